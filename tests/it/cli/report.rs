//! Every page of `--report`: whole, alone, small; and opened in a browser, where there is one.

use crate::support::browser;
use crate::support::command;
use crate::support::leaking;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use browser::{browser, call};
use command::borescope;
use leaking::leaking;
use serde_json::Value;
use tempfile::TempDir;

const RIG: &str = "fixtures/telescopic/rig.toml";
/// 10,100 rows.
const LONG: &str = "fixtures/telescopic/series_1.csv";
const TANKS: &str = "fixtures/two_tanks/rig.toml";
/// How often a page is opened at most.
const TRIES: usize = 5;
/// What a page may be.
const MOST_BYTES: usize = 1_500_000;
/// Pages of these have at least so many charts.
const CHARTS: [(&str, u64); 10] = [
    ("diagnose", 44),
    ("compare", 17),
    ("suggest", 34),
    ("improve", 36),
    ("campaign", 3),
    ("isolability", 0),
    ("effects", 0),
    ("history", 1),
    ("fleet", 0),
    ("calibrate", 4),
];

/// Those of which the curves are written too.
const WITH_CURVES: [&str; 4] = ["diagnose", "compare", "suggest", "improve"];

struct Pages {
    // Removed at the end.
    folder: TempDir,
    paths: BTreeMap<&'static str, PathBuf>,
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

fn ran(arguments: &[String]) {
    let ran = borescope(arguments);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""), "{arguments:?}");
    // What was written is told, the page among it; what to type next is the last command.
    let named = arguments
        .windows(2)
        .filter(|two| ["--report", "--curves", "-o"].contains(&two[0].as_str()))
        .map(|two| two[1].clone());
    let (mut named, mut written): (Vec<String>, Vec<String>) = (named.collect(), ran.written);
    named.sort();
    written.sort();
    assert_eq!(written, if arguments[0] == "--quiet" { Vec::new() } else { named }, "{arguments:?}");
    let last =
        ran.out.lines().rev().take(2).any(|line| line.contains("borescope ") || line.starts_with("Intervals hold"));
    assert!(last, "{arguments:?}: {}", ran.out);
}

fn words(line: &str) -> Vec<String> {
    line.split(' ').map(str::to_owned).collect()
}

/// Every page, made once for all tests.
fn pages() -> &'static Pages {
    static PAGES: OnceLock<Pages> = OnceLock::new();
    PAGES.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| text(&folder.path().join(name));
        leaking(folder.path());
        kept(&folder);
        let (rig, fit, check, new) = (path("rig.toml"), path("fit.csv"), path("check.csv"), path("new.toml"));
        let calls = [
            ("diagnose", format!("diagnose {RIG} {LONG}")),
            ("compare", format!("compare {RIG} {LONG}")),
            ("suggest", format!("suggest {rig} {fit} --check {check}")),
            ("improve", format!("improve {rig} --fit {fit} --check {check} -o {new}")),
            ("campaign", format!("campaign {TANKS} --cases 20")),
            ("isolability", format!("isolability {RIG}")),
            ("effects", "effects".to_owned()),
            ("history", format!("history {} --store {}", path("tanks.toml"), path("store"))),
            ("fleet", format!("fleet {}", path("store"))),
            ("calibrate", format!("calibrate {TANKS} {} -o {}", path("healthy.csv"), path("calibrated.toml"))),
        ];
        let mut paths = BTreeMap::new();
        for (verb, call) in calls {
            let page = folder.path().join(format!("{verb}.html"));
            let curves = if WITH_CURVES.contains(&verb) {
                format!(" --curves {}", text(&page.with_extension("csv")))
            } else {
                String::new()
            };
            ran(&words(&format!("{call}{curves} --report {}", text(&page))));
            paths.insert(verb, page);
        }
        Pages { folder, paths }
    })
}

