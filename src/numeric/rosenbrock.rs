//! Rodas5P: a Rosenbrock method for stiff smooth pieces of a circuit's motion.

mod coefficients;
mod control;
mod error;
mod linear;
mod options;
mod sparse;
mod stages;
mod stagewise;
mod step;
mod tangents;

use std::ops::ControlFlow;
use std::sync::Arc;

use super::in_use;
use control::{factor, first_step, fit, norm};
use stages::{Local, attempt, worst_state};

pub use error::IntegrationError;
pub use linear::{Inverse, Scalar, Solver, States};
pub use options::{Options, Stats};
pub use sparse::Elimination;
pub use step::Step;
pub use tangents::{Curved, Entry, Tangents};

/// The equations `y' = f(t, y)` of `N` states.
pub trait System<S: Scalar, const N: usize> {
    /// How many states are in use, from the first on, and how many of those the others depend on. The rates of those behind
    /// them are zero, and nothing depends on them.
    fn states(&self) -> States {
        States::all(N)
    }

    /// Along which pattern its matrix is eliminated, where that is known and pays.
    fn elimination(&self) -> Option<&Arc<Elimination>> {
        None
    }

    /// Writes `f(t, y)` into `dydt`, every entry.
    fn derivative(&mut self, t: f64, y: &[S; N], dydt: &mut [S; N]);

    /// Writes the Jacobian `j[row][column] = df[row]/dy[column]` and `dfdt`, the partial derivative of `f` by time at
    /// constant `y`: what inputs given as functions of time contribute. Both arrive zeroed, so entries that are always
    /// zero need no writing.
    ///
    /// Over dual numbers the entries carry their own derivatives (second derivatives of `f`); without them the
    /// sensitivities are wrong, not merely less accurate. Without `dfdt` the order falls wherever an input moves.
    fn jacobian(&mut self, t: f64, y: &[S; N], j: &mut [[S; N]; N], dfdt: &mut [S; N]);

    /// Both at once, at the start of every step. Override it where the Jacobian yields the derivative as by-product; the
    /// values written must equal those of [`derivative`](System::derivative).
    #[inline]
    fn linearise(&mut self, t: f64, y: &[S; N], dydt: &mut [S; N], j: &mut [[S; N]; N], dfdt: &mut [S; N]) {
        self.derivative(t, y, dydt);
        self.jacobian(t, y, j, dfdt);
    }
}

/// Where an integration ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival<S, const N: usize> {
    /// The time reached (s).
    pub t: f64,
    /// The states there.
    pub y: [S; N],
    /// Whether the callback ended it before the end asked for.
    pub stopped: bool,
}

/// The integrator Rodas5P: order 5 with an embedded order 4, L-stable, stiffly accurate, dense output of order 4.
///
/// It integrates smooth pieces. Where the equations switch, end the piece there, call [`restart`](Rosenbrock::restart) and
/// go on; where only the slope of an input changes (the knots of a measured, linearly interpolated input), end the piece
/// and go on without it: the step size is kept. Kinks that are not announced are found by the error estimate, at the
/// price of some rejected steps.
///
/// Over `Dual<f64, P>` it gives the derivatives of the numerical solution by `P` parameters, at fixed step sizes: the error
/// estimate looks only at real parts, so the steps are those of the plain run. They are as accurate as the steps are, and
/// not controlled by themselves.
///
/// Source: G. Steinebach, BIT Numerical Mathematics 63:27 (2023); step control after E. Hairer and G. Wanner, "Solving
/// Ordinary Differential Equations II", 2nd ed., Springer 1996, IV.7 and IV.8.
///
/// ```
/// use borescope::internals::numeric::{Options, Rosenbrock, System};
///
/// /// A pressure that decays through a leak: y' = -1000 y.
/// struct Leak;
///
/// impl System<f64, 1> for Leak {
///     fn derivative(&mut self, _t: f64, y: &[f64; 1], dydt: &mut [f64; 1]) {
///         dydt[0] = -1000.0 * y[0];
///     }
///     fn jacobian(&mut self, _t: f64, _y: &[f64; 1], j: &mut [[f64; 1]; 1], _dfdt: &mut [f64; 1]) {
///         j[0][0] = -1000.0;
///     }
/// }
///
/// let mut integrator = Rosenbrock::new(Options::uniform(1e-8, 1e-12));
/// let mut middle = 0.0;
/// let end = integrator.integrate(&mut Leak, 0.0, &[1.0], 0.005, |step| {
///     if (step.t..step.t_end).contains(&0.002) {
///         middle = step.interpolate_all(0.002)[0];
///     }
/// })?;
/// assert!((end[0] - (-5.0_f64).exp()).abs() < 1e-9);
/// assert!((middle - (-2.0_f64).exp()).abs() < 1e-7);
/// # Ok::<(), borescope::internals::numeric::IntegrationError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rosenbrock<const N: usize> {
    options: Options<N>,
    stats: Stats,
    /// The step that the next call starts with (s).
    hint: Option<f64>,
    /// Error of the last accepted step relative to the tolerance, for the proportional part of the control.
    last_error: f64,
}

impl<const N: usize> Rosenbrock<N> {
    /// An integrator without history.
    pub fn new(options: Options<N>) -> Self {
        Self { options, stats: Stats::default(), hint: None, last_error: 1.0 }
    }

