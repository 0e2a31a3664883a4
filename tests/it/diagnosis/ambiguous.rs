//! Faults that no record tells from one another are all named.

use std::fs;

use borescope::Model;
use borescope::Rig;
use borescope::internals::diagnosis::{DiagnosisOptions, diagnose};

use crate::support::cycle::Run;

const FILTER: &str = "fixtures/own_filter/rig.toml";

/// The filter with two gaps in parallel that leak past it with the cube of their width, each of a width in mm when new: where one is, the
/// other has no slope, or little.
fn with_two_gaps(new: f64) -> Rig {
    let text = fs::read_to_string(FILTER).unwrap();
    let gap = "\n[own_components.gap]\nmeaning = \"Gap past a seat.\"\nsymbol = \"restrictor\"\n\
               ports = { in = \"hydraulic\", out = \"hydraulic\" }\n\
               parameters.width = { unit = \"mm\", default = \"NEW mm\", bounds = [\"0 mm\", \"1 mm\"], meaning = \"width of the gap\" }\n\
               flow = { from = \"in\", to = \"out\", formula = \"[500 L/min/bar/mm^3] * width^3 * (in.p - out.p)\" }\n\n[nodes]\n";
    let placed =
        |name: &str| format!("{name} = {{ kind = \"own:gap\", ports = {{ in = \"dirty\", out = \"clean\" }} }}\n");
    let fault =
        |name: &str| format!("\"{name}.width\" = {{ healthy = \"NEW mm\", bounds = [\"0 mm\", \"0.5 mm\"] }}\n");
    let text = text
        .replace("\n[nodes]\n", gap)
        .replace("\n[components]\n", &format!("\n[components]\n{}{}", placed("left"), placed("right")))
        .replace("\n[faults]\n", &format!("\n[faults]\n{}{}", fault("left"), fault("right")));
    Rig::parse("gaps.toml", text.replace("NEW mm", &format!("{new} mm"))).unwrap()
}

#[test]
fn a_fault_without_slope_where_it_is_healthy_stands_beside_its_twin() {
    stands_beside_its_twin(0.0);
}

#[test]
fn a_fault_with_little_slope_where_it_is_healthy_stands_beside_its_twin() {
    stands_beside_its_twin(0.05);
}

/// One of two gaps has become 0.2 mm wide.
fn stands_beside_its_twin(new: f64) {
    let model = Model::new(with_two_gaps(new));
    let record = Run::of(&model).with_quantities(&[("left.width", "0.2 mm")]).seed(3).record("gap");
    let found = diagnose(&model, &record, &DiagnosisOptions::default()).unwrap().diagnosis;
    assert_eq!(found.ambiguity, [["left.width", "right.width"]], "{found:?}");
    let one = found.present().next().unwrap();
    assert_eq!(found.present().count(), 1);
    assert!((one.value - 0.2).abs() < 0.002, "{one:?}");
    for fault in found.faults.iter().filter(|fault| fault.id.ends_with(".width")) {
        // No record tells them apart: each is as probable as the other.
        assert!((0.4..0.6).contains(&fault.probability), "{fault:?}");
    }
}

/// A relief valve does nothing until it is set so low that it opens, and not much lower a pump lifts nothing any more.
#[test]
fn a_fault_that_acts_only_far_from_healthy_is_found() {
    let fault = "\n[faults]\n\"relief.set_pressure\" = { bounds = [\"20 bar\", \"220 bar\"] }\n\
                 \"pump.leakage\" = { bounds = [\"0 L/min/bar\", \"0.2 L/min/bar\"] }\n\n[cycle]\n";
    let text = include_str!("scissor_lift.toml").replace("\n[cycle]\n", fault);
    let model = Model::new(Rig::parse("lift.toml", text).unwrap());
    let record = Run::of(&model).with_quantities(&[("relief.set_pressure", "116 bar")]).seed(3).record("lift");
    let found = diagnose(&model, &record, &DiagnosisOptions::default()).unwrap().diagnosis;
    let present: Vec<&str> = found.present().map(|fault| fault.id.as_str()).collect();
    assert_eq!(present, ["relief.set_pressure"], "{found:?}");
    let relief = found.present().next().unwrap();
    assert!((relief.value - 116.0).abs() < 0.5, "{relief:?}");
}
