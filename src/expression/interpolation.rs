//! Lines through knots, differentiable by the argument and by the heights.

use crate::numeric::Real;

/// Broken line through the knots (`at[i]`, `heights[i]`), its ends held outside. `at` grows and has at least two places.
pub(super) fn broken<T: Real>(x: T, at: &[f64], heights: &[T]) -> T {
    match place(x.re(), at) {
        Place::Held(i) => heights[i],
        Place::Between(i) => heights[i] + secant(at, heights, i) * (x - at[i]),
        Place::Nowhere => x,
    }
}

/// Monotone cubic through the knots: between two of them it stays between their heights.
///
/// Slopes at the knots are weighted harmonic means of the neighbouring secants, 0 where these differ in sign. Source: F. N.
/// Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304; ends by three points as in D. Kahaner, C. Moler and
/// S. Nash, Numerical Methods and Software (1988).
pub(super) fn monotone<T: Real>(x: T, at: &[f64], heights: &[T]) -> T {
    match place(x.re(), at) {
        Place::Held(i) => heights[i],
        Place::Between(i) => {
            let (left, right) = (slope(at, heights, i), slope(at, heights, i + 1));
            let secant = secant(at, heights, i);
            let dx = x - at[i];
            let share = dx / (at[i + 1] - at[i]);
            let bend = secant * 3.0 - left * 2.0 - right + (left + right - secant * 2.0) * share;
            heights[i] + dx * (left + bend * share)
        }
        Place::Nowhere => x,
    }
}

pub(super) enum Place {
    /// Outside, held at this knot.
    Held(usize),
    /// Between this knot and the next.
    Between(usize),
    /// The argument is NaN, and so is the answer.
    Nowhere,
}

pub(super) fn place(x: f64, at: &[f64]) -> Place {
    let last = at.len() - 1;
    if x.is_nan() {
        Place::Nowhere
    } else if x < at[0] {
        Place::Held(0)
    } else if x >= at[last] {
        Place::Held(last)
    } else {
        Place::Between(at.partition_point(|knot| *knot <= x) - 1)
    }
}

/// The slopes of the monotone cubic at every knot.
pub(super) fn slopes(at: &[f64], heights: &[f64]) -> Vec<f64> {
    (0..at.len()).map(|i| slope(at, heights, i)).collect()
}

fn secant<T: Real>(at: &[f64], heights: &[T], i: usize) -> T {
    (heights[i + 1] - heights[i]) / (at[i + 1] - at[i])
}

/// The slope of the monotone cubic at knot `i`.
fn slope<T: Real>(at: &[f64], heights: &[T], i: usize) -> T {
    let last = at.len() - 1;
    let width = |i: usize| at[i + 1] - at[i];
    let secant = |i: usize| secant(at, heights, i);
    if last == 1 {
        return secant(0);
    }
    if i == 0 {
        return end(secant(0), secant(1), width(0), width(1));
    }
    if i == last {
        return end(secant(last - 1), secant(last - 2), width(last - 1), width(last - 2));
    }
    let (before, after) = (secant(i - 1), secant(i));
    if !same_sign(before.re(), after.re()) {
        return T::zero();
    }
    let (w, v) = (width(i - 1) + width(i) * 2.0, width(i - 1) * 2.0 + width(i));
    T::constant(w + v) / (T::constant(w) / before + T::constant(v) / after)
}

/// The slope at an end, from the secants of the outer and the next interval and their widths.
fn end<T: Real>(outer: T, next: T, width: f64, next_width: f64) -> T {
    let parabola = (outer * (2.0 * width + next_width) - next * width) / (width + next_width);
    if !same_sign(parabola.re(), outer.re()) {
        T::zero()
    } else if !same_sign(outer.re(), next.re()) && parabola.re().abs() > 3.0 * outer.re().abs() {
        outer * 3.0
    } else {
        parabola
    }
}

fn same_sign(a: f64, b: f64) -> bool {
    (a > 0.0 && b > 0.0) || (a < 0.0 && b < 0.0)
}
