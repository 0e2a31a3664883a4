//! Where the model has its events, and what they do to the weights.

use std::ops::Range;

use rayon::prelude::*;

use super::noise::{self, Weights};
use super::problem::RecordProblem;
use super::starts;
use crate::model::{Following, InputSignals, Late, Model, Sensitivities, SimulationError};
use crate::record::Record;
use crate::rig::Rig;

/// Weights of a record for all parameters of a rig, SI, and what the sensors read with them, `[sensor][row]`, SI.
pub(crate) fn weights_of(
    model: &Model,
    record: &Record,
    drive: &InputSignals,
    parameters: &[f64],
) -> Result<(Weights, Vec<Vec<f64>>), SimulationError> {
    let LeftOpen { weights, outputs, .. } = weights_leaving_open(model, record, (drive, parameters), &[])?;
    Ok((weights, outputs))
}

/// Weights of a record that is not asked for some parameters.
pub(crate) struct LeftOpen {
    pub weights: Weights,
    /// What the sensors read, `[sensor][row]`, SI.
    pub outputs: Vec<Vec<f64>>,
    /// The most that one standard deviation of each of them changes any sample, times its noise.
    pub most: Vec<f64>,
}

/// The same where some parameters of the rig are known to one standard deviation each, SI, and the record is not asked for them.
pub(crate) fn weights_leaving_open(
    model: &Model,
    record: &Record,
    (drive, parameters): (&InputSignals, &[f64]),
    open: &[(usize, f64)],
) -> Result<LeftOpen, SimulationError> {
    let nothing = Weights::new(&model.rig, &[], &[], &[]);
    let mut problem = RecordProblem::new(model, drive, &record.time, Vec::new(), nothing, Vec::new());
    problem.base = parameters.to_vec();
    let by: Vec<usize> = open.iter().map(|(parameter, _)| *parameter).collect();
    let (mut events, Sensitivities { outputs, mut derivatives }) = events_along(&problem, record, &[], &by)?;
    for (change, (_, sigma)) in derivatives.iter_mut().zip(open) {
        change.iter_mut().flatten().for_each(|value| *value *= sigma);
    }
    let times_noise = |change: &Vec<Vec<f64>>| {
        let of = |(change, variance): (&Vec<f64>, &Vec<f64>)| {
            change.iter().zip(variance).map(|(change, variance)| change.abs() / variance.sqrt()).fold(0.0, f64::max)
        };
        change.iter().zip(&events.variance).map(of).fold(0.0, f64::max)
    };
    let most = derivatives.iter().map(times_noise).collect();
    events.changes.extend(derivatives);
    Ok(LeftOpen { weights: judged(&problem, record, &events), outputs: outputs.values, most })
}

/// Weights at `theta`: events where the model has them, time constants uncertain anew in each phase.
pub(crate) fn weights(problem: &RecordProblem<'_>, record: &Record, theta: &[f64]) -> Result<Weights, SimulationError> {
    Ok(judged(problem, record, &events(problem, record, theta)?))
}

/// The same with what a linearisation there is made of: one run gives both.
pub(super) fn weights_along(
    problem: &RecordProblem<'_>,
    record: &Record,
    theta: &[f64],
) -> Result<(Weights, Sensitivities), SimulationError> {
    let (events, solved) = events_along(problem, record, theta, &problem.inside())?;
    Ok((judged(problem, record, &events), solved))
}

/// Weights of events, which are judged where they are straight.
fn judged(problem: &RecordProblem<'_>, record: &Record, events: &Events) -> Weights {
    let rig = &problem.model.rig;
    events.weights(rig).judging_events(noise::are_events_straight(rig, record))
}

/// What weights are made of, but for the tolerances.
pub(crate) struct Events {
    /// Of each sample, `[sensor][row]`, SI squared.
    pub variance: Vec<Vec<f64>>,
    /// Rows between events.
    pub phases: Vec<Range<usize>>,
    /// Of all readings, by one standard deviation of what may be another in each phase: `[what][sensor][row]`, SI.
    pub changes: Vec<Vec<Vec<f64>>>,
    /// The same by what may be another, and is one and the same in all phases.
    pub throughout: Vec<Vec<Vec<f64>>>,
}

impl Events {
    /// Weights with the tolerances of a rig.
    pub fn weights(&self, rig: &Rig) -> Weights {
        Weights::new(rig, &self.phases, &self.variance, &self.changes).with_throughout(&self.throughout)
    }
}

/// Events at `theta`, where the model has them.
pub(crate) fn events(problem: &RecordProblem<'_>, record: &Record, theta: &[f64]) -> Result<Events, SimulationError> {
    Ok(events_along(problem, record, theta, &[])?.0)
}

