//! What is known of estimated parameters before a record is seen.

use nalgebra::{DMatrix, DVector};

/// A normal distribution over some of the estimated parameters; nothing is known of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussian {
    /// Indices among the estimated parameters.
    pub members: Vec<usize>,
    /// One per member, SI.
    pub mean: Vec<f64>,
    /// One per member, one standard deviation, SI.
    pub sigma: Vec<f64>,
    /// Turns deviations from the mean into independent ones of variance 1.
    whitening: DMatrix<f64>,
}

impl Gaussian {
    /// From the covariance of the members, SI. Correlations that no covariance can have are dropped.
    pub fn new(members: Vec<usize>, mean: Vec<f64>, covariance: &DMatrix<f64>) -> Self {
        let sigma: Vec<f64> = covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
        let scaled = |a: usize, b: usize| covariance[(a, b)] / (sigma[a] * sigma[b]);
        let count = members.len();
        let correlation = DMatrix::from_fn(count, count, scaled);
        let factor = correlation.cholesky().map_or_else(|| DMatrix::identity(count, count), |factor| factor.l());
        // L is triangular with a positive diagonal, so it has an inverse.
        let mut whitening = factor
            .solve_lower_triangular(&DMatrix::identity(count, count))
            .unwrap_or_else(|| DMatrix::identity(count, count));
        for (mut column, sigma) in whitening.column_iter_mut().zip(&sigma) {
            column /= *sigma;
        }
        Self { members, mean, sigma, whitening }
    }

    /// Nothing is known.
    pub fn none() -> Self {
        Self::new(Vec::new(), Vec::new(), &DMatrix::zeros(0, 0))
    }

    /// How many rows it adds to the misfits.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    pub fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// Independent misfits of variance 1, one per member.
    pub fn misfit(&self, theta: &[f64]) -> DVector<f64> {
        let away = self.members.iter().zip(&self.mean).map(|(&member, mean)| theta[member] - mean);
        &self.whitening * DVector::from_iterator(self.len(), away)
    }

    /// How [`Gaussian::misfit`] changes when all parameters move by a step, SI.
    pub fn change(&self, step: &DVector<f64>) -> DVector<f64> {
        &self.whitening * DVector::from_iterator(self.len(), self.members.iter().map(|&member| step[member]))
    }

    /// Derivatives of [`Gaussian::misfit`] by all of `count` parameters.
    pub fn jacobian(&self, count: usize) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(self.len(), count);
        for (column, &member) in self.members.iter().enumerate() {
            jacobian.set_column(member, &self.whitening.column(column));
        }
        jacobian
    }

    /// A root of the covariance, SI: what it makes of independent deviations of variance 1 is distributed like this.
    pub fn root(&self) -> DMatrix<f64> {
        let whitening = self.whitening.clone();
        // It is triangular with a positive diagonal.
        whitening.solve_lower_triangular(&DMatrix::identity(self.len(), self.len())).unwrap_or(whitening)
    }

    /// Inverse of the covariance, SI.
    pub fn precision(&self) -> DMatrix<f64> {
        self.whitening.tr_mul(&self.whitening)
    }

    /// Mean and standard deviation of one estimated parameter.
    pub fn of(&self, parameter: usize) -> Option<(f64, f64)> {
        let place = self.members.iter().position(|&member| member == parameter)?;
        Some((self.mean[place], self.sigma[place]))
    }
}
