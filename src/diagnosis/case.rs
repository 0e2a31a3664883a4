//! Everything that stays the same while sets of faults are tried on a record.

use nalgebra::{DMatrix, DVector};

use super::noise::Weights;
use super::prior::Gaussian;
use super::problem::{Estimated, RecordProblem};
use crate::fit::Loss;
use crate::model::{Drive, Model};
use crate::record::Record;
use crate::rig::FaultSet;
use crate::rig::Rig;

/// Uncertain parameters are searched this many standard deviations to both sides.
pub(crate) const REACH: f64 = 6.0;
/// Least share of its stated value that something positive is estimated as.
const LEAST: f64 = 0.1;
/// How far a value that has not changed may be from what it was before, as a share of its uncertainty: as good as nothing,
/// but more than rounding.
const APART: f64 = 1e-3;
/// A misfit of more standard deviations pulls with constant force only (Huber); one sample in 400 is beyond by chance.
pub const ROBUST: Loss = Loss::Huber { k: 3.0 };

/// A record, a rig, and all that may be estimated: the faults first, in their order, then what else is uncertain.
pub struct Case<'a> {
    /// All estimated parameters, nothing known before.
    pub full: RecordProblem<'a>,
    pub record: &'a Record,
    /// Of each estimated parameter: healthy value, or what is expected before the record, SI.
    pub mean: Vec<f64>,
    /// Estimated parameters with a standard uncertainty before the record; a fault's is that of its healthy value.
    pub known: Vec<usize>,
    /// Of `known`, SI.
    covariance: DMatrix<f64>,
}

impl<'a> Case<'a> {
    pub fn new(
        model: &'a Model,
        record: &'a Record,
        drive: &'a Drive,
        measured: Vec<&'a [f64]>,
        weights: Weights,
    ) -> Self {
        let rig = &model.rig;
        let estimated = estimated(rig);
        let mut mean: Vec<f64> = rig.faults.iter().map(|fault| fault.healthy).collect();
        mean.extend(estimated[mean.len()..].iter().map(|uncertain| rig.parameters[uncertain.parameter].value));
        let uncertain = |index: &usize| {
            let parameter = &rig.parameters[estimated[*index].parameter];
            parameter.sigma > 0.0 && !parameter.anew
        };
        let known: Vec<usize> = (0..estimated.len()).filter(uncertain).collect();
        let mut covariance = rig.covariance(&known.iter().map(|&index| estimated[index].parameter).collect::<Vec<_>>());
        for (place, &index) in known.iter().enumerate() {
            if rig.before(estimated[index].parameter).is_some() {
                covariance[(place, place)] *= 1.0 + APART * APART;
            }
        }
        let mut full = RecordProblem::new(model, drive, &record.time, measured, weights, estimated, Gaussian::none());
        full.base = rig.healthy();
        Self { full, record, mean, known, covariance }
    }

