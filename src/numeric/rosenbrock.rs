//! Rodas5P: a Rosenbrock method for stiff smooth pieces of a circuit's motion.

mod coefficients;
mod error;
mod linear;
mod step;

use std::ops::ControlFlow;

use super::Real;

use coefficients::{A2, A3, A4, A5, A6, C, C2, C3, C4, C5, C6, C7, C8, D, GAMMA};
pub use error::IntegrationError;
pub use linear::{Inverse, Scalar};
pub use step::Step;

/// The equations `y' = f(t, y)` of `N` states.
pub trait System<S: Scalar, const N: usize> {
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

/// Accuracy and limits of an integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<const N: usize> {
    /// Relative tolerance: the error of one step is held below `atol + rtol |y|`, root mean square over the states.
    pub rtol: f64,
    /// Absolute tolerance of each state, in its unit; greater than 0 unless the state keeps away from 0.
    pub atol: [f64; N],
    /// The first step after [`Rosenbrock::restart`] (s), or `None` to choose it from the first two derivatives.
    pub h_initial: Option<f64>,
    /// A step that must fall below this (s) is an error. Rounding of `t` sets a floor of its own.
    pub h_min: f64,
    /// No step is longer than this (s).
    pub h_max: f64,
    /// Most steps, accepted and rejected together, in one call of [`Rosenbrock::integrate`].
    pub max_steps: usize,
}

impl<const N: usize> Options<N> {
    /// Tolerances for each state, without other limits than 100,000 steps.
    pub fn new(rtol: f64, atol: [f64; N]) -> Self {
        Self { rtol, atol, h_initial: None, h_min: 0.0, h_max: f64::INFINITY, max_steps: 100_000 }
    }

    /// One absolute tolerance for all states: right only where they are of similar size.
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
    /// Evaluations of the derivative (those within [`System::linearise`] included).
    pub derivatives: usize,
    /// Evaluations of the Jacobian.
    pub jacobians: usize,
    /// Inversions of `W`.
    pub factorisations: usize,
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
/// use borescope::numeric::{Options, Rosenbrock, System};
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
/// # Ok::<(), borescope::numeric::IntegrationError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rosenbrock<const N: usize> {
    options: Options<N>,
    stats: Stats,
    /// The step that the next call starts with (s).
    hint: Option<f64>,
    /// Factor by which the last accepted step's successor may differ, remembered for the proportional part.
    last_error: f64,
}

/// A step is stretched by at most this to land on the end.
const STRETCH: f64 = 1.05;
/// Share of the step that the error estimate allows.
const SAFETY: f64 = 0.9;
/// Bounds on the change of the step size from one to the next.
const SHRINK: f64 = 0.15;
const GROW: f64 = 6.0;
/// Exponents of the error of this step and the one before.
const INTEGRAL: f64 = 0.2;
const PROPORTIONAL: f64 = 0.0;

impl<const N: usize> Rosenbrock<N> {
    /// An integrator without history.
    pub fn new(options: Options<N>) -> Self {
        Self { options, stats: Stats::default(), hint: None, last_error: 1.0 }
    }

