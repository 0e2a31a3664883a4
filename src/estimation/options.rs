//! When a fit may stop, and how its damping rises and falls.

/// When a fit may stop. Shares are without unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Share of the cost that a step saves and promised to save.
    pub function: f64,
    /// Cosine between the misfit and the columns of the Jacobian that are still free.
    pub gradient: f64,
    /// Largest change of a parameter as a share of the larger of its value and its scale.
    pub step: f64,
    /// Decrease of `2 F` that is worth a step.
    pub promise: f64,
    /// Most steps.
    pub max_iterations: u64,
    /// Damping of the first step, relative to the squared column lengths.
    pub damping: f64,
}

impl Default for Options {
    /// Well below a standard error, and above the noise that an integrator leaves in the cost.
    fn default() -> Self {
        Self { function: 1e-8, gradient: 1e-8, step: 1e-9, promise: 0.0, max_iterations: 100, damping: 1e-4 }
    }
}

impl Options {
    /// As far as double precision goes: for models without integration error.
    pub fn tight() -> Self {
        Self { function: 1e-18, gradient: 1e-15, step: 1e-14, max_iterations: 5000, ..Self::default() }
    }

    /// So many steps, until the next promises to lower `2 F` by less than `promise`; the first one undamped.
    pub fn steps(max_iterations: u64, promise: f64) -> Self {
        Self { function: 0.0, gradient: 0.0, step: 0.0, promise, max_iterations, damping: 0.0 }
    }

    /// With this damping of the first step.
    #[must_use]
    pub fn damped(self, damping: f64) -> Self {
        Self { damping, ..self }
    }
}

/// How the damping rises and falls. Weakly determined directions move the furthest and bend the most: damping holds them
/// back before others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedule {
    /// Least damping after a step that did not pay; less than this is no damping.
    pub least: f64,
    /// Damping beyond which no step is tried.
    pub most: f64,
}

/// With the Jacobian of each iterate any damping helps.
pub(super) const FRESH: Schedule = Schedule { least: 0.0, most: 1e32 };
/// Along one from nearby a failed step says that the model bends over its length: a tenth of the curvature is the first that
/// shortens it noticeably, and steps a thousandth as long are as short as the noise of the integration.
pub(super) const NEARBY: Schedule = Schedule { least: 0.1, most: 1e3 };
