//! From a record to its explanation: weights, starts, isolation, until nothing moves any more.

use super::case::{Case, members};
use super::hypotheses::{Isolation, isolate};
use super::noise::{self, Weights};
use super::prior::Gaussian;
use super::problem::{Estimated, RecordProblem};
use crate::complaint::{Complaint, Kind, Place};
use crate::fit::{self, FitError, Loss, Starts, Tolerances};
use crate::model::{Drive, Model, SimulationError, Tolerance};
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Quantity, Target};

/// Width of the loss while the faults are still far off: large misfits keep pulling, but not with their square.
const FAR: f64 = 10.0;
/// Points of the fault box that are simulated before any is fitted from, per fault.
const SAMPLED_PER_FAULT: usize = 10;
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
const MOST_ROUNDS: usize = 4;
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

/// Explains a record by faults of the rig, from the healthy rig or from `guess` (all estimated parameters).
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved at any start.
pub fn estimate<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a Drive,
    seed: u64,
    guess: Option<&[f64]>,
) -> Result<Estimate<'a>, Complaint> {
    let rig = &model.rig;
    let data = measured(model, record)?;
    let failed = |error: FitError| {
        Complaint::new(Kind::Computation, format!("the faults could not be fitted: {error}"))
            .at(Place::file(&rig.path))
            .at(Place::file(&record.path))
            .help("check values and units of the rig with `borescope check`")
    };
    let unsolved = |error: SimulationError| failed(FitError::Start { source: error.into() });
    let variance = noise::variances(rig, record, &data, true);
    let phases = noise::phases(rig, drive, &record.time, &variance);
    let rough = Weights::new(rig, &phases, &variance, &[]);
    let mut case = Case::new(model, record, drive, data, rough.clone());
    let start = guess.map_or_else(|| case.mean.clone(), <[f64]>::to_vec);
    let mut best = settle(&mut case, &start);
    let samples = (case.full.times.len() * case.full.measured.len()) as f64;
    let missed =
        |found: &Found| found.as_ref().map_or(true, |(isolation, _)| isolation.best.cost > 2.0 * POOR * samples);
    if guess.is_none() && missed(&best) {
        case.full.weights = rough.clone();
        for theta in neighbourhoods(&case, seed).map_err(failed)? {
            case.full.weights = rough.clone();
            let other = settle(&mut case, &theta);
            let cost = |found: &Found| found.as_ref().map_or(f64::INFINITY, |(isolation, _)| isolation.best.cost);
            if cost(&other) < cost(&best) {
                best = other;
            }
            if !missed(&best) {
                break;
            }
        }
    }
    let (isolation, weights) = best.map_err(unsolved)?;
    case.full.weights = weights;
    Ok(Estimate { case, isolation })
}

/// An explanation and the weights it was found with.
type Found = Result<(Isolation, Weights), SimulationError>;

/// Explains the record from a guess; renews the weights where the explanation puts the events, and the explanation with
/// them, until no fault moves.
fn settle(case: &mut Case<'_>, guess: &[f64]) -> Found {
    let mut isolation = isolate(case, guess)?;
    for _ in 0..MOST_ROUNDS {
        case.full.weights = weights(&case.full, case.record, &isolation.best.theta)?;
        let before = isolation;
        isolation = isolate(case, &before.best.theta)?;
        let still = |fault: usize| {
            let sigma = isolation.reduced.sigma(isolation.set(), fault);
            let sigma = sigma.map_or(case.range(fault), |sigma| sigma * isolation.quadratic.scale[fault]);
            (isolation.best.theta[fault] - before.best.theta[fault]).abs() <= SETTLED * sigma
        };
        if isolation.set() == before.set() && members(isolation.set()).all(still) {
            break;
        }
    }
    Ok((isolation, case.full.weights.clone()))
}

/// Places to start from that the faults of components alone explain best.
fn neighbourhoods(case: &Case<'_>, seed: u64) -> Result<Vec<Vec<f64>>, FitError> {
    let rig = case.rig();
    let of_component: Vec<usize> = (0..case.faults())
        .filter(|&fault| {
            !rig.sensors.iter().any(|sensor| {
                (sensor.first_parameter..sensor.first_parameter + 2).contains(&rig.faults[fault].parameter)
            })
        })
        .collect();
    let mut coarse_model = case.full.model.clone();
    coarse_model.tolerance = Tolerance::COARSE;
    let estimated: Vec<Estimated> = of_component.iter().map(|&fault| case.full.estimated[fault].clone()).collect();
    let full = &case.full;
    let mut coarse = RecordProblem::new(
        &coarse_model,
        full.drive,
        full.times,
        full.measured.clone(),
        full.weights.clone(),
        estimated,
        Gaussian::none(),
    );
    coarse.base.clone_from(&full.base);
    let tolerances = Tolerances { function: NEIGHBOURHOOD, max_iterations: FIRST_ITERATIONS, ..Tolerances::default() };
    let starts = Starts {
        given: vec![of_component.iter().map(|&fault| case.mean[fault]).collect()],
        sampled: SAMPLED_PER_FAULT * of_component.len(),
        fitted: FITTED,
        seed,
    };
    let found = fit::multi_start(&coarse, &starts, Loss::SoftL1 { k: FAR }, tolerances)?;
    Ok(found
        .optima
        .iter()
        .map(|optimum| {
            let mut theta = case.mean.clone();
            for (&fault, value) in of_component.iter().zip(&optimum.theta) {
                theta[fault] = *value;
            }
            theta
        })
        .collect())
}

/// Weights at `theta`: events where the model has them, time constants uncertain anew in each phase.
pub(crate) fn weights(problem: &RecordProblem<'_>, record: &Record, theta: &[f64]) -> Result<Weights, SimulationError> {
    let model = problem.model;
    let rig = &model.rig;
    let constants: Vec<usize> = rig
        .parameters
        .iter()
        .enumerate()
        .filter(|(index, parameter)| parameter.sigma > 0.0 && parameter.anew && !rig.is_fault(*index))
        .map(|(index, _)| index)
        .collect();
    let solved = model.sensitivities(&problem.parameters(theta), &constants, problem.drive, problem.times)?;
    let curves: Vec<&[f64]> = solved.outputs.values.iter().map(Vec::as_slice).collect();
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
        let mut shifted = model.simulate(&problem.parameters(theta), &drive, problem.times)?.values;
        for (late, plain) in shifted.iter_mut().zip(&solved.outputs.values) {
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
        let mut nudged = model.simulate(&problem.parameters(theta), &drive, &problem.times[..first])?.values;
        for (nudged, plain) in nudged.iter_mut().zip(&solved.outputs.values) {
            nudged.iter_mut().zip(plain).for_each(|(nudged, plain)| *nudged -= plain);
            nudged.resize(plain.len(), 0.0);
        }
        changes.push(nudged);
    }
    Ok(Weights::new(rig, &phases, &variance, &changes))
}
