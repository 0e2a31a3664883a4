//! A rig and a record as a least-squares problem.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::DMatrix;

use super::noise::Weights;
use crate::context::Interrupted;
use crate::estimation::{FitError, Linearised, Part, Problem, Series};
use crate::model::{InputSignals, Model, Onset, Sensitivities, SimulationError};

/// A parameter that is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimated {
    /// Index among the rig's parameters.
    pub parameter: usize,
    /// SI.
    pub bounds: (f64, f64),
    /// Typical magnitude, SI.
    pub scale: f64,
}

/// Model minus measurement, one sensor after the other, both `[sensor][row]`.
pub(crate) fn away(outputs: &[Vec<f64>], measured: &[&[f64]]) -> Vec<f64> {
    let pairs = outputs.iter().zip(measured);
    pairs.flat_map(|(model, measured)| model.iter().zip(*measured).map(|(m, y)| m - y)).collect()
}

/// Sum of the squares of model minus measured over the samples that are there, SI squared; 0 without any.
pub(crate) fn square_sum(model: &[f64], measured: &[f64]) -> f64 {
    let there = model.iter().zip(measured).filter(|(_, y)| !y.is_nan());
    there.fold(0.0, |sum, (m, y)| sum + (m - y) * (m - y))
}

/// How many samples there are.
pub(crate) fn count_there(measured: &[f64]) -> usize {
    measured.iter().filter(|value| !value.is_nan()).count()
}

/// Root mean square of model minus measured over the samples that are there, SI; `None` without any.
pub(crate) fn root_mean_square(model: &[f64], measured: &[f64]) -> Option<f64> {
    let count = count_there(measured);
    (count > 0).then(|| (square_sum(model, measured) / count as f64).sqrt())
}

/// The one number of a fit: root mean square over the sensors that have samples of what each is missed by, times its noise.
pub(crate) fn over_sensors(times_noise: impl Iterator<Item = Option<f64>>) -> f64 {
    let (sum, count) = times_noise.flatten().fold((0.0, 0_usize), |(sum, count), one| (sum + one * one, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// Misfits of a model to a record: every sensor's samples one after the other.
pub struct RecordProblem<'a> {
    pub model: &'a Model,
    pub drive: &'a InputSignals,
    pub times: &'a [f64],
    /// `[sensor][row]`, SI.
    pub measured: Vec<&'a [f64]>,
    pub weights: Weights,
    pub estimated: Vec<Estimated>,
    /// All parameters of the rig; the estimated ones are replaced.
    pub base: Vec<f64>,
    bounds: Vec<(f64, f64)>,
    /// Simulations so far, those with sensitivities included.
    solves: AtomicU64,
}

impl<'a> RecordProblem<'a> {
    pub fn new(
        model: &'a Model,
        drive: &'a InputSignals,
        times: &'a [f64],
        measured: Vec<&'a [f64]>,
        weights: Weights,
        estimated: Vec<Estimated>,
    ) -> Self {
        let bounds = estimated.iter().map(|estimated| estimated.bounds).collect();
        Self {
            model,
            drive,
            times,
            measured,
            weights,
            estimated,
            base: model.rig.nominal(),
            bounds,
            solves: AtomicU64::new(0),
        }
    }

    /// All parameters of the rig with the estimated ones at `theta`.
    pub fn parameters(&self, theta: &[f64]) -> Vec<f64> {
        let mut parameters = self.base.clone();
        for (estimated, &value) in self.estimated.iter().zip(theta) {
            parameters[estimated.parameter] = value;
        }
        parameters
    }

    /// Simulations so far, those with sensitivities included.
    pub fn solves(&self) -> u64 {
        self.solves.load(Ordering::Relaxed)
    }

    /// What the sensors read with all parameters of the rig and a drive, `[sensor][row]`, SI.
    ///
    /// # Errors
    /// The model cannot be solved.
    pub fn outputs(&self, parameters: &[f64], drive: &InputSignals) -> Result<Vec<Vec<f64>>, SimulationError> {
        self.solves.fetch_add(1, Ordering::Relaxed);
        Ok(self.model.solve(parameters, drive, self.times)?.values)
    }

    /// What another drive changes of the readings `outputs`, over so many rows from the first.
    ///
    /// # Errors
    /// The model cannot be solved.
    pub(super) fn change(
        &self,
        drive: &InputSignals,
        parameters: &[f64],
        outputs: &[Vec<f64>],
        rows: usize,
    ) -> Result<Vec<Vec<f64>>, SimulationError> {
        let mut changed = self.model.solve(parameters, drive, &self.times[..rows])?.values;
        for (changed, plain) in changed.iter_mut().zip(outputs) {
            changed.iter_mut().zip(plain).for_each(|(changed, plain)| *changed -= plain);
            changed.resize(plain.len(), 0.0);
        }
        Ok(changed)
    }

    /// Misfits, had something else driven the rig.
    ///
    /// # Errors
    /// The model cannot be solved.
    pub fn misfit_with(&self, drive: &InputSignals, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        Ok(self.weigh(&self.outputs(&self.parameters(theta), drive)?))
    }

    /// The parts of the misfit vector that are time series, one per sensor.
    pub fn series(&self) -> Vec<Range<usize>> {
        let rows = self.times.len();
        (0..self.measured.len()).map(|sensor| sensor * rows..(sensor + 1) * rows).collect()
    }

    /// Misfits of what the sensors would read, `[sensor][row]`, SI.
    pub(super) fn weigh(&self, outputs: &[Vec<f64>]) -> Vec<f64> {
        let mut misfit = away(outputs, &self.measured);
        self.weights.apply(&mut misfit);
        misfit
    }
}

/// One per sensor.
impl Series for RecordProblem<'_> {
    fn parts(&self) -> Vec<Part> {
        self.series()
            .into_iter()
            .zip(self.weights.shared.iter().copied())
            .map(|(rows, shared)| Part { rows, shared })
            .collect()
    }

    fn leave_own(&self, column: &mut [f64]) {
        self.weights.leave_own(column);
    }
}

impl Problem for RecordProblem<'_> {
    type Error = SimulationError;

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        self.misfit_with(self.drive, theta)
    }

    fn linearise(&self, theta: &[f64]) -> Result<Linearised, SimulationError> {
        let solved = self.model.sensitivities(&self.parameters(theta), &self.inside(), self.drive, self.times)?;
        Ok(self.linearised(theta, &solved))
    }

    fn scale(&self) -> Vec<f64> {
        self.estimated.iter().map(|estimated| estimated.scale).collect()
    }

    fn name(&self, parameter: usize) -> String {
        let own = self.model.rig.original(self.estimated[parameter].parameter);
        self.model.rig.parameters[own].id.clone()
    }
}

