//! How well it is known where the circuit starts.

use super::problem::RecordProblem;
use crate::model::{SimulationError, level_per_pressure};
use crate::rig::{InitialPressure, NodeKind, Quantity, Target};

/// What each start, off by one standard deviation, changes of the readings `outputs`. Pressures are forgotten behind the `first`
/// rows; a position or a level is not.
pub fn changes(
    problem: &RecordProblem<'_>,
    parameters: &[f64],
    outputs: &[Vec<f64>],
    first: usize,
) -> Result<Vec<Vec<Vec<f64>>>, SimulationError> {
    let (rig, mut changes) = (&problem.model.rig, Vec::new());
    for node in 0..rig.nodes.len() {
        let Some((nudge, lasting)) = unknown(problem, parameters, node).filter(|(nudge, _)| *nudge > 0.0) else {
            continue;
        };
        let mut drive = problem.drive.clone();
        drive.nudges[node] = nudge;
        let rows = if lasting { problem.times.len() } else { first };
        changes.push(problem.change(&drive, parameters, outputs, rows)?);
    }
    let of_states = problem.drive.shown.iter().enumerate();
    for (place, shown) in of_states.filter(|(_, one)| matches!(rig.sensors[one.sensor].target, Target::State(..))) {
        let mut drive = problem.drive.clone();
        drive.shown[place].value += shown.sigma;
        changes.push(problem.change(&drive, parameters, outputs, problem.times.len())?);
    }
    Ok(changes)
}

/// One standard deviation of the start of a node, SI, and whether it lasts.
pub fn unknown(problem: &RecordProblem<'_>, parameters: &[f64], node: usize) -> Option<(f64, bool)> {
    let rig = &problem.model.rig;
    let shown = problem.drive.shown_at(rig, node);
    let NodeKind::Volume { initial } = rig.nodes[node].kind else {
        return shown.map(|shown| (shown.sigma, true));
    };
    if let Some(level) = shown.filter(|shown| rig.sensors[shown.sensor].quantity == Quantity::Level) {
        return Some((level.sigma / level_per_pressure(parameters[0]), true));
    }
    let known = match initial {
        _ if shown.is_some() => 0.0,
        InitialPressure::Given(pressure) => {
            problem.model.rig.settings().diagnosis.start_pressure_share * pressure.abs()
        }
        // What is estimated, or another node's.
        InitialPressure::Uncertain(_) | InitialPressure::Like(_) => return None,
        InitialPressure::Balance | InitialPressure::Record => {
            problem.model.rig.settings().diagnosis.start_pressure_share
                * problem.drive.readings[node].freed(rig, parameters).abs()
        }
    };
    // No better than a sensor shows, nor than to a hundredth.
    let sensors = rig.sensors.iter().filter(|sensor| sensor.target == Target::Node(node));
    let pressures = sensors.filter(|sensor| sensor.quantity == Quantity::Pressure);
    Some((pressures.map(|sensor| sensor.noise).fold(known, f64::max), false))
}
