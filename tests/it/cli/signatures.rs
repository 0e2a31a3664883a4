//! The signature matrix of `isolability`: at the cycle, along a record, and where there is no operating point.

use crate::support::command;

use command::borescope;
use serde_json::Value;

const RIG: &str = "fixtures/telescopic/rig.toml";

fn signatures(arguments: &[&str]) -> Value {
    let ran = borescope([&["isolability"], arguments, &["--format", "json"]].concat());
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    let page: Value = serde_json::from_str(&ran.out).unwrap();
    page["signatures"].clone()
}

/// Response of a residual in a phase to a fault, in its unit.
fn response(matrix: &Value, residual: &str, phase: &str, fault: &str) -> Option<f64> {
    let row = matrix.as_array().unwrap().iter().find(|row| row["residual"] == residual && row["phase"] == phase)?;
    let answer = row["faults"].as_array().unwrap().iter().find(|answer| answer["id"] == fault)?;
    answer["response"].as_f64()
}

#[test]
fn each_fault_has_its_residuals_and_the_sign_turns_with_the_stroke() {
    let matrix = signatures(&[RIG]);
    // All the pump gives at 0.4 mm is less than the gap would pass at the healthy pressures: 5.5 L/min of 18.
    let out = response(&matrix, "cylinder.leakage", "P-A", "cylinder.clearance").unwrap();
    let back = response(&matrix, "cylinder.leakage", "P-B", "cylinder.clearance").unwrap();
    assert!(out > 5.5 && back < 0.0, "{out} {back}");
    for (residual, fault) in [
        ("flow_control.flow", "flow_control.orifice_diameter"),
        ("directional_valve.consumer", "directional_valve.opening"),
        ("directional_valve.supply", "directional_valve.opening"),
        ("directional_valve.return", "directional_valve.opening"),
    ] {
        for phase in ["P-A", "P-B"] {
            let response = response(&matrix, residual, phase, fault).unwrap();
            assert!(response > 0.0, "{residual} {phase}: {response}");
        }
    }
    // Of 5.5 L/min through P-A an opening of 0.02 leaves a fiftieth at the same drop.
    let lost = response(&matrix, "directional_valve.supply", "P-A", "directional_valve.opening").unwrap();
    assert!((lost / (0.98 * 5.5) - 1.0).abs() < 0.01, "{lost}");
    assert_eq!(response(&matrix, "directional_valve.supply", "P-A", "cylinder.clearance"), None);
    assert_eq!(response(&matrix, "directional_valve.supply", "closed", "directional_valve.opening"), None);
    for row in matrix.as_array().unwrap() {
        for answer in row["faults"].as_array().unwrap().iter().chain(row["sensors"].as_array().unwrap()) {
            let spread = row["sigma_of_mean"].as_f64().unwrap().hypot(row["tolerance"].as_f64().unwrap());
            let deviations = answer["response"].as_f64().unwrap() / spread;
            assert!((deviations - answer["deviations"].as_f64().unwrap()).abs() <= 1e-3 * deviations.abs(), "{answer}");
        }
    }
}

#[test]
fn a_record_gives_the_operating_point() {
    let at_cycle = signatures(&[RIG]);
    let along = signatures(&[RIG, "--input", "fixtures/telescopic/healthy_1.csv"]);
    let id = "cylinder.clearance";
    let [cycle, record] = [&at_cycle, &along].map(|matrix| response(matrix, "cylinder.leakage", "P-A", id).unwrap());
    assert!(record > 0.0 && (record / cycle - 1.0).abs() > 0.05, "another load, another leakage: {cycle} {record}");
    let missing = borescope(["isolability", RIG, "--input", "nowhere.csv"]);
    assert_eq!(missing.status, Some(2));
    assert!(missing.err.contains("nowhere.csv"), "{}", missing.err);
}

#[test]
fn the_text_says_where_signatures_are_missing() {
    let text = borescope(["isolability", RIG, "--all"]).out;
    // One row has noise and unit, those below it the faults, some at a time.
    let is_row = |line: &&str| line.trim_start().starts_with("cylinder.leakage") && line.contains("P-A");
    let rows: Vec<&str> = text.lines().filter(is_row).collect();
    assert!(rows.iter().all(|row| row.contains("(4)")) && rows[0].ends_with("L/min"), "{rows:?}");
    assert!(rows[1..].iter().any(|row| row.contains('+')), "{rows:?}");
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    let fixture = std::fs::read_to_string(RIG).unwrap();
    std::fs::write(&rig, fixture.split_once("[cycle]").unwrap().0).unwrap();
    let ran = borescope(["isolability".as_ref(), rig.as_os_str()]);
    assert_eq!(ran.status, Some(0));
    assert!(ran.out.contains("No signatures: they need an operating point"), "{}", ran.out);
}
