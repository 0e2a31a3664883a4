//! The stage equation `W k = b`, with one real elimination per step and a correction for derivatives.

use std::sync::Arc;

use super::sparse::{Elimination, Factors};
use crate::numeric::wide::wide;
use crate::numeric::{Dual, Real, WHOLE, in_use};

/// How many states a system has in an array of more, from the first on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct States {
    /// Those in use.
    pub all: usize,
    /// Those before the followers. A follower depends on coupled states and on itself; no other state depends on it.
    pub coupled: usize,
}

impl States {
    /// So many without a follower.
    pub fn all(states: usize) -> Self {
        Self { all: states, coupled: states }
    }
}

/// A real `N` by `N` matrix, made ready to solve its equations; by reference, since an inverse of many states takes longer to move than to use.
#[derive(Clone, Copy, Debug)]
pub enum Solver<'a, const N: usize> {
    /// Few states: an explicit inverse pays, with eight products per step and none of the serial dependence of a triangular solve.
    Inverse(&'a Inverse<N>),
    /// Many states: most entries are zero, and elimination along the pattern touches a few of each row.
    Sparse(&'a Factors<f64>),
}

impl<const N: usize> Solver<'_, N> {
    /// The solution for the right-hand side `b`.
    #[inline(always)]
    fn solve(self, b: &[f64; N]) -> [f64; N] {
        match self {
            Self::Sparse(factors) if N > WHOLE => {
                let mut x = *b;
                factors.solve(&mut x);
                x
            }
            Self::Inverse(inverse) => inverse.times(b),
            Self::Sparse(_) => [f64::NAN; N],
        }
    }
}

/// `W = diagonal I - J` eliminated along the pattern of many states, where there is one and its pivots are safe.
#[inline(always)]
pub(super) fn along<S: Real, const N: usize>(
    elimination: Option<&Arc<Elimination>>,
    diagonal: f64,
    j: &[[S; N]; N],
    scale: &[f64; N],
) -> Option<Factors<f64>> {
    if N <= WHOLE {
        return None;
    }
    Factors::of(elimination?, scale, |row, column| {
        let own = -j[row][column].re();
        if row == column { own + diagonal } else { own }
    })
}

/// The inverse of a real `N` by `N` matrix.
#[derive(Clone, Debug)]
pub struct Inverse<const N: usize> {
    /// `columns[c][r]` is the entry of row `r`, column `c`: a product runs along memory.
    columns: [[f64; N]; N],
    /// States in use; what is behind them is zero.
    states: usize,
}

impl<const N: usize> Inverse<N> {
    /// Inverts `W = diagonal I - J` from the real part of `j[row][column]`.
    ///
    /// `scale[i] > 0` is the size at which state `i` matters; pivots are compared in these units, so the choice does not
    /// depend on whether a pressure is in Pa or MPa. Only the first `states.all` rows and columns are looked at, and of those
    /// only the first `states.coupled` are eliminated: what follows them is found by substitution.
    /// Returns `None` if `W` is singular or not finite.
    pub fn of_shifted<S: Real>(diagonal: f64, j: &[[S; N]; N], scale: &[f64; N], states: States) -> Option<Self> {
        // Held transposed throughout, since the inverse of the transpose is the transpose of the inverse.
        let mut a = [[0.0; N]; N];
        for (r, row) in j[..states.coupled].iter().enumerate() {
            for (c, value) in row[..states.coupled].iter().enumerate() {
                a[c][r] = -value.re();
            }
            a[r][r] += diagonal;
        }
        if !inverted(&mut a, scale, states.coupled) {
            return None;
        }
        for follower in states.coupled..states.all {
            let per_own = 1.0 / (diagonal - j[follower][follower].re());
            if !per_own.is_finite() {
                return None;
            }
            for (state, slope) in j[follower][..states.coupled].iter().enumerate() {
                // A sensor that lags reads one component: most entries are zero.
                if !slope.is_zero() {
                    let factor = slope.re() * per_own;
                    a[..states.coupled].iter_mut().for_each(|column| column[follower] += factor * column[state]);
                }
            }
            a[follower][follower] = per_own;
        }
        Some(Self { columns: a, states: in_use::<N>(states.all) })
    }

    /// The product of the inverse with `b`.
    #[inline]
    pub fn times(&self, b: &[f64; N]) -> [f64; N] {
        product(&self.columns, b, self.states)
    }
}

wide! {
    /// Inverts the part of a matrix that is in use in place, by Gauss and Jordan with pivots by column; false if it is singular or
    /// not finite.
    pub(super) fn inverted<const N: usize>(a: &mut [[f64; N]; N], scale: &[f64; N], states: usize) -> bool {
        let n = states.min(N);
        let mut swapped_with = [0; N];
        for p in 0..n {
            let mut best = p;
            let mut size = a[p][p].abs() * scale[p];
            for r in p + 1..n {
                let candidate = a[r][p].abs() * scale[r];
                if candidate > size {
                    best = r;
                    size = candidate;
                }
            }
            let reciprocal = 1.0 / a[best][p];
            if !(size > 0.0 && size.is_finite() && reciprocal.is_finite()) {
                return false;
            }
            swapped_with[p] = best;
            if best != p {
                a.swap(p, best);
            }
            if N > WHOLE {
                eliminated(&mut a[..n], p, reciprocal);
                continue;
            }
            // A choice, not a store of one entry: a wide load right behind a narrow store waits for it.
            let with = |row: &[f64; N], entry: f64| std::array::from_fn(|c| if c == p { entry } else { row[c] });
            let pivot_row: [f64; N] = with(&a[p], 1.0).map(|value| value * reciprocal);
            for row in &mut a[..n] {
                let factor = row[p];
                // The matrices of circuits are sparse: most rows have nothing to eliminate.
                if factor != 0.0 {
                    let mut rest: [f64; N] = with(row, 0.0);
                    for (value, pivot) in rest.iter_mut().zip(&pivot_row) {
                        *value -= factor * pivot;
                    }
                    *row = rest;
                }
            }
            a[p] = pivot_row;
        }
        for p in (0..n).rev() {
            let other = swapped_with[p];
            if other != p {
                for row in a[..n].iter_mut() {
                    row.swap(p, other);
                }
            }
        }
        true
    }
}

