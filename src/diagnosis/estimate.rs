//! From a record to its explanation: weights, starts, isolation, until nothing moves any more.

use super::case::{Case, Set, members};
use super::hypotheses::{Isolation, MOST_ROUNDS, isolate, simpler, unseen};
use super::noise::{self, Weights};
use super::prior::Gaussian;
use super::problem::RecordProblem;
use crate::complaint::{Complaint, Kind, Place};
use crate::fit::{self, FitError, Loss, Problem, Tolerances};
use crate::model::{Drive, Model, SimulationError, Tolerance};
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Quantity, Target};

/// Width of the loss while the faults are still far off: large misfits keep pulling, but not with their square.
const FAR: Loss = Loss::SoftL1 { k: 10.0 };
/// Shares of the way to a bound at which single faults are simulated before any is fitted.
const LEVELS: [f64; 3] = [0.2, 0.5, 0.75];
/// The same for each of a pair.
const PAIRED: [f64; 1] = [0.45];
/// How many of them are fitted from.
const FITTED: usize = 3;
/// Share to which the pressures at the start are known.
const START: f64 = 0.01;
/// Cost per sample from which on a start is taken to have missed; noise alone costs 1/2.
const POOR: f64 = 1.0;
/// Relative decrease of the cost that ends the search for the neighbourhood.
const NEIGHBOURHOOD: f64 = 1e-3;
/// Iterations after which a start that has not found a neighbourhood is given up.
const FIRST_ITERATIONS: u64 = 25;
/// Most rounds of isolation and renewed weights. Weights hang on the fit only through when things happen, so two are
/// enough unless the start was far.
const MOST_RENEWALS: usize = 3;
/// Rounds of isolation from the healthy rig: what it takes where the faults are small or those of sensors.
pub const FROM_HEALTHY: u64 = 2;
/// Standard errors by which no fault moves any more when the rounds end.
const SETTLED: f64 = 0.3;

/// The explanation of a record.
pub struct Estimate<'a> {
    pub case: Case<'a>,
    pub isolation: Isolation,
}

/// The columns of a record that the rig's sensors read, SI.
///
/// # Errors
/// A column that is missing or of another dimension.
pub fn measured<'a>(model: &Model, record: &'a Record) -> Result<Vec<&'a [f64]>, Complaint> {
    model
        .rig
        .sensors
        .iter()
        .map(|sensor| {
            let channel = record.require(&sensor.column, sensor.quantity.dimension(), sensor.place.clone())?;
            Ok(channel.values.as_slice())
        })
        .collect()
}

/// Explains a record by faults of the rig: from a guess of all estimated parameters and the set of faults or else from the
/// healthy rig; where that misses, from the places that few faults at a time explain best.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved at any start.
pub fn estimate<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a Drive,
    guess: Option<(&[f64], Set)>,
) -> Result<Estimate<'a>, Complaint> {
    let near = near(model, record, drive, guess, if guess.is_some() { MOST_ROUNDS } else { FROM_HEALTHY })?;
    if near.missed() { screened(near) } else { Ok(near) }
}

/// Explains a record from a guess or from the healthy rig alone, in so many rounds; it may miss.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved there.
pub fn near<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a Drive,
    guess: Option<(&[f64], Set)>,
    rounds: u64,
) -> Result<Estimate<'a>, Complaint> {
    let data = measured(model, record)?;
    let mut case = Case::new(model, record, drive, Vec::new(), rough(model, record, drive, &data));
    case.full.measured = data;
    let healthy = case.mean.clone();
    let (start, set) = guess.unwrap_or((&healthy[..], 0));
    let isolation = settle(&mut case, start, set, rounds)
        .map_err(|error| failed(model, record, &FitError::Start { source: error.into() }))?;
    Ok(Estimate { case, isolation })
}

/// Explains a record anew from the places that few faults at a time explain best, if any of them does better.
///
/// # Errors
/// A model that cannot be solved at any start.
pub fn screened(mut before: Estimate<'_>) -> Result<Estimate<'_>, Complaint> {
    let case = &mut before.case;
    let (model, record) = (case.full.model, case.record);
    let rough = rough(model, record, case.full.drive, &case.full.measured);
    let mut best = (before.isolation, std::mem::replace(&mut case.full.weights, rough.clone()));
    let places = sparsest(case);
    for place in places.into_iter().take(FITTED) {
        // A place from which the model cannot be solved is passed over.
        let Ok(theta) = neighbourhood(case, &place) else { continue };
        case.full.weights = rough.clone();
        let Ok(isolation) = settle(case, &theta, 0, MOST_ROUNDS) else { continue };
        let missed = missed(case, &isolation);
        if isolation.best.cost < best.0.best.cost || !missed {
            best = (isolation, case.full.weights.clone());
        }
        if !missed {
            break;
        }
    }
    (before.isolation, before.case.full.weights) = best;
    Ok(before)
}

fn failed(model: &Model, record: &Record, error: &FitError) -> Complaint {
    Complaint::new(Kind::Computation, format!("the faults could not be fitted: {error}"))
        .at(Place::file(&model.rig.path))
        .at(Place::file(&record.path))
        .help("check values and units of the rig with `borescope check`")
}

impl Estimate<'_> {
    /// Goes on from other values of the estimated parameters, SI; stays where that cannot be solved.
    #[must_use]
    pub fn resumed(mut self, theta: &[f64]) -> Self {
        let set = self.isolation.set();
        if let Ok(isolation) = settle(&mut self.case, theta, set, MOST_ROUNDS) {
            self.isolation = isolation;
        }
        self
    }

    /// Whether it leaves more than noise unexplained.
    pub fn missed(&self) -> bool {
        missed(&self.case, &self.isolation)
    }
}

