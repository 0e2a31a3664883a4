//! Records through `check`: what is refused with which message, what is accepted, what is doubted.

use crate::support::command;

use std::fs;

use command::{Ran, borescope};

const RIG: &str = "fixtures/two_tanks/rig.toml";

/// Forty rows of the two tanks, levels that rise and shake.
fn right() -> String {
    let row =
        |k: i32| format!("{k},{},{}.{},{}.5\n", if k < 20 { 1 } else { 2 }, 3 * k + k % 3, k % 10, k + 2 * (k % 2));
    let rows: String = (0..40).map(row).collect();
    format!("time [s],u [V],level_1 [mm],level_2 [mm]\n{rows}")
}

/// `check` of this record, the paths in its messages replaced.
fn check(record: &[u8]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    fs::write(&path, record).unwrap();
    let mut ran = borescope(["check", RIG, path.to_str().unwrap(), "--all"]);
    ran.err = ran.err.replace(path.to_str().unwrap(), "RECORD").replace(RIG, "RIG");
    ran
}

#[test]
fn a_wrong_record_gives_its_message() {
    let right = right();
    let cases = [
        (
            right.replace("level_2 [mm]", "Level_2 [mm]"),
            "error: RIG:54 and RECORD:1: the record has no column `level_2`\n  help: did you mean `Level_2`? Known columns: \
             `u`, `level_1`, `Level_2`\n",
        ),
        (
            right.replace("u [V]", "v [V]"),
            "error: RIG:48 and RECORD:1: the record has no column `u`\n  help: did you mean `v`? Known columns: `v`, `level_1`, `level_2`\n",
        ),
        (
            right.replace("level_1 [mm]", "level_1 [bar]"),
            "error: RIG:53 and RECORD:1: column `level_1`: `bar` is a unit of pressure, not of length\n  help: units of \
             length: `mm`, `um`, `cm`, `m`, `km`, `mm2/mm`\n",
        ),
        (
            right.replace("level_1 [mm]", "level_1"),
            "error: RECORD:1: the column `level_1` has no unit in square brackets\n  help: write its unit behind the name, \
             such as `level_1 [bar]`; `level_1 [-]` for a pure number\n",
        ),
        (
            right.replace("\n7,1,", "\n5,1,"),
            "error: RECORD:8 and RECORD:9: the time runs backwards to 5 s\n  help: the time rises from row to row; sort \
             the rows, remove those that repeat, or split the record where the clock was set\n",
        ),
        (
            right[..right.len() - 8].to_owned(),
            "error: RECORD:41: the file ends in the middle of a row: 3 fields of 4\n  help: the writing broke off; remove \
             the last line, or copy the file again\n",
        ),
        (
            right.lines().take(2).collect::<Vec<_>>().join("\n") + "\n",
            "error: RECORD:1: the record has fewer than two rows, so no interval between rows\n  help: take a record of at \
             least two rows\n",
        ),
    ];
    for (record, message) in cases {
        let ran = check(record.as_bytes());
        let lines: Vec<&str> = ran.err.split_inclusive('\n').collect();
        let (told, shown) = lines.split_at(2.min(lines.len()));
        assert_eq!((ran.status, told.concat().as_str()), (Some(2), message));
        assert!(
            shown.last().is_none_or(|carets| carets.trim_start_matches([' ', '|']).starts_with('^')),
            "{}",
            ran.err
        );
        // A record that can be surveyed is, before it is refused.
        assert!(ran.out.is_empty() || ran.out.contains("\nwarnings: "), "{}", ran.out);
    }
    let ran = borescope(["check", RIG, "nowhere.csv"]);
    assert_eq!(ran.status, Some(2));
    assert!(ran.err.starts_with("error: nowhere.csv: there is no such file\n"), "{}", ran.err);
}

#[test]
fn a_value_that_is_missing_is_told() {
    for field in ["NaN", ""] {
        let ran = check(right().replace("\n7,1,", &format!("\n7,{field},")).as_bytes());
        assert_eq!(ran.status, Some(0), "{}", ran.err);
        assert!(ran.out.contains("`u` has no value in 1 row at 7 s"), "{}", ran.out);
    }
}

