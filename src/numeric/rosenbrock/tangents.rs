//! Derivatives of a solution by parameters, many at once and behind the plain run.
//!
//! Along a solution `y(t)` the derivatives `S` obey `S' = J(t, y) S + df/dp`, which is linear. The method takes this equation
//! along the steps that the plain run took, with the same inverse of `W`. Jacobians along the step and their turning at its
//! start do not depend on the parameter, so they are made once per accepted step; what is left for each parameter is sums
//! of products. Rejected attempts cost nothing.

use super::Step;
use super::coefficients::{A2, A3, A4, A5, A6, C, C2, C3, C4, C5, C6, C7, C8, D, H};
use crate::numeric::wide::wide;

/// The derivatives of a system of `N` states by states and parameters.
pub trait Curved<const N: usize> {
    /// Writes the derivatives of `f(t, y)` by the states into `j[row][column]`, which arrives zeroed, and adds those by the
    /// parameters to `by`.
    fn slopes(&mut self, t: f64, y: &[f64; N], j: &mut [[f64; N]; N], by: &mut Vec<Entry>);

    /// As [`slopes`](Self::slopes), how fast they change there with time while the states move along `direction`, per second.
    fn turning(&mut self, t: f64, y: &[f64; N], direction: &[f64; N], j: &mut [[f64; N]; N], by: &mut Vec<Entry>);
}

/// A derivative of one row by one parameter; several of the same place add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    pub row: usize,
    pub parameter: usize,
    pub value: f64,
}

/// Parameters that are carried side by side.
const WIDTH: usize = 8;
/// Derivatives of one state by as many parameters.
type Row = [f64; WIDTH];
/// Derivatives of all states by as many parameters.
type Block<const N: usize> = [Row; N];

/// Rows of `A` of the stages whose argument is a sum over earlier ones.
const A: [&[f64]; 6] = [&[], &A2, &A3, &A4, &A5, &A6];
/// Rows of `C`.
const COUPLING: [&[f64]; 8] = [&[], &C2, &C3, &C4, &C5, &C6, &C7, &C8];

/// Points of a step where slopes are asked for: the first six stages; the last two share the end with the sixth.
const POINTS: usize = 6;

/// Derivatives of the states by parameters, led along the steps of a plain run.
///
/// They are as accurate as the steps are, of order 5 as these, and not controlled by themselves.
///
/// Source: the variational equation by the method of the plain run; E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary
/// Differential Equations I", 2nd ed., Springer 1993, I.14.
#[derive(Clone, Debug)]
pub struct Tangents<const N: usize> {
    /// At the end of the last step.
    blocks: Vec<Block<N>>,
    /// At its start, and its stages.
    before: Vec<Block<N>>,
    stages: Vec<[Block<N>; 8]>,
    slopes: [Slopes; POINTS],
    turning: Slopes,
    /// Whether the slopes at the end of the last step hold at the start of the next.
    goes_on: bool,
}

/// What is not zero of a matrix of derivatives.
#[derive(Clone, Debug, Default)]
struct Slopes {
    /// Number of entries of each row.
    counts: Vec<usize>,
    /// Column and value, row by row.
    by_state: Vec<(usize, f64)>,
    by_parameter: Vec<Entry>,
}

impl Slopes {
    fn take<const N: usize>(&mut self, fill: impl FnOnce(&mut [[f64; N]; N], &mut Vec<Entry>)) {
        let mut j = [[0.0; N]; N];
        self.counts.clear();
        self.by_state.clear();
        self.by_parameter.clear();
        fill(&mut j, &mut self.by_parameter);
        for entries in &j {
            let before = self.by_state.len();
            let entries = entries.iter().enumerate().filter(|(_, value)| **value != 0.0);
            self.by_state.extend(entries.map(|(column, &value)| (column, value)));
            self.counts.push(self.by_state.len() - before);
        }
    }

    /// Adds the change of all rows when the states change by `argument` and every parameter by one.
    #[inline(always)]
    fn add<const N: usize>(&self, argument: &Block<N>, block: usize, right: &mut Block<N>) {
        let mut entries = self.by_state.iter();
        for (sum, &count) in right.iter_mut().zip(&self.counts) {
            for &(column, value) in entries.by_ref().take(count) {
                axpy(sum, value, &argument[column]);
            }
        }
        for entry in &self.by_parameter {
            if entry.parameter / WIDTH == block {
                right[entry.row][entry.parameter % WIDTH] += entry.value;
            }
        }
    }
}

#[inline(always)]
fn axpy(sum: &mut Row, factor: f64, row: &Row) {
    for (sum, value) in sum.iter_mut().zip(row) {
        *sum += factor * value;
    }
}

/// Adds the weighted stages to every row.
#[inline(always)]
fn add_stages<const N: usize>(sum: &mut Block<N>, weights: &[f64], stages: &[Block<N>; 8]) {
    for (row, sum) in sum.iter_mut().enumerate() {
        for (weight, stage) in weights.iter().zip(stages) {
            axpy(sum, *weight, &stage[row]);
        }
    }
}

