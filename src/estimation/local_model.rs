//! The local quadratic model: what the cost of a record looks like around one point, for every subset of parameters at once.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::criteria::occam;
use super::prior::Gaussian;
use super::problem::{Linearised, Problem, Space, scale};
use super::triangle::Triangle;
use super::{FitError, Loss, ScoreTest, long_run_variance};
use crate::numeric::dot;

/// Share of the largest influence that every parameter is given, so that a direction without influence stays where it is:
/// the root of what double precision resolves in a sum of squares.
const TRACE: f64 = 1e-8;

/// `sum rho(r^2)` of a record as Gauss and Newton model it around one point. The prior is no part of it: which parameters
/// are held, and what is known of them, is the matter of each [`Problem`] that asks.
///
/// Parameters are in units of their scales, so that they can be compared.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalModel {
    /// Where it was taken, in the units of the parameters.
    pub theta: Vec<f64>,
    /// Misfits there.
    pub misfit: Vec<f64>,
    /// One per parameter.
    pub scale: Vec<f64>,
    pub loss: Loss,
    /// Rows of misfits, columns of all parameters, per scale.
    jacobian: DMatrix<f64>,
    /// Of the Jacobian and the misfits, each row times the root of its weight.
    triangle: Triangle,
}

impl LocalModel {
    /// Linearises a problem at `theta`.
    ///
    /// # Errors
    /// The model fails there, or its misfits or sensitivities are not finite; the message names the parameter.
    pub fn at<P: Problem>(problem: &P, theta: &[f64], loss: Loss) -> Result<Self, FitError> {
        Self::of(problem, theta, problem.linearise(theta).map_err(FitError::start)?, loss)
    }

    /// From the misfits of a problem and their derivatives at `theta`.
    ///
    /// # Errors
    /// Shapes that do not agree, or numbers that are not finite; the message names the parameter.
    pub fn of<P: Problem>(problem: &P, theta: &[f64], linearised: Linearised, loss: Loss) -> Result<Self, FitError> {
        linearised.check(theta.len(), |parameter| problem.name(parameter))?;
        let scale = scale(problem);
        let Linearised { misfit, mut jacobian } = linearised;
        for (mut column, scale) in jacobian.column_iter_mut().zip(&scale) {
            column *= *scale;
        }
        let triangle = Triangle::reduce(&jacobian, &misfit, loss);
        Ok(Self { theta: theta.to_vec(), misfit, scale, loss, jacobian, triangle })
    }

    /// Number of parameters.
    pub fn count(&self) -> usize {
        self.scale.len()
    }

    /// The triangle of the Jacobian.
    pub(super) fn triangle(&self) -> &Triangle {
        &self.triangle
    }

    /// Logarithm of the share of its prior volume that the record leaves what is known before it; see [`occam`].
    pub fn occam(&self, prior: &Gaussian) -> f64 {
        let mut columns = self.triangle.r.select_columns(&prior.members);
        for (mut column, &member) in columns.column_iter_mut().zip(&prior.members) {
            column /= self.scale[member];
        }
        occam(columns * prior.root())
    }

    /// Derivatives of the misfits by the parameters, per scale.
    pub fn jacobian(&self) -> &DMatrix<f64> {
        &self.jacobian
    }

    /// Half the derivative of the cost by the parameters, per scale, at other misfits, along the Jacobian from here.
    pub fn gradient(&self, misfit: &[f64]) -> DVector<f64> {
        let pull: Vec<f64> = misfit.iter().map(|&r| r * self.loss.weight(r)).collect();
        self.transposed_times(&pull)
    }

    /// The product of the transposed Jacobian with a series of misfits.
    pub(super) fn transposed_times(&self, series: &[f64]) -> DVector<f64> {
        let columns = self.jacobian.as_slice().chunks_exact(series.len().max(1));
        DVector::from_iterator(self.count(), columns.map(|column| dot(column, series)))
    }

    /// The same of a problem, with what its prior says at `theta`.
    pub fn gradient_of<P: Problem>(&self, problem: &P, theta: &[f64], misfit: &[f64]) -> DVector<f64> {
        let mut gradient = self.gradient(misfit);
        if let Some(prior) = problem.prior() {
            let own = prior.jacobian(self.count()).tr_mul(&prior.misfit(theta));
            gradient += own.component_mul(&DVector::from_column_slice(&self.scale));
        }
        gradient
    }

    /// Half the derivative of the cost along something that moves the misfits so, at those here.
    pub fn pull(&self, influence: &DVector<f64>) -> f64 {
        influence.iter().zip(&self.misfit).map(|(by, &r)| by * r * self.loss.weight(r)).sum()
    }

