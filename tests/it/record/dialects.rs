//! The dialects of CSV: what is recognised, how it is told, what is refused because it may be read in two ways.

use crate::support::command;

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use borescope::Record;
use borescope::internals::record::survey::{Doubt, Finding, Scatter, survey};
use command::borescope;

fn read(bytes: &[u8]) -> Result<Record, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record");
    fs::write(&path, bytes).unwrap();
    Record::read(&path).map_err(|complaint| complaint.to_string().replace(&path.display().to_string(), "RECORD"))
}

fn right(bytes: &[u8]) -> Record {
    read(bytes).unwrap_or_else(|message| panic!("{message}\nfor:\n{}", String::from_utf8_lossy(bytes)))
}

const PLAIN: &str = "time [s],p [bar],u [-]\n0.0,1.5,0\n0.5,-2.5,1\n";

#[test]
fn what_was_recognised_is_told() {
    let plain = right(PLAIN.as_bytes());
    for (text, read_as) in [
        (PLAIN, "CSV, columns between commas, decimal points"),
        ("time [s];p [bar];u [-]\n0,0;1,5;0\n0,5;-2,5;1\n", "CSV, columns between semicolons, decimal commas"),
        ("time [s]\tp [bar]\tu [-]\r\n0.0\t1.5\t0\r\n0.5\t-2.5\t1\r\n", "CSV, columns between tabs, decimal points"),
        ("\u{feff}Time [s],p [bar],u [-]\n0.0,1.5,0\n0.5,-2.5,1\n", "CSV, columns between commas, decimal points"),
        ("time,p,u\ns,bar,-\n0.0,1.5,0\n0.5,-2.5,1\n", "CSV, columns between commas, decimal points, units in line 2"),
        (
            "# made by hand\n\ntime;\"p\";u\n[s];[bar];(1)\n0,0;1,5;0\n0,5;-2,5;1\n",
            "CSV, columns between semicolons, decimal commas, units in line 4",
        ),
        (
            "sep=;\r\ntime [s];p [bar];u [-]\r\n0,0;1,5;0\r\n0,5;-2,5;1\r\n",
            "CSV, columns between semicolons, decimal commas, the line above the names passed over",
        ),
        (
            "Zeit;p;u\n[s];[bar];[-]\n0,0;1,5;0\n0,5;-2,5;1\n",
            "CSV, columns between semicolons, decimal commas, units in line 2",
        ),
        (
            "Date/Time;12.03.2024 10:15\nSample time [s];0,5\nZeit;p;u\ns;bar;-\n0,0;1,5;0\n0,5;-2,5;1\n",
            "CSV, columns between semicolons, decimal commas, units in line 4, 2 lines above the names passed over",
        ),
        (
            "Press 3, Monday\n\"run 12; 40 degC\"\n\ntime,p,u\ns,bar,-\n0.0,1.5,0\n0.5,-2.5,1\n",
            "CSV, columns between commas, decimal points, units in line 5, 2 lines above the names passed over",
        ),
        (
            "time (s),p (bar),u (-)\n0.0,1.5,0\n0.5,-2.5,1\n",
            "CSV, columns between commas, decimal points, units in round brackets",
        ),
        (
            "t_s,p_bar,u\n0.0,1.5,0\n0.5,-2.5,1\n",
            "CSV, columns between commas, decimal points, units behind the last `_` of the names",
        ),
        (
            "timestamp,p [bar],u [-]\n2026-11-23 10:00:00.0,1.5,0\n2026-11-23 10:00:00.5,-2.5,1\n",
            "CSV, columns between commas, decimal points, times counted from the first row, at 2026-11-23 10:00:00.0",
        ),
        (
            "Date/Time;p [bar];u [-]\n2026-11-22T23:59:59,5+01:00;1,5;0\n2026-11-22T23:00:00Z;-2,5;1\n",
            "CSV, columns between semicolons, decimal commas, times counted from the first row, at 2026-11-22T23:59:59,5+01:00",
        ),
    ] {
        let record = right(text.as_bytes());
        assert_eq!(record.origin.read_as, read_as);
        assert_eq!(record.origin.is_plain(), read_as == "CSV, columns between commas, decimal points");
        assert_eq!(record.time, plain.time, "{text}");
        for (channel, plain) in record.channels.iter().zip(&plain.channels) {
            assert_eq!((&channel.name, &channel.values), (&plain.name, &plain.values), "{text}");
        }
        assert!(record.origin.modified.is_some() && record.origin.digest.len() == 64);
    }
    // SHA-256 of the bytes, as `sha256sum` gives it.
    assert_eq!(right(b"time [s],p [bar]\n0,1\n").origin.digest.get(..16), Some("632167c0828258e5"));
}

