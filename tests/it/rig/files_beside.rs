//! Files that a rig file names: included components, tables of formulas; written elsewhere, in digests, and every mistake.

use std::fs;
use std::path::Path;

use borescope::internals::campaign::CampaignOptions;
use borescope::internals::campaign::store::digest;
use borescope::internals::rig::Rig;

use crate::support::command::borescope;

const FILTER: &str = "fixtures/own_filter/rig.toml";

/// The rig with the filter in an included file and a throttle whose opening is a table, in `folder/rig`.
fn apart(folder: &Path) -> std::path::PathBuf {
    let rig = folder.join("rig");
    fs::create_dir_all(rig.join("parts")).unwrap();
    let text = fs::read_to_string(FILTER).unwrap();
    let (head, rest) = text.split_once("[own_components.filter]").unwrap();
    let (own, rest) = rest.split_once("[nodes]").unwrap();
    fs::write(rig.join("parts/filter.toml"), format!("[own_components.filter]{own}")).unwrap();
    let table = "[own_components.damper]\nports = { in = \"hydraulic\", out = \"hydraulic\" }\ntables.line = \"parts/line.csv\"\nparameters.share = { unit = \"-\", \
                 default = 1 }\nflow = { from = \"in\", to = \"out\", formula = \"share * line(in.p - out.p)\" }\n";
    fs::write(rig.join("parts/line.csv"), "drop [bar],flow [L/min]\n-10,-1\n0,0\n10,1\n").unwrap();
    let rest = rest.replace(
        "\n[inputs.u]",
        "damper = { kind = \"own:damper\", ports = { in = \"clean\", out = \"tank\" } }\n\n[inputs.u]",
    );
    let path = rig.join("rig.toml");
    fs::write(&path, format!("include = [\"parts/filter.toml\"]\n{head}{table}[nodes]{rest}")).unwrap();
    path
}

#[test]
fn a_rig_file_written_elsewhere_names_its_files_from_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = apart(folder.path());
    fs::create_dir(folder.path().join("new")).unwrap();
    for (output, include) in [("new/better.toml", "../rig/parts/filter.toml"), ("rig/better.toml", "parts/filter.toml")]
    {
        let output = folder.path().join(output);
        let names = ["add", path.to_str().unwrap(), "external-leakage@clean", "-o", output.to_str().unwrap()];
        let ran = borescope(names);
        assert_eq!(ran.status, Some(0), "{}", ran.err);
        let text = fs::read_to_string(&output).unwrap();
        assert!(text.contains(&format!("include = [\"{include}\"]")), "{text}");
        assert!(text.contains(&include.replace("filter.toml", "line.csv")), "{text}");
        assert_eq!(Rig::read(&output).unwrap().effects.len(), 1);
    }
    // What is calibrated reads from another folder too.
    let record = folder.path().join("healthy.csv");
    let (rig, record) = (path.to_str().unwrap(), record.to_str().unwrap());
    assert_eq!(borescope(["simulate", rig, "--seed", "1", "-o", record]).status, Some(0));
    let output = folder.path().join("new/calibrated.toml");
    let ran = borescope(["calibrate", rig, record, "-o", output.to_str().unwrap()]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    assert!(Rig::read(&output).unwrap().calibration.is_some());
}

#[test]
fn the_digest_of_a_campaign_covers_the_files_that_the_rig_file_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = apart(folder.path());
    let now = || digest(&CampaignOptions::new(10), &Rig::read(&path).unwrap());
    let before = now();
    assert_eq!(before, now());
    for file in ["filter.toml", "line.csv"] {
        let file = path.parent().unwrap().join("parts").join(file);
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, format!("# changed\n{text}")).unwrap();
        assert_ne!(before, now(), "{}", file.display());
        fs::write(&file, text).unwrap();
        assert_eq!(before, now());
    }
}

#[test]
fn a_table_that_does_not_fit_is_complained_about_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = apart(folder.path());
    let table = path.parent().unwrap().join("parts/line.csv");
    for (text, pieces) in [
        ("drop [bar],flow [L/min]\n0,0\n0,1\n", &["`drop` does not grow from row 1", "sort the rows"][..]),
        ("drop [bar],flow [L/min]\n0,0\n", &["fewer than two values"]),
        ("drop [bar],flow [L/min]\n0,0\n1\n", &["line.csv:3", "1 fields, the heading 2"]),
        ("drop [bar],flow [L/min]\n0,0\n1,x\n", &["line.csv:3", "`x` is no number"]),
        ("drop [bra],flow [L/min]\n0,0\n1,1\n", &["line.csv:1", "bra"]),
        ("drop [mm],flow [L/min]\n0,0\n1,1\n", &["rig.toml:", "the table `line` is over length, not pressure"]),
        ("drop [bar],flow [mm]\n0,0\n1,1\n", &["rig.toml:", "the formula gives length", "not flow"]),
        ("drop [bar]\n0\n1\n", &["line.csv:1", "2 are needed"]),
        ("drop [bar],the flow [L/min]\n0,0\n1,1\n", &["`the flow` cannot be named"]),
        ("drop [bar],flow [L/min],loss [W]\n0,0,0\n1,1,1\n", &["unknown function `line`", "line.flow"]),
        ("", &["the table is empty"]),
    ] {
        fs::write(&table, text).unwrap();
        let message = Rig::read(&path).unwrap_err().with_lines();
        for piece in pieces {
            assert!(message.contains(piece), "{text}\n{message}\nlacks: {piece}");
        }
        assert!(message.contains("help:"), "{message}");
    }
    fs::remove_file(&table).unwrap();
    assert!(Rig::read(&path).unwrap_err().with_lines().contains("rig.toml:"));
}

#[test]
fn a_table_over_two_columns_is_a_grid() {
    let folder = tempfile::tempdir().unwrap();
    let path = apart(folder.path());
    let change = |from: &str, to: &str| {
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from));
        fs::write(&path, text.replace(from, to)).unwrap();
    };
    change("\"parts/line.csv\"", "{ file = \"parts/line.csv\", over = 2 }");
    change("line(in.p - out.p)", "line(in.p - out.p, in.p)");
    let table = path.parent().unwrap().join("parts/line.csv");
    fs::write(&table, "drop [bar],at [bar],flow [L/min]\n0,0,0\n0,10,0\n10,0,1\n10,10,2\n").unwrap();
    Rig::read(&path).unwrap();
    fs::write(&table, "drop [bar],at [bar],flow [L/min]\n0,0,0\n0,10,0\n10,0,1\n").unwrap();
    assert!(Rig::read(&path).unwrap_err().with_lines().contains("no grid of `drop` and `at`"));
}

#[test]
fn more_states_than_a_component_has_room_for_are_refused() {
    let ports = "ports = { a = \"body\", b = \"body\", c = \"hydraulic\", d = \"hydraulic\" }";
    let state = |name: &str| format!("states.{name} = {{ unit = \"-\", rate = \"(1 - {name}) / [1 s]\" }}\n");
    let own = format!(
        "[own_components.wide]\n{ports}\n{}{}flow = {{ from = \"c\", to = \"d\", formula = \"(p + q) * [1 L/min]\" }}\n",
        state("p"),
        state("q")
    );
    let text = fs::read_to_string(FILTER).unwrap().replace("[nodes]\n", &format!("{own}[nodes]\n"));
    let message = Rig::parse(FILTER, text).unwrap_err().with_lines();
    assert!(message.contains("more than 7 variables of ports and states"), "{message}");
}
