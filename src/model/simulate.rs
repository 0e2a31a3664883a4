//! Simulation and sensitivities of a rig over a drive.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::assembly::{Assembly, Inputs};
use super::drive::{Before, InputSignals};
use super::layout::Layout;
use super::outcome::{Outputs, Sensitivities, SimulationError, SolverEffort, Tolerance};
use super::slopes::LANES;
use super::start;

use crate::numeric::{Options, Rosenbrock, Step};
use crate::physics::effect::{self, Form};
use crate::rig::{InstalledEffect, Location, NodeKind, Parameter, Rig};

/// Most parameters whose sensitivities are carried along with one integration.
const GROUP: usize = 32;
/// Fewest parameters for which a second integration pays: then another thread leads half of them.
const SHARED: usize = 2 * LANES;

/// Step of the differences by a dead time, as a share of its standard deviation: far more than the solver errs. What is quicker than that is
/// smoothed by it.
const DEAD_TIME_STEP: f64 = 0.25;
/// Standard deviation of one that is exact, s.
const LEAST_DEVIATION: f64 = 1e-4;

/// Steps that a run may take besides those of its rows, and for each row: half a period, the fastest that a record shows, takes
/// about 20.
const STEPS: usize = 100_000;
const STEPS_PER_ROW: usize = 20;
/// Steps that a run may reject for each jump of an input, and for each row. The strokes of the measured rigs reject 35 behind a jump
/// and one in seven rows. A bend that comes without notice costs about four, and of several between two rows a record shows one.
const REJECTED_PER_JUMP: usize = 1000;
const REJECTED_PER_ROW: usize = 4;

/// The same with limits to the steps of a run: a formula that jumps a thousand times a second would make a fit last for ever.
fn limited<const N: usize>(options: Options<N>, drive: &InputSignals, rows: usize) -> Options<N> {
    let rows = rows.max(drive.pieces.len());
    let jumps = 1 + drive.pieces.iter().filter(|piece| piece.jump).count();
    Options {
        max_steps: STEPS + STEPS_PER_ROW * rows,
        max_rejected: REJECTED_PER_JUMP * jumps + REJECTED_PER_ROW * rows,
        ..options
    }
}

/// A rig with its equations laid out.
#[derive(Debug, Clone)]
pub struct Model {
    /// With the values of its parameters as the rig file has them.
    pub rig: Rig,
    layout: Layout,
    /// Accuracy of the integration.
    #[doc(hidden)]
    pub tolerance: Tolerance,
}

macro_rules! with_states {
    ($states:expr, $N:ident => $body:expr) => {
        match $states {
            0..=4 => {
                const $N: usize = 4;
                $body
            }
            5..=8 => {
                const $N: usize = 8;
                $body
            }
            9..=12 => {
                const $N: usize = 12;
                $body
            }
            13..=16 => {
                const $N: usize = 16;
                $body
            }
            17..=24 => {
                const $N: usize = 24;
                $body
            }
            // Plants: loops over states that are not there cost less than one more size to compile.
            25..=$crate::numeric::MOST_STATES => {
                const $N: usize = $crate::numeric::MOST_STATES;
                $body
            }
            states => Err(SimulationError::TooLarge { states, most: $crate::numeric::MOST_STATES }),
        }
    };
}

// Behind the macro that they use.
mod explicit;
mod sensitive;

impl Model {
    /// The equations of a rig, solved with the default accuracy.
    #[doc(hidden)]
    pub fn new(rig: Rig) -> Self {
        let layout = Layout::of(&rig);
        Self { rig, layout, tolerance: Tolerance::default() }
    }

    /// The same, solved with this accuracy.
    #[doc(hidden)]
    pub fn with_tolerance(self, tolerance: Tolerance) -> Self {
        Self { tolerance, ..self }
    }

    /// Names of the states, in their order.
    pub fn states(&self) -> &[String] {
        &self.layout.names
    }

    /// What the sensors read at `times` (rising, s, within the drive) for one set of parameters (all of the rig's, SI).
    ///
    /// # Errors
    /// The integrator gives up: parameters without physical sense, or a circuit that tears.
    #[doc(hidden)]
    pub fn solve(&self, parameters: &[f64], drive: &InputSignals, times: &[f64]) -> Result<Outputs, SimulationError> {
        self.rig.context().solved(false);
        let (values, effort) = with_states!(self.layout.states, N => self.readings::<N>(parameters, drive, times))?;
        Ok(Outputs { values, effort })
    }

