//! Parts that are not as the rig file has them, in a press whose file takes all data sheets as exact.

use borescope::internals::calibration::{CalibrationOptions, calibrate};
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, Verdict, diagnose};
use borescope::{Model, Record, Rig};

use crate::support::cycle::Run;

/// About one standard deviation of what parts deviate by, each.
const OFF: [(&str, &str); 6] = [
    ("directional_valve.opening_PA", "0.97"),
    ("directional_valve.opening_BT", "1.02"),
    ("meter_out.rated_drop", "20.8 bar"),
    ("pump.displacement", "10.12 cc/rev"),
    ("relief.rated_overpressure", "8.8 bar"),
    ("cylinder.viscous_friction", "2300 N.s/m"),
];

/// A record of the press with these values.
fn pressed(model: &Model, seed: u64, values: &[(&str, &str)]) -> Record {
    let mut cycle = model.rig.cycle.clone().unwrap();
    cycle.interval *= 2.0;
    Run::of(model).through(cycle).with_quantities(values).seed(seed).record("press")
}

/// What is found in a record of the press with these values, by its file.
fn diagnosed(values: &[(&str, &str)]) -> (Rig, Diagnosis) {
    let model = Model::new(Rig::read("fixtures/press/rig.toml").unwrap());
    let record = pressed(&model, 3, values);
    let diagnosis = diagnose(&model, &record, &DiagnosisOptions::default()).unwrap().diagnosis;
    (model.rig, diagnosis)
}

fn present(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.present().map(|fault| fault.id.as_str()).collect()
}

#[test]
fn a_healthy_machine_is_not_faulty_for_its_data_sheets() {
    let (rig, found) = diagnosed(&OFF);
    let off = found.off_data_sheet.as_ref().unwrap_or_else(|| panic!("as stated: {found:?}"));
    assert_eq!((found.verdict, present(&found)), (Verdict::Healthy, Vec::new()));
    // As stated it takes faults that are not there, or is not explained at all.
    assert!(!off.instead_of.is_empty() && off.times_noise_as_stated > found.times_noise, "{off:?}");
    // Values that the file has as exact, and offsets of which it says nothing, by their distance; not a word of what it states as uncertain.
    let is_unsaid = |id: &str| id.ends_with(".offset") || rig.parameters[rig.parameter(id).unwrap()].sigma == 0.0;
    assert!(off.values.iter().all(|one| is_unsaid(&one.id)), "{off:?}");
    let away = |one: &borescope::results::OffSheetValue| ((one.value - one.nominal) / one.sigma_before).abs();
    assert!(off.values.windows(2).all(|pair| away(&pair[0]) >= away(&pair[1])), "{off:?}");
}

#[test]
fn a_leak_in_such_a_machine_is_found_alone() {
    let leak = [&OFF[..], &[("cylinder.clearance", "0.1 mm")]].concat();
    let (_, found) = diagnosed(&leak);
    assert!(found.off_data_sheet.is_some(), "{found:?}");
    assert_eq!((found.verdict, present(&found)), (Verdict::Faulty, vec!["cylinder.clearance"]));
    let leak = found.present().next().unwrap();
    let [low, high] = leak.ci95.map(|end| end.unwrap());
    assert!(low < 0.1 && 0.1 < high, "{leak:?}");
}

#[test]
fn faults_that_the_data_sheet_cannot_be_stand() {
    let (_, found) = diagnosed(&[("cylinder.clearance", "0.1 mm"), ("meter_out.opening", "0.7")]);
    assert_eq!(found.off_data_sheet, None);
    assert_eq!(present(&found), ["meter_out.opening", "cylinder.clearance"]);
}

/// The press as its file has it, and calibrated on two records of one whose parts deviate.
fn calibrated() -> (Model, Model) {
    let text = std::fs::read_to_string("fixtures/press/rig.toml").unwrap();
    let model = Model::new(Rig::parse(std::path::Path::new("press.toml"), text.clone()).unwrap());
    let healthy = [1, 2].map(|seed| pressed(&model, seed, &OFF));
    let calibrated = calibrate(&text, &model.rig, &healthy, &CalibrationOptions::default()).unwrap();
    (model, Model::new(calibrated.rig))
}

/// Off by less than half of the step with which a search for lags begins, and by more than position sensors forgive.
#[test]
fn a_valve_that_is_a_seventh_slower_than_its_data_sheet_is_found_by_calibration() {
    let text = std::fs::read_to_string("fixtures/press/rig.toml").unwrap();
    let model = Model::new(Rig::parse(std::path::Path::new("press.toml"), text.clone()).unwrap());
    let slower = [&OFF[..], &[("directional_valve.lag", "23 ms")]].concat();
    let healthy = [1, 2].map(|seed| pressed(&model, seed, &slower));
    let found = calibrate(&text, &model.rig, &healthy, &CalibrationOptions::default()).unwrap();
    let valve = found.report.dynamics.iter().find(|one| one.id == "directional_valve.lag").unwrap();
    assert!((valve.after - 23.0).abs() < 0.5, "{valve:?}");
    for x in found.report.records.iter().map(|record| &record.channels[4]) {
        assert!(x.rmse_before > 0.3 && x.rmse < 0.075, "{x:?}");
    }
}

