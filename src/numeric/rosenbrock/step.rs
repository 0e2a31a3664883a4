//! One accepted step and the solution inside it.

use std::array::from_fn;
use std::cell::OnceCell;

use super::coefficients::H;
use super::stages::combine;
use crate::numeric::Real;

/// One accepted step, valid while the integrator's callback runs.
///
/// Inside the step the solution is a polynomial of order 4; its coefficients are computed on first use, because most steps
/// of a stiff start contain no output point.
#[derive(Debug)]
pub struct Step<'a, S, const N: usize> {
    /// Start of the step (s).
    pub t: f64,
    /// End of the step (s); of the last step exactly the end that was asked for.
    pub t_end: f64,
    /// Length of the step (s).
    pub h: f64,
    /// States at the start.
    pub y0: &'a [S; N],
    /// States at the end.
    pub y1: &'a [S; N],
    stages: &'a [[S; N]; 8],
    /// States in use.
    n: usize,
    dense: OnceCell<[[S; N]; 3]>,
}

impl<'a, S: Real, const N: usize> Step<'a, S, N> {
    /// From the time at the start, at the end and between, the states at both, and the stages of the first `n` states.
    #[inline]
    pub(super) fn new(
        (t, t_end, h): (f64, f64, f64),
        (y0, y1): (&'a [S; N], &'a [S; N]),
        stages: &'a [[S; N]; 8],
        n: usize,
    ) -> Self {
        Self { t, t_end, h, y0, y1, stages, n, dense: OnceCell::new() }
    }

    /// The coefficients `D_1, D_2, D_3`, each with one entry per state: with `s = (t - t0)/h`,
    /// `y(s) = (1 - s) y0 + s (y1 + (1 - s) (D_1 + s (D_2 + s D_3)))`.
    #[inline]
    pub fn dense(&self) -> &[[S; N]; 3] {
        self.dense.get_or_init(|| H.map(|weights| combine(&weights, self.stages, self.n)))
    }

    /// State number `i` at time `t` (s) within the step; outside, the polynomial goes on and its error grows fast.
    /// `None` if there is no such state.
    #[inline]
    #[cfg(feature = "internals")]
    pub fn interpolate(&self, t: f64, i: usize) -> Option<S> {
        (i < N).then(|| self.state((t - self.t) / self.h, self.dense(), i))
    }

    /// All states at time `t` (s) within the step.
    #[inline]
    pub fn interpolate_all(&self, t: f64) -> [S; N] {
        let s = (t - self.t) / self.h;
        let dense = self.dense();
        from_fn(|i| self.state(s, dense, i))
    }

    #[inline]
    fn state(&self, s: f64, [d1, d2, d3]: &[[S; N]; 3], i: usize) -> S {
        let bulge = d1[i] + (d2[i] + d3[i] * s) * s;
        self.y0[i] * (1.0 - s) + (self.y1[i] + bulge * (1.0 - s)) * s
    }
}
