//! How many simulations the verbs take: what a change of the engine costs shows here before it shows on a clock.

use std::path::Path;

use borescope::Context;
use borescope::Model;
use borescope::Record;
use borescope::Rig;
use borescope::internals::calibration::{self, calibrate};
use borescope::internals::diagnosis::{DiagnosisOptions, diagnose};

fn telescopic() -> Rig {
    Rig::read("fixtures/telescopic/rig.toml").unwrap().with_context(&Context::new())
}

fn record(name: &str) -> Record {
    Record::read(Path::new("fixtures").join(name)).unwrap()
}

/// Simulations and linearisations within a tenth of what they were: fewer ask for a new number as well as more.
fn took(rig: &Rig, simulations: u64, linearisations: u64) {
    let effort = rig.context().effort();
    let found = [effort.simulations(), effort.linearisations()];
    println!("{found:?}");
    for (found, pinned) in found.into_iter().zip([simulations, linearisations]) {
        assert!(found.abs_diff(pinned) * 10 <= pinned, "{found} instead of {pinned}");
    }
}

#[test]
fn a_diagnosis_takes_its_pinned_effort() {
    let rig = telescopic();
    diagnose(&Model::new(rig.clone()), &record("telescopic/leak_020.csv"), &DiagnosisOptions::default()).unwrap();
    took(&rig, 298, 73);
}

#[test]
fn a_calibration_takes_its_pinned_effort() {
    let rig = telescopic();
    let text = std::fs::read_to_string(&rig.path).unwrap();
    calibrate(&text, &rig, &[record("telescopic/healthy_1.csv")], &calibration::CalibrationOptions::default()).unwrap();
    took(&rig, 164, 22);
}

mod studies {
    use super::*;
    use borescope::internals::learn::suggest::suggest;

    #[test]
    #[ignore = "half a minute"]
    fn a_suggestion_takes_its_pinned_effort() {
        let rig = telescopic();
        suggest(&rig, &record("learning/line_fit.csv"), Some(&record("learning/line_check.csv"))).unwrap();
        took(&rig, 1140, 114);
    }
}