    /// Record and prior of a problem over some parameters, as one triangle per scale. Its right-hand side holds where
    /// `theta` is where the model was taken.
    pub(super) fn joined<P: Problem>(&self, problem: &P, theta: &[f64], free: &[usize]) -> Triangle {
        let (p, n) = (self.count(), free.len());
        let rows = problem.prior().map_or(0, |prior| prior.len());
        let mut joined = DMatrix::zeros(p + 1 + rows, n + 1);
        for (k, &j) in free.iter().enumerate() {
            joined.view_mut((0, k), (p, 1)).copy_from(&self.triangle.r.column(j));
        }
        joined.view_mut((0, n), (p, 1)).copy_from(&self.triangle.z);
        joined[(p, n)] = self.triangle.rest;
        if let Some(prior) = problem.prior() {
            let jacobian = prior.jacobian(p);
            for (k, &j) in free.iter().enumerate() {
                joined.view_mut((p + 1, k), (rows, 1)).copy_from(&(jacobian.column(j) * self.scale[j]));
            }
            joined.view_mut((p + 1, n), (rows, 1)).copy_from(&prior.misfit(theta));
        }
        Triangle::of(joined)
    }

    /// What record and prior say of the parameters that a problem leaves free.
    ///
    /// # Errors
    /// Bounds or scales of the problem that do not fit together.
    pub fn information<P: Problem>(&self, problem: &P) -> Result<Information, FitError> {
        let free = Space::of(problem)?.free();
        let Triangle { r, .. } = self.joined(problem, &self.theta, &free);
        let most = r.column_iter().map(|column| column.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let n = free.len();
        let mut rows = DMatrix::zeros(2 * n, n + 1);
        rows.view_mut((0, 0), (n, n)).copy_from(&r);
        (0..n).for_each(|k| rows[(n + k, k)] = TRACE * most);
        Ok(Information { count: self.count(), free, r: Triangle::of(rows).r })
    }

    /// Prepares the score test of changes that the model does not have, at values of all parameters of a problem and the
    /// misfits there.
    ///
    /// # Errors
    /// Bounds or scales of the problem that do not fit together.
    pub fn score_test<P: Problem>(
        &self,
        problem: &P,
        theta: &[f64],
        misfit: &[f64],
    ) -> Result<ScoreTest<'_>, FitError> {
        let information = self.information(problem)?;
        let gradient = information.of_free(&self.gradient_of(problem, theta, misfit));
        Ok(ScoreTest::new(self, information, gradient, misfit))
    }

    /// Whether the Jacobian foresees what moving from one point to another does to the misfits, up to a share of the squared
    /// change.
    pub fn foresees(&self, before: Evaluated<'_>, after: Evaluated<'_>, share: f64) -> bool {
        let step = DVector::from_fn(self.count(), |i, _| (after.theta[i] - before.theta[i]) / self.scale[i]);
        let expected = &self.jacobian * step;
        let (mut missed, mut change) = (0.0, 0.0);
        for ((expected, before), after) in expected.iter().zip(before.misfit).zip(after.misfit) {
            let moved = after - before;
            missed += (moved - expected).powi(2);
            change += moved * moved;
        }
        missed <= share * change
    }

    /// Variance inflation by autocorrelation of an estimate: the variance of its scores over that of white misfits, at least 1.
    ///
    /// `influence` is what the estimate's [direction](Information::direction) does to the misfits, `misfit` those that are
    /// left. What the prior adds to the scores, the square of `known` along the direction, is no series and is not inflated: the
    /// variance of the estimate is `d' (v J'J + P) d` (sandwich). Nor is what the weights allow samples to share, unless it is exceeded:
    /// with weights `W'W = (D + L)^-1`, `D` of samples on their own and `L` of what they share, the scores `g'W'W e` of errors that are
    /// coloured by a factor `v` have the variance `a'(v D + L)a` with `a = W'W g`.
    pub fn inflation(&self, influence: &DVector<f64>, misfit: &[f64], known: f64, series: &dyn Series) -> f64 {
        let (mut correlated, mut white) = (known, known);
        let pull: Vec<f64> = misfit.iter().map(|&r| r * self.loss.weight(r)).collect();
        let (mut own, mut noise) = (influence.as_slice().to_vec(), pull.clone());
        series.leave_own(&mut own);
        series.leave_own(&mut noise);
        for Part { rows, shared } in series.parts() {
            let square = |of: &[f64]| of[rows.clone()].iter().map(|value| value * value).sum::<f64>();
            let (all, on_their_own) = (square(influence.as_slice()), square(&own));
            let of_noise = long_run_variance(rows.clone().map(|row| own[row] * noise[row]).collect());
            let of_shared = (all - on_their_own).max(0.0);
            let colour = if on_their_own > 0.0 { of_noise / on_their_own } else { 1.0 };
            let excess = shared.excess(square(&pull) - square(&noise), colour);
            correlated += of_noise + of_shared * excess;
            white += all;
        }
        if white > 0.0 { (correlated / white).max(1.0) } else { 1.0 }
    }

