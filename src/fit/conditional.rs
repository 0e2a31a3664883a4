//! The best fit with some parameters held: at their healthy value, or along a profile.
//!
//! A misfit evaluation is an order of magnitude cheaper than a linearisation, and a linearisation is cheap beside the
//! triangle that a long Jacobian is reduced to. So both are kept from the point one comes from: a step needs the fresh
//! gradient only, `R' z = J' r` (the simplified Gauss-Newton method; Deuflhard, *Newton Methods for Nonlinear Problems*,
//! section 4.3). They are renewed only where steps stop to pay or where the result must be certain.

use std::sync::Arc;

use nalgebra::DVector;

use super::active_set::bounded_step;
use super::problem::{Linearised, Problem, Space, try_misfit};
use super::{Fit, FitError, Loss, Triangle};

/// A Jacobian and what it reduces to, shared by all points that step along it.
#[derive(Debug, PartialEq)]
struct Slope {
    linearised: Linearised,
    triangle: Triangle,
}

impl Slope {
    fn of(linearised: Linearised, loss: Loss) -> Arc<Self> {
        let triangle = Triangle::reduce(&linearised, loss);
        Arc::new(Self { linearised, triangle })
    }

    /// The triangle with the gradient of other misfits than its own.
    fn with(&self, misfit: &[f64], loss: Loss) -> Triangle {
        let weighted = DVector::from_iterator(misfit.len(), misfit.iter().map(|&r| r * loss.at(r * r).1));
        let gradient = self.linearised.jacobian.tr_mul(&weighted);
        let p = gradient.len();
        // Forward substitution; a direction without influence has no gradient either.
        let mut z = DVector::zeros(p);
        for j in 0..p {
            let known: f64 = (0..j).map(|k| self.triangle.r[(k, j)] * z[k]).sum();
            let pivot = self.triangle.r[(j, j)];
            let column = self.triangle.r.column(j).norm();
            z[j] = if pivot.abs() > 1e-12 * column { (gradient[j] - known) / pivot } else { 0.0 };
        }
        Triangle { r: self.triangle.r.clone(), z, rest: self.triangle.rest }
    }
}

/// The best fit with some parameters held.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionalFit {
    /// All `p` parameters, the held ones at their values.
    pub theta: Vec<f64>,
    /// `1/2 sum rho(r^2)` there.
    pub cost: f64,
    misfit: Vec<f64>,
    slope: Arc<Slope>,
    /// Whether the Jacobian is that of `theta`; if not, it is one from nearby.
    pub exact: bool,
    /// Whether no step over the free parameters promises more than the tolerance.
    pub converged: bool,
}

impl ConditionalFit {
    fn move_to(&mut self, theta: Vec<f64>, misfit: Vec<f64>, cost: f64) {
        (self.theta, self.misfit, self.cost, self.exact) = (theta, misfit, cost, false);
    }
}

/// Minimises a problem with some parameters held, starting from where it has been before.
#[derive(Debug)]
pub struct Conditional<'a, P: Problem> {
    problem: &'a P,
    loss: Loss,
    space: Space,
    origin: ConditionalFit,
    /// Decrease of `2 F` that is not worth another step.
    tolerance: f64,
    /// Calls of [`Problem::misfit`] so far.
    pub misfit_evaluations: u64,
    /// Calls of [`Problem::linearise`] so far.
    pub linearisations: u64,
}

const MOST_ROUNDS: usize = 60;
/// Damping that only keeps the step unique.
const NO_DAMPING: f64 = 1e-14;
const FIRST_DAMPING: f64 = 1e-2;
/// A step with less than this share of the promised decrease says that the Jacobian is out of date.
const POOR_GAIN: f64 = 0.25;

impl<'a, P: Problem> Conditional<'a, P> {
    /// Starts from the optimum `fit`.
    ///
    /// # Errors
    /// If lengths or bounds of the problem do not fit together.
    pub fn new(problem: &'a P, fit: &Fit) -> Result<Self, FitError> {
        let origin = ConditionalFit {
            theta: fit.theta.clone(),
            cost: fit.cost,
            misfit: fit.linearised.misfit.clone(),
            slope: Slope::of(fit.linearised.clone(), fit.loss),
            exact: true,
            converged: true,
        };
        let space = Space::of(problem)?;
        super::problem::expect_length("parameters of the fit", space.len(), fit.theta.len())?;
        let loss = fit.loss;
        Ok(Self { problem, loss, space, origin, tolerance: 1e-3, misfit_evaluations: 0, linearisations: 0 })
    }

    /// Decrease of `2 F` (so, for known noise, of chi-squared) that is not worth another step; 0.001 unless set.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// The optimum that everything starts from.
    pub fn origin(&self) -> &ConditionalFit {
        &self.origin
    }

    pub(super) fn space(&self) -> &Space {
        &self.space
    }