    /// The options, to be changed between calls.
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
        let (mut t, mut y) = (t0, *y0);
        if !(t0.is_finite() && t1.is_finite() && t1 >= t0) {
            return Err(IntegrationError::NoInterval { t0, t1 });
        }
        let mut error = [0.0; N];
        let mut tried = 0;
        let mut next = self.hint;
        while t < t1 {
            let local = Local::at(system, t, &y)?;
            self.stats.derivatives += 1;
            self.stats.jacobians += 1;
            let floor = self.options.h_min.max(8.0 * f64::EPSILON * t.abs()).max(f64::MIN_POSITIVE);
            let mut wanted = match next {
                Some(h) => h,
                None => self.first_step(&local, &y).max(floor),
            };
            let mut rejected_before = false;
            // Tries ever shorter steps from the same point, whose derivative and Jacobian stay valid.
            loop {
                if tried >= self.options.max_steps {
                    let worst_state = largest(&error);
                    return Err(IntegrationError::TooManySteps { t, steps: tried, worst_state });
                }
                tried += 1;
                wanted = wanted.min(self.options.h_max);
                let (h, t_end) = fit(t, wanted, t1, self.options.h_max);
                let attempt = self.attempt(system, &local, t, &y, h, &mut error);
                let norm = mean_square(&error).sqrt();
                if let Some((y1, stages)) = attempt.filter(|_| norm <= 1.0) {
                    self.stats.steps += 1;
                    let factor = self.factor(norm);
                    let proposal = h * if rejected_before { factor.min(1.0) } else { factor };
                    self.last_error = norm.max(1e-4);
                    // A step cut short to land on the end says little of what the next piece can bear.
                    let kept = if h < wanted { proposal.max(wanted) } else { proposal };
                    self.hint = Some(kept);
                    next = self.hint;
                    let step = Step::new((t, t_end, h), &y, &y1, &stages);
                    if let ControlFlow::Break(at) = on_step(&step) {
                        let y = step.interpolate_all(at);
                        return Ok(Arrival { t: at, y, stopped: true });
                    }
                    (t, y) = (t_end, y1);
                    break;
                }
                self.stats.rejected += 1;
                rejected_before = true;
                // Not a number says nothing of how far off the step was.
                wanted = h * if norm.is_finite() { self.factor(norm).min(0.9) } else { 0.5 };
                if wanted < floor {
                    let worst_state = largest(&error);
                    return Err(IntegrationError::StepTooSmall { t, h: wanted, worst_state });
                }
            }
        }
        Ok(Arrival { t, y, stopped: false })
    }

    /// One step of length `h`: the new states and the eight stages. `error` becomes each state's estimated error relative
    /// to its tolerance. `None` if `W` cannot be inverted.
    #[inline]
    fn attempt<S: Scalar>(
        &mut self,
        system: &mut impl System<S, N>,
        local: &Local<S, N>,
        t: f64,
        y: &[S; N],
        h: f64,
        error: &mut [f64; N],
    ) -> Option<([S; N], [[S; N]; 8])> {
        let Options { rtol, atol, .. } = &self.options;
        let mut scale = [0.0; N];
        for ((scale, atol), y) in scale.iter_mut().zip(atol).zip(y) {
            *scale = atol + rtol * y.re().abs();
        }
        self.stats.factorisations += 1;
        let Some(inverse) = Inverse::of_shifted(1.0 / (GAMMA * h), &local.jacobian, &scale) else {
            *error = [f64::NAN; N];
            return None;
        };
        self.stats.derivatives += 7;

        let mut stages = Stages { system, local, inverse: &inverse, t, h, k: [[S::zero(); N]; 8] };
        stages.first();
        stages.next(1, &plus(y, &combine(&A2, &stages.k)), &C2);
        stages.next(2, &plus(y, &combine(&A3, &stages.k)), &C3);
        stages.next(3, &plus(y, &combine(&A4, &stages.k)), &C4);
        stages.next(4, &plus(y, &combine(&A5, &stages.k)), &C5);
        let mut y1 = plus(y, &combine(&A6, &stages.k));
        stages.next(5, &y1, &C6);
        y1 = plus(&y1, &stages.k[5]);
        stages.next(6, &y1, &C7);
        y1 = plus(&y1, &stages.k[6]);
        stages.next(7, &y1, &C8);
        y1 = plus(&y1, &stages.k[7]);

        for (i, error) in error.iter_mut().enumerate() {
            let size = y[i].re().abs().max(y1[i].re().abs());
            *error = stages.k[7][i].re() / (atol[i] + rtol * size);
        }
        Some((y1, stages.k))
    }

    /// By how much the step size should change after a step with error `norm` (1 is just allowed).
    fn factor(&self, norm: f64) -> f64 {
        let wish = SAFETY * norm.max(1e-10).powf(-INTEGRAL) * self.last_error.powf(PROPORTIONAL);
        wish.clamp(SHRINK, GROW)
    }

    /// A careful first step, from the size of the first and second derivative (Hairer, Norsett, Wanner, "Solving Ordinary
    /// Differential Equations I", 2nd ed., II.4; the second derivative is exact here, as the Jacobian is at hand).
    fn first_step<S: Scalar>(&self, local: &Local<S, N>, y: &[S; N]) -> f64 {
        if let Some(h) = self.options.h_initial {
            return h;
        }
        let (mut size, mut slope, mut bend) = ([0.0; N], [0.0; N], [0.0; N]);
        for i in 0..N {
            let scale = self.options.atol[i] + self.options.rtol * y[i].re().abs();
            let mut second = local.dfdt[i].re();
            for (j, f) in local.jacobian[i].iter().zip(&local.derivative) {
                second += j.re() * f.re();
            }
            size[i] = y[i].re() / scale;
            slope[i] = local.derivative[i].re() / scale;
            bend[i] = second / scale;
        }
        let [size, slope, bend] = [size, slope, bend].map(|v| mean_square(&v).sqrt());
        let first = if size < 1e-5 || slope < 1e-5 { 1e-6 } else { 0.01 * size / slope };
        let fastest = slope.max(bend);
        let second = if fastest <= 1e-15 { (first * 1e-3).max(1e-6) } else { (0.01 / fastest).powf(0.2) };
        second.min(100.0 * first)
    }
}

