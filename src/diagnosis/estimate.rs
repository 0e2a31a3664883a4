//! Identification: the faults of a rig fitted to a record, together with everything else that is uncertain.

use super::noise::{self, Weights};
use super::prior::Gaussian;
use super::problem::{Estimated, RecordProblem};
use crate::complaint::{Complaint, Kind, Place};
use crate::fit::{self, Fit, FitError, Loss, MultiStart, Starts, Tolerances, Uncertainty, UncertaintyOptions};
use crate::model::{Drive, Model, SimulationError, Tolerance};
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Quantity, Target};

/// Uncertain parameters are searched this many standard deviations to both sides.
const REACH: f64 = 5.0;
/// A misfit of more standard deviations pulls with constant force only (Huber); one sample in 400 is beyond by chance.
const ROBUST: f64 = 3.0;
/// Width of the loss while the faults are still far off: large misfits keep pulling, but not with their square.
const FAR: f64 = 10.0;
/// Points of the fault box that are simulated before any is fitted from, per fault.
const SAMPLED_PER_FAULT: usize = 10;
/// How many of them are fitted from.
const FITTED: usize = 2;
/// Share to which the pressures at the start are known.
const START: f64 = 0.01;
/// Cost per sample from which on the first starts are taken to have missed; noise alone costs 1/2.
const POOR: f64 = 1.0;
/// How many times more starts are then tried.
const FURTHER: usize = 3;
/// Relative decrease of the cost that ends the search for the neighbourhood.
const NEIGHBOURHOOD: f64 = 1e-3;
/// Iterations after which a start that has not found a neighbourhood is given up.
const FIRST_ITERATIONS: u64 = 25;
/// Relative decrease of the cost that ends each round of fit and renewed weights; the last one is kept for further rounds.
/// It ends far below a rise of 1 in chi-square.
const ROUNDS: [f64; 2] = [1e-4, 2e-6];
/// Most rounds. Weights hang on the fit only through when things happen, so two are enough unless the start was far.
const MOST_ROUNDS: usize = 5;
/// Standard errors by which no fault moves any more when the rounds end.
const SETTLED: f64 = 0.2;

/// Where the fit starts.
#[derive(Debug, Clone, PartialEq)]
pub enum Seed {
    /// From the healthy rig and from points of the fault box, drawn with this seed.
    Sampled(u64),
    /// From values of all estimated parameters.
    Given(Vec<f64>),
}

/// The best fit of faults and uncertain parameters to a record.
pub struct Estimate<'a> {
    /// The faults of the rig first, in their order, then uncertain parameters in theirs.
    pub problem: RecordProblem<'a>,
    pub fit: Fit,
    pub uncertainty: Uncertainty,
    /// Evaluations of the model, those with sensitivities included.
    pub solves: u64,
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

