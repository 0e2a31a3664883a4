//! The desk as a hand works it in a browser.

use std::path::PathBuf;

use super::*;
use crate::support::page;
use crate::support::tab::Tab;

const WORK: Duration = Duration::from_secs(300);
const SOON: Duration = Duration::from_secs(20);

struct Desk {
    running: Running,
    tab: Tab,
    records: [PathBuf; 2],
}

/// A desk for one of the shared rigs, with a tab that has drawn its curves.
fn opened(rig: &str) -> Desk {
    opened_of(FIXTURES, &format!("rig_{rig}"))
}

/// The same for the rig of a folder and a pair of shared records.
fn opened_of(fixtures: &str, pair: &str) -> Desk {
    let records = ["fit", "check"].map(|name| PathBuf::from(format!("../shared/records/{pair}_{name}.csv")));
    let running = Running::of(fixtures, &records[0], &records[1]);
    let mut tab = Tab::open(&format!("http://{}/{}/", running.host, running.secret), (1400, 1000));
    tab.wait(
        "typeof drawn !== 'undefined' && drawn !== null && document.querySelectorAll('#charts canvas').length",
        SOON,
    );
    Desk { running, tab, records }
}

impl Desk {
    fn picture(&mut self, name: &str) {
        if let Some(folder) = std::env::var_os("DESK_PICTURES") {
            self.tab.picture(&Path::new(&folder).join(format!("{name}.png")));
        }
    }

    /// What the gauge over all sensors shows of the record that is fitted to.
    fn error(&mut self) -> f64 {
        let shown = self.tab.script("document.querySelector('[data-sensor=\"all sensors\"] output').textContent");
        shown.as_str().unwrap().trim_end_matches([' ', '×']).parse().unwrap()
    }

    /// Looks for what is missing and adds what comes first; what that is called.
    fn find_and_add(&mut self) -> String {
        self.work("#find");
        let found = self.tab.wait("document.querySelector('#found .one span')?.textContent", SOON);
        let steps = self.tab.script("state.staircase.length");
        self.tab.click("[data-found='0']");
        self.tab.wait(&format!("state.staircase.length > {steps} && drawn.revision >= state.revision"), SOON);
        found.as_str().unwrap().to_owned()
    }

    /// Judges the model on both records, saves it, and compares the saved file on the command line: its comparison with each record.
    fn judged_and_saved(&mut self) -> [Value; 2] {
        self.work("#judge");
        self.tab.wait("state.judged !== null", SOON);
        // A script knows no difference between 22 and 22.0.
        let judged = self.running.state()["judged"].clone();
        self.tab.script("document.getElementById('name').value = 'better.toml'");
        self.tab.script("document.getElementById('save').requestSubmit()");
        self.tab.wait("document.getElementById('note').textContent.startsWith('saved as')", SOON);
        let better = self.running.folder.path().join("better.toml");
        [(&self.records[0], "fit"), (&self.records[1], "check")].map(|(record, name)| {
            let ran = borescope(["compare".as_ref(), better.as_os_str(), record.as_os_str(), "--format=json".as_ref()]);
            let compared: Value = serde_json::from_str(&ran.out).unwrap();
            assert!(compared["times_noise"].is_number(), "{compared}");
            for key in ["times_noise", "chi2_reduced", "channels", "with_faults"] {
                assert_eq!(compared[key], judged[name][key], "{name} {key}");
            }
            compared
        })
    }

    /// Presses a button for long work and waits for its end.
    fn work(&mut self, button: &str) {
        let before = self.tab.script("state.revision");
        self.tab.click(button);
        self.tab.wait(&format!("state.revision > {before} && state.running === null"), WORK);
    }
}

#[test]
#[ignore = "needs a browser"]
fn a_slider_draws_fifteen_pictures_a_second() {
    let running = Running::healthy();
    let mut tab = Tab::open(&format!("http://{}/{}/", running.host, running.secret), (1400, 1000));
    tab.wait(
        "typeof drawn !== 'undefined' && drawn !== null && document.querySelectorAll('#charts canvas').length",
        SOON,
    );
    tab.click("[data-switch='cylinder.clearance']");
    tab.wait("state.cards.some((card) => card.id === 'cylinder.clearance' && card.on)", SOON);
    let spell = "(async () => {
           const input = document.querySelector(\"[data-id='cylinder.clearance']\"), before = frames, begin = performance.now();
           for (let at = 0; performance.now() - begin < 3000; at += 1) {
             input.value = 0.1 + 0.05 * Math.sin(at / 20); input.dispatchEvent(new Event('input'));
             await new Promise((then) => requestAnimationFrame(then));
           }
           return (frames - before) / (performance.now() - begin) * 1000;
         })()";
    // What else this machine does takes away from it and never adds: the best of three spells.
    let spells = [(); 3].map(|()| tab.script(spell).as_f64().unwrap());
    let best = spells.into_iter().fold(0.0, f64::max);
    eprintln!("{spells:.1?} pictures a second");
    assert!(best >= 15.0, "{spells:.1?} pictures a second");
    assert_eq!(tab.complaints, [""; 0]);
}

