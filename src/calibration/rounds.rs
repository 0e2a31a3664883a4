//! Rounds of noise, tolerance, weights and fit, until none of it moves any more.

use nalgebra::DVector;

use super::first_fits::{ends, unsettled};
use super::joint::{Joint, Solutions};
use super::noise::{self, Noise};
use super::tolerance::{Evidence, PortVariables};
use crate::diagnosis::events::{self, Events};
use crate::diagnosis::noise::Weights;
use crate::diagnosis::problem::RecordProblem;
use crate::estimation::{Fit, FitError, Gaussian, Loss};
use crate::model::{Model, SimulationError};
use crate::rig::{Rig, Sensor, TOLERANCE};

/// Where rounds have ended.
pub(super) struct Settled {
    /// The last fit.
    pub fit: Fit,
    /// What it weighed each record with.
    pub weights: Vec<Weights>,
    pub rounds: usize,
    /// Whether nothing moved any more.
    pub settled: bool,
}

/// How often a calibration goes halfway back from where the model is unstable: to a thousandth of the last step.
const HALVED: usize = 10;

/// What changes from round to round.
pub(super) struct Rounds<'a> {
    /// With the noise and tolerance found so far.
    pub rig: Rig,
    pub noises: Vec<Option<Noise>>,
    pub solutions: Solutions<'a>,
    pub prior: &'a Gaussian,
    /// Root mean square errors of the model as stated: `[record][sensor]`, SI.
    pub before: Vec<Vec<f64>>,
}

impl<'a> Rounds<'a> {
    /// Before the first. `before`: root mean square errors of the model as stated, `[record][sensor]`, SI.
    pub fn new(solutions: Solutions<'a>, prior: &'a Gaussian, before: Vec<Vec<f64>>) -> Self {
        let rig = solutions.model.rig.clone();
        Self { noises: vec![None; rig.sensors.len()], rig, solutions, prior, before }
    }

    /// So many rounds at most, from `theta`, until none of it moves any more. Where a fit has ended at values at which the model is
    /// unstable, no weights can be had; the round is taken from halfway back, again and again.
    ///
    /// # Errors
    /// The model cannot be solved, or the fit fails.
    pub fn settle(&mut self, mut theta: Vec<f64>, most: usize) -> Result<Settled, FitError> {
        let context = self.rig.context().clone();
        let count = context.count("rounds of noise, tolerance and fit, at most", most);
        let mut from = theta.clone();
        let mut rounds = 0;
        let mut halved = 0;
        loop {
            let before = self.rig.clone();
            let (fit, weights, near) = match self.round(&theta, rounds == 0) {
                Ok(taken) => taken,
                Err(_) if rounds > 0 && halved < HALVED && !context.is_cancelled() => {
                    halved += 1;
                    theta.iter_mut().zip(&from).for_each(|(theta, from)| *theta = f64::midpoint(*theta, *from));
                    continue;
                }
                Err(error) => return Err(error),
            };
            rounds += 1;
            count.one();
            let settled = near && alike(&before, &self.rig);
            if settled || rounds >= most {
                return Ok(Settled { fit, weights, rounds, settled });
            }
            from = std::mem::replace(&mut theta, fit.theta);
        }
    }

    /// One round from `theta`: the fit, what it was weighed with, and whether it stayed near.
    fn round(&mut self, theta: &[f64], is_first: bool) -> Result<(Fit, Vec<Weights>, bool), FitError> {
        self.forget_lack_of_fit();
        self.estimate_noise(theta)?;
        let events = self.events(&self.rig, theta)?;
        self.estimate_tolerance(theta, &events, if is_first { 2 } else { 1 })?;
        let mut weights = Self::weights(&self.rig, &events);
        if self.estimate_lack_of_fit(theta, &weights)? {
            weights = Self::weights(&self.rig, &self.events(&self.rig, theta)?);
        }
        let settings = &self.rig.settings().calibration;
        let joint = self.joint(weights.clone(), theta, Loss::Huber { k: settings.huber_width })?;
        let fit = joint.fit(theta, ends(&self.rig))?;
        let near = joint.within(&fit.theta, theta, settings.settled_deviation)?;
        Ok((fit, weights, near))
    }

