//! Effects that explain a record as well as a fault does: named where they do, and only there.

use std::fs;

use borescope::internals::model::Model;
use borescope::{Diagnosis, Rig, Verdict};

use crate::support::cycle::Run;

/// Diagnoses one cycle of a rig with a fault.
fn diagnosed(rig: Rig, fault: (&str, &str)) -> Diagnosis {
    let model = Model::new(rig);
    let record = Run::of(&model).with_quantities(&[fault]).record("cycle");
    let diagnosis = model.diagnose(&record).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::Faulty, "{fault:?}");
    assert_eq!(diagnosis.present().map(|fault| fault.id.as_str()).collect::<Vec<_>>(), [fault.0]);
    println!("{fault:?}: {:?}", diagnosis.rival_effects);
    diagnosis
}

#[test]
fn a_leak_of_the_valve_may_as_well_be_one_of_the_line() {
    // Both are laminar flows from A to a tank at no pressure, and no sensor sits between the valve and the line.
    let leak = "\"directional_valve.leak_AT\" = { bounds = [\"0 L/min/bar\", \"0.1 L/min/bar\"] }";
    let text =
        fs::read_to_string("fixtures/press/rig.toml").unwrap().replacen("[faults]", &format!("[faults]\n{leak}"), 1);
    let rig = Rig::parse("fixtures/press/rig.toml", text).unwrap();
    let diagnosis = diagnosed(rig, ("directional_valve.leak_AT", "0.01 L/min/bar"));
    let rival = diagnosis.rival_effects.first().unwrap();
    assert_eq!((rival.fault.as_str(), rival.effect.as_str()), ("directional_valve.leak_AT", "external-leakage@A"));
    assert_eq!(rival.unit, "L/min/bar");
    assert!((rival.value - 0.01).abs() < 0.0005 && rival.delta_bic.abs() < 10.0, "{rival:?}");
}

#[test]
fn a_fault_that_the_sensors_isolate_has_no_rival() {
    // The flow meter at A sees a leak of the valve, and not one of the line.
    let faults = [
        ("directional_valve.leak_AT", "0.01 L/min/bar"),
        ("directional_valve.opening", "0.5"),
        ("flow_control.orifice_diameter", "4 mm"),
    ];
    for fault in faults {
        let diagnosis = diagnosed(Rig::read("fixtures/telescopic/rig.toml").unwrap(), fault);
        assert!(diagnosis.rival_effects.is_empty(), "{fault:?}");
    }
}