impl From<Interrupted> for FitError {
    fn from(interrupted: Interrupted) -> Self {
        SimulationError::from(interrupted).into()
    }
}

impl From<SimulationError> for FitError {
    fn from(error: SimulationError) -> Self {
        Self::start(error)
    }
}

impl RecordProblem<'_> {
    /// Estimated parameters, by index of the rig's, whose derivatives need an integration: offsets and gains act on the
    /// finished reading, but where the circuit starts as the sensor shows.
    pub(super) fn inside(&self) -> Vec<usize> {
        let all = self.estimated.iter().map(|estimated| estimated.parameter);
        all.filter(|&parameter| self.by_reading(parameter).is_none()).collect()
    }

    /// Misfits and their derivatives at `theta`, from what the sensors read there and its derivatives by
    /// [`RecordProblem::inside`].
    pub(super) fn linearised(&self, theta: &[f64], solved: &Sensitivities) -> Linearised {
        self.solves.fetch_add(1, Ordering::Relaxed);
        let Sensitivities { outputs, derivatives } = solved;
        let parameters = self.parameters(theta);
        let misfit = self.weigh(&outputs.values);
        let rows = self.times.len();
        let (before, until) = (self.drive.before(&parameters).0, self.until());
        let mut jacobian = DMatrix::zeros(misfit.len(), theta.len());
        let mut next = 0;
        for (column, estimated) in self.estimated.iter().enumerate() {
            let mut column = jacobian.column_mut(column);
            if let Some(OfSensor { sensor, is_gain, rows: own }) = self.by_reading(estimated.parameter) {
                let first = self.model.rig.sensors[sensor].first_parameter;
                for row in own {
                    let at = if row < until { &before } else { &parameters };
                    let raw = || (outputs.values[sensor][row] - at[first]) / at[first + 1];
                    column[sensor * rows + row] = if is_gain { raw() } else { 1.0 };
                }
            } else {
                for (slot, derivative) in column.iter_mut().zip(derivatives[next].iter().flatten()) {
                    *slot = *derivative;
                }
                next += 1;
            }
        }
        self.weights.apply_to_columns(&mut jacobian);
        Linearised { misfit, jacobian }
    }

    /// Rows until which parameters may have other values than after.
    fn until(&self) -> usize {
        let first = self.drive.pieces.first().map_or(f64::INFINITY, |piece| piece.start);
        let begins = self.drive.onset.as_ref().filter(|onset| onset.time > first);
        begins.map_or(0, |onset| self.times.partition_point(|&t| t <= onset.time))
    }

    /// What of a sensor this parameter is, if it does nothing but to the finished reading.
    fn by_reading(&self, parameter: usize) -> Option<OfSensor> {
        let own = self.model.rig.original(parameter);
        let (sensor, is_gain) = self.model.rig.sensors.iter().enumerate().find_map(|(index, sensor)| {
            let place = own.checked_sub(sensor.first_parameter)?;
            let starts = self.drive.starts_by(index);
            (place < 2 && !starts).then_some((index, place == 1))
        })?;
        let changes = |onset: &Onset| onset.before.iter().any(|(changed, _)| *changed == own);
        let rows = match (own == parameter, self.drive.onset.as_ref().is_some_and(changes)) {
            (true, true) => self.until()..self.times.len(),
            (true, false) => 0..self.times.len(),
            (false, _) => 0..self.until(),
        };
        Some(OfSensor { sensor, is_gain, rows })
    }
}

/// What of a sensor a parameter is.
struct OfSensor {
    sensor: usize,
    /// Else its offset.
    is_gain: bool,
    /// Rows in which it is in force.
    rows: Range<usize>,
}
