//! A model with everything uncertain fitted to a record, faults included, and its free run on another.

use std::collections::BTreeMap;

use super::lack_of_fit::{has_lack_of_fit, is_alike, with_lack_of_fit, without_lack_of_fit};
use super::run::{Run, run_of};
use crate::complaint::Complaint;
use crate::diagnosis::case::robust;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::events::LeftOpen;
use crate::diagnosis::noise::Weights;
use crate::diagnosis::problem::away;
use crate::diagnosis::{events, preliminary, weighed};
use crate::estimation::Problem;
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::{FaultSet, Parameter, Rig};

/// Share of the variance that a rig file states from which on a record has told less than the file does.
const LEFT_OPEN: f64 = 0.5;

/// What a record says through one model.
#[derive(Debug, Clone)]
pub struct FittedModel {
    pub rig: Rig,
    /// Every parameter of the rig as fitted, SI.
    pub values: Vec<f64>,
    /// Standard errors of those that were fitted, SI, by index of the rig's parameters.
    pub sigmas: BTreeMap<usize, f64>,
    /// Faults that are present.
    pub set: FaultSet,
    /// Parameters of effects that ended on a bound of their search, by index of the rig's parameters.
    pub at_bound: Vec<usize>,
    /// `2 F` of record and prior, under the weights that it was fitted with.
    pub cost: f64,
    pub fit: Run,
}

impl FittedModel {
    /// From an estimate.
    ///
    /// # Errors
    /// The model cannot be solved at it.
    pub fn of(estimate: &Estimate<'_>) -> Result<Self, Complaint> {
        let full = &estimate.case.full;
        Self::with_run(estimate, |values| run_with(full.model, estimate.case.record, full.drive, values))
    }

    /// The same, judged under the weights of the estimate.
    ///
    /// # Errors
    /// The model cannot be solved at it.
    pub(super) fn under(estimate: &Estimate<'_>) -> Result<Self, Complaint> {
        let (full, record) = (&estimate.case.full, estimate.case.record);
        Self::with_run(estimate, |values| {
            let outputs = full.outputs(values, full.drive);
            let outputs = outputs.map_err(|error| weighed::unsolvable(full.model, record, error))?;
            run_of(&full.model.rig, record, outputs, full.weights.clone())
        })
    }

    /// From an estimate and the run with its values of all parameters, SI.
    fn with_run(
        estimate: &Estimate<'_>,
        run: impl FnOnce(&[f64]) -> Result<Run, Complaint>,
    ) -> Result<Self, Complaint> {
        let (case, isolation) = (&estimate.case, &estimate.isolation);
        let theta = &isolation.best.theta;
        let values = case.full.parameters(theta);
        let fit = run(&values)?;
        let inverse = case.information(&isolation.local, isolation.set()).map(|known| known.covariance()).ok();
        let (mut sigmas, mut at_bound) = (BTreeMap::new(), Vec::new());
        let rig = case.rig();
        for (index, estimated) in case.full.estimated.iter().enumerate() {
            let variance = inverse.as_ref().map_or(0.0, |inverse| inverse[(index, index)]);
            if variance > 0.0 {
                sigmas.insert(estimated.parameter, variance.sqrt() * isolation.local.scale[index]);
            }
            let (low, high) = case.full.bounds()[index];
            if rig.is_of_effect(estimated.parameter) && (theta[index] <= low || theta[index] >= high) {
                at_bound.push(estimated.parameter);
            }
        }
        let cost = isolation.best.cost;
        Ok(Self { rig: rig.clone(), values, sigmas, set: isolation.set(), at_bound, cost, fit })
    }

    /// A rig with values of all of its parameters (SI), the faults that are present, and what they cost, under its own weights
    /// or given ones.
    ///
    /// # Errors
    /// Columns that are missing, or a model that cannot be solved there.
    pub fn at(
        rig: &Rig,
        record: &Record,
        values: &[f64],
        (set, cost): (FaultSet, f64),
        weights: Option<&Weights>,
    ) -> Result<Self, Complaint> {
        let fit = run_under(rig, record, values, weights)?;
        let (rig, values) = (rig.clone(), values.to_vec());
        Ok(Self { rig, values, sigmas: BTreeMap::new(), set, at_bound: Vec::new(), cost, fit })
    }

