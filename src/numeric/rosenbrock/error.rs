//! Why an integration stopped early.

use std::fmt;

/// Why an integration stopped early. Times are in s; a state is named by its index, the caller knows its name.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum IntegrationError {
    /// The accuracy asked for needs steps below the floor: mostly a jump inside the piece, or a law with an infinite slope.
    StepTooSmall {
        /// Time reached.
        t: f64,
        /// The step that was refused.
        h: f64,
        /// The state with the largest error in that step.
        worst_state: usize,
    },
    /// The end was not reached within the allowed number of steps.
    TooManySteps {
        /// Time reached.
        t: f64,
        /// Steps tried since the integrator was made.
        steps: usize,
        /// The state with the largest error in the last step tried.
        worst_state: usize,
    },
    /// More steps were rejected than are allowed: the equations jump, or bend, again and again without notice.
    TooManyRejected {
        /// Time reached.
        t: f64,
        /// Steps rejected.
        rejected: usize,
        /// The state with the largest error in the last one.
        worst_state: usize,
    },
    /// The start of a step already has a derivative, or an entry of the Jacobian, that is infinite or no number.
    NotFinite {
        /// Time of the state that cannot be continued.
        t: f64,
        /// The first state whose derivative or Jacobian row is not finite.
        worst_state: usize,
    },
    /// The end lies before the start, or one of them is no number.
    NoInterval {
        /// Start.
        t0: f64,
        /// End.
        t1: f64,
    },
}

impl IntegrationError {
    /// Index of the state that stood in the way, where one did.
    pub fn worst_state(&self) -> Option<usize> {
        match *self {
            Self::StepTooSmall { worst_state, .. }
            | Self::TooManySteps { worst_state, .. }
            | Self::TooManyRejected { worst_state, .. }
            | Self::NotFinite { worst_state, .. } => Some(worst_state),
            Self::NoInterval { .. } => None,
        }
    }
}

impl IntegrationError {
    /// What went wrong, the worst state by a name of the caller's.
    pub fn told(&self, state: &dyn fmt::Display) -> String {
        match *self {
            Self::StepTooSmall { t, h, .. } => {
                format!("at t = {t} s the step fell to {h:e} s without reaching the accuracy; {state} is the worst")
            }
            Self::TooManySteps { t, steps, .. } => {
                format!("{steps} steps reached only t = {t} s; {state} held the step down last")
            }
            Self::TooManyRejected { t, rejected, .. } => {
                format!("{rejected} steps had to be taken back up to t = {t} s; {state} jumps or bends again and again")
            }
            Self::NotFinite { t, .. } => {
                format!("at t = {t} s the derivative of {state}, or its Jacobian row, is not finite")
            }
            Self::NoInterval { t0, t1 } => {
                format!("cannot integrate from t = {t0} s to t = {t1} s: time must run forward")
            }
        }
    }
}

impl fmt::Display for IntegrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.told(&format_args!("state {}", self.worst_state().unwrap_or_default())))
    }
}

impl std::error::Error for IntegrationError {}
