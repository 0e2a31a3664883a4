//! Ctrl-C and SIGTERM end any verb soon, with 130, and leave nothing half-written.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const RIG: &str = "fixtures/telescopic/rig.toml";
const RECORD: &str = "fixtures/telescopic/leak_020.csv";
const HEALTHY: [&str; 2] = ["fixtures/telescopic/healthy_1.csv", "fixtures/telescopic/healthy_2.csv"];
/// How soon after the signal a verb has to be over.
const SOON: Duration = Duration::from_millis(200);
/// What the system takes beside: for `kill`, and to tell of the end.
const SYSTEM: Duration = Duration::from_millis(50);

fn start(arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_borescope"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().unwrap()
}

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// What a verb left that got a signal `after` its start, and how long it went on.
fn interrupted(arguments: &[&str], signal: &str, after: Duration) -> (Output, Duration) {
    let child = start(arguments);
    std::thread::sleep(after);
    let begin = Instant::now();
    send(signal, &child);
    let output = child.wait_with_output().unwrap();
    (output, begin.elapsed())
}

/// What stands in a folder.
fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// Interrupts a verb at several moments, and asserts that it ends as it should with nothing in `folder`.
fn ends_soon(arguments: &[&str], folder: &Path, signal: &str, moments: &[u64]) {
    for &after in moments {
        let (output, took) = interrupted(arguments, signal, Duration::from_millis(after));
        let told = format!("{arguments:?}, {signal} after {after} ms: {took:?}");
        assert_eq!(output.status.code(), Some(130), "{told}");
        // Before it may stand what the verb waits for, and what it has seen.
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.lines().last(), Some("interrupted"), "{told}");
        assert!(
            said.lines().rev().skip(1).all(|line| {
                line.starts_with("first look: ") || line.starts_with("note: ") && line.contains("waiting")
            }),
            "{told}: {said}"
        );
        assert!(output.stdout.is_empty(), "{told}");
        assert!(took < SOON + SYSTEM, "{told}");
        assert_eq!(names(folder), [""; 0], "{told}");
    }
}

#[test]
fn verbs_that_compute_end_soon_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (page, new) = (path("page.html"), path("new.toml"));
    ends_soon(&["diagnose", RIG, RECORD, "--report", &page], folder.path(), "-INT", &[300, 1000, 2000]);
    ends_soon(&["suggest", RIG, RECORD, "--report", &page], folder.path(), "-TERM", &[2000]);
    ends_soon(&["calibrate", RIG, HEALTHY[0], HEALTHY[1], "-o", &new], folder.path(), "-INT", &[1000]);
    ends_soon(&["campaign", RIG, "--cases", "50"], folder.path(), "-INT", &[1000]);
}

#[test]
fn a_verb_that_waits_for_a_pipe_ends_too() {
    let (fifos, empty) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let fifo = fifos.path().join("record.csv");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    ends_soon(&["check", RIG, fifo.to_str().unwrap()], empty.path(), "-INT", &[300]);
}

#[test]
fn a_second_signal_ends_a_verb_at_once() {
    let fifos = tempfile::tempdir().unwrap();
    let fifo = fifos.path().join("record.csv");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let child = start(&["check", RIG, fifo.to_str().unwrap()]);
    std::thread::sleep(Duration::from_millis(300));
    let begin = Instant::now();
    send("-INT", &child);
    // Two signals that are waiting are one.
    std::thread::sleep(Duration::from_millis(20));
    send("-INT", &child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(begin.elapsed() < Duration::from_millis(100), "{:?}", begin.elapsed());
}

#[test]
fn a_record_that_is_being_written_leaves_no_trace() {
    let folder = tempfile::tempdir().unwrap();
    let (rig, output) = (folder.path().join("rig.toml"), tempfile::tempdir().unwrap());
    // A cycle of so many rows that the writing alone takes seconds.
    let text = fs::read_to_string("fixtures/two_tanks/rig.toml").unwrap();
    let text = text.replace("interval = \"1 s\"", "interval = \"1 ms\"");
    fs::write(&rig, text).unwrap();
    let record = output.path().join("record.csv");
    let arguments = ["simulate", rig.to_str().unwrap(), "-o", record.to_str().unwrap()];
    let child = start(&arguments);
    let begin = Instant::now();
    // Until its temporary file is there.
    while names(output.path()).is_empty() && begin.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!names(output.path()).is_empty() && !record.exists(), "{:?}", begin.elapsed());
    send("-INT", &child);
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(130));
    assert_eq!(names(output.path()), [""; 0]);
}