#[test]
fn packed_files_are_known_by_their_bytes() {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(PLAIN.as_bytes()).unwrap();
    let gzip = packed.finish().unwrap();
    let zstd = ruzstd::encoding::compress_to_vec(PLAIN.as_bytes(), ruzstd::encoding::CompressionLevel::Fastest);
    for (bytes, how) in [(&gzip, "gzip"), (&zstd, "zstd")] {
        let record = right(bytes);
        assert_eq!(record.channels, right(PLAIN.as_bytes()).channels);
        assert!(record.origin.read_as.ends_with(&format!(", packed with {how}")), "{}", record.origin.read_as);
        let cut = read(&bytes[..bytes.len() - 12]).unwrap_err();
        assert!(
            cut.starts_with(&format!("error: RECORD: the file is packed with {how}, but cannot be unpacked")),
            "{cut}"
        );
    }
    // Two gzip members, as a logger leaves that appends.
    let twice = [&gzip[..], &gzip[..]].concat();
    assert!(read(&twice).unwrap_err().contains("`time [s]` in column `time` is not a number"));
}

#[test]
fn what_may_be_read_in_two_ways_is_refused() {
    for (text, what) in [
        (
            "time [s];p [bar]\n0;1,234\n1;2,345\n",
            "RECORD:2: `1,234` in column `p` may be 1.234 or 1234, and so may all numbers with a comma",
        ),
        (
            "time [s],p [bar]\n0,\"1,234\"\n1,\"12,345\"\n",
            "RECORD:2: `1,234` in column `p` may be 1.234 or 1234, and so may all numbers with a comma",
        ),
        ("time [s];p [bar]\n0;1,234.5\n", "RECORD:2: `1,234.5` in column `p` has separators of thousands"),
        ("time [s];p [bar]\n0;1.234.567\n", "RECORD:2: `1.234.567` in column `p` has separators of thousands"),
        ("time [s],p;rod [bar]\n0,1\n", "RECORD:1: the columns may be separated by `,` or by `;`"),
        ("time,p\ns,bar,mm\n0,1\n", "RECORD:2: the row has 3 units, but the header names 2 columns"),
        ("time,p\ns,\n0,1\n", "RECORD:2: the column `p` has no unit"),
        ("time,p\ns,barg\n0,1\n", "RECORD:2: column `p`: unknown unit `barg`"),
        ("time,p\nbar,bar\n0,1\n", "RECORD:1: the column `p` has no unit in square brackets"),
    ] {
        let message = read(text.as_bytes()).unwrap_err();
        assert_eq!(message.lines().next().unwrap(), format!("error: {what}"), "{text}");
        assert!(message.contains("\n  help: "), "{message}");
    }
    // One number that can only have a decimal comma settles the others.
    for settled in ["0,004;1,234", "12;1,2", "0;1234,567", "0;,500", "0;1,234e2"] {
        right(format!("time [s];p [bar]\n{settled}\n100;1,234\n").as_bytes());
    }
}

#[test]
fn formats_that_are_not_read_are_named() {
    for (bytes, what) in [
        (&b"PK\x03\x04rest"[..], "the file is a ZIP archive or a workbook of a spreadsheet"),
        (b"BZh9rest", "the file is packed with bzip2"),
    ] {
        let message = read(bytes).unwrap_err();
        assert!(message.starts_with(&format!("error: RECORD: {what}")), "{message}");
        assert!(message.contains("\n  help: "), "{message}");
    }
    #[cfg(not(feature = "parquet"))]
    {
        let what = "the file is Parquet, and this borescope was built without the feature `parquet`";
        let help = "build it with `cargo build --release --features parquet`, or write the record as CSV";
        assert_eq!(read(b"PAR1rest").unwrap_err(), format!("error: RECORD: {what}\n  help: {help}"));
    }
    #[cfg(not(feature = "hdf5"))]
    for bytes in [&b"\x89HDF\r\n\x1a\n"[..], b"MATLAB 7.3 MAT-file"] {
        let message = read(bytes).unwrap_err();
        let what = "the file is MATLAB v7.3 or HDF5, and this borescope was built without the feature `hdf5`";
        assert!(message.starts_with(&format!("error: RECORD: {what}\n  help: ")), "{message}");
    }
    for (bytes, name) in
        [(&b"UnFinMF 4.10    "[..], "MDF whose writing broke off"), (b"MDF     3.30    ", "MDF before version 4")]
    {
        let message = read(bytes).unwrap_err();
        assert!(
            message.starts_with(&format!("error: RECORD: the file is {name}, which is not read\n  help: ")),
            "{message}"
        );
    }
}

