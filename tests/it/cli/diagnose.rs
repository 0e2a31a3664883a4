//! `diagnose` as programs see it: its JSON, its exit status, several records, its page, what it refuses.

use crate::support::command;

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use borescope::internals::files::digest;
use command::{Ran, borescope};
use serde_json::Value;

const RIG: &str = "fixtures/telescopic/rig.toml";
const LEAK: &str = "fixtures/telescopic/leak_020.csv";
const HEALTHY: &str = "fixtures/telescopic/healthy_2.csv";
/// The leak as JSON, worked out once for all tests.
fn leak() -> &'static Ran {
    static RAN: OnceLock<Ran> = OnceLock::new();
    RAN.get_or_init(|| borescope(["diagnose", RIG, LEAK, "--format", "json"]))
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

/// Whether a value is what a letter stands for: `s` a text, `n` a number, `b` true or false, `a` a list, `0` null.
fn is(value: &Value, letter: char) -> bool {
    match letter {
        's' => value.is_string(),
        'n' => value.is_number(),
        'b' => value.is_boolean(),
        'a' => value.is_array(),
        '0' => value.is_null(),
        _ => panic!("no type is called `{letter}`"),
    }
}

#[test]
fn a_result_says_from_which_files_it_is_made() {
    let made = &json(&leak().out)["provenance"];
    let file = |path: &str| serde_json::json!([{ "file": path, "sha256": digest(&fs::read(path).unwrap()) }]);
    assert_eq!(made["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&made["rig_files"], &made["records"]), (&file(RIG), &file(LEAK)));
}

/// An object has all of these keys, each of one of the types behind it.
fn has(object: &Value, keys: &[(&str, &str)]) {
    for (key, types) in keys {
        let value = object.get(*key).unwrap_or_else(|| panic!("`{key}` is missing in {object}"));
        assert!(types.chars().any(|letter| is(value, letter)), "`{key}` is {value}, not one of `{types}`");
    }
}

fn list<'a>(object: &'a Value, key: &str) -> &'a [Value] {
    object[key].as_array().unwrap_or_else(|| panic!("`{key}` is no list"))
}

fn is_probability(value: &Value) {
    assert!(value.as_f64().is_some_and(|p| (0.0..=1.0).contains(&p)), "{value}");
}

#[test]
fn the_json_has_every_promised_key_with_its_type() {
    let ran = leak();
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    let diagnosis = json(&ran.out);
    has(
        &diagnosis,
        &[
            ("schema", "s"),
            ("record", "s"),
            ("verdict", "s"),
            ("detected_at_s", "n0"),
            ("faults", "a"),
            ("hypotheses", "a"),
            ("residuals", "a"),
        ],
    );
    assert_eq!(diagnosis["schema"], "borescope.diagnosis/1");
    assert_eq!(diagnosis["record"], LEAK);
    assert_eq!(diagnosis["verdict"], "faulty");
    assert!(
        diagnosis["detected_at_s"].as_f64().is_some_and(|at| at > 0.0 && at < 5.0),
        "{}",
        diagnosis["detected_at_s"]
    );

    let faults = list(&diagnosis, "faults");
    let ids: Vec<&str> = faults.iter().filter_map(|fault| fault["id"].as_str()).collect();
    let rig = borescope::Rig::read(RIG).unwrap();
    let all: Vec<&str> = rig.faults.iter().map(|fault| rig.parameters[fault.parameter].id.as_str()).collect();
    assert_eq!(ids, all, "every fault of the rig, in its order");
    assert_eq!(ids[..3], ["cylinder.clearance", "flow_control.orifice_diameter", "directional_valve.opening"]);
    for fault in faults {
        let keys =
            [("value", "n"), ("unit", "s"), ("healthy", "n"), ("ci95", "a"), ("present", "b"), ("identifiable", "bs")];
        has(fault, &keys);
        is_probability(&fault["probability"]);
        let ends = list(fault, "ci95");
        assert!(ends.len() == 2 && ends.iter().all(|end| is(end, 'n') || is(end, '0')), "{fault}");
        let open: Vec<bool> = ends.iter().map(Value::is_null).collect();
        // An end is null exactly where the word says so.
        match (&fault["identifiable"], open.as_slice()) {
            (Value::Bool(true), [false, false]) | (Value::Bool(false), [true, true]) => {}
            (Value::String(word), [false, true]) if word == "lower-bound-only" => {}
            (Value::String(word), [true, false]) if word == "upper-bound-only" => {}
            (word, _) => panic!("{word} with {}", fault["ci95"]),
        }
    }
    let clearance = &faults[0];
    assert_eq!((&clearance["present"], clearance["unit"].as_str()), (&Value::Bool(true), Some("mm")));
    assert!(clearance["value"].as_f64().is_some_and(|value| (0.195..0.205).contains(&value)), "{clearance}");

    let findings = list(&diagnosis, "findings");
    assert!(findings.len() == 1 && findings[0]["id"] == "cylinder.clearance", "{findings:?}");
    assert_eq!((&findings[0]["direction"], &findings[0]["value"]), (&"larger".into(), &clearance["value"]));
    // The leak takes its flow from the supply.
    let more = |one: &Value| one["sensor"] == "q_P" && one["change"].as_f64().is_some_and(|change| change > 0.0);
    assert!(list(&findings[0], "consequences").iter().any(more), "{findings:?}");

    let hypotheses = list(&diagnosis, "hypotheses");
    assert!(!hypotheses.is_empty());
    for hypothesis in hypotheses {
        is_probability(&hypothesis["probability"]);
        assert!(list(hypothesis, "faults").iter().all(Value::is_string));
    }
    assert_eq!(hypotheses[0]["faults"], serde_json::json!(["cylinder.clearance"]));

    let residuals = list(&diagnosis, "residuals");
    assert!(!residuals.is_empty());
    for residual in residuals {
        has(
            residual,
            &[("id", "s"), ("equation", "s"), ("mean", "n0"), ("sigma", "n0"), ("unit", "s"), ("fired", "b")],
        );
    }
    assert!(residuals.iter().any(|residual| residual["fired"] == true));
    has(&diagnosis["fit"], &[("chi2_reduced", "n"), ("iterations", "n"), ("solves", "n"), ("stopped_because", "s")]);
    assert!(diagnosis["fit"]["chi2_reduced"].as_f64().is_some_and(|chi2| (0.8..1.2).contains(&chi2)));
}

