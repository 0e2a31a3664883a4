//! What a simulation is asked for and what it gives.

use std::fmt;

use crate::context::Interrupted;
use crate::numeric::IntegrationError;

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
pub struct SolverEffort {
    /// Steps that were taken.
    pub steps: usize,
    /// Steps that were tried and taken back.
    pub rejected: usize,
}

/// What the sensors of the model read: `[sensor][sample]`, SI, pressures gauge.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// `[sensor][sample]`, SI.
    pub values: Vec<Vec<f64>>,
    /// What the integrator spent.
    pub effort: SolverEffort,
}

/// Outputs with their derivatives: `[parameter][sensor][sample]`, per SI unit of the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivities {
    /// The plain run.
    pub outputs: Outputs,
    /// `[parameter][sensor][sample]`, per SI unit of the parameter.
    pub derivatives: Vec<Vec<Vec<f64>>>,
}

/// Why a simulation came to no end.
#[derive(Debug, Clone, PartialEq)]
pub enum SimulationError {
    /// The integrator gave up, at this state.
    Integration {
        /// What went wrong, and when.
        error: IntegrationError,
        /// The state that had the largest error.
        state: String,
        /// The formula of the rig file that may be the cause, with its effect.
        formula: Option<String>,
    },
    /// More states than the solver is built for.
    TooLarge {
        /// Of the rig.
        states: usize,
        /// Of the solver.
        most: usize,
    },
    /// The explicit method gave up behind time `t` (s).
    Explicit {
        /// s.
        t: f64,
        /// In the words of the library.
        reason: String,
    },
    /// A rounding error of a parameter grows until a sensor shows it: what the model gives from there on is chance.
    Unstable {
        /// Id of the parameter.
        parameter: String,
        /// Name of the sensor.
        sensor: String,
        /// s.
        t: f64,
    },
    /// The context of the rig was cancelled.
    Interrupted,
}

impl fmt::Display for SimulationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integration { error, state, formula } => {
                f.write_str(&error.told(state))?;
                match formula {
                    Some(formula) => write!(f, "; there acts the formula {formula}"),
                    None => Ok(()),
                }
            }
            Self::TooLarge { states, most } => write!(f, "the rig has {states} states, more than {most}"),
            Self::Unstable { parameter, sensor, t } => {
                write!(
                    f,
                    "from {t:.3} s on the model is unstable or rings undamped: a rounding error of {parameter} grows until it shows in {sensor}; a shorter \
                     lag of that part, or more volume beside it, damps it"
                )
            }
            Self::Interrupted => Interrupted.fmt(f),
            Self::Explicit { t, reason } => write!(f, "behind {t} s the explicit method gave up: {reason}"),
        }
    }
}

impl std::error::Error for SimulationError {}

impl From<Interrupted> for SimulationError {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}
