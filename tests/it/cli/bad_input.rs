//! Input that would lose data, fill the memory, never end, or forge what people read: one message, exit status 2.

use crate::support::command;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use borescope::Complaint;
use borescope::Rig;
use borescope::internals::record::{Asked, Record};
use command::borescope;

const RIG: &str = "fixtures/two_tanks/rig.toml";

/// A folder with a rig file, a record of it, and paths in it.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        fs::copy(RIG, bench.path("rig.toml")).unwrap();
        let ran = borescope(["simulate", RIG, "--seed", "1", "-o", &bench.own("record.csv")]);
        assert_eq!(ran.status, Some(0), "{}", ran.err);
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn own(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }
}

fn refused(arguments: &[&str], what: &str) {
    let ran = borescope(arguments);
    assert_eq!(ran.status, Some(2), "{arguments:?}: {}{}", ran.out, ran.err);
    assert!(ran.err.starts_with("error: ") && ran.err.contains(what), "{arguments:?}: {}", ran.err);
}

fn record_of(text: &str) -> Result<Record, Complaint> {
    Asked::default().read_bytes("RECORD", text.as_bytes().to_vec())
}

fn rig_of(text: &str) -> Result<Rig, Complaint> {
    Rig::parse("rig.toml", text.to_owned())
}

#[test]
fn outputs_stores_and_inputs_are_files_of_their_own() {
    let bench = Bench::new();
    let (rig, record) = (bench.own("rig.toml"), bench.own("record.csv"));
    let store = bench.own("rig.db");
    assert_eq!(borescope(["diagnose", &rig, &record, "--store", &store]).status, Some(0));
    let kept = fs::read(&store).unwrap();
    fs::hard_link(&store, bench.path("hard.html")).unwrap();
    std::os::unix::fs::symlink(&store, bench.path("soft.html")).unwrap();
    for report in ["rig.db", "./rig.db", "hard.html", "soft.html", "rig.db-journal"] {
        let report = bench.folder.path().join(report).display().to_string();
        let both = ["diagnose", &rig, &record, "--store", &store, "--report", &report, "--force"];
        refused(&both, "this file is the store");
        refused(&["history", &rig, "--store", &store, "--report", &report, "--force"], "this file is the store");
    }
    refused(&["export", "--store", &store, "-o", &store, "--force"], "ending");
    assert_eq!(fs::read(&store).unwrap(), kept);
    let page = bench.own("page");
    for verb in [
        &["diagnose", &rig, &record, "--report", &page, "--curves", &page][..],
        &["compare", &rig, &record, "--report", &page, "--curves", &bench.own("PAGE")],
        &["calibrate", &rig, &record, "-o", &page, "--report", &page],
    ] {
        refused(verb, "two outputs would go to this file");
    }
    assert!(!bench.path("page").exists());
    refused(&["diagnose", &rig, &record, "--store", ":memory:"], "nothing would be kept");
}

