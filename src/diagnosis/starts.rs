//! How well it is known where the circuit starts.

use super::events::change;
use super::problem::RecordProblem;
use crate::model::{SimulationError, level_per_pressure};
use crate::rig::{InitialPressure, NodeKind, Quantity, Target};

/// What each start, off by one standard deviation, changes of the readings `outputs`. Pressures are forgotten behind the `first`
/// rows; a position or a level is not.
pub(super) fn changes(
    problem: &RecordProblem<'_>,
    parameters: &[f64],
    outputs: &[Vec<f64>],
    first: usize,
) -> Result<Vec<Vec<Vec<f64>>>, SimulationError> {
    let mut changes = Vec::new();
    for node in 0..problem.model.rig.nodes.len() {
        let Some((nudge, lasting)) = unknown(problem, parameters, node).filter(|(nudge, _)| *nudge > 0.0) else {
            continue;
        };
        let mut drive = problem.drive.clone();
        drive.nudges[node] = nudge;
        let rows = if lasting { problem.times.len() } else { first };
        changes.push(change(problem, &drive, parameters, outputs, rows)?);
    }
    Ok(changes)
}

/// One standard deviation of the start of a node, SI, and whether it lasts.
fn unknown(problem: &RecordProblem<'_>, parameters: &[f64], node: usize) -> Option<(f64, bool)> {
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
            problem.model.rig.settings().diagnosis.start_pressure_share * problem.drive.readings[node].abs()
        }
    };
    // No better than a sensor shows, nor than to a hundredth.
    let sensors = rig.sensors.iter().filter(|sensor| sensor.target == Target::Node(node));
    let pressures = sensors.filter(|sensor| sensor.quantity == Quantity::Pressure);
    Some((pressures.map(|sensor| sensor.noise).fold(known, f64::max), false))
}

#[cfg(test)]
mod tests {
    use super::super::noise::Weights;
    use super::*;
    use crate::model::{InputSignals, Model, Shown, cycle_times};
    use crate::physics::GRAVITY;
    use crate::rig::Rig;

    #[test]
    fn a_level_that_a_sensor_shows_is_as_uncertain_as_its_reading_and_is_not_forgotten() {
        let model = Model::new(Rig::read("fixtures/two_tanks/rig.toml").unwrap());
        let rig = &model.rig;
        let cycle = rig.cycle.as_ref().unwrap();
        let (times, mut drive) = (cycle_times(rig, cycle), InputSignals::from_cycle(rig, cycle));
        drive.shown.push(Shown { sensor: 0, value: 0.1, sigma: 5e-4, rate: 0.0 });
        let nothing = Weights::new(rig, &[], &[], &[]);
        let problem = RecordProblem::new(&model, &drive, &times, Vec::new(), nothing, Vec::new());
        let parameters = rig.nominal();
        let Target::Node(upper) = rig.sensors[0].target else { panic!("a level is that of a node") };
        let (sigma, lasts) = unknown(&problem, &parameters, upper).unwrap();
        approx::assert_relative_eq!(sigma, 998.0 * GRAVITY * 5e-4, max_relative = 1e-12);
        assert!(lasts);
        // Half a millimetre at the start still shows behind the first rows.
        let outputs = model.solve(&parameters, &drive, &times).unwrap().values;
        let changed = changes(&problem, &parameters, &outputs, 2).unwrap();
        let shows: Vec<f64> = changed[0][0][..6].to_vec();
        assert!(shows.iter().all(|change| (4e-4..=5e-4 + 1e-9).contains(change)), "{shows:?}");
    }
}
