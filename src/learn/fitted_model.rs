//! A model with everything uncertain fitted to a record, faults included, and its free run on another.

use std::collections::BTreeMap;

use super::lack_of_fit::{has_lack_of_fit, is_alike, with_lack_of_fit, without_lack_of_fit};
use super::refit::effect_parameters;
use crate::complaint::Complaint;
use crate::diagnosis::case::robust;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::noise::Weights;
use crate::diagnosis::problem::{away, over_sensors, root_mean_square};
use crate::diagnosis::{self, events, is_there, weighed};
use crate::estimation::Problem;
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::FaultSet;
use crate::rig::Rig;
use crate::settings::Settings;

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

/// A record simulated with given parameters.
#[derive(Debug, Clone)]
pub struct Run {
    /// What the sensors would show, `[sensor][row]`, SI.
    pub outputs: Vec<Vec<f64>>,
    /// Misfits weighted by noise and tolerance, one sensor after the other.
    pub misfit: Vec<f64>,
    pub weights: Weights,
    /// Root mean square of measured minus model per sensor, SI.
    pub rmse: Vec<f64>,
    /// The same over the noise of the sensor, over all of them.
    pub normalised: f64,
    /// Mean square of the weighted misfits, single wild ones tamed: 1 if the model is right within its tolerance.
    pub chi2: f64,
    /// The same of each sensor.
    pub of_sensors: Vec<f64>,
    /// Whether every sensor is explained within noise and tolerance.
    pub is_adequate: bool,
}

impl FittedModel {
    /// From an estimate.
    ///
    /// # Errors
    /// The model cannot be solved at it.
    pub fn of(estimate: &Estimate<'_>) -> Result<Self, Complaint> {
        let (case, isolation) = (&estimate.case, &estimate.isolation);
        let theta = &isolation.best.theta;
        let values = case.full.parameters(theta);
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
        let fit = run_with(case.full.model, case.record, case.full.drive, &values)?;
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

    /// What the model says of another record with nothing fitted to it.
    ///
    /// # Errors
    /// Columns that are missing, or a model that cannot be solved on it.
    pub fn check(&self, record: &Record) -> Result<Run, Complaint> {
        self.check_under(record, None)
    }

    /// The same under given weights.
    ///
    /// # Errors
    /// As [`FittedModel::check`].
    pub fn check_under(&self, record: &Record, weights: Option<&Weights>) -> Result<Run, Complaint> {
        run_under(&self.rig, record, &self.values, weights)
    }

    /// Fall of the information criterion against a model without its effects, on the record that both are fitted to, under the
    /// weights of `judge`. What an effect moves that was known before counts as the data sheet says.
    ///
    /// # Errors
    /// Columns that are missing.
    pub fn gain_over(&self, base: &Self, record: &Record, judge: &Judge) -> Result<f64, Complaint> {
        let parameters = |one: &Self| effect_parameters(&one.rig) as f64 + one.set.len() as f64;
        let fall = judge.fall(record, (base, &base.fit), (self, &self.fit))?;
        let known = |(index, value): (usize, &f64)| {
            let before = &base.rig.parameters[index];
            let waived = before.sigma > 0.0 && !base.rig.is_of_effect(index) && self.rig.is_of_effect(index);
            if waived { ((value - before.value) / before.sigma).powi(2) } else { 0.0 }
        };
        let known = |values: &[f64]| values.iter().take(base.values.len()).enumerate().map(known).sum::<f64>();
        let waived = known(&self.values) - known(&base.values);
        let samples = base.fit.weights.all_samples() as f64;
        Ok(fall - waived - (parameters(self) - parameters(base)) * samples.ln())
    }
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
    let model = Model::new(rig.clone());
    let drive = InputSignals::from_record(rig, record)?;
    let Some(weights) = weights else { return run_with(&model, record, &drive, values) };
    let solved = model.solve(values, &drive, &record.time);
    let outputs = solved.map_err(|error| weighed::unsolvable(&model, record, error))?.values;
    run_of(rig, record, outputs, weights.clone())
}

/// Root mean square misfits of the sensors, SI, as one error, times the sensor noise.
pub(super) fn times_noise(rig: &Rig, missed: &[Option<f64>]) -> f64 {
    over_sensors(missed.iter().zip(&rig.sensors).map(|(rms, sensor)| rms.map(|rms| rms / sensor.stated_noise)))
}

/// A run whose outputs are known.
pub(super) fn run_of(rig: &Rig, record: &Record, outputs: Vec<Vec<f64>>, weights: Weights) -> Result<Run, Complaint> {
    let data = weighed::measured(rig, record)?;
    let mut misfit = away(&outputs, &data);
    let missed: Vec<Option<f64>> =
        outputs.iter().zip(&data).map(|(model, measured)| root_mean_square(model, measured)).collect();
    let normalised = times_noise(rig, &missed);
    let rmse = missed.iter().map(|rms| rms.unwrap_or(0.0)).collect();
    weights.apply(&mut misfit);
    let lasting = |misfit: &[f64]| lasting_squares(rig.settings(), misfit);
    let squares: Vec<f64> = misfit.chunks(weights.rows().max(1)).take(rig.sensors.len()).map(lasting).collect();
    let chi2 = squares.iter().sum::<f64>() / weights.all_samples().max(1) as f64;
    let mean = |(sensor, squares): (usize, &f64)| squares / weights.samples(sensor).max(1) as f64;
    let of_sensors = squares.iter().enumerate().map(mean).collect();
    let settings = &rig.settings().diagnosis;
    let is_adequate = diagnosis::missed(settings, &weights, &misfit).iter().all(|one| one.is_explained(settings));
    Ok(Run { outputs, misfit, weights, rmse, normalised, chi2, of_sensors, is_adequate })
}

/// Sum of squares of the weighted misfits of a sensor. One that base points out from those around it counts as no more than a wild
/// sample; what lasts counts in full, so that twice the error is four times the sum however large it is.
fn lasting_squares(settings: &Settings, misfit: &[f64]) -> f64 {
    let (lasting, outlier) = (settings.learn.lasting_rows, settings.diagnosis.outlier_misfit);
    let sizes: Vec<f64> = misfit.iter().copied().filter(|misfit| is_there(*misfit)).map(f64::abs).collect();
    let around = |row: usize| {
        let mut near = sizes[row.saturating_sub(lasting)..(row + lasting + 1).min(sizes.len())].to_vec();
        near.sort_by(f64::total_cmp);
        near[near.len() / 2]
    };
    let one = |(row, size): (usize, &f64)| if *size <= outlier { *size } else { size.min(around(row).max(outlier)) };
    sizes.iter().enumerate().map(one).map(|size| size * size).sum()
}
