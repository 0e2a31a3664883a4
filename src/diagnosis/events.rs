//! Where the model has its events, and what they do to the weights.

use std::ops::Range;

use super::noise::{self, Weights};
use super::prior::Gaussian;
use super::problem::RecordProblem;
use crate::model::{Drive, Model, SimulationError};
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Quantity, Target};

/// Share to which the pressures at the start are known.
const START: f64 = 0.01;

/// Weights of a record for all parameters of a rig, SI.
pub(crate) fn weights_of(
    model: &Model,
    record: &Record,
    drive: &Drive,
    parameters: &[f64],
) -> Result<Weights, SimulationError> {
    let nothing = Weights::new(&model.rig, &[], &[], &[]);
    let mut problem = RecordProblem::new(model, drive, &record.time, Vec::new(), nothing, Vec::new(), Gaussian::none());
    problem.base = parameters.to_vec();
    weights(&problem, record, &[])
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
    pub phases: Vec<Range<usize>>,
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
    let solved = model.sensitivities(&parameters, &constants, problem.drive, problem.times)?;
    let outputs = solved.outputs.values;
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
            // What is estimated, or another node's.
            InitialPressure::Uncertain(_) | InitialPressure::Like(_) => continue,
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
