//! How many simulations the verbs take: what a change of the engine costs shows here before it shows on a clock.

use crate::support::telescopic;

/// Simulations and linearisations within a tenth of what they were: fewer ask for a new number as well as more.
fn is_as_pinned(found: [u64; 2], pinned: [u64; 2]) {
    println!("{found:?}");
    for (found, pinned) in found.into_iter().zip(pinned) {
        assert!(found.abs_diff(pinned) * 10 <= pinned, "{found} instead of {pinned}");
    }
}

#[test]
fn a_diagnosis_takes_its_pinned_effort() {
    is_as_pinned(telescopic::diagnosis("leak_020").effort, [226, 15]);
}

#[test]
fn a_calibration_takes_its_pinned_effort() {
    is_as_pinned(telescopic::calibrated().effort, [193, 10]);
}

mod studies {
    use super::*;
    use borescope::{Context, Record, Rig, suggest};

    #[test]
    #[ignore = "half a minute"]
    fn a_suggestion_takes_its_pinned_effort() {
        let rig = Rig::read(telescopic::RIG).unwrap().with_context(&Context::new());
        let record = |name: &str| Record::read(format!("fixtures/learning/{name}.csv")).unwrap();
        suggest(&rig, &record("line_fit"), Some(&record("line_check"))).unwrap();
        let effort = rig.context().effort();
        is_as_pinned([effort.simulations(), effort.linearisations()], [1439, 134]);
    }
}
