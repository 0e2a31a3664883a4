//! Times a rig on a record: simulation, and sensitivities by ever more parameters: `cargo bench --bench circuit`.

use std::time::Instant;

use borescope::model::{Drive, Model};
use borescope::rig::Rig;

const RIG: &str = "fixtures/telescopic/rig.toml";
const RECORD: &str = "fixtures/telescopic/healthy_1.csv";
const RUNS: usize = 15;

/// Median time of a run (ms).
fn time(mut f: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            f();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

fn main() {
    let model = Model::new(Rig::read(RIG).expect("the rig is right"));
    let record = model.rig.record(RECORD).expect("the record is right");
    let drive = Drive::from_record(&model.rig, &record).expect("the record drives the rig");
    let parameters = model.rig.nominal();
    let effort = model.simulate(&parameters, &drive, &record.time).expect("solved").effort;
    let plain = time(|| {
        model.simulate(&parameters, &drive, &record.time).expect("solved");
    });
    let per_step = plain * 1e3 / (effort.steps + effort.rejected) as f64;
    println!("{} + {} steps, {} rows", effort.steps, effort.rejected, record.time.len());
    println!("simulation: {plain:.1} ms, {per_step:.2} us per step");
    let free = |index: &usize| {
        let sensor = model.rig.sensors.iter().any(|sensor| (0..2).any(|own| sensor.first_parameter + own == *index));
        !sensor && (model.rig.parameters[*index].sigma > 0.0 || model.rig.is_fault(*index))
    };
    let by: Vec<usize> = (0..parameters.len()).filter(free).collect();
    for count in [1, 3, 6, 14, by.len()] {
        let taken = time(|| {
            model.sensitivities(&parameters, &by[..count], &drive, &record.time).expect("solved");
        });
        println!("{count} sensitivities: {taken:.1} ms, {:.1} simulations", taken / plain);
    }
}
