//! How well it is known where the circuit starts.

use super::problem::RecordProblem;
use crate::model::{SimulationError, level_per_pressure};
use crate::rig::{InitialPressure, NodeKind, Quantity, Target};

/// Square of a direction over samples below which it shows nowhere: it takes half a per cent of a misfit.
const SEEN: f64 = 0.01;

/// How far the start of a node may be from where the model has it.
pub struct Unknown {
    /// One standard deviation of it, SI.
    pub sigma: f64,
    /// The part of it that the reading has by noise, where it is remembered; the rest is of the gauge, and of the moment.
    pub lasting: f64,
}

/// What each start, off by one standard deviation, changes of the readings: `[what][sensor][row]`, SI.
#[derive(Default)]
pub struct Changes {
    /// What each phase may have by itself: a pressure over the first rows alone, since what it does behind them is forgotten with most, and
    /// is not of the start; a position, a level or a state over all rows, in which stops and friction make something else of it.
    pub in_phases: Vec<Vec<Vec<f64>>>,
    /// Over all rows, in which it is one and the same: an accumulator keeps the pressure that it began with.
    pub throughout: Vec<Vec<Vec<f64>>>,
}

/// What each start changes of the readings `outputs`, over the `first` rows or throughout.
pub fn changes(
    problem: &RecordProblem<'_>,
    parameters: &[f64],
    outputs: &[Vec<f64>],
    first: usize,
) -> Result<Changes, SimulationError> {
    let (rig, mut changes) = (&problem.model.rig, Changes::default());
    let all = problem.times.len();
    for node in 0..rig.nodes.len() {
        let Some(Unknown { sigma, lasting }) = unknown(problem, parameters, node).filter(|one| one.sigma > 0.0) else {
            continue;
        };
        let mut drive = problem.drive.clone();
        drive.nudges[node] = sigma;
        let share = lasting / sigma;
        let change = problem.change(&drive, parameters, outputs, if share < 1.0 { first } else { all })?;
        if share == 1.0 || !is_remembered(problem, &change, share, first) {
            changes.in_phases.push(change);
            continue;
        }
        changes.in_phases.push(scaled(change, (1.0 - share * share).sqrt()));
        changes.throughout.push(scaled(problem.change(&drive, parameters, outputs, all)?, share));
    }
    let of_states = problem.drive.shown.iter().enumerate();
    for (place, shown) in of_states.filter(|(_, one)| matches!(rig.sensors[one.sensor].target, Target::State(..))) {
        let mut drive = problem.drive.clone();
        drive.shown[place].value += shown.sigma;
        changes.in_phases.push(problem.change(&drive, parameters, outputs, all)?);
    }
    Ok(changes)
}

/// So many times a change.
fn scaled(mut change: Vec<Vec<f64>>, share: f64) -> Vec<Vec<f64>> {
    change.iter_mut().flatten().for_each(|value| *value *= share);
    change
}

/// Whether a share of what a start changes shows behind the `first` rows, where all of them have of it what the last of the first has.
fn is_remembered(problem: &RecordProblem<'_>, change: &[Vec<f64>], share: f64, first: usize) -> bool {
    let left = (problem.times.len() - first) as f64;
    let squares = problem.model.rig.sensors.iter().zip(change).map(|(sensor, curve)| {
        let last = first.checked_sub(1).and_then(|row| curve.get(row)).copied().unwrap_or(0.0);
        (share * last).powi(2) / sensor.variance()
    });
    left * squares.sum::<f64>() > SEEN
}

/// How well the start of a node is known; `None` of what is estimated, or another node's.
pub fn unknown(problem: &RecordProblem<'_>, parameters: &[f64], node: usize) -> Option<Unknown> {
    let rig = &problem.model.rig;
    let shown = problem.drive.shown_at(rig, node);
    let NodeKind::Volume { initial } = rig.nodes[node].kind else {
        return shown.map(|shown| Unknown { sigma: shown.sigma, lasting: shown.sigma });
    };
    if let Some(level) = shown.filter(|shown| rig.sensors[shown.sensor].quantity == Quantity::Level) {
        let sigma = level.sigma / level_per_pressure(parameters[0]);
        return Some(Unknown { sigma, lasting: sigma });
    }
    let reading = &problem.drive.readings[node];
    let share = rig.settings().diagnosis.start_pressure_share;
    let (known, lasting) = match initial {
        _ if let Some(shown) = shown => (0.0, shown.sigma),
        InitialPressure::Given(pressure) => (share * pressure.abs(), 0.0),
        // What is estimated, or another node's.
        InitialPressure::Uncertain(_) | InitialPressure::Like(_) => return None,
        InitialPressure::Balance | InitialPressure::Record => {
            (share * reading.freed(rig, parameters).abs(), reading.freed_sigma(rig, parameters))
        }
    };
    // No better than a sensor shows, nor than to a hundredth.
    let sensors = rig.sensors.iter().filter(|sensor| sensor.target == Target::Node(node));
    let pressures = sensors.filter(|sensor| sensor.quantity == Quantity::Pressure);
    Some(Unknown { sigma: pressures.map(|sensor| sensor.noise).fold(known, f64::max).max(lasting), lasting })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::weighed::unweighed;
    use crate::model::{InputSignals, Model};
    use crate::rig::Rig;
    use crate::simulation::{SimulationOptions, simulate};

    #[test]
    fn an_accumulator_remembers_where_it_started_and_a_line_does_not() {
        let text = std::fs::read_to_string("fixtures/accumulator/rig.toml").unwrap();
        let given = Model::new(Rig::parse("rig.toml", text.clone()).unwrap());
        let options = SimulationOptions { seed: Some(1), ..SimulationOptions::default() };
        let record = simulate(&given, None, &options).unwrap().record;
        let by_record = text.replacen("H = { initial = \"100 bar\" }", "H = {}", 1).replacen(
            "P = { initial = \"100 bar\" }",
            "P = {}",
            1,
        );
        let model = Model::new(Rig::parse("rig.toml", by_record).unwrap());
        let drive = InputSignals::from_record(&model.rig, &record).unwrap();
        let problem = unweighed(&model, &record, &drive).unwrap().full;
        let parameters = model.rig.nominal();
        let outputs = problem.outputs(&parameters, &drive).unwrap();
        let node = |name: &str| model.rig.nodes.iter().position(|node| node.name == name).unwrap();
        let sensor = |name: &str| model.rig.sensors.iter().position(|sensor| sensor.name == name).unwrap();
        // The mean of at least three readings of 0.3 bar, by which the accumulator is off still after two seconds.
        let of_record = drive.readings[node("H")].sigma;
        assert!(of_record > 0.0 && of_record <= 0.3e5 / 3.0_f64.sqrt(), "{of_record}");
        let first = 100;
        let all = changes(&problem, &parameters, &outputs, first).unwrap();
        let behind = |change: &Vec<Vec<f64>>, name: &str| change[sensor(name)][first + 10].abs();
        let [kept] = all.throughout.as_slice() else { panic!("{} starts are remembered", all.throughout.len()) };
        assert!(!all.in_phases.is_empty() && all.in_phases.iter().all(|change| behind(change, "p_H") == 0.0));
        // Gas of 2.3 L at 100 bar that the pump has pressed to 1.93 L in 2 s is stiffer: p V^1.25 stays, so what the start was off by is there
        // 2.3/1.93 to the power 2.25 times, 1.48; a consumer has taken some of it since.
        let share = behind(kept, "p_H") / of_record;
        assert!((1.2..=1.48).contains(&share), "{share}");
    }
}
