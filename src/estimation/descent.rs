//! The one descent: damped, inside the box, as a solver of `argmin`.
//!
//! Each step minimises the local quadratic model plus `damping |D d|^2` *inside the box*, by an active set on the small
//! triangle, so a parameter at its bound costs no accuracy in the others. `D` are the column lengths of the triangle, which
//! makes the path independent of units (Marquardt 1963; Moré 1978); the damping follows Nielsen, *Damping parameter in
//! Marquardt's method*, IMM-REP-1999-05. There is no geodesic acceleration.
//!
//! Where the Jacobian comes from is a policy. [`fit`] takes it again at every iterate. [`fit_along`] keeps one from nearby,
//! with fresh misfits: a simulation is an order of magnitude cheaper than one with sensitivities (simplified Gauss-Newton;
//! Deuflhard, *Newton Methods for Nonlinear Problems*, section 4.3).

use argmin::core::{Error, Executor, IterState, KV, Problem as Counted, Solver, TerminationReason, TerminationStatus};

use super::bounded_step::{Linear, bounded_step};
use super::options::{FRESH, NEARBY, Options, Schedule};
use super::problem::{Problem, Space, cost, expect_length};
use super::triangle::Triangle;
use super::{Bound, Fit, FitError, LocalModel, Loss, NotFinite, StoppedBecause};

/// The iteration state that `argmin` keeps: parameters and cost.
pub type FitState = IterState<Vec<f64>, (), (), (), (), f64>;

/// Damping that only keeps the step unique: the square of what is lost in a sum of squares in double precision.
const LEAST_DAMPING: f64 = 1e-16;
/// Least influence, as a share of the largest, that a parameter's damping is relative to: a column of zeros keeps a weight.
const LEAST_LENGTH: f64 = 1e-12;
/// Share of the cost below which a change of it may be rounding.
const ROUNDED: f64 = 1e-12;
/// Share by which rounding may raise the cost: misfits are differences of nearly equal numbers, which costs up to five of
/// sixteen digits.
const NOISE: f64 = 1e-10;
const MOST_POLISHING: usize = 40;
/// Least share of the promised decrease that makes a step acceptable.
const LEAST_GAIN: f64 = 1e-4;

/// Where the local model comes from.
#[derive(Debug)]
enum Source<'a> {
    /// Taken again at each iterate; `None` before the first.
    Fresh(Option<Box<LocalModel>>),
    /// From nearby, kept.
    Nearby(&'a LocalModel),
}

/// One point of a search.
#[derive(Debug, Clone)]
struct Iterate {
    theta: Vec<f64>,
    misfit: Vec<f64>,
    cost: f64,
    /// Record and prior over the free parameters, per scale.
    triangle: Triangle,
}

/// What a trial came to.
enum Advance {
    To(Iterate, Option<Box<LocalModel>>),
    Stop(StoppedBecause),
}

/// The descent; see the module.
#[derive(Debug)]
pub struct Descent<'a> {
    options: Options,
    loss: Loss,
    source: Source<'a>,
    schedule: Schedule,
    space: Space,
    free: Vec<usize>,
    here: Option<Iterate>,
    /// Roots of the weights of the damping, one per free parameter; never zero.
    lengths: Vec<f64>,
    damping: f64,
    growth: f64,
    /// Decrease that the next step promises, and share of its promise that the last one kept.
    promised: f64,
    kept: f64,
    stopped: Option<StoppedBecause>,
    iterations: u64,
    misfit_evaluations: u64,
    linearisations: u64,
}

impl<'a> Descent<'a> {
    /// With a Jacobian of each iterate.
    pub fn new(loss: Loss, options: Options) -> Self {
        Self::with(loss, options, Source::Fresh(None), FRESH)
    }

    /// Along a model from nearby.
    pub fn along(near: &'a LocalModel, options: Options) -> Self {
        Self::with(near.loss, options, Source::Nearby(near), NEARBY)
    }

    fn with(loss: Loss, options: Options, source: Source<'a>, schedule: Schedule) -> Self {
        Self {
            options,
            loss,
            source,
            schedule,
            space: Space::default(),
            free: Vec::new(),
            here: None,
            lengths: Vec::new(),
            damping: options.damping,
            growth: 2.0,
            promised: 0.0,
            kept: 1.0,
            stopped: None,
            iterations: 0,
            misfit_evaluations: 0,
            linearisations: 0,
        }
    }

