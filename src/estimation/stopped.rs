//! Which inequality ended a fit.

use std::fmt;

/// Which inequality ended a fit, with both its sides.
#[derive(Debug, Clone, PartialEq)]
pub enum StoppedBecause {
    /// The last step lowered the cost, and promised to lower it, by a share of at most `tolerance`.
    FunctionTolerance { relative_decrease: f64, tolerance: f64 },
    /// The cosine of the angle between the misfit and every direction that is still free is at most `tolerance`.
    GradientTolerance { cosine: f64, tolerance: f64 },
    /// The last step changed no parameter by more than `tolerance` of its magnitude.
    StepTolerance { relative_step: f64, tolerance: f64 },
    /// The next step promises to lower the cost by less than `tolerance`.
    PromiseTolerance { promised: f64, tolerance: f64 },
    /// No step, down to `relative_step`, lowers the cost: that is what rounding, or the integrator's error, leaves.
    NoFurtherDecrease { relative_step: f64, promised: f64 },
    /// The steps that were allowed are used up.
    MaxIterations { iterations: u64 },
}

impl StoppedBecause {
    /// Whether the point found is an optimum as far as the arithmetic can tell.
    pub fn converged(&self) -> bool {
        !matches!(self, Self::MaxIterations { .. })
    }
}

impl fmt::Display for StoppedBecause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FunctionTolerance { relative_decrease, tolerance } => {
                write!(f, "relative cost decrease {relative_decrease:.2e} <= {tolerance:.1e}")
            }
            Self::GradientTolerance { cosine, tolerance } => {
                write!(f, "projected gradient {cosine:.2e} <= {tolerance:.1e}")
            }
            Self::StepTolerance { relative_step, tolerance } => {
                write!(f, "relative step {relative_step:.2e} <= {tolerance:.1e}")
            }
            Self::PromiseTolerance { promised, tolerance } => {
                write!(f, "the next step promises to lower chi-square by {promised:.2e} < {tolerance:.1e}")
            }
            Self::NoFurtherDecrease { relative_step, promised } => {
                write!(
                    f,
                    "no further decrease down to a relative step of {relative_step:.2e} ({promised:.2e} of the cost promised)"
                )
            }
            Self::MaxIterations { iterations } => write!(f, "{iterations} iterations used up"),
        }
    }
}