#[test]
fn standard_input_and_output_are_files() {
    let rig = "fixtures/two_tanks/rig.toml";
    let made = borescope(["simulate", rig, "--seed", "1", "-o", "-"]);
    assert_eq!((made.status, made.err.as_str()), (Some(0), ""));
    assert!(made.out.starts_with("time [s],"), "{}", made.out);
    let german = made.out.replace(',', ";").replace('.', ",");
    let through = |arguments: &[&str]| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_borescope"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(german.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (page, told) = through(&["check", rig, "-"]);
    assert!(page.contains("\n  Read as CSV, columns between semicolons, decimal commas.\n"), "{page}");
    assert_eq!(told, "");
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("a.store");
    let (page, told) = through(&["diagnose", rig, "-", "--store", store.to_str().unwrap()]);
    assert!(page.contains("HEALTHY"), "{page}");
    assert!(
        told.starts_with("note: -: read as CSV, columns between semicolons, decimal commas\nnote: -: kept in "),
        "{told}"
    );
    assert!(told.ends_with("(the time of the diagnosis; `--at` gives another)\n"), "{told}");
}

#[test]
fn a_mistake_behind_titles_has_its_line() {
    assert_eq!(
        read(b"Press 3\nMonday\ntime [s],p [bar]\n0,1\n1,x\n").unwrap_err().lines().next(),
        Some("error: RECORD:5: `x` in column `p` is not a number")
    );
    let nameless = read(b",p [bar]\n0,1\n").unwrap_err();
    assert!(nameless.ends_with("help: name the first column `time [s]`"), "{nameless}");
    // Of a table whose first column is not the time the header is meant, not the title above it.
    let told = read(b"Press 3\nt,p [bar]\n0,1\n").unwrap_err();
    let mut lines = told.lines();
    let header =
        "no line begins with the time; this one looks like the header, but its first column is `t`, not the time";
    assert_eq!(lines.next(), Some(format!("error: RECORD:2: {header}").as_str()));
    assert_eq!(told.lines().last(), Some("  help: write `t [s]` if it is; else put the time in front"));
}

#[test]
fn a_first_column_of_dates_is_the_time_whatever_it_is_called() {
    let rows = "23.11.2026 10:00:00,005;1,25\n23.11.2026 10:00:00,010;1,5\n";
    for header in ["Zeit;p [bar]\n", "Datum/Uhrzeit;p [bar]\n", "Presse 4\nDatum;p [bar]\n", "Zeit;p (bar)\n"] {
        let record = read(format!("{header}{rows}").as_bytes()).unwrap_or_else(|told| panic!("{header}{told}"));
        assert!((record.time[1] - 0.005).abs() < 1e-12, "{header}: {:?}", record.time);
        assert_eq!(record.channels[0].values, [1.25e5, 1.5e5], "{header}");
    }
    // Which number is the day stays open between slashes, under any name.
    for header in ["Zeit;p [bar]\n", "time;p [bar]\n"] {
        let told = read(format!("{header}11/12/2026 10:00:00;1,25\n").as_bytes()).unwrap_err();
        assert!(told.contains("another order could be read in two ways"), "{told}");
    }
    // Numbers are no dates, and a time that stands elsewhere goes before.
    assert!(read(b"Zeit;p [bar]\n0,5;1,25\n").is_err());
    assert!(read(b"Datum;time [s];p [bar]\n23.11.2026 10:00:00;0,5;1,25\n").unwrap_err().contains("must be the first"));
}

