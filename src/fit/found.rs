//! What a fit found.

use super::{Linearised, Loss, StoppedBecause};

/// The bound that a parameter ended on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
}

/// What a fit found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The `p` parameters, each in its unit.
    pub theta: Vec<f64>,
    /// `1/2 sum rho(r^2)` there.
    pub cost: f64,
    /// Accepted steps.
    pub iterations: u64,
    /// Calls of [`Problem::misfit`](super::Problem::misfit).
    pub misfit_evaluations: u64,
    /// Calls of [`Problem::linearise`](super::Problem::linearise).
    pub linearisations: u64,
    /// Which inequality ended it.
    pub stopped: StoppedBecause,
    /// The bound that each parameter lies on, if any.
    pub at_bound: Vec<Option<Bound>>,
    /// Misfits and Jacobian at `theta`.
    pub linearised: Linearised,
    /// The loss that was minimised.
    pub loss: Loss,
}
