//! The choice of the step size.

use super::stages::Local;
use super::{Options, Scalar};

/// A step is stretched by at most this to land on the end.
const STRETCH: f64 = 1.05;
/// Share of the step that the error estimate allows.
const SAFETY: f64 = 0.9;
/// Bounds on the change of the step size from one to the next.
const SHRINK: f64 = 0.15;
const GROW: f64 = 6.0;
/// Exponents of the error of this step and the one before.
const INTEGRAL: f64 = 0.2;
const PROPORTIONAL: f64 = 0.04;

/// By how much the step size should change after a step with error `norm` (1 is just allowed), given the error `last` of
/// the accepted step before. The small share of the latter damps the alternation of accepted and rejected steps.
pub(super) fn factor(norm: f64, last: f64) -> f64 {
    let wish = SAFETY * norm.max(1e-10).powf(-INTEGRAL) * last.powf(PROPORTIONAL);
    wish.clamp(SHRINK, GROW)
}

/// A careful first step, from the size of the first and second derivative (Hairer, Norsett, Wanner, "Solving Ordinary
/// Differential Equations I", 2nd ed., II.4; the second derivative is exact here, as the Jacobian is at hand).
pub(super) fn first_step<S: Scalar, const N: usize>(options: &Options<N>, local: &Local<S, N>) -> f64 {
    let y = &local.y;
    if let Some(h) = options.h_initial {
        return h;
    }
    let (mut size, mut slope, mut bend) = ([0.0; N], [0.0; N], [0.0; N]);
    for i in 0..N {
        let scale = options.atol[i] + options.rtol * y[i].re().abs();
        let mut second = local.dfdt[i].re();
        for (j, f) in local.jacobian[i].iter().zip(&local.derivative) {
            second += j.re() * f.re();
        }
        size[i] = y[i].re() / scale;
        slope[i] = local.derivative[i].re() / scale;
        bend[i] = second / scale;
    }
    let [size, slope, bend] = [size, slope, bend].map(|v| norm(&v, N));
    let first = if size < 1e-5 || slope < 1e-5 { 1e-6 } else { 0.01 * size / slope };
    let fastest = slope.max(bend);
    let second = if fastest <= 1e-15 { (first * 1e-3).max(1e-6) } else { (0.01 / fastest).powf(0.2) };
    second.min(100.0 * first)
}

/// The step to take from `t` when `wanted` would suit, and its end. The last step may be a little longer than wanted, and
/// what remains for two is halved, so that no sliver is left over.
#[inline]
pub(super) fn fit(t: f64, wanted: f64, t1: f64, h_max: f64) -> (f64, f64) {
    let rest = t1 - t;
    if rest <= wanted || (rest <= STRETCH * wanted && rest <= h_max) {
        (rest, t1)
    } else if rest < 2.0 * wanted {
        (0.5 * rest, t + 0.5 * rest)
    } else {
        (wanted, t + wanted)
    }
}

/// Root of the mean square over so many states.
#[inline]
pub(super) fn norm<const N: usize>(v: &[f64; N], states: usize) -> f64 {
    (v.iter().map(|x| x * x).sum::<f64>() / (states.max(1) as f64)).sqrt()
}