    pub fn rig(&self) -> &'a Rig {
        &self.full.model.rig
    }

    /// Number of faults.
    pub fn faults(&self) -> usize {
        self.rig().faults.len()
    }

    /// Whether a fault is an offset or a gain of a sensor: readings follow those exactly in a straight line.
    pub fn is_of_sensor(&self, fault: usize) -> bool {
        self.rig().is_of_sensor(self.rig().faults[fault].parameter)
    }

    /// Number of estimated parameters.
    pub fn count(&self) -> usize {
        self.mean.len()
    }

    /// Whether parameter `index` is a fault outside `set` whose healthy value is exact.
    pub fn is_held(&self, set: FaultSet, index: usize) -> bool {
        index < self.faults() && !set.contains(index) && !self.known.contains(&index)
    }

    /// What is known while the faults of `set` are present: of a present fault, nothing.
    pub fn prior(&self, set: FaultSet) -> Gaussian {
        let places: Vec<usize> = (0..self.known.len())
            .filter(|&place| self.known[place] >= self.faults() || !set.contains(self.known[place]))
            .collect();
        let members: Vec<usize> = places.iter().map(|&place| self.known[place]).collect();
        let mean = members.iter().map(|&member| self.mean[member]).collect();
        let covariance = DMatrix::from_fn(places.len(), places.len(), |a, b| self.covariance[(places[a], places[b])]);
        Gaussian::new(members, mean, &covariance)
    }

    /// What is known while no fault is present.
    pub fn healthy_prior(&self) -> Gaussian {
        self.prior(FaultSet::EMPTY)
    }

    /// `2 F` of record and prior while the faults of `set` are present, from the misfits of the record at `theta`.
    pub fn cost(&self, set: FaultSet, misfit: &[f64], theta: &[f64]) -> f64 {
        2.0 * ROBUST.cost(misfit) + self.prior(set).misfit(theta).norm_squared()
    }

    /// Width of the range in which a fault is searched, SI.
    pub fn range(&self, fault: usize) -> f64 {
        let (low, high) = self.rig().faults[fault].bounds;
        high - low
    }

    /// Values of a fault at shares of the way from its healthy value to each of its bounds, SI.
    pub fn levels<'s>(&self, fault: usize, shares: &'s [f64]) -> impl Iterator<Item = f64> + use<'s> {
        let (healthy, (low, high)) = (self.mean[fault], self.rig().faults[fault].bounds);
        let ends = [low, high].into_iter().filter(move |&end| end != healthy);
        ends.flat_map(move |end| shares.iter().map(move |share| healthy + share * (end - healthy)))
    }

    /// All estimated parameters, SI, with the faults outside `set` at their healthy values.
    pub fn without_others(&self, theta: &[f64], set: FaultSet) -> Vec<f64> {
        let mut theta = theta.to_vec();
        for other in (0..self.faults()).filter(|&other| !set.contains(other)) {
            theta[other] = self.mean[other];
        }
        theta
    }

    /// All estimated parameters, SI, with what is uncertain as it is expected; faults and what effects have stay.
    pub fn as_expected(&self, theta: &[f64]) -> Vec<f64> {
        let stays =
            |index: usize| index < self.faults() || self.rig().is_of_effect(self.full.estimated[index].parameter);
        theta.iter().enumerate().map(|(index, &value)| if stays(index) { value } else { self.mean[index] }).collect()
    }

    /// Parameters that are free while the faults of `set` are present.
    pub fn free(&self, set: FaultSet) -> Vec<usize> {
        (0..self.count()).filter(|&index| !self.is_held(set, index)).collect()
    }

    /// What the prior adds to the information on all estimated parameters while the faults of `set` are present, per `scale`.
    pub fn precision(&self, set: FaultSet, scale: &[f64]) -> DMatrix<f64> {
        let prior = self.prior(set);
        let known = prior.precision();
        let mut precision = DMatrix::zeros(self.count(), self.count());
        for (a, &i) in prior.members.iter().enumerate() {
            for (b, &j) in prior.members.iter().enumerate() {
                precision[(i, j)] = known[(a, b)] * scale[i] * scale[j];
            }
        }
        precision
    }

    /// How far values of all estimated parameters are from what is expected of them, in scales.
    pub fn away(&self, theta: &[f64], scale: &[f64]) -> DVector<f64> {
        DVector::from_fn(self.count(), |index, _| (theta[index] - self.mean[index]) / scale[index])
    }
}

/// What an explanation costs, `cost` being `2 F` of its fit, with each fault priced as a parameter is (Schwarz 1978): fewer
/// are better where both explain so many samples alike.
pub fn priced(cost: f64, set: FaultSet, samples: f64) -> f64 {
    cost + set.len() as f64 * samples.ln()
}

/// The faults of a rig, then everything uncertain that is no fault, what sensors show at zero included. What is uncertain
/// anew in each switching is in the weights; see [`super::noise`].
pub(super) fn estimated(rig: &Rig) -> Vec<Estimated> {
    let faults = rig.faults.iter().map(|fault| Estimated {
        parameter: fault.parameter,
        bounds: fault.bounds,
        scale: (fault.bounds.1 - fault.bounds.0) / 4.0,
    });
    let stated = rig.parameters.iter().enumerate().filter(|(_, parameter)| parameter.sigma > 0.0 && !parameter.anew);
    let uncertain = stated.filter(|(index, _)| !rig.is_fault(*index)).map(|(index, known)| {
        let (low, high) = (known.value - REACH * known.sigma, known.value + REACH * known.sigma);
        // What is positive by nature stays of the size stated: a laminar start of nothing cannot be solved.
        let least = if known.bounds.0 > 0.0 { known.bounds.0.max(known.value * LEAST) } else { known.bounds.0 };
        let bounds = (least.max(low), known.bounds.1.min(high));
        Estimated { parameter: index, bounds, scale: known.sigma }
    });
    faults.chain(uncertain).collect()
}