/// Two hundred rows of a noisy pressure, 10 ms apart, changed by `change(row, time, value)`.
fn findings(change: impl Fn(usize, f64, f64) -> (f64, f64)) -> Vec<Finding> {
    let mut state = 7_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
    };
    let mut rows = String::from("time [s],p [bar]\n");
    for row in 0..200 {
        let (time, value) = change(row, 0.01 * row as f64, 50.0 + 0.1 * row as f64 + noise());
        rows.push_str(&if value.is_nan() { format!("{time:.4},\n") } else { format!("{time:.4},{value:.3}\n") });
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    fs::write(&path, rows).unwrap();
    let (record, refused) = Record::read_as_it_stands(&path).unwrap();
    let found = survey(&record, |_| Some(Scatter { noise: 0.3e5, resolution: 0.0 }), |_| false);
    let refusing = |finding: &Finding| matches!(finding.doubt, Doubt::DuplicateStamp | Doubt::ClockReset);
    assert_eq!(refused.is_some(), found.iter().any(refusing), "{found:?}");
    found
}

#[test]
fn each_doubt_is_found_with_its_times() {
    let texts = |found: Vec<Finding>| found.iter().map(Finding::to_string).collect::<Vec<_>>();
    assert_eq!(texts(findings(|_, time, value| (time, value))), Vec::<String>::new());
    let dropout = findings(|row, time, value| (time, if (50..53).contains(&row) { f64::NAN } else { value }));
    assert_eq!(texts(dropout), ["`p` has no value in 3 rows from 0.5 s to 0.52 s"]);
    let stuck = findings(|row, time, value| (time, if (50..80).contains(&row) { 55.0 } else { value }));
    assert_eq!(texts(stuck), ["`p` is stuck at 55 bar for 30 rows from 0.5 s to 0.79 s"]);
    let saturated = findings(|_, time, value| (time, value.min(65.0)));
    assert_eq!(saturated.last().unwrap().doubt, Doubt::Saturated);
    assert!(saturated.iter().all(|finding| finding.value == Some(65.0)), "{saturated:?}");
    let spike = findings(|row, time, value| (time, if row == 120 { 90.0 } else { value }));
    assert_eq!(texts(spike), ["`p` leaps to 90 bar at 1.2 s"]);
    let constant = findings(|_, time, _| (time, 7.0));
    assert_eq!(texts(constant), ["`p` stays at 7 bar: is the sensor connected?"]);
    let twice = findings(|row, time, value| (if row == 100 { time - 0.01 } else { time }, value));
    assert_eq!(texts(twice), ["the time 0.99 s stands in 2 rows", "1 row missing from 0.99 s to 1.01 s"]);
    let set = findings(|row, time, value| (if row >= 100 { time - 0.95 } else { time }, value));
    assert_eq!(texts(set), ["the clock was set back from 0.99 s to 0.05 s"]);
    let missing = findings(|row, time, value| (if row >= 100 { time + 0.04 } else { time }, value));
    assert_eq!(texts(missing), ["4 rows missing from 0.99 s to 1.04 s"]);
    let jitter = findings(|row, time, value| (time + if row % 3 == 0 { 0.001 } else { 0.0 }, value));
    assert_eq!(jitter.len(), 1);
    assert_eq!(jitter[0].doubt, Doubt::Jitter);
    assert!((jitter[0].value.unwrap() - 0.0008).abs() < 0.0002, "{jitter:?}");
}

/// Where a valve opens a pressure leaps for one row; no circuit leaves all that it has ever done by more than that spans.
#[test]
fn a_leap_while_a_command_switches_is_the_circuits() {
    let pressures = |at_switching: f64| {
        let wave = (0..200).map(|row| 50.0 + 5.0 * (0.05 * f64::from(row)).sin() + 0.3 * f64::from(row * row).sin());
        let mut values: Vec<f64> = wave.map(|bar| bar * 1e5).collect();
        values[120] = at_switching * 1e5;
        let time = (0..200).map(|row| 0.01 * f64::from(row)).collect();
        Record::from_columns(time, [("p", "Pa", values)]).unwrap()
    };
    let leaps = |record: &Record, switched: f64| {
        let scatter = |_: &_| Some(Scatter { noise: 0.3e5, resolution: 0.0 });
        let found = survey(record, scatter, |time| (switched..switched + 0.05).contains(&time));
        found
            .into_iter()
            .filter(|finding| finding.doubt == Doubt::Spike)
            .map(|finding| finding.from_s)
            .collect::<Vec<_>>()
    };
    assert_eq!(leaps(&pressures(40.0), 0.3), [1.2]);
    assert_eq!(leaps(&pressures(40.0), 1.18), [] as [f64; 0]);
    assert_eq!(leaps(&pressures(400.0), 1.18), [1.2]);
}

