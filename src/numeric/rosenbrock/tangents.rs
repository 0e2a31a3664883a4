//! Derivatives of a solution by parameters, many at once and behind the plain run.
//!
//! Along a solution `y(t)` the derivatives `S` obey `S' = J(t, y) S + df/dp`, which is linear: an implicit method needs no
//! iteration. Jacobians along the step do not depend on the parameter, so they are made and eliminated once per accepted step;
//! what is left for each parameter is sums of products. Rejected attempts cost nothing.

use std::sync::Arc;

use super::Step;
use super::linear::inverted;
use super::sparse::{Element, Elimination, Factors};
use super::stagewise::{Row, STAGES, Stagewise, WIDTH, axpy};
use crate::numeric::wide::wide;
use crate::numeric::{WHOLE, in_use};

/// The derivatives of a system of `N` states by states and parameters.
pub trait Curved<const N: usize> {
    /// How many states are in use, from the first on.
    fn states(&self) -> usize {
        N
    }

    /// Along which pattern the equations of a step are eliminated, where that is known and pays.
    fn elimination(&self) -> Option<&Arc<Elimination>> {
        None
    }

    /// Writes the derivatives of `f(t, y)` by the states into `j[row][column]`, which arrives zeroed, and adds those by the
    /// parameters to `by`.
    fn slopes(&mut self, t: f64, y: &[f64; N], j: &mut [[f64; N]; N], by: &mut Vec<Entry>);
}

/// A derivative of one row by one parameter; several of the same place add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Index of the row.
    pub row: usize,
    /// Index of the parameter among those that are led along.
    pub parameter: usize,
    /// The derivative.
    pub value: f64,
}

/// Derivatives of all states by as many parameters.
type Block<const N: usize> = [Row; N];

/// Stage times, as fractions of the step.
const C: [f64; STAGES] = [0.155_051_025_721_682_2, 0.644_948_974_278_317_8, 1.0];
/// Weights of the stages.
const B: [f64; STAGES] = [0.376_403_062_700_467_3, 0.512_485_826_188_421_6, 0.111_111_111_111_111_1];
/// The inverse of the method's matrix.
const A: [[f64; STAGES]; STAGES] = [
    [3.224_744_871_391_589, 1.167_840_084_690_405_5, -0.253_197_264_742_180_8],
    [-3.567_840_084_690_405_5, 0.775_255_128_608_411, 1.053_197_264_742_180_8],
    [5.531_972_647_421_808, -7.531_972_647_421_808, 5.0],
];

/// Derivatives of the states by parameters, led along the steps of a plain run.
///
/// The method is Radau IIA with three stages: order 5, stiffly accurate and L-stable, dense output of order 3. Its error is
/// not controlled: steps that follow the solution to a tolerance follow its derivatives about as well.
///
/// Where a kink within a step opens or shuts a loop of two states, such as a valve that leans on its seat, stages on both sides of it would feed each other
/// and grow. There all stages have the mean Jacobian, of which the method is L-stable. Steps that lie on one side each may still grow.
///
/// Source: E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", 2nd ed., Springer 1996, table IV.5.6.
#[derive(Clone, Debug)]
pub struct Tangents<const N: usize> {
    /// Sizes at which states matter.
    scale: [f64; N],
    /// At the end of the last step.
    blocks: Vec<Block<N>>,
    /// At its start, and at its stages.
    before: Vec<Block<N>>,
    stages: Vec<[Block<N>; STAGES]>,
    /// Derivatives by parameters at each stage.
    by: [Vec<Entry>; STAGES],
    /// Derivatives by the states at each stage, then [`ELIMINATED`]: on the heap, since those of a plant would fill a thread's stack.
    matrices: Vec<Matrix<N>>,
}

/// A matrix, column by column.
type Matrix<const N: usize> = [[f64; N]; N];

