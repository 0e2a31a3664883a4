//! `compare`, `suggest` and `effects` as programs see them: JSON, exit status, what they say of known records.

use crate::support::command;
use crate::support::leaking;

use command::borescope;
use leaking::leaking;
use serde_json::Value;

const RIG: &str = "fixtures/telescopic/rig.toml";
const HEALTHY: &str = "fixtures/telescopic/healthy_1.csv";
const OPENING: &str = "fixtures/telescopic/opening_040.csv";
const PHASES: [&str; 5] = ["extend", "retract", "hold", "switch", "last 20 mm"];

fn json(arguments: &[&str], status: i32) -> Value {
    let ran = borescope(arguments.iter().chain(&["--format", "json"]));
    assert_eq!((ran.status, ran.err.as_str()), (Some(status), ""), "{arguments:?}");
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error} in {}", ran.out))
}

fn list<'a>(object: &'a Value, key: &str) -> &'a [Value] {
    object[key].as_array().unwrap_or_else(|| panic!("`{key}` is no list in {object}"))
}

/// A key and what its value must be.
type Key<'a> = (&'a str, fn(&Value) -> bool);

/// An object has all of these keys, with values that fit.
fn has(object: &Value, keys: &[Key<'_>]) {
    for (key, fits) in keys {
        let value = object.get(*key).unwrap_or_else(|| panic!("`{key}` is missing in {object}"));
        assert!(fits(value), "`{key}` is {value}");
    }
}

#[test]
fn a_healthy_record_is_explained() {
    let comparison = json(&["compare", RIG, HEALTHY, "--exit-code"], 0);
    assert_eq!(comparison["schema"], "borescope.comparison/1");
    assert_eq!((&comparison["adequate"], &comparison["where"]), (&Value::Bool(true), &Value::Null));
    assert!(comparison["chi2_reduced"].as_f64().is_some_and(|chi2| (0.7..1.3).contains(&chi2)));
    let channels = list(&comparison, "channels");
    assert_eq!(channels.len(), 8);
    for channel in channels {
        assert_eq!(channel["adequate"], true, "{channel}");
        assert!(channel["fit_percent"].as_f64().is_some_and(|fit| fit > 95.0), "{channel}");
        assert!(channel["autocorrelation"].as_f64().is_some_and(|r| r.abs() < 0.1), "{channel}");
    }
}

#[test]
fn a_misfit_is_found_with_its_phase() {
    let comparison = json(&["compare", RIG, OPENING, "--exit-code"], 1);
    assert_eq!(comparison["adequate"], false);
    has(
        &comparison["where"],
        &[("equation", Value::is_string), ("phase", Value::is_string), ("depends_on", Value::is_array)],
    );
    for channel in list(&comparison, "channels") {
        has(
            channel,
            &[
                ("name", Value::is_string),
                ("unit", Value::is_string),
                ("rmse", Value::is_number),
                ("noise_sigma", Value::is_number),
                ("fit_percent", Value::is_number),
                ("chi2_reduced", Value::is_number),
                ("adequate", Value::is_boolean),
                ("worst", Value::is_array),
            ],
        );
        assert!(!list(channel, "worst").is_empty());
        for miss in list(channel, "worst") {
            has(miss, &[("from_s", Value::is_number), ("to_s", Value::is_number), ("rmse", Value::is_number)]);
            assert!(miss["from_s"].as_f64() < miss["to_s"].as_f64(), "{miss}");
            assert!(PHASES.iter().any(|phase| miss["phase"] == *phase), "{miss}");
        }
    }
    // The fault that explains the record closes the loop.
    let with_faults = &comparison["with_faults"];
    let ids: Vec<&Value> = list(with_faults, "faults").iter().map(|fault| &fault["id"]).collect();
    assert_eq!(ids, ["directional_valve.opening"]);
    let (alone, explained) = (comparison["times_noise"].as_f64(), with_faults["times_noise"].as_f64());
    assert!(alone > Some(10.0) && explained < Some(3.0), "{alone:?} {explained:?}");
}

/// What a table of curves says of a sensor.
fn rms_over_sigma(table: &str, sensor: &str, curve: &str) -> f64 {
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let heads = rows.headers().unwrap().clone();
    let place = |column: &str| {
        let name = format!("{sensor}.{column} [");
        heads.iter().position(|head| head.starts_with(&name)).unwrap_or_else(|| panic!("no {name} in {heads:?}"))
    };
    let (measured, model, sigma) = (place("measured"), place(curve), place("sigma"));
    let squares: Vec<f64> = rows
        .records()
        .map(|row| {
            let row = row.unwrap();
            let number = |column: usize| row[column].parse::<f64>().unwrap();
            ((number(measured) - number(model)) / number(sigma)).powi(2)
        })
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// The same over all sensors, each with as many samples.
fn rms_of_all(table: &str, curve: &str) -> f64 {
    let sensors: Vec<&str> = table
        .lines()
        .next()
        .unwrap()
        .split(',')
        .filter_map(|head| head.split_once(".sigma"))
        .map(|(name, _)| name)
        .collect();
    let squares: f64 = sensors.iter().map(|sensor| rms_over_sigma(table, sensor, curve).powi(2)).sum();
    (squares / sensors.len() as f64).sqrt()
}

#[test]
fn old_and_new_stand_side_by_side_and_curves_hold_what_was_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    // A model whose throttle is too small misses what the true one explains.
    let rig = std::fs::read_to_string("fixtures/two_tanks/rig.toml").unwrap();
    let mut lines: Vec<String> = rig.lines().map(str::to_owned).collect();
    std::fs::write(path("new.toml"), &rig).unwrap();
    let outlet = lines.iter().rposition(|line| line == "diameter = \"8 mm\"").unwrap();
    lines[outlet] = "diameter = \"7.6 mm\"".to_owned();
    std::fs::write(path("old.toml"), lines.join("\n")).unwrap();
    assert_eq!(borescope(["simulate", &path("new.toml"), "--seed", "3", "-o", &path("record.csv")]).status, Some(0));
    let [new, old, record, curves] = ["new.toml", "old.toml", "record.csv", "curves.csv"].map(path);
    let command = ["compare", &new, &record, "--before", &old, "--curves", &curves];
    let comparison = json(&command, 0);
    assert_eq!(comparison["adequate"], true);
    let times = |value: &Value| value["times_noise"].as_f64().unwrap();
    assert!(times(&comparison) < 1.2 && times(&comparison["before"]) > 3.0, "{comparison}");
    let table = std::fs::read_to_string(&curves).unwrap();
    for channel in list(&comparison, "channels") {
        let name = channel["name"].as_str().unwrap();
        // Sigma has the rounding of the sensor in it, the noise alone has not.
        let told = times(channel);
        assert!((rms_over_sigma(&table, name, "model") / told - 1.0).abs() < 0.03, "{name}: {told}");
    }
    let text = borescope(["compare", &new, &record, "--before", &old]);
    assert!(text.out.starts_with("ADEQUATE: your model explains the record"), "{}", text.out);
    assert!(
        text.out.contains("Before (") && text.out.lines().all(|line| line.len() <= 80 || line.contains('/')),
        "{}",
        text.out
    );
}

#[test]
fn a_leak_that_the_model_lacks_is_suggested() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    leaking(folder.path());
    let (rig, fit, check, curves) = (path("rig.toml"), path("fit.csv"), path("check.csv"), path("curves.csv"));
    let arguments = ["suggest", &rig, &fit, "--check", &check, "--curves", &curves, "--exit-code"];
    let suggestion = json(&arguments, 1);
    assert_eq!(suggestion["schema"], "borescope.suggestion/1");
    assert_eq!(suggestion["conclusion"], "effect-found", "{suggestion}");
    assert_eq!(suggestion["where"]["equation"], "pressure balance of A");
    has(&suggestion["where"], &[("phase", Value::is_string), ("depends_on", Value::is_array)]);
    let best = &list(&suggestion, "candidates")[0];
    assert_eq!((&best["effect"], &best["supported"]), (&"external-leakage@A".into(), &true.into()));
    has(
        best,
        &[
            ("delta_bic", Value::is_number),
            ("parameters", Value::is_array),
            ("confounded_with", Value::is_array),
            ("warnings", Value::is_array),
        ],
    );
    for (before, after) in [("rmse_before", "rmse_after"), ("check_rmse_before", "check_rmse_after")] {
        assert!(best[after].as_f64().unwrap() < best[before].as_f64().unwrap(), "{best}");
    }
    let table = std::fs::read_to_string(&curves).unwrap();
    for (curve, told) in [("model", "rmse_before"), ("found", "rmse_after")] {
        let (rms, told) = (rms_of_all(&table, curve), best[told].as_f64().unwrap());
        assert!((rms / told - 1.0).abs() < 0.03, "{curve}: {rms}, {told}");
    }
    let improved = path("improved.csv");
    let new = path("new.toml");
    let improvement = json(&["improve", &rig, "--fit", &fit, "--check", &check, "-o", &new, "--curves", &improved], 0);
    assert_eq!(list(&improvement, "steps")[1]["added"], "external-leakage@A", "{improvement}");
    let improved = std::fs::read_to_string(&improved).unwrap();
    for (curve, step) in [("model", 0), ("found", list(&improvement, "steps").len() - 1)] {
        let (rms, told) =
            (rms_of_all(&improved, curve), list(&improvement, "steps")[step]["fit_rmse"].as_f64().unwrap());
        assert!((rms / told - 1.0).abs() < 0.03, "{curve}: {rms}, {told}");
    }
    let conductance = &list(best, "parameters")[0];
    assert_eq!(conductance["unit"], "L/min/bar");
    assert!(conductance["value"].as_f64().is_some_and(|value| (value - 0.01).abs() < 2e-4), "{conductance}");
    let ends = list(conductance, "ci95");
    assert!(ends[0].as_f64() < conductance["value"].as_f64() && conductance["value"].as_f64() < ends[1].as_f64());

    let others = list(&suggestion, "not_fitted");
    assert!(others.len() > 30);
    for other in others {
        has(other, &[("id", Value::is_string), ("unit", Value::is_string), ("excited", Value::is_boolean)]);
        assert!(other["smallest_detectable"].is_null() || other["smallest_detectable"].as_f64() > Some(0.0), "{other}");
        assert!(other["absorbed_by"].is_null() || other["absorbed_by"].is_string(), "{other}");
    }
    // The piston stays away from the ends.
    let cushion = others.iter().find(|other| other["id"] == "end-cushioning@cylinder").unwrap();
    assert_eq!((&cushion["excited"], &cushion["smallest_detectable"]), (&false.into(), &Value::Null));
}