    /// The same with derivatives by the parameters `by` (indices), along the plain run's steps.
    ///
    /// # Errors
    /// As [`Model::solve`].
    #[doc(hidden)]
    pub fn sensitivities(
        &self,
        parameters: &[f64],
        by: &[usize],
        drive: &InputSignals,
        times: &[f64],
    ) -> Result<Sensitivities, SimulationError> {
        let late: Vec<usize> =
            self.rig.fitted_dead_times().map(|(_, own)| own).filter(|own| by.contains(own)).collect();
        if !late.is_empty() {
            return self.sensitivities_by_dead_times((parameters, drive, times), by, &late);
        }
        self.rig.context().solved(true);
        let least = if by.len() > SHARED { 2 } else { 1 };
        let groups = by.len().div_ceil(GROUP).max(least);
        // Whole registers in each, and as many in one as in another.
        let length = by.len().div_ceil(groups * LANES).max(1) * LANES;
        let groups: Vec<&[usize]> = by.chunks(length).collect();
        let solve =
            |group: &[usize]| with_states!(self.layout.states, N => self.group::<N>(parameters, group, drive, times));
        // Groups are independent, so threads change nothing but the time.
        let solved: Result<Vec<Sensitivities>, _> =
            self.rig.context().on_threads(|| groups.par_iter().map(|&group| solve(group)).collect());
        let all = solved?.into_iter().reduce(|mut all, part| {
            all.derivatives.extend(part.derivatives);
            all
        });
        match all {
            Some(all) => Ok(all),
            None => Ok(Sensitivities { outputs: self.solve(parameters, drive, times)?, derivatives: Vec::new() }),
        }
    }

    /// Derivatives where some are by dead times of inputs, `late`: those by differences of two runs, since what drives the rig carries none.
    fn sensitivities_by_dead_times(
        &self,
        (parameters, drive, times): (&[f64], &InputSignals, &[f64]),
        by: &[usize],
        late: &[usize],
    ) -> Result<Sensitivities, SimulationError> {
        let others: Vec<usize> = by.iter().copied().filter(|one| !late.contains(one)).collect();
        let Sensitivities { outputs, derivatives } = self.sensitivities(parameters, &others, drive, times)?;
        let mut derivatives = derivatives.into_iter();
        let shifted = |own: usize, step: f64| {
            let mut parameters = parameters.to_vec();
            parameters[own] += step;
            self.solve(&parameters, drive, times)
        };
        let column = |&own: &usize| {
            if !late.contains(&own) {
                return Ok(derivatives.next().unwrap_or_default());
            }
            let Parameter { sigma, spread, .. } = self.rig.parameters[own];
            let step = DEAD_TIME_STEP * if sigma > 0.0 { sigma } else { spread.max(LEAST_DEVIATION) };
            let (mut later, sooner) = (shifted(own, step)?.values, shifted(own, -step)?.values);
            for (later, sooner) in later.iter_mut().flatten().zip(sooner.iter().flatten()) {
                *later = (*later - sooner) / (2.0 * step);
            }
            Ok(later)
        };
        let derivatives = by.iter().map(column).collect::<Result<_, SimulationError>>()?;
        Ok(Sensitivities { outputs, derivatives })
    }

    /// The formula of the rig file that acts on a state, with its effect.
    fn formula_on(&self, state: usize) -> Option<String> {
        let acts_on = |node: usize| {
            let is_body = matches!(self.rig.nodes[node].kind, NodeKind::Body { .. });
            let first = self.layout.node_state[node];
            first.is_some_and(|first| state == first || (is_body && state == first + 1))
        };
        let acts = |present: &&InstalledEffect| match (present.placed.spot, present.placed.effect.form) {
            (Location::Node(node), _) => acts_on(node),
            (Location::Component(component), Form::PressureLoss { .. }) => {
                self.rig.components[component].ports.iter().any(|&node| acts_on(node))
            }
            _ => false,
        };
        let formula =
            |present: &&InstalledEffect| present.placed.effect.form.card().is_some_and(|card| card.formula.is_some());
        let present = self.rig.effects.iter().filter(formula).find(acts)?;
        Some(format!("`{}` of `{}`", present.placed.effect.law, present.id))
    }

    /// What the sensors show, `[sensor][row]`, with what effects do to it.
    fn readings<const N: usize>(
        &self,
        parameters: &[f64],
        drive: &InputSignals,
        times: &[f64],
    ) -> Result<(Vec<Vec<f64>>, SolverEffort), SimulationError> {
        let mut readings = Readings(vec![vec![0.0; times.len()]; self.rig.sensors.len()]);
        let effort = self.run::<N>(parameters, drive, times, &mut readings)?;
        let Readings(mut readings) = readings;
        self.read_by_effects(parameters, drive, times, &mut readings);
        Ok((readings, effort))
    }

    /// What effects do to the readings of sensors.
    fn read_by_effects(&self, parameters: &[f64], drive: &InputSignals, times: &[f64], readings: &mut [Vec<f64>]) {
        for does in &self.rig.readings {
            let own = &parameters[does.first_parameter..][..does.card.parameters.len()];
            effect::read(does.card, own, drive.begun, times, &mut readings[does.sensor]);
        }
    }