fn missed(case: &Case<'_>, isolation: &Isolation) -> bool {
    let samples = (case.full.times.len() * case.full.measured.len()) as f64;
    isolation.best.cost > 2.0 * POOR * samples
}

/// Weights from the record alone, before any model has followed it.
fn rough(model: &Model, record: &Record, drive: &Drive, data: &[&[f64]]) -> Weights {
    let rig = &model.rig;
    let variance = noise::variances(rig, record, data, true);
    let phases = noise::phases(rig, drive, &record.time, &variance);
    Weights::new(rig, &phases, &variance, &[])
}

/// Explains the record from a guess. Where that does, weights are renewed where the explanation puts the events, and the
/// explanation with them, until no fault moves.
fn settle(case: &mut Case<'_>, guess: &[f64], set: Set, most_rounds: u64) -> Result<Isolation, SimulationError> {
    let mut isolation = isolate(case, guess, set, most_rounds)?;
    for _ in 0..MOST_RENEWALS {
        if most_rounds < MOST_ROUNDS && missed(case, &isolation) {
            break;
        }
        case.full.weights = weights(&case.full, case.record, &isolation.best.theta)?;
        let before = isolation;
        isolation = isolate(case, &before.best.theta, before.set(), most_rounds)?;
        let still = |fault: usize| {
            let sigma = isolation.reduced.sigma(isolation.set(), fault);
            let sigma = sigma.map_or(case.range(fault), |sigma| sigma * isolation.quadratic.scale[fault]);
            (isolation.best.theta[fault] - before.best.theta[fault]).abs() <= SETTLED * sigma
        };
        if isolation.set() != before.set() || !members(isolation.set()).all(still) {
            continue;
        }
        // What the form cannot see from here may explain the record better.
        let Some((set, point)) = unseen(case, &isolation).or_else(|| simpler(case, &isolation)) else { break };
        isolation = isolate(case, &point.theta, set, most_rounds)?;
    }
    Ok(isolation)
}

/// The problem of the components' faults alone, solved coarsely.
fn coarse<'a>(case: &Case<'a>, model: &'a Model) -> (RecordProblem<'a>, Vec<usize>) {
    let of_component: Vec<usize> = (0..case.faults()).filter(|&fault| !case.is_of_sensor(fault)).collect();
    let full = &case.full;
    let estimated = of_component.iter().map(|&fault| full.estimated[fault].clone()).collect();
    let (measured, weights) = (full.measured.clone(), full.weights.clone());
    let mut coarse = RecordProblem::new(model, full.drive, full.times, measured, weights, estimated, Gaussian::none());
    coarse.base.clone_from(&full.base);
    (coarse, of_component)
}

/// A model that is solved as coarsely as a first search allows.
fn coarsely(model: &Model) -> Model {
    let mut model = model.clone();
    model.tolerance = Tolerance::COARSE;
    model
}

/// Few faults of components at a time, those that explain the record best first: `[place][fault of a component]`, SI.
fn sparsest(case: &Case<'_>) -> Vec<Vec<f64>> {
    let model = coarsely(case.full.model);
    let (coarse, of_component) = coarse(case, &model);
    let healthy: Vec<f64> = of_component.iter().map(|&fault| case.mean[fault]).collect();
    let mut screened: Vec<(f64, Vec<f64>)> = sparse(&healthy, coarse.bounds())
        .into_iter()
        .filter_map(|theta| Some((FAR.cost(&coarse.misfit(&theta).ok()?), theta)))
        .collect();
    screened.sort_by(|a, b| a.0.total_cmp(&b.0));
    screened.into_iter().map(|(_, theta)| theta).collect()
}

/// Where the faults of components alone come from a place: all estimated parameters, SI.
fn neighbourhood(case: &Case<'_>, place: &[f64]) -> Result<Vec<f64>, FitError> {
    let model = coarsely(case.full.model);
    let (coarse, of_component) = coarse(case, &model);
    let tolerances = Tolerances { function: NEIGHBOURHOOD, max_iterations: FIRST_ITERATIONS, ..Tolerances::default() };
    let found = fit::fit(&coarse, place, FAR, tolerances)?;
    let mut theta = case.mean.clone();
    for (&fault, value) in of_component.iter().zip(&found.theta) {
        theta[fault] = *value;
    }
    Ok(theta)
}