#[test]
fn the_short_answers_fit_a_terminal_and_end_with_the_next_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    leaking(folder.path());
    let (rig, fit, check, new) = (path("rig.toml"), path("fit.csv"), path("check.csv"), path("new.toml"));
    let suggest = ["suggest", &rig, &fit, "--check", &check];
    let improve = ["improve", &rig, "--fit", &fit, "--check", &check, "-o", &new];
    let before = ["compare", &new, &check, "--before", &rig];
    for (call, verdict, next) in [
        (&suggest[..], "EFFECT FOUND: ", "Next: borescope add "),
        (&improve[..], "EFFECT FOUND: ", "Next: borescope compare "),
        (&before[..], "ADEQUATE: ", "Next: borescope diagnose "),
    ] {
        let ran = borescope(call);
        let lines: Vec<&str> = ran.out.lines().collect();
        let last = lines.iter().rposition(|line| line.starts_with("Next: ")).unwrap();
        assert!(lines[0].starts_with(verdict) && lines[last].starts_with(next), "{}", ran.out);
        // Of the command that is longer than a terminal is wide each line but the last says that it goes on.
        assert!(lines[last..lines.len() - 1].iter().all(|line| line.ends_with(" \\")), "{}", ran.out);
        let widest = lines.iter().map(|line| line.chars().count()).max().unwrap();
        assert!(widest <= 80, "{widest} columns: {}", ran.out);
        assert!(lines.len() <= 16, "{} lines: {}", lines.len(), ran.out);
    }
}

#[test]
fn the_library_is_listed_and_shows_its_cards() {
    let library = json(&["effects"], 0);
    assert_eq!(library["schema"], "borescope.effects/1");
    let all: Vec<_> = borescope::internals::report::effects::all().collect();
    assert_eq!(list(&library, "effects").len(), all.len());
    assert!(all.len() > borescope::internals::physics::effect::EFFECTS.len(), "none of the catalogue");
    let table = borescope(["effects"]);
    for effect in all {
        assert!(table.out.contains(effect.name), "{}", effect.name);
        let card = borescope(["effects", effect.name]);
        assert_eq!((card.status, card.err.as_str()), (Some(0), ""));
        // Lines are broken to the width of a terminal.
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let out = words(&card.out);
        assert!(out.contains(&words(effect.law)) && out.contains(&words(effect.source)), "{}", card.out);
    }
    assert_eq!(borescope(["effects", "seal-friction@cylinder"]).out, borescope(["effects", "seal-friction"]).out);
}

#[test]
fn an_unknown_effect_is_told_with_the_near_miss() {
    let ran = borescope(["effects", "seal-frction"]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert!(ran.err.contains("did you mean `seal-friction`?"), "{}", ran.err);
}