/// A value that never changes is a dead sensor only where noise would move it, and moves the other channels.
#[test]
fn a_sensor_that_noise_would_move_is_dead() {
    let doubts_of = |own: fn(usize) -> String, other: fn(usize) -> f64, resolution: f64| {
        let mut rows = String::from("time [s],p [bar],r [bar]\n");
        (0..50).for_each(|row| rows.push_str(&format!("{:.2},{},{:.3}\n", 0.01 * row as f64, own(row), other(row))));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.csv");
        fs::write(&path, rows).unwrap();
        let record = Record::read(&path).unwrap();
        let found = survey(&record, |_| Some(Scatter { noise: 0.3e5, resolution }), |_| false);
        found.into_iter().map(|finding| (finding.channel.unwrap(), finding.doubt)).collect::<Vec<_>>()
    };
    let doubts = |other, resolution| doubts_of(|_| "7.0".to_owned(), other, resolution);
    let restless: fn(usize) -> f64 = |row| 20.0 + 0.5 * ((row * row) as f64).sin();
    let p = |doubt| vec![("p".to_owned(), doubt)];
    assert_eq!(doubts(restless, 0.0), p(Doubt::Dead));
    // A digit of 1 bar hides a noise of 0.3 bar.
    assert_eq!(doubts(restless, 1e5), p(Doubt::Constant));
    // A computed record has no noise anywhere.
    assert_eq!(doubts(|row| 20.0 + 0.1 * row as f64, 0.0), p(Doubt::Constant));
    // Three values of a slow channel may be alike.
    let slow = doubts_of(|row| if row % 20 == 0 { "7.0".to_owned() } else { String::new() }, restless, 0.0);
    assert_eq!(slow, p(Doubt::Dropout));
}

/// Real and simulated records give no false alarm of a damaged sensor.
#[test]
fn sound_records_are_not_doubted() {
    for name in ["healthy_1", "leak_020", "blocked_16", "series_1"] {
        let ran = borescope([
            "check",
            "fixtures/telescopic/rig.toml",
            &format!("fixtures/telescopic/{name}.csv"),
            "--format",
            "json",
        ]);
        let page: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
        assert_eq!(page["record"]["findings"], serde_json::json!([]), "{name}");
    }
}

/// Dates count exactly, however long the record: a day in steps of a millisecond stays on its grid.
#[test]
fn dates_count_from_the_first_row() {
    let stamps = ["2026-03-28 23:59:59.999", "2026-03-29 00:00:00.000", "2026-03-29 23:59:59.123456"];
    let rows: String = stamps.iter().enumerate().map(|(row, stamp)| format!("{stamp},{row}\n")).collect();
    let record = right(format!("time,p [bar]\n{rows}").as_bytes());
    assert_eq!(record.time, [0.0, 0.001, 86399.124456]);
    // A unit that the header names is not that of dates.
    let record = right(format!("time [min],p [bar]\n{rows}").as_bytes());
    assert_eq!(record.time, [0.0, 0.001, 86399.124456]);
    for (times, message) in [
        (
            ["2026-11-23 10:00:00", "2026-11-23 09:59:59"],
            "RECORD:2 and RECORD:3: the time runs backwards to 2026-11-23 09:59:59",
        ),
        (["2026-11-23 10:00:00", "2026-11-23 10:00:00"], "RECORD:2 and RECORD:3: the time 2026-11-23 10:00:00 repeats"),
        (["2026-11-23 10:00:00", "1.5"], "RECORD:3: `1.5` in column `time` is not a date with a time of day"),
        (
            ["2026-11-23 10:00:00Z", "2026-11-23 10:00:01"],
            "RECORD:3: `2026-11-23 10:00:01` in column `time`: only some",
        ),
        (
            ["11/12/2026 10:00:00", "11/12/2026 10:00:01"],
            "RECORD:2: `11/12/2026 10:00:00` in column `time` is not a date",
        ),
        (["10:00:00.1", "10:00:00.2"], "RECORD:2: `10:00:00.1` in column `time` is not a date with a time of day"),
        (["0", "1"], "RECORD:1: the column `time` has no unit in square brackets"),
    ] {
        let told = read(format!("time,p [bar]\n{},1\n{},2\n", times[0], times[1]).as_bytes()).unwrap_err();
        assert!(told.starts_with(&format!("error: {message}")), "{told}");
    }
}

