//! Parts that are not as the rig file has them, in a press whose file takes all data sheets as exact.

use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, Verdict, diagnose};
use borescope::{Model, Rig};

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

/// What is found in a record of the press with these values, by its file.
fn diagnosed(values: &[(&str, &str)]) -> (Rig, Diagnosis) {
    let model = Model::new(Rig::read("fixtures/press/rig.toml").unwrap());
    let mut cycle = model.rig.cycle.clone().unwrap();
    cycle.interval *= 2.0;
    let record = Run::of(&model).through(cycle).with_quantities(values).seed(3).record("press");
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
    // Values that the file has as exact, by their distance; not a word of what it states as uncertain.
    assert!(off.values.iter().all(|one| rig.parameters[rig.parameter(&one.id).unwrap()].sigma == 0.0), "{off:?}");
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
