//! A rig and a record as a least-squares problem.

use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::DMatrix;

use super::noise::Weights;
use super::prior::Gaussian;
use crate::fit::{Linearised, Problem};
use crate::model::{Drive, Model, Sensitivities, SimulationError};

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

/// Misfits of a model to a record: every sensor's samples one after the other, then those of what is known before.
pub struct RecordProblem<'a> {
    pub model: &'a Model,
    pub drive: &'a Drive,
    pub times: &'a [f64],
    /// `[sensor][row]`, SI.
    pub measured: Vec<&'a [f64]>,
    pub weights: Weights,
    pub estimated: Vec<Estimated>,
    pub prior: Gaussian,
    /// All parameters of the rig; the estimated ones are replaced.
    pub base: Vec<f64>,
    bounds: Vec<(f64, f64)>,
    /// Simulations so far, those with sensitivities included.
    solves: AtomicU64,
}

impl<'a> RecordProblem<'a> {
    pub fn new(
        model: &'a Model,
        drive: &'a Drive,
        times: &'a [f64],
        measured: Vec<&'a [f64]>,
        weights: Weights,
        estimated: Vec<Estimated>,
        prior: Gaussian,
    ) -> Self {
        let bounds = estimated.iter().map(|estimated| estimated.bounds).collect();
        Self {
            model,
            drive,
            times,
            measured,
            weights,
            estimated,
            prior,
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

    /// Misfits, had something else driven the rig.
    ///
    /// # Errors
    /// The model cannot be solved.
    pub fn misfit_with(&self, drive: &Drive, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        self.solves.fetch_add(1, Ordering::Relaxed);
        let outputs = self.model.simulate(&self.parameters(theta), drive, self.times)?;
        Ok(self.weigh(&outputs.values, theta))
    }

    /// The parts of the misfit vector that are time series, one per sensor.
    pub fn series(&self) -> Vec<std::ops::Range<usize>> {
        let rows = self.times.len();
        (0..self.measured.len()).map(|sensor| sensor * rows..(sensor + 1) * rows).collect()
    }

    fn weigh(&self, outputs: &[Vec<f64>], theta: &[f64]) -> Vec<f64> {
        let mut misfit = Vec::with_capacity(self.times.len() * self.measured.len() + theta.len());
        for (model, measured) in outputs.iter().zip(&self.measured) {
            misfit.extend(model.iter().zip(*measured).map(|(m, y)| m - y));
        }
        self.weights.apply(&mut misfit);
        misfit.extend(self.prior.misfit(theta).iter());
        misfit
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
        let parameters = self.parameters(theta);
        // Offsets and gains of sensors act on the finished reading; only the others need an integration.
        let inside: Vec<usize> = self
            .estimated
            .iter()
            .map(|estimated| estimated.parameter)
            .filter(|&parameter| self.of_sensor(parameter).is_none())
            .collect();
        self.solves.fetch_add(1, Ordering::Relaxed);
        let Sensitivities { outputs, derivatives } =
            self.model.sensitivities(&parameters, &inside, self.drive, self.times)?;
        let misfit = self.weigh(&outputs.values, theta);
        let rows = self.times.len();
        let mut jacobian = DMatrix::zeros(misfit.len(), theta.len());
        let mut next = 0;
        for (column, estimated) in self.estimated.iter().enumerate() {
            let mut column = jacobian.column_mut(column);
            if let Some((sensor, is_gain)) = self.of_sensor(estimated.parameter) {
                let first = self.model.rig.sensors[sensor].first_parameter;
                let (offset, gain) = (parameters[first], parameters[first + 1]);
                let raw = |value: f64| if is_gain { (value - offset) / gain } else { 1.0 };
                for (slot, value) in column.iter_mut().skip(sensor * rows).zip(&outputs.values[sensor]) {
                    *slot = raw(*value);
                }
            } else {
                for (slot, derivative) in column.iter_mut().zip(derivatives[next].iter().flatten()) {
                    *slot = *derivative;
                }
                next += 1;
            }
            self.weights.apply(column.as_mut_slice());
        }
        let first_prior = rows * self.measured.len();
        self.prior.linearise(&mut jacobian, first_prior);
        Ok(Linearised { misfit, jacobian })
    }

    fn scale(&self) -> Vec<f64> {
        self.estimated.iter().map(|estimated| estimated.scale).collect()
    }
}

impl RecordProblem<'_> {
    /// The sensor whose offset (false) or gain (true) this parameter is.
    fn of_sensor(&self, parameter: usize) -> Option<(usize, bool)> {
        self.model.rig.sensors.iter().enumerate().find_map(|(index, sensor)| {
            let place = parameter.checked_sub(sensor.first_parameter)?;
            (place < 2).then_some((index, place == 1))
        })
    }
}