/// A clearance leaks with its cube, so the form at none sees nothing of it, and a leak that the calibration leaves open can stand in.
#[test]
fn a_small_clearance_behind_a_throttle_is_found_in_a_calibrated_machine() {
    let (model, calibrated) = calibrated();
    let faults = [("meter_out.opening", "0.81"), ("cylinder.clearance", "0.017 mm")];
    let record = pressed(&model, 4, &[&OFF[..], &faults].concat());
    let found = diagnose(&calibrated, &record, &DiagnosisOptions::default()).unwrap().diagnosis;
    assert_eq!(present(&found), ["meter_out.opening", "cylinder.clearance"]);
    for (fault, truth) in found.present().zip([0.81, 0.017]) {
        let [low, high] = fault.ci95.map(|end| end.unwrap());
        assert!(low < truth && truth < high, "{fault:?}");
    }
}

#[test]
fn a_calibrated_value_that_has_changed_is_a_fault_although_none_is_declared() {
    let (model, calibrated) = calibrated();
    let found = |seed, values: &[(&str, &str)]| {
        let record = pressed(&model, seed, values);
        diagnose(&calibrated, &record, &DiagnosisOptions::default()).unwrap().diagnosis
    };
    let as_before = found(3, &OFF);
    assert_eq!((as_before.verdict, present(&as_before)), (Verdict::Healthy, Vec::new()));
    assert_eq!(as_before.faults.len(), calibrated.rig.faults.len());
    let leaks = found(4, &[&OFF[..], &[("cylinder.clearance", "0.1 mm")]].concat());
    assert_eq!((present(&leaks), &leaks.undeclared), (vec!["cylinder.clearance"], &Vec::new()));
    // An eighth less than new; nothing declared takes its place.
    let mut worn = OFF;
    worn[3].1 = "8.9 cc/rev";
    let worn = found(5, &worn);
    assert_eq!((worn.verdict, present(&worn)), (Verdict::Faulty, vec!["pump.displacement"]));
    assert_eq!(worn.undeclared, ["pump.displacement"]);
    let pump = worn.present().next().unwrap();
    let [low, high] = pump.ci95.map(|end| end.unwrap());
    assert!(low < 8.9 && 8.9 < high && high - low < 0.5, "{pump:?}");
    // An edge that lets through a quarter: a calibration knows it so badly that it hardly moves, and the throttle takes its place.
    let mut clogged = OFF;
    clogged[1].1 = "0.25";
    let clogged = found(5, &[&clogged[..], &[("meter_out.opening", "0.6")]].concat());
    assert_eq!(present(&clogged), ["meter_out.opening", "directional_valve.opening_BT"]);
    assert_eq!(clogged.undeclared, ["directional_valve.opening_BT"]);
    for (fault, truth) in clogged.present().zip([0.6, 0.25]) {
        let [low, high] = fault.ci95.map(|end| end.unwrap());
        assert!(low < truth && truth < high, "{fault:?}");
    }
}

#[test]
fn offsets_below_the_noise_are_no_missing_physics() {
    let offsets =
        [("sensor.p_pump.offset", "-0.4 bar"), ("sensor.p_B.offset", "0.3 bar"), ("sensor.q_B.offset", "0.03 L/min")];
    let all: Vec<(&str, &str)> = OFF.into_iter().chain(offsets).collect();
    let (_, found) = diagnosed(&all);
    assert_eq!((found.verdict, present(&found)), (Verdict::Healthy, Vec::new()), "{found:?}");
}

#[test]
fn a_declared_fault_is_no_deviation_of_a_part() {
    let all: Vec<(&str, &str)> = OFF.into_iter().chain([("relief.set_pressure", "149 bar")]).collect();
    let (_, found) = diagnosed(&all);
    assert_eq!((found.verdict, present(&found)), (Verdict::Faulty, vec!["relief.set_pressure"]), "{found:?}");
}

/// A flywheel of three quarters of the stated inertia: no declared fault is like it, and what is exact cannot follow.
#[test]
fn a_value_that_the_file_has_wrong_is_found_although_it_is_exact_and_no_fault() {
    let model = Model::new(Rig::read("fixtures/hydrostatic_drive/rig.toml").unwrap());
    let found = |seed, values: &[(&str, &str)]| {
        let record = Run::of(&model).with_quantities(values).seed(seed).record("drive");
        diagnose(&model, &record, &DiagnosisOptions::default()).unwrap().diagnosis
    };
    let light = [("motor.inertia", "2.4 kg.m2")];
    let alone = found(1, &light);
    assert_eq!((alone.verdict, &alone.undeclared), (Verdict::Faulty, &vec!["motor.inertia".to_owned()]));
    assert_eq!(present(&alone), ["motor.inertia"]);
    let inertia = alone.present().next().unwrap();
    let [low, high] = inertia.ci95.map(|end| end.unwrap());
    assert!(low < 2.4 && 2.4 < high && high - low < 0.05, "{inertia:?}");
    // Beside a fault that the file declares.
    let beside = found(2, &[light[0], ("motor.internal_leakage", "0.04 L/min/bar")]);
    assert_eq!(present(&beside), ["motor.internal_leakage", "motor.inertia"]);
    assert_eq!(beside.undeclared, ["motor.inertia"]);
}
