//! The page that adds a component, done: the file that it prints is the one that is compiled, and what it promises of it holds.

use borescope::internals::diagnosis::Verdict;
use borescope::internals::report::circuit;
use borescope::internals::residual::generators;
use borescope::internals::simulation::{SimulationOptions, simulate};
use borescope::{Diagnosis, Rig};

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
    Rig::read("fixtures/suction/rig.toml").unwrap()
}

/// The diagnosis of a record of the rig with so much of the mesh clogged.
fn diagnosed(clogging: &str) -> Diagnosis {
    let model = rig().model();
    let clogged = model.with("strainer.clogging", clogging).unwrap();
    let options = SimulationOptions { seed: Some(1), ..SimulationOptions::default() };
    model.diagnose(&simulate(&clogged, None, &options).unwrap().record).unwrap()
}

#[test]
fn the_page_prints_the_file_that_is_compiled_and_the_rig_that_is_diagnosed() {
    assert_eq!(block("rust"), std::fs::read_to_string("src/physics/component/suction_strainer.rs").unwrap());
    assert!(std::fs::read_to_string("fixtures/suction/rig.toml").unwrap().ends_with(&block("toml")));
}

#[test]
fn it_is_drawn_and_has_its_residual() {
    assert!(circuit::svg(&rig(), &[]).contains(">strainer</text>"));
    assert!(generators(&rig()).iter().any(|generator| generator.id == "strainer.flow"));
}

#[test]
fn a_clogged_mesh_is_diagnosed_below_and_above_its_bypass() {
    for (clogging, size) in [("0.5", 0.5), ("0.9", 0.9)] {
        let diagnosis = diagnosed(clogging);
        assert_eq!(diagnosis.verdict, Verdict::Faulty);
        let present: Vec<_> = diagnosis.present().collect();
        let [found] = present.as_slice() else { panic!("{present:?}") };
        assert_eq!(found.id, "strainer.clogging");
        assert!(!found.interval_misses(size, 0.0), "{found:?}");
        assert!(diagnosis.residuals.iter().any(|alarm| alarm.id == "strainer.flow" && alarm.fired));
    }
    assert_eq!(diagnosed("0").verdict, Verdict::Healthy);
}
