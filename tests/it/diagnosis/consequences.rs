//! What a fault changes at the sensors, against closed forms and the signs of the machine.

use std::f64::consts::PI;

use borescope::internals::finding::measured::events;
use borescope::internals::finding::{Consequence, Measure, Runs};
use borescope::internals::model::{InputSignals, Model};
use borescope::{Record, Rig};

const RECORD: &str = "fixtures/telescopic/healthy_1.csv";

/// What a fault at a size changes under the inputs of a record of the telescopic rig, and the readings with it.
fn caused_by(id: &str, size: &str) -> (Vec<Consequence>, Record, Vec<Vec<f64>>) {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
    let record = rig.record(RECORD).unwrap();
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let run = |model: &Model| model.solve(&model.rig.nominal(), &drive, &record.time).unwrap().values;
    let (with_fault, without_fault) = (&run(&rig.model().with(id, size).unwrap()), &run(&rig.model()));
    let runs = Runs::simulated((&rig, &record, &drive), 0, [with_fault, without_fault]);
    (runs.consequences(id.starts_with("sensor.")), record, with_fault.clone())
}

#[test]
fn a_clearance_causes_the_leak_of_its_gap() {
    let (found, record, with_fault) = caused_by("cylinder.clearance", "0.2 mm");
    let flow = found.iter().find(|one| one.sensor == "q_P" && one.measure == Measure::Mean).unwrap();
    let rows: Vec<usize> =
        (0..record.time.len()).filter(|&row| (flow.from_s..=flow.to_s).contains(&record.time[row])).collect();
    let drop = rows.iter().map(|&row| with_fault[2][row] - with_fault[3][row]).sum::<f64>() / rows.len() as f64;
    // Laminar flow through the annular gap at rest: pi D h^3 dp / (12 mu L), m3/s to L/min.
    let leak = PI * 0.04 * 1e-4_f64.powi(3) * drop / (12.0 * 0.0455 * 0.0374) * 6e4;
    assert!((flow.change - leak).abs() < 0.03 * leak, "{} L/min, closed form {leak} L/min", flow.change);
}

#[test]
fn a_stroke_that_only_one_of_both_ends_is_the_change_that_is_named() {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
    let record = rig.record(RECORD).unwrap();
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let run = |model: &Model| model.solve(&model.rig.nominal(), &drive, &record.time).unwrap().values;
    let healthy = run(&rig.model());
    let slow = run(&rig.model().with("flow_control.orifice_diameter", "1 mm").unwrap());
    let told = |with_fault: &Vec<Vec<f64>>, without_fault: &Vec<Vec<f64>>| {
        let runs = Runs::simulated((&rig, &record, &drive), 0, [with_fault, without_fault]);
        runs.consequences(false).into_iter().find(|one| one.measure == Measure::TravelTime).unwrap()
    };
    let never = told(&slow, &healthy);
    assert!(never.text.starts_with("x no longer reaches ") && never.with_fault.is_none(), "{never:?}");
    assert!(never.change > 0.0 && never.without_fault.is_some(), "{never:?}");
    // The other way round it arrives only with the fault, as a piston does that leaks from its high side to the other.
    let only = told(&healthy, &slow);
    assert!(only.text.ends_with(" s (new: not at all)") && only.change == -never.change, "{only:?}");
}

#[test]
fn signs_are_those_of_the_machine() {
    let (lower, ..) = caused_by("relief.set_pressure", "80 bar");
    let pump = lower.iter().find(|one| one.sensor == "p_pump").unwrap();
    assert!((pump.change + 20.0).abs() < 1.0 && pump.text.ends_with(" bar lower"), "{pump:?}");
    let (slower, ..) = caused_by("flow_control.orifice_diameter", "1.9 mm");
    let late = slower.iter().find(|one| one.measure == Measure::TravelTime).unwrap();
    assert!(late.change > 0.0 && late.text.ends_with(" s later"), "{late:?}");
    let (read, ..) = caused_by("sensor.q_A.offset", "0.5 L/min");
    assert_eq!((read.len(), read[0].text.as_str()), (1, "q_A 0.5 L/min higher"));
}

#[test]
fn what_never_stands_is_compared_where_its_change_is_sustained() {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
    let record = rig.record(RECORD).unwrap();
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let p_a = rig.sensors.iter().position(|sensor| sensor.name == "p_A").unwrap();
    let mut without_fault = rig.model().solve(&rig.model().rig.nominal(), &drive, &record.time).unwrap().values;
    // A pump ripple of 5 bar: no phase is steady any more.
    for (value, time) in without_fault[p_a].iter_mut().zip(&record.time) {
        *value += 5e5 * (60.0 * time).sin();
    }
    // 4 bar lower for most of a second at rest, and 40 bar for a moment, as a switching that comes late has it.
    let mut with_fault = without_fault.clone();
    let last = record.time[record.time.len() - 1];
    for (value, time) in with_fault[p_a].iter_mut().zip(&record.time) {
        *value -= match last - time {
            left if (0.1..0.9).contains(&left) => 4e5,
            left if (1.2..1.25).contains(&left) => 40e5,
            _ => 0.0,
        };
    }
    let (with_fault, without_fault) = (&with_fault, &without_fault);
    let runs = Runs::simulated((&rig, &record, &drive), 0, [with_fault, without_fault]);
    let found = runs.consequences(false);
    let one = &found[0];
    assert_eq!((one.sensor.as_str(), one.measure), ("p_A", Measure::Sustained), "{found:?}");
    assert!((one.change + 4.0).abs() < 1e-6, "{one:?}");
    assert!(one.from_s > last - 0.9 && one.to_s < last - 0.1 + 1e-9, "{one:?}");
    assert!(one.text.contains(" instead of ") && one.text.contains(" bar at "), "{one:?}");
}

/// What of a record is read beside the model without faults.
fn read(record: &str) -> Vec<Consequence> {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
    let record = rig.record(format!("fixtures/telescopic/{record}.csv")).unwrap();
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let model = Model::new(rig.clone()).solve(&rig.nominal(), &drive, &record.time).unwrap().values;
    events(&rig, &record, &model).unwrap()
}

#[test]
fn a_record_is_read_beside_its_model_as_on_a_chart() {
    let leaks = read("leak_020");
    let late = leaks.iter().find(|one| one.measure == Measure::TravelTime).unwrap();
    assert!(late.sensor == "x" && (0.3..0.6).contains(&late.change), "{leaks:?}");
    let slow = leaks.iter().find(|one| one.sensor.starts_with('q')).unwrap();
    assert!((slow.change + 3.5).abs() < 0.3 || (slow.change - 3.5).abs() < 0.3, "{leaks:?}");
    // Noise makes no event, and what a healthy machine differs by is within its tolerance.
    let healthy = read("healthy_1");
    assert!(healthy.iter().all(|one| one.measure != Measure::TravelTime || one.change.abs() < 0.05), "{healthy:?}");
}
