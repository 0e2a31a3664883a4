//! What the verbs write as JSON keeps to the published schemas in `docs/schema`.

use crate::support::{command, page};

use std::fs;

use borescope::internals::schemas;
use command::borescope;
use serde_json::Value;

const RIG: &str = "fixtures/two_tanks/rig.toml";
const CYLINDER: &str = "fixtures/telescopic/rig.toml";
const LEAK: &str = "fixtures/telescopic/leak_020.csv";

/// What of a value goes against a schema. Of the vocabulary only what the schemas use: anything else is a mistake of the test.
fn wrong((root, schema): (&Value, &Value), value: &Value, at: &str, found: &mut Vec<String>) {
    for (key, rule) in schema.as_object().unwrap() {
        match key.as_str() {
            "$schema" | "title" | "description" | "$comment" | "$defs" => {}
            "$ref" => {
                let place = rule.as_str().unwrap().strip_prefix('#').unwrap();
                wrong((root, root.pointer(place).unwrap()), value, at, found);
            }
            "anyOf" | "oneOf" => {
                let one = |rule: &Value| {
                    let mut found = Vec::new();
                    wrong((root, rule), value, at, &mut found);
                    found
                };
                let all: Vec<Vec<String>> = rule.as_array().unwrap().iter().map(one).collect();
                if all.iter().all(|found| !found.is_empty()) {
                    found.extend(all.into_iter().min_by_key(Vec::len).unwrap());
                }
            }
            "minimum" => {
                if value.as_f64().is_some_and(|number| number < rule.as_f64().unwrap()) {
                    found.push(format!("{at} is {value}, below {rule}"));
                }
            }
            "minItems" | "maxItems" => {
                let (length, limit) = (value.as_array().map_or(0, Vec::len) as u64, rule.as_u64().unwrap());
                if value.is_array() && (if key == "minItems" { length < limit } else { length > limit }) {
                    found.push(format!("{at} has {length} items, {key} is {limit}"));
                }
            }
            "prefixItems" => {
                for (index, rule) in rule.as_array().unwrap().iter().enumerate() {
                    wrong((root, rule), &value[index], &format!("{at}[{index}]"), found);
                }
            }
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
                let is_whole = value.is_i64() || value.is_u64();
                let is_allowed = allowed.contains(&type_of(value)) || (is_whole && allowed.contains(&"integer"));
                if !is_allowed {
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
                        wrong((root, rule), inner, &format!("{at}.{key}"), found);
                    }
                }
            }
            "additionalProperties" if rule.is_boolean() => {}
            "additionalProperties" => {
                for (key, inner) in value.as_object().into_iter().flatten() {
                    wrong((root, rule), inner, &format!("{at}.{key}"), found);
                }
            }
            "items" => {
                for (index, inner) in value.as_array().into_iter().flatten().enumerate() {
                    wrong((root, rule), inner, &format!("{at}[{index}]"), found);
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
    let schema = schema_of(&result);
    wrong((&schema, &schema), &result, "result", &mut found);
    assert!(found.is_empty(), "{arguments:?}:\n{}", found.join("\n"));
    result["schema"].as_str().unwrap().to_owned()
}

/// Keys without a description, which tells their unit.
fn undescribed(schema: &Value, at: &str, found: &mut Vec<String>) {
    match schema {
        Value::Object(words) => {
            for (key, rule) in words.get("properties").and_then(Value::as_object).into_iter().flatten() {
                if rule.get("description").is_none() {
                    found.push(format!("{at}.{key}"));
                }
            }
            words.iter().for_each(|(key, inner)| undescribed(inner, &format!("{at}.{key}"), found));
        }
        Value::Array(all) => all.iter().for_each(|inner| undescribed(inner, at, found)),
        _ => {}
    }
}

/// `BLESS=1` writes them.
#[test]
fn published_schemas_are_those_of_the_types() {
    let mut wrong = Vec::new();
    for (name, schema) in schemas() {
        let path = format!("docs/schema/{}.json", name.replace('/', "-"));
        let now = serde_json::to_string_pretty(&schema).unwrap() + "\n";
        if page::blessed() {
            fs::write(&path, &now).unwrap();
        }
        if fs::read_to_string(&path).unwrap_or_default() != now {
            wrong.push(format!("{path} is stale (BLESS=1 writes it)"));
        }
        undescribed(&schema, &name, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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