    /// What was found, once the executor has returned; `None` if it never ran.
    pub fn finish(self) -> Option<Fit> {
        let here = self.here?;
        let at_bound = here.theta.iter().zip(&self.space.bounds).map(|(t, (lower, upper))| match *t {
            _ if lower == upper => Some(Bound::Held),
            t if t <= *lower => Some(Bound::Lower),
            t if t >= *upper => Some(Bound::Upper),
            _ => None,
        });
        Some(Fit {
            at_bound: at_bound.collect(),
            theta: here.theta,
            misfit: here.misfit,
            cost: here.cost,
            promised: self.promised,
            damping: self.damping,
            iterations: self.iterations,
            misfit_evaluations: self.misfit_evaluations,
            linearisations: self.linearisations,
            stopped: self.stopped?,
            model: match self.source {
                Source::Fresh(model) => model.map(|model| *model),
                Source::Nearby(_) => None,
            },
        })
    }

    /// More damping, and faster so each time in a row.
    fn reject(&mut self) {
        self.damping = (self.damping * self.growth).max(self.schedule.least).max(LEAST_DAMPING);
        self.growth *= 2.0;
    }

    /// Less damping the better the step kept its promise.
    fn accept(&mut self, gain: f64) {
        self.damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
        if self.damping < self.schedule.least {
            self.damping = 0.0;
        }
        self.growth = 2.0;
        self.kept = gain.clamp(0.0, 1.0);
        self.iterations += 1;
    }

    /// Moré's rule: where a parameter loses its influence, its damping stays, or it would run away for good.
    fn lengthen(&mut self, triangle: &Triangle) {
        let norms = triangle.column_norms();
        let most = norms.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        self.lengths.resize(norms.len(), 0.0);
        for (length, norm) in self.lengths.iter_mut().zip(norms) {
            *length = length.max(norm).max(LEAST_LENGTH * most);
        }
    }

    /// The step from an iterate at this damping, as the point that it leads to, and the decrease that it promises.
    fn step(&self, here: &Iterate, damping: f64) -> (Vec<f64>, f64) {
        let root = damping.max(LEAST_DAMPING).sqrt();
        let damping: Vec<f64> = self.lengths.iter().map(|length| length * root).collect();
        let slack: Vec<_> = self.free.iter().map(|&j| self.space.slack(&here.theta, j)).collect();
        let linear = Linear { a: &here.triangle.r, b: &here.triangle.z, damping: &damping };
        let step = bounded_step(linear, &slack);
        let mut theta = here.theta.clone();
        for (d, &j) in step.iter().zip(&self.free) {
            theta[j] += d * self.space.scale[j];
        }
        (self.space.clamp(&theta), here.triangle.predicted_decrease(&step))
    }

    /// The local model at a point, taken there; an error only where its sensitivities are not finite.
    fn linearise<O: Problem>(
        &mut self,
        problem: &mut Counted<O>,
        theta: &[f64],
    ) -> Result<Option<Box<LocalModel>>, Error> {
        self.linearisations += 1;
        let loss = self.loss;
        match problem.problem("linearise_count", |p| Ok(LocalModel::at(p, theta, loss)))? {
            Ok(model) => Ok(Some(Box::new(model))),
            Err(FitError::Start { .. } | FitError::NotFinite(NotFinite::Misfit)) => Ok(None),
            Err(other) => Err(other.into()),
        }
    }

    /// An iterate with the local model taken there.
    fn at_fresh<O: Problem>(&self, problem: &mut Counted<O>, model: &LocalModel) -> Result<Iterate, Error> {
        let (loss, free) = (self.loss, &self.free);
        problem.problem("prior_count", |p| {
            Ok(Iterate {
                cost: cost(p, loss, &model.misfit, &model.theta),
                theta: model.theta.clone(),
                misfit: model.misfit.clone(),
                triangle: model.joined(p, &model.theta, free),
            })
        })
    }

    /// Misfits and cost at a trial point; `None` where the model fails or is not finite.
    fn evaluate<O: Problem>(&mut self, problem: &mut Counted<O>, theta: &[f64]) -> Option<(Vec<f64>, f64)> {
        self.misfit_evaluations += 1;
        let loss = self.loss;
        let tried = problem.problem("misfit_count", |p| {
            Ok(p.misfit(theta).ok().map(|misfit| (cost(p, loss, &misfit, theta), misfit)))
        });
        let (cost, misfit) = tried.ok().flatten()?;
        cost.is_finite().then_some((misfit, cost))
    }