    /// The options, to be changed between calls.
    #[cfg(feature = "internals")]
    pub fn options_mut(&mut self) -> &mut Options<N> {
        &mut self.options
    }

    /// The effort so far.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Forgets the step size: the next call starts carefully, as is right behind a switch.
    pub fn restart(&mut self) {
        self.hint = None;
        self.last_error = 1.0;
    }

    /// Integrates a smooth piece from `y0` at `t0` to `t1` (s) and returns the states there; `on_step` sees every accepted
    /// step. Nothing is done if `t1 == t0`.
    ///
    /// # Errors
    ///
    /// See [`IntegrationError`]. The steps shown to `on_step` before the error are good.
    #[cfg(feature = "internals")]
    pub fn integrate<S: Scalar>(
        &mut self,
        system: &mut impl System<S, N>,
        t0: f64,
        y0: &[S; N],
        t1: f64,
        mut on_step: impl FnMut(&Step<'_, S, N>),
    ) -> Result<[S; N], IntegrationError> {
        let arrival = self.integrate_until(system, t0, y0, t1, |step| {
            on_step(step);
            ControlFlow::Continue(())
        })?;
        Ok(arrival.y)
    }

    /// As [`integrate`](Rosenbrock::integrate), until `on_step` returns a break with a time (s) within that step: the
    /// arrival is then the interpolated state at this time. For switches that depend on the state.
    ///
    /// Over dual numbers the state is that at a fixed time: how the moment of the switch depends on the parameters is for
    /// the caller to add.
    ///
    /// # Errors
    ///
    /// As [`integrate`](Rosenbrock::integrate).
    pub fn integrate_until<S: Scalar>(
        &mut self,
        system: &mut impl System<S, N>,
        t0: f64,
        y0: &[S; N],
        t1: f64,
        mut on_step: impl FnMut(&Step<'_, S, N>) -> ControlFlow<f64>,
    ) -> Result<Arrival<S, N>, IntegrationError> {
        if !(t0.is_finite() && t1.is_finite() && t1 >= t0) {
            return Err(IntegrationError::NoInterval { t0, t1 });
        }
        let mut local = Local::new(t0, *y0);
        let mut stages = [[S::zero(); N]; 8];
        let mut error = [0.0; N];
        let n = in_use::<N>(system.states().all);
        while local.t < t1 {
            local.linearise(system)?;
            self.stats.derivatives += 1;
            self.stats.jacobians += 1;
            let t = local.t;
            let rounding = (8.0 * f64::EPSILON * t.abs()).max(f64::MIN_POSITIVE);
            let floor = self.options.h_min.max(rounding);
            let mut wanted = match self.hint {
                Some(h) => h,
                None => first_step(&self.options, &local).max(rounding),
            };
            let mut growth = f64::INFINITY;
            // Tries ever shorter steps from the same point, whose derivative and Jacobian stay valid.
            loop {
                let steps = self.stats.steps + self.stats.rejected;
                if steps >= self.options.max_steps {
                    let worst_state = worst_state(system, &local, wanted, &error);
                    return Err(IntegrationError::TooManySteps { t, steps, worst_state });
                }
                wanted = wanted.min(self.options.h_max);
                let (h, t_end) = fit(t, wanted, t1, self.options.h_max);
                let attempt = attempt(system, &local, &self.options, h, &mut stages, &mut error);
                self.stats.factorisations += 1;
                self.stats.derivatives += if attempt.is_some() { 7 } else { 0 };
                let norm = norm(&error, n);
                if let Some(y1) = attempt.filter(|_| norm <= 1.0) {
                    // The estimate sees real parts only: a derivative may have been lost on the way.
                    if let Some(worst_state) = y1.iter().position(|y| !y.is_finite()) {
                        return Err(IntegrationError::NotFinite { t, worst_state });
                    }
                    self.stats.steps += 1;
                    let proposal = h * factor(norm, self.last_error).min(growth);
                    self.last_error = norm.max(1e-4);
                    // A step cut short to land on the end says little of what the next piece can bear.
                    self.hint = Some(if h < wanted { proposal.max(wanted) } else { proposal });
                    let step = Step::new((t, t_end, h), (&local.y, &y1), &stages, n);
                    if let ControlFlow::Break(at) = on_step(&step) {
                        let y = step.interpolate_all(at);
                        return Ok(Arrival { t: at, y, stopped: true });
                    }
                    local.t = t_end;
                    local.y = y1;
                    break;
                }
                let rejected = self.stats.rejected;
                if rejected >= self.options.max_rejected {
                    let worst_state = worst_state(system, &local, h, &error);
                    return Err(IntegrationError::TooManyRejected { t, rejected, worst_state });
                }
                self.stats.rejected += 1;
                growth = 1.0;
                // Not a number says nothing of how far off the step was.
                let shrink = if norm.is_finite() { factor(norm, self.last_error).min(0.9) } else { 0.5 };
                wanted = h * shrink;
                if wanted < floor {
                    let worst_state = worst_state(system, &local, h, &error);
                    return Err(IntegrationError::StepTooSmall { t, h: wanted, worst_state });
                }
            }
        }
        Ok(Arrival { t: local.t, y: local.y, stopped: false })
    }
}