#[test]
fn what_loggers_write_is_accepted() {
    let right = right();
    let with_commas = right.replace(',', ";").replace('.', ",");
    let with_mark = format!("\u{FEFF}{right}");
    let with_returns = right.replace('\n', "\r\n");
    let page = check(right.as_bytes()).out;
    assert!(page.contains("warnings: 0"), "{page}");
    for record in [with_commas, with_mark, with_returns] {
        let ran = check(record.as_bytes());
        assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""), "{record}");
        // The next command names the file.
        let below = |page: &str| {
            let (_, below) = page.split_once("\n\ncolumns").unwrap();
            below.split_once("\nNext: ").unwrap().0.to_owned()
        };
        assert_eq!(below(&ran.out), below(&page));
    }
}

#[test]
fn the_page_tells_phases_ranges_and_doubts() {
    let page = check(right().as_bytes()).out;
    for line in [
        "40 rows from 0 s to 39 s, 39 s in all, one every 1 s",
        "phases between jumps of the inputs: 2",
        "  0 s to 20 s   u = 1 V",
        "  20 s to 39 s  u = 2 V",
        "  level_1  sensor  from 0 to 117.9 mm",
        "  upper_outlet.diameter",
    ] {
        assert!(page.contains(line), "{line}\n{page}");
    }
    let stuck: String = right()
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((row, last)) if !last.contains('[') => format!("{row},7\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    assert!(
        check(stuck.as_bytes()).out.replace("\n    ", " ").contains(
            "  `level_2` stays at 7 mm in all 40 rows, which the noise that the rig file gives it would not allow: a dead sensor\n"
        )
    );
    let clipped: String = right()
        .lines()
        .map(|line| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            if fields[2].parse::<f64>().is_ok_and(|level| level > 80.0) {
                fields[2] = "80.0".to_owned();
            }
            fields.join(",") + "\n"
        })
        .collect();
    let page = check(clipped.as_bytes()).out;
    assert!(page.contains("  `level_1` may be saturated: it rests at its extreme value 80 mm from "), "{page}");
    let gap = right().replace("\n7,1,", "\n7.4,1,");
    let page = check(gap.as_bytes()).out;
    assert!(page.contains("  the sampling is irregular: intervals from 0.6 s to 1.4 s, mostly 1 s\n"), "{page}");
}

#[test]
fn columns_of_other_names_are_proposed() {
    let record =
        right().replace("level_1 [mm]", "Level 1 [cm]").replace("level_2 [mm]", "L2 [cm]").replace("u [V]", "pump [V]");
    let ran = check(record.as_bytes());
    assert_eq!(ran.status, Some(2));
    for line in [
        "columns that are missing, with what the rig file may say: 3",
        "  level_1  sensor  column = \"Level 1\"",
        "  level_2  sensor  column = \"L2\"  (the only one of its unit)",
        "  u        input   column = \"pump\"  (the only one of its unit)",
    ] {
        assert!(ran.out.contains(line), "{line}\n{}", ran.out);
    }
}

#[test]
fn a_damaged_record_is_surveyed_as_a_whole() {
    let damaged = right().replace("\n7,1,", "\n5,1,").replace("\n20,2,", "\n20,,").replace("\n30,2,", "\n30,NaN,");
    let ran = check(damaged.as_bytes());
    assert_eq!(ran.status, Some(2));
    assert!(ran.err.starts_with("error: RECORD:8 and RECORD:9: the time runs backwards to 5 s\n"), "{}", ran.err);
    for line in [
        "  the clock was set back from 6 s to 5 s",
        "  `u` has no value in 1 row at 20 s",
        "  `u` has no value in 1 row at 30 s",
    ] {
        assert!(ran.out.contains(line), "{line}\n{}", ran.out);
    }
}

/// The lines below the warnings of a check of the telescopic circuit, its rig file and healthy record changed.
fn doubts(rig: impl Fn(&str) -> String, record: impl Fn(&str) -> String) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["rig.toml", "record.csv"].map(|name| folder.path().join(name));
    fs::write(&paths[0], rig(include_str!("../../../fixtures/telescopic/rig.toml"))).unwrap();
    fs::write(&paths[1], record(include_str!("../../../fixtures/telescopic/healthy_1.csv"))).unwrap();
    let [rig, record] = paths.each_ref().map(|path| path.to_str().unwrap());
    let ran = borescope(["check", rig, record]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    let page = ran.out.replace(rig, "RIG");
    let told = page.split_once("\nwarnings: ").unwrap().1.replace("\n    ", " ");
    told.lines().filter_map(|line| line.strip_prefix("  ")).map(str::to_owned).collect()
}