    /// One step that lowers the cost, or the reason why there is none.
    fn advance<O: Problem>(&mut self, problem: &mut Counted<O>, here: &Iterate) -> Result<Advance, Error> {
        let options = self.options;
        loop {
            let (theta, promised) = self.step(here, self.damping);
            self.promised = promised * self.kept;
            let relative_step = self.space.relative_step(&here.theta, &theta);
            let share = promised / here.cost.max(f64::MIN_POSITIVE);
            if promised < options.promise {
                let stopped = StoppedBecause::PromiseTolerance { promised, tolerance: options.promise };
                return Ok(Advance::Stop(stopped));
            }
            if self.iterations >= options.max_iterations {
                return Ok(Advance::Stop(StoppedBecause::MaxIterations { iterations: self.iterations }));
            }
            if theta == here.theta || self.damping > self.schedule.most {
                (self.promised, self.damping) = (0.0, 0.0);
                return Ok(Advance::Stop(StoppedBecause::NoFurtherDecrease { relative_step, promised: share }));
            }
            let Some((misfit, cost)) = self.evaluate(problem, &theta) else {
                self.reject();
                continue;
            };
            let gain = (here.cost - cost) / promised;
            if !(gain > LEAST_GAIN && cost < here.cost) {
                // Below rounding of the cost a rejection says nothing about the model any more.
                if share <= options.function {
                    let (relative_decrease, tolerance) = (share, options.function);
                    return Ok(Advance::Stop(StoppedBecause::FunctionTolerance { relative_decrease, tolerance }));
                }
                if share.abs() < 4.0 * f64::EPSILON || relative_step < options.step {
                    return Ok(Advance::Stop(StoppedBecause::NoFurtherDecrease { relative_step, promised: share }));
                }
                self.reject();
                continue;
            }
            let (next, model) = match self.source {
                Source::Nearby(near) => {
                    let gradient = problem.problem("prior_count", |p| Ok(near.gradient_of(p, &theta, &misfit)))?;
                    let gradient = nalgebra::DVector::from_fn(self.free.len(), |k, _| gradient[self.free[k]]);
                    (Iterate { triangle: here.triangle.with_gradient(&gradient), theta, misfit, cost }, None)
                }
                Source::Fresh(_) => {
                    let Some(model) = self.linearise(problem, &theta)? else {
                        self.reject();
                        continue;
                    };
                    (self.at_fresh(problem, &model)?, Some(model))
                }
            };
            self.accept(gain);
            let relative_decrease = ((here.cost - next.cost) / here.cost).abs().max(share);
            if relative_decrease <= options.function && gain < 2.0 {
                let tolerance = options.function;
                self.stopped = Some(StoppedBecause::FunctionTolerance { relative_decrease, tolerance });
            } else if relative_step <= options.step {
                self.stopped = Some(StoppedBecause::StepTolerance { relative_step, tolerance: options.step });
            }
            return Ok(Advance::To(next, model));
        }
    }

    /// Where the cost is equal up to rounding, the decrease that the linear model promises still tells better from
    /// worse: Gauss-Newton steps as long as they lower it. Without this the parameters keep half the digits of the cost.
    fn polish<O: Problem>(&mut self, problem: &mut Counted<O>, mut here: Iterate) -> Result<Iterate, Error> {
        let (mut theta, mut promised) = self.step(&here, 0.0);
        for _ in 0..MOST_POLISHING {
            if promised > ROUNDED * here.cost || theta == here.theta {
                break;
            }
            let Some(model) = self.linearise(problem, &theta)? else { break };
            let next = self.at_fresh(problem, &model)?;
            self.lengthen(&next.triangle);
            let (next_theta, next_promised) = self.step(&next, 0.0);
            if next_promised >= promised || next.cost > here.cost * (1.0 + NOISE) {
                break;
            }
            (here, theta, promised) = (next, next_theta, next_promised);
            self.source = Source::Fresh(Some(model));
        }
        Ok(here)
    }

    /// Stops if the gradient vanishes at an iterate, and remembers it.
    fn arrive(&mut self, here: Iterate, state: FitState) -> FitState {
        self.lengthen(&here.triangle);
        if self.options.gradient > 0.0 {
            let (cosine, tolerance) = (self.cosine(&here), self.options.gradient);
            if cosine <= tolerance {
                self.stopped = Some(StoppedBecause::GradientTolerance { cosine, tolerance });
            }
        }
        let state = state.param(here.theta.clone()).cost(here.cost);
        self.here = Some(here);
        state
    }

    /// Largest cosine between the misfit and a direction that the bounds leave open.
    fn cosine(&self, here: &Iterate) -> f64 {
        let total = here.triangle.z.norm().hypot(here.triangle.rest);
        let norms = here.triangle.column_norms();
        let gradient = here.triangle.gradient();
        let mut largest = 0.0_f64;
        for (k, &j) in self.free.iter().enumerate() {
            let ((lower, upper), slope) = (self.space.bounds[j], gradient[k]);
            let blocked = (here.theta[j] <= lower && slope > 0.0) || (here.theta[j] >= upper && slope < 0.0);
            if !blocked && norms[k] > 0.0 && total > 0.0 {
                largest = largest.max(slope.abs() / (norms[k] * total));
            }
        }
        largest
    }

