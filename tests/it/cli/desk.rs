//! The desk: its page is served to whoever has the address, and what it saves says the same on the command line.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use borescope::Rig;
use serde_json::{Value, json};

use crate::support::command::{Ending, borescope};

const FIXTURES: &str = "fixtures/telescopic";

/// A desk that runs, in a folder of its own.
struct Running {
    child: Ending,
    host: String,
    secret: String,
    folder: tempfile::TempDir,
}

impl Running {
    /// The telescopic rig beside these records.
    fn new(fit: &Path, check: &Path) -> Self {
        Self::of(FIXTURES, fit, check)
    }

    /// The rig of a folder beside these records.
    fn of(fixtures: &str, fit: &Path, check: &Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let rig = folder.path().join("rig.toml");
        fs::copy(Path::new(fixtures).join("rig.toml"), &rig).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_borescope"));
        command.arg("desk").arg(&rig).arg("--fit").arg(fit).arg("--check").arg(check).args(["--no-open", "--quiet"]);
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut address).unwrap();
        let (host, secret) = address.trim().strip_prefix("http://").unwrap().split_once('/').unwrap();
        let (host, secret) = (host.to_owned(), secret.trim_end_matches('/').to_owned());
        Self { child: Ending(child), host, secret, folder }
    }

    fn healthy() -> Self {
        let [fit, check] = ["healthy_1.csv", "healthy_3.csv"].map(|name| Path::new(FIXTURES).join(name));
        Self::new(&fit, &check)
    }

    /// Status, head and body of the answer to a request as it is.
    fn raw(&self, request: &str) -> (u16, String, String) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, head.to_owned(), body.to_owned())
    }

    fn get(&self, path: &str) -> (u16, String, String) {
        let Self { host, secret, .. } = self;
        self.raw(&format!("GET /{secret}/{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"))
    }

    fn posted(&self, (secret, host, origin, kind): (&str, &str, &str, &str), body: &str) -> (u16, String) {
        let length = body.len();
        let (status, _, body) = self.raw(&format!(
            "POST /{secret}/ask HTTP/1.1\r\nHost: {host}\r\n{origin}Content-Type: {kind}\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n{body}"
        ));
        (status, body)
    }

    fn ask(&self, message: &Value) -> (u16, Value) {
        let origin = format!("Origin: http://{}\r\n", self.host);
        let from = (self.secret.as_str(), self.host.as_str(), origin.as_str(), "application/json");
        let (status, body) = self.posted(from, &message.to_string());
        (status, serde_json::from_str(&body).unwrap_or(Value::String(body)))
    }

    fn state(&self) -> Value {
        serde_json::from_str(&self.get("state").2).unwrap()
    }

    /// Does long work to its end.
    fn work(&self, task: &str) -> Value {
        assert_eq!(self.ask(&json!({"ask": "begin", "task": task})).0, 200);
        let begin = Instant::now();
        loop {
            let state = self.state();
            if state["running"].is_null() {
                return state;
            }
            assert!(begin.elapsed() < Duration::from_secs(600), "{state}");
            self.get(&format!("state?since={}", state["revision"]));
        }
    }
}

fn window(from: f64, to: f64) -> Value {
    json!({"from": from, "to": to, "pixels": 800})
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|one| one.as_f64().unwrap()).collect()
}