/// Round brackets beside square ones may be part of a name: whoever reads them as a unit could be wrong.
#[test]
fn round_brackets_are_units_where_no_square_ones_are() {
    let record = right(b"time [s],p (A) [bar]\n0,1\n");
    assert_eq!((record.channels[0].name.as_str(), record.channels[0].values[0]), ("p (A)", 1e5));
    let record = right(b"time (ms),flow (raw) (L/min)\n5,60\n");
    assert_eq!((record.channels[0].name.as_str(), record.channels[0].values[0]), ("flow (raw)", 1e-3));
    assert_eq!(record.time, [0.005]);
    for (header, message) in [
        ("time [s],p (bar)", "the column `p (bar)` has no unit in square brackets\n  help: write `p [bar]`"),
        ("time (s),p (main)", "the column `p (main)` has no unit in square brackets"),
        ("time (bar),p (bar)", "column `time`: `bar` is a unit of pressure, not of time"),
    ] {
        let told = read(format!("{header}\n0,1\n").as_bytes()).unwrap_err();
        assert!(told.starts_with(&format!("error: RECORD:1: {message}")), "{told}");
    }
}

#[test]
fn latin_1_is_read_where_the_bytes_are_nothing_else() {
    let latin = right(b"time [s],T [\xB0C],x [\xB5m]\n0,40,1000\n");
    let plain = right("time [s],T [\u{b0}C],x [\u{b5}m]\n0,40,1000\n".as_bytes());
    assert_eq!((&latin.channels, &latin.time), (&plain.channels, &plain.time));
    assert_eq!(latin.origin.read_as, "CSV in Latin-1, columns between commas, decimal points");
    // The sign may come behind the first piece.
    let mut late = ("time [s],p [bar]\n".to_owned() + &"# x\n".repeat(300_000)).into_bytes();
    late.extend(b"# \xB0C\n0,1\n");
    assert_eq!(right(&late).time, [0.0]);
    // One character of each encoding, a control character, a sign that no file of Latin-1 has.
    for bytes in
        [&b"time [s],T [\xB0C]\n# \xC2\xB0\n0,1\n"[..], b"time [s],T [\xB0C]\n0,\x01\n", b"time [s],T [\x80C]\n0,1\n"]
    {
        let told = read(bytes).unwrap_err();
        assert!(told.contains("is not UTF-8 text"), "{told}");
    }
}

#[cfg(feature = "excel")]
#[test]
fn a_workbook_is_read_where_one_sheet_holds_anything() {
    let record = Record::read("fixtures/formats/dates.xlsx").unwrap();
    assert_eq!(record.time, [0.0, 0.004, 0.012]);
    let [p, temperature] = &record.channels[..] else { panic!("{:?}", record.channels) };
    assert_eq!((p.name.as_str(), &p.values[..]), ("p_A", &[1.5e5, 1.25e5, -0.5e5][..]));
    assert!(temperature.name == "T (oil)" && temperature.values[1].is_nan());
    let read_as = "Excel workbook, sheet `Data`, times counted from the first row, at 2026-11-23 12:00:00.000";
    assert_eq!(record.origin.read_as, read_as);
    let told = Record::read("fixtures/formats/two_sheets.xlsx").unwrap_err().to_string();
    assert!(told.contains("any of 2 sheets may be the record: `Data`, `Notes`"), "{told}");
    let whole = fs::read("fixtures/formats/stroke.xlsx").unwrap();
    for cut in [4, 100, whole.len() / 2, whole.len() - 1] {
        let message = read(&whole[..cut]).unwrap_err();
        assert!(message.starts_with("error: RECORD: the file is a ZIP archive or a workbook"), "{message}");
    }
    // No damage panics, wherever it is.
    for at in (4..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xFF;
        let _ = read(&bytes);
    }
}