    /// The same of an estimate along a direction (per scale), with the prior of its problem.
    pub fn inflation_along<P: Problem>(
        &self,
        problem: &P,
        direction: &DVector<f64>,
        misfit: &[f64],
        series: &dyn Series,
    ) -> f64 {
        let step = direction.component_mul(&DVector::from_column_slice(&self.scale));
        let known = problem.prior().map_or(0.0, |prior| prior.change(&step).norm_squared());
        self.inflation(&(&self.jacobian * direction), misfit, known, series)
    }
}

/// Weighted misfits as time series.
pub trait Series {
    /// One after the other.
    fn parts(&self) -> Vec<Part>;

    /// Of weighted misfits, or of what a parameter does to them: leaves what samples have on their own, where weights that allow
    /// them to share something have called misfits independent.
    fn leave_own(&self, column: &mut [f64]);
}

/// One time series of weighted misfits.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    pub rows: Range<usize>,
    pub shared: Shared,
}

/// What the samples of a series may share: each way in which they may differ together has a variance, of which a share is not that of
/// samples on their own.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shared {
    /// Sum of the shares over all ways.
    pub sum: f64,
    /// Sum of their squares.
    pub squares: f64,
}

impl Shared {
    /// One way more, weighed by how far it is one of this series.
    pub fn add(&mut self, share: f64, weight: f64) {
        self.sum += weight * share;
        self.squares += weight * share * share;
    }

    /// By how much the variance of what is shared exceeds what is allowed, at least 1: from what [`Series::leave_own`] takes from the
    /// sum of squares of misfits whose noise has long-run variance `colour`. A way with a share `s` has `s excess + (1 - s) colour`.
    fn excess(&self, taken: f64, colour: f64) -> f64 {
        if self.squares > 0.0 { ((taken - colour * (self.sum - self.squares)) / self.squares).max(1.0) } else { 1.0 }
    }
}

/// Values of all parameters and the misfits there.
#[derive(Debug, Clone, Copy)]
pub struct Evaluated<'a> {
    pub theta: &'a [f64],
    pub misfit: &'a [f64],
}

/// The triangle of what record and prior say of the free parameters of a problem, per scale. Covariances and directions come
/// from it by triangular solves.
#[derive(Debug, Clone, PartialEq)]
pub struct Information {
    count: usize,
    free: Vec<usize>,
    /// Upper triangular, its diagonal nowhere zero.
    r: DMatrix<f64>,
}

impl Information {
    /// The free parameters.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// Those of all parameters that are free.
    pub(super) fn of_free(&self, all: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(self.free.len(), |k, _| all[self.free[k]])
    }

    /// `R^-T v`.
    pub(super) fn whitened(&self, free: &DVector<f64>) -> DVector<f64> {
        self.r.tr_solve_upper_triangular(free).unwrap_or_else(|| DVector::zeros(free.len()))
    }

    /// `R^-1 v`.
    pub(super) fn back(&self, whitened: &DVector<f64>) -> DVector<f64> {
        self.r.solve_upper_triangular(whitened).unwrap_or_else(|| DVector::zeros(whitened.len()))
    }

    /// How all parameters move with the gradient of one of them: a column of [`Information::covariance`]. `None` of a
    /// parameter that is held.
    pub fn direction(&self, parameter: usize) -> Option<DVector<f64>> {
        let mut unit = DVector::zeros(self.free.len());
        unit[self.free.iter().position(|&index| index == parameter)?] = 1.0;
        let solved = self.back(&self.whitened(&unit));
        let mut direction = DVector::zeros(self.count);
        for (k, &index) in self.free.iter().enumerate() {
            direction[index] = solved[k];
        }
        Some(direction)
    }

    /// Covariance of all parameters for white misfits, per scale; zero for those that are held.
    pub fn covariance(&self) -> DMatrix<f64> {
        let n = self.free.len();
        let unit = DMatrix::identity(n, n);
        let inverse = self.r.solve_upper_triangular(&unit).unwrap_or_else(|| DMatrix::zeros(n, n));
        let solved = &inverse * inverse.transpose();
        let mut covariance = DMatrix::zeros(self.count, self.count);
        for (a, &i) in self.free.iter().enumerate() {
            for (b, &j) in self.free.iter().enumerate() {
                covariance[(i, j)] = solved[(a, b)];
            }
        }
        covariance
    }
}