/// Matrices of the equations of the stages, `(A/h - J) Z = right`, with one stage eliminated after the other: the inverses of what is
/// left of each diagonal block, and what is left of the blocks right of the second and below it.
const ELIMINATED: usize = STAGES + 2;

/// An entry of the Jacobian that falls to this share of what it is at another stage, or turns its sign, has met a kink.
const VANISHED: f64 = 0.1;

/// Whether the Jacobian has a kink within a step of length `h` that opens or shuts a loop of two states, one that is answered within
/// the step. A state that acts on itself alone cannot grow: where it is stiff it stays small, and at the other stages it is the
/// method's own. `places` are rows and columns of all entries.
fn kinked<const N: usize>(h: f64, j: &[Matrix<N>], mut places: impl Iterator<Item = (usize, usize)>) -> bool {
    let ends = |row: usize, column: usize| {
        let at = |stage: usize| j[stage][row][column];
        let (low, high) = (at(0).min(at(1)).min(at(2)), at(0).max(at(1)).max(at(2)));
        if low.abs() < high.abs() { (low, high) } else { (high, low) }
    };
    let opens = |(row, column): (usize, usize)| {
        let (least, most) = ends(row, column);
        let back = ends(column, row).1;
        row != column && least / most < VANISHED && h * h * ((most - least) * back).abs() > 1.0
    };
    places.any(opens)
}

/// Gives all stages the mean Jacobian of the step.
fn level<const N: usize>(j: &mut [Matrix<N>], places: impl Iterator<Item = (usize, usize)>) {
    for (row, column) in places {
        let mean: f64 = B.iter().zip(j.iter()).map(|(weight, j)| weight * j[row][column]).sum();
        j.iter_mut().for_each(|j| j[row][column] = mean);
    }
}

/// Rows and columns of a full matrix.
fn all(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |row| (0..n).map(move |column| (row, column)))
}

wide! {
    /// Eliminates stage by stage; false if that is singular. `j[stage][row][column]`.
    fn eliminate<const N: usize>(
        h: f64,
        j: &[Matrix<N>],
        scale: &[f64; N],
        states: usize,
        eliminated: &mut [Matrix<N>],
    ) -> bool {
        let n = in_use::<N>(states);
        for (stage, block) in eliminated[..STAGES].iter_mut().enumerate() {
            for (column, entries) in block[..n].iter_mut().enumerate() {
                for (row, entry) in entries[..n].iter_mut().enumerate() {
                    *entry = -j[stage][row][column];
                }
                entries[column] += A[stage][stage] / h;
            }
        }
        let [first, second, third, right, below] = eliminated else { return false };
        if !inverted(first, scale, n) {
            return false;
        }
        let per = 1.0 / (h * h);
        for column in 0..n {
            for row in 0..n {
                let known = first[column][row] * per;
                second[column][row] -= A[1][0] * A[0][1] * known;
                right[column][row] = -A[1][0] * A[0][2] * known;
                below[column][row] = -A[2][0] * A[0][1] * known;
                third[column][row] -= A[2][0] * A[0][2] * known;
            }
            right[column][column] += A[1][2] / h;
            below[column][column] += A[2][1] / h;
        }
        if !inverted(second, scale, n) {
            return false;
        }
        for column in 0..n {
            let mut through = [0.0; N];
            for (factor, entries) in right[column][..n].iter().zip(second.iter()) {
                through[..n].iter_mut().zip(entries).for_each(|(sum, entry)| *sum += factor * entry);
            }
            for (factor, entries) in through[..n].iter().zip(below.iter()) {
                third[column][..n].iter_mut().zip(entries).for_each(|(sum, entry)| *sum -= factor * entry);
            }
        }
        inverted(third, scale, n)
    }
}

