//! Bounded Levenberg-Marquardt as a solver of `argmin`.
//!
//! Each iteration linearises once and then tries steps, at one misfit evaluation each, until one lowers the cost. A step
//! minimises the linear model plus `lambda |D d|^2` *inside the box*, by an active set on the small triangle, so a
//! parameter at its bound costs no accuracy in the others. `D` are the column lengths of the Jacobian, which makes the
//! path independent of units (Marquardt 1963; Moré 1978); `lambda` follows Nielsen, *Damping parameter in Marquardt's
//! method*, IMM-REP-1999-05. There is no geodesic acceleration.

use super::active_set::bounded_step;
use super::here::Here;
use super::problem::{Problem, Space, expect_length, linearise_start, try_misfit};
use super::{Bound, Fit, FitError, Loss, StoppedBecause};
use argmin::core::{
    Error, Executor, IterState, KV, Problem as Counted, Solver, State, TerminationReason, TerminationStatus,
};

/// The iteration state that `argmin` keeps: parameters and gradient of the cost.
pub type FitState = IterState<Vec<f64>, Vec<f64>, (), (), (), f64>;

/// When a fit may stop. All are without unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Share of the cost that a step saves and promised to save.
    pub function: f64,
    /// Cosine between the misfit and the columns of the Jacobian that are still free.
    pub gradient: f64,
    /// Largest change of a parameter as a share of the larger of its value and its scale.
    pub step: f64,
    /// Iterations, each with one linearisation.
    pub max_iterations: u64,
}

impl Default for Tolerances {
    /// Well below a standard error, and above the noise that an integrator leaves in the cost.
    fn default() -> Self {
        Self { function: 1e-8, gradient: 1e-8, step: 1e-9, max_iterations: 100 }
    }
}

impl Tolerances {
    /// As far as double precision goes: for models without integration error.
    pub fn tight() -> Self {
        Self { function: 1e-18, gradient: 1e-15, step: 1e-14, max_iterations: 5000 }
    }
}

/// The damping of the first step, relative to the squared column lengths.
const FIRST_DAMPING: f64 = 1e-4;
const LEAST_DAMPING: f64 = 1e-16;
const MOST_DAMPING: f64 = 1e32;
/// Share of the cost below which a change of it may be rounding.
const ROUNDED: f64 = 1e-12;
const MOST_POLISHING: usize = 40;
/// Least share of the promised decrease that makes a step acceptable.
const LEAST_GAIN: f64 = 1e-4;

/// Bounded Levenberg-Marquardt; give it to an [`Executor`] over any [`Problem`], or call [`fit`].
#[derive(Debug, Clone)]
pub struct LevenbergMarquardt {
    tolerances: Tolerances,
    loss: Loss,
    space: Space,
    here: Option<Here>,
    damping: f64,
    growth: f64,
    stopped: Option<StoppedBecause>,
    misfit_evaluations: u64,
    linearisations: u64,
}

impl LevenbergMarquardt {
    /// A solver with the given tolerances, for plain least squares.
    pub fn new(tolerances: Tolerances) -> Self {
        Self {
            tolerances,
            loss: Loss::None,
            space: Space::default(),
            here: None,
            damping: FIRST_DAMPING,
            growth: 2.0,
            stopped: None,
            misfit_evaluations: 0,
            linearisations: 0,
        }
    }

    /// Minimise with this loss.
    #[must_use]
    pub fn loss(mut self, loss: Loss) -> Self {
        self.loss = loss;
        self
    }

    /// What was found, once the executor has returned `state`; `None` if it never ran.
    pub fn finish(self, state: &FitState) -> Option<Fit> {
        let here = self.here?;
        let stopped = self.stopped.unwrap_or_else(|| match state.get_termination_reason() {
            Some(reason) if *reason != TerminationReason::MaxItersReached => {
                StoppedBecause::Executor { reason: reason.clone() }
            }
            _ => StoppedBecause::MaxIterations { iterations: state.get_iter() },
        });
        let at_bound = here.theta.iter().zip(&self.space.bounds).map(|(t, (lower, upper))| match *t {
            t if t <= *lower => Some(Bound::Lower),
            t if t >= *upper => Some(Bound::Upper),
            _ => None,
        });
        Some(Fit {
            at_bound: at_bound.collect(),
            theta: here.theta,
            cost: here.cost,
            iterations: state.get_iter(),
            misfit_evaluations: self.misfit_evaluations,
            linearisations: self.linearisations,
            stopped,
            linearised: here.seen,
            loss: self.loss,
        })
    }

