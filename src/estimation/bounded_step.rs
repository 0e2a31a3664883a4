//! The linear step inside the box.

use nalgebra::{DMatrix, DVector};

use super::triangle::triangularise;

/// What a parameter does in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hold {
    Free,
    Lower,
    Upper,
}

/// Linear least squares: `|A d + b|^2 + |diag(damping) d|^2`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linear<'a> {
    pub a: &'a DMatrix<f64>,
    pub b: &'a DVector<f64>,
    pub damping: &'a [f64],
}

/// Minimises a linear problem with `slack.0 <= d <= slack.1`, both ends of each of opposite sign or zero.
///
/// A primal active-set method: parameters that overshoot are put on their bound, those whose force points back inside are
/// released one by one. The sizes are those of the parameters, not of the data, so exactness costs nothing.
/// Source: Stark and Parker, *Bounded-variable least squares*, Computational Statistics 10 (1995), without its phase 1.
pub(super) fn bounded_step(linear: Linear<'_>, slack: &[(f64, f64)]) -> Vec<f64> {
    let p = slack.len();
    let mut step = vec![0.0; p];
    let mut hold = vec![Hold::Free; p];
    // Two parameters can hand the last free place back and forth by rounding; the step is feasible at every pass.
    for _ in 0..4 * p + 8 {
        linear.solve_free(&hold, &mut step);
        let mut clipped = false;
        for j in (0..p).filter(|&j| hold[j] == Hold::Free).collect::<Vec<_>>() {
            if step[j] < slack[j].0 {
                (step[j], hold[j], clipped) = (slack[j].0, Hold::Lower, true);
            } else if step[j] > slack[j].1 {
                (step[j], hold[j], clipped) = (slack[j].1, Hold::Upper, true);
            }
        }
        if clipped {
            continue;
        }
        let Some(j) = linear.wants_release(&hold, &step) else { break };
        hold[j] = Hold::Free;
    }
    step.iter().zip(slack).map(|(d, (lower, upper))| d.max(*lower).min(*upper)).collect()
}

impl Linear<'_> {
    /// The unconstrained minimiser over the free parameters, the others at their values in `step`.
    fn solve_free(self, hold: &[Hold], step: &mut [f64]) {
        let (rows, p) = self.a.shape();
        let free: Vec<usize> = (0..p).filter(|&j| hold[j] == Hold::Free).collect();
        let n = free.len();
        if n == 0 {
            return;
        }
        let mut right = self.b.clone();
        for j in (0..p).filter(|&j| hold[j] != Hold::Free) {
            right.axpy(step[j], &self.a.column(j), 1.0);
        }
        // The damping rows go on top, as the triangle that is there already; the rows of `A` are below it.
        let mut work = DMatrix::zeros(n + 1 + rows, n + 1);
        for (k, &j) in free.iter().enumerate() {
            work[(k, k)] = self.damping[j];
            work.view_mut((n + 1, k), (rows, 1)).copy_from(&self.a.column(j));
        }
        work.view_mut((n + 1, n), (rows, 1)).copy_from(&right);
        triangularise(&mut work, n + 1, rows);
        for k in (0..n).rev() {
            let known: f64 = (k + 1..n).map(|l| work[(k, l)] * step[free[l]]).sum();
            let diagonal = work[(k, k)];
            step[free[k]] = if diagonal == 0.0 { 0.0 } else { -(work[(k, n)] + known) / diagonal };
        }
    }

    /// The parameter on a bound whose force points inside most strongly, relative to what it could weigh.
    fn wants_release(self, hold: &[Hold], step: &[f64]) -> Option<usize> {
        let moved = self.a * DVector::from_column_slice(step) + self.b;
        let mut best = (1e-12, None);
        for j in 0..step.len() {
            let outward = match hold[j] {
                Hold::Lower => 1.0,
                Hold::Upper => -1.0,
                Hold::Free => continue,
            };
            let held_back = self.damping[j] * self.damping[j] * step[j];
            let force = (self.a.column(j).dot(&moved) + held_back) * outward;
            let weight = self.a.column(j).norm() * moved.norm() + held_back.abs();
            if weight > 0.0 && -force / weight > best.0 {
                best = (-force / weight, Some(j));
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

    fn step(a: &[f64], b: &[f64], damping: &[f64], slack: &[(f64, f64)]) -> Vec<f64> {
        let (a, b) = (DMatrix::from_row_slice(b.len(), slack.len(), a), DVector::from_row_slice(b));
        bounded_step(Linear { a: &a, b: &b, damping }, slack)
    }

    // |d0 + d1 - 3|^2 + |d1 - 1|^2: unbounded minimum at (2, 1)
    const CORNER: ([f64; 4], [f64; 2]) = ([1.0, 1.0, 0.0, 1.0], [-3.0, -1.0]);

    #[test]
    fn a_bound_shifts_the_others() {
        let free = step(&CORNER.0, &CORNER.1, &[0.0, 0.0], &[OPEN, OPEN]);
        approx::assert_relative_eq!(free[..], [2.0, 1.0][..], max_relative = 1e-12);
        let bounded = step(&CORNER.0, &CORNER.1, &[0.0, 0.0], &[(-1.0, 1.0), OPEN]);
        approx::assert_relative_eq!(bounded[..], [1.0, 1.5][..], max_relative = 1e-12);
    }

    #[test]
    fn a_parameter_that_overshot_at_first_is_released() {
        // The free minimum (2, 1) leaves both bounds; with d1 at its bound d0 wants to lie within its own again.
        let found = step(&CORNER.0, &CORNER.1, &[0.0, 0.0], &[(-1.0, 1.9), (-4.0, -3.0 + 3.5)]);
        approx::assert_relative_eq!(found[..], [1.9, 0.5][..], max_relative = 1e-12);
        // |d0 - d1 - 2|^2 + |d1 - 4|^2 / 100: free minimum (6, 4); with d1 <= 1 it is (3, 1), inside d0 <= 5.
        let found = step(&[1.0, -1.0, 0.0, 0.1], &[-2.0, -0.4], &[0.0, 0.0], &[(-5.0, 5.0), (-5.0, 1.0)]);
        approx::assert_relative_eq!(found[..], [3.0, 1.0][..], max_relative = 1e-9);
    }

    #[test]
    fn damping_shortens_a_step_as_ridge_regression_does() {
        // |2 d - 4|^2 + |3 d|^2: d = 8 / 13
        approx::assert_relative_eq!(step(&[2.0], &[-4.0], &[3.0], &[OPEN])[0], 8.0 / 13.0, max_relative = 1e-12);
    }

    #[test]
    fn a_column_without_influence_stays() {
        let found = step(&[1.0, 0.0, 0.0, 0.0], &[-3.0, 0.0], &[0.0, 0.1], &[OPEN, OPEN]);
        approx::assert_relative_eq!(found[0], 3.0, max_relative = 1e-12);
        assert_eq!(found[1], 0.0);
    }
}
