//! What is to be fitted.

use super::FitError;
use super::loss::Loss;
use nalgebra::DMatrix;

/// A weighted least-squares problem in a box: `p` parameters, `m` misfits.
///
/// An evaluation may fail at some `theta` (the integration broke down there, say). A fit takes that as a rejected step,
/// and fails itself only if its start fails. A misfit that is not finite counts as a failure.
pub trait Problem: Sync {
    /// Why the model could not be evaluated.
    type Error: std::error::Error + Send + Sync + 'static;

    /// Lower and upper bound of each of the `p` parameters, in the parameter's unit. May be infinite.
    fn bounds(&self) -> &[(f64, f64)];

    /// The `m` misfits `(model - measurement) / sigma`, without unit; `m` is the same at every `theta`.
    ///
    /// # Errors
    /// Where the model cannot be evaluated at `theta`.
    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// The misfits and their derivatives at `theta`.
    ///
    /// # Errors
    /// Where the model or its sensitivities cannot be evaluated at `theta`.
    fn linearise(&self, theta: &[f64]) -> Result<Linearised, Self::Error>;

    /// A typical magnitude of each of the `p` parameters, positive, in the parameter's unit. It is what a step is
    /// compared with to be called small, and what a parameter without influence is moved by.
    fn scale(&self) -> Vec<f64>;
}

impl<P: Problem + ?Sized> Problem for &P {
    type Error = P::Error;
    fn bounds(&self) -> &[(f64, f64)] {
        (**self).bounds()
    }
    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, Self::Error> {
        (**self).misfit(theta)
    }
    fn linearise(&self, theta: &[f64]) -> Result<Linearised, Self::Error> {
        (**self).linearise(theta)
    }
    fn scale(&self) -> Vec<f64> {
        (**self).scale()
    }
}

/// A problem seen from one point: the misfits there and how they change.
#[derive(Debug, Clone, PartialEq)]
pub struct Linearised {
    /// The `m` misfits.
    pub misfit: Vec<f64>,
    /// `d misfit / d theta`, `m` rows and `p` columns; a column has the inverse unit of its parameter.
    pub jacobian: DMatrix<f64>,
}

impl Linearised {
    /// Whether shapes agree with `p` parameters and with each other.
    pub(super) fn check(&self, p: usize) -> Result<(), FitError> {
        let (rows, columns) = self.jacobian.shape();
        if columns != p {
            return Err(FitError::Length { what: "columns of the Jacobian", expected: p, found: columns });
        }
        if rows != self.misfit.len() {
            return Err(FitError::Length { what: "rows of the Jacobian", expected: self.misfit.len(), found: rows });
        }
        Ok(())
    }

    /// Whether every number in it is finite.
    pub(super) fn is_finite(&self) -> bool {
        self.misfit.iter().all(|r| r.is_finite()) && self.jacobian.iter().all(|d| d.is_finite())
    }
}

/// Bounds and scales of a problem, checked once.
#[derive(Debug, Clone, Default)]
pub(super) struct Space {
    pub bounds: Vec<(f64, f64)>,
    pub scale: Vec<f64>,
}

impl Space {
    pub fn of<P: Problem>(problem: &P) -> Result<Self, FitError> {
        let bounds = problem.bounds().to_vec();
        for (parameter, &(lower, upper)) in bounds.iter().enumerate() {
            let ordered = lower <= upper; // false for a NaN, too
            if !ordered {
                return Err(FitError::Bounds { parameter, lower, upper });
            }
        }
        let given = problem.scale();
        expect_length("scales", bounds.len(), given.len())?;
        let scale = given.iter().map(|&s| if s.is_finite() && s != 0.0 { s.abs() } else { 1.0 }).collect();
        Ok(Self { bounds, scale })
    }

    pub fn len(&self) -> usize {
        self.bounds.len()
    }

    pub fn clamp(&self, theta: &[f64]) -> Vec<f64> {
        theta.iter().zip(&self.bounds).map(|(t, (lower, upper))| t.max(*lower).min(*upper)).collect()
    }

    /// Largest change of a parameter relative to its magnitude.
    pub fn relative_step(&self, theta: &[f64], step: &[f64]) -> f64 {
        let each = theta.iter().zip(step).zip(&self.scale).map(|((t, d), s)| d.abs() / t.abs().max(*s));
        each.fold(0.0, f64::max)
    }
}

pub(super) fn expect_length(what: &'static str, expected: usize, found: usize) -> Result<(), FitError> {
    if expected == found { Ok(()) } else { Err(FitError::Length { what, expected, found }) }
}

/// Misfits and cost at a trial point; `None` where the model fails or is not finite, which a solver takes as "not there".
pub(super) fn try_misfit<P: Problem>(problem: &P, theta: &[f64], loss: Loss) -> Option<(Vec<f64>, f64)> {
    let misfit = problem.misfit(theta).ok()?;
    let cost = loss.cost(&misfit);
    cost.is_finite().then_some((misfit, cost))
}

/// The problem linearised at a start; here a failure is an error.
pub(super) fn linearise_start<P: Problem>(problem: &P, theta: &[f64]) -> Result<Linearised, FitError> {
    let seen = problem.linearise(theta).map_err(|error| FitError::Start { source: Box::new(error) })?;
    seen.check(theta.len())?;
    if seen.is_finite() { Ok(seen) } else { Err(FitError::StartNotFinite) }
}
