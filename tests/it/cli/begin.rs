//! The verbs to begin with: `init` drafts a rig file that `check` passes, `example` writes one with records.

use std::fs;
use std::path::Path;

use crate::support::command::{Ran, borescope};

fn done(arguments: &[&str]) -> Ran {
    let ran = borescope(arguments);
    assert_eq!(ran.status, Some(0), "{arguments:?}: {}{}", ran.out, ran.err);
    ran
}

/// A draft of a record, which passes `check` alone and with the record.
fn drafted(record: &str, more: &[&str]) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    let rig = rig.to_str().unwrap();
    let ran = done(&[&["init", record, "-o", rig], more].concat());
    done(&["check", rig]);
    if !ran.out.contains("No column of the record") {
        done(&["check", rig, record]);
    }
    (fs::read_to_string(rig).unwrap(), ran.out)
}

#[test]
fn a_record_of_a_cylinder_gives_its_circuit() {
    let (text, out) = drafted("fixtures/telescopic/healthy_1.csv", &["--bore", "40mm", "--rod", "20 mm"]);
    for part in [
        "bore = \"40 mm\"\nrod = \"20 mm\"\n",
        "column = \"valve_command\"\n",
        "p_pump = { quantity = \"pressure\", at = \"pump_line\", noise = \"0.2",
        "q_B = { quantity = \"flow\", at = \"directional_valve.B\"",
        "x = { quantity = \"position\", at = \"piston\"",
        "A = {}  # starts at what its sensor shows first; a cycle without record needs { initial = \"",
        "# column T_oil [degC]: not used\n",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    for part in ["  p_A            pressure at port A\n", "  F_load         load\n", "  T_oil          not used\n"] {
        assert!(out.contains(part), "{part}\n{out}");
    }
    assert!(text.matches("# DATA SHEET").count() > 10);
}

#[test]
fn check_finds_the_columns_that_init_maps_and_names_what_is_left_to_fill_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (english, german, rig) = (path("english.csv"), path("german.csv"), path("rig.toml"));
    let rows: String =
        (0..40).map(|row| format!("0.{row:02},{},160,{},{},{row}\n", row % 2, 20 + row % 3, 10 + row)).collect();
    let header = |names: [&str; 3]| {
        format!("time [s],u [-],{} [bar],{} [bar],{} [bar],x [mm]\n{rows}", names[0], names[1], names[2])
    };
    fs::write(&english, header(["p_pump", "p_A", "p_B"])).unwrap();
    fs::write(&german, header(["Druck Pumpe", "Druck A", "Druck B"])).unwrap();
    let ran = done(&["init", &english, "-o", &rig]);
    let (open, _) = ran.out.split_once(" values are marked DATA SHEET").unwrap();
    let open = open.rsplit('\n').next().unwrap();
    let ran = done(&["init", &german, "-o", &path("other.toml")]);
    assert!(ran.out.contains("  Druck Pumpe  pressure at the pump line\n"), "{}", ran.out);
    let ran = borescope(["check", rig.as_str(), &german]);
    for name in ["Druck Pumpe", "Druck A", "Druck B"] {
        assert!(ran.out.contains(&format!("column = \"{name}\"")), "{}", ran.out);
    }
    // The line of each is named while its mark stands.
    let text = fs::read_to_string(&rig).unwrap();
    let line = 1 + text.lines().position(|line| line.contains("= \"870 kg/m3\"  # DATA SHEET")).unwrap();
    let told = done(&["check", &rig, &english]).out;
    assert!(told.contains(&format!("{open} values are still marked DATA SHEET (lines {line}, ")), "{told}");
    // Nothing is sought in a draft without faults.
    fs::write(&rig, &text[..text.find("\n[faults]").unwrap()]).unwrap();
    for verb in ["compare", "suggest", "diagnose"] {
        let told = done(&[verb, &rig, &english]).out;
        assert!(told.contains(&format!("{open} values of the rig file are still marked DATA SHEET")), "{verb}: {told}");
        assert!(told.contains(&format!("\nNext: borescope check {rig} {english}\n")), "{verb}: {told}");
    }
    fs::write(&rig, text.replace("# DATA SHEET", "#")).unwrap();
    assert!(!done(&["check", &rig, &english]).out.contains("DATA SHEET"));
}

/// Off, one solenoid, off, the other.
#[test]
fn two_columns_that_switch_a_solenoid_each_give_a_valve_with_two_solenoids() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("press.csv");
    let rows: String = (0..40)
        .map(|row| {
            let (out, back) = ((10..20).contains(&row), (30..40).contains(&row));
            format!("{}.0,{},{},{},5,{}\n", row, 24 * u8::from(back), 24 * u8::from(out), 20 + row % 3, 10 + row)
        })
        .collect();
    fs::write(&record, format!("time [s],Y1 b [V],Y2 a [V],p_A [bar],p_B [bar],x [mm]\n{rows}")).unwrap();
    let (text, out) = drafted(record.to_str().unwrap(), &[]);
    for part in [
        "kind = \"catalogue:solenoid-valve\"",
        "[inputs.solenoid_a]\nunit = \"-\"\ncolumn = \"Y2 a\"\nscale = \"0.0417/V\"",
        "[inputs.solenoid_b]\nunit = \"-\"\ncolumn = \"Y1 b\"\n",
        "\"directional_valve.leakage\" = ",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(out.contains("  Y2 a  solenoid a: P to A and B to T\n") && !out.contains("No column"), "{out}");
    // The user knows better.
    let (text, _) = drafted(record.to_str().unwrap(), &["--command", "Y1 b"]);
    assert!(text.contains("kind = \"directional-valve\"") && text.contains("# column Y2 a [V]: not used"), "{text}");
}