/// What other programs wrote of one stroke reads as one record.
#[test]
fn files_of_other_programs_read_alike() {
    let read =
        |name: &str| Record::read(format!("fixtures/formats/{name}")).unwrap_or_else(|complaint| panic!("{complaint}"));
    let plain = read("stroke.csv");
    assert_eq!((plain.time.len(), plain.channels.len()), (250, 11));
    let mut names = vec!["stroke.csv.gz", "stroke.csv.zst", "stroke_german.csv", "stroke_units.tsv"];
    names.extend(["stroke_plain.mat", "stroke_struct.mat", "stroke.mf4", "stroke.tdms"]);
    if cfg!(feature = "parquet") {
        names.push("stroke.parquet");
    }
    if cfg!(feature = "excel") {
        names.push("stroke.xlsx");
    }
    if cfg!(feature = "hdf5") {
        names.extend(["stroke.h5", "stroke_frame.h5", "stroke_v73.mat"]);
    }
    for name in names {
        let other = read(name);
        assert_eq!(other.time, plain.time, "{name}");
        assert_eq!(other.channels.len(), plain.channels.len(), "{name}");
        // HDF5 keeps names in their own order.
        for plain in &plain.channels {
            let channel = other.channel(&plain.name).unwrap_or_else(|| panic!("{name}: {}", plain.name));
            assert_eq!((&channel.unit, &channel.values), (&plain.unit, &plain.values), "{name}: {}", plain.name);
        }
        assert!(!other.origin.is_plain(), "{name}");
    }
}

/// Groups of other rates, scaled integers, packed and transposed bytes: each sample at its own time, none in between.
#[test]
fn channels_of_other_rates_stay_at_their_times() {
    let plain = Record::read("fixtures/formats/stroke.csv").unwrap();
    // TDMS has multiples of an increment where the table has rounded decimals.
    let mut files = vec![("stroke_rates.mf4", "MDF 4", 0.0), ("stroke_rates.tdms", "TDMS", 1e-12)];
    if cfg!(feature = "hdf5") {
        files.push(("stroke_rates.h5", "MATLAB v7.3 or HDF5", 0.0));
    }
    for (file, format, apart) in files {
        let rates = Record::read(format!("fixtures/formats/{file}")).unwrap();
        assert_eq!((rates.time.len(), &rates.origin.read_as[..]), (plain.time.len(), format));
        for (time, plain) in rates.time.iter().zip(&plain.time) {
            approx::assert_relative_eq!(time, plain, epsilon = 0.0, max_relative = apart);
        }
        check_rates(&plain, &rates);
    }
}

fn check_rates(plain: &Record, rates: &Record) {
    for channel in &plain.channels {
        let other = rates.channel(&channel.name).unwrap();
        assert_eq!(other.unit, channel.unit);
        for (row, (value, other)) in channel.values.iter().zip(&other.values).enumerate() {
            if channel.name == "T_oil" && row % 25 != 0 {
                assert!(other.is_nan(), "row {row}");
            } else {
                // An integer times the step, against the rounded decimal.
                approx::assert_relative_eq!(value, other, max_relative = 1e-12, epsilon = 1e-12);
            }
        }
    }
    let gaps = rates.gaps();
    assert_eq!((gaps.len(), gaps[0].channel.as_str(), gaps[0].missing), (1, "T_oil", 240));
}

/// Blocks that lead back to themselves are no endless record.
#[test]
fn links_in_a_circle_are_told() {
    let mut bytes = fs::read("fixtures/formats/stroke.mf4").unwrap();
    for id in [b"##DL", b"##CG", b"##CN"] {
        let at = bytes.windows(4).position(|four| four == id).unwrap();
        bytes[at + 24..at + 32].copy_from_slice(&(at as u64).to_le_bytes());
        let message = read(&bytes).unwrap_err();
        assert!(
            message.starts_with("error: RECORD: the MDF 4 file is damaged: its blocks lead in a circle"),
            "{message}"
        );
    }
}

/// No damage panics, wherever it is, and none is read as if nothing were.
#[test]
fn damaged_binary_files_are_told() {
    let files = ["stroke_plain.mat", "stroke_struct.mat", "stroke.mf4", "stroke_rates.mf4"];
    for name in files.into_iter().chain(["stroke.tdms", "stroke_rates.tdms"]) {
        let whole = fs::read(format!("fixtures/formats/{name}")).unwrap();
        for cut in [20, 100, 130, whole.len() / 2] {
            let message = read(&whole[..cut]).unwrap_err();
            assert!(message.starts_with("error: RECORD: ") && message.contains("  help: "), "{name} {cut}: {message}");
        }
        for at in (16..whole.len()).step_by(13) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xFF;
            let _ = read(&bytes);
        }
    }
}

#[cfg(feature = "hdf5")]
mod hdf5 {
    use super::*;