    /// Fits a rig to a record from values of all of its parameters (SI) and the faults that are present, in so many rounds of
    /// isolation; weighed by the lack of fit that it leaves itself.
    ///
    /// # Errors
    /// Columns that are missing, or a model that cannot be solved there.
    pub fn fitted(rig: &Rig, record: &Record, values: &[f64], set: FaultSet, rounds: u64) -> Result<Self, Complaint> {
        let mut fitted = Self::at(rig, record, values, (set, f64::INFINITY), None)?;
        for _ in 0..rig.settings().learn.weighings {
            let model = Model::new(with_lack_of_fit(&fitted.rig, &fitted.fit));
            let drive = InputSignals::from_record(&model.rig, record)?;
            let theta = estimate::picked(&model.rig, &fitted.values);
            fitted = Self::of(&estimate::isolated(&model, record, &drive, (&theta, fitted.set), rounds)?)?;
            if is_alike(&fitted.rig, &with_lack_of_fit(&fitted.rig, &fitted.fit)) {
                break;
            }
        }
        Ok(fitted)
    }

    /// What the model says of another record with nothing fitted to it. Where that misses, what the fitted record has left open is not
    /// held against it: a relief valve that did not open there, an end that was not reached.
    ///
    /// # Errors
    /// Columns that are missing, or a model that cannot be solved on it.
    pub fn check(&self, record: &Record) -> Result<Run, Complaint> {
        let values = values_on(&self.rig, &self.values, record)?;
        let run = run_under(&self.rig, record, &values, None)?;
        let open = self.left_open();
        if run.is_adequate || open.is_empty() {
            return Ok(run);
        }
        let model = Model::new(without_lack_of_fit(&self.rig));
        let drive = InputSignals::from_record(&model.rig, record)?;
        let solved = events::weights_leaving_open(&model, record, (&drive, &values), &open);
        let LeftOpen { weights, outputs, most } = solved.map_err(|error| weighed::unsolvable(&model, record, error))?;
        let mut shows: Vec<(usize, f64)> =
            open.iter().map(|one| one.0).zip(most).filter(|(_, most)| *most > 1.0).collect();
        shows.sort_by(|a, b| b.1.total_cmp(&a.1));
        let left_open = shows.into_iter().map(|(parameter, _)| parameter).collect();
        Ok(Run { left_open, ..run_of(&model.rig, record, outputs, weights)? })
    }

    /// Uncertain parameters of which the rig file says more than the record that was fitted, with what is known of them, SI.
    fn left_open(&self) -> Vec<(usize, f64)> {
        let is_present = |index: usize| self.set.iter().any(|fault| self.rig.faults[fault].parameter == index);
        let known = self.sigmas.iter().filter(|&(&index, &sigma)| {
            let parameter = &self.rig.parameters[index];
            let stated = parameter.sigma;
            stated > 0.0
                && !self.rig.is_of_effect(index)
                && !is_present(index)
                // What is fitted to the other record by itself is not open there.
                && !parameter.role.is_of_record()
                && sigma * sigma > LEFT_OPEN * stated * stated
        });
        known.map(|(&index, &sigma)| (index, sigma)).collect()
    }

    /// The same under given weights.
    ///
    /// # Errors
    /// As [`FittedModel::check`].
    pub fn check_under(&self, record: &Record, weights: Option<&Weights>) -> Result<Run, Complaint> {
        run_under(&self.rig, record, &values_on(&self.rig, &self.values, record)?, weights)
    }

    /// Fall of the information criterion against a model without its effects, on the record that both are fitted to, under the
    /// weights of `judge`. What an effect moves that was known before counts as the data sheet says: a calibration is of records that lack
    /// the effect, whatever it is.
    ///
    /// # Errors
    /// Columns that are missing.
    pub fn gain_over(&self, base: &Self, record: &Record, judge: &Judge) -> Result<f64, Complaint> {
        let parameters = |one: &Self| effect_parameters(&one.rig) as f64 + one.set.len() as f64;
        let fall = judge.fall(record, (base, &base.fit), (self, &self.fit))?;
        let known = |(index, value): (usize, &f64)| {
            let before = &base.rig.parameters[index];
            let waived = before.sigma > 0.0 && !base.rig.is_of_effect(index) && self.rig.is_of_effect(index);
            if waived { ((value - before.value) / before.sigma.max(before.spread)).powi(2) } else { 0.0 }
        };
        let known = |values: &[f64]| values.iter().take(base.values.len()).enumerate().map(known).sum::<f64>();
        let waived = known(&self.values) - known(&base.values);
        let samples = base.fit.weights.all_samples() as f64;
        Ok(fall - waived - (parameters(self) - parameters(base)) * samples.ln())
    }
}

