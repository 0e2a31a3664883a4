//! Times a rig on a record: simulation, and sensitivities by ever more parameters: `cargo bench --bench circuit`.

mod timing;

use borescope::model::{Drive, Model};
use borescope::rig::Rig;
use timing::{line, time};

const RIG: &str = "fixtures/telescopic/rig.toml";
const RECORD: &str = "fixtures/telescopic/healthy_1.csv";
const RUNS: usize = 15;

fn main() {
    let model = Model::new(Rig::read(RIG).expect("the rig is right"));
    let record = model.rig.record(RECORD).expect("the record is right");
    let drive = Drive::from_record(&model.rig, &record).expect("the record drives the rig");
    let parameters = model.rig.nominal();
    let effort = model.simulate(&parameters, &drive, &record.time).expect("solved").effort;
    let plain = time(RUNS, || {
        model.simulate(&parameters, &drive, &record.time).expect("solved");
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
}