#[test]
fn a_file_that_is_there_is_overwritten_only_with_force() {
    let bench = Bench::new();
    let (rig, record) = (bench.own("rig.toml"), bench.own("record.csv"));
    let before = fs::read(&record).unwrap();
    refused(&["simulate", &rig, "-o", &record], "there is such a file already");
    refused(&["add", &rig, "external-leakage@upper", "-o", &rig], "there is such a file already");
    refused(&["isolability", &rig, "--report", &record], "there is such a file already");
    assert_eq!(fs::read(&record).unwrap(), before);
    let ran = borescope(["simulate", &rig, "--seed", "2", "-o", &record, "--force"]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    assert_ne!(fs::read(&record).unwrap(), before);
    let ran = Command::new(env!("CARGO_BIN_EXE_borescope")).args(["simulate", &rig, "-o", "/dev/stdout"]).output();
    let ran = ran.unwrap();
    assert!(ran.status.success() && ran.stdout.starts_with(b"time [s],"));
    assert!(!String::from_utf8_lossy(&ran.stdout).contains(" rows of "), "the summary stands in the record");
}

/// The signal of the limit is not ignored here: the program itself outlives it.
#[test]
fn a_limit_on_the_size_of_files_is_told() {
    let bench = Bench::new();
    let out = bench.own("out.csv");
    let program = env!("CARGO_BIN_EXE_borescope");
    let script = format!("ulimit -f 4; exec {program} simulate {RIG} -o {out}");
    let output = Command::new("bash").args(["-c", &script]).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("cannot be written: ") && told.contains("ulimit"), "{told}");
    let left: Vec<_> = fs::read_dir(bench.folder.path()).unwrap().flatten().map(|entry| entry.file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn names_and_units_that_no_table_can_show_are_refused() {
    let long = "p".repeat(70_000);
    let told = |text: String| record_of(&text).unwrap_err().to_string();
    assert!(told(format!("time [s],{long} [bar]\n0,1\n")).contains("70000 characters, more than 200"));
    assert!(told("time [s],p\u{1b}[2J [bar]\n0,1\n".into()).contains("is not shown"));
    let unit = format!("m{}", "*m/m".repeat(20_000));
    assert!(told(format!("time [s],p [{unit}]\n0,1\n")).len() < 1000);
    let text = fs::read_to_string(RIG).unwrap();
    let forged = text.replacen("\"two tanks\"", "\"two\\nHEALTHY: nothing is wrong\"", 1);
    assert!(rig_of(&forged).unwrap_err().what.contains("line break"));
    let turned = text.replacen("[components.pump]", "[components.\"pump\\u202e\"]", 1);
    assert!(rig_of(&turned).unwrap_err().what.contains("is not shown"));
}

#[test]
fn what_a_terminal_acts_on_is_shown_as_its_escape() {
    let told = record_of("time [s],p [bar]\n0,1\u{1b}[2J\n").unwrap_err().to_string();
    assert!(told.contains("\\u001b[2J") && !told.contains('\u{1b}'), "{told}");
    let told = record_of("time [s],p [bar]\n0,1\0.5\n").unwrap_err().to_string();
    assert!(told.contains("`1\\u0000.5` in column `p` is not a number"), "{told}");
    let bench = Bench::new();
    let strange = bench.own("rig\u{1b}]0;title\u{7}.toml");
    fs::copy(RIG, &strange).unwrap();
    let ran = borescope(["check", &strange]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    assert!(ran.out.contains("rig\\u001b]0;title\\u0007.toml") && !ran.out.contains('\u{1b}'), "{}", ran.out);
    let ran = borescope(["check", &strange, "--format", "json"]);
    let page: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(page["rig"]["file"], strange.as_str());
}

#[test]
fn limits_hold_before_the_work() {
    let begun = Instant::now();
    refused(&["campaign", RIG, "--cases", "1000000000000000000"], "a campaign of 1000000000000000000 cases");
    refused(&["campaign", RIG, "--cases", "1000000000"], "a campaign of 1000000000 cases");
    let text = fs::read_to_string(RIG).unwrap();
    let many = |count: usize, line: &dyn Fn(usize) -> String| (0..count).map(line).collect::<String>();
    let nodes = text.replacen("[nodes]\n", &format!("[nodes]\n{}", many(10_000, &|n| format!("n{n} = {{}}\n"))), 1);
    assert!(rig_of(&nodes).unwrap_err().what.contains("`[nodes]` has 10003 entries"));
    let part = |n| format!("[components.c{n}]\nkind = \"tank\"\nports = {{ T = \"sump\" }}\n");
    let components = text.replacen("[inputs.u]", &format!("{}[inputs.u]", many(20_000, &part)), 1);
    assert!(rig_of(&components).unwrap_err().what.contains("`[components]` has 20006 entries"));
    let (before, _) = text.split_once("[cycle]").unwrap();
    let phase = |_| "{ duration = \"1 s\", u = \"1 V\" },\n".to_owned();
    let phases = format!("{before}[cycle]\ninterval = \"1 s\"\nphases = [{}]\n", many(100_000, &phase));
    assert!(rig_of(&phases).unwrap_err().what.contains("the cycle has 100000 phases"));
    let most = format!("{before}[cycle]\ninterval = \"1 s\"\nphases = [{}]\n", many(10_000, &phase));
    assert_eq!(rig_of(&most).unwrap().cycle.unwrap().phases.len(), 10_000);
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
}

/// One line of 10^8 characters, a header of 10^7 columns, a file of nothing but zeros.
#[test]
fn what_is_no_table_is_refused_before_it_fills_the_memory() {
    let bench = Bench::new();
    let path = bench.path("huge.csv");
    let told = |text: &[u8], length: u64| {
        fs::write(&path, text).unwrap();
        fs::File::options().write(true).open(&path).unwrap().set_len(length).unwrap();
        Record::read(&path).unwrap_err().to_string()
    };
    assert!(told(b"", 1 << 30).contains("there is no line break in 1 MiB"));
    assert!(told(&b"time [s],p [bar]"[..], 100_000_000).contains("there is no line break in 1 MiB"));
    assert!(told(&b"a,".repeat(2 << 20), 4 << 20).contains("there is no line break in 1 MiB"));
    assert!(told(&b"\n".repeat(2 << 20), 2 << 20).contains("nothing but blank lines in 1 MiB"));
    assert!(told(b"", (1 << 30) + 1).contains("the file is larger than 1024 MiB"));
}

#[test]
fn time_stamps_of_a_computer_count_from_the_first_row() {
    let record = record_of("time [s],p [bar]\n1700000000.25,1\n1700000000.26,2\n1700000000.28,3\n").unwrap();
    assert_eq!(record.time, [0.0, 0.01, 0.03]);
    assert!(record.origin.read_as.ends_with("times counted from the first row, at 1700000000.25 s"));
    let record = record_of("time [ms],p [bar]\n1700000000250,1\n1700000000260,2\n").unwrap();
    assert_eq!(record.time, [0.0, 0.01]);
    let near = record_of("time [s],p [bar]\n86400.5,1\n86401.5,2\n").unwrap();
    assert_eq!((near.time[0], near.origin.is_plain()), (86400.5, true));
    let told = record_of("time [s],p [bar]\n0,1\n4e-303,2\n").unwrap_err().what;
    assert_eq!(told, "the time rises by 4e-303 s only, to 4e-303 s");
}

/// The same record under stamps of a computer gives the same diagnosis.
#[test]
fn a_diagnosis_does_not_depend_on_where_the_clock_begins() {
    let bench = Bench::new();
    let text = fs::read_to_string(bench.path("record.csv")).unwrap();
    let mut stamped = String::new();
    for (number, line) in text.lines().enumerate() {
        let (time, rest) = line.split_once(',').unwrap();
        match number {
            0 => stamped.push_str(line),
            _ => stamped.push_str(&format!("{:.3},{rest}", 1.7e9 + time.parse::<f64>().unwrap())),
        }
        stamped.push('\n');
    }
    fs::write(bench.path("stamped.csv"), stamped).unwrap();
    let page = |name: &str| -> serde_json::Value {
        let ran = borescope(["diagnose", RIG, &bench.own(name), "--format", "json"]);
        assert_eq!(ran.status, Some(0), "{}", ran.err);
        assert_eq!(ran.err.contains("times counted from the first row"), name == "stamped.csv", "{}", ran.err);
        serde_json::from_str(&ran.out).unwrap()
    };
    let (plain, stamped) = (page("record.csv"), page("stamped.csv"));
    assert_eq!((&plain["verdict"], &plain["faults"]), (&stamped["verdict"], &stamped["faults"]));
}

#[test]
fn a_table_for_spreadsheets_holds_no_formula() {
    use borescope::internals::store::plain_cell;
    for (text, cell) in [
        ("=1+1", "'=1+1"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("-2+3", "'-2+3"),
        ("+cmd|' /C calc'!A0", "'+cmd|' /C calc'!A0"),
        ("-", "-"),
        ("rig.toml", "rig.toml"),
    ] {
        assert_eq!(plain_cell(text), cell);
    }
}

#[test]
fn a_key_that_stands_twice_is_named_with_both_places() {
    let told = |text: &str| rig_of(text).unwrap_err().to_string();
    let twice = told("[rig]\nname = \"a\"\n[fluid]\ndensity = \"1 kg/m3\"\nviscosity = \"1 mPa.s\"\ndensity = 2\n");
    assert!(twice.starts_with("error: rig.toml:4 and rig.toml:6: this is not TOML: the key `density` appears twice"));
    let twice = told("[rig]\nname = \"a\"\n[nodes]\n[rig]\n");
    assert!(
        twice.starts_with("error: rig.toml:1 and rig.toml:4: this is not TOML: the key `rig` appears twice"),
        "{twice}"
    );
}

#[test]
fn who_waits_says_so() {
    let bench = Bench::new();
    let pipe = bench.own("pipe.csv");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let waiting = Command::new(env!("CARGO_BIN_EXE_borescope"))
        .args(["check", RIG, &pipe])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let text = fs::read(bench.path("record.csv")).unwrap();
    fs::write(&pipe, text).unwrap();
    let output = waiting.wait_with_output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("this is a pipe; waiting for the program at its other end"), "{told}");

    let store = bench.own("rig.db");
    assert_eq!(borescope(["diagnose", RIG, &bench.own("record.csv"), "--store", &store]).status, Some(0));
    let other = rusqlite::Connection::open(&store).unwrap();
    other.execute_batch("BEGIN EXCLUSIVE").unwrap();
    let history = std::thread::spawn(move || borescope(["history", RIG, "--store", &store]));
    std::thread::sleep(Duration::from_secs(2));
    other.execute_batch("COMMIT").unwrap();
    let ran = history.join().unwrap();
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    assert!(ran.err.contains("another program holds the store; waiting for it"), "{}", ran.err);
}
