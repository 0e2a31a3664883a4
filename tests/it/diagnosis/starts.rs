//! How well it is known where the circuit starts.

use borescope::Record;
use borescope::internals::diagnosis::noise::{Weights, phases, variances};
use borescope::internals::diagnosis::problem::RecordProblem;
use borescope::internals::diagnosis::starts::{changes, unknown};
use borescope::internals::model::{InputSignals, Model, Shown, cycle_times};
use borescope::internals::physics::GRAVITY;
use borescope::internals::rig::{Rig, Target};

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
    let start = unknown(&problem, &parameters, upper).unwrap();
    approx::assert_relative_eq!(start.sigma, 998.0 * GRAVITY * 5e-4, max_relative = 1e-12);
    assert_eq!(start.lasting, start.sigma);
    // Half a millimetre at the start still shows behind the first rows.
    let outputs = model.solve(&parameters, &drive, &times).unwrap().values;
    let changed = changes(&problem, &parameters, &outputs, 2).unwrap();
    let shows: Vec<f64> = changed.in_phases[0][0][..6].to_vec();
    assert!(changed.throughout.is_empty());
    assert!(shows.iter().all(|change| (4e-4..=5e-4 + 1e-9).contains(change)), "{shows:?}");
}

/// Where the record begins is no event: a start that is off by a little is so until a valve opens, not in the first row alone. Oil that a
/// closed valve traps remembers it.
#[test]
fn the_first_phase_lasts_until_something_happens() {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
    let record = Record::read("fixtures/telescopic/healthy_1.csv").unwrap();
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let measured: Vec<&[f64]> =
        rig.sensors.iter().map(|sensor| record.channel(&sensor.column).unwrap().values.as_slice()).collect();
    let variance = variances(&rig, &record, &measured, true);
    let command = &record.channel("valve_command").unwrap().values;
    let switches = command.iter().position(|value| *value != command[0]).unwrap();
    assert!(switches > 10, "{switches}");
    let first = phases(&rig, &drive, &record.time, &variance).swap_remove(0);
    assert_eq!(first.start, 0);
    assert!(first.end.abs_diff(switches) <= 1, "{first:?}, the valve switches in row {switches}");
}