/// Every parameter of a rig on another record than that which it was fitted to with these `values`, SI: the same, but for those that are
/// another in each record, which are fitted to this one by themselves.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved on it.
pub(super) fn values_on(rig: &Rig, values: &[f64], record: &Record) -> Result<Vec<f64>, Complaint> {
    let is_own = |parameter: &Parameter| parameter.role.is_of_record() && parameter.is_uncertain();
    let mut values = values.to_vec();
    if !rig.parameters.iter().any(is_own) {
        return Ok(values);
    }
    let mut alone = without_lack_of_fit(rig);
    alone.faults.clear();
    for (parameter, &fitted) in alone.parameters.iter_mut().zip(&values) {
        if is_own(parameter) {
            continue;
        }
        parameter.value = fitted;
        // How far each switching may be from the mean is no knowledge of this record.
        if !parameter.per_event {
            parameter.sigma = 0.0;
        }
    }
    let model = Model::new(alone);
    let drive = InputSignals::from_record(&model.rig, record)?;
    let start = estimate::picked(&model.rig, &model.rig.nominal());
    let most = model.rig.settings().learn.linearisations;
    let fit = preliminary::quick(&model, record, &drive, (&start, FaultSet::EMPTY), most, None)?;
    for (parameter, value) in estimate::estimated_parameters(&model.rig).into_iter().zip(fit.theta) {
        values[parameter] = value;
    }
    Ok(values)
}

/// Number of parameters of effects that are fitted.
pub(super) fn effect_parameters(rig: &Rig) -> usize {
    let fitted = |&&parameter: &&usize| rig.parameters[parameter].sigma > 0.0;
    rig.effects.iter().flat_map(|effect| &effect.parameters).filter(fitted).count()
}

/// What models of one record are compared by.
pub struct Judge {
    weights: Weights,
    /// Mean square that the best leaves under them, at least 1.
    left: f64,
}

impl Judge {
    /// Weights with the lack of fit that the best model leaves itself in its run over the record.
    ///
    /// # Errors
    /// Columns that are missing, or a model that cannot be solved.
    pub fn of(best: &FittedModel, run: &Run, record: &Record) -> Result<Self, Complaint> {
        let rig = with_lack_of_fit(&best.rig, run);
        let weights = if has_lack_of_fit(&rig) {
            let model = Model::new(rig);
            let drive = InputSignals::from_record(&model.rig, record)?;
            let solved = events::weights_of(&model, record, &drive, &best.values);
            solved.map_err(|error| weighed::unsolvable(&model, record, error))?.0
        } else {
            run.weights.clone()
        };
        let samples = weights.all_samples().max(1) as f64;
        let mut judge = Self { weights, left: 1.0 };
        judge.left = (judge.cost(record, best, run)? / samples).max(1.0);
        Ok(judge)
    }

    /// Fall of `2 F` of the record alone from one model to another, in what the best leaves.
    ///
    /// # Errors
    /// Columns that are missing.
    pub fn fall(
        &self,
        record: &Record,
        (one, before): (&FittedModel, &Run),
        (other, after): (&FittedModel, &Run),
    ) -> Result<f64, Complaint> {
        Ok((self.cost(record, one, before)? - self.cost(record, other, after)?) / self.left)
    }

    fn cost(&self, record: &Record, model: &FittedModel, run: &Run) -> Result<f64, Complaint> {
        let mut misfit = away(&run.outputs, &weighed::measured(&model.rig, record)?);
        self.weights.apply(&mut misfit);
        Ok(2.0 * robust(&model.rig).cost(&misfit))
    }
}

/// Simulates a record with all parameters given, SI; judged by noise alone, whatever it was fitted with.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub fn run_with(model: &Model, record: &Record, drive: &InputSignals, values: &[f64]) -> Result<Run, Complaint> {
    if has_lack_of_fit(&model.rig) {
        return run_with(&Model::new(without_lack_of_fit(&model.rig)), record, drive, values);
    }
    let solved = events::weights_of(model, record, drive, values);
    let (weights, outputs) = solved.map_err(|error| weighed::unsolvable(model, record, error))?;
    run_of(&model.rig, record, outputs, weights)
}

/// The same of a record with what drives it, under its own weights or given ones.
///
/// # Errors
/// As [`run_with`].
pub(crate) fn run_under(
    rig: &Rig,
    record: &Record,
    values: &[f64],
    weights: Option<&Weights>,
) -> Result<Run, Complaint> {
    let Some(weights) = weights else {
        let model = Model::new(without_lack_of_fit(rig));
        return run_with(&model, record, &InputSignals::from_record(&model.rig, record)?, values);
    };
    let model = Model::new(rig.clone());
    let drive = InputSignals::from_record(rig, record)?;
    let solved = model.solve(values, &drive, &record.time);
    let outputs = solved.map_err(|error| weighed::unsolvable(&model, record, error))?.values;
    run_of(rig, record, outputs, weights.clone())
}