#[inline(always)]
fn product<const N: usize>(matrix: &Matrix<N>, block: &Block<N>, states: usize) -> Block<N> {
    let n = in_use::<N>(states);
    let mut result = [[0.0; WIDTH]; N];
    for (row, sum) in result[..n].iter_mut().enumerate() {
        for (column, factors) in matrix[..n].iter().zip(block) {
            axpy(sum, column[row], factors);
        }
    }
    result
}

/// `a + factor b`.
#[inline(always)]
fn plus<const N: usize>(mut a: Block<N>, factor: f64, b: &Block<N>) -> Block<N> {
    for (a, b) in a.iter_mut().zip(b) {
        axpy(a, factor, b);
    }
    a
}

/// What is known of the equations of the stages of a step of length `h` for one block of parameters: the derivatives at its start, and those of
/// the equations by the parameters. `n` states are in use.
#[inline(always)]
fn known<const N: usize>(
    h: f64,
    n: usize,
    by: &[Vec<Entry>; STAGES],
    block: usize,
    before: &Block<N>,
) -> [Block<N>; STAGES] {
    let mut known = [[[0.0; WIDTH]; N]; STAGES];
    for ((known, weights), by) in known.iter_mut().zip(&A).zip(by) {
        let per_step = weights.iter().sum::<f64>() / h;
        known[..n].iter_mut().zip(before).for_each(|(known, before)| axpy(known, per_step, before));
        for entry in by {
            if entry.parameter / WIDTH == block {
                known[entry.row][entry.parameter % WIDTH] += entry.value;
            }
        }
    }
    known
}

wide! {
    /// The derivatives by one block of parameters at the stages of a step of length `h`, from what is known of them.
    fn staged<const N: usize>(
        h: f64,
        eliminated: &[Matrix<N>],
        states: usize,
        known: &[Block<N>; STAGES],
    ) -> [Block<N>; STAGES] {
        let product = |matrix: usize, block: &Block<N>| product(&eliminated[matrix], block, states);
        let (right, below) = (STAGES, STAGES + 1);
        let first = product(0, &known[0]);
        let second = product(1, &plus(known[1], -A[1][0] / h, &first));
        let rest = plus(plus(known[2], -A[2][0] / h, &first), -1.0, &product(below, &second));
        let third = product(2, &rest);
        let second = plus(second, -1.0, &product(1, &product(right, &third)));
        let rest = plus(plus(known[0], -A[0][1] / h, &second), -A[0][2] / h, &third);
        [product(0, &rest), second, third]
    }
}

/// The equations of the stages, `(A/h - J) Z = right`, eliminated state by state along the pattern of the circuit.
fn along<const N: usize>(
    elimination: &Arc<Elimination>,
    h: f64,
    j: &[Matrix<N>],
    scale: &[f64; N],
) -> Option<Factors<Stagewise>> {
    Factors::of(elimination, scale, |row, column| {
        let mut entry = if row == column { A.map(|weights| weights.map(|weight| weight / h)) } else { Stagewise::ZERO };
        for (stage, j) in j.iter().enumerate() {
            entry[stage][stage] -= j[row][column];
        }
        entry
    })
}

wide! {
    /// The same as [`staged`] from equations that were eliminated along the pattern.
    fn staged_along<const N: usize>(
        factors: &Factors<Stagewise>,
        n: usize,
        known: &[Block<N>; STAGES],
    ) -> [Block<N>; STAGES] {
        let mut rows: Vec<[Row; STAGES]> = (0..n).map(|state| std::array::from_fn(|stage| known[stage][state])).collect();
        factors.solve(&mut rows);
        let mut stages = [[[0.0; WIDTH]; N]; STAGES];
        for (state, row) in rows.iter().enumerate() {
            stages.iter_mut().zip(row).for_each(|(stage, row)| stage[state] = *row);
        }
        stages
    }
}

