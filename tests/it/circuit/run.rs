//! A model as programs use it: parameters by text, runs along a record, readings by sensor and unit.

use borescope::internals::complaint::Kind;
use borescope::{Record, Rig};

const TANKS: &str = "fixtures/two_tanks/rig.toml";

fn still(rows: usize) -> Record {
    let time = (0..rows).map(|row| row as f64).collect();
    Record::from_columns(time, [("u", "V", vec![1.2; rows])]).unwrap()
}

#[test]
fn readings_come_in_the_unit_asked_for() {
    let model = Rig::read(TANKS).unwrap().model();
    let run = model.simulate(&still(200).inputs()).unwrap();
    let (mm, metres) = (run.sensor("level_1").unwrap().in_unit("mm").unwrap(), &run.sensors[0].values);
    assert!(mm.iter().zip(metres).all(|(mm, metre)| (mm - 1e3 * metre).abs() < 1e-9));
    assert!(mm[199] > 50.0, "{}", mm[199]);
    let half_closed = model.with("upper_outlet.diameter", "6.5 mm").unwrap();
    let higher = half_closed.simulate(&still(200).inputs()).unwrap();
    assert!(higher.sensors[0].values[199] > 1.1 * metres[199]);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let model = Rig::read(TANKS).unwrap().model();
    let run = model.simulate(&still(3).inputs()).unwrap();
    assert_eq!(run.sensor("level_3").unwrap_err().kind, Kind::UnknownName);
    assert_eq!(run.sensor("level_1").unwrap().in_unit("bar").unwrap_err().kind, Kind::Unit);
    assert_eq!(model.with("upper_outlet.diametre", "6 mm").unwrap_err().kind, Kind::UnknownName);
    assert_eq!(model.with("upper_outlet.diameter", "6").unwrap_err().kind, Kind::Unit);
    assert_eq!(model.with("upper_outlet.diameter", "-6 mm").unwrap_err().kind, Kind::Bounds);
    assert_eq!(model.with("upper.area", "0 m2").unwrap_err().kind, Kind::Bounds);
    let no_input = Record::from_columns(vec![0.0, 1.0], [("v", "V", vec![0.0; 2])]).unwrap();
    assert_eq!(model.simulate(&no_input.inputs()).unwrap_err().kind, Kind::UnknownName);
}
