//! The score test: what a change that the model does not have would explain, everything estimated following it.
//!
//! Source: Rao, Proceedings of the Cambridge Philosophical Society 44 (1948).

use nalgebra::{DMatrix, DVector};

use super::local_model::{Information, LocalModel};
use crate::numeric::dot;

/// What the misfits say of a further change that the model does not have.
#[derive(Debug, Clone)]
pub struct Score {
    /// Factor on the change at which the cost would be least.
    pub factor: f64,
    /// Inverse variance of that factor: the squared length of what of the change nothing estimated can take over.
    pub information: f64,
    /// Share of the change, root of squares, that nothing estimated can take over.
    pub own: f64,
    /// The estimated parameter that takes over most of it.
    pub absorbed_by: Option<usize>,
    /// Half the derivative of the cost by the factor, everything estimated following.
    pull: f64,
    /// By how much each free parameter, per scale, falls for a factor of 1, everything estimated following.
    follow: DVector<f64>,
    /// The free parameters.
    free: Vec<usize>,
}

/// A parameter that might stand at another value if the model had a change: how far it is off now, and how surely.
#[derive(Debug, Clone, Copy)]
pub struct EstimatedAt {
    /// Its index among all parameters.
    pub parameter: usize,
    /// Estimate less the other value, per scale.
    pub off: f64,
    /// Variance of the estimate, per scale, the change not in the model.
    pub variance: f64,
    /// Variance of the other value, per scale; 0 where it is exact.
    pub other_variance: f64,
}

impl EstimatedAt {
    /// Rise of the cost with the parameter at the other value, the change not in the model.
    pub fn rise(&self) -> f64 {
        self.off * self.off / (self.variance + self.other_variance)
    }
}

impl Score {
    /// Fall of the cost at a factor on the change, everything estimated following.
    pub fn fall_at(&self, factor: f64) -> f64 {
        self.information * factor * (2.0 * self.factor - factor)
    }

    /// The free parameters, and by how much each falls, per scale, for a factor of 1, everything estimated following.
    pub fn following(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.free.iter().copied().zip(self.follow.iter().copied())
    }

    /// Rise of the cost where the change is in the model and a free parameter stands at another value, all else following; and
    /// the factor on the change at which it is least. Of two quantities that are normal together the one conditioned on the other,
    /// written without a division by the information of the change: one that does what the parameter does has none beside it.
    pub fn in_place_of(&self, estimated: EstimatedAt) -> Option<(f64, f64)> {
        let place = self.free.iter().position(|&free| free == estimated.parameter)?;
        let (follow, off) = (self.follow[place], estimated.off);
        let variance = estimated.variance + estimated.other_variance;
        let own = variance * self.information + follow * follow;
        let rise = off * off * self.information + 2.0 * off * follow * self.pull - self.pull * self.pull * variance;
        (own > 0.0).then(|| (rise / own, (follow * off - self.pull * variance) / own))
    }
}

/// A point at which further changes of the misfits are scored.
#[derive(Debug)]
pub struct ScoreTest<'a> {
    model: &'a LocalModel,
    information: Information,
    /// Half the derivative of the cost by the free parameters: next to nothing at the optimum.
    gradient: DVector<f64>,
    weights: Vec<f64>,
    /// Misfits as the loss weighs them.
    pull: Vec<f64>,
}

impl<'a> ScoreTest<'a> {
    pub(super) fn new(model: &'a LocalModel, information: Information, gradient: DVector<f64>, misfit: &[f64]) -> Self {
        let weights: Vec<f64> = misfit.iter().map(|&r| model.loss.weight(r)).collect();
        let pull = misfit.iter().zip(&weights).map(|(r, weight)| r * weight).collect();
        Self { model, information, gradient, weights, pull }
    }

    fn weighted(&self, change: &[f64]) -> Vec<f64> {
        change.iter().zip(&self.weights).map(|(s, w)| s * w).collect()
    }

    /// Half the derivative of the cost by the factor on a change that takes along what follows it, which has a gradient of its own,
    /// that of the prior too.
    fn pull(&self, change: &[f64], follow: &DVector<f64>) -> f64 {
        dot(change, &self.pull) - follow.dot(&self.gradient)
    }

    /// The most that the cost could fall with any sum of some `changes` of the misfits, each with a factor of its own, everything
    /// estimated following.
    pub fn most(&self, changes: &[Vec<f64>]) -> f64 {
        let weighted: Vec<Vec<f64>> = changes.iter().map(|change| self.weighted(change)).collect();
        let across = |weighted: &[f64]| self.information.of_free(&self.model.transposed_times(weighted));
        let whitened: Vec<DVector<f64>> =
            weighted.iter().map(|weighted| self.information.whitened(&across(weighted))).collect();
        let information = DMatrix::from_fn(changes.len(), changes.len(), |i, j| {
            dot(&changes[i], &weighted[j]) - whitened[i].dot(&whitened[j])
        });
        let pull = DVector::from_fn(changes.len(), |i, _| self.pull(&changes[i], &self.information.back(&whitened[i])));
        let spectrum = information.symmetric_eigen();
        // A direction that what is estimated takes over but for rounding explains nothing of its own.
        let least = f64::EPSILON.sqrt() * spectrum.eigenvalues.amax();
        let own = spectrum.eigenvectors.tr_mul(&pull);
        own.iter()
            .zip(spectrum.eigenvalues.iter())
            .filter(|&(_, &value)| value > least)
            .map(|(own, value)| own * own / value)
            .sum()
    }

    /// The score of a `change` of the misfits, one per sample.
    pub fn of(&self, change: &[f64]) -> Score {
        let weighted = self.weighted(change);
        let across = self.information.of_free(&self.model.transposed_times(&weighted));
        let whitened = self.information.whitened(&across);
        let follow = self.information.back(&whitened);
        let total = dot(change, &weighted);
        let information = (total - whitened.norm_squared()).max(0.0);
        let pull = self.pull(change, &follow);
        let taken = |a: usize| (follow[a] * across[a]).abs();
        let most = (0..across.len()).max_by(|&a, &b| taken(a).total_cmp(&taken(b)));
        Score {
            factor: if information > 0.0 { -pull / information } else { 0.0 },
            information,
            own: if total > 0.0 { (information / total).sqrt() } else { 0.0 },
            absorbed_by: most.map(|a| self.information.free()[a]),
            pull,
            free: self.information.free().to_vec(),
            follow,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A score of a change that moves the misfits exactly as a parameter of variance 1 does, with a share of its own.
    fn score(information: f64) -> Score {
        let follow = DVector::from_element(1, 1.0);
        Score { factor: 0.0, information, own: 0.0, absorbed_by: None, pull: 0.0, follow, free: vec![0] }
    }

    #[test]
    fn a_change_that_does_the_same_takes_the_place_of_a_parameter_for_nothing() {
        let estimated = EstimatedAt { parameter: 0, off: 30.0, variance: 1.0, other_variance: 0.0 };
        assert_eq!(estimated.rise(), 900.0);
        assert_eq!(score(0.0).in_place_of(estimated), Some((0.0, 30.0)));
        // Half of its length is its own: with a change of the misfits by s = (1, 1) and J = (1, 0) cost is (p + e)^2 + e^2, p = -30.
        let (rise, factor) = score(1.0).in_place_of(estimated).unwrap();
        assert_eq!((rise, factor), (450.0, 15.0));
        assert!(score(1.0).in_place_of(EstimatedAt { parameter: 1, ..estimated }).is_none());
    }
}
