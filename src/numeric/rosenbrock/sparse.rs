//! Elimination along the pattern of a circuit: what never holds anything is never touched.
//!
//! Circuits are sparse: a pressure meets the few components at its node. The order of the pivots is chosen once per circuit (minimum degree: S. Parter,
//! SIAM Review 3, 1961; W. F. Tinney and J. W. Walker, Proc. IEEE 55, 1967), and pivots stay on the diagonal. That is safe where a
//! circuit is passive, since the equations of a step then take energy in whatever order; where feedback makes it grow, the caller is told.

use std::sync::Arc;

/// Growth of a multiplier, in units of the states, beyond which an elimination is given up: rounding of 1e-16 becomes 1e-10, still far below what steps
/// are controlled to.
const MOST_GROWTH: f64 = 1e6;

/// A column and row that is eliminated: places of its entries among those of the matrix.
#[derive(Clone, Debug)]
struct Pivot {
    state: usize,
    diagonal: usize,
    /// Row and place of each entry below.
    below: Vec<(usize, usize)>,
    /// Column and place of each entry to the right.
    right: Vec<(usize, usize)>,
    /// Where each product of one below and one to the right is taken from, row by row.
    targets: Vec<usize>,
}

/// The order in which the states of a circuit are eliminated, and the entries that this needs.
#[derive(Clone, Debug)]
pub struct Elimination {
    /// Row and column of each entry; those that the circuit has come first.
    entries: Vec<(usize, usize)>,
    own: usize,
    pivots: Vec<Pivot>,
}

impl Elimination {
    /// For `states` states of which `pattern` says which row depends on which column; the diagonal goes without saying.
    pub fn of(states: usize, pattern: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let mut entries: Vec<(usize, usize)> = (0..states).map(|state| (state, state)).chain(pattern).collect();
        entries.sort_unstable();
        entries.dedup();
        let own = entries.len();
        let mut place = vec![vec![None; states]; states];
        for (index, &(row, column)) in entries.iter().enumerate() {
            place[row][column] = Some(index);
        }
        let mut left: Vec<usize> = (0..states).collect();
        let mut pivots = Vec::with_capacity(states);
        let mut neighbours = vec![vec![false; states]; states];
        for &(row, column) in &entries {
            (neighbours[row][column], neighbours[column][row]) = (true, true);
        }
        while !left.is_empty() {
            let degree = |state: usize| left.iter().filter(|&&other| neighbours[state][other]).count();
            let at = (0..left.len()).min_by_key(|&at| degree(left[at])).unwrap_or(0);
            let state = left.remove(at);
            let meets: Vec<usize> = left.iter().copied().filter(|&other| neighbours[state][other]).collect();
            for &a in &meets {
                meets.iter().for_each(|&b| neighbours[a][b] = true);
            }
            let entry = |row: usize, column: usize| place[row][column];
            let below: Vec<(usize, usize)> = left.iter().filter_map(|&row| Some((row, entry(row, state)?))).collect();
            let right: Vec<(usize, usize)> =
                left.iter().filter_map(|&column| Some((column, entry(state, column)?))).collect();
            let mut targets = Vec::with_capacity(below.len() * right.len());
            for &(row, _) in &below {
                for &(column, _) in &right {
                    targets.push(*place[row][column].get_or_insert_with(|| {
                        entries.push((row, column));
                        entries.len() - 1
                    }));
                }
            }
            let diagonal = place[state][state].unwrap_or(0);
            pivots.push(Pivot { state, diagonal, below, right, targets });
        }
        Self { entries, own, pivots }
    }

    /// Row and column of each entry that the circuit has.
    pub fn pattern(&self) -> &[(usize, usize)] {
        &self.entries[..self.own]
    }
}

/// A number of the matrix, or a small matrix of them.
pub trait Element: Copy {
    const ZERO: Self;
    /// What it is multiplied by when an equation is solved.
    type Right: Copy;

    fn inverse(&self) -> Option<Self>;
    fn times(&self, other: &Self) -> Self;
    /// Takes a product away from it.
    fn minus(&mut self, a: &Self, b: &Self);
    fn largest(&self) -> f64;
    fn applied_to(&self, right: &Self::Right) -> Self::Right;
    /// Takes its product with `x` away from a right-hand side.
    fn taken_from(&self, right: &mut Self::Right, x: &Self::Right);
}

impl Element for f64 {
    const ZERO: Self = 0.0;
    type Right = f64;