#[test]
fn the_misfit_is_measured_minus_model_over_the_noise_at_every_sample_and_follows_a_slider() {
    let desk = Running::healthy();
    let rig = Rig::read(Path::new(FIXTURES).join("rig.toml")).unwrap();
    let noises: Vec<f64> = numbers(&json!(
        desk.state()["sensors"].as_array().unwrap().iter().map(|one| one["noise"].clone()).collect::<Vec<_>>()
    ));
    assert_eq!(noises.len(), rig.sensors.len());
    let asked = |change: Value| {
        let (status, drawn) = desk.ask(&change);
        assert_eq!(status, 200, "{drawn}");
        for (sensor, noise) in drawn["sensors"].as_array().unwrap().iter().zip(&noises) {
            let [measured, model, misfit] = ["measured", "model", "misfit"].map(|name| numbers(&sensor[name]));
            assert!(misfit.len() > 50);
            for ((measured, model), misfit) in measured.iter().zip(&model).zip(&misfit) {
                // The curves come with six digits.
                let digits = 1e-5 * (measured.abs() + model.abs()) / noise + 1e-5 * misfit.abs();
                assert!(((measured - model) / noise - misfit).abs() <= digits, "{measured} {model} {noise} {misfit}");
            }
        }
        drawn
    };
    let window = window(1.0, 2.0);
    let before = asked(json!({"ask": "curves", "window": window, "check": false}));
    let moved = json!({"ask": "change", "window": window, "check": false,
        "changes": [{"value": {"id": "cylinder.clearance", "value": 0.2}}]});
    let after = asked(moved);
    let all = |drawn: &Value| drawn["gauges"]["fit"]["all"].as_f64().unwrap();
    let ran =
        borescope(["compare", "fixtures/telescopic/rig.toml", "fixtures/telescopic/healthy_1.csv", "--format=json"]);
    let compared: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(before["gauges"]["fit"]["all"], compared["times_noise"]);
    assert!(all(&after) > 3.0 * all(&before), "{} {}", all(&before), all(&after));
    // A second tab sees what the first has done, and switching the fault off brings the model back.
    let card = |state: &Value| {
        let cards = state["cards"].as_array().unwrap().clone();
        cards.into_iter().find(|card| card["id"] == "cylinder.clearance").unwrap()
    };
    let seen = desk.state();
    assert_eq!(card(&seen)["on"], true);
    assert_eq!(card(&seen)["sliders"][0]["value"], 0.2);
    assert_eq!(seen["gauges"]["fit"], after["gauges"]["fit"]);
    // The record that is not drawn follows when somebody asks.
    assert!(before["gauges"]["check"].is_object());
    assert_eq!(after["gauges"]["check"], Value::Null);
    let check = |gauges: &Value| gauges["check"]["all"].as_f64().unwrap();
    assert!(check(&seen["gauges"]) > 3.0 * check(&before["gauges"]));
    let (_, other) = desk.ask(&json!({"ask": "change", "window": window, "check": true,
        "changes": [{"value": {"id": "cylinder.clearance", "value": 0.2}}]}));
    assert_eq!(other["gauges"], json!({"fit": null, "check": seen["gauges"]["check"]}));
    let off = asked(json!({"ask": "change", "window": window, "check": false,
        "changes": [{"switch": {"id": "cylinder.clearance", "on": false}}]}));
    assert_eq!(off["gauges"]["fit"], before["gauges"]["fit"]);
    assert_eq!(desk.state()["gauges"], before["gauges"]);
}

#[test]
fn more_samples_than_pixels_keep_the_least_and_the_largest() {
    let desk = Running::healthy();
    let curves = |pixels: usize| {
        let (status, drawn) = desk.ask(&json!({"ask": "curves", "check": false,
            "window": {"from": null, "to": null, "pixels": pixels}}));
        assert_eq!(status, 200, "{drawn}");
        drawn["sensors"].as_array().unwrap().clone()
    };
    let extremes = |sensor: &Value, name: &str| {
        let values = numbers(&sensor[name]);
        (values.iter().copied().fold(f64::INFINITY, f64::min), values.into_iter().fold(f64::NEG_INFINITY, f64::max))
    };
    for (thin, all) in curves(100).iter().zip(&curves(4000)) {
        assert!(thin["time"].as_array().unwrap().len() <= 200);
        for name in ["measured", "model", "misfit"] {
            assert_eq!(extremes(thin, name), extremes(all, name), "{name}");
        }
    }
}

#[test]
fn nobody_else_is_answered() {
    let desk = Running::healthy();
    let (host, secret) = (desk.host.as_str(), desk.secret.as_str());
    assert!(host.starts_with("127.0.0.1:") && secret.len() == 48, "{host} {secret}");
    let (status, head, page) = desk.get("");
    assert_eq!(status, 200);
    assert!(page.contains("Find what is missing"));
    for header in ["default-src 'none'", "nosniff", "no-referrer", "no-store", "frame-ancestors 'none'"] {
        assert!(head.contains(header), "{header}: {head}");
    }
    let get = |path: &str, host: &str, more: &str| {
        desk.raw(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}Connection: close\r\n\r\n")).0
    };
    let wrong = "0".repeat(48);
    let state = format!("/{secret}/state");
    assert_eq!(get("/", host, ""), 404);
    assert_eq!(get(&format!("/{wrong}/state"), host, ""), 404);
    assert_eq!(get(&format!("/{secret}/../rig.toml"), host, ""), 404);
    assert_eq!(get(&state, "evil.example", ""), 403);
    assert_eq!(get(&state, host, "Origin: http://evil.example\r\n"), 403);
    assert_eq!(get(&state, host, ""), 200);
    let stop = json!({"ask": "stop"}).to_string();
    let own = format!("Origin: http://{host}\r\n");
    let json = "application/json";
    assert_eq!(desk.posted((secret, host, "", json), &stop).0, 403);
    assert_eq!(desk.posted((secret, host, "Origin: null\r\n", json), &stop).0, 403);
    assert_eq!(desk.posted((secret, host, &own, "text/plain"), &stop).0, 415);
    assert_eq!(desk.posted((&wrong, host, &own, json), &stop).0, 404);
    assert_eq!(desk.posted((secret, host, &own, json), &" ".repeat(70_000)).0, 413);
    assert_eq!(desk.posted((secret, host, &own, json), "{}").0, 400);
    assert_eq!(desk.posted((secret, host, &own, json), &stop).0, 200);
}

