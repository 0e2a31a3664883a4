//! The linear step inside the box.

use super::triangle::{Triangle, triangularise};
use nalgebra::DMatrix;

/// What a parameter may do in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hold {
    Free,
    Lower,
    Upper,
    /// Held by the caller, never released.
    Fixed,
}

/// Minimises `|R d + z|^2 + |diag(damping) d|^2` with `room.0 <= d <= room.1`, and `d_j` given for the held ones.
///
/// A primal active-set method: parameters that overshoot are put on their bound, those whose force points back inside are
/// released one by one. The sizes are those of the parameters, not of the data, so exactness costs nothing.
/// Source: Stark and Parker, *Bounded-variable least squares*, Computational Statistics 10 (1995), without its phase 1.
pub(super) fn bounded_step(
    triangle: &Triangle,
    damping: &[f64],
    room: &[(f64, f64)],
    held: &[Option<f64>],
) -> Vec<f64> {
    let p = triangle.len();
    let mut step: Vec<f64> = held.iter().map(|h| h.unwrap_or(0.0)).collect();
    let mut hold: Vec<Hold> = held.iter().map(|h| if h.is_some() { Hold::Fixed } else { Hold::Free }).collect();
    // Two parameters can hand the last free place back and forth by rounding; the step is feasible at every pass.
    for _ in 0..4 * p + 8 {
        solve_free(triangle, damping, &hold, &mut step);
        let mut clipped = false;
        for j in 0..p {
            if hold[j] != Hold::Free {
                continue;
            }
            if step[j] < room[j].0 {
                (step[j], hold[j], clipped) = (room[j].0, Hold::Lower, true);
            } else if step[j] > room[j].1 {
                (step[j], hold[j], clipped) = (room[j].1, Hold::Upper, true);
            }
        }
        if clipped {
            continue;
        }
        let Some(j) = wants_release(triangle, damping, &hold, &step) else {
            break;
        };
        hold[j] = Hold::Free;
    }
    for (d, (lower, upper)) in step.iter_mut().zip(room).zip(held).filter(|(_, h)| h.is_none()).map(|(x, _)| x) {
        *d = d.max(*lower).min(*upper);
    }
    step
}

/// The unconstrained minimiser over the free parameters, the others at their values in `step`.
fn solve_free(triangle: &Triangle, damping: &[f64], hold: &[Hold], step: &mut [f64]) {
    let p = triangle.len();
    let free: Vec<usize> = (0..p).filter(|&j| hold[j] == Hold::Free).collect();
    let n = free.len();
    if n == 0 {
        return;
    }
    let mut right = triangle.z.clone();
    for j in (0..p).filter(|&j| hold[j] != Hold::Free) {
        right.axpy(step[j], &triangle.r.column(j), 1.0);
    }
    // The damping rows go on top, as the triangle that is there already; the rows of R are "below" it.
    let mut work = DMatrix::zeros(n + 1 + p, n + 1);
    for (k, &j) in free.iter().enumerate() {
        work[(k, k)] = damping[j];
        for i in 0..p {
            work[(n + 1 + i, k)] = triangle.r[(i, j)];
        }
    }
    for i in 0..p {
        work[(n + 1 + i, n)] = right[i];
    }
    triangularise(&mut work, n + 1, p);
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|l| work[(k, l)] * step[free[l]]).sum();
        let diagonal = work[(k, k)];
        step[free[k]] = if diagonal == 0.0 { 0.0 } else { -(work[(k, n)] + known) / diagonal };
    }
}

/// The parameter on a bound whose force points inside most strongly, relative to what it could weigh.
fn wants_release(triangle: &Triangle, damping: &[f64], hold: &[Hold], step: &[f64]) -> Option<usize> {
    let moved = &triangle.r * nalgebra::DVector::from_column_slice(step) + &triangle.z;
    let force = triangle.r.tr_mul(&moved);
    let mut best = (1e-12, None);
    for j in 0..step.len() {
        let outward = match hold[j] {
            Hold::Lower => 1.0,
            Hold::Upper => -1.0,
            Hold::Free | Hold::Fixed => continue,
        };
        let slope = (force[j] + damping[j] * damping[j] * step[j]) * outward;
        let weight = triangle.r.column(j).norm() * moved.norm() + damping[j] * damping[j] * step[j].abs();
        if weight > 0.0 && -slope / weight > best.0 {
            best = (-slope / weight, Some(j));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    fn corner() -> Triangle {
        // |d0 + d1 - 3|^2 + |d1 - 1|^2: unbounded minimum at (2, 1)
        Triangle {
            r: DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0]),
            z: DVector::from_vec(vec![-3.0, -1.0]),
            rest: 0.0,
        }
    }

    #[test]
    fn a_bound_shifts_the_others() {
        let open = (f64::NEG_INFINITY, f64::INFINITY);
        let free = bounded_step(&corner(), &[0.0, 0.0], &[open, open], &[None, None]);
        approx::assert_relative_eq!(free[0], 2.0, max_relative = 1e-12);
        let bounded = bounded_step(&corner(), &[0.0, 0.0], &[(-1.0, 1.0), open], &[None, None]);
        approx::assert_relative_eq!(bounded[0], 1.0, max_relative = 1e-12);
        approx::assert_relative_eq!(bounded[1], 1.5, max_relative = 1e-12);
        let held = bounded_step(&corner(), &[0.0, 0.0], &[open, open], &[Some(1.0), None]);
        approx::assert_relative_eq!(held[1], 1.5, max_relative = 1e-12);
    }

    #[test]
    fn a_column_without_influence_stays() {
        let flat = Triangle {
            r: DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.0]),
            z: DVector::from_vec(vec![-3.0, 0.0]),
            rest: 0.0,
        };
        let open = (f64::NEG_INFINITY, f64::INFINITY);
        let step = bounded_step(&flat, &[0.0, 0.1], &[open, open], &[None, None]);
        approx::assert_relative_eq!(step[0], 3.0, max_relative = 1e-12);
        assert_eq!(step[1], 0.0);
    }
}