impl<const N: usize> Tangents<N> {
    /// From the derivatives `start(state, parameter)` of the initial states by `parameters` parameters. `scale[i] > 0` is the
    /// size at which state `i` matters.
    pub fn new(parameters: usize, scale: [f64; N], start: impl Fn(usize, usize) -> f64) -> Self {
        let blocks = (0..parameters.div_ceil(WIDTH)).map(|block| {
            std::array::from_fn(|state| {
                std::array::from_fn(|lane| {
                    let parameter = block * WIDTH + lane;
                    if parameter < parameters { start(state, parameter) } else { 0.0 }
                })
            })
        });
        let blocks: Vec<Block<N>> = blocks.collect();
        Self {
            scale,
            before: blocks.clone(),
            stages: vec![[[[0.0; WIDTH]; N]; STAGES]; blocks.len()],
            blocks,
            by: Default::default(),
            matrices: vec![[[0.0; N]; N]; STAGES + ELIMINATED],
        }
    }

    /// Goes along one accepted step of `system`'s plain run. Where the method's equations are singular, all become NaN.
    pub fn advance(&mut self, system: &mut impl Curved<N>, step: &Step<'_, f64, N>) {
        let n = in_use::<N>(system.states());
        let (j, eliminated) = self.matrices.split_at_mut(STAGES);
        for ((c, j), by) in C.iter().zip(j.iter_mut()).zip(&mut self.by) {
            j[..n].iter_mut().for_each(|row| row[..n].fill(0.0));
            let (t, y) = match step.t + c * step.h {
                t if *c < 1.0 => (t, step.interpolate_all(t)),
                _ => (step.t_end, *step.y1),
            };
            by.clear();
            system.slopes(t, &y, j, by);
        }
        let elimination = system.elimination().filter(|_| N > WHOLE);
        let kinked = match elimination {
            Some(elimination) => kinked(step.h, j, elimination.pattern().iter().copied()),
            None => kinked(step.h, j, all(n)),
        };
        if kinked {
            level(j, all(n));
        }
        std::mem::swap(&mut self.before, &mut self.blocks);
        let sparse = elimination.and_then(|elimination| along(elimination, step.h, j, &self.scale));
        let regular = sparse.is_some() || eliminate(step.h, j, &self.scale, n, eliminated);
        for (block, before) in self.before.iter().enumerate() {
            let known = known(step.h, n, &self.by, block, before);
            let stages = &mut self.stages[block];
            *stages = match &sparse {
                Some(factors) => staged_along(factors, n, &known),
                None if regular => staged(step.h, eliminated, n, &known),
                None => [[[f64::NAN; WIDTH]; N]; STAGES],
            };
            self.blocks[block] = stages[STAGES - 1];
        }
    }

    /// Derivatives of `state` by each parameter at the end of the last step.
    pub fn state(&self, state: usize) -> impl Iterator<Item = f64> {
        self.blocks.iter().flat_map(move |block| block[state])
    }

    /// Derivatives of some states by each parameter at time `t` (s) within the last step, which is `step`, into `out[state]`.
    #[inline]
    pub fn interpolate(&self, step: &Step<'_, f64, N>, t: f64, states: &[usize], out: &mut [Vec<f64>]) {
        let s = (t - step.t) / step.h;
        // The polynomial through the start and the stages.
        let weights: [f64; STAGES] = std::array::from_fn(|k| {
            let others = (0..STAGES).filter(|other| *other != k);
            others.map(|other| (s - C[other]) / (C[k] - C[other])).product::<f64>() * s / C[k]
        });
        let at_start = C.iter().map(|c| (c - s) / c).product::<f64>();
        for &state in states {
            let parts = out[state].chunks_mut(WIDTH);
            for ((before, stages), out) in self.before.iter().zip(&self.stages).zip(parts) {
                let mut sum = [0.0; WIDTH];
                axpy(&mut sum, at_start, &before[state]);
                for (weight, stage) in weights.iter().zip(stages) {
                    axpy(&mut sum, *weight, &stage[state]);
                }
                out.copy_from_slice(&sum[..out.len()]);
            }
        }
    }
}