#[test]
fn what_was_saved_gives_the_same_numbers_on_the_command_line() {
    let [fit, check] = ["line_fit.csv", "line_check.csv"].map(|name| Path::new("fixtures/learning").join(name));
    let desk = Running::new(&fit, &check);
    let folder = desk.folder.path();
    let input = fs::read_to_string(folder.join("rig.toml")).unwrap();
    let (status, said) = desk.ask(&json!({"ask": "add", "effect": "line-resistance@A"}));
    assert_eq!(status, 200, "{said}");
    let fitted = desk.work("fit");
    let stairs = fitted["staircase"].as_array().unwrap();
    let error = |step: &Value| step["fit"].as_f64().unwrap();
    assert!(stairs.len() == 3 && error(&stairs[2]) < 0.7 * error(&stairs[0]), "{stairs:?}");
    let card = &fitted["cards"][0];
    assert!(card["id"] == "line-resistance@A" && card["sliders"][0]["interval"].is_array(), "{card}");
    let judged = desk.work("judge")["judged"].clone();
    let save = |name: &str| desk.ask(&json!({"ask": "save", "name": name, "replace": false}));
    for bad in ["../out.toml", "/tmp/out.toml", "a/b.toml", "out.csv", ".toml", "rig.toml"] {
        assert_eq!(save(bad).0, 422, "{bad}");
    }
    assert_eq!(desk.ask(&json!({"ask": "save", "name": "rig.toml", "replace": true})).0, 422);
    fs::write(folder.join("there.toml"), "mine").unwrap();
    assert_eq!(save("there.toml").0, 422);
    assert_eq!(fs::read_to_string(folder.join("there.toml")).unwrap(), "mine");
    let (status, said) = save("better.toml");
    assert_eq!(status, 200, "{said}");
    assert_eq!(fs::read_to_string(folder.join("rig.toml")).unwrap(), input);
    let better = folder.join("better.toml");
    for (record, name) in [(&fit, "fit"), (&check, "check")] {
        let ran = borescope(["compare".as_ref(), better.as_os_str(), record.as_os_str(), "--format=json".as_ref()]);
        let compared: Value = serde_json::from_str(&ran.out).unwrap();
        for key in ["times_noise", "chi2_reduced", "channels", "fitted", "with_faults"] {
            assert_eq!(compared[key], judged[name][key], "{name} {key}");
        }
    }
    assert_eq!(desk.ask(&json!({"ask": "undo"})).0, 200);
    assert_eq!(desk.ask(&json!({"ask": "undo"})).0, 200);
    assert_eq!(desk.ask(&json!({"ask": "undo"})).0, 422);
    let before = desk.state();
    assert_eq!(before["staircase"].as_array().unwrap().len(), 1);
    assert_eq!(desk.ask(&json!({"ask": "text"})).1["said"], input);
}

#[test]
fn long_work_is_stopped_and_leaves_everything_as_it_was() {
    let [fit, check] = ["line_fit.csv", "line_check.csv"].map(|name| Path::new("fixtures/learning").join(name));
    let desk = Running::new(&fit, &check);
    let before = desk.state();
    assert_eq!(desk.ask(&json!({"ask": "begin", "task": "find"})).0, 200);
    assert_eq!(desk.ask(&json!({"ask": "begin", "task": "fit"})).0, 422);
    assert_eq!(desk.ask(&json!({"ask": "undo"})).0, 422);
    assert_eq!(desk.ask(&json!({"ask": "stop"})).0, 200);
    let begin = Instant::now();
    let mut state = desk.state();
    while !state["running"].is_null() {
        assert!(begin.elapsed() < Duration::from_secs(5), "{state}");
        desk.get(&format!("state?since={}", state["revision"]));
        state = desk.state();
    }
    assert!(state["note"]["text"].as_str().unwrap().contains("stopped"), "{}", state["note"]);
    for key in ["found", "cards", "gauges", "staircase"] {
        assert_eq!(state[key], before[key], "{key}");
    }
}

#[cfg(unix)]
#[test]
fn control_c_ends_it_at_once() {
    let mut desk = Running::healthy();
    let begin = Instant::now();
    assert!(Command::new("kill").args(["-INT", &desk.child.0.id().to_string()]).status().unwrap().success());
    assert_eq!(desk.child.0.wait().unwrap().code(), Some(130));
    assert!(begin.elapsed() < Duration::from_millis(250), "{:?}", begin.elapsed());
}

/// The page itself, driven as a user drives it. `DESK_PICTURES` names a folder for pictures of the way.
#[cfg(unix)]
mod in_a_browser;
