//! The store through the program: a leak that grows over thirty records, processes at once, processes that are killed.

use crate::support::command;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use borescope::Record;
use borescope::internals::store::Store;
use command::borescope;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The two tanks with a leak out of the lower one, small records, and a limit.
fn leaking(folder: &Path) -> PathBuf {
    let text = fs::read_to_string("fixtures/two_tanks/rig.toml").unwrap();
    let (head, cycle) = text.split_once("# Three levels").unwrap();
    let text = head.replace(
        "[inputs.u]",
        "[components.leak]\nkind = \"restrictor\"\nports = { in = \"lower\", out = \"sump\" }\nrated_flow = \"10 L/min\"\n\
         rated_drop = \"20 mbar\"\nopening = 0.0\ntransition_pressure = \"0.5 mbar\"\n\n[inputs.u]",
    ) + "\"leak.opening\" = { healthy = 0.0, bounds = [0.0, 0.8], limit = 0.4 }\n\n# Three levels"
        + &cycle.replace("300 s", "60 s");
    let path = folder.join("rig.toml");
    fs::write(&path, text).unwrap();
    path
}

fn made(rig: &Path, opening: f64, seed: usize, record: &Path) {
    let set = format!("leak.opening={opening}");
    let seed = seed.to_string();
    let (rig, record) = (rig.to_str().unwrap(), record.to_str().unwrap());
    let ran = borescope(["simulate", rig, "--set", &set, "--seed", &seed, "--force", "-o", record]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
}

#[test]
fn a_growing_leak_over_thirty_records_is_shown_with_its_forecast() {
    let folder = tempfile::tempdir().unwrap();
    let rig = leaking(folder.path());
    let (store, record) = (folder.path().join("tanks.store"), folder.path().join("record.csv"));
    let (rig_text, store, record_text) = (rig.to_str().unwrap(), store.to_str().unwrap(), record.to_str().unwrap());
    for day in 1..=30_usize {
        made(&rig, 0.01 * day as f64, day, &record);
        let at = format!("2026-05-{day:02}T12:00:00Z");
        let ran = borescope(["diagnose", rig_text, record_text, "--store", store, "--at", &at]);
        assert_eq!(ran.status, Some(0), "{}", ran.err);
        let note = format!("as run {day}, measured 2026-05-{day:02} 12:00 UTC (stated with `--at`)");
        assert!(ran.err.contains(&note), "{}", ran.err);
    }
    let ran = borescope(["history", rig_text, "--store", store]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    println!("{}", ran.out);
    let ran = borescope(["history", rig_text, "--store", store, "--format", "json"]);
    let history: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(history["schema"], "borescope.history/1");
    let faults = history["faults"].as_array().unwrap();
    let fault = faults.iter().find(|fault| fault["id"] == "leak.opening").unwrap();
    assert_eq!(fault["values"].as_array().unwrap().len(), 30);
    let slope = |at: usize| fault["trend"]["ci95"][at].as_f64().unwrap();
    assert!(slope(0) < 0.01 && 0.01 < slope(1) && slope(1) - slope(0) < 0.002, "{}", fault["trend"]);
    assert_eq!(fault["forecast"]["state"], "will-pass");
    // 0.4 at 0.01 a day: noon of the ninth of June.
    let end = |at: usize| fault["forecast"]["ci95"][at].as_str().unwrap();
    assert!(end(0) < "2026-06-09T12" && "2026-06-09T12" < end(1), "{}", fault["forecast"]);
    assert!(end(0) > "2026-06-05" && end(1) < "2026-06-14", "{}", fault["forecast"]);
    let table = folder.path().join("table.csv");
    let ran = borescope(["export", "--store", store, "-o", table.to_str().unwrap()]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    assert_eq!(fs::read_to_string(&table).unwrap().lines().count(), 1 + 30 * faults.len());
    // Diagnosed again, the record keeps the time that was given to it.
    let ran = borescope(["diagnose", rig_text, record_text, "--store", store]);
    assert!(ran.err.contains("as run 31, measured 2026-05-30 12:00 UTC (as stated before"), "{}", ran.err);
}

#[test]
fn wrong_stores_and_times_give_their_message_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let rig = leaking(folder.path());
    let record = folder.path().join("record.csv");
    made(&rig, 0.1, 1, &record);
    let (rig, record, store) = (rig.to_str().unwrap(), record.to_str().unwrap(), folder.path().join("a.store"));
    let store = store.to_str().unwrap();
    for (arguments, message) in [
        (vec!["diagnose", rig, record, "--store", record], "RECORD: this file is read, and would be overwritten"),
        (vec!["diagnose", rig, record, "--store", "Cargo.toml"], "Cargo.toml: this is no store of diagnoses"),
        (vec!["diagnose", rig, record, "--at", "2026-05-01"], "`--at` without `--store`"),
        (vec!["diagnose", rig, record, "--store", store, "--at", "noon"], "`--at`: `noon` is no moment"),
        (
            vec!["diagnose", rig, record, record, "--store", store, "--at", "2026-05-01"],
            "`--at` with more than one record",
        ),
        (vec!["history", rig, "--store", store], "STORE: there is no such store"),
        (vec!["export", "--store", store, "-o", "table.csv"], "STORE: there is no such store"),
        (vec!["export", "--store", store, "-o", "table.xls"], "table.xls: the ending `xls` is that of no known table"),
    ] {
        let ran = borescope(&arguments);
        let told = ran.err.replace(record, "RECORD").replace(store, "STORE");
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{arguments:?}");
        assert_eq!(told.lines().next().unwrap(), format!("error: {message}"));
        assert!(told.contains("\n  help: "), "{told}");
        assert!(!Path::new(store).exists() && !Path::new("table.csv").exists());
    }
    let ran = borescope(["diagnose", rig, record, "--store", store]);
    assert!(ran.err.contains("(the time of the record's file; `--at` gives another)"), "{}", ran.err);
    let ran = borescope(["history", "fixtures/press/rig.toml", "--store", store]);
    assert_eq!(ran.status, Some(2));
    assert!(ran.err.contains("the store has no runs of") && ran.err.contains("`two tanks`"), "{}", ran.err);
}

/// Small records, so that much of a run is writing.
fn records(folder: &Path, rig: &Path, count: usize) -> Vec<PathBuf> {
    let record = |number: usize| {
        let path = folder.join(format!("record_{number}.csv"));
        made(rig, 0.1, number, &path);
        path
    };
    (0..count).map(record).collect()
}

fn start(arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_borescope"))
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
fn processes_may_write_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let rig = leaking(folder.path());
    let records = records(folder.path(), &rig, 6);
    let store = folder.path().join("shared.store");
    let mut arguments = vec!["diagnose", rig.to_str().unwrap(), "--store", store.to_str().unwrap()];
    arguments.extend(records.iter().map(|record| record.to_str().unwrap()));
    let children: Vec<Child> = (0..4).map(|_| start(&arguments)).collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    let store = Store::open_existing(&store).unwrap();
    let runs = store.runs().unwrap();
    assert_eq!(runs.len(), 4 * records.len());
    assert!(runs.iter().all(|run| run.faults.len() == 2));
    assert!(store.is_sound().unwrap());
}

/// Kills `count` runs at random moments of their lives. Afterwards each output file is whole, old or new, and the store is
/// sound, with whole runs only.
fn kill(count: usize, seed: u64) {
    let folder = tempfile::tempdir().unwrap();
    let rig = leaking(folder.path());
    let records = records(folder.path(), &rig, 4);
    let path = |name: &str| folder.path().join(name);
    let (store, page, table, copy) = (path("a.store"), path("page.html"), path("table.csv"), path("copy.csv"));
    let text = |path: &'_ Path| path.to_str().unwrap().to_owned();
    let (rig, first) = (text(&rig), text(&records[0]));
    let mut several = vec!["diagnose".to_owned(), rig.clone(), "--store".to_owned(), text(&store)];
    several.extend(records.iter().map(|record| text(record)));
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    let commands = [
        several,
        words(&["diagnose", &rig, &first, "--store", &text(&store), "--report", &text(&page), "--force"]),
        words(&["simulate", &rig, "--seed", "3", "-o", &text(&copy), "--force"]),
        words(&["export", "--store", &text(&store), "-o", &text(&table), "--force"]),
    ];
    let lengths: Vec<Duration> = commands
        .iter()
        .map(|command| {
            let begun = Instant::now();
            assert!(start(&command.iter().map(String::as_str).collect::<Vec<_>>()).wait().unwrap().success());
            begun.elapsed()
        })
        .collect();
    let rows = Record::read(&copy).unwrap().time.len();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut killed, mut stored) = (0, Store::open_existing(&store).unwrap().runs().unwrap().len());
    let mut tried = 0;
    while killed < count {
        let which = tried % commands.len();
        tried += 1;
        let share = random.next_u32() as f64 / f64::from(u32::MAX);
        let mut child = start(&commands[which].iter().map(String::as_str).collect::<Vec<_>>());
        std::thread::sleep(lengths[which].mul_f64(share));
        // One that has ended already was not killed.
        killed += usize::from(child.try_wait().unwrap().is_none());
        let _ = child.kill();
        child.wait().unwrap();

        let store = Store::open_existing(&store).unwrap();
        assert!(store.is_sound().unwrap(), "after {tried} runs");
        let runs = store.runs().unwrap();
        assert!(runs.len() >= stored && runs.iter().all(|run| run.faults.len() == 2), "after {tried} runs");
        stored = runs.len();
        assert!(fs::read_to_string(&page).unwrap().trim_end().ends_with("</html>"), "after {tried} runs");
        assert_eq!(Record::read(&copy).unwrap().time.len(), rows, "after {tried} runs");
        let table = fs::read_to_string(&table).unwrap();
        assert!(table.ends_with('\n') && table.lines().count() % 2 == 1, "after {tried} runs");
        assert!(table.lines().all(|line| line.matches(',').count() == 24), "after {tried} runs");
    }
    println!("{killed} kills in {tried} runs, {stored} runs stored, every file whole");
}

#[test]
fn killed_processes_leave_no_torn_file() {
    kill(24, 1);
}

/// What takes minutes.
mod studies {
    use super::*;

    #[test]
    #[ignore = "two hundred kills take a while"]
    fn two_hundred_killed_processes_leave_no_torn_file() {
        kill(200, 2);
    }
}
