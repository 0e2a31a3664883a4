//! A rig and a record as a least-squares problem.

use nalgebra::DMatrix;

use crate::fit::{Linearised, Problem};
use crate::model::{Drive, Model, SimulationError};

/// What is known of an estimated parameter besides the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// SI.
    pub mean: f64,
    /// One standard deviation, SI.
    pub sigma: f64,
}

/// A parameter that is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimated {
    /// Index among the rig's parameters.
    pub parameter: usize,
    /// SI.
    pub bounds: (f64, f64),
    /// Typical magnitude, SI.
    pub scale: f64,
    pub prior: Option<Prior>,
}

/// Misfits of a model to a record: every sensor's samples one after the other, then one per prior.
pub struct RecordProblem<'a> {
    pub model: &'a Model,
    pub drive: &'a Drive,
    pub times: &'a [f64],
    /// `[sensor][row]`, SI.
    pub measured: Vec<&'a [f64]>,
    /// Variance of each sample, `[sensor][row]`, SI squared.
    pub variance: Vec<Vec<f64>>,
    pub estimated: Vec<Estimated>,
    /// All parameters of the rig; the estimated ones are replaced.
    pub base: Vec<f64>,
    /// Rows of each phase, between jumps of the inputs.
    pub phases: Vec<std::ops::Range<usize>>,
    bounds: Vec<(f64, f64)>,
}

impl<'a> RecordProblem<'a> {
    pub fn new(
        model: &'a Model,
        drive: &'a Drive,
        times: &'a [f64],
        measured: Vec<&'a [f64]>,
        variance: Vec<Vec<f64>>,
        estimated: Vec<Estimated>,
    ) -> Self {
        let bounds = estimated.iter().map(|estimated| estimated.bounds).collect();
        let phases = phases(drive, times);
        Self { model, drive, times, measured, variance, estimated, base: model.rig.nominal(), phases, bounds }
    }

    /// All parameters of the rig with the estimated ones at `theta`.
    pub fn parameters(&self, theta: &[f64]) -> Vec<f64> {
        let mut parameters = self.base.clone();
        for (estimated, &value) in self.estimated.iter().zip(theta) {
            parameters[estimated.parameter] = value;
        }
        parameters
    }

    /// The parts of the misfit vector that are time series, one per sensor.
    pub fn series(&self) -> Vec<std::ops::Range<usize>> {
        let rows = self.times.len();
        (0..self.measured.len()).map(|sensor| sensor * rows..(sensor + 1) * rows).collect()
    }

    fn priors(&self) -> impl Iterator<Item = (usize, Prior)> {
        self.estimated.iter().enumerate().filter_map(|(index, estimated)| Some((index, estimated.prior?)))
    }

    fn weigh(&self, outputs: &[Vec<f64>], theta: &[f64]) -> Vec<f64> {
        let mut misfit = Vec::with_capacity(self.times.len() * self.measured.len() + theta.len());
        for ((model, measured), variance) in outputs.iter().zip(&self.measured).zip(&self.variance) {
            misfit.extend(model.iter().zip(*measured).zip(variance).map(|((m, y), v)| (m - y) / v.sqrt()));
        }
        self.whiten(&mut misfit);
        misfit.extend(self.priors().map(|(index, prior)| (theta[index] - prior.mean) / prior.sigma));
        misfit
    }
}