/// The same with the derivatives by further parameters.
fn events_along(
    problem: &RecordProblem<'_>,
    record: &Record,
    theta: &[f64],
    further: &[usize],
) -> Result<(Events, Sensitivities), SimulationError> {
    let model = problem.model;
    let rig = &model.rig;
    let constants: Vec<usize> = rig
        .parameters
        .iter()
        .enumerate()
        .filter(|(index, parameter)| parameter.varies() && !parameter.role.is_of_the_drive() && !rig.is_fault(*index))
        .map(|(index, _)| index)
        .collect();
    let parameters = problem.parameters(theta);
    let by = [&constants[..], further].concat();
    let Sensitivities { outputs: run, derivatives: mut constant } =
        model.sensitivities(&parameters, &by, problem.drive, problem.times)?;
    let derivatives = constant.split_off(constants.len());
    let outputs = &run.values;
    let curves: Vec<&[f64]> = outputs.iter().map(Vec::as_slice).collect();
    let variance = noise::variances(rig, record, &curves, false);
    let phases = noise::phases(rig, problem.drive, problem.times, &variance);
    if let Some(unstable) = unstable(rig, problem.times, (&constants, &constant), &variance) {
        return Err(unstable);
    }
    let mut changes: Vec<Vec<Vec<f64>>> = constant
        .into_iter()
        .zip(&constants)
        .map(|(mut derivative, &constant)| {
            derivative.iter_mut().flatten().for_each(|value| *value *= rig.parameters[constant].sigma);
            derivative
        })
        .collect();
    let otherwise = driven_otherwise(problem, record, &parameters).into_par_iter();
    let otherwise = otherwise.map(|drive| problem.change(&drive, &parameters, outputs, problem.times.len()));
    changes.extend(otherwise.collect::<Result<Vec<_>, _>>()?);
    let starts = starts::changes(problem, &parameters, outputs, phases.first().map_or(0, |phase| phase.end))?;
    changes.extend(starts.in_phases);
    Ok((
        Events { variance, phases, changes, throughout: starts.throughout },
        Sensitivities { outputs: run, derivatives },
    ))
}

/// The first sample in which the derivatives `[parameter][sensor][row]` make a rounding error of a parameter's uncertainty as large as
/// noise. Linear theory ends long before, and with it everything that a fit goes by.
fn unstable(
    rig: &Rig,
    times: &[f64],
    (by, derivatives): (&[usize], &[Vec<Vec<f64>>]),
    variance: &[Vec<f64>],
) -> Option<SimulationError> {
    let is_noise = |row: usize, parameter: usize, sensor: usize| {
        let rounding = f64::EPSILON * rig.parameters[by[parameter]].sigma;
        (derivatives[parameter][sensor][row] * rounding).powi(2) > variance[sensor][row]
    };
    let pairs = (0..by.len()).flat_map(|parameter| (0..variance.len()).map(move |sensor| (parameter, sensor)));
    let grown = pairs.filter_map(|(parameter, sensor)| {
        let row = (0..times.len()).find(|&row| is_noise(row, parameter, sensor))?;
        Some((row, parameter, sensor))
    });
    let (row, parameter, sensor) = grown.min()?;
    Some(SimulationError::Unstable {
        parameter: rig.parameters[by[parameter]].id.clone(),
        sensor: rig.sensors[sensor].name.clone(),
        t: times[row],
    })
}

/// What else the mass of a spool may be, as `T/tau`: none, and dampings of 0.8 and 0.6, whose step response overshoots by 9.5 %. How far
/// a spool passes the centre decides which edges open, so the readings do not grow straight with its mass: three points span a parabola.
const INERTIA_TIMES: [f64; 3] = [0.0, 0.5 / 0.8, 0.5 / 0.6];

