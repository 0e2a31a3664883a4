//! Why a fit could not be done at all.

use std::error::Error;
use std::fmt;

/// Why a fit could not be done at all. A trial point where the model fails is not one of these: it is a rejected step.
#[derive(Debug)]
pub enum FitError {
    /// An array has another length than the problem says: parameters, bounds, scales, misfits or Jacobian rows.
    Length { what: &'static str, expected: usize, found: usize },
    /// The lower bound of parameter `parameter` lies above its upper one, or one of them is not a number.
    Bounds { parameter: usize, lower: f64, upper: f64 },
    /// The model could not be evaluated at the point to start from.
    Start { source: Box<dyn Error + Send + Sync> },
    /// The model was evaluated at the point to start from, and gave an infinity or a NaN.
    StartNotFinite,
    /// A confidence level that is not between 0 and 1.
    Level { level: f64 },
    /// None of the `tried` starts could be evaluated.
    NoStart { tried: usize },
    /// The executor of the solver gave up, for instance because an observer failed.
    Executor { source: Box<dyn Error + Send + Sync> },
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { what, expected, found } => write!(f, "{what}: {expected} expected, {found} found"),
            Self::Bounds { parameter, lower, upper } => {
                write!(f, "parameter {parameter}: the bounds {lower} and {upper} leave no room")
            }
            Self::Start { source } => {
                write!(f, "the model fails at the start of the fit: {source}")
            }
            Self::StartNotFinite => write!(f, "the model gives no finite misfit at the start of the fit"),
            Self::Level { level } => {
                write!(f, "a confidence level lies between 0 and 1, not at {level}")
            }
            Self::NoStart { tried } => {
                write!(f, "the model fails at all {tried} starts of the fit")
            }
            Self::Executor { source } => write!(f, "the fit was given up: {source}"),
        }
    }
}

impl Error for FitError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            Self::Start { source } | Self::Executor { source } => Some(source.as_ref()),
            _ => None,
        }
    }
}