/// A store with the runs of an outlet that grows towards its limit, and a healthy record of before.
fn kept(folder: &TempDir) {
    let path = |name: &str| text(&folder.path().join(name));
    ran(&words(&format!("simulate {TANKS} --seed 9 -o {}", path("healthy.csv"))));
    let healthy = "\"upper_outlet.diameter\" = {";
    let rig = fs::read_to_string(TANKS).unwrap();
    assert!(rig.contains(healthy));
    fs::write(path("tanks.toml"), rig.replace(healthy, &format!("{healthy} limit = \"8.8 mm\","))).unwrap();
    for day in 1..=4 {
        let record = path(&format!("day_{day}.csv"));
        let grown = 8.0 + 0.1 * f64::from(day);
        let set = format!("upper_outlet.diameter={grown}mm");
        ran(&words(&format!("simulate {TANKS} --set {set} --seed {day} -o {record}")));
        let (rig, store) = (path("tanks.toml"), path("store"));
        ran(&words(&format!("--quiet diagnose {rig} {record} --store {store} --at 2026-05-0{day}")));
    }
}

/// Elements that are open at the end, or closed without having been opened.
fn unbalanced(html: &str) -> Vec<String> {
    const VOID: [&str; 4] = ["meta", "br", "hr", "!DOCTYPE"];
    let (mut open, mut wrong): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        let end = rest.find('>').unwrap_or(rest.len());
        let (tag, behind) = rest.split_at(end);
        let name: String =
            tag.trim_start_matches('/').chars().take_while(|c| !c.is_whitespace() && *c != '/').collect();
        rest = behind;
        if tag.starts_with('/') {
            if open.pop().as_deref() != Some(&name) {
                wrong.push(format!("</{name}>"));
            }
        } else if !tag.ends_with('/') && !VOID.contains(&name.as_str()) {
            // Scripts and styles hold no elements.
            if name == "script" || name == "style" {
                let close = rest.find(&format!("</{name}>")).unwrap_or(rest.len());
                rest = &rest[close..];
            }
            open.push(name);
        }
    }
    wrong.extend(open);
    wrong
}

#[test]
fn every_page_is_whole_alone_and_small() {
    for (verb, path) in &pages().paths {
        let html = fs::read_to_string(path).unwrap();
        assert!(html.starts_with("<!DOCTYPE html>\n<html lang=\"en\">") && html.ends_with("</html>\n"), "{verb}");
        assert_eq!(unbalanced(&html), Vec::<String>::new(), "{verb}");
        for foreign in ["http://", "https://", "<script src", "<link", "<img", "@import", "url(", "fetch("] {
            assert!(!html.contains(foreign), "{verb}: {foreign}");
        }
        assert!(html.contains("default-src 'none'"), "{verb}");
        assert!(!html.contains("NaN\"") && !html.contains("\"inf") && !html.contains("NaN%"), "{verb}");
        assert!(html.len() < MOST_BYTES, "{verb}: {} bytes", html.len());
        println!("{verb}: {} kB", html.len() / 1000);
        for heading in html.split("<h2 id=\"").skip(1) {
            let id = heading.split('"').next().unwrap();
            assert_eq!(html.matches(&format!("id=\"{id}\"")).count(), 1, "{verb}: {id}");
        }
    }
}

/// Ends of an axis.
type Ends = (f64, f64);

