//! One mistake in taking a record instead of several faults; several faults that are there stay faults.

use borescope::Model;
use borescope::Record;
use borescope::Rig;
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, Verdict, diagnose};

use crate::support::cycle::Run;

const CYLINDER: &str = "fixtures/telescopic/rig.toml";
const TANKS: &str = "fixtures/two_tanks/rig.toml";

/// Diagnoses a cycle as a logger of half the rate would have spoilt it.
fn diagnosed(rig: &str, faults: &[(&str, &str)], spoil: impl Fn(&mut Record)) -> Diagnosis {
    diagnosed_by(Rig::read(rig).unwrap(), faults, spoil)
}

fn diagnosed_by(rig: Rig, faults: &[(&str, &str)], spoil: impl Fn(&mut Record)) -> Diagnosis {
    let model = Model::new(rig);
    let mut cycle = model.rig.cycle.clone().unwrap();
    cycle.interval *= 2.0;
    let mut record = Run::of(&model).through(cycle).with_quantities(faults).seed(7).record("cycle");
    spoil(&mut record);
    diagnose(&model, &record, &DiagnosisOptions::default()).unwrap().diagnosis
}

fn values<'a>(record: &'a mut Record, column: &str) -> &'a mut Vec<f64> {
    let channel = record.channels.iter_mut().find(|channel| channel.name == column);
    &mut channel.unwrap_or_else(|| panic!("no column `{column}`")).values
}

/// The healthy verdict under a common cause, which is handed on.
fn healthy_if(diagnosis: &Diagnosis) -> (&str, Vec<&str>, Option<f64>) {
    assert_eq!((diagnosis.verdict, diagnosis.present().count()), (Verdict::Healthy, 0), "{diagnosis:?}");
    let cause = diagnosis.common_cause.as_ref().unwrap_or_else(|| panic!("no common cause in {diagnosis:?}"));
    (cause.kind, cause.columns.iter().map(String::as_str).collect(), cause.value)
}

#[test]
fn swapped_columns_are_asked_about() {
    let swapped = diagnosed(TANKS, &[], |record| {
        let first = std::mem::take(values(record, "level_1"));
        let second = std::mem::replace(values(record, "level_2"), first);
        *values(record, "level_1") = second;
    });
    assert_eq!(healthy_if(&swapped), ("swapped-columns", vec!["level_1", "level_2"], None));
}

#[test]
fn a_turned_sign_is_asked_about() {
    let turned =
        diagnosed(TANKS, &[], |record| values(record, "level_2").iter_mut().for_each(|value| *value = -*value));
    assert_eq!(healthy_if(&turned), ("turned-sign", vec!["level_2"], None));
}

#[test]
fn absolute_pressures_are_not_four_offsets() {
    let absolute = diagnosed(CYLINDER, &[], |record| {
        for column in ["p_pump", "p_P", "p_A", "p_B"] {
            values(record, column).iter_mut().for_each(|value| *value += 101_325.0);
        }
    });
    assert_eq!(healthy_if(&absolute).0, "absolute-pressures");
}

#[test]
fn a_fast_clock_is_not_three_gains() {
    let fast = diagnosed(CYLINDER, &[], |record| record.time.iter_mut().for_each(|time| *time *= 1.01));
    let (kind, _, rate) = healthy_if(&fast);
    assert_eq!(kind, "fast-clock");
    // A row is 0.4 % of the shortest phase; the rate is found far more sharply than that.
    approx::assert_abs_diff_eq!(rate.unwrap(), 0.01, epsilon = 3e-4);
}

/// A record whose column shows so many rows late what acted.
fn delayed(record: &mut Record, column: &str, rows: usize) {
    let values = values(record, column);
    values.rotate_right(rows);
    let first = values[rows];
    values[..rows].fill(first);
}

#[test]
fn a_command_that_is_recorded_late_is_asked_about() {
    // Seven rows of 8 ms: three time constants of the valve.
    let late = diagnosed(CYLINDER, &[], |record| delayed(record, "valve_command", 7));
    assert_eq!(healthy_if(&late), ("late-inputs", vec!["valve_command"], Some(0.056)));
    // What a fault does besides stays a fault.
    let faulty = diagnosed(CYLINDER, &[("sensor.x.offset", "1.5 mm")], |record| delayed(record, "valve_command", 7));
    assert_eq!(faulty.common_cause.as_ref().map(|cause| (cause.kind, cause.value)), Some(("late-inputs", Some(0.056))));
    let present: Vec<&str> = faulty.present().map(|fault| fault.id.as_str()).collect();
    assert_eq!(present, ["sensor.x.offset"]);
}

#[test]
fn warm_oil_is_no_fault_and_a_part_that_runs_easily_no_oil() {
    // A gap and much friction: both go with the viscosity.
    let text = std::fs::read_to_string(CYLINDER).unwrap();
    let text = text.replace("clearance = \"0 mm\"", "clearance = \"0.12 mm\"");
    let text = text
        .replace("\"cylinder.clearance\" = { healthy = \"0 mm\"", "\"cylinder.clearance\" = { healthy = \"0.12 mm\"");
    let text = text.replace("viscous_friction = \"800 N.s/m\"", "viscous_friction = \"4 kN.s/m\"");
    let rig = || Rig::parse("worn.toml", text.clone()).unwrap();
    let warm =
        diagnosed_by(rig(), &[("fluid.viscosity", "25 mPa.s"), ("cylinder.viscous_friction", "2198 N.s/m")], |_| {});
    let (kind, columns, viscosity) = healthy_if(&warm);
    assert_eq!((kind, columns.len()), ("other-oil", 0));
    approx::assert_relative_eq!(viscosity.unwrap(), 0.025, max_relative = 0.01);

    let easily = diagnosed_by(rig(), &[("cylinder.viscous_friction", "2198 N.s/m")], |_| {});
    assert_eq!((easily.verdict, &easily.common_cause), (Verdict::Healthy, &None));
    // Half as much friction is no more than data sheets leave open.
    let off = easily.off_data_sheet.unwrap();
    let friction = off.values.iter().find(|value| value.id == "cylinder.viscous_friction").unwrap();
    approx::assert_relative_eq!(friction.value, 2.198, max_relative = 0.05);
}

#[test]
fn faults_of_two_sensors_stay_faults() {
    let faulty = diagnosed(CYLINDER, &[("sensor.p_A.offset", "1 bar"), ("sensor.q_B.gain", "1.03")], |_| {});
    let present: Vec<&str> = faulty.present().map(|fault| fault.id.as_str()).collect();
    assert_eq!(present, ["sensor.p_A.offset", "sensor.q_B.gain"]);
    assert_eq!((faulty.verdict, &faulty.common_cause), (Verdict::Faulty, &None));
}