#[test]
fn the_same_input_gives_the_same_bytes_and_the_exit_status_tells_on_request() {
    let again = borescope(["diagnose", RIG, LEAK, "--format", "json", "--exit-code"]);
    assert_eq!((again.status, again.err.as_str()), (Some(1), ""));
    assert!(again.out == leak().out, "two runs differ");
}

#[test]
fn a_bad_record_does_not_stop_the_good_one() {
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.csv");
    fs::write(&bad, "time [s],p_A [bar]\n0,1\n").unwrap();
    let bad = bad.to_str().unwrap();
    let good = folder.path().join("good.csv");
    let good = good.to_str().unwrap();
    assert_eq!(borescope(["simulate", RIG, "--seed", "1", "-o", good]).status, Some(0));
    let ran = borescope(["diagnose", RIG, bad, good, "--format", "json"]);
    assert_eq!(ran.status, Some(2));
    assert!(ran.err.starts_with("error: ") && ran.err.matches("error: ").count() == 1, "{}", ran.err);
    assert!(ran.err.contains(bad) && !ran.err.contains(good), "{}", ran.err);
    // A list, because two records were asked for; the good one is what it is alone.
    let alone = borescope(["diagnose", RIG, good, "--format", "json"]);
    assert_eq!(json(&ran.out), Value::Array(vec![json(&alone.out)]));
}

#[test]
fn two_records_give_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("healthy.csv");
    let path = path.to_str().unwrap();
    assert_eq!(borescope(["simulate", RIG, "--seed", "1", "-o", path]).status, Some(0));
    let ran = borescope(["diagnose", RIG, path, path, "--format", "json"]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    let both = json(&ran.out);
    let verdicts: Vec<&Value> = both.as_array().unwrap().iter().map(|one| &one["verdict"]).collect();
    assert_eq!(verdicts, ["healthy", "healthy"]);
    assert_eq!(both[0], both[1]);
    assert!(both[0]["detected_at_s"].is_null());
}

#[test]
fn what_is_not_called_a_fault_has_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let ran = borescope(["diagnose", RIG, LEAK, "--all", "--report", page.to_str().unwrap()]);
    let told = json(&leak().out);
    assert_eq!(told["verdict"], "faulty");
    let stopped = told["fit"]["stopped_because"].as_str().unwrap();
    assert!(stopped.starts_with("no other fault combination"), "{stopped}");
    let html = fs::read_to_string(&page).unwrap();
    let mut explained = 0;
    for fault in list(&told, "faults").iter().filter(|fault| fault["present"] == false) {
        let id = fault["id"].as_str().unwrap();
        let ends: Vec<Option<f64>> = list(fault, "ci95").iter().map(Value::as_f64).collect();
        let healthy = fault["healthy"].as_f64().unwrap();
        let off = ends[0].is_some_and(|low| healthy < low) || ends[1].is_some_and(|high| high < healthy);
        let why = format!("{id}: its interval reaches the tolerance of its healthy value");
        assert_eq!((ran.out.contains(&why), html.contains(&why)), (off, off), "{id} in {}", ran.out);
        explained += usize::from(off);
        let row = ran.out.lines().find(|line| line.split_whitespace().next() == Some(id)).unwrap();
        match ends.as_slice() {
            // Digits follow the width: two ends are never printed alike.
            [Some(_), Some(_)] => {
                let (low, high) = row.split_once(" to ").unwrap();
                assert_ne!(low.split_whitespace().last(), high.split_whitespace().next(), "{row}");
            }
            [None, Some(_)] => {
                let open = format!("\n  {id}: at most ");
                assert!(row.contains(" at most ") && ran.out.contains(&open), "{row}");
            }
            [Some(_), None] => assert!(row.contains(" at least "), "{row}"),
            _ => assert!(row.contains(" open "), "{row}"),
        }
    }
    assert!(explained > 0, "{}", ran.out);
}