/// The equations around the start of a step.
struct Local<S, const N: usize> {
    derivative: [S; N],
    jacobian: [[S; N]; N],
    dfdt: [S; N],
    /// Whether `dfdt` has any entry to add to the stages.
    driven: bool,
}

impl<S: Scalar, const N: usize> Local<S, N> {
    #[inline]
    fn at(system: &mut impl System<S, N>, t: f64, y: &[S; N]) -> Result<Self, IntegrationError> {
        let zero = [S::zero(); N];
        let mut local = Self { derivative: zero, jacobian: [zero; N], dfdt: zero, driven: false };
        system.linearise(t, y, &mut local.derivative, &mut local.jacobian, &mut local.dfdt);
        for (i, row) in local.jacobian.iter().enumerate() {
            // One sum per row: it is finite only if every summand is.
            let mut sum = local.derivative[i].re() * 0.0 + local.dfdt[i].re() * 0.0;
            for entry in row {
                sum += entry.re() * 0.0;
            }
            if sum != 0.0 {
                return Err(IntegrationError::NotFinite { t, worst_state: i });
            }
        }
        local.driven = !local.dfdt.iter().all(|entry| entry.is_zero());
        Ok(local)
    }
}

/// The stages of one step while they are being computed.
struct Stages<'a, S, Y, const N: usize> {
    system: &'a mut Y,
    local: &'a Local<S, N>,
    inverse: &'a Inverse<N>,
    t: f64,
    h: f64,
    k: [[S; N]; 8],
}

impl<S: Scalar, Y: System<S, N>, const N: usize> Stages<'_, S, Y, N> {
    /// The first stage, whose derivative is that at the start.
    #[inline]
    fn first(&mut self) {
        let right = self.local.derivative;
        self.finish(0, right);
    }

    /// Stage `i` at the argument `y`, with row `c` of the coefficients `C`.
    #[inline]
    fn next<const M: usize>(&mut self, i: usize, y: &[S; N], c: &[f64; M]) {
        let mut right = [S::zero(); N];
        self.system.derivative(self.t + C[i] * self.h, y, &mut right);
        let coupling = combine(c, &self.k);
        let per_step = 1.0 / self.h;
        for (right, coupling) in right.iter_mut().zip(&coupling) {
            *right += *coupling * per_step;
        }
        self.finish(i, right);
    }

    #[inline]
    fn finish(&mut self, i: usize, mut right: [S; N]) {
        if self.local.driven && D[i] != 0.0 {
            for (right, dfdt) in right.iter_mut().zip(&self.local.dfdt) {
                *right += *dfdt * (self.h * D[i]);
            }
        }
        self.k[i] = S::solve(self.inverse, &self.local.jacobian, &right);
    }
}

/// The step to take from `t` when `wanted` would suit, and its end. The last step may be a little longer than wanted, and
/// what remains for two is halved, so that no sliver is left over.
#[inline]
fn fit(t: f64, wanted: f64, t1: f64, h_max: f64) -> (f64, f64) {
    let rest = t1 - t;
    if rest <= wanted || (rest <= STRETCH * wanted && rest <= h_max) {
        (rest, t1)
    } else if rest < 2.0 * wanted {
        (0.5 * rest, t + 0.5 * rest)
    } else {
        (wanted, t + wanted)
    }
}

/// `sum c[j] k[j]` over the first `M` stages.
#[inline]
fn combine<S: Real, const N: usize, const M: usize>(c: &[f64; M], k: &[[S; N]; 8]) -> [S; N] {
    let mut sum = [S::zero(); N];
    for (c, k) in c.iter().zip(k) {
        for (sum, k) in sum.iter_mut().zip(k) {
            *sum += *k * *c;
        }
    }
    sum
}

#[inline]
fn plus<S: Scalar, const N: usize>(a: &[S; N], b: &[S; N]) -> [S; N] {
    std::array::from_fn(|i| a[i] + b[i])
}

#[inline]
fn mean_square<const N: usize>(v: &[f64; N]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>() / (N.max(1) as f64)
}

/// The index of the largest magnitude; one that is not a number counts as largest.
fn largest<const N: usize>(v: &[f64; N]) -> usize {
    let mut best = 0;
    for (i, x) in v.iter().enumerate() {
        if x.is_nan() {
            return i;
        }
        if x.abs() > v[best].abs() {
            best = i;
        }
    }
    best
}