/// Ends of the axes of a chart of a page, and the points of one of its curves in the units of these.
fn curve(html: &str, chart: &str, curve: usize) -> ([Ends; 2], Vec<(f64, f64)>) {
    let figure = html
        .split("<figure class=\"chart\"")
        .find(|part| part.starts_with(&format!(" data-name=\"{chart}\"")))
        .unwrap();
    let ends = |name: &str| {
        let text = figure.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap();
        let ends: Vec<f64> = text.split(' ').map(|number| number.parse().unwrap()).collect();
        (ends[0], ends[1])
    };
    let (x, y) = (ends(" data-x"), ends("data-y"));
    let path = figure.split("<path ").find(|path| path.contains(&format!("data-curve=\"{curve}\" d="))).unwrap();
    let path = path.split(" d=\"").nth(1).unwrap().split('"').next().unwrap();
    let mut points = Vec::new();
    for piece in path.split('M').filter(|piece| !piece.is_empty()) {
        // Differences stand without a blank before a minus.
        let spaced = piece.replace('l', " ").replace('-', " -");
        let numbers: Vec<f64> = spaced.split_whitespace().map(|number| number.parse().unwrap()).collect();
        let mut at = (0.0, 0.0);
        for pair in numbers.chunks(2) {
            at = (at.0 + pair[0], at.1 + pair[1]);
            points.push((x.0 + at.0 / 1e4 * (x.1 - x.0), y.1 - at.1 / 5e3 * (y.1 - y.0)));
        }
    }
    ([x, y], points)
}

#[test]
fn the_misfit_that_is_drawn_is_measured_minus_model_over_the_noise() {
    for verb in WITH_CURVES {
        let page = &pages().paths[verb];
        let rows = fs::read_to_string(page.with_extension("csv")).unwrap();
        let mut rows = rows.lines();
        let heads: Vec<&str> = rows.next().unwrap().split(',').collect();
        let rows: Vec<Vec<f64>> =
            rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()).collect();
        let column = |name: &str| heads.iter().position(|head| head.starts_with(&format!("{name} "))).unwrap();
        let html = fs::read_to_string(page).unwrap();
        // An improvement shows the check record first; the curves are of the other.
        let html = if verb == "improve" { html.rsplit_once(">The fit record<").unwrap().1 } else { &html };
        for (sensor, noise) in [("p_P", 0.25), ("q_A", 0.03), ("x", 0.03)] {
            let measured = column(&format!("{sensor}.measured"));
            for (drawn, model) in ["model", "found"].into_iter().enumerate() {
                let model = column(&format!("{sensor}.{model}"));
                let samples: Vec<(f64, f64)> =
                    rows.iter().map(|row| (row[0], (row[measured] - row[model]) / noise)).collect();
                let ([x, y], points) = curve(html, &format!("misfit of {sensor}"), drawn);
                // Drawn as finely as the chart is, and thinned where it runs straight.
                assert!(points.len() > 100, "{verb}, {sensor}: {} points", points.len());
                // A place of the grid to each side.
                let grid = (1.01e-4 * (x.1 - x.0), 2.02e-4 * (y.1 - y.0));
                for (time, misfit) in points {
                    let near = samples.iter().filter(|sample| (sample.0 - time).abs() <= grid.0);
                    assert!(
                        near.clone().any(|sample| (sample.1 - misfit).abs() <= grid.1),
                        "{verb}, {sensor} at {time} s: {misfit} drawn, {:?}",
                        near.collect::<Vec<_>>()
                    );
                }
            }
        }
    }
}

#[test]
fn the_first_picture_of_what_is_missing_is_at_the_place_of_the_verdict() {
    for verb in ["suggest", "improve"] {
        let html = fs::read_to_string(&pages().paths[verb]).unwrap();
        let section = html.split(">What is missing</h2>").nth(1).unwrap();
        let first = section.split("data-name=\"").nth(1).unwrap();
        assert!(first.starts_with("flow to the tank at A\""), "{verb}: {}", &first[..40]);
    }
    let html = fs::read_to_string(&pages().paths["suggest"]).unwrap();
    // The law is a line through the origin, and the record asks for it.
    let ([_, y], law) = curve(&html, "flow to the tank at A", 1);
    let (_, asked) = curve(&html, "flow to the tank at A", 0);
    let middle = |points: &[(f64, f64)]| points[points.len() / 2];
    let (law, asked) = (middle(&law), middle(&asked));
    assert!(law.1 > 0.0 && (law.1 - asked.1).abs() < 0.1 * (y.1 - y.0), "{law:?} {asked:?}");
}