#[test]
#[ignore = "needs a browser, ../shared/records and a minute"]
fn the_leak_of_rig_a_is_seen_found_added_judged_and_saved() {
    let mut desk = opened("a");
    let misfit = desk.error();
    assert!(misfit > 10.0, "{misfit}");
    desk.picture("a-1-misfit");
    assert_eq!(desk.find_and_add(), "external-leakage@A");
    desk.picture("a-2-added");
    let left = desk.error();
    assert!(left < 0.1 * misfit, "{misfit} to {left}");
    desk.judged_and_saved();
    desk.picture("a-3-judged");
    if page::blessed() {
        desk.tab.picture(Path::new("docs/figures/desk.png"));
    }
    assert_eq!(desk.tab.complaints, [""; 0]);
}

#[test]
#[ignore = "needs a browser, ../shared/records and two minutes"]
fn friction_and_a_line_are_seen_found_added_judged_and_saved() {
    for (rig, effect) in [("b", "seal-friction@cylinder"), ("c", "line-resistance@A")] {
        let mut desk = opened(rig);
        let misfit = desk.error();
        assert_eq!(desk.find_and_add(), effect);
        desk.picture(&format!("{rig}-2-added"));
        let left = desk.error();
        assert!(misfit > 2.0 && left < 0.5 * misfit, "{rig}: {misfit} to {left}");
        for compared in desk.judged_and_saved() {
            // What is left is nothing, or a fault of the record.
            let explains = [&compared["adequate"], &compared["with_faults"]["adequate"]];
            assert!(explains.iter().any(|one| **one == true), "{rig}: {compared}");
        }
        assert_eq!(desk.tab.complaints, [""; 0]);
    }
}

#[test]
#[ignore = "needs a browser, ../shared/records and a minute"]
fn the_tanks_get_one_effect_after_the_other() {
    let mut desk = opened_of("fixtures/cascaded_tanks", "tanks");
    let mut errors = vec![desk.error()];
    let mut added = Vec::new();
    while added.len() < 3 {
        added.extend(desk.find_and_add().split(" + ").map(str::to_owned));
        errors.push(desk.error());
    }
    desk.picture("tanks-2-added");
    added.sort();
    assert_eq!(added, ["dead-voltage", "reservoir-overflow@lower", "reservoir-overflow@upper"]);
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
    desk.judged_and_saved();
    assert_eq!(desk.tab.complaints, [""; 0]);
}

#[test]
#[ignore = "needs a browser, ../shared/records and a minute"]
fn the_tight_spot_of_rig_d_is_drawn_told_written_and_added() {
    let mut desk = opened("d");
    let misfit = desk.error();
    desk.work("#find");
    let found = desk.tab.wait("document.querySelector('#found .one span')?.textContent", SOON);
    assert_eq!(found, "empirical-friction@cylinder");
    let curve =
        desk.tab.script("document.querySelector('#found .rise polyline').getAttribute('points').split(' ').length");
    assert!(curve.as_u64().is_some_and(|points| points > 100), "{curve}");
    let told = desk.tab.script("document.getElementById('found').textContent");
    let told = told.as_str().unwrap();
    assert!(told.contains("extra friction of ") && told.contains(" mm wide"), "{told}");
    let formula = desk.tab.script("document.querySelector('#found pre').textContent");
    desk.picture("d-2-found");
    desk.tab.click("[data-found='0']");
    desk.tab.wait("state.staircase.length === 2", SOON);
    let left = desk.error();
    assert!(left < 0.6 * misfit, "{misfit} to {left}");
    desk.picture("d-3-added");
    // The formula is one that a rig file takes.
    let rig = desk.running.folder.path().join("law.toml");
    let with_law = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap() + "\n" + formula.as_str().unwrap();
    std::fs::write(&rig, with_law).unwrap();
    assert_eq!(borescope(["check".as_ref(), rig.as_os_str()]).status, Some(0));
    assert_eq!(desk.tab.complaints, [""; 0]);
}