fn entries(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn the_page_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let ran = borescope(["diagnose", RIG, HEALTHY, "--report", page.to_str().unwrap(), "--exit-code"]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    assert!(ran.out.starts_with("HEALTHY: "), "{}", ran.out);
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>\n"));
    // Measured and misfit of each sensor, a residual and its sum, the map, the circuit.
    let charts = |of: &str| html.matches(of).count();
    assert_eq!(
        (charts("data-name=\"misfit of "), charts("class=\"live map\""), charts("class=\"circuit\"")),
        (8, 1, 1)
    );
    assert!(charts("data-name=\"running sum of ") > 5);
    assert!(html.len() < 1_500_000, "{} bytes", html.len());
    assert_eq!(entries(folder.path()), ["page.html"]);

    let missing = folder.path().join("missing").join("page.html");
    let ran = borescope(["diagnose", RIG, HEALTHY, "--report", missing.to_str().unwrap()]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert!(ran.err.contains("there is no folder") && ran.err.contains("  help: "), "{}", ran.err);
    assert_eq!(entries(folder.path()), ["page.html"]);

    let ran = borescope(["diagnose", RIG, HEALTHY, LEAK, "--report", page.to_str().unwrap()]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert!(ran.err.contains("one file per record"), "{}", ran.err);
}

#[test]
fn a_record_that_does_not_fit_the_rig_is_refused_with_both_places() {
    let right = fs::read_to_string(HEALTHY).unwrap();
    let line = |name: &str| {
        let rig = fs::read_to_string(RIG).unwrap();
        1 + rig.lines().position(|line| line.starts_with(name)).unwrap()
    };
    let cases = [
        (
            right.replacen("p_A [bar]", "p_a [bar]", 1),
            format!(
                "error: {RIG}:{} and RECORD:1: the record has no column `p_A`\n  help: did you mean `p_a`?",
                line("p_A")
            ),
        ),
        (
            right.replacen("q_A [L/min]", "q_A [mm]", 1),
            format!("error: {RIG}:{} and RECORD:1: column `q_A`: `mm` is a unit of length, not of ", line("q_A")),
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    for (record, message) in cases {
        fs::write(&path, record).unwrap();
        let ran = borescope(["diagnose", RIG, path.to_str().unwrap()]);
        let err = ran.err.replace(path.to_str().unwrap(), "RECORD");
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{err}");
        assert!(err.starts_with(&message), "{err}");
        assert_eq!(err.matches("error: ").count(), 1, "{err}");
    }
}

/// A record whose column is changed by `change(field)`.
fn with_column(name: &str, change: impl Fn(&str) -> String) -> String {
    let right = fs::read_to_string(HEALTHY).unwrap();
    let column = right.lines().next().unwrap().split(',').position(|head| head == name).unwrap();
    let changed = |(number, line): (usize, &str)| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if number > 0 {
            fields[column] = change(&fields[column]);
        }
        fields.join(",") + "\n"
    };
    right.lines().enumerate().map(changed).collect()
}

fn diagnosed(record: &str, format: &str) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    fs::write(&path, record).unwrap();
    borescope(["diagnose", RIG, path.to_str().unwrap(), "--all", "--format", format])
}

/// Nothing is blamed for a sensor that is dead: the record says nothing of its own faults.
#[test]
fn a_dead_sensor_is_left_out() {
    let ran = diagnosed(&with_column("q_A [L/min]", |_| "0.000".to_owned()), "json");
    let found = json(&ran.out);
    assert_eq!(found["verdict"], "healthy", "{found}");
    let left_out = list(&found, "left_out");
    assert_eq!((left_out.len(), &left_out[0]["doubt"]), (1, &Value::from("dead")));
    let q_a = list(&found, "channels").iter().find(|channel| channel["name"] == "q_A").unwrap();
    assert_eq!(q_a["samples"], 0);
    assert!(ran.err.contains("`q_A` "), "{}", ran.err);
}

/// The same of one that lacks every value.
#[test]
fn a_sensor_without_values_is_left_out() {
    let ran = diagnosed(&with_column("q_A [L/min]", |_| String::new()), "text");
    assert!(ran.out.starts_with("HEALTHY"), "{}", ran.out);
    let undetermined = "\nThe record does not determine sensor.q_A.offset, sensor.q_A.gain.\n";
    assert!(ran.out.contains(undetermined), "{}", ran.out);
    assert!(ran.out.lines().any(|line| line.starts_with("  q_A ") && line.ends_with("no samples")), "{}", ran.out);
    assert!(ran.err.contains("`q_A` "), "{}", ran.err);
}

/// Megapascals in a column of bar.
#[test]
fn a_column_in_another_unit_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    fs::write(&path, with_column("p_A [bar]", |field| format!("{:.3}", field.parse::<f64>().unwrap() / 10.0))).unwrap();
    let rig = borescope::Rig::read(RIG).unwrap();
    let found = rig.model().diagnose(&rig.record(&path).unwrap()).unwrap();
    assert_eq!(found.verdict, borescope::Verdict::ModelInadequate);
    for channel in &found.channels {
        let ratio = channel.ratio_to_healthy;
        let p_a = channel.name == "p_A";
        assert!(if p_a { (ratio.unwrap() - 0.1).abs() < 0.002 } else { ratio.is_none() }, "{channel:?}");
    }
    let ratio = found.channels.iter().find_map(|channel| channel.ratio_to_healthy).unwrap();
    let told = format!("\np_A reads {ratio} times what the healthy model says: is its column in bar?\n");
    assert!(found.to_string().contains(&told), "{found}");
}

/// A chamber that starts at its first reading cannot be started by a sensor that is dead.
#[test]
fn a_start_that_nothing_shows_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (rig, record) = (path("rig.toml"), path("record.csv"));
    let tanks = "fixtures/two_tanks/rig.toml";
    assert_eq!(borescope(["simulate", tanks, "--seed", "1", "-o", &record]).status, Some(0));
    let dead: String = fs::read_to_string(&record)
        .unwrap()
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((rest, last)) if last.parse::<f64>().is_ok() => format!("{rest},0.0\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    fs::write(&record, dead).unwrap();
    let text = fs::read_to_string(tanks).unwrap();
    let line = text.lines().find(|line| line.starts_with("lower = ")).unwrap();
    fs::write(&rig, text.replace(line, "lower = {}")).unwrap();
    let ran = borescope(["diagnose", &rig, &record]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert!(ran.err.contains("rig.toml:14 and "), "{}", ran.err);
    assert!(ran.err.contains("nothing shows where node `lower` starts: its sensor is dead"), "{}", ran.err);
    // What the file says of the start is enough.
    assert_eq!(borescope(["diagnose", tanks, &record]).status, Some(0));
}

/// What a record and its rig file say differently is told before anything is computed.
#[test]
fn a_record_at_odds_with_its_rig_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let warned = |record: &str| {
        fs::write(&path, record).unwrap();
        let ran = borescope(["check", RIG, path.to_str().unwrap()]);
        let (_, told) = ran.out.split_once("\nwarnings: ").unwrap();
        told.split_once("\n`--all`").unwrap().0.to_owned()
    };
    let right = fs::read_to_string(HEALTHY).unwrap();
    assert_eq!(warned(&right), "0\n");
    let later: String = right
        .lines()
        .enumerate()
        .filter(|(row, _)| *row == 0 || *row > 600)
        .fold(String::new(), |text, (_, line)| text + line + "\n");
    let told = warned(&later);
    assert!(
        told.contains("`x` begins at 1") && told.contains(" mm, where the rig file starts `piston` at 0 mm: write"),
        "{told}"
    );
    let percent = with_column("valve_command [-]", |field| format!("{}", 100.0 * field.parse::<f64>().unwrap()));
    assert!(warned(&percent).contains("`valve_command` runs from -100 to 100, a command from -1 to 1: "));
    let milliseconds = with_column("time [s]", |field| format!("{:.1}", 1000.0 * field.parse::<f64>().unwrap()));
    assert!(warned(&milliseconds).contains("one row every 4 s, 1000 times the interval of the rig file's cycle"));
    // As many samples as a fit has to choose from; two rows more are no longer all met.
    let rows =
        |count: usize| warned(&right.lines().take(1 + count).fold(String::new(), |text, line| text + line + "\n"));
    assert!(rows(2).contains("2 rows give ") && rows(2).contains("says little of so few"), "{}", rows(2));
    assert!(!rows(200).contains("says little of so few"));
    rows(2);
    let ran = borescope(["compare", RIG, path.to_str().unwrap()]);
    assert!(ran.status == Some(0) && ran.err.contains(": 2 rows give "), "{}{}", ran.out, ran.err);
}