#[test]
fn the_healthy_model_asks_about_exchanged_columns_and_other_units() {
    let same = |text: &str| text.to_owned();
    let right = doubts(same, same);
    assert!(right.is_empty(), "{right:?}");
    let exchanged = |text: &str| text.replacen("p_A", "p_C", 1).replacen("p_B", "p_A", 1).replacen("p_C", "p_B", 1);
    assert_eq!(
        doubts(same, exchanged),
        ["`p_A` shows what the healthy model says of `p_B`, and `p_B` that of `p_A`: are the two columns exchanged?"]
    );
    // Of readings that are alike, and with the numbers of another quantity.
    for (a, b) in [("q_A [L/min]", "q_B [L/min]"), ("p_A [bar]", "x [mm]")] {
        let told = doubts(same, |text| text.replacen(a, "@", 1).replacen(b, a, 1).replacen('@', b, 1));
        let [a, b] = [a, b].map(|column| column.split_once(' ').unwrap().0);
        let asked = |one: &String| one.contains("are the two columns exchanged?") && one.contains(a) && one.contains(b);
        assert!(told.iter().any(asked), "{a} {b}: {told:?}");
    }
    let told = doubts(same, |text| text.replacen("q_A [L/min]", "q_A [L/s]", 1));
    assert!(told.len() == 1 && told[0].starts_with("`q_A` reads 60") && told[0].ends_with("is its column in L/min?"));
    // Several readings are off at once where a value of the rig file is.
    let told = doubts(|text| text.replacen("bore = \"40 mm\"", "bore = \"40 cm\"", 1), same);
    assert!(told.len() == 1 && told[0].contains("`cylinder.bore` at 4 cm instead of 40 cm (RIG:"), "{told:?}");
    let told = doubts(|text| text.replacen("\"1000 rev/min\"", "\"1000 rev/s\"", 1), same);
    assert!(told.len() == 1 && told[0].contains("`pump.speed` at 16.67 rev/s instead of 1000 rev/s"), "{told:?}");
}

#[test]
fn a_rig_file_that_says_two_things_or_an_unusual_one_is_asked_about() {
    let same = |text: &str| text.to_owned();
    let told = doubts(|text| text.replacen("set_pressure = \"100 bar ", "set_pressure = \"100.5 bar ", 1), same);
    assert_eq!(
        told,
        [
            "`relief.set_pressure` is 100.5 bar (RIG:40) and as a fault 100 bar when healthy (RIG:128): `simulate` takes the \
          first, `diagnose` the second; leave `healthy` out, or write the same value"
        ]
    );
    let told = doubts(|text| text.replacen("45.5 mPa.s", "45.5 Pa.s", 1), same);
    assert_eq!(
        told,
        ["`fluid.viscosity` is 45500 mPa.s (RIG:10), where 0.3 to 5000 mPa.s is usual: is its unit right?"]
    );
}

/// Rows in the order of another column: the model has no way through them, and none is looked for.
#[test]
fn a_time_that_ends_before_it_begins_is_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let rig = fs::read_to_string(RIG).unwrap();
    // An input with noise is smoothed over the time.
    let noisy = rig.replacen("[inputs.u]\nunit = \"V\"", "[inputs.u]\nunit = \"V\"\nnoise = \"0.01 V\"", 1);
    assert_ne!(noisy, rig);
    fs::write(path("rig.toml"), noisy).unwrap();
    let mut rows: Vec<String> = (0..400).map(|row| format!("{row},{},1,2\n", 1 + row % 3)).collect();
    rows.rotate_left(200);
    fs::write(path("record.csv"), format!("time [s],u [V],level_1 [cm],level_2 [cm]\n{}", rows.concat())).unwrap();
    let ran = borescope(["check", &path("rig.toml"), &path("record.csv")]);
    assert_eq!(ran.status, Some(2), "{}", ran.err);
    assert!(ran.err.contains("the time runs backwards to 0 s"), "{}", ran.err);
    assert!(ran.out.contains("the clock was set back from 399 s to 0 s"), "{}", ran.out);
}
