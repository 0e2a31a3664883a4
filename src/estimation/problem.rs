//! What is to be fitted.

use nalgebra::DMatrix;

use super::prior::Gaussian;
use super::{FitError, Loss, NotFinite};

/// A weighted least-squares problem in a box: `p` parameters, `m` misfits.
///
/// An evaluation may fail at some `theta` (the integration broke down there, say), and so does one whose misfits are not
/// finite. A fit takes that as a rejected step, and fails itself only if its start fails. A derivative that is not finite
/// where a fit has arrived ends the fit with the name of the parameter.
///
/// A parameter whose two bounds are equal is held there.
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
    /// compared with to be called small, and the unit in which parameters are compared.
    fn scale(&self) -> Vec<f64>;

    /// What is known of the parameters before the record; no loss applies to it.
    fn prior(&self) -> Option<&Gaussian> {
        None
    }

    /// What a message calls a parameter.
    fn name(&self, parameter: usize) -> String {
        format!("parameter {parameter}")
    }
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
    fn prior(&self) -> Option<&Gaussian> {
        (**self).prior()
    }
    fn name(&self, parameter: usize) -> String {
        (**self).name(parameter)
    }
}

/// A problem with one parameter held at a value.
#[derive(Debug)]
pub struct Held<'a, P: Problem> {
    problem: &'a P,
    bounds: Vec<(f64, f64)>,
}

impl<'a, P: Problem> Held<'a, P> {
    /// `value` is in the unit of the parameter, and may lie outside its bounds.
    pub fn new(problem: &'a P, parameter: usize, value: f64) -> Self {
        let mut bounds = problem.bounds().to_vec();
        bounds[parameter] = (value, value);
        Self { problem, bounds }
    }
}

impl<P: Problem> Problem for Held<'_, P> {
    type Error = P::Error;
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }
    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, Self::Error> {
        self.problem.misfit(theta)
    }
    fn linearise(&self, theta: &[f64]) -> Result<Linearised, Self::Error> {
        self.problem.linearise(theta)
    }
    fn scale(&self) -> Vec<f64> {
        self.problem.scale()
    }
    fn prior(&self) -> Option<&Gaussian> {
        self.problem.prior()
    }
    fn name(&self, parameter: usize) -> String {
        self.problem.name(parameter)
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
    /// Refuses shapes that do not agree with `p` parameters and with each other, and numbers that are not finite.
    pub(super) fn check(&self, p: usize, name: impl Fn(usize) -> String) -> Result<(), FitError> {
        let (rows, columns) = self.jacobian.shape();
        expect_length("columns of the Jacobian", p, columns)?;
        expect_length("rows of the Jacobian", self.misfit.len(), rows)?;
        if self.misfit.iter().any(|r| !r.is_finite()) {
            return Err(FitError::NotFinite(NotFinite::Misfit));
        }
        let finite = |column: &f64| column.is_finite();
        match self.jacobian.column_iter().position(|column| !column.iter().all(finite)) {
            Some(column) => Err(FitError::NotFinite(NotFinite::Sensitivity { parameter: name(column) })),
            None => Ok(()),
        }
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
                return Err(FitError::Bounds { parameter: problem.name(parameter), lower, upper });
            }
        }
        let scale = scale(problem);
        expect_length("scales", bounds.len(), scale.len())?;
        Ok(Self { bounds, scale })
    }

    pub fn len(&self) -> usize {
        self.bounds.len()
    }

    /// Parameters that are not held.
    pub fn free(&self) -> Vec<usize> {
        (0..self.len()).filter(|&j| self.bounds[j].0 < self.bounds[j].1).collect()
    }

    pub fn clamp(&self, theta: &[f64]) -> Vec<f64> {
        theta.iter().zip(&self.bounds).map(|(t, (lower, upper))| t.max(*lower).min(*upper)).collect()
    }

    /// How far a parameter may go to either side, in scales.
    pub fn slack(&self, theta: &[f64], parameter: usize) -> (f64, f64) {
        let ((lower, upper), scale) = (self.bounds[parameter], self.scale[parameter]);
        ((lower - theta[parameter]) / scale, (upper - theta[parameter]) / scale)
    }

    /// Largest change of a parameter relative to its magnitude.
    pub fn relative_step(&self, from: &[f64], to: &[f64]) -> f64 {
        let each = from.iter().zip(to).zip(&self.scale).map(|((a, b), s)| (b - a).abs() / a.abs().max(*s));
        each.fold(0.0, f64::max)
    }
}

/// The scales of a problem; one that is no magnitude counts as 1.
pub(super) fn scale<P: Problem>(problem: &P) -> Vec<f64> {
    let usable = |s: f64| if s.is_finite() && s != 0.0 { s.abs() } else { 1.0 };
    problem.scale().into_iter().map(usable).collect()
}

/// `2 F` of record and prior, from the misfits of the record at `theta`.
pub(super) fn cost<P: Problem>(problem: &P, loss: Loss, misfit: &[f64], theta: &[f64]) -> f64 {
    let before = problem.prior().map_or(0.0, |prior| prior.misfit(theta).norm_squared());
    2.0 * loss.cost(misfit) + before
}

pub(super) fn expect_length(what: &'static str, expected: usize, found: usize) -> Result<(), FitError> {
    if expected == found { Ok(()) } else { Err(FitError::Length { what, expected, found }) }
}
