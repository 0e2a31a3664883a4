//! Tables of numbers that formulas call like functions, one for each column: measured or computed elsewhere.

use super::interpolation::{Place, place, slopes};
use crate::numeric::Real;
use crate::units::Dimension;

/// A column over one or two others, in SI. Outside its knots it holds its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// As a formula calls it, such as `lever.ratio`.
    pub name: String,
    /// What its arguments measure: one or two.
    pub arguments: Vec<Dimension>,
    /// What it gives.
    pub gives: Dimension,
    /// Knots of the first argument, and of the second if there is one; they grow.
    x: Vec<f64>,
    y: Vec<f64>,
    /// At each `x` one, or one for each `y`.
    heights: Vec<f64>,
    /// At each `x`, of a smooth line.
    slopes: Vec<f64>,
}

impl Sheet {
    /// A line through knots that grow, at least two: broken, or smooth without overshoot.
    pub fn line(name: String, dimensions: [Dimension; 2], x: Vec<f64>, heights: Vec<f64>, smooth: bool) -> Self {
        let slopes = if smooth { slopes(&x, &heights) } else { Vec::new() };
        let [argument, gives] = dimensions;
        Self { name, arguments: vec![argument], gives, x, y: Vec::new(), heights, slopes }
    }

    /// A surface over a grid of knots that grow, at least two each way; between them bilinear. `heights` has all `y` of the first
    /// `x`, then those of the next.
    pub fn surface(name: String, dimensions: [Dimension; 3], x: Vec<f64>, y: Vec<f64>, heights: Vec<f64>) -> Self {
        let [first, second, gives] = dimensions;
        Self { name, arguments: vec![first, second], gives, x, y, heights, slopes: Vec::new() }
    }

    /// The value over one argument or two.
    pub(super) fn evaluate<T: Real>(&self, arguments: &[T]) -> T {
        let (i, share) = within(arguments[0], &self.x);
        let Some(&second) = arguments.get(1) else {
            let (left, right) = (self.heights[i], self.heights[i + 1]);
            if self.slopes.is_empty() {
                return share * (right - left) + left;
            }
            // The cubic of two heights and two slopes.
            let width = self.x[i + 1] - self.x[i];
            let (from, to) = (self.slopes[i] * width, self.slopes[i + 1] * width);
            let rise = right - left;
            let bend = share * (from + to - 2.0 * rise) + (3.0 * rise - 2.0 * from - to);
            return share * (share * bend + from) + left;
        };
        let (j, along) = within(second, &self.y);
        let height = |i: usize, j: usize| self.heights[i * self.y.len() + j];
        let edge = |i: usize| along * (height(i, j + 1) - height(i, j)) + height(i, j);
        let (low, high) = (edge(i), edge(i + 1));
        low + share * (high - low)
    }
}

/// Between which knots, and at which share of the way.
fn within<T: Real>(x: T, at: &[f64]) -> (usize, T) {
    match place(x.re(), at) {
        Place::Held(0) => (0, T::zero()),
        Place::Held(last) => (last - 1, T::constant(1.0)),
        Place::Between(i) => (i, (x - at[i]) * (1.0 / (at[i + 1] - at[i]))),
        Place::Nowhere => (0, x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dual;

    #[test]
    fn a_smooth_line_is_the_one_of_a_curve_with_its_slope() {
        let (x, heights) = (vec![0.0, 1.0, 2.5, 4.0], vec![0.0, 2.0, 2.5, -1.0]);
        let sheet = Sheet::line("a.b".into(), [Dimension::NONE; 2], x.clone(), heights.clone(), true);
        for at in [-1.0, 0.0, 0.3, 1.0, 2.0, 3.9, 4.0, 5.0] {
            let argument = Dual::<f64, 1>::variable(at, 0);
            let curve = super::super::interpolation::monotone(
                argument,
                &x,
                &heights.iter().map(|h| Dual::constant(*h)).collect::<Vec<_>>(),
            );
            let own = sheet.evaluate(&[argument]);
            assert!((own.re - curve.re).abs() < 1e-12 && (own.eps[0] - curve.eps[0]).abs() < 1e-12, "{at}");
        }
    }

    #[test]
    fn a_surface_is_exact_for_a_bilinear_one_and_held_outside() {
        let law = |x: f64, y: f64| 1.0 + 2.0 * x - y + 0.5 * x * y;
        let (x, y) = (vec![0.0, 1.0, 3.0], vec![-1.0, 2.0]);
        let heights = x.iter().flat_map(|&x| y.iter().map(move |&y| law(x, y))).collect();
        let sheet = Sheet::surface("a.b".into(), [Dimension::NONE; 3], x, y, heights);
        assert!((sheet.evaluate(&[2.2, 0.4]) - law(2.2, 0.4)).abs() < 1e-12);
        assert!((sheet.evaluate(&[9.0, 5.0]) - law(3.0, 2.0)).abs() < 1e-12);
    }
}
