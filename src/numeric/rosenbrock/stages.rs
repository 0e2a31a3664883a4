//! One attempt at a step: its eight stages.

use super::coefficients::{A2, A3, A4, A5, A6, C, C2, C3, C4, C5, C6, C7, C8, D, GAMMA};
use super::linear::along;
use super::{IntegrationError, Inverse, Options, Scalar, Solver, System};
use crate::numeric::{Real, in_use};

/// A point of the solution and the equations around it: what every attempt at a step from there shares.
pub(super) struct Local<S, const N: usize> {
    pub(super) t: f64,
    pub(super) y: [S; N],
    pub(super) derivative: [S; N],
    pub(super) jacobian: [[S; N]; N],
    pub(super) dfdt: [S; N],
    /// Whether `dfdt` has any entry to add to the stages.
    driven: bool,
}

impl<S: Scalar, const N: usize> Local<S, N> {
    /// A point whose equations have not been asked for yet.
    pub(super) fn new(t: f64, y: [S; N]) -> Self {
        let zero = [S::zero(); N];
        Self { t, y, derivative: zero, jacobian: [zero; N], dfdt: zero, driven: false }
    }

    /// Asks the system for derivative and Jacobian here.
    #[inline(always)]
    pub(super) fn linearise(&mut self, system: &mut impl System<S, N>) -> Result<(), IntegrationError> {
        let n = in_use::<N>(system.states().all);
        for row in &mut self.jacobian[..n] {
            row[..n].fill(S::zero());
        }
        self.dfdt = [S::zero(); N];
        system.linearise(self.t, &self.y, &mut self.derivative, &mut self.jacobian, &mut self.dfdt);
        for (i, row) in self.jacobian[..n].iter().enumerate() {
            // Zero times anything finite is zero, so one sum tells whether all of the row is finite.
            let mut sum = self.derivative[i].re() * 0.0 + self.dfdt[i].re() * 0.0;
            for entry in &row[..n] {
                sum += entry.re() * 0.0;
            }
            if sum != 0.0 {
                return Err(IntegrationError::NotFinite { t: self.t, worst_state: i });
            }
        }
        self.driven = !self.dfdt.iter().all(|entry| entry.is_zero());
        Ok(())
    }
}

/// One step of length `h`: the new states, and the eight stages in `k`. `error` becomes each state's estimated error
/// relative to its tolerance. `None` if `W` cannot be inverted.
#[inline(always)]
pub(super) fn attempt<S: Scalar, const N: usize>(
    system: &mut impl System<S, N>,
    local: &Local<S, N>,
    options: &Options<N>,
    h: f64,
    k: &mut [[S; N]; 8],
    error: &mut [f64; N],
) -> Option<[S; N]> {
    let y = &local.y;
    let tolerance = |i: usize, size: f64| options.atol[i] + options.rtol * size;
    let scale = std::array::from_fn(|i| tolerance(i, y[i].re().abs()));
    *error = [f64::NAN; N];
    let diagonal = 1.0 / (GAMMA * h);
    let sparse = along(system.elimination(), diagonal, &local.jacobian, &scale);
    let inverse;
    let solver = match &sparse {
        Some(factors) => Solver::Sparse(factors),
        None => {
            inverse = Inverse::of_shifted(diagonal, &local.jacobian, &scale, system.states())?;
            Solver::Inverse(&inverse)
        }
    };
    let n = in_use::<N>(system.states().all);

    let mut stages = Stages { system, local, solver, n, h, k };
    stages.first();
    stages.next(1, &plus(y, &combine(&A2, stages.k, n)), &C2);
    stages.next(2, &plus(y, &combine(&A3, stages.k, n)), &C3);
    stages.next(3, &plus(y, &combine(&A4, stages.k, n)), &C4);
    stages.next(4, &plus(y, &combine(&A5, stages.k, n)), &C5);
    let mut y1 = plus(y, &combine(&A6, stages.k, n));
    stages.next(5, &y1, &C6);
    y1 = plus(&y1, &stages.k[5]);
    stages.next(6, &y1, &C7);
    y1 = plus(&y1, &stages.k[6]);
    stages.next(7, &y1, &C8);
    y1 = plus(&y1, &stages.k[7]);

    for (i, error) in error.iter_mut().enumerate() {
        let size = y[i].re().abs().max(y1[i].re().abs());
        *error = k[7][i].re() / tolerance(i, size);
    }
    Some(y1)
}

/// The stages of one step while they are being computed; those not yet reached hold leftovers.
struct Stages<'a, S, Y, const N: usize> {
    system: &'a mut Y,
    local: &'a Local<S, N>,
    solver: Solver<'a, N>,
    /// States in use.
    n: usize,
    h: f64,
    k: &'a mut [[S; N]; 8],
}

impl<S: Scalar, Y: System<S, N>, const N: usize> Stages<'_, S, Y, N> {
    /// The first stage, whose derivative is that at the start.
    #[inline(always)]
    fn first(&mut self) {
        let right = self.local.derivative;
        self.finish(0, right);
    }

    /// Stage `i` at the argument `y`, with row `c` of the coefficients `C`.
    #[inline(always)]
    fn next<const M: usize>(&mut self, i: usize, y: &[S; N], c: &[f64; M]) {
        let mut right = [S::zero(); N];
        self.system.derivative(self.local.t + C[i] * self.h, y, &mut right);
        let coupling = combine(c, self.k, self.n);
        let per_step = 1.0 / self.h;
        for (right, coupling) in right.iter_mut().zip(&coupling) {
            *right += *coupling * per_step;
        }
        self.finish(i, right);
    }

    #[inline(always)]
    fn finish(&mut self, i: usize, mut right: [S; N]) {
        if self.local.driven && D[i] != 0.0 {
            for (right, dfdt) in right.iter_mut().zip(&self.local.dfdt) {
                *right += *dfdt * (self.h * D[i]);
            }
        }
        self.k[i] = S::solve(self.solver, &self.local.jacobian, &right);
    }
}

/// `sum c[j] k[j]` over the first `M` stages, of the first `n` states.
#[inline(always)]
pub(super) fn combine<S: Real, const N: usize, const M: usize>(c: &[f64; M], k: &[[S; N]; 8], n: usize) -> [S; N] {
    let mut sum = [S::zero(); N];
    for (c, k) in c.iter().zip(k) {
        for (sum, k) in sum[..n].iter_mut().zip(k) {
            *sum += *k * *c;
        }
    }
    sum
}

#[inline(always)]
fn plus<S: Scalar, const N: usize>(a: &[S; N], b: &[S; N]) -> [S; N] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// The state that spoiled the attempt of length `h`: the one with the largest error, or, where the error is no number,
/// the first whose derivative is not finite along the tangent of the step.
#[cold]
pub(super) fn worst_state<S: Scalar, const N: usize>(
    system: &mut impl System<S, N>,
    local: &Local<S, N>,
    h: f64,
    error: &[f64; N],
) -> usize {
    let mut best = 0;
    for (i, value) in error.iter().enumerate() {
        if value.abs() > error[best].abs() {
            best = i;
        }
    }
    if error.iter().all(|value| value.is_finite()) {
        return best;
    }
    // The solve spreads one NaN over all states, so the error itself does not tell where it arose.
    let mut derivative = [S::zero(); N];
    for share in C {
        let y = std::array::from_fn(|i| local.y[i] + local.derivative[i] * (share * h));
        system.derivative(local.t + share * h, &y, &mut derivative);
        if let Some(i) = derivative.iter().position(|value| !value.re().is_finite()) {
            return i;
        }
    }
    best
}
