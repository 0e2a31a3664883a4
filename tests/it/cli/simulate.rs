//! `simulate` and what surrounds every verb: records, noise, settings, exit status, JSON, closed pipes.

use crate::support::command;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use borescope::Record;
use borescope::Rig;
use command::borescope;
use serde_json::Value;

const RIGS: [&str; 3] = ["fixtures/telescopic/rig.toml", "fixtures/two_tanks/rig.toml", "fixtures/press/rig.toml"];

/// Simulates into a file of this folder, which must succeed.
fn simulate(folder: &Path, name: &str, arguments: &[&str]) -> Record {
    let path = folder.join(name);
    let ran = borescope(["simulate", "--force", "-o", path.to_str().unwrap()].iter().chain(arguments));
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""), "{arguments:?}");
    Record::read(&path).unwrap()
}

#[test]
fn a_simulated_record_fed_back_gives_itself() {
    let folder = tempfile::tempdir().unwrap();
    for path in RIGS {
        let rig = Rig::read(path).unwrap();
        let first = simulate(folder.path(), "first.csv", &[path]);
        let input = folder.path().join("first.csv");
        let second = simulate(folder.path(), "second.csv", &[path, "--input", input.to_str().unwrap()]);
        assert_eq!(first.time, second.time);
        for input in &rig.inputs {
            assert_eq!(first.channel(&input.column), second.channel(&input.column));
        }
        let (mut within, mut all) = (0, 0);
        for sensor in &rig.sensors {
            let (one, other) = (first.channel(&sensor.column).unwrap(), second.channel(&sensor.column).unwrap());
            let worst = one.values.iter().zip(&other.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("{} {}: {:.1e} of its resolution at worst", rig.name, sensor.name, worst / sensor.resolution);
            within += one.values.iter().zip(&other.values).filter(|(a, b)| (*a - *b).abs() < sensor.resolution).count();
            all += one.values.len();
        }
        // A ramp of the force comes back as steps of one row, so a few samples behind its ends differ by more.
        assert!(within as f64 > 0.99 * all as f64, "{path}: {within} of {all} within the resolution");
        let checked = borescope(["check", path, input.to_str().unwrap()]);
        assert_eq!((checked.status, checked.err.as_str()), (Some(0), ""));
        assert!(checked.out.contains("warnings: 0"), "{}", checked.out);
    }
}

/// A load that pulls, and no valve through which oil is sucked in.
#[test]
fn a_pressure_below_vacuum_is_warned_of_although_no_sensor_shows_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let text = fs::read_to_string(RIGS[0]).unwrap();
    let pulled = text.replace("\"5400 N\"", "\"-9000 N\"").replace("\"0.3 bar\"", "\"60 bar\"");
    let sensors: Vec<&str> =
        pulled.lines().filter(|line| !line.starts_with("p_A = ") && !line.contains("sensor.p_A.")).collect();
    fs::write(path("rig.toml"), sensors.join("\n")).unwrap();
    let ran = borescope(["simulate", &path("rig.toml"), "-o", &path("record.csv"), "--format", "json"]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    assert!(
        ran.err.starts_with("warning: the pressure of node `A` falls to -") && ran.err.contains(" s, below vacuum"),
        "{}",
        ran.err
    );
    let below = &serde_json::from_str::<Value>(&ran.out).unwrap()["below_vacuum"];
    assert!(below["pressure_bar"].as_f64().unwrap() < -1.013 && below["node"] == "A", "{below}");
}

#[test]
fn noise_has_its_size_and_comes_back_with_its_seed() {
    let folder = tempfile::tempdir().unwrap();
    let rig = Rig::read(RIGS[0]).unwrap();
    let exact = simulate(folder.path(), "exact.csv", &[RIGS[0]]);
    let noisy = simulate(folder.path(), "noisy.csv", &[RIGS[0], "--seed", "7"]);
    simulate(folder.path(), "again.csv", &[RIGS[0], "--seed", "7"]);
    simulate(folder.path(), "other.csv", &[RIGS[0], "--seed", "8"]);
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(text("noisy.csv"), text("again.csv"));
    assert_ne!(text("noisy.csv"), text("other.csv"));
    let columns = rig.sensors.iter().map(|sensor| (&sensor.column, sensor.noise, sensor.resolution));
    let inputs = rig.inputs.iter().map(|input| (&input.column, input.noise, 0.0));
    for (column, noise, resolution) in columns.chain(inputs) {
        let (one, other) = (exact.channel(column).unwrap(), noisy.channel(column).unwrap());
        let square = |(a, b): (&f64, &f64)| (a - b) * (a - b);
        let sigma = (one.values.iter().zip(&other.values).map(square).sum::<f64>() / one.values.len() as f64).sqrt();
        let expected = (noise * noise + resolution * resolution / 12.0).sqrt();
        println!("{column}: {sigma:.4e}, expected {expected:.4e}");
        // Five standard errors of a standard deviation from 1875 samples.
        assert!((sigma - expected).abs() <= 0.082 * expected, "{column}");
        if resolution > 0.0 {
            assert!(other.values.iter().all(|value| (value / resolution - (value / resolution).round()).abs() < 1e-6));
        }
    }
    assert_eq!(noisy.channel("p_A").unwrap().decimals, Some(2));
    assert_eq!(noisy.channel("x").unwrap().unit.symbol, "mm");
}

#[test]
fn settings_reach_the_circuit_and_wrong_ones_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let healthy = simulate(folder.path(), "healthy.csv", &[RIGS[0]]);
    let faulty = ["--set", "cylinder.clearance=200 um", "--set", "directional_valve.opening=0.9"];
    let leaky = simulate(folder.path(), "leaky.csv", &[&[RIGS[0]][..], &faulty[..]].concat());
    // 2 s into the outstroke leakage has cost some way.
    let x = |record: &Record| record.channel("x").unwrap().values[624];
    assert!(x(&leaky) < 0.95 * x(&healthy), "{} {}", x(&leaky), x(&healthy));
    for (set, message) in [
        (
            "cylinder.clearanc=0.2mm",
            "error: fixtures/telescopic/rig.toml: `--set cylinder.clearanc=0.2mm`: the rig has no parameter \
             `cylinder.clearanc`\n  help: did you mean `cylinder.clearance`?\n",
        ),
        (
            "cylinder.clearance=0.2",
            "error: `--set cylinder.clearance=0.2`: `0.2` has no unit, but needs one of length\n  help: write for example \
             `0.2 mm`; units of length: `mm`, `um`, `cm`, `m`, `km`, `mm2/mm`\n",
        ),
        (
            "cylinder.clearance=0.2bar",
            "error: `--set cylinder.clearance=0.2bar`: `bar` is a unit of pressure, not of length\n  help: units of \
             length: `mm`, `um`, `cm`, `m`, `km`, `mm2/mm`\n",
        ),
        (
            "directional_valve.opening=7",
            "error: fixtures/telescopic/rig.toml:63: `--set directional_valve.opening=7`: 7 is outside the physical \
             bounds\n  help: opening coefficient common to all paths: from 0 to 1.5\n",
        ),
        (
            "cylinder.clearance",
            "error: `--set cylinder.clearance`: there is no `=`\n  help: write PARAMETER=VALUE, such as `--set \
             cylinder.clearance=0.2mm`\n",
        ),
        (
            "pump_line.volume=0cm3",
            "error: fixtures/telescopic/rig.toml:16: with `--set pump_line.volume=0cm3` node `pump_line` has neither volume \
             nor mass\n  help: set values above 0\n",
        ),
        (
            "relief.lag=0s",
            "error: fixtures/telescopic/rig.toml:43: `--set relief.lag=0s`: 0 s is outside the physical bounds\n  help: time \
             constant of the opening: above 0\n",
        ),
    ] {
        let output = folder.path().join("wrong.csv");
        let ran = borescope(["simulate", RIGS[0], "--set", set, "-o", output.to_str().unwrap()]);
        assert_eq!((ran.status, ran.out.as_str(), message_of(&ran.err).as_str()), (Some(2), "", message));
        assert!(!output.exists());
    }
}