/// One column of the elimination in a large array, of which few entries are in use and fewer are not zero.
#[inline(always)]
fn eliminated<const N: usize>(a: &mut [[f64; N]], p: usize, reciprocal: f64) {
    let n = a.len();
    a[p][p] = 1.0;
    a[p][..n].iter_mut().for_each(|value| *value *= reciprocal);
    let pivot_row = a[p];
    for (r, row) in a.iter_mut().enumerate() {
        let factor = row[p];
        if r != p && factor != 0.0 {
            row[p] = 0.0;
            row[..n].iter_mut().zip(&pivot_row).for_each(|(value, pivot)| *value -= factor * pivot);
        }
    }
}

wide! {
    fn product<const N: usize>(columns: &[[f64; N]; N], b: &[f64; N], states: usize) -> [f64; N] {
        let n = in_use::<N>(states);
        let mut x = [0.0; N];
        for (column, factor) in columns[..n].iter().zip(b) {
            for (sum, entry) in x[..n].iter_mut().zip(column) {
                *sum += entry * factor;
            }
        }
        x
    }
}

/// What the stage solver needs of a number type beyond [`Real`].
///
/// Implemented for `f64` and, for sensitivities, `Dual<f64, P>`.
pub trait Scalar: Real {
    /// Solves `W k = b` with `W = I/(gamma h) - J`, given the solver of the real part of `W` and `j[row][column] = J`.
    ///
    /// For each direction of a dual number the equation reads `W0 k1 - J1 k0 = b1`, so only the right-hand side changes
    /// and the real elimination serves all directions. The result is the exact derivative of the real solution.
    fn solve<const N: usize>(solver: Solver<'_, N>, j: &[[Self; N]; N], b: &[Self; N]) -> [Self; N];
}

impl Scalar for f64 {
    #[inline]
    fn solve<const N: usize>(solver: Solver<'_, N>, _j: &[[f64; N]; N], b: &[f64; N]) -> [f64; N] {
        solver.solve(b)
    }
}

impl<const P: usize> Scalar for Dual<f64, P> {
    #[inline]
    fn solve<const N: usize>(solver: Solver<'_, N>, j: &[[Self; N]; N], b: &[Self; N]) -> [Self; N] {
        let value = solver.solve(&b.map(|entry| entry.re));
        let mut k = value.map(Self::lift);
        let mut right = [[0.0; P]; N];
        for ((right, row), entry) in right.iter_mut().zip(j).zip(b) {
            let mut sum = entry.eps;
            for (slope, factor) in row.iter().zip(&value) {
                for (sum, slope) in sum.iter_mut().zip(&slope.eps) {
                    *sum += slope * factor;
                }
            }
            *right = sum;
        }
        match solver {
            Solver::Inverse(inverse) => {
                for (column, right) in inverse.columns.iter().zip(&right).take(inverse.states) {
                    for (k, entry) in k.iter_mut().zip(column) {
                        for (sum, right) in k.eps.iter_mut().zip(right) {
                            *sum += entry * right;
                        }
                    }
                }
            }
            Solver::Sparse(_) => {
                for direction in 0..P {
                    let solved = solver.solve(&right.map(|right| right[direction]));
                    k.iter_mut().zip(solved).for_each(|(k, solved)| k.eps[direction] = solved);
                }
            }
        }
        k
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn followers_are_found_by_substitution() {
        // Three coupled states, of which the fourth follows two and the fifth follows one.
        let j = [
            [-3.0, 1.0, 0.5, 0.0, 0.0],
            [2.0, -7.0, 0.0, 0.0, 0.0],
            [0.0, 4.0, -1.5, 0.0, 0.0],
            [5.0, 0.0, -6.0, -20.0, 0.0],
            [0.0, 8.0, 0.0, 0.0, -9.0],
        ];
        let whole = Inverse::of_shifted(2.0, &j, &[1.0; 5], States::all(5)).unwrap();
        let split = Inverse::of_shifted(2.0, &j, &[1.0; 5], States { all: 5, coupled: 3 }).unwrap();
        let b = [1.0, -2.0, 3.0, -4.0, 5.0];
        let k = split.times(&b);
        for (k, expected) in k.iter().zip(whole.times(&b)) {
            approx::assert_relative_eq!(*k, expected, max_relative = 1e-13);
        }
        for (row, b) in j
            .iter()
            .enumerate()
            .map(|(r, row)| (2.0 * k[r] - row.iter().zip(&k).map(|(j, k)| j * k).sum::<f64>(), b[r]))
        {
            approx::assert_relative_eq!(row, b, max_relative = 1e-12);
        }
    }
}