    /// The first iterate, at a start inside the bounds.
    fn begin<O: Problem>(&mut self, problem: &mut Counted<O>, start: Vec<f64>) -> Result<Iterate, Error> {
        let near = match self.source {
            Source::Nearby(near) => near,
            Source::Fresh(_) => {
                self.linearisations += 1;
                let loss = self.loss;
                let model = problem.problem("linearise_count", |p| Ok(LocalModel::at(p, &start, loss)))??;
                let here = self.at_fresh(problem, &model)?;
                self.source = Source::Fresh(Some(Box::new(model)));
                return Ok(here);
            }
        };
        expect_length("parameters of the local model", self.space.len(), near.count())?;
        // Where the model was taken its misfits are at hand.
        let misfit = if start == near.theta {
            near.misfit.clone()
        } else {
            self.misfit_evaluations += 1;
            problem.problem("misfit_count", |p| Ok(p.misfit(&start).map_err(FitError::start)))??
        };
        let (loss, free) = (self.loss, &self.free);
        let here = problem.problem("prior_count", |p| {
            let gradient = near.gradient_of(p, &start, &misfit);
            let gradient = nalgebra::DVector::from_fn(free.len(), |k, _| gradient[free[k]]);
            let triangle = near.joined(p, &start, free).with_gradient(&gradient);
            Ok(Iterate { cost: cost(p, loss, &misfit, &start), theta: start, misfit, triangle })
        })?;
        if here.cost.is_finite() { Ok(here) } else { Err(FitError::NotFinite(NotFinite::Misfit).into()) }
    }
}

impl<O: Problem> Solver<O, FitState> for Descent<'_> {
    fn name(&self) -> &str {
        "bounded damped descent"
    }

    fn init(&mut self, problem: &mut Counted<O>, mut state: FitState) -> Result<(FitState, Option<KV>), Error> {
        self.space = problem.problem("bounds_count", |p| Ok(Space::of(p)))??;
        self.free = self.space.free();
        let start = state.take_param().unwrap_or_default();
        expect_length("parameters of the start", self.space.len(), start.len())?;
        let start = self.space.clamp(&start);
        let here = self.begin(problem, start)?;
        Ok((self.arrive(here, state), None))
    }

    fn next_iter(&mut self, problem: &mut Counted<O>, state: FitState) -> Result<(FitState, Option<KV>), Error> {
        let Some(here) = self.here.take() else { return Ok((state, None)) };
        match self.advance(problem, &here)? {
            Advance::To(next, model) => {
                if model.is_some() {
                    self.source = Source::Fresh(model);
                }
                let report = argmin::core::KV::new().merge(argmin::kv!("damping" => self.damping;));
                Ok((self.arrive(next, state), Some(report)))
            }
            Advance::Stop(stopped) => {
                let here = match self.source {
                    Source::Fresh(_) => self.polish(problem, here)?,
                    Source::Nearby(_) => here,
                };
                let state = self.arrive(here, state);
                self.stopped = Some(stopped);
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

/// Fits `problem` from `start` (its `p` parameters; moved into the bounds if outside), with the Jacobian of each iterate.
///
/// # Errors
/// If lengths or bounds do not fit together, the model fails at the start, or a sensitivity is not finite where the fit has
/// arrived.
pub fn fit<P: Problem>(problem: &P, start: &[f64], loss: Loss, options: Options) -> Result<Fit, FitError> {
    run(problem, start, Descent::new(loss, options))
}

/// The same along a local model from nearby, with its loss.
///
/// # Errors
/// As [`fit`].
pub fn fit_along<P: Problem>(problem: &P, near: &LocalModel, start: &[f64], options: Options) -> Result<Fit, FitError> {
    run(problem, start, Descent::along(near, options))
}

fn run<P: Problem>(problem: &P, start: &[f64], descent: Descent<'_>) -> Result<Fit, FitError> {
    let executor = Executor::new(problem, descent)
        .configure(|state: FitState| state.param(start.to_vec()))
        .timer(false)
        .ctrlc(false);
    let result = executor.run().map_err(|error| match error.downcast::<FitError>() {
        Ok(known) => known,
        Err(other) => FitError::Executor { source: other.into() },
    })?;
    let never_ran = || FitError::Executor { source: "no iteration was run".into() };
    result.solver.finish().ok_or_else(never_ran)
}
