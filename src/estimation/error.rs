//! Why a fit could not be done at all.

use std::error::Error;
use std::fmt;

/// Why a fit could not be done at all. A trial point where the model fails is not one of these: it is a rejected step.
#[derive(Debug)]
pub enum FitError {
    /// An array has another length than the problem says: parameters, bounds, scales, misfits or Jacobian rows.
    Length { what: &'static str, expected: usize, found: usize },
    /// The lower bound of a parameter lies above its upper one, or one of them is not a number.
    Bounds { parameter: String, lower: f64, upper: f64 },
    /// The model could not be evaluated at the point to start from.
    Start { source: Box<dyn Error + Send + Sync> },
    /// The model was evaluated, and gave an infinity or a NaN.
    NotFinite(NotFinite),
    /// The executor of the solver gave up, for instance because an observer failed.
    Executor { source: Box<dyn Error + Send + Sync> },
}

/// What is not finite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NotFinite {
    /// A misfit at the start of a fit.
    Misfit,
    /// A derivative of the misfits by this parameter.
    Sensitivity { parameter: String },
}

impl FitError {
    /// The model fails at the point to start from.
    pub fn start(error: impl Error + Send + Sync + 'static) -> Self {
        Self::Start { source: Box::new(error) }
    }
}

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Misfit => f.write_str("the model gives no finite misfit at the start of the fit"),
            Self::Sensitivity { parameter } => write!(f, "the sensitivity to {parameter} is not finite"),
        }
    }
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { what, expected, found } => write!(f, "{what}: {expected} expected, {found} found"),
            Self::Bounds { parameter, lower, upper } => {
                write!(f, "{parameter}: the bounds {lower} and {upper} leave no room")
            }
            Self::Start { source } => write!(f, "the model fails at the start of the fit: {source}"),
            Self::NotFinite(what) => write!(f, "{what}"),
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