#[test]
fn a_law_in_a_parameter_that_the_circuit_has_anyway_is_drawn_at_its_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| text(&folder.path().join(name));
    let (example, rig) = (path("example"), path("example/rig.toml"));
    assert_eq!(borescope(words(&format!("example {example}"))).status, Some(0));
    for (seed, record) in [(1, path("fit.csv")), (2, path("check.csv"))] {
        ran(&words(&format!("simulate {rig} --set cylinder.viscous_friction=20kN.s/m --seed {seed} -o {record}")));
    }
    let (new, page) = (path("new.toml"), path("page.html"));
    let files = format!("--fit {} --check {} -o {new} --report {page}", path("fit.csv"), path("check.csv"));
    ran(&words(&format!("improve {rig} {files}")));
    let html = fs::read_to_string(&page).unwrap();
    let (_, law) = curve(&html, "force against the motion at cylinder", 1);
    // The example has 2 kN.s/m: the law is what is more of it, a line through the origin.
    let last = law.last().unwrap();
    let slope = last.1 / last.0;
    assert!((slope / 18.0 - 1.0).abs() < 0.2, "{slope} N.s/mm of 18 at {last:?}");
}

#[test]
fn the_misfit_by_phase_says_of_which_model_it_is() {
    for (verb, name) in [
        ("diagnose", "with the faults"),
        ("compare", "with the faults that explain it best"),
        ("suggest", "with external-leakage@A"),
        ("improve", "with external-leakage@A"),
    ] {
        let html = fs::read_to_string(&pages().paths[verb]).unwrap();
        assert!(html.contains(&format!("Misfit by phase, {name}, times the sensor noise")), "{verb}");
    }
}

#[test]
fn a_calibrated_value_is_drawn_upon_what_was_known_before() {
    let html = fs::read_to_string(&pages().paths["calibrate"]).unwrap();
    let (_, table) = html.split_once("Before and after, ").unwrap();
    let (table, _) = table.split_once("</table>").unwrap();
    let rows = table.matches("<tr><td>").count();
    assert!(rows > 0 && table.matches("class=\"bar\"").count() == rows);
    assert_eq!(table.matches("class=\"interval\"").count(), rows);
}

#[test]
fn what_was_found_stands_before_the_circuit_and_the_circuit_before_the_curves() {
    let html = fs::read_to_string(&pages().paths["diagnose"]).unwrap();
    let place = |part: &str| html.find(part).unwrap_or_else(|| panic!("{part}"));
    let order = ["<article class=\"finding alert\">", ">Circuit</h2>", "data-name=\"x\"", "<details"];
    assert!(order.windows(2).all(|pair| place(pair[0]) < place(pair[1])), "{order:?}");
    assert_eq!(html.matches("<article class=\"finding").count(), 3);
    assert!(html.contains("<footer>borescope "));
}

#[test]
fn a_page_is_the_same_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let [once, again] = ["once.html", "again.html"].map(|name| folder.path().join(name));
    let made = pages();
    let path = |name: &str| text(&made.folder.path().join(name));
    let calls = [
        format!("diagnose {TANKS} {}", path("healthy.csv")),
        format!("isolability {RIG}"),
        format!("history {} --store {}", path("tanks.toml"), path("store")),
        format!("fleet {}", path("store")),
    ];
    for call in calls {
        let [once, again] = [once.clone(), again.clone()].map(|page| {
            ran(&words(&format!("{call} --force --report {}", text(&page))));
            fs::read(&page).unwrap()
        });
        assert_eq!(once, again, "{call}");
    }
}

mod studies {
    use super::*;

    #[test]
    #[ignore = "half a minute"]
    fn the_page_of_a_suggestion_is_the_same_every_time() {
        let folder = tempfile::tempdir().unwrap();
        let again = folder.path().join("again.html");
        let made = pages();
        let path = |name: &str| text(&made.folder.path().join(name));
        let call = format!("suggest {} {} --check {}", path("rig.toml"), path("fit.csv"), path("check.csv"));
        ran(&words(&format!("{call} --report {}", text(&again))));
        assert_eq!(fs::read(&again).unwrap(), fs::read(&made.paths["suggest"]).unwrap());
    }
}

