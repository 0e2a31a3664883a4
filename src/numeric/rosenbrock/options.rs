//! What an integration is asked for, and what it cost.

/// Accuracy and limits of an integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<const N: usize> {
    /// Relative tolerance: the error of one step is held below `atol + rtol |y|`, root mean square over the states.
    pub rtol: f64,
    /// Absolute tolerance of each state, in its unit; greater than 0 unless the state keeps away from 0.
    pub atol: [f64; N],
    /// The first step after [`Rosenbrock::restart`](super::Rosenbrock::restart) (s), or `None` to choose it from the first two
    /// derivatives.
    pub h_initial: Option<f64>,
    /// A step that must fall below this (s) is an error. Rounding of `t` sets a floor of its own.
    pub h_min: f64,
    /// No step is longer than this (s).
    pub h_max: f64,
    /// Most steps, accepted and rejected together, since the integrator was made.
    pub max_steps: usize,
    /// Most of them that are rejected.
    pub max_rejected: usize,
}

impl<const N: usize> Options<N> {
    /// Tolerances for each state, without other limits than 100,000 steps.
    pub fn new(rtol: f64, atol: [f64; N]) -> Self {
        Self {
            rtol,
            atol,
            h_initial: None,
            h_min: 0.0,
            h_max: f64::INFINITY,
            max_steps: 100_000,
            max_rejected: 100_000,
        }
    }

    /// One absolute tolerance for all states: right only where they are of similar size.
    #[cfg(feature = "internals")]
    pub fn uniform(rtol: f64, atol: f64) -> Self {
        Self::new(rtol, [atol; N])
    }
}

/// The effort spent, summed over all calls since the integrator was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Evaluations of the derivative (those within [`System::linearise`](super::System::linearise) included).
    pub derivatives: usize,
    /// Evaluations of the Jacobian.
    pub jacobians: usize,
    /// Inversions of `W`.
    pub factorisations: usize,
}
