//! What is another in each record and known of none: a load that nobody weighed.

use approx::assert_relative_eq;
use borescope::internals::calibration::{CalibrationOptions, calibrate_rig};
use borescope::internals::diagnosis::Verdict;
use borescope::internals::rig::Rig;
use borescope::{Record, suggest};

use crate::support::cycle::Run;

/// A pump that delivers 2 % less than its data sheet.
const SMALLER: &str = "7.84 cc/rev";

/// A lift table with so many kilograms on it that its column knows nothing of.
fn lift(role: &str) -> Rig {
    let parameter = format!(
        "parameters.unweighed = {{ unit = \"kg\", default = \"0 kg +- 60 kg\", bounds = [\"-400 kg\", \"400 kg\"], {role}meaning = \"load that was not weighed\" }}"
    );
    let text = include_str!("scissor_lift.toml")
        .replace("parameters.stroke", &format!("{parameter}\nparameters.stroke"))
        .replace("(load + own_mass)", "(load + own_mass + unweighed)");
    Rig::parse("lift.toml", text).unwrap()
}

/// A healthy record with a load that differs from its column, of a pump with this displacement.
fn record(rig: &Rig, (displacement, unweighed): (&str, &str), seed: u64) -> Record {
    let truth = [("scissor.unweighed", unweighed), ("pump.displacement", displacement)];
    Run::of(&rig.model()).with_quantities(&truth).seed(seed).record("lift.csv")
}

#[test]
fn a_load_of_each_record_spoils_no_calibration() {
    let rig = lift("role = \"record\", ");
    let records = [record(&rig, (SMALLER, "70 kg"), 1), record(&rig, (SMALLER, "-50 kg"), 2)];
    let (found, report) = calibrate_rig(&rig, &records, &CalibrationOptions::default()).unwrap();
    assert!(report.adequate, "{:?}", report.warnings);
    let of = |id: &str| &found.parameters[found.parameter(id).unwrap()];
    assert_relative_eq!(of("pump.displacement").value, 7.84e-6, max_relative = 2e-3);
    // The next record has a load of its own again, which is no fault of its own.
    let stated = of("scissor.unweighed");
    assert_eq!((stated.value, stated.sigma), (0.0, 60.0));
    let diagnosis = found.model().diagnose(&record(&rig, (SMALLER, "-90 kg"), 3)).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::Healthy);
    let load = diagnosis.uncertain.iter().find(|one| one.id == "scissor.unweighed").unwrap();
    assert_relative_eq!(load.value, -90.0, epsilon = 3.0);

    // Taken for one load of all records it explains neither.
    let one = lift("");
    let (_, report) = calibrate_rig(&one, &records, &CalibrationOptions::default()).unwrap();
    assert!(!report.adequate);
}

#[test]
fn a_check_record_has_its_own_load() {
    let rig = lift("role = \"record\", ");
    let suggestion =
        suggest(&rig, &record(&rig, ("8 cc/rev", "70 kg"), 1), Some(&record(&rig, ("8 cc/rev", "-90 kg"), 2))).unwrap();
    assert!(suggestion.base_check.as_ref().unwrap().normalised < 1.1, "{}", suggestion.base_check.unwrap().normalised);
}
