//! What the verbs write as JSON keeps to the published schemas in `docs/schema`.

use crate::support::command;

use std::fs;

use command::borescope;
use serde_json::Value;

const RIG: &str = "fixtures/two_tanks/rig.toml";
const CYLINDER: &str = "fixtures/telescopic/rig.toml";
const LEAK: &str = "fixtures/telescopic/leak_020.csv";

/// What of a value goes against a schema. Of the vocabulary only what the schemas use: anything else is a mistake of the test.
fn wrong(schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    for (key, rule) in schema.as_object().unwrap() {
        match key.as_str() {
            "$schema" | "title" | "description" | "$comment" => {}
            "const" if value != rule => found.push(format!("{at} is {value} instead of {rule}")),
            "enum" if !rule.as_array().unwrap().contains(value) => {
                found.push(format!("{at} is {value}, none of {rule}"))
            }
            "const" | "enum" => {}
            "type" => {
                let allowed: Vec<&str> = match rule {
                    Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
                    one => vec![one.as_str().unwrap()],
                };
                if !allowed.contains(&type_of(value)) {
                    found.push(format!("{at} is of type {}, none of {allowed:?}", type_of(value)));
                }
            }
            "required" => {
                for key in rule.as_array().unwrap().iter().filter_map(Value::as_str) {
                    if value.is_object() && value.get(key).is_none() {
                        found.push(format!("{at} lacks `{key}`"));
                    }
                }
            }
            "properties" => {
                for (key, rule) in rule.as_object().unwrap() {
                    if let Some(inner) = value.get(key) {
                        wrong(rule, inner, &format!("{at}.{key}"), found);
                    }
                }
            }
            "additionalProperties" => {
                for (key, inner) in value.as_object().into_iter().flatten() {
                    wrong(rule, inner, &format!("{at}.{key}"), found);
                }
            }
            "items" => {
                for (index, inner) in value.as_array().into_iter().flatten().enumerate() {
                    wrong(rule, inner, &format!("{at}[{index}]"), found);
                }
            }
            other => panic!("the word `{other}` is not known here"),
        }
    }
}

fn type_of(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    }
}

/// The schema of a result, by the name that it gives itself.
fn schema_of(result: &Value) -> Value {
    let name = result["schema"].as_str().unwrap().replace('/', "-");
    let path = format!("docs/schema/{name}.json");
    serde_json::from_str(&fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))).unwrap()
}

/// Runs a verb and gives the name of its schema.
fn check(arguments: &[&str]) -> String {
    let ran = borescope(arguments.iter().copied().chain(["--format", "json"]));
    assert_eq!(ran.status, Some(0), "{arguments:?}: {}", ran.err);
    let result: Value = serde_json::from_str(&ran.out).unwrap();
    let mut found = Vec::new();
    wrong(&schema_of(&result), &result, "result", &mut found);
    assert!(found.is_empty(), "{arguments:?}:\n{}", found.join("\n"));
    result["schema"].as_str().unwrap().to_owned()
}

#[test]
fn every_verb_keeps_to_its_schema() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (healthy, other, faulty, store) = (path("h.csv"), path("o.csv"), path("f.csv"), path("store.sqlite"));
    let list = path("list.csv");
    fs::write(&list, "record\nh.csv\nf.csv\n").unwrap();
    let mut names = vec![
        check(&["simulate", RIG, "--seed", "1", "-o", &healthy]),
        check(&["simulate", RIG, "--seed", "2", "-o", &other]),
        check(&["simulate", RIG, "--seed", "3", "--set", "upper_outlet.diameter=6mm", "-o", &faulty]),
        check(&["check", RIG]),
        check(&["check", RIG, &healthy]),
        check(&["effects"]),
        check(&["components"]),
        check(&["components", "catalogue:motor"]),
        check(&["diagnose", RIG, &healthy, "--store", &store]),
        check(&["diagnose", RIG, &other, "--store", &store]),
        check(&["diagnose", RIG, &faulty, "--store", &store]),
        check(&["diagnose", CYLINDER, LEAK, "--window", "10", "--fits", "1"]),
        check(&["history", RIG, "--store", &store, "--by", "run"]),
        check(&["compare", RIG, &faulty]),
        check(&["suggest", RIG, &faulty]),
        check(&["suggest", RIG, &faulty, "--check", &other]),
        check(&["improve", RIG, "--fit", &faulty, "--check", &faulty, "-o", &path("improved.toml")]),
        check(&["calibrate", RIG, &healthy, &other, "-o", &path("calibrated.toml")]),
        check(&["add", RIG, "external-leakage@lower", "-o", &path("leaking.toml")]),
        check(&["isolability", RIG]),
        check(&["campaign", RIG, "--cases", "2"]),
        check(&["campaign", RIG, "--cases", "2", "--case", "1"]),
        check(&["campaign", RIG, "--cases", "2", "--shard", "1/1", "-o", &path("shards")]),
        check(&["campaign", "--merge", &path("shards"), "-o", &path("merged")]),
        check(&["diagnose", RIG, "--records", &list, "-o", &path("rows")]),
        check(&["diagnose", "--merge", &path("rows"), "-o", &path("rows.csv")]),
        check(&["fleet", &store]),
    ];
    names.sort();
    names.dedup();
    let published: Vec<String> = fs::read_dir("docs/schema")
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".json"))
        .collect();
    assert_eq!(names.len(), published.len(), "{names:?} {published:?}");
}

/// A record with missing, stuck and leaping samples keeps to it too, and each is told.
#[test]
fn what_is_left_out_is_in_the_diagnosis() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let path = path.to_str().unwrap();
    assert_eq!(borescope(["simulate", RIG, "--seed", "5", "-o", path]).status, Some(0));
    let text = fs::read_to_string(path).unwrap();
    let column = text.lines().next().unwrap().split(',').position(|name| name.starts_with("level_2")).unwrap();
    let change = |(row, line): (usize, &str)| {
        let mut fields: Vec<&str> = line.split(',').collect();
        match row {
            100..=104 => fields[column] = "",
            300..=379 => fields[column] = "60",
            500 => fields[column] = "2000",
            _ => {}
        }
        fields.join(",")
    };
    assert!(text.lines().next().unwrap().contains("level_2 [mm]"));
    fs::write(path, text.lines().enumerate().map(|line| change(line) + "\n").collect::<String>()).unwrap();
    assert_eq!(check(&["diagnose", RIG, path]), "borescope.diagnosis/1");
    let ran = borescope(["diagnose", RIG, path, "--format", "json"]);
    let result: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(result["verdict"], "healthy", "{}", ran.out);
    let doubts: Vec<&str> =
        result["left_out"].as_array().unwrap().iter().map(|one| one["doubt"].as_str().unwrap()).collect();
    assert!(doubts.contains(&"dropout"), "{doubts:?}");
    assert!(ran.err.contains("`level_2` has no value in 5 of "), "{}", ran.err);
    // Without the rest, stuck and leaping samples would pull the level.
    assert!(doubts.contains(&"stuck") && doubts.contains(&"spike"), "{doubts:?}");
    let text = borescope(["diagnose", RIG, path, "--all"]);
    assert!(text.out.contains("\nLeft out of the fit\n"), "{}", text.out);
}
