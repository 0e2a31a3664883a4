//! Physics at a motor that a closed drive hides.

use std::fs;

use borescope::Rig;
use borescope::internals::learn::evaluated::Conclusion;
use borescope::internals::learn::suggest::suggest;
use borescope::internals::model::Model;

use crate::support::cycle::Run;

const DRIVE: &str = "fixtures/hydrostatic_drive/rig.toml";

/// What is suggested of two records of the drive that hides an effect, with the value found for its first parameter.
fn suggested(effect: &str, values: &str, parameter: &str) -> (Conclusion, String, f64) {
    let hidden = format!("{}\n[effects]\n\"{effect}\" = {values}\n", fs::read_to_string(DRIVE).unwrap());
    let hidden = Model::new(Rig::parse(DRIVE, hidden).unwrap());
    let mut other = hidden.rig.cycle.clone().unwrap();
    // The second input is the torque.
    for phase in &mut other.phases {
        phase.inputs[1].from *= 0.6;
        phase.inputs[1].to *= 0.6;
    }
    let [fit, check] = [(1, hidden.rig.cycle.clone().unwrap()), (2, other)]
        .map(|(seed, cycle)| Run::of(&hidden).through(cycle).seed(seed).record("drive"));
    let found = suggest(&Rig::read(DRIVE).unwrap(), &fit, Some(&check)).unwrap();
    let best = &found.judged[0];
    let rig = &best.trial.rig;
    let value = rig
        .parameter(&format!("{effect}.{parameter}"))
        .map_or(f64::NAN, |index| rig.parameters[index].unit.from_si(best.trial.values[index]));
    (found.conclusion, best.id(), value)
}

#[test]
fn a_line_to_a_motor_is_found() {
    let (conclusion, found, turbulent) =
        suggested("line-resistance@A", "{ turbulent = \"0.004 bar.min2/L2\" }", "turbulent");
    assert_eq!((conclusion, found.as_str()), (Conclusion::EffectFound, "line-resistance@A"));
    approx::assert_relative_eq!(turbulent, 0.004, max_relative = 0.05);
}

#[test]
fn a_hole_across_a_motor_is_no_leak_to_the_tank() {
    let (conclusion, found, area) = suggested("motor-orifice-leakage@motor", "{ area = \"0.5 mm2\" }", "area");
    assert_eq!((conclusion, found.as_str()), (Conclusion::EffectFound, "motor-orifice-leakage@motor"));
    approx::assert_relative_eq!(area, 0.5, max_relative = 0.05);
}