#[test]
fn levels_give_tanks() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("tanks.csv");
    fs::write(&record, "time (s);pump (V);level \"1\" (mm);Level 2 (mm)\n0;1,5;10;5\n1;1,5;11;5\n2;1,5;12,5;6\n")
        .unwrap();
    let (text, out) = drafted(record.to_str().unwrap(), &[]);
    assert!(text.contains("at = \"tank_2\", column = \"Level 2\"") && text.contains("column = \"pump\"\n"), "{text}");
    assert!(out.contains("level of tank_2"), "{out}");
    let (text, _) = drafted(record.to_str().unwrap(), &["--circuit", "cylinder"]);
    assert!(text.contains("scale = \"0.667/V\"") && text.contains("quantity = \"position\""), "{text}");
}

/// Whatever the columns are called, and however few they are.
#[test]
fn every_record_gives_a_draft_that_passes() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("record.csv");
    for header in [
        "time [s],p [bar]",
        "time [s],\"p.A #1, \"\"x\"\"\" [Pa]",
        "time [ms],\u{538b}\u{529b} A [MPa],\u{538b}\u{529b} B [MPa],v [mm/s],F [kN],u [-]",
        "time [s],p A [bar],p_A [bar],P-A [psi],Q [L/min],q_P [L/min],T [\u{b0}C],i [A]",
        "timestamp,x_piston [mm],pA [bar]",
    ] {
        let columns = header.replace("\"\"x\"\"", "").replace(", ", " ").matches(',').count();
        let row = |time: &str, value: &str| format!("{time}{}\n", format!(",{value}").repeat(columns));
        let times =
            if header.starts_with("timestamp") { ["2026-11-23 10:00:00", "2026-11-23 10:00:01"] } else { ["0", "1"] };
        fs::write(&record, format!("{header}\n{}{}", row(times[0], "1.5"), row(times[1], ""))).unwrap();
        drafted(record.to_str().unwrap(), &[]);
        drafted(record.to_str().unwrap(), &["--circuit", "reservoirs"]);
    }
}

#[test]
fn what_is_no_command_or_no_length_is_refused() {
    let record = "fixtures/telescopic/healthy_1.csv";
    for (more, message) in [
        (["--command", "p_A"], "the column `p_A` is a pressure, and no command"),
        (["--command", "valve"], "the record has no column `valve`"),
        (["--load", "p_A"], "column `p_A`: `bar` is a unit of pressure, not of force"),
        (["--bore", "40"], "`--bore 40`: `40` has no unit"),
        (["--bore", "-4 mm"], "outside its physical bounds"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("rig.toml");
        let more = [format!("{}={}", more[0], more[1])];
        let ran = borescope(
            [&["init".to_owned(), record.to_owned(), "-o".to_owned(), out.display().to_string()], &more[..]].concat(),
        );
        assert!(ran.status == Some(2) && ran.err.contains(message) && !out.exists(), "{message}: {}", ran.err);
    }
}

#[test]
fn the_example_can_be_checked_and_diagnosed() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join("new/press").join(name).display().to_string();
    let ran = done(&["example", &path("")]);
    assert!(ran.out.contains("rig.toml: a press\n") && ran.out.contains("\nNext: borescope check "), "{}", ran.out);
    done(&["check", &path("rig.toml"), &path("healthy.csv")]);
    let page: serde_json::Value =
        serde_json::from_str(&done(&["diagnose", &path("rig.toml"), &path("leak.csv"), "--format", "json"]).out)
            .unwrap();
    assert_eq!((&page["verdict"], &page["faults"][1]["id"]), (&"faulty".into(), &"cylinder.clearance".into()));
    assert!((page["faults"][1]["value"].as_f64().unwrap() - 0.15).abs() < 0.01, "{}", page["faults"]);
    drafted(&path("healthy.csv"), &[]);
}

#[test]
fn nothing_is_overwritten_unless_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let record = "fixtures/telescopic/healthy_1.csv";
    fs::write(path("rig.toml"), "mine").unwrap();
    for arguments in [vec!["init", record, "-o", &path("rig.toml")], vec!["example", &path("")]] {
        let ran = borescope(&arguments);
        assert!(ran.status == Some(2) && ran.err.contains("there is such a file already"), "{}", ran.err);
        assert_eq!(fs::read_to_string(path("rig.toml")).unwrap(), "mine");
        assert!(!Path::new(&path("healthy.csv")).exists());
        done(&[arguments, vec!["--force"]].concat());
        assert_ne!(fs::read_to_string(path("rig.toml")).unwrap(), "mine");
        fs::write(path("rig.toml"), "mine").unwrap();
    }
}
