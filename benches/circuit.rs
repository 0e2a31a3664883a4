//! Times a rig on a record: simulation, sensitivities by ever more parameters, and its cycle beside the same circuit by hand:
//! `cargo bench --bench circuit`.

#[path = "by_hand/telescopic.rs"]
mod by_hand;
mod timing;

use std::hint::black_box;

use borescope::Rig;
use borescope::internals::model::{InputSignals, Model, cycle_times};
use borescope::internals::numeric::System;
use by_hand::{N, Telescopic};
use timing::{line, time};

const RIG: &str = "fixtures/telescopic/rig.toml";
const RECORD: &str = "fixtures/telescopic/healthy_1.csv";
const RUNS: usize = 15;

/// The general circuit beside the same circuit by hand, over the cycle of the rig.
fn beside_by_hand(model: &Model) {
    let cycle = model.rig.cycle.as_ref().expect("a cycle");
    let (drive, times) = (InputSignals::from_cycle(&model.rig, cycle), cycle_times(&model.rig, cycle));
    let parameters = model.rig.nominal();
    let general = model.solve(&parameters, &drive, &times).expect("solved");
    let (values, steps) = by_hand::run(&model.rig, &drive, &times);
    // Both are the same circuit: they differ by less than a thirtieth of the noise of each sensor.
    for ((sensor, ours), theirs) in model.rig.sensors.iter().zip(&general.values).zip(&values) {
        let squares: f64 = ours.iter().zip(theirs).map(|(a, b)| (a - b).powi(2)).sum();
        let rms = (squares / times.len() as f64).sqrt();
        assert!(rms < sensor.noise / 30.0, "{}: {rms} beside a noise of {}", sensor.name, sensor.noise);
    }
    let what = format!("a cycle of the rig, {} rows", times.len());
    let remark =
        |steps: usize, timed: timing::Timed| format!("{steps} steps, {:.2} us each", timed.least * 1e3 / steps as f64);
    let timed = time(RUNS * 5, || drop(black_box(model.solve(&parameters, &drive, &times))));
    line(&what, "borescope", timed, &remark(general.effort.steps + general.effort.rejected, timed));
    let timed = time(RUNS * 5, || drop(black_box(by_hand::run(&model.rig, &drive, &times))));
    line(&what, "by hand", timed, &remark(steps, timed));
    pieces(&model.rig);
}

/// Right-hand side and Jacobian by hand, in the middle of the stroke.
fn pieces(rig: &Rig) {
    let mut circuit = Telescopic::of(rig);
    (circuit.command, circuit.load) = (1.0, 5400.0);
    let y = [101e5, 98e5, 65e5, 15e5, 0.08, 0.06, 1e5, 1.4e-3, 1.0, 8e-5, 8e-5, 6e-5];
    let (mut f, mut j) = ([0.0; N], [[0.0; N]; N]);
    let rounds = 100_000;
    let derivative = time(11, || (0..rounds).for_each(|_| circuit.derivative(0.0, black_box(&y), black_box(&mut f))));
    let jacobian =
        time(11, || (0..rounds).for_each(|_| circuit.jacobian(0.0, black_box(&y), black_box(&mut j), &mut f)));
    for (what, timed) in [("telescopic right-hand side", derivative), ("telescopic Jacobian", jacobian)] {
        let each = timing::Timed { least: timed.least / rounds as f64, median: timed.median / rounds as f64 };
        line(what, "by hand", each, "");
    }
}

fn main() {
    let model = Model::new(Rig::read(RIG).expect("the rig is right"));
    let record = model.rig.record(RECORD).expect("the record is right");
    let drive = InputSignals::from_record(&model.rig, &record).expect("the record drives the rig");
    let parameters = model.rig.nominal();
    let effort = model.solve(&parameters, &drive, &record.time).expect("solved").effort;
    let plain = time(RUNS, || {
        model.solve(&parameters, &drive, &record.time).expect("solved");
    });
    let steps = effort.steps + effort.rejected;
    let remark =
        format!("{} + {} steps, {:.2} us each", effort.steps, effort.rejected, plain.least * 1e3 / steps as f64);
    line(&format!("telescopic rig, {} rows", record.time.len()), "borescope", plain, &remark);
    let free = |index: &usize| {
        let sensor = model.rig.sensors.iter().any(|sensor| (0..2).any(|own| sensor.first_parameter + own == *index));
        !sensor && (model.rig.parameters[*index].sigma > 0.0 || model.rig.is_fault(*index))
    };
    let by: Vec<usize> = (0..parameters.len()).filter(free).collect();
    for count in [1, 3, 6, 14, by.len()] {
        let taken = time(RUNS, || {
            model.sensitivities(&parameters, &by[..count], &drive, &record.time).expect("solved");
        });
        let remark = format!("{:.1} simulations", taken.least / plain.least);
        line(&format!("telescopic rig, {count} sensitivities"), "borescope", taken, &remark);
    }
    beside_by_hand(&model);
}