    /// More damping, and faster so each time in a row.
    fn reject(&mut self) {
        self.damping *= self.growth;
        self.growth *= 2.0;
    }

    /// Where the cost is equal up to rounding, the decrease that the linear model promises still tells better from
    /// worse: Gauss-Newton steps as long as they lower it. Without this the parameters keep half the digits of the cost.
    fn polish<O: Problem>(&mut self, problem: &mut Counted<O>, mut here: Here) -> Here {
        let (mut step, mut promised) = self.gauss_newton(&here);
        for _ in 0..MOST_POLISHING {
            let target: Vec<f64> = here.theta.iter().zip(&step).map(|(t, d)| t + d).collect();
            let theta = self.space.clamp(&target);
            if promised > ROUNDED * here.cost || theta == here.theta {
                break;
            }
            self.linearisations += 1;
            let seen = problem.problem("linearise_count", |p| Ok(p.linearise(&theta).ok()));
            let Some(seen) = seen.ok().flatten().filter(|s| s.check(theta.len()).is_ok() && s.is_finite()) else {
                break;
            };
            let next = Here::new(theta, seen, self.loss, &self.space, &here.lengths);
            let (next_step, next_promised) = self.gauss_newton(&next);
            if next_promised >= promised || next.cost > here.cost * (1.0 + ROUNDED) {
                break;
            }
            (here, step, promised) = (next, next_step, next_promised);
        }
        here
    }

    /// The undamped step inside the box, and the decrease it promises.
    fn gauss_newton(&self, here: &Here) -> (Vec<f64>, f64) {
        let room = self.room(&here.theta);
        let damping: Vec<f64> = here.lengths.iter().map(|l| l * LEAST_DAMPING.sqrt()).collect();
        let step = bounded_step(&here.triangle, &damping, &room, &vec![None; room.len()]);
        let promised = here.triangle.predicted_decrease(&step);
        (step, promised)
    }

    fn room(&self, theta: &[f64]) -> Vec<(f64, f64)> {
        theta.iter().zip(&self.space.bounds).map(|(t, (lower, upper))| (lower - t, upper - t)).collect()
    }

    /// One step that lowers the cost, or the reason why there is none.
    fn advance<O: Problem>(&mut self, problem: &mut Counted<O>, here: &Here) -> Result<(Here, f64), StoppedBecause> {
        let room = self.room(&here.theta);
        let held = vec![None; room.len()];
        loop {
            let root = self.damping.sqrt();
            let damping: Vec<f64> = here.lengths.iter().map(|l| l * root).collect();
            let step = bounded_step(&here.triangle, &damping, &room, &held);
            let relative_step = self.space.relative_step(&here.theta, &step);
            let promised = here.triangle.predicted_decrease(&step);
            let share = promised / here.cost.max(f64::MIN_POSITIVE);
            let target: Vec<f64> = here.theta.iter().zip(&step).map(|(t, d)| t + d).collect();
            let theta = self.space.clamp(&target);
            if theta == here.theta || self.damping > MOST_DAMPING {
                return Err(StoppedBecause::NoFurtherDecrease { relative_step, promised: share });
            }
            self.misfit_evaluations += 1;
            let loss = self.loss;
            let tried = problem.problem("misfit_count", |p| Ok(try_misfit(p, &theta, loss)));
            let Some((_, cost)) = tried.ok().flatten() else {
                self.reject();
                continue;
            };
            let gain = (here.cost - cost) / promised;
            if !(gain > LEAST_GAIN && cost < here.cost) {
                // Below rounding of the cost a rejection says nothing about the model any more.
                if share <= self.tolerances.function {
                    return Err(StoppedBecause::FunctionTolerance {
                        relative_decrease: share,
                        tolerance: self.tolerances.function,
                    });
                }
                if share.abs() < 4.0 * f64::EPSILON || relative_step < self.tolerances.step {
                    return Err(StoppedBecause::NoFurtherDecrease { relative_step, promised: share });
                }
                self.reject();
                continue;
            }
            self.linearisations += 1;
            let seen = problem.problem("linearise_count", |p| Ok(p.linearise(&theta).ok()));
            let Some(seen) = seen.ok().flatten().filter(|s| s.check(theta.len()).is_ok() && s.is_finite()) else {
                self.reject();
                continue;
            };
            self.damping = (self.damping * (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0)).max(LEAST_DAMPING);
            self.growth = 2.0;
            let next = Here::new(theta, seen, self.loss, &self.space, &here.lengths);
            let relative_decrease = ((here.cost - next.cost) / here.cost).abs().max(share);
            let tolerances = self.tolerances;
            if relative_decrease <= tolerances.function && gain < 2.0 {
                self.stopped =
                    Some(StoppedBecause::FunctionTolerance { relative_decrease, tolerance: tolerances.function });
            } else if relative_step <= tolerances.step {
                self.stopped = Some(StoppedBecause::StepTolerance { relative_step, tolerance: tolerances.step });
            }
            return Ok((next, relative_step));
        }
    }

