//! The page that adds a component, done: the file that it prints is compiled, and what it promises of it holds.

use crate::diagnosis::Verdict;
use crate::physics::component::{AnyLaw, PortFlows, PortVariables, filter};
use crate::physics::fluid::Fluid;
use crate::report::circuit;
use crate::residual::{ResidualReport, generators};
use crate::simulation::{SimulationOptions, simulate};
use crate::units::Unit;
use crate::{Rig, diagnose};

fn page() -> String {
    std::fs::read_to_string("docs/how-to/add-a-component.md").unwrap()
}

/// The one block of the page in this language.
fn block(language: &str) -> String {
    let page = page();
    let (_, behind) = page.split_once(&format!("```{language}\n")).unwrap();
    behind.split_once("```\n").unwrap().0.to_owned()
}

fn rig() -> Rig {
    Rig::parse("filter.toml", block("toml")).unwrap()
}

/// The file without the comment on top, which is of the file in this tree alone.
fn body(file: &str) -> &str {
    file.split_once("\n\n").unwrap().1
}

#[test]
fn the_page_prints_the_file_that_is_compiled() {
    let file = std::fs::read_to_string("src/physics/component/filter.rs").unwrap();
    assert_eq!(body(&block("rust")), body(&file));
}

#[test]
fn its_number_worked_by_hand_comes_out() {
    let [worked] = filter::CARD.worked else { panic!("one number") };
    let parameters: Vec<f64> = filter::CARD
        .parameters
        .iter()
        .zip(worked.parameters)
        .map(|(own, (_, value))| Unit::parse(own.unit).unwrap().difference_to_si(*value))
        .collect();
    let (mut seen, mut answers) = (PortVariables::default(), PortFlows::default());
    seen.z[..2].copy_from_slice(worked.at);
    AnyLaw::new(&filter::CARD, &parameters, &Fluid::new(&[870.0, 0.0455, 1.4e9, 0.0, 0.0, 0.0]))
        .unwrap()
        .evaluate(&seen, &mut answers);
    approx::assert_relative_eq!(answers.through[0], worked.expect, max_relative = 1e-12);
}

#[test]
fn it_is_drawn_and_has_its_residual() {
    let rig = rig();
    assert!(circuit::svg(&rig, &[]).contains(">filter</text>"));
    let found = generators(&rig);
    let ids: Vec<&str> = found.iter().map(|generator| generator.id.as_str()).collect();
    assert_eq!(ids, ["filter.flow"]);
}

#[test]
fn a_clogged_element_is_diagnosed() {
    let rig = rig();
    let clogged = rig.model().with("filter.clogging", "0.3").unwrap();
    let record =
        simulate(&clogged, None, &SimulationOptions { seed: Some(1), ..SimulationOptions::default() }).unwrap().record;
    let diagnosis = diagnose(&rig.model(), &record, &crate::diagnosis::DiagnosisOptions::default()).unwrap().diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Faulty);
    let present: Vec<_> = diagnosis.present().collect();
    let [clogging] = present.as_slice() else { panic!("{present:?}") };
    assert_eq!(clogging.id, "filter.clogging");
    assert!(!clogging.interval_misses(0.3, 0.0), "{clogging:?}");
    let fired = |alarm: &ResidualReport| alarm.id == "filter.flow" && alarm.fired;
    assert!(diagnosis.residuals.iter().any(fired), "{:?}", diagnosis.residuals);
    assert!(page().contains(&clogging.to_string()), "the page does not print `{clogging}`");
}

#[test]
fn the_healthy_filter_is_healthy() {
    let model = rig().model();
    let record =
        simulate(&model, None, &SimulationOptions { seed: Some(2), ..SimulationOptions::default() }).unwrap().record;
    assert_eq!(model.diagnose(&record).unwrap().verdict, Verdict::Healthy);
}
