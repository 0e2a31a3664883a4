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
    let records = ["fit", "check"].map(|name| PathBuf::from(format!("../shared/records/rig_{rig}_{name}.csv")));
    let running = Running::new(&records[0], &records[1]);
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
    desk.work("#find");
    let found = desk.tab.wait("document.querySelector('#found .one span')?.textContent", SOON);
    assert_eq!(found, "external-leakage@A");
    desk.picture("a-2-found");
    desk.tab.click("[data-found='0']");
    desk.tab.wait("state.staircase.length === 2", SOON);
    let left = desk.error();
    assert!(left < 0.1 * misfit, "{misfit} to {left}");
    desk.work("#judge");
    desk.tab.wait("state.judged !== null", SOON);
    // A script knows no difference between 22 and 22.0.
    let judged = desk.running.state()["judged"].clone();
    desk.picture("a-3-judged");
    if page::blessed() {
        desk.tab.picture(Path::new("docs/figures/desk.png"));
    }
    desk.tab.script("document.getElementById('name').value = 'better.toml'");
    desk.tab.script("document.getElementById('save').requestSubmit()");
    desk.tab.wait("document.getElementById('note').textContent.startsWith('saved as')", SOON);
    let better = desk.running.folder.path().join("better.toml");
    for (record, name) in desk.records.iter().zip(["fit", "check"]) {
        let ran = borescope(["compare".as_ref(), better.as_os_str(), record.as_os_str(), "--format=json".as_ref()]);
        let compared: Value = serde_json::from_str(&ran.out).unwrap();
        for key in ["times_noise", "chi2_reduced", "channels", "with_faults"] {
            assert_eq!(compared[key], judged[name][key], "{name} {key}");
        }
    }
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
