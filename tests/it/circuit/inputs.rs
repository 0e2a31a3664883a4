//! What drives a simulated cycle, beside what its record says of it.

use borescope::internals::model::{InputSignals, Model, cycle_times, input_columns, recording};
use borescope::internals::rig::Rig;

/// A cycle may jump where an input runs straight from row to row: what acts has to be what its column will say.
#[test]
fn an_input_that_runs_straight_acts_as_its_record_says() {
    let model = Model::new(Rig::read("fixtures/servo_axis/rig.toml").unwrap());
    let (rig, cycle) = (&model.rig, model.rig.cycle.as_ref().unwrap());
    let (drive, times) = (InputSignals::from_cycle(rig, cycle), cycle_times(rig, cycle));
    let outputs = model.solve(&rig.nominal(), &drive, &times).unwrap();
    let columns = input_columns(rig, &drive, &times);
    let record = recording(rig, "cycle.csv", times, columns, &outputs, None);
    let recorded = InputSignals::from_record(rig, &record).unwrap();
    // Its corners only: straight pieces of many rows are one.
    assert!(drive.pieces.len() < 30, "{} pieces", drive.pieces.len());
    for input in 0..rig.inputs.len() {
        for step in 0..1000 {
            let time = f64::from(step) * cycle.duration() / 999.0;
            let (acted, said) = (drive.value(input, time), recorded.value(input, time));
            assert!((acted - said).abs() <= 1e-9 * acted.abs().max(1.0), "{time} s: {acted} and {said}");
        }
    }
}