/// Fits the faults of the rig to a record.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved at any start.
pub fn estimate<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a Drive,
    seed: &Seed,
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

    let faults: Vec<Estimated> = rig
        .faults
        .iter()
        .map(|fault| Estimated {
            parameter: fault.parameter,
            bounds: fault.bounds,
            scale: (fault.bounds.1 - fault.bounds.0) / 4.0,
        })
        .collect();
    let variance = noise::variances(rig, record, &data, true);
    let phases = noise::phases(rig, drive, &record.time, &variance);
    let rough = Weights::new(rig, &phases, &variance, &[]);
    let mut solves = 0;
    let mut theta = match seed {
        Seed::Given(theta) => theta.clone(),
        Seed::Sampled(seed) => {
            let mut coarse_model = model.clone();
            coarse_model.tolerance = Tolerance::COARSE;
            let (times, weights) = (&record.time, rough.clone());
            let coarse = RecordProblem::new(
                &coarse_model,
                drive,
                times,
                data.clone(),
                weights,
                faults.clone(),
                Gaussian::none(),
            );
            let found = neighbourhood(&coarse, *seed).map_err(failed)?;
            solves += found.misfit_evaluations + found.linearisations;
            found.best.theta
        }
    };
    let mut all = faults;
    all.extend(uncertain(model));
    let known: Vec<usize> = all.iter().skip(rig.faults.len()).map(|estimated| estimated.parameter).collect();
    let prior = Gaussian::new(
        (rig.faults.len()..all.len()).collect(),
        known.iter().map(|&parameter| rig.parameters[parameter].value).collect(),
        &rig.covariance(&known),
    );
    let nominal = rig.nominal();
    theta.extend(all.iter().skip(theta.len()).map(|estimated| nominal[estimated.parameter]));
    let mut problem = RecordProblem::new(model, drive, &record.time, data, rough, all, prior);
    let options = UncertaintyOptions { series: problem.series(), ..UncertaintyOptions::default() };
    let mut round = 0;
    let (fit, uncertainty) = loop {
        let tolerances = Tolerances { function: ROUNDS[round.min(ROUNDS.len() - 1)], ..Tolerances::default() };
        problem.weights = weights(&problem, record, &theta).map_err(unsolved)?;
        let fit = fit::fit(&problem, &theta, Loss::Huber { k: ROBUST }, tolerances).map_err(failed)?;
        solves += 1 + fit.misfit_evaluations + fit.linearisations;
        round += 1;
        let before = std::mem::replace(&mut theta, fit.theta.clone());
        if round < ROUNDS.len() {
            continue;
        }
        let uncertainty = Uncertainty::at(&fit, &options);
        let settled = (0..rig.faults.len()).all(|i| {
            uncertainty.standard_error[i].as_ref().map_or(true, |sigma| (theta[i] - before[i]).abs() <= SETTLED * sigma)
        });
        if settled || round == MOST_ROUNDS {
            break (fit, uncertainty);
        }
    };
    Ok(Estimate { problem, fit, uncertainty, solves })
}

/// Finds the neighbourhood of the best fit with the faults alone; where no start fits, with more starts.
fn neighbourhood(problem: &RecordProblem<'_>, seed: u64) -> Result<MultiStart, FitError> {
    let faults = &problem.model.rig.faults;
    let tolerances = Tolerances { function: NEIGHBOURHOOD, max_iterations: FIRST_ITERATIONS, ..Tolerances::default() };
    let mut starts = Starts {
        given: vec![faults.iter().map(|fault| fault.healthy).collect()],
        sampled: SAMPLED_PER_FAULT * faults.len(),
        fitted: FITTED,
        seed,
    };
    let loss = Loss::SoftL1 { k: FAR };
    let first = fit::multi_start(problem, &starts, loss, tolerances)?;
    let samples = (problem.times.len() * problem.measured.len()) as f64;
    if first.best.cost <= POOR * samples {
        return Ok(first);
    }
    starts.given = vec![first.best.theta.clone()];
    starts.sampled *= FURTHER;
    starts.fitted *= FURTHER;
    starts.seed = seed.wrapping_add(1);
    let second = fit::multi_start(problem, &starts, loss, tolerances)?;
    let better = if second.best.cost < first.best.cost { second.best } else { first.best };
    Ok(MultiStart {
        best: better,
        misfit_evaluations: first.misfit_evaluations + second.misfit_evaluations,
        linearisations: first.linearisations + second.linearisations,
        ..second
    })
}

/// Everything that is uncertain but no fault, what sensors show at zero included.
fn uncertain(model: &Model) -> Vec<Estimated> {
    let rig = &model.rig;
    let within = |parameter: usize, sigma: f64| {
        let known = &rig.parameters[parameter];
        let (low, high) = (known.value - REACH * sigma, known.value + REACH * sigma);
        Estimated { parameter, bounds: (known.bounds.0.max(low), known.bounds.1.min(high)), scale: sigma }
    };
    // What is uncertain anew in each switching is in the weights; see `noise`.
    let stated = rig.parameters.iter().enumerate().filter(|(_, parameter)| parameter.sigma > 0.0 && !parameter.anew);
    stated.filter(|(index, _)| !rig.is_fault(*index)).map(|(index, parameter)| within(index, parameter.sigma)).collect()
}

/// Weights at `theta`: events where the model has them, time constants uncertain anew in each phase.
fn weights(problem: &RecordProblem<'_>, record: &Record, theta: &[f64]) -> Result<Weights, SimulationError> {
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
