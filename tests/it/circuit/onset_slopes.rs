//! Derivatives of a run in which faults begin, by what they are, and by what they were before; and of a start by the sensor that shows it.

use borescope::internals::diagnosis::noise::Weights;
use borescope::internals::diagnosis::problem::{Estimated, RecordProblem};
use borescope::internals::estimation::Problem;
use borescope::internals::model::{Before, InputSignals, Model, Onset, Tolerance, cycle_times};
use borescope::{Record, Rig};

/// Faults of the circuit, of a sensor's gain and of its offset; and how far each is moved, SI.
const ASKED: [(&str, f64, f64); 4] = [
    ("flow_control.orifice_diameter", 4.5e-3, 1e-6),
    ("directional_valve.opening", 0.9, 1e-4),
    ("sensor.p_A.gain", 1.05, 1e-4),
    ("sensor.x.offset", 1e-3, 1e-6),
];

#[test]
fn derivatives_with_a_beginning_are_those_of_differences() {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap().with_before();
    let cycle = rig.cycle.clone().unwrap();
    let times = cycle_times(&rig, &cycle);
    // Within the first stroke.
    let time = 0.3 * times[times.len() - 1];
    let before = rig.before.iter().map(|&(fault, before)| (fault, Before::Like(before))).collect();
    let drive = InputSignals::from_cycle(&rig, &cycle).with_onset(Onset { time, before });
    let mut theta = Vec::new();
    let mut steps = Vec::new();
    let mut estimated = Vec::new();
    for (id, value, step) in ASKED {
        let parameter = rig.parameter(id).unwrap();
        let was = rig.before(parameter).unwrap();
        for (parameter, value) in [(parameter, value), (was, rig.parameters[was].value)] {
            estimated.push(Estimated { parameter, bounds: (f64::NEG_INFINITY, f64::INFINITY), scale: step });
            theta.push(value);
            steps.push(step);
        }
    }
    let nothing = vec![0.0; times.len()];
    let measured = vec![&nothing[..]; rig.sensors.len()];
    let weights = Weights::new(&rig, &[], &[], &[]);
    let model = Model::new(rig).with_tolerance(Tolerance { relative: 1e-10, absolute: 1e-10 });
    let problem = RecordProblem::new(&model, &drive, &times, measured, weights, estimated);
    let jacobian = problem.linearise(&theta).unwrap().jacobian;
    for (column, step) in steps.iter().enumerate() {
        let moved = |by: f64| {
            let mut theta = theta.clone();
            theta[column] += by;
            problem.misfit(&theta).unwrap()
        };
        let (up, down) = (moved(*step), moved(-step));
        let slope = |row: usize| (up[row] - down[row]) / (2.0 * step);
        let largest = jacobian.column(column).amax();
        assert!(largest > 0.0, "{column} does nothing");
        for (row, value) in jacobian.column(column).iter().enumerate() {
            let apart = (value - slope(row)).abs();
            assert!(apart <= 2e-3 * largest, "{column} in {row}: {value} instead of {}", slope(row));
        }
    }
}

/// An accumulator behind a check valve keeps what it starts with: what its sensor shows, free of offset and gain.
#[test]
fn derivatives_of_a_start_that_a_sensor_shows_are_those_of_differences() {
    let path = "fixtures/accumulator/rig.toml";
    let text = std::fs::read_to_string(path).unwrap();
    let stated = "H = { initial = \"100 bar\" }";
    assert!(text.contains(stated));
    let rig = Rig::parse(path, text.replace(stated, "H = {}")).unwrap();
    let record = Record::read("fixtures/accumulator/healthy_1.csv").unwrap();
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let id = |what: &str| rig.parameter(&format!("sensor.p_H.{what}")).unwrap();
    let steps = [1e3, 1e-4];
    let pairs = [id("offset"), id("gain")].into_iter().zip(steps);
    let unbounded = (f64::NEG_INFINITY, f64::INFINITY);
    let estimated = pairs.map(|(parameter, scale)| Estimated { parameter, bounds: unbounded, scale }).collect();
    let nothing = vec![0.0; record.time.len()];
    let measured = vec![&nothing[..]; rig.sensors.len()];
    let sensor = rig.sensors.iter().position(|sensor| sensor.name == "p_H").unwrap();
    let weights = Weights::new(&rig, &[], &vec![vec![1.0; record.time.len()]; rig.sensors.len()], &[]);
    let model = Model::new(rig).with_tolerance(Tolerance { relative: 1e-9, absolute: 1e-9 });
    let problem = RecordProblem::new(&model, &drive, &record.time, measured, weights, estimated);
    let theta = [2e5, 1.01];
    let jacobian = problem.linearise(&theta).unwrap().jacobian;
    for (column, step) in steps.into_iter().enumerate() {
        let moved = |by: f64| {
            let mut theta = theta;
            theta[column] += by;
            problem.misfit(&theta).unwrap()
        };
        let (up, down) = (moved(step), moved(-step));
        let own = sensor * record.time.len();
        let largest = jacobian.column(column).amax();
        for (row, value) in jacobian.column(column).iter().enumerate() {
            let slope = (up[row] - down[row]) / (2.0 * step);
            assert!((value - slope).abs() <= 2e-3 * largest, "{column} in {row}: {value} instead of {slope}");
        }
        // What the sensor shows first is what it showed, whatever its offset.
        assert!(jacobian[(own, column)].abs() < 1e-3 * largest, "{column}: {}", jacobian[(own, column)]);
    }
}