    fn run<const N: usize>(
        &self,
        parameters: &[f64],
        drive: &InputSignals,
        times: &[f64],
        watch: &mut impl Watch<N>,
    ) -> Result<SolverEffort, SimulationError> {
        let (tolerance, context) = (self.tolerance, self.rig.context());
        let acting = drive.with_dead_times(&self.rig, parameters);
        let drive = acting.as_ref();
        let changed: &[(usize, Before)] = drive.onset.as_ref().map_or(&[], |onset| &onset.before);
        let (before, moment) = drive.before(parameters);
        let after = parameters;
        let begun = |t: f64| t >= moment;
        let mut parameters: &[f64] = &before;
        let mut assembly = Assembly::new(&self.rig, &self.layout, parameters);
        let mut atol = [1.0; N];
        for (atol, scale) in atol.iter_mut().zip(&self.layout.scales) {
            *atol = scale * tolerance.absolute;
        }
        let mut integrator = Rosenbrock::new(limited(Options::new(tolerance.relative, atol), drive, times.len()));
        let mut y = [0.0; N];
        let mut raw = vec![0.0; self.rig.sensors.len()];
        let mut row = 0;
        // The samples of a step are written after it: the integrator holds the assembly while it runs.
        let mut samples: Vec<(usize, [f64; N])> = Vec::new();
        for (index, piece) in drive.pieces.iter().enumerate() {
            let begins = begun(piece.start) && !std::ptr::eq(parameters, after);
            if begins {
                parameters = after;
                assembly = Assembly::new(&self.rig, &self.layout, parameters);
            }
            assembly.inputs = Inputs::of(piece, drive.begun);
            if index == 0 {
                start::start(&self.rig, &self.layout, &mut assembly, parameters, drive, piece.start, &mut y);
                watch.start(parameters, if begins { &[] } else { changed }, &assembly.inputs, piece.start);
            } else if begins {
                watch.change(parameters);
            }
            watch.piece(&assembly.inputs);
            if piece.jump {
                integrator.restart();
            }
            let sensors = &self.rig.sensors;
            let mut emit = |assembly: &mut Assembly<'_, f64>, watch: &mut _, row: usize, y: &[f64; N]| {
                assembly.raw_values(times[row], y, &mut raw);
                for (index, (sensor, &raw)) in sensors.iter().zip(&raw).enumerate() {
                    let (offset, gain) = (parameters[sensor.first_parameter], parameters[sensor.first_parameter + 1]);
                    Watch::<N>::reading(watch, row, index, raw, raw * gain + offset);
                }
            };
            while row < times.len() && times[row] <= piece.start {
                watch.at_rest(row, times[row], &y);
                emit(&mut assembly, watch, row, &y);
                row += 1;
            }
            let last = index + 1 == drive.pieces.len();
            samples.clear();
            context.check()?;
            let result = integrator.integrate_until(&mut assembly, piece.start, &y, piece.end, |step| {
                watch.step(step);
                while row < times.len() && (times[row] <= step.t_end || (last && step.t_end >= piece.end)) {
                    let t = times[row].min(step.t_end);
                    let y = step.interpolate_all(t);
                    watch.sample(step, row, t, &y);
                    samples.push((row, y));
                    row += 1;
                }
                if context.is_cancelled() { ControlFlow::Break(step.t_end) } else { ControlFlow::Continue(()) }
            });
            for (row, y) in &samples {
                emit(&mut assembly, watch, *row, y);
            }
            let arrival = result.map_err(|error| {
                let worst = error.worst_state();
                let state = worst.and_then(|state| self.layout.names.get(state)).cloned().unwrap_or_default();
                let formula = worst.and_then(|state| self.formula_on(state));
                SimulationError::Integration { error, state, formula }
            })?;
            context.check()?;
            y = arrival.y;
            if row == times.len() {
                break;
            }
        }
        let stats = integrator.stats();
        Ok(SolverEffort { steps: stats.steps, rejected: stats.rejected })
    }
}

/// What goes along with a run.
trait Watch<const N: usize> {
    /// The run begins with these parameters (all of the rig's, SI), those of `changed` as they were.
    fn start(&mut self, _parameters: &[f64], _changed: &[(usize, Before)], _inputs: &Inputs, _t: f64) {}

    /// From here on these are the parameters.
    fn change(&mut self, _parameters: &[f64]) {}

    /// From here on these are the inputs.
    fn piece(&mut self, _inputs: &Inputs) {}

    /// A step was taken.
    fn step(&mut self, _step: &Step<'_, f64, N>) {}

    /// A row lies at the beginning, before any step.
    fn at_rest(&mut self, _row: usize, _t: f64, _y: &[f64; N]) {}

    /// A row lies in the step at `t`.
    fn sample(&mut self, _step: &Step<'_, f64, N>, _row: usize, _t: f64, _y: &[f64; N]) {}

    /// What a sensor sees, and what it shows; after all else of the row.
    fn reading(&mut self, row: usize, sensor: usize, raw: f64, shown: f64);
}

/// Keeps nothing but what the sensors show.
struct Readings(Vec<Vec<f64>>);

impl<const N: usize> Watch<N> for Readings {
    fn reading(&mut self, row: usize, sensor: usize, _raw: f64, shown: f64) {
        self.0[sensor][row] = shown;
    }
}