    pub(super) fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = tolerance;
    }

    /// The best fit with each `(parameter, value)` held, starting from the optimum; confirmed by a fresh linearisation.
    /// Indices beyond the last parameter are ignored; a value outside its bounds is allowed.
    ///
    /// # Errors
    /// If the model fails wherever it is tried with these values.
    pub fn minimise_with_fixed(&mut self, fixed: &[(usize, f64)]) -> Result<ConditionalFit, FitError> {
        let origin = self.origin.clone();
        self.walk(&origin, fixed, true)
    }

    /// The same from any earlier result; without `certain` a Jacobian from nearby may end it, which is cheaper and can
    /// leave the cost slightly too high, never too low.
    ///
    /// # Errors
    /// If the model fails wherever it is tried with these values.
    pub fn walk(
        &mut self,
        from: &ConditionalFit,
        fixed: &[(usize, f64)],
        certain: bool,
    ) -> Result<ConditionalFit, FitError> {
        let mut held = vec![None; self.space.len()];
        let mut target = from.theta.clone();
        for &(j, value) in fixed.iter().filter(|(j, _)| *j < from.theta.len()) {
            held[j] = Some(0.0);
            target[j] = value;
        }
        let mut here = if target == from.theta { from.clone() } else { self.jump(from, &target, &held)? };
        here.converged = false;
        let mut damping = NO_DAMPING;
        for _ in 0..MOST_ROUNDS {
            let triangle =
                if here.exact { here.slope.triangle.clone() } else { here.slope.with(&here.misfit, self.loss) };
            let step = self.step(&triangle, &here.theta, &held, damping);
            let promised = triangle.predicted_decrease(&step);
            if 2.0 * promised <= self.tolerance || self.space.relative_step(&here.theta, &step) < 1e-12 {
                if here.exact || !certain || !self.renew(&mut here) {
                    here.converged = here.exact || !certain;
                    break;
                }
                damping = NO_DAMPING;
                continue;
            }
            let theta: Vec<f64> = here.theta.iter().zip(&step).map(|(t, d)| t + d).collect();
            self.misfit_evaluations += 1;
            let tried = try_misfit(self.problem, &theta, self.loss).filter(|(_, cost)| *cost < here.cost);
            let Some((misfit, cost)) = tried else {
                if here.exact || !self.renew(&mut here) {
                    damping = (4.0 * damping).max(FIRST_DAMPING);
                } else {
                    damping = NO_DAMPING;
                }
                continue;
            };
            let gain = (here.cost - cost) / promised;
            here.move_to(theta, misfit, cost);
            if gain > POOR_GAIN {
                damping = if damping > FIRST_DAMPING { damping / 4.0 } else { NO_DAMPING };
            }
            if gain < POOR_GAIN {
                self.renew(&mut here);
            }
        }
        Ok(here)
    }

    /// The first point with the held parameters at their new values: along the linear model, or, where the model fails
    /// there, with all others where they were.
    fn jump(
        &mut self,
        from: &ConditionalFit,
        target: &[f64],
        held: &[Option<f64>],
    ) -> Result<ConditionalFit, FitError> {
        let displaced: Vec<Option<f64>> =
            held.iter().zip(target.iter().zip(&from.theta)).map(|(h, (v, t))| h.map(|_| v - t)).collect();
        let triangle = from.slope.with(&from.misfit, self.loss);
        let step = self.step(&triangle, &from.theta, &displaced, NO_DAMPING);
        let mut theta: Vec<f64> = from.theta.iter().zip(&step).map(|(t, d)| t + d).collect();
        for (j, _) in held.iter().enumerate().filter(|(_, h)| h.is_some()) {
            theta[j] = target[j];
        }
        let mut here = from.clone();
        self.misfit_evaluations += 1;
        if let Some((misfit, cost)) = try_misfit(self.problem, &theta, self.loss) {
            here.move_to(theta, misfit, cost);
            return Ok(here);
        }
        self.misfit_evaluations += 1;
        let misfit = self.problem.misfit(target).map_err(|error| FitError::Start { source: Box::new(error) })?;
        let cost = self.loss.cost(&misfit);
        if !cost.is_finite() {
            return Err(FitError::StartNotFinite);
        }
        here.move_to(target.to_vec(), misfit, cost);
        Ok(here)
    }

    fn step(&self, triangle: &Triangle, theta: &[f64], held: &[Option<f64>], damping: f64) -> Vec<f64> {
        let room: Vec<_> = theta.iter().zip(&self.space.bounds).map(|(t, (l, u))| (l - t, u - t)).collect();
        bounded_step(
            triangle,
            &self.weights(triangle).iter().map(|l| l * damping.sqrt()).collect::<Vec<_>>(),
            &room,
            held,
        )
    }

    fn weights(&self, triangle: &Triangle) -> Vec<f64> {
        let norms = triangle.column_norms();
        let most = norms.iter().zip(&self.space.scale).map(|(n, s)| n * s).fold(f64::MIN_POSITIVE, f64::max);
        norms.iter().zip(&self.space.scale).map(|(n, s)| n.max(1e-8 * most / s)).collect()
    }

    /// Replaces the Jacobian from nearby by the true one; false if the model cannot be linearised here.
    fn renew(&mut self, here: &mut ConditionalFit) -> bool {
        self.linearisations += 1;
        let Ok(seen) = self.problem.linearise(&here.theta) else {
            return false;
        };
        if seen.check(here.theta.len()).is_err() || !seen.is_finite() {
            return false;
        }
        here.cost = self.loss.cost(&seen.misfit);
        here.misfit.clone_from(&seen.misfit);
        here.slope = Slope::of(seen, self.loss);
        here.exact = true;
        true
    }
}
