//! Simulation and sensitivities of a rig over a drive.

use std::fmt;

use rayon::prelude::*;

use super::assembly::{Assembly, Inputs};
use super::drive::Drive;
use super::layout::Layout;
use super::start;

use crate::numeric::{Dual, IntegrationError, Options, Real, Rosenbrock, Scalar};
use crate::physics::effect;
use crate::rig::Rig;

/// Parameters whose sensitivities are carried through one integration.
const LANES: usize = 4;

/// Most states that the solver is built for.
pub const MOST_STATES: usize = 24;

/// Accuracy of the integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Relative.
    pub relative: f64,
    /// Relative to each state's typical magnitude.
    pub absolute: f64,
}

impl Default for Tolerance {
    /// Errors of about 10 Pa: so small that a least-squares cost over 10^5 samples stays smooth to a tenth.
    fn default() -> Self {
        Self { relative: 1e-6, absolute: 1e-6 }
    }
}

/// What the integrator spent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Effort {
    pub steps: usize,
    pub rejected: usize,
}

/// What the sensors of the model read: `[sensor][sample]`, SI, pressures gauge.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    pub values: Vec<Vec<f64>>,
    pub effort: Effort,
}

/// Outputs with their derivatives: `[parameter][sensor][sample]`, per SI unit of the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivities {
    pub outputs: Outputs,
    pub derivatives: Vec<Vec<Vec<f64>>>,
}

/// Why a simulation came to no end.
#[derive(Debug, Clone, PartialEq)]
pub enum SimulationError {
    /// The integrator gave up, at this state.
    Integration { error: IntegrationError, state: String },
    /// More states than the solver is built for.
    TooLarge { states: usize, most: usize },
    /// The explicit method gave up behind time `t` (s).
    Explicit { t: f64, reason: String },
}

impl fmt::Display for SimulationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integration { error, state } => write!(f, "{error} (worst: {state})"),
            Self::TooLarge { states, most } => write!(f, "the rig has {states} states, more than {most}"),
            Self::Explicit { t, reason } => write!(f, "behind {t} s the explicit method gave up: {reason}"),
        }
    }
}

impl std::error::Error for SimulationError {}

/// A rig with its equations laid out.
#[derive(Debug, Clone)]
pub struct Model {
    pub rig: Rig,
    layout: Layout,
    pub tolerance: Tolerance,
}

macro_rules! with_states {
    ($states:expr, $N:ident => $body:expr) => {
        match $states {
            0..=4 => {
                const $N: usize = 4;
                $body
            }
            5..=8 => {
                const $N: usize = 8;
                $body
            }
            9..=12 => {
                const $N: usize = 12;
                $body
            }
            13..=16 => {
                const $N: usize = 16;
                $body
            }
            17..=24 => {
                const $N: usize = 24;
                $body
            }
            states => Err(SimulationError::TooLarge { states, most: $crate::model::MOST_STATES }),
        }
    };
}

// Behind the macro that it uses.
mod explicit;

impl Model {
    pub fn new(rig: Rig) -> Self {
        let layout = Layout::of(&rig);
        Self { rig, layout, tolerance: Tolerance::default() }
    }

    /// Names of the states, in their order.
    pub fn states(&self) -> &[String] {
        &self.layout.names
    }

    /// What the sensors read at `times` (rising, s, within the drive) for one set of parameters (all of the rig's, SI).
    ///
    /// # Errors
    /// The integrator gives up: parameters without physical sense, or a circuit that tears.
    pub fn simulate(&self, parameters: &[f64], drive: &Drive, times: &[f64]) -> Result<Outputs, SimulationError> {
        let (values, effort) =
            with_states!(self.layout.states, N => self.readings::<f64, N>(parameters, drive, times))?;
        Ok(Outputs { values, effort })
    }

    /// The same with derivatives by the parameters `by` (indices), through dual numbers at the plain run's steps.
    ///
    /// # Errors
    /// As [`Model::simulate`].
    pub fn sensitivities(
        &self,
        parameters: &[f64],
        by: &[usize],
        drive: &Drive,
        times: &[f64],
    ) -> Result<Sensitivities, SimulationError> {
        let groups: Vec<&[usize]> = by.chunks(LANES).collect();
        let solve = |group: &[usize]| self.group(parameters, group, drive, times);
        // Groups are independent, so threads change nothing but the time.
        let solved: Result<Vec<Sensitivities>, _> = groups.par_iter().map(|&group| solve(group)).collect();
        let all = solved?.into_iter().reduce(|mut all, part| {
            all.derivatives.extend(part.derivatives);
            all
        });
        match all {
            Some(all) => Ok(all),
            None => Ok(Sensitivities { outputs: self.simulate(parameters, drive, times)?, derivatives: Vec::new() }),
        }
    }