/// What is wrong and what would be right, without the line of the file.
fn message_of(told: &str) -> String {
    told.split_inclusive('\n').take(2).collect()
}

#[test]
fn a_rig_without_cycle_needs_a_record_and_one_without_start_too() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    let output = folder.path().join("record.csv");
    let right = fs::read_to_string(RIGS[1]).unwrap();
    let told = |text: &str| {
        fs::write(&rig, text).unwrap();
        let ran = borescope(["simulate", rig.to_str().unwrap(), "-o", output.to_str().unwrap()]);
        assert_eq!((ran.status, ran.out.as_str(), output.exists()), (Some(2), "", false));
        message_of(&ran.err).replace(rig.to_str().unwrap(), "RIG")
    };
    assert_eq!(
        told(right.split_once("[cycle]").unwrap().0),
        "error: RIG: the rig file has no `[cycle]` to simulate\n  help: add `[cycle]` with `interval` and `phases`, or give \
         commands and loads with `--input RECORD`\n"
    );
    let startless = right.replace("lower = { initial = \"0 bar\" }", "lower = {}");
    let both = told(&startless.replace("upper = { initial = \"0 bar\" }", "upper = {}"));
    assert!(both.contains("nodes `upper`, `lower` start at what their sensors show first"), "{both}");
    assert_eq!(
        told(&startless),
        "error: RIG:14: node `lower` starts at what its sensor shows first, but there is no record\n  help: add the pressure that it starts with, such as `initial = \"5 bar\"`, or give `--input RECORD`\n"
    );
    // From a record the lower tank starts at its first level.
    fs::write(folder.path().join("in.csv"), "time [s],u [V],level_2 [mm]\n0,1,150\n1,1,150\n2,1,150\n").unwrap();
    let input = folder.path().join("in.csv");
    let from = [rig.to_str().unwrap(), "--input", input.to_str().unwrap()];
    let level = simulate(folder.path(), "level.csv", &from).channel("level_2").unwrap().values[0];
    assert!((level - 0.150).abs() < 1e-9, "{level}");
}

