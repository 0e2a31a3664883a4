//! Everything that stays the same while sets of faults are tried on a record.

use nalgebra::DMatrix;

use super::noise::Weights;
use super::problem::{Estimated, RecordProblem};
use crate::estimation::local_model::Information;
use crate::estimation::profile::QUANTILE;
use crate::estimation::{
    Fit, FitError, Gaussian, Held, Linearised, LocalModel, Loss, Options, Problem, SchurComplement, fit, fit_along,
};
use crate::model::{InputSignals, Model, SimulationError};
use crate::record::Record;
use crate::rig::FaultSet;
use crate::rig::Rig;
use crate::settings::DiagnosisSettings;

/// Standard deviations from the rig file beyond which a value is asked about: of 40 that are right, one is as far off in a quarter of
/// a per cent of records.
pub(crate) const FAR_OFF: f64 = 4.0;

/// The loss of a sample.
pub(crate) fn robust(rig: &Rig) -> Loss {
    Loss::Huber { k: rig.settings().diagnosis.huber_width }
}

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
        drive: &'a InputSignals,
        measured: Vec<&'a [f64]>,
        weights: Weights,
    ) -> Self {
        let rig = &model.rig;
        let estimated = estimated(rig);
        let mut mean: Vec<f64> = rig.faults.iter().map(|fault| fault.healthy).collect();
        mean.extend(estimated[mean.len()..].iter().map(|uncertain| rig.parameters[uncertain.parameter].value));
        let uncertain = |index: &usize| rig.parameters[estimated[*index].parameter].is_uncertain();
        let known: Vec<usize> = (0..estimated.len()).filter(uncertain).collect();
        let mut covariance = rig.covariance(&known.iter().map(|&index| estimated[index].parameter).collect::<Vec<_>>());
        for (place, &index) in known.iter().enumerate() {
            if rig.before(estimated[index].parameter).is_some() {
                let unchanged = rig.settings().diagnosis.unchanged_share;
                covariance[(place, place)] *= 1.0 + unchanged * unchanged;
            }
        }
        let mut full = RecordProblem::new(model, drive, &record.time, measured, weights, estimated);
        full.base = rig.healthy();
        Self { full, record, mean, known, covariance }
    }

    pub fn rig(&self) -> &'a Rig {
        &self.full.model.rig
    }

    /// The thresholds of diagnosis.
    pub(crate) fn settings(&self) -> &'a DiagnosisSettings {
        &self.rig().settings().diagnosis
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

    /// The healthy value of a fault that is nearest to a value, SI: as far as it is uncertain, what a record has shown of it is no change.
    pub fn as_healthy(&self, fault: usize, value: f64) -> f64 {
        let parameter = &self.rig().parameters[self.rig().faults[fault].parameter];
        let range = if parameter.is_uncertain() { QUANTILE * parameter.sigma } else { 0.0 };
        let (low, high) = self.rig().faults[fault].bounds;
        value.clamp(self.mean[fault] - range, self.mean[fault] + range).clamp(low, high)
    }

    /// Whether parameter `index` is a fault outside `set` whose healthy value is exact.
    pub fn is_held(&self, set: FaultSet, index: usize) -> bool {
        index < self.faults() && !set.contains(index) && !self.known.contains(&index)
    }

    /// Whether what is uncertain beside the faults has to be further off than chance puts one value of a right model.
    pub fn is_strained(&self, theta: &[f64]) -> bool {
        let beside = self.known.iter().enumerate().filter(|(_, index)| **index >= self.faults());
        let mut squares =
            beside.map(|(place, &index)| (theta[index] - self.mean[index]).powi(2) / self.covariance[(place, place)]);
        squares.any(|square| square > FAR_OFF * FAR_OFF)
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
        2.0 * robust(self.rig()).cost(misfit) + self.prior(set).misfit(theta).norm_squared()
    }

    /// Width of the range in which a fault is searched, SI.
    pub fn range(&self, fault: usize) -> f64 {
        let (low, high) = self.rig().faults[fault].bounds;
        high - low
    }

    /// Values of a fault at shares of the way from its healthy value to each of its bounds, SI.
    pub fn levels<'s>(&self, fault: usize, shares: &'s [f64]) -> impl Iterator<Item = f64> + use<'s> {
        let healthy = self.mean[fault];
        self.ends(fault).flat_map(move |end| shares.iter().map(move |share| level(healthy, end, *share)))
    }

    /// The bounds of a fault, SI, that are not its healthy value.
    pub fn ends(&self, fault: usize) -> impl Iterator<Item = f64> + use<> {
        let (healthy, (low, high)) = (self.mean[fault], self.rig().faults[fault].bounds);
        [low, high].into_iter().filter(move |&end| end != healthy)
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

    /// The fit of one set of faults: the others held at their healthy values, with what is known while it is present.
    pub fn problem(&self, set: FaultSet) -> SetProblem<'_, 'a> {
        let mut bounds = self.full.bounds().to_vec();
        for index in (0..self.faults()).filter(|&index| self.is_held(set, index)) {
            bounds[index] = (self.mean[index], self.mean[index]);
        }
        SetProblem { case: self, bounds, prior: self.prior(set) }
    }

    /// The same with further parameters held where they are, SI.
    pub fn problem_beside(
        &self,
        set: FaultSet,
        held: impl Iterator<Item = usize>,
        theta: &[f64],
    ) -> SetProblem<'_, 'a> {
        let mut problem = self.problem(set);
        held.for_each(|index| problem.bounds[index] = (theta[index], theta[index]));
        problem
    }

    /// The local model at values of all estimated parameters, SI.
    ///
    /// # Errors
    /// The model cannot be solved there, or what it gives is not finite.
    pub fn local_model(&self, theta: &[f64]) -> Result<LocalModel, FitError> {
        LocalModel::at(&self.full, theta, robust(self.rig()))
    }

    /// Fits the faults of `set` along a local model from nearby, in so many steps.
    ///
    /// # Errors
    /// The model cannot be solved at the start.
    pub fn fit(&self, near: &LocalModel, set: FaultSet, start: &[f64], steps: Options) -> Result<Fit, FitError> {
        fit_along(&self.problem(set), near, start, steps)
    }

    /// The fits of a set, each in so many steps along a local model of where the one before ended; ends where the model cannot be solved.
    pub fn relinearised<'s>(
        &'s self,
        set: FaultSet,
        start: &[f64],
        steps: Options,
    ) -> impl Iterator<Item = (LocalModel, Fit)> + use<'s, 'a> {
        let mut theta = start.to_vec();
        std::iter::from_fn(move || {
            let near = self.local_model(&theta).ok()?;
            let fit = self.fit(&near, set, &theta, steps).ok()?;
            theta.clone_from(&fit.theta);
            Some((near, fit))
        })
    }

    /// The first of so many of them that promises less than a decrease, or the last that could be solved; `None` where none could.
    pub fn settled(
        &self,
        set: FaultSet,
        start: &[f64],
        steps: Options,
        (most, decrease): (usize, f64),
    ) -> Option<(LocalModel, Fit)> {
        let mut last = None;
        for (near, fit) in self.relinearised(set, start, steps).take(most) {
            let is_settled = fit.promised < decrease;
            last = Some((near, fit));
            if is_settled {
                break;
            }
        }
        last
    }

    /// The lowest point of a set, with a local model of each iterate.
    ///
    /// # Errors
    /// The model cannot be solved at the start.
    pub fn descended(&self, set: FaultSet, start: &[f64]) -> Result<Fit, FitError> {
        let steps = Options::steps(Options::default().max_iterations, self.settings().isolation_decrease);
        fit(&self.problem(set), start, robust(self.rig()), steps)
    }

    /// The fit of a set along a local model with one of the parameters held at a value, SI.
    ///
    /// # Errors
    /// The model cannot be solved at the start.
    pub fn fit_held(
        &self,
        near: &LocalModel,
        set: FaultSet,
        held: Holding,
        start: &[f64],
        steps: Options,
    ) -> Result<Fit, FitError> {
        fit_along(&Held::new(&self.problem(set), held.parameter, held.value), near, start, steps)
    }

    /// What record and prior say of all that is estimated while the faults of `set` are present.
    ///
    /// # Errors
    /// Bounds or scales that do not fit together.
    pub fn information(&self, near: &LocalModel, set: FaultSet) -> Result<Information, FitError> {
        near.information(&self.problem(set))
    }

    /// The form over the deviations of all faults from healthy, with everything uncertain left to follow.
    pub fn schur_complement(&self, near: &LocalModel) -> SchurComplement {
        let bounds: Vec<(f64, f64)> = self.rig().faults.iter().map(|fault| fault.bounds).collect();
        SchurComplement::new(near, &self.healthy_prior(), &self.mean, &bounds)
    }
}