    fn group(
        &self,
        parameters: &[f64],
        by: &[usize],
        drive: &Drive,
        times: &[f64],
    ) -> Result<Sensitivities, SimulationError> {
        let mut dual: Vec<Dual<f64, LANES>> = parameters.iter().map(|&value| Dual::constant(value)).collect();
        for (lane, &parameter) in by.iter().enumerate() {
            dual[parameter].eps[lane] = 1.0;
        }
        let (readings, effort) =
            with_states!(self.layout.states, N => self.readings::<Dual<f64, LANES>, N>(&dual, drive, times))?;
        let part = |of: &dyn Fn(&Dual<f64, LANES>) -> f64| -> Vec<Vec<f64>> {
            readings.iter().map(|readings| readings.iter().map(of).collect()).collect()
        };
        let derivatives = (0..by.len()).map(|lane| part(&|reading| reading.eps[lane])).collect();
        Ok(Sensitivities { outputs: Outputs { values: part(&|reading| reading.re), effort }, derivatives })
    }

    /// What the sensors show, `[sensor][row]`, with what effects do to it.
    fn readings<S: Scalar, const N: usize>(
        &self,
        parameters: &[S],
        drive: &Drive,
        times: &[f64],
    ) -> Result<(Vec<Vec<S>>, Effort), SimulationError> {
        let mut readings = vec![vec![S::zero(); times.len()]; self.rig.sensors.len()];
        let effort = self.run::<S, N>(parameters, drive, times, |row, sensor, value| readings[sensor][row] = value)?;
        for does in &self.rig.readings {
            let own = &parameters[does.first_parameter..][..does.card.parameters.len()];
            effect::read(does.card.kind, own, times, &mut readings[does.sensor]);
        }
        Ok((readings, effort))
    }

    fn run<S: Scalar, const N: usize>(
        &self,
        parameters: &[S],
        drive: &Drive,
        times: &[f64],
        mut write: impl FnMut(usize, usize, S),
    ) -> Result<Effort, SimulationError> {
        let tolerance = self.tolerance;
        let mut before = parameters.to_vec();
        for &(parameter, value) in drive.onset.iter().flat_map(|onset| &onset.before) {
            before[parameter] = S::constant(value);
        }
        let after = parameters;
        let begun = |t: f64| drive.onset.as_ref().is_none_or(|onset| t >= onset.time);
        let mut parameters: &[S] = &before;
        let mut assembly = Assembly::new(&self.rig, &self.layout, parameters);
        let mut atol = [1.0; N];
        for (atol, scale) in atol.iter_mut().zip(&self.layout.scales) {
            *atol = scale * tolerance.absolute;
        }
        let mut integrator = Rosenbrock::new(Options::new(tolerance.relative, atol));
        let mut y = [S::zero(); N];
        let mut raw = vec![S::zero(); self.rig.sensors.len()];
        let mut row = 0;
        for (index, piece) in drive.pieces.iter().enumerate() {
            let length = piece.end - piece.start;
            if begun(piece.start) && !std::ptr::eq(parameters, after) {
                parameters = after;
                assembly = Assembly::new(&self.rig, &self.layout, parameters);
            }
            assembly.inputs = Inputs {
                start: piece.start,
                from: piece.from.clone(),
                slope: piece.from.iter().zip(&piece.to).map(|(from, to)| (to - from) / length).collect(),
            };
            if index == 0 {
                start::start(&self.rig, &self.layout, &mut assembly, parameters, drive, piece.start, &mut y);
            }
            if piece.jump {
                integrator.restart();
            }
            let sensors = &self.rig.sensors;
            let mut emit = |assembly: &mut Assembly<'_, S>, row: usize, t: f64, y: &[S; N]| {
                assembly.raw_values(t, y, &mut raw);
                for (index, (sensor, &raw)) in sensors.iter().zip(&raw).enumerate() {
                    let (offset, gain) = (parameters[sensor.first_parameter], parameters[sensor.first_parameter + 1]);
                    write(row, index, raw * gain + offset);
                }
            };
            while row < times.len() && times[row] <= piece.start {
                emit(&mut assembly, row, times[row], &y);
                row += 1;
            }
            let last = index + 1 == drive.pieces.len();
            // The samples of a step are written after it: the integrator holds the assembly while it runs.
            let mut samples: Vec<(usize, [S; N])> = Vec::new();
            let result = integrator.integrate(&mut assembly, piece.start, &y, piece.end, |step| {
                while row < times.len() && (times[row] <= step.t_end || (last && step.t_end >= piece.end)) {
                    samples.push((row, step.interpolate_all(times[row].min(step.t_end))));
                    row += 1;
                }
            });
            for (row, y) in &samples {
                emit(&mut assembly, *row, times[*row], y);
            }
            y = result.map_err(|error| {
                let state = error.worst_state().and_then(|state| self.layout.names.get(state)).cloned();
                SimulationError::Integration { error, state: state.unwrap_or_default() }
            })?;
        }
        let stats = integrator.stats();
        Ok(Effort { steps: stats.steps, rejected: stats.rejected })
    }
}
