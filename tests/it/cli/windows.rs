//! `diagnose --window`: long records at constant memory, and the messages about them.

use crate::support::command;
use crate::support::long_record;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use command::borescope;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;

const RIG: &str = "fixtures/telescopic/rig.toml";
const LEAK: (&str, &str) = ("cylinder.clearance", "0.1 mm");

fn long(folder: &Path, cycles: [usize; 2]) -> PathBuf {
    let path = folder.join(format!("{}_{}.csv", cycles[0], cycles[1]));
    long_record::write(&path, RIG, cycles, LEAK);
    path
}

fn watched(path: &Path, more: &[&str]) -> Value {
    let path = path.to_str().unwrap();
    let ran = borescope(["diagnose", RIG, path, "--format", "json", "--window"].iter().chain(more));
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    serde_json::from_str(&ran.out).unwrap()
}

#[test]
fn a_leak_that_begins_in_the_middle_is_found_in_its_window_and_sized() {
    let folder = tempfile::tempdir().unwrap();
    // The leak begins at 45 s, in the middle of a window.
    let result = watched(&long(folder.path(), [6, 6]), &["30"]);
    assert_eq!(result["schema"], "borescope.windows/1");
    assert_eq!(result["conclusion"], "faulty");
    assert_eq!((&result["rows"], result["windows"].as_array().unwrap().len()), (&22500.into(), 3));
    let alarms: Vec<u64> =
        result["windows"].as_array().unwrap().iter().map(|one| one["alarms"].as_u64().unwrap()).collect();
    assert!(alarms[0] == 0 && alarms[1] > 0 && alarms[2] > 0, "{alarms:?}");
    let [episode] = &result["episodes"].as_array().unwrap()[..] else { panic!("{}", result["episodes"]) };
    let onset = episode["onset_s"].as_f64().unwrap();
    assert!((45.0..46.0).contains(&onset), "{onset}");
    // The window behind that of the first alarm is the first that has the leak throughout.
    let from = episode["diagnosed_s"][0].as_f64().unwrap();
    assert!((60.0..75.0).contains(&from), "{from}");
    let diagnosis = &episode["diagnosis"];
    assert_eq!((&diagnosis["schema"], &diagnosis["verdict"]), (&"borescope.diagnosis/1".into(), &"faulty".into()));
    let present: Vec<&Value> =
        diagnosis["faults"].as_array().unwrap().iter().filter(|fault| fault["present"] == true).collect();
    assert_eq!(present.iter().map(|fault| &fault["id"]).collect::<Vec<_>>(), ["cylinder.clearance"]);
    let [low, high] = [0, 1].map(|end| present[0]["ci95"][end].as_f64().unwrap());
    assert!(low < 0.1 && 0.1 < high && high - low < 0.002, "{low} to {high}");
}

#[test]
fn what_is_not_diagnosed_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = long(folder.path(), [2, 2]);
    let ran = borescope(["diagnose", RIG, path.to_str().unwrap(), "--window", "10", "--fits", "0", "--exit-code"]);
    assert_eq!(ran.status, Some(1), "{}", ran.err);
    assert!(
        ran.out.starts_with("NOT DIAGNOSED: residuals raised alarms in 1 episode; the cause is not known.\n"),
        "{}",
        ran.out
    );
    assert!(ran.out.contains("not diagnosed: `--fits 0` allows no more windows to be diagnosed\n"), "{}", ran.out);
    assert!(ran.out.contains("\n3 windows of 10 s: "), "{}", ran.out);
}

#[test]
fn a_healthy_record_is_healthy_in_every_window() {
    let folder = tempfile::tempdir().unwrap();
    let path = long(folder.path(), [8, 0]);
    let ran = borescope(["diagnose", RIG, path.to_str().unwrap(), "--window", "7.5", "--exit-code"]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    assert!(ran.out.starts_with("HEALTHY: no residual raised an alarm in any window.\n"), "{}", ran.out);
    assert!(ran.out.contains("\n8 windows of 7.5 s: 8 quiet, 0 with alarms\n"), "{}", ran.out);
}

/// Flow meters that may be far off see no leak; pressures and position do.
#[test]
fn what_no_residual_answers_to_shows_in_a_window_that_is_diagnosed_in_full() {
    let folder = tempfile::tempdir().unwrap();
    let path = long(folder.path(), [0, 3]);
    let text = fs::read_to_string(RIG).unwrap().replace("lag = \"2 ms\"", "lag = \"2 ms\", tolerance = \"5 L/min\"");
    let rig = folder.path().join("rig.toml");
    fs::write(&rig, text).unwrap();
    let [rig, path] = [&rig, &path].map(|path| path.to_str().unwrap());
    let ran = borescope(["diagnose", rig, path, "--window", "10", "--exit-code"]);
    assert_eq!(ran.status, Some(1), "{} {}", ran.out, ran.err);
    assert!(
        ran.out.starts_with("FAULTY: no residual raised an alarm, a window diagnosed in full does.\n"),
        "{}",
        ran.out
    );
    assert!(ran.out.contains("  FAULTY: cylinder.clearance 0."), "{}", ran.out);
    let none = borescope(["diagnose", rig, path, "--window", "10", "--fits", "0"]);
    assert!(none.out.starts_with("HEALTHY: no residual raised an alarm in any window.\n"), "{}", none.out);
}

#[test]
fn packed_records_and_standard_input_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = long(folder.path(), [2, 2]);
    let bytes = fs::read(&path).unwrap();
    let options = ["diagnose", RIG, "-", "--window", "10", "--fits", "0", "--format", "json"];
    let plain = watched(&path, &["10", "--fits", "0"]);
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(&bytes).unwrap();
    // Two members, one behind the other.
    let mut packed = gzip.finish().unwrap();
    let half = bytes.len() / 2;
    let mut members = GzEncoder::new(Vec::new(), Compression::fast());
    members.write_all(&bytes[..half]).unwrap();
    let mut members = members.finish().unwrap();
    let mut second = GzEncoder::new(Vec::new(), Compression::fast());
    second.write_all(&bytes[half..]).unwrap();
    members.extend(second.finish().unwrap());
    for (content, kind) in [(&bytes, ""), (&packed, ", packed with gzip"), (&members, ", packed with gzip")] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_borescope"))
            .args(options)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(content).unwrap();
        let out = child.wait_with_output().unwrap();
        let mut result: Value = serde_json::from_slice(&out.stdout).unwrap();
        let read_as = format!("CSV, columns between commas, decimal points{kind}");
        assert_eq!((&result["record"], &result["read_as"]), (&"-".into(), &read_as.into()));
        (result["record"], result["read_as"]) = (plain["record"].clone(), plain["read_as"].clone());
        assert_eq!(result, plain);
    }
    packed.truncate(packed.len() / 2);
    let broken = folder.path().join("broken.csv.gz");
    fs::write(&broken, packed).unwrap();
    let ran = borescope(["diagnose", RIG, broken.to_str().unwrap(), "--window", "10", "--fits", "0"]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert!(ran.err.contains("the file is packed with gzip, but cannot be unpacked: it ends too early"), "{}", ran.err);
}