    pub(super) fn joint(&self, weights: Vec<Weights>, theta: &[f64], loss: Loss) -> Result<Joint<'_>, SimulationError> {
        Joint::new(&self.solutions, weights, self.prior).robust(theta, loss)
    }

    /// The events of each record under the noise and tolerance of a rig.
    pub(super) fn events(&self, rig: &Rig, theta: &[f64]) -> Result<Vec<Events>, SimulationError> {
        let model = Model::new(rig.clone());
        let each = self.solutions.records.iter().enumerate().map(|(record, one)| {
            let empty = Weights::new(rig, &[], &[], &[]);
            let (open, theta) = self.solutions.of(theta, record);
            let (times, measured) = (&one.record.time, one.measured.clone());
            let problem = RecordProblem::new(&model, &one.drive, times, measured, empty, open);
            let mut events = events::events(&problem, one.record, &theta)?;
            unsettled(rig, one, &mut events.variance);
            Ok(events)
        });
        each.collect()
    }

    pub(super) fn weights(rig: &Rig, events: &[Events]) -> Vec<Weights> {
        events.iter().map(|one| one.weights(rig)).collect()
    }

    fn estimate_noise(&mut self, theta: &[f64]) -> Result<(), SimulationError> {
        let curves = self.solutions.curves(theta)?;
        self.noises = noise::estimate(&self.rig, &self.solutions, &curves);
        for (sensor, noise) in self.rig.sensors.iter_mut().zip(&self.noises) {
            if let Some(noise) = noise {
                sensor.noise = noise.sigma;
            }
        }
        Ok(())
    }

    fn estimate_tolerance(&mut self, theta: &[f64], events: &[Events], sweeps: usize) -> Result<(), SimulationError> {
        let mut free = self.rig.clone();
        free.sensors.iter_mut().for_each(|sensor| sensor.tolerance = 0.0);
        if events.iter().map(|one| one.phases.len()).sum::<usize>() < free.settings().calibration.tolerance_phases {
            return Ok(());
        }
        let curves = self.solutions.curves(theta)?;
        let mut seen = Vec::new();
        for (record, one) in events.iter().enumerate() {
            seen.push(PortVariables {
                weights: one.weights(&free),
                phases: one.phases.clone(),
                misfit: self.solutions.misfit(&curves, record),
                columns: self.solutions.columns(theta, record)?,
            });
        }
        let precision = self.prior.precision();
        let away = DVector::from_iterator(theta.len(), self.prior.mean.iter().zip(theta).map(|(mean, at)| mean - at));
        let pull = &precision * away;
        let colour: Vec<f64> = self.noises.iter().map(|noise| noise.map_or(1.0, |noise| noise.colour())).collect();
        let stated = &self.solutions.model.rig.sensors;
        // A tolerance that is stated as none is not believed, but taken as the usual one.
        let share = |sensor: &Sensor| if sensor.tolerance > 0.0 { sensor.tolerance / sensor.noise } else { TOLERANCE };
        let scale = stated.iter().map(share).collect();
        let evidence = Evidence::new(&free, seen, precision, pull, &colour, scale);
        let start: Vec<f64> = self.rig.sensors.iter().map(|sensor| sensor.tolerance).collect();
        for (sensor, tolerance) in self.rig.sensors.iter_mut().zip(evidence.tolerances(&start, sweeps)) {
            sensor.tolerance = tolerance.max(free.settings().calibration.least_tolerance_share * sensor.noise);
        }
        Ok(())
    }
}

/// Whether noise and tolerance have settled.
fn alike(before: &Rig, after: &Rig) -> bool {
    let settings = &after.settings().calibration;
    before.sensors.iter().zip(&after.sensors).all(|(before, after)| {
        (after.noise - before.noise).abs() <= settings.settled_noise * before.noise
            && (after.tolerance - before.tolerance).abs()
                <= settings.settled_tolerance * before.tolerance.max(after.tolerance)
    })
}