/// Few faults at a time, each at a few levels towards each of its bounds: healthy, singles and pairs.
fn sparse(healthy: &[f64], bounds: &[(f64, f64)]) -> Vec<Vec<f64>> {
    let levels = |i: usize, shares: &'static [f64]| {
        let ends = [bounds[i].0, bounds[i].1].into_iter().filter(move |&end| end != healthy[i]);
        ends.flat_map(move |end| shares.iter().map(move |share| healthy[i] + share * (end - healthy[i])))
    };
    let with = |point: &[f64], i: usize, at: f64| {
        let mut point = point.to_vec();
        point[i] = at;
        point
    };
    let mut points = vec![healthy.to_vec()];
    for a in 0..healthy.len() {
        points.extend(levels(a, &LEVELS).map(|at| with(healthy, a, at)));
        for at in levels(a, &PAIRED) {
            let single = with(healthy, a, at);
            points.extend(
                (0..a).flat_map(|b| levels(b, &PAIRED).map(move |at| (b, at))).map(|(b, at)| with(&single, b, at)),
            );
        }
    }
    points
}

/// Weights at `theta`: events where the model has them, time constants uncertain anew in each phase.
pub(crate) fn weights(problem: &RecordProblem<'_>, record: &Record, theta: &[f64]) -> Result<Weights, SimulationError> {
    let Events { variance, phases, changes } = events(problem, record, theta)?;
    Ok(Weights::new(&problem.model.rig, &phases, &variance, &changes))
}

/// What weights are made of, but for the tolerances.
pub(crate) struct Events {
    /// Of each sample, `[sensor][row]`, SI squared.
    pub variance: Vec<Vec<f64>>,
    /// Rows between events.
    pub phases: Vec<std::ops::Range<usize>>,
    /// Of all readings, by one standard deviation of what may be another in each phase: `[what][sensor][row]`, SI.
    pub changes: Vec<Vec<Vec<f64>>>,
}

/// Events at `theta`, where the model has them.
pub(crate) fn events(problem: &RecordProblem<'_>, record: &Record, theta: &[f64]) -> Result<Events, SimulationError> {
    let model = problem.model;
    let rig = &model.rig;
    let constants: Vec<usize> = rig
        .parameters
        .iter()
        .enumerate()
        .filter(|(index, parameter)| parameter.sigma > 0.0 && parameter.anew && !rig.is_fault(*index))
        .map(|(index, _)| index)
        .collect();
    let parameters = problem.parameters(theta);
    let outputs = model.simulate(&parameters, problem.drive, problem.times)?.values;
    let solved =
        model.sensitivities_within(Tolerance::SLOPES, &parameters, &constants, problem.drive, problem.times)?;
    let curves: Vec<&[f64]> = outputs.iter().map(Vec::as_slice).collect();
    let variance = noise::variances(rig, record, &curves, false);
    let phases = noise::phases(rig, problem.drive, problem.times, &variance);
    let mut changes: Vec<Vec<Vec<f64>>> = solved
        .derivatives
        .into_iter()
        .zip(&constants)
        .map(|(mut derivative, &constant)| {
            derivative.iter_mut().flatten().for_each(|value| *value *= rig.parameters[constant].sigma);
            derivative
        })
        .collect();
    let late = noise::input_timing(rig, record);
    if late > 0.0
        && let Ok(drive) = Drive::from_late_record(rig, record, late)
    {
        let mut shifted = model.simulate(&parameters, &drive, problem.times)?.values;
        for (late, plain) in shifted.iter_mut().zip(&outputs) {
            late.iter_mut().zip(plain).for_each(|(late, plain)| *late -= plain);
        }
        changes.push(shifted);
    }
    // Where the pressures start is known no better than a sensor shows, nor than to a hundredth.
    let first = phases.first().map_or(0, |phase| phase.end);
    for (node, start) in rig.nodes.iter().enumerate() {
        let NodeKind::Volume { initial } = start.kind else { continue };
        let shown = rig
            .sensors
            .iter()
            .filter(|sensor| sensor.target == Target::Node(node) && sensor.quantity == Quantity::Pressure);
        let known = match initial {
            InitialPressure::Given(pressure) => START * pressure.abs(),
            InitialPressure::Balance | InitialPressure::Record => START * problem.drive.readings[node].abs(),
        };
        let mut drive = problem.drive.clone();
        drive.nudges[node] = shown.map(|sensor| sensor.noise).fold(known, f64::max);
        if drive.nudges[node] == 0.0 {
            continue;
        }
        let mut nudged = model.simulate(&parameters, &drive, &problem.times[..first])?.values;
        for (nudged, plain) in nudged.iter_mut().zip(&outputs) {
            nudged.iter_mut().zip(plain).for_each(|(nudged, plain)| *nudged -= plain);
            nudged.resize(plain.len(), 0.0);
        }
        changes.push(nudged);
    }
    Ok(Events { variance, phases, changes })
}