/// What may have driven the rig instead of what the record says, by one standard deviation each: measured inputs that acted
/// later, commands that acted later, spools that follow their command with mass, not with a lag alone, and mass and dead time of spools, and
/// dead time of inputs, that the rig file states as uncertain.
fn driven_otherwise(problem: &RecordProblem<'_>, record: &Record, parameters: &[f64]) -> Vec<InputSignals> {
    let rig = &problem.model.rig;
    let Late { measured, commanded } = noise::input_timing(rig, record);
    let lates = [Late { measured, commanded: 0.0 }, Late { measured: 0.0, commanded }];
    let late = lates.into_iter().filter(|late| *late != Late::default());
    let late =
        late.filter_map(|late| Some(InputSignals::from_late_record(rig, record, late).ok()?.in_run_of(problem.drive)));
    let followings = Following::of(rig, parameters);
    let others = (0..followings.len()).flat_map(|one| INERTIA_TIMES.map(|share| (one, share * followings[one].lag)));
    let others = others.filter(|&(one, inertia_time)| inertia_time != followings[one].inertia_time);
    let others = others.map(|(one, inertia_time)| (one, Following { inertia_time, ..followings[one] }));
    let sigma = |own: Option<usize>| own.map_or(0.0, |own| rig.parameters[own].sigma);
    let stated = rig.followers().zip(&followings).enumerate().flat_map(|(one, (follower, &following))| {
        let inertia_time = following.inertia_time + sigma(follower.inertia_time);
        let dead_time = following.dead_time + sigma(follower.dead_time);
        [Following { inertia_time, ..following }, Following { dead_time, ..following }].map(|other| (one, other))
    });
    let stated = stated.filter(|&(one, other)| other != followings[one]);
    let reshaped = others.chain(stated).map(|(one, other)| {
        let mut followings = followings.clone();
        followings[one] = other;
        problem.drive.clone().followed(rig, &followings)
    });
    let dead_times = rig.inputs.iter().filter_map(|input| input.dead_time).filter(|&own| rig.parameters[own].varies());
    let later = dead_times.map(|own| {
        let mut other = rig.clone();
        other.parameters[own].value += other.parameters[own].sigma;
        problem.drive.clone().followed(&other, &followings)
    });
    late.chain(reshaped).chain(later).chain(begun_at_rest(problem, &followings)).collect()
}

/// A moment in which nothing moves that a row could show, as a share of the time between two rows.
const MOMENT: f64 = 1e-3;

/// Spools that a record commands from its first row on, had they been at rest until then: what came before it no record says.
fn begun_at_rest(problem: &RecordProblem<'_>, followings: &[Following]) -> Vec<InputSignals> {
    let (rig, drive) = (&problem.model.rig, problem.drive);
    let [first, second, ..] = *problem.times else { return Vec::new() };
    let mut inputs: Vec<usize> = followings.iter().map(|one| one.input).collect();
    inputs.sort_unstable();
    inputs.dedup();
    let commanded = inputs.into_iter().filter(|&input| drive.value(input, first) != 0.0);
    let at_rest = |input: usize| drive.clone().without_at_first(input, MOMENT * (second - first));
    commanded.map(|input| at_rest(input).followed(rig, followings)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_may_act_as_much_later_as_its_dead_time_is_uncertain() {
        let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
        let after = "[inputs.valve_command]";
        let jumps_and_others = |dead_time: &str| {
            let text = text.replacen(after, &format!("{after}\ndead_time = \"{dead_time}\""), 1);
            let model = Model::new(Rig::parse("fixtures/telescopic/rig.toml", text).unwrap());
            let record = model.rig.record("fixtures/telescopic/healthy_1.csv").unwrap();
            let drive = InputSignals::from_record(&model.rig, &record).unwrap();
            let nothing = Weights::new(&model.rig, &[], &[], &[]);
            let problem = RecordProblem::new(&model, &drive, &record.time, Vec::new(), nothing, Vec::new());
            let first = |drive: &InputSignals| {
                drive.pieces.iter().find(|piece| piece.jump && piece.start > 0.1).map(|piece| piece.start).unwrap()
            };
            let others = driven_otherwise(&problem, &record, &model.rig.nominal());
            (first(&drive), others.iter().map(first).collect::<Vec<f64>>())
        };
        let (at, exact) = jumps_and_others("4 ms");
        let (same, open) = jumps_and_others("4 ms +- 3 ms");
        assert_eq!((at, exact.len() + 1), (same, open.len()));
        assert!(open.iter().any(|start| (start - at - 3e-3).abs() < 1e-9), "{at}: {open:?}");
        assert!(!exact.iter().any(|start| (start - at - 3e-3).abs() < 1e-9), "{at}: {exact:?}");
    }

    #[test]
    fn a_rounding_error_that_grows_to_noise_is_unstable() {
        let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let lag = rig.parameter("directional_valve.lag").unwrap();
        let variance = vec![vec![1e8; 3]; 2];
        // The second sensor shows the lag's rounding error at half and at twice its noise of 1e4.
        let at = |times_noise: f64| times_noise * 1e4 / (f64::EPSILON * rig.parameters[lag].sigma);
        let found = |last: f64| {
            let derivatives = [vec![vec![0.0; 3], vec![0.0, -1.0, last]]];
            unstable(&rig, &[0.0, 0.1, 0.2], (&[lag], &derivatives), &variance)
        };
        assert!(found(at(0.5)).is_none());
        let Some(SimulationError::Unstable { parameter, sensor, t }) = found(at(2.0)) else { panic!("stable") };
        assert_eq!((parameter.as_str(), sensor.as_str(), t), ("directional_valve.lag", "p_P", 0.2));
    }
}