#[test]
fn a_page_that_cannot_be_written_is_refused_before_the_work() {
    let verbs = [
        format!("compare {RIG} {LONG}"),
        format!("suggest {RIG} {LONG}"),
        format!("campaign {TANKS} --cases 1"),
        format!("isolability {RIG}"),
        "effects".to_owned(),
    ];
    for call in verbs {
        let ran = borescope(words(&format!("{call} --report missing/page.html")));
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{call}");
        assert!(ran.err.contains("there is no folder") && ran.err.contains("  help: "), "{call}: {}", ran.err);
    }
}

/// Opens a page in a frame of this width and gives what its self-test told.
fn opened(browser: &str, page: &Path, width: u32, dark: bool) -> Value {
    // A browser on a busy machine may be asked for the page before the frame has told anything.
    let told = (0..TRIES).find_map(|_| told(browser, page, width, dark));
    told.unwrap_or_else(|| panic!("{}: the self-test told nothing", page.display()))
}

/// What the self-test told, or `None` where it was not heard.
fn told(browser: &str, page: &Path, width: u32, dark: bool) -> Option<Value> {
    let folder = tempfile::tempdir().unwrap();
    let html = fs::read_to_string(page).unwrap();
    let test = include_str!("report/selftest.js");
    let copy = html.replacen("<head>\n", &format!("<head>\n<script>\n{test}</script>\n"), 1);
    fs::write(folder.path().join("page.html"), copy).unwrap();
    let frame = format!(
        "<!DOCTYPE html><html><body><iframe style=\"border:0;width:{width}px;height:900px\" src=\"page.html\"></iframe>\
         <pre id=\"told\"></pre><script>addEventListener('message', (event) => {{ \
         document.getElementById('told').textContent = event.data; }});</script></body></html>"
    );
    let outer = folder.path().join("frame.html");
    fs::write(&outer, frame).unwrap();
    let output = call(browser, folder.path(), (width + 40, 1000), dark)
        .arg("--dump-dom")
        .arg(format!("file://{}", outer.display()))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let console: Vec<&str> = said.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(console.is_empty(), "{}: {console:?}", page.display());
    let dom = String::from_utf8_lossy(&output.stdout);
    let told = dom.split("<pre id=\"told\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let told = told?.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    serde_json::from_str(&told).ok()
}

/// Pages as they are opened.
mod in_a_browser {
    use super::*;

    #[test]
    #[ignore = "needs Chromium"]
    fn every_page_works_in_a_browser() {
        let browser = browser();
        for (verb, path) in &pages().paths {
            for (width, dark) in [(1400, false), (1400, true), (400, false), (400, true)] {
                let told = opened(browser, path, width, dark);
                let what = format!("{verb}, {width} px, dark {dark}: {told}");
                for key in ["errors", "empty", "wrong", "overlapping", "requests"] {
                    assert_eq!(told[key], Value::Array(Vec::new()), "{key} of {what}");
                }
                assert_eq!((&told["width"], &told["dark"]), (&width.into(), &dark.into()), "{what}");
                assert!(told["wider"].as_i64().is_some_and(|wider| wider <= 0), "the page scrolls sideways: {what}");
                assert_eq!((&told["unnamed"], &told["copies"]), (&0.into(), &told["tables"]), "{what}");
                let least = CHARTS.iter().find(|(name, _)| name == verb).unwrap().1;
                let count = |key: &str| told[key].as_u64().unwrap();
                assert!(count("charts") >= least, "{what}");
                assert!(least < 3 || (count("zoomed") > 2 * least / 3 && count("pointed") > least / 2), "{what}");
                assert_eq!(
                    told["saved"].as_array().map(Vec::len),
                    Some((count("charts") + count("drawings")) as usize),
                    "{what}"
                );
            }
        }
    }
}
