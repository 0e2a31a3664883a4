//! What a fit found.

use super::{LocalModel, StoppedBecause};

/// The bound that a parameter ended on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
    /// Both: it was held.
    Held,
}

/// What a fit found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The `p` parameters, each in its unit.
    pub theta: Vec<f64>,
    /// Misfits of the record there.
    pub misfit: Vec<f64>,
    /// `2 F` of record and prior there: chi-square, where the noise is known.
    pub cost: f64,
    /// Decrease of the cost that a further step promises, as far as the last one kept its promise.
    pub promised: f64,
    /// Damping that a fit which goes on from here starts with.
    pub damping: f64,
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
    /// The local model at `theta`; `None` where the fit went along one from nearby.
    pub model: Option<LocalModel>,
}