/// What a step has for all parameters alike.
struct Shared<'a, const N: usize> {
    h: f64,
    slopes: &'a [Slopes; POINTS],
    turning: &'a Slopes,
    inverse: &'a [[f64; N]; N],
}

wide! {
    /// The derivatives by one block of parameters at the end of a step, from those at its start; leaves their stages.
    fn ended<const N: usize>(
        shared: &Shared<'_, N>,
        block: usize,
        before: &Block<N>,
        stages: &mut [Block<N>; 8],
    ) -> Block<N> {
        let mut turning = [[0.0; WIDTH]; N];
        shared.turning.add(before, block, &mut turning);
        let mut argument = *before;
        for i in 0..8 {
            if i < POINTS {
                argument = *before;
                add_stages(&mut argument, A[i], stages);
            } else {
                for (argument, stage) in argument.iter_mut().zip(&stages[i - 1]) {
                    axpy(argument, 1.0, stage);
                }
            }
            let mut right = [[0.0; WIDTH]; N];
            add_stages(&mut right, COUPLING[i], stages);
            let per_step = 1.0 / shared.h;
            right.iter_mut().flatten().for_each(|value| *value *= per_step);
            shared.slopes[i.min(POINTS - 1)].add(&argument, block, &mut right);
            if D[i] != 0.0 {
                for (right, turning) in right.iter_mut().zip(&turning) {
                    axpy(right, shared.h * D[i], turning);
                }
            }
            for (row, stage) in stages[i].iter_mut().enumerate() {
                let mut sum = [0.0; WIDTH];
                for (column, right) in shared.inverse.iter().zip(&right) {
                    axpy(&mut sum, column[row], right);
                }
                *stage = sum;
            }
        }
        for (argument, stage) in argument.iter_mut().zip(&stages[7]) {
            axpy(argument, 1.0, stage);
        }
        argument
    }
}

impl<const N: usize> Tangents<N> {
    /// From the derivatives `start(state, parameter)` of the initial states by `parameters` parameters.
    pub fn new(parameters: usize, start: impl Fn(usize, usize) -> f64) -> Self {
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
            before: blocks.clone(),
            stages: vec![[[[0.0; WIDTH]; N]; 8]; blocks.len()],
            blocks,
            slopes: Default::default(),
            turning: Slopes::default(),
            goes_on: false,
        }
    }

    /// The equations change between the last step and the next.
    pub fn restart(&mut self) {
        self.goes_on = false;
    }

    /// Goes along one accepted step of `system`'s plain run.
    pub fn advance(&mut self, system: &mut impl Curved<N>, step: &Step<'_, f64, N>) {
        let h = step.h;
        if self.goes_on {
            self.slopes.swap(0, POINTS - 1);
        } else {
            self.slopes[0].take(|j, by| system.slopes(step.t, step.y0, j, by));
        }
        for (slopes, c) in self.slopes.iter_mut().zip(C).skip(1) {
            let (t, y) =
                if c == 1.0 { (step.t_end, *step.y1) } else { (step.t + c * h, step.interpolate_all(step.t + c * h)) };
            slopes.take(|j, by| system.slopes(t, &y, j, by));
        }
        self.goes_on = true;
        self.turning.take(|j, by| system.turning(step.t, step.y0, step.slope(), j, by));
        std::mem::swap(&mut self.before, &mut self.blocks);
        let inverse = step.inverse().columns();
        let shared = Shared { h, slopes: &self.slopes, turning: &self.turning, inverse };
        let blocks = self.before.iter().zip(&mut self.stages).zip(&mut self.blocks);
        for (block, ((before, stages), after)) in blocks.enumerate() {
            *after = ended(&shared, block, before, stages);
        }
    }

    /// Derivatives of `state` by each parameter at the end of the last step.
    pub fn state(&self, state: usize) -> impl Iterator<Item = f64> {
        self.blocks.iter().flat_map(move |block| block[state])
    }

    /// Derivatives of `state` by each parameter at time `t` (s) within the last step, which is `step`, into `out`.
    #[inline]
    pub fn interpolate(&self, step: &Step<'_, f64, N>, t: f64, state: usize, out: &mut [f64]) {
        let s = (t - step.t) / step.h;
        // Weights of the ends and of the stages in the polynomial of order 4.
        let inner = (1.0 - s) * s;
        let weights: [f64; 8] = std::array::from_fn(|k| (H[0][k] + (H[1][k] + H[2][k] * s) * s) * inner);
        let blocks = self.before.iter().zip(&self.blocks).zip(&self.stages);
        for (((before, after), stages), out) in blocks.zip(out.chunks_mut(WIDTH)) {
            let mut sum = [0.0; WIDTH];
            axpy(&mut sum, 1.0 - s, &before[state]);
            axpy(&mut sum, s, &after[state]);
            for (weight, stage) in weights.iter().zip(stages) {
                axpy(&mut sum, *weight, &stage[state]);
            }
            out.copy_from_slice(&sum[..out.len()]);
        }
    }
}