    #[inline(always)]
    fn inverse(&self) -> Option<Self> {
        let reciprocal = 1.0 / self;
        reciprocal.is_finite().then_some(reciprocal)
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn minus(&mut self, a: &Self, b: &Self) {
        *self -= a * b;
    }

    #[inline(always)]
    fn largest(&self) -> f64 {
        self.abs()
    }

    #[inline(always)]
    fn applied_to(&self, right: &f64) -> f64 {
        self * right
    }

    #[inline(always)]
    fn taken_from(&self, right: &mut f64, x: &f64) {
        *right -= self * x;
    }
}

/// A matrix eliminated along its pattern.
#[derive(Clone, Debug)]
pub struct Factors<E> {
    elimination: Arc<Elimination>,
    /// Multipliers below the diagonal, the inverses of the pivots on it, what is left to the right.
    values: Vec<E>,
}

impl<E: Element> Factors<E> {
    /// Eliminates the matrix of `entry(row, column)`, `scale[i] > 0` being the size at which state `i` matters; `None` where a pivot
    /// is singular or too small for its column.
    pub(super) fn of(elimination: &Arc<Elimination>, scale: &[f64], entry: impl Fn(usize, usize) -> E) -> Option<Self> {
        let mut values: Vec<E> = elimination.pattern().iter().map(|&(row, column)| entry(row, column)).collect();
        values.resize(elimination.entries.len(), E::ZERO);
        for pivot in &elimination.pivots {
            let inverse = values[pivot.diagonal].inverse()?;
            values[pivot.diagonal] = inverse;
            let mut targets = pivot.targets.chunks_exact(pivot.right.len().max(1));
            for &(row, place) in &pivot.below {
                let factor = values[place].times(&inverse);
                // Of what is no number neither holds.
                let is_safe = factor.largest() * scale[pivot.state] <= MOST_GROWTH * scale[row];
                if !is_safe {
                    return None;
                }
                values[place] = factor;
                for (target, (_, right)) in targets.next().into_iter().flatten().zip(&pivot.right) {
                    let right = values[*right];
                    values[*target].minus(&factor, &right);
                }
            }
        }
        Some(Self { elimination: Arc::clone(elimination), values })
    }

    /// Solves in place.
    #[inline]
    pub(super) fn solve(&self, right: &mut [E::Right]) {
        for pivot in &self.elimination.pivots {
            let known = right[pivot.state];
            for &(row, place) in &pivot.below {
                self.values[place].taken_from(&mut right[row], &known);
            }
        }
        for pivot in self.elimination.pivots.iter().rev() {
            let mut own = right[pivot.state];
            for &(column, place) in &pivot.right {
                self.values[place].taken_from(&mut own, &right[column]);
            }
            right[pivot.state] = self.values[pivot.diagonal].applied_to(&own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of states that all meet the first, and the last of which drives the second.
    fn matrix(n: usize) -> Vec<Vec<f64>> {
        let entry = |row: usize, column: usize| match (row, column) {
            (r, c) if r == c => 3.0 + r as f64,
            (0, c) => 0.3 * c as f64,
            (r, 0) => -0.2 * r as f64,
            (r, c) if r == c + 1 => 1.5,
            (1, c) if c == n - 1 => -4.0,
            _ => 0.0,
        };
        (0..n).map(|row| (0..n).map(|column| entry(row, column)).collect()).collect()
    }

    #[test]
    fn the_solution_solves_the_equations_and_little_is_filled() {
        let n = 40;
        let a = matrix(n);
        let places = (0..n).flat_map(|row| (0..n).map(move |column| (row, column)));
        let elimination = Arc::new(Elimination::of(n, places.filter(|&(row, column)| a[row][column] != 0.0)));
        let factors = Factors::of(&elimination, &vec![1.0; n], |row, column| a[row][column]).unwrap();
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut x = b.clone();
        factors.solve(&mut x);
        for (row, b) in a.iter().zip(&b) {
            let sum: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            approx::assert_relative_eq!(sum, *b, epsilon = 1e-12);
        }
        // An arrow with a chain: at most one further entry for each state.
        assert!(elimination.entries.len() <= elimination.pattern().len() + 2 * n, "{}", elimination.entries.len());
    }

    #[test]
    fn a_pivot_that_is_too_small_is_refused() {
        let elimination = Arc::new(Elimination::of(2, [(0, 1), (1, 0)]));
        let is_solved = |pivot: f64| {
            let entry = |row: usize, column: usize| if row == column { pivot } else { 1.0 };
            Factors::of(&elimination, &[1.0; 2], entry).is_some()
        };
        // At 1 nothing is left of the second pivot.
        assert_eq!([2.0, 1e-5, 1e-7, 0.0, 1.0, f64::NAN].map(is_solved), [true, true, false, false, false, false]);
    }
}