impl Problem for RecordProblem<'_> {
    type Error = SimulationError;

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        let outputs = self.model.simulate(&self.parameters(theta), self.drive, self.times)?;
        Ok(self.weigh(&outputs.values, theta))
    }

    fn linearise(&self, theta: &[f64]) -> Result<Linearised, SimulationError> {
        let parameters = self.parameters(theta);
        // Offsets and gains of sensors act on the finished reading; only the others need an integration.
        let inside: Vec<usize> = self
            .estimated
            .iter()
            .map(|estimated| estimated.parameter)
            .filter(|&parameter| self.of_sensor(parameter).is_none())
            .collect();
        let solved = self.model.sensitivities(&parameters, &inside, self.drive, self.times)?;
        let misfit = self.weigh(&solved.outputs.values, theta);
        let rows = self.times.len();
        let mut jacobian = DMatrix::zeros(misfit.len(), theta.len());
        let mut next = 0;
        for (column, estimated) in self.estimated.iter().enumerate() {
            let mut column = jacobian.column_mut(column);
            if let Some((sensor, is_gain)) = self.of_sensor(estimated.parameter) {
                let first = self.model.rig.sensors[sensor].first_parameter;
                let (offset, gain) = (parameters[first], parameters[first + 1]);
                let raw = |value: f64| if is_gain { (value - offset) / gain } else { 1.0 };
                let outputs = solved.outputs.values[sensor].iter().zip(&self.variance[sensor]);
                for (slot, (value, variance)) in column.iter_mut().skip(sensor * rows).zip(outputs) {
                    *slot = raw(*value) / variance.sqrt();
                }
            } else {
                let derivatives = solved.derivatives[next].iter().zip(&self.variance);
                for (slot, (derivative, variance)) in column
                    .iter_mut()
                    .zip(derivatives.flat_map(|(derivative, variance)| derivative.iter().zip(variance)))
                {
                    *slot = derivative / variance.sqrt();
                }
                next += 1;
            }
        }
        let first_prior = rows * self.measured.len();
        for mut column in jacobian.column_iter_mut() {
            self.whiten(column.as_mut_slice());
        }
        for (row, (index, prior)) in self.priors().enumerate() {
            jacobian[(first_prior + row, index)] = 1.0 / prior.sigma;
        }
        Ok(Linearised { misfit, jacobian })
    }

    fn scale(&self) -> Vec<f64> {
        self.estimated.iter().map(|estimated| estimated.scale).collect()
    }
}

impl RecordProblem<'_> {
    /// Takes from a column of weighted misfits (or of their derivatives) what a difference shared by a whole phase can
    /// explain: multiplies each phase of each sensor by `(I + v v')^(-1/2)`, `v` the sensor's tolerance over the standard
    /// deviation of each sample. A phase then says no more of a constant difference than the tolerance allows, however
    /// many samples it has.
    fn whiten(&self, column: &mut [f64]) {
        let rows = self.times.len();
        for (index, (sensor, variance)) in self.model.rig.sensors.iter().zip(&self.variance).enumerate() {
            for phase in &self.phases {
                let block = &mut column[index * rows + phase.start..index * rows + phase.end];
                let shared = || variance[phase.clone()].iter().map(|variance| sensor.tolerance / variance.sqrt());
                let square: f64 = shared().map(|v| v * v).sum();
                if square == 0.0 {
                    continue;
                }
                let along: f64 = shared().zip(block.iter()).map(|(v, r)| v * r).sum();
                let factor = (1.0 - 1.0 / (1.0 + square).sqrt()) * along / square;
                for (r, v) in block.iter_mut().zip(shared()) {
                    *r -= factor * v;
                }
            }
        }
    }

    /// The sensor whose offset (false) or gain (true) this parameter is.
    fn of_sensor(&self, parameter: usize) -> Option<(usize, bool)> {
        self.model.rig.sensors.iter().enumerate().find_map(|(index, sensor)| {
            let place = parameter.checked_sub(sensor.first_parameter)?;
            (place < 2).then_some((index, place == 1))
        })
    }
}

/// Rows between jumps of the inputs.
fn phases(drive: &Drive, times: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut starts: Vec<usize> = drive
        .pieces
        .iter()
        .filter(|piece| piece.jump)
        .map(|piece| times.partition_point(|&time| time <= piece.start))
        .collect();
    starts.push(0);
    starts.push(times.len());
    starts.sort_unstable();
    starts.dedup();
    starts.windows(2).map(|pair| pair[0]..pair[1]).collect()
}
