//! Many records of many machines: the list of them in shards, the merge, and how the fleet stands.

use crate::support::command;

use std::fs;
use std::path::{Path, PathBuf};

use borescope::internals::store::Store;
use command::{Ran, borescope};
use serde_json::Value;
use tempfile::TempDir;

/// Machines of the fleet, and the diameter of their outlets at each of four records, mm; healthy is 8, the limit 6.5.
const MACHINES: [(&str, [f64; 4]); 4] = [
    ("sound", [8.0, 8.0, 8.0, 8.0]),
    ("clogging", [7.9, 7.7, 7.5, 7.3]),
    ("clogged", [6.9, 6.7, 6.5, 6.3]),
    ("narrow", [7.5, 7.5, 7.5, 7.5]),
];

/// A folder with the rig file, the records of all machines, two damaged ones, and the list of them.
struct Fleet(TempDir);

impl Fleet {
    fn new() -> Self {
        let fleet = Self(tempfile::tempdir().unwrap());
        let healthy = "\"upper_outlet.diameter\" = {";
        let rig = fs::read_to_string("fixtures/two_tanks/rig.toml").unwrap();
        assert!(rig.contains(healthy));
        fs::write(fleet.path("rig.toml"), rig.replace(healthy, &format!("{healthy} limit = \"6.5 mm\","))).unwrap();
        let mut list = "record,rig,measured_at\n".to_owned();
        for (name, diameters) in MACHINES {
            for (month, diameter) in (1..).zip(diameters) {
                let record = format!("{name}_{month}.csv");
                let (set, seed) = (format!("upper_outlet.diameter={diameter}mm"), month.to_string());
                let (rig, path) = (fleet.text("rig.toml"), fleet.text(&record));
                let ran = borescope(["simulate", &rig, "--set", &set, "--seed", &seed, "-o", &path]);
                assert_eq!(ran.status, Some(0), "{}", ran.err);
                list += &format!("{record},{name},2026-{month:02}-01\n");
            }
        }
        fs::write(fleet.path("torn.csv"), "time [s],level_1").unwrap();
        list += "torn.csv,sound,2026-05-01\ngone.csv,sound,2026-06-01\n";
        fs::write(fleet.path("list.csv"), list).unwrap();
        fleet
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    /// Does records of the list, into a folder.
    fn diagnose(&self, into: &str, more: &[&str]) -> Ran {
        let (rig, list, into) = (self.text("rig.toml"), self.text("list.csv"), self.text(into));
        borescope(["diagnose", &rig, "--records", &list, "-o", &into].iter().chain(more))
    }

    /// The merged table without the moments of the diagnoses, and what was said.
    fn merged(&self, shards: &str) -> (String, Ran) {
        let table = self.text(&format!("{shards}.csv"));
        let ran = borescope(["diagnose", "--merge", &self.text(shards), "-o", &table, "--force"]);
        (timeless(Path::new(&table)), ran)
    }
}

/// A table of runs without when they were diagnosed.
fn timeless(table: &Path) -> String {
    let Ok(text) = fs::read_to_string(table) else { return String::new() };
    let column = text.lines().next().unwrap().split(',').position(|name| name == "diagnosed_at").unwrap();
    let without = |line: &str| {
        let fields = line.split(',').enumerate().filter(|(index, _)| *index != column);
        fields.map(|(_, field)| field).collect::<Vec<_>>().join(",") + "\n"
    };
    text.lines().map(without).collect()
}

/// However the records are shared out and whatever happens on the way, the table is that of one process; what is damaged is named
/// by its shard and by the merge, and counted once.
#[test]
fn shards_make_the_table_of_one_process() {
    let fleet = Fleet::new();
    let ran = fleet.diagnose("whole", &["--threads", "1"]);
    assert_eq!(ran.status, Some(2), "two cannot be read");
    for damaged in ["torn.csv:1: ", "gone.csv: there is no such file\n  help: "] {
        assert_eq!(ran.err.matches(damaged).count(), 1, "{}", ran.err);
    }
    let (whole, ran) = fleet.merged("whole");
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    assert!(
        ran.out.contains("18 records: 4 healthy, 12 faulty, 0 model inadequate, 2 without a diagnosis"),
        "{}",
        ran.out
    );
    assert_eq!(ran.out.matches("torn.csv:1: ").count() + ran.out.matches("gone.csv: there").count(), 2);
    assert_eq!(whole.lines().count(), 1 + 16, "one fault a run");
    for (of, order) in [(2, &[2, 1][..]), (7, &[5, 2, 7, 1, 3, 6, 4])] {
        let shards = format!("of_{of}");
        let shard = |index: usize| fleet.diagnose(&shards, &["--shard", &format!("{index}/{of}")]);
        for &index in order {
            // The last ones of the list are damaged.
            assert_eq!(shard(index).status, Some(if index == of { 2 } else { 0 }));
        }
        let last = fleet.path(&shards).join(format!("shard-{of:05}"));
        for _ in 0..2 {
            let journal = fs::read_to_string(last.join("journal.jsonl")).unwrap();
            let kept: Vec<&str> = journal.lines().take(2).collect();
            fs::write(last.join("journal.jsonl"), format!("{}\n{{\"number\": 1, \"re", kept.join("\n"))).unwrap();
            fs::remove_file(last.join("done.json")).unwrap();
            let told = fleet.merged(&shards).1;
            assert_eq!(told.status, Some(2));
            assert!(told.err.contains(&format!("shard {of} of {of} is not done; 1 of them begun")), "{}", told.err);
            assert_eq!(shard(of).status, Some(2));
        }
        let failures = fs::read_to_string(last.join("failures.csv")).unwrap();
        assert_eq!(failures.lines().count(), 3, "{failures}");
        let again = shard(of);
        assert_eq!((again.status, again.err.as_str()), (Some(0), ""), "what is done is done");
        assert!(again.out.contains("done before"), "{}", again.out);
        assert_eq!(fleet.merged(&shards).0, whole, "{of} shards");
    }
    // What is in a store already is not added again.
    let store = fleet.text("fleet.db");
    let into = |shards: &str| borescope(["diagnose", "--merge", &fleet.text(shards), "--store", &store]).out;
    assert!(into("of_7").contains("16 runs added\n"));
    assert!(into("of_7").contains("0 runs added, 16 were there already\n"));
    assert!(Store::open_existing(&store).unwrap().is_sound().unwrap());
    let exported = fleet.text("exported.csv");
    assert_eq!(borescope(["export", "--store", &store, "-o", &exported]).status, Some(0));
    let sorted = |text: &str| {
        // A store numbers its runs as they come, and gives them by their times.
        let mut lines: Vec<String> = text.lines().map(|line| line.split_once(',').unwrap().1.to_owned()).collect();
        lines.sort();
        lines
    };
    assert_eq!(sorted(&timeless(Path::new(&exported))), sorted(&whole));
    // Single records go into the same store, and belong to the rig file.
    let ran = borescope(["diagnose", &fleet.text("rig.toml"), &fleet.text("sound_1.csv"), "--store", &store]);
    assert!(ran.err.contains("as run 17, measured 2026-01-01 00:00 UTC (as stated before"), "{}", ran.err);
}

#[test]
fn wrong_lists_and_strange_shards_are_told() {
    let fleet = Fleet::new();
    let told = |ran: Ran, what: &str| {
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
        assert!(ran.err.contains(what) && ran.err.contains("help: "), "{what}: {}", ran.err);
    };
    fs::write(fleet.path("twice.csv"), "record\nsound_1.csv\nsound_1.csv\n").unwrap();
    let (rig, rows) = (fleet.text("rig.toml"), fleet.text("rows"));
    told(
        borescope(["diagnose", &rig, "--records", &fleet.text("twice.csv"), "-o", &rows]),
        "twice.csv:3: `sound_1.csv` comes twice",
    );
    told(fleet.diagnose("list.csv", &[]), "this is a file, and `--records` fills a folder");
    told(borescope(["diagnose", "--merge", &rows]), "`--merge` does not say where to");
    told(borescope(["diagnose", "--merge", &rows, "-o", &fleet.text("t.txt")]), "`txt` is that of no known table");
    told(fleet.merged("rows").1, "the folder cannot be read");
    assert_eq!(fleet.diagnose("rows", &["--shard", "1/2"]).status, Some(0));
    told(fleet.merged("rows").1, "shard 2 of 2 is not done");
    told(fleet.diagnose("rows", &["--shard", "1/3"]), "the folder holds shard 1 of 2 of a list of records, not 1 of 3");
    fs::write(fleet.path("list.csv"), "record\nsound_1.csv\nsound_2.csv\n").unwrap();
    told(fleet.diagnose("rows", &["--shard", "1/2"]), "with other options, other files or another version");
    assert!(!fleet.path("rows.csv").exists());
}

/// The worst first, each with the limit that it comes to; the same out of a store and out of a table; and small for many rigs.
#[test]
fn a_fleet_is_shown_the_worst_first() {
    let fleet = Fleet::new();
    fleet.diagnose("rows", &[]);
    let (store, table) = (fleet.text("fleet.db"), fleet.text("table.csv"));
    assert_eq!(
        borescope(["diagnose", "--merge", &fleet.text("rows"), "--store", &store, "-o", &table]).status,
        Some(0)
    );
    let shown = |source: &str| -> Value {
        let ran = borescope(["fleet", source, "--format", "json"]);
        assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
        serde_json::from_str(&ran.out).unwrap()
    };
    let stands = shown(&store);
    assert_eq!(stands["rigs"], shown(&table)["rigs"]);
    assert_eq!((&stands["runs"], &stands["states"]["faulty"]), (&16.into(), &2.into()));
    let rigs: Vec<(&str, &str)> = stands["rigs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|rig| (rig["rig"].as_str().unwrap(), rig["state"].as_str().unwrap()))
        .collect();
    assert_eq!(
        rigs,
        [("clogged", "limit-reached"), ("clogging", "faulty"), ("narrow", "faulty"), ("sound", "healthy")]
    );
    // From 7.9 to 7.3 mm in the ninety days from January to April, and on to 6.5 mm in another 120.
    let next = &stands["rigs"][1]["next"];
    assert_eq!((next["state"].as_str(), next["limit"].as_f64()), (Some("will-pass"), Some(6.5)), "{next}");
    let end = |at: usize| next["ci95"][at].as_str().unwrap();
    assert!("2026-07" < end(0) && end(0) < "2026-07-30" && "2026-07-30" < end(1) && end(1) < "2026-09", "{next}");
    assert!(stands["rigs"][2]["next"].is_null() && stands["rigs"][3]["next"].is_null(), "{stands}");
    let ran = borescope(["fleet", &store]);
    assert!(ran.out.contains("4 rigs, 16 runs\n1 limit reached, 2 faulty, 1 healthy\n"), "{}", ran.out);

    // Ten thousand rigs as these.
    let text = fs::read_to_string(&table).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let columns: Vec<&str> = head.split(',').collect();
    let at = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let (run, rig, digest) = (at("run"), at("rig_name"), at("record_digest"));
    let mut many = format!("{head}\n");
    for copy in 0..2500 {
        for row in rows.lines() {
            let mut fields: Vec<String> = row.split(',').map(str::to_owned).collect();
            fields[run] = format!("{}{:02}", copy + 1, fields[run].parse::<u32>().unwrap());
            fields[rig] += &format!(" {copy}");
            fields[digest] += &copy.to_string();
            many += &(fields.join(",") + "\n");
        }
    }
    fs::write(fleet.path("many.csv"), many).unwrap();
    let page = fleet.text("many.html");
    let ran = borescope(["fleet", &fleet.text("many.csv"), "--report", &page]);
    assert!(ran.out.contains("10000 rigs, 40000 runs\n2500 limit reached, 5000 faulty, 2500 healthy\n"), "{}", ran.out);
    assert!(ran.out.contains("\n9980 more; `--all` shows them\n\nNext: "), "{}", ran.out);
    let page = fs::read_to_string(page).unwrap();
    assert!(page.len() < 5_000_000, "{}", page.len());
    assert_eq!(page.matches("<td>healthy</td>").count(), 2500);
}

/// A store of the version before is read, gets what it lacks, and says of its old runs that limits are not known.
#[test]
fn a_store_of_version_1_goes_on() {
    let fleet = Fleet::new();
    let (rig, store) = (fleet.text("rig.toml"), fleet.text("old.db"));
    let keep =
        |record: &str| borescope(["diagnose", &rig, &fleet.text(record), "--store", &store, "--at", "2026-01-01"]);
    assert_eq!(keep("narrow_1.csv").status, Some(0));
    let old = rusqlite::Connection::open(&store).unwrap();
    let back =
        ["limit_value", "lower_bound", "upper_bound"].map(|name| format!("ALTER TABLE fault DROP COLUMN {name};"));
    old.execute_batch(&back.concat()).unwrap();
    old.pragma_update(None, "user_version", 1).unwrap();
    drop(old);
    let ran = borescope(["history", &rig, "--store", &store]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    assert_eq!(keep("narrow_2.csv").status, Some(0));
    let runs = Store::open_existing(&store).unwrap().runs().unwrap();
    assert_eq!(runs.iter().map(|run| run.faults[0].limit).collect::<Vec<_>>(), [None, Some(6.5)]);
    assert_eq!(runs[1].faults[0].lower_bound.zip(runs[1].faults[0].upper_bound), Some((2.0, 9.0)));
}

#[test]
fn what_is_no_store_and_no_table_is_told() {
    let fleet = Fleet::new();
    for (text, told) in [
        ("", "there are no runs in it"),
        ("run,fault\n1,a\n", "wrong.csv:2: the table has nothing in `unit`"),
        ("run\nx\n", "wrong.csv:2: `x` in `run` is no number"),
    ] {
        fs::write(fleet.path("wrong.csv"), text).unwrap();
        let ran = borescope(["fleet", &fleet.text("wrong.csv")]);
        assert_eq!(ran.status, Some(2), "{text:?}: {}", ran.out);
        assert!(ran.err.contains(told) && ran.err.contains("help: "), "{text:?}: {}", ran.err);
    }
    let ran = borescope(["fleet", &fleet.text("rig.toml")]);
    assert!(ran.status == Some(2) && ran.err.contains("this is no store of diagnoses"), "{}", ran.err);
    let ran = borescope(["fleet", &fleet.text("nowhere.db")]);
    assert!(ran.status == Some(2) && ran.err.contains("there is no such store"), "{}", ran.err);
}