#[test]
fn json_is_one_object_with_its_schema() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("record.csv");
    let output = output.to_str().unwrap();
    let ran = borescope([
        "simulate",
        RIGS[2],
        "--set",
        "meter_out.opening=0.5",
        "--seed",
        "1",
        "-o",
        output,
        "--format",
        "json",
    ]);
    let summary: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(summary["schema"], "borescope.simulation/1");
    assert_eq!(summary["set"][0]["id"], "meter_out.opening");
    assert_eq!(summary["set"][0]["value"], 0.5);
    let ran = borescope(["check", RIGS[2], output, "--format", "json"]);
    let page: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(page["schema"], "borescope.check/1");
    assert_eq!(page["rig"]["states"].as_array().unwrap().len(), 9);
    assert_eq!(page["record"]["rows"], summary["rows"]);
    let ids: Vec<_> =
        page["rig"]["faults"].as_array().unwrap().iter().map(|fault| fault["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["meter_out.opening", "cylinder.clearance", "relief.set_pressure"]);
}

#[test]
fn usage_errors_are_2_and_help_is_0() {
    for arguments in
        [vec![], vec!["chek"], vec!["check"], vec!["simulate", RIGS[0]], vec!["check", RIGS[0], "--format", "xml"]]
    {
        let ran = borescope(&arguments);
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(!ran.err.is_empty() && !ran.err.contains('\u{1b}'));
    }
    for arguments in [vec!["--help"], vec!["check", "--help"], vec!["--version"]] {
        let ran = borescope(&arguments);
        assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""), "{arguments:?}");
    }
}

#[test]
fn a_closed_pipe_is_no_failure() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_borescope"))
        .args(["check", RIGS[0]])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), String::from_utf8(output.stderr).unwrap().as_str()), (Some(0), ""));
}

#[test]
fn a_record_into_a_folder_that_is_not_there_is_told() {
    let ran = borescope(["simulate", RIGS[1], "-o", "nowhere/record.csv"]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert!(ran.err.starts_with("error: nowhere/record.csv: there is no folder"), "{}", ran.err);
}