    /// Stops if the gradient vanishes at `here`, and remembers `here`.
    fn arrive(&mut self, here: Here, state: FitState) -> FitState {
        let cosine = here.cosine(&self.space);
        if cosine <= self.tolerances.gradient {
            self.stopped = Some(StoppedBecause::GradientTolerance { cosine, tolerance: self.tolerances.gradient });
        }
        let gradient = here.triangle.gradient().iter().copied().collect();
        let state = state.param(here.theta.clone()).gradient(gradient).cost(here.cost);
        self.here = Some(here);
        state
    }
}

impl<O: Problem> Solver<O, FitState> for LevenbergMarquardt {
    fn name(&self) -> &str {
        "bounded Levenberg-Marquardt"
    }

    fn init(&mut self, problem: &mut Counted<O>, mut state: FitState) -> Result<(FitState, Option<KV>), Error> {
        self.space = problem.problem("bounds_count", |p| Ok(Space::of(p)))??;
        let start = state.take_param().unwrap_or_default();
        expect_length("parameters of the start", self.space.len(), start.len())?;
        let start = self.space.clamp(&start);
        self.linearisations += 1;
        let seen = problem.problem("linearise_count", |p| Ok(linearise_start(p, &start)))??;
        let here = Here::new(start, seen, self.loss, &self.space, &[]);
        Ok((self.arrive(here, state), None))
    }

    fn next_iter(&mut self, problem: &mut Counted<O>, state: FitState) -> Result<(FitState, Option<KV>), Error> {
        let Some(here) = self.here.take() else {
            return Err(FitError::NoStart { tried: 0 }.into());
        };
        match self.advance(problem, &here) {
            Ok((next, relative_step)) => {
                let report = argmin::core::KV::new()
                    .merge(argmin::kv!("damping" => self.damping; "relative_step" => relative_step;));
                Ok((self.arrive(next, state), Some(report)))
            }
            Err(stopped) => {
                let here = self.polish(problem, here);
                let state = self.arrive(here, state);
                self.stopped.get_or_insert(stopped);
                Ok((state, None))
            }
        }
    }

    fn terminate(&mut self, _state: &FitState) -> TerminationStatus {
        match &self.stopped {
            None => TerminationStatus::NotTerminated,
            Some(_) => TerminationStatus::Terminated(TerminationReason::SolverConverged),
        }
    }
}

/// Fits `problem` from `start` (its `p` parameters; moved into the bounds if outside).
///
/// # Errors
/// If lengths or bounds do not fit together, or the model fails at the start.
pub fn fit<P: Problem>(problem: &P, start: &[f64], loss: Loss, tolerances: Tolerances) -> Result<Fit, FitError> {
    let executor = Executor::new(problem, LevenbergMarquardt::new(tolerances).loss(loss))
        .configure(|state: FitState| state.param(start.to_vec()).max_iters(tolerances.max_iterations))
        .timer(false)
        .ctrlc(false);
    let result = executor.run().map_err(|error| match error.downcast::<FitError>() {
        Ok(known) => known,
        Err(other) => FitError::Executor { source: other.into() },
    })?;
    result.solver.finish(&result.state).ok_or(FitError::NoStart { tried: 1 })
}
