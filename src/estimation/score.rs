//! The score test: what a change that the model does not have would explain, everything estimated following it.
//!
//! Source: Rao, Proceedings of the Cambridge Philosophical Society 44 (1948).

use nalgebra::DVector;

use super::local_model::{Information, LocalModel};

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
}

impl Score {
    /// Fall of the cost at a factor on the change, everything estimated following.
    pub fn fall_at(&self, factor: f64) -> f64 {
        self.information * factor * (2.0 * self.factor - factor)
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

    /// The score of a `change` of the misfits, one per sample.
    pub fn of(&self, change: &[f64]) -> Score {
        let weighted = DVector::from_iterator(change.len(), change.iter().zip(&self.weights).map(|(s, w)| s * w));
        let across = self.information.of_free(&self.model.jacobian().tr_mul(&weighted));
        let whitened = self.information.whitened(&across);
        let follow = self.information.back(&whitened);
        let total: f64 = change.iter().zip(weighted.iter()).map(|(s, weighted)| s * weighted).sum();
        let information = (total - whitened.norm_squared()).max(0.0);
        // What follows takes its own gradient along, that of the prior too.
        let pull = change.iter().zip(&self.pull).map(|(s, pull)| s * pull).sum::<f64>() - follow.dot(&self.gradient);
        let taken = |a: usize| (follow[a] * across[a]).abs();
        let most = (0..across.len()).max_by(|&a, &b| taken(a).total_cmp(&taken(b)));
        Score {
            factor: if information > 0.0 { -pull / information } else { 0.0 },
            information,
            own: if total > 0.0 { (information / total).sqrt() } else { 0.0 },
            absorbed_by: most.map(|a| self.information.free()[a]),
        }
    }
}