    /// No damage panics, fills the memory or takes long, wherever it is.
    #[test]
    fn damaged_files_are_told() {
        for name in ["stroke.h5", "stroke_rates.h5", "stroke_frame.h5", "stroke_v73.mat"] {
            let whole = fs::read(format!("fixtures/formats/{name}")).unwrap();
            for cut in [20, 520, 1000, whole.len() / 2] {
                let message = read(&whole[..cut]).unwrap_err();
                let damaged = "error: RECORD: the MATLAB v7.3 or HDF5 file is damaged: ";
                assert!(message.starts_with(damaged) && message.contains("  help: "), "{name} {cut}: {message}");
            }
            for at in (8..whole.len()).step_by(13) {
                let mut bytes = whole.clone();
                bytes[at] ^= 0xFF;
                let _ = read(&bytes);
            }
        }
    }

    /// What is no series is left out with its reason, and the rest is read.
    #[test]
    fn what_is_no_series_is_left_out() {
        let record = Record::read("fixtures/formats/mixed.h5").unwrap();
        assert_eq!(record.channels.iter().map(|channel| &channel.name[..]).collect::<Vec<_>>(), ["on", "p_A"]);
        let left: Vec<String> = record.origin.left_out.iter().map(|(name, why)| format!("{name}: {why}")).collect();
        let mut left: Vec<&str> = left.iter().map(String::as_str).collect();
        left.sort_unstable();
        assert_eq!(
            left,
            [
                "alone.around: a group once more",
                "gain: one number",
                "image: no vector",
                "operator: text",
                "other: a cell array",
                "packed: packed in a way that is not read",
                "z: no time with it",
            ]
        );
    }

    /// A few bytes that stand for terabytes, and links that lead in a circle, cost nothing.
    #[test]
    fn large_promises_are_refused() {
        let message = Record::read("fixtures/formats/promise.h5").unwrap_err().to_string();
        assert!(message.contains("larger than"), "{message}");
    }
}

#[cfg(feature = "parquet")]
#[test]
fn a_damaged_parquet_file_is_told() {
    let whole = fs::read("fixtures/formats/stroke.parquet").unwrap();
    for cut in [4, 100, whole.len() - 1] {
        let message = read(&whole[..cut]).unwrap_err();
        assert!(message.starts_with("error: RECORD: the Parquet file cannot be read: "), "{message}");
    }
    // No damage panics, wherever it is.
    for at in (4..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xFF;
        let _ = read(&bytes);
    }
}

#[test]
fn a_file_too_large_is_refused_unread() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.toml");
    fs::File::create(&path).unwrap().set_len(1 << 33).unwrap();
    let shown = |arguments: [&str; 2]| borescope(arguments).err.replace(path.to_str().unwrap(), "FILE");
    let text = path.to_str().unwrap();
    let help = "\n  help: split it; no more is read, so that a wrong file cannot fill the memory\n";
    assert_eq!(shown(["check", text]), format!("error: FILE: the file is larger than 4 MiB{help}"));
    let complaint = Record::read(&path).unwrap_err();
    assert_eq!(complaint.what, "the file is larger than 1024 MiB");
    // Ten thousand lists within each other.
    fs::write(&path, format!("a = {}1{}", "[".repeat(10_000), "]".repeat(10_000))).unwrap();
    let told = shown(["check", text]);
    assert!(told.starts_with("error: FILE:1: this is not TOML: "), "{told}");
    // A packed file of zeros that would fill the memory.
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    let zeros = vec![0_u8; 1 << 24];
    for _ in 0..65 {
        packed.write_all(&zeros).unwrap();
    }
    assert!(read(&packed.finish().unwrap()).unwrap_err().contains("there is no line break in 1 MiB"));
}

#[test]
fn units_are_taken_from_names_where_the_time_has_its_own_there() {
    let record = right(b"t_s,p_S_bar,n_rpm,u_pct,T_oil_C,q_lpm,y_up\n0,1,60,50,20,6,1\n1,1,60,50,20,6,1\n");
    let read: Vec<(&str, f64)> = record.channels.iter().map(|one| (one.name.as_str(), one.values[0])).collect();
    let wanted = [("p_S", 1e5), ("n", 1.0), ("u", 0.5), ("T_oil", 293.15), ("q", 1e-4), ("y_up", 1.0)];
    for ((name, value), (wanted_name, wanted)) in read.into_iter().zip(wanted) {
        assert_eq!(name, wanted_name);
        assert!((value / wanted - 1.0).abs() < 1e-12, "{name}: {value}");
    }
    // Beside brackets a low line is part of the name.
    assert_eq!(right(b"time [s],p_bar [bar]\n0,1\n1,1\n").channels[0].name, "p_bar");
}