/// The same message, with the same line, as of the record read whole; nothing is written before it.
#[test]
fn a_bad_row_far_down_is_told_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = long(folder.path(), [12, 0]);
    let text = fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let bad = folder.path().join("bad.csv");
    for (line, row) in [(20_000, "x,y"), (20_001, "0.5"), (19_999, "80,1,2,3,\"4\n"), (22_501, "90.000,0,1")] {
        let mut lines = lines.clone();
        lines[line - 1] = row;
        fs::write(&bad, lines.join("\n") + "\n").unwrap();
        let path = bad.to_str().unwrap();
        let whole = borescope(["diagnose", RIG, path]);
        let ran = borescope(["diagnose", RIG, path, "--window", "10"]);
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{row}");
        assert!(ran.err.contains(&format!("bad.csv:{line}")), "{}", ran.err);
        assert_eq!(ran.err, whole.err, "{row}");
    }
    // A byte that is no text, far down.
    let mut bytes = text.into_bytes();
    let at = bytes.len() - 100;
    bytes[at] = 0xE4;
    fs::write(&bad, &bytes).unwrap();
    let path = bad.to_str().unwrap();
    let ran = borescope(["diagnose", RIG, path, "--window", "10"]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert_eq!(ran.err, borescope(["diagnose", RIG, path]).err);
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let refused = |arguments: &[&str], wanted: &str| {
        let ran = borescope(["diagnose"].iter().chain(arguments));
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(ran.err.contains(wanted), "{}", ran.err);
    };
    let record = "fixtures/telescopic/healthy_1.csv";
    refused(&[RIG, record, "--window", "0"], "`--window 0` is no length of a window");
    refused(&[RIG, record, "--window", "nan"], "`--window NaN` is no length of a window");
    refused(&[RIG, record, "--fits", "2"], "--window");
    refused(&[RIG, record, "--window", "10", "--report", "page.html"], "--report");
    let matlab = "fixtures/formats/stroke_plain.mat";
    refused(&[RIG, matlab, "--window", "10"], "the file is MATLAB v5, which is not read piece by piece");
    let tanks = "fixtures/two_tanks/rig.toml";
    refused(&[tanks, record, "--window", "10"], "the sensors of this rig allow no residuals");
}

/// Most memory that a run held, kB.
#[cfg(target_os = "linux")]
fn peak(path: &Path, options: &[&str]) -> f64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_borescope"))
        .args(["diagnose", RIG, path.to_str().unwrap(), "--window"].iter().chain(options))
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0_f64;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let size = line.and_then(|line| line.trim().strip_suffix(" kB")?.trim().parse().ok());
        peak = peak.max(size.unwrap_or(0.0));
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert!(child.wait().unwrap().success());
    peak
}

#[test]
#[cfg(target_os = "linux")]
fn memory_does_not_grow_with_the_record() {
    let folder = tempfile::tempdir().unwrap();
    let [short, long] = [100, 400].map(|cycles| peak(&long(folder.path(), [cycles, 0]), &["7.5", "--fits", "0"]));
    println!("187,500 rows: {short} kB, 750,000 rows: {long} kB");
    // Ten columns of numbers, were the further rows kept; what an allocator holds on to while the machine is busy is a few megabytes.
    let kept = (750_000.0 - 187_500.0) * 10.0 * 8.0 / 1024.0;
    assert!(short > 1000.0 && long - short < 0.25 * kept, "{short} kB, then {long} kB, of {kept:.0} kB");
}

/// What takes minutes.
mod studies {
    use super::*;

    /// Eleven hours, for the page on speed.
    #[test]
    #[ignore = "minutes of computing, 700 MB of disk"]
    #[cfg(target_os = "linux")]
    fn ten_million_rows() {
        let folder = tempfile::tempdir().unwrap();
        let path = long(folder.path(), [2667, 2667]);
        let begin = std::time::Instant::now();
        let memory = peak(&path, &["60"]) / 1024.0;
        println!("{:.1} s, {memory:.0} MiB", begin.elapsed().as_secs_f64());
        assert!(memory < 500.0, "{memory} MiB");
    }
}