/// The value of a fault at a share of the way from its healthy value to one of its bounds.
pub fn level(healthy: f64, end: f64, share: f64) -> f64 {
    healthy + share * (end - healthy)
}

/// A parameter held at a value.
#[derive(Debug, Clone, Copy)]
pub struct Holding {
    /// Index among the estimated ones.
    pub parameter: usize,
    /// SI.
    pub value: f64,
}

/// The fit of one set of faults to a record.
pub struct SetProblem<'c, 'a> {
    case: &'c Case<'a>,
    bounds: Vec<(f64, f64)>,
    prior: Gaussian,
}

impl Problem for SetProblem<'_, '_> {
    type Error = SimulationError;

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        self.case.full.misfit(theta)
    }

    fn linearise(&self, theta: &[f64]) -> Result<Linearised, SimulationError> {
        self.case.full.linearise(theta)
    }

    fn scale(&self) -> Vec<f64> {
        self.case.full.scale()
    }

    fn prior(&self) -> Option<&Gaussian> {
        Some(&self.prior)
    }

    fn name(&self, parameter: usize) -> String {
        self.case.full.name(parameter)
    }
}

/// The faults of a rig, then everything uncertain that is no fault, what sensors show at zero included. What is uncertain
/// anew in each switching is in the weights; see [`super::noise`].
pub(super) fn estimated(rig: &Rig) -> Vec<Estimated> {
    let faults = rig.faults.iter().map(|fault| Estimated {
        parameter: fault.parameter,
        bounds: fault.bounds,
        scale: (fault.bounds.1 - fault.bounds.0) / 4.0,
    });
    let stated = rig.parameters.iter().enumerate().filter(|(_, parameter)| parameter.is_uncertain());
    let uncertain = stated.filter(|(index, _)| !rig.is_fault(*index)).map(|(index, known)| {
        let settings = &rig.settings().diagnosis;
        let reach = settings.search_reach * known.sigma;
        let (low, high) = (known.value - reach, known.value + reach);
        // What is positive by nature stays of the size stated: a laminar start of nothing cannot be solved.
        let least =
            if known.bounds.0 > 0.0 { known.bounds.0.max(known.value * settings.least_share) } else { known.bounds.0 };
        let bounds = (least.max(low), known.bounds.1.min(high));
        Estimated { parameter: index, bounds, scale: known.sigma }
    });
    faults.chain(uncertain).collect()
}
