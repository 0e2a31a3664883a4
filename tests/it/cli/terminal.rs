//! What a terminal gets and a pipe does not; help, completions and manual.

use crate::support::command;

use std::fs;
use std::path::Path;
use std::process::Command;

use command::borescope;

const RIG: &str = "fixtures/two_tanks/rig.toml";
const SHELLS: [&str; 3] = ["bash", "zsh", "fish"];

/// The names of all verbs, as `--help` lists them.
fn verbs() -> Vec<String> {
    let help = borescope(["--help"]).out;
    let (groups, _) = help.split_once("\nOptions:\n").unwrap();
    let (_, groups) = groups.split_once("\n\nBegin:\n").unwrap();
    let is_verb = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    let name = |line: &str| line.split_whitespace().next().unwrap().to_owned();
    let verbs: Vec<String> = groups.lines().filter(is_verb).map(name).collect();
    assert!(verbs.len() > 10, "{help}");
    verbs.into_iter().filter(|verb| verb != "help").collect()
}

/// A record of the two tanks in `folder`, in the dialect of a spreadsheet, so that reading it leaves a note.
fn record(folder: &Path) -> String {
    let (plain, other) = (folder.join("plain.csv"), folder.join("record.csv"));
    let ran = borescope(["simulate", RIG, "--seed", "1", "-o", plain.to_str().unwrap()]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    fs::write(&other, fs::read_to_string(&plain).unwrap().replace(',', ";")).unwrap();
    other.to_str().unwrap().to_owned()
}

/// Runs a command line on a terminal of its own, which `script` makes.
fn on_a_terminal(line: &str, environment: &[(&str, &str)]) -> String {
    let line = line.replacen("borescope", env!("CARGO_BIN_EXE_borescope"), 1);
    let mut command = Command::new("script");
    command.args(["-qec", &line, "/dev/null"]).env_remove("NO_COLOR").env("TERM", "xterm");
    command.envs(environment.iter().copied());
    let output = command.output().expect("no `script` here (Debian: apt-get install bsdutils)");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_verb_shows_an_example_of_itself() {
    for verb in verbs() {
        let ran = borescope([verb.as_str(), "--help"]);
        assert_eq!(ran.status, Some(0), "{verb}");
        let example = ran.out.lines().any(|line| line.starts_with(&format!("  borescope {verb} ")));
        assert!(ran.out.contains("\nExample") && example, "{verb}: {}", ran.out);
        assert!(ran.out.contains("--quiet"), "{verb}");
    }
}

#[test]
fn help_has_every_verb_in_a_group_and_fits_a_terminal() {
    let help = borescope(["--help"]).out;
    assert!(help.contains("Start here: borescope example DIR"), "{help}");
    let page = borescope(["completions", "fish"]).out;
    for name in verbs() {
        assert!(page.contains(&format!("-a \"{name}\"")), "{name}");
    }
    let of_completions = page.lines().filter(|line| line.contains("__fish_borescope_needs_command\" -f -a"));
    let names: Vec<&str> =
        of_completions.map(|line| line.split("-f -a \"").nth(1).unwrap().split('"').next().unwrap()).collect();
    for name in names.into_iter().filter(|name| *name != "help") {
        assert!(verbs().contains(&name.to_owned()), "{name} is in no group");
    }
    for verb in verbs().iter().map(|verb| vec![verb.as_str(), "--help"]).chain([vec!["--help"]]) {
        let out = borescope(&verb).out;
        // What is to be typed stays in one line.
        let is_wide = |line: &&str| line.chars().count() > 80 && !line.starts_with("Usage: ");
        let wide: Vec<&str> = out.lines().filter(is_wide).collect();
        assert!(wide.is_empty(), "{verb:?}: {wide:#?}");
    }
}

#[test]
fn lists_and_full_texts_fit_a_terminal() {
    let calls: [&[&str]; 5] = [
        &["effects"],
        &["components"],
        &["effects", "seal-friction"],
        &["components", "cylinder"],
        &["isolability", "fixtures/telescopic/rig.toml"],
    ];
    for call in calls {
        let out = borescope(call).out;
        let wide: Vec<&str> = out.lines().filter(|line| line.chars().count() > 80).collect();
        assert!(wide.is_empty(), "{call:?}: {wide:#?}");
    }
    // Each name once, and a name that is none leads to those that have the word.
    let out = borescope(["effects"]).out;
    let names = out.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   ")).skip(1);
    let names: Vec<&str> = names.map(|line| line.split_whitespace().next().unwrap()).collect();
    assert!(names.is_sorted() && names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
    let told = borescope(["effects", "friction"]).err;
    assert!(told.contains("`seal-friction`") && told.contains("`viscous-friction`"), "{told}");
}

#[test]
fn completions_know_every_verb() {
    for shell in SHELLS {
        let ran = borescope(["completions", shell]);
        assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""), "{shell}");
        for verb in verbs() {
            assert!(ran.out.contains(&verb), "{shell}: {verb}");
        }
    }
}

#[test]
fn every_verb_has_a_page_in_the_manual() {
    let folder = tempfile::tempdir().unwrap();
    let ran = borescope(["man", folder.path().join("man1").to_str().unwrap()]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    for name in std::iter::once("borescope".to_owned()).chain(verbs().iter().map(|verb| format!("borescope-{verb}"))) {
        let page = fs::read_to_string(folder.path().join("man1").join(format!("{name}.1"))).unwrap();
        assert!(page.contains(&format!(".TH {name} 1")), "{name}: {page}");
        assert!(page.contains(".SH SYNOPSIS"), "{name}");
    }
}

#[test]
fn quiet_leaves_nothing_on_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    let record = record(folder.path());
    let loud = borescope(["compare", RIG, &record]);
    assert_eq!(loud.status, Some(0));
    assert!(loud.err.starts_with("note: ") && loud.err.contains("read as"), "{}", loud.err);
    for arguments in [["--quiet", "compare", RIG, &record], ["compare", RIG, &record, "-q"]] {
        let quiet = borescope(arguments);
        assert_eq!((quiet.status, quiet.err.as_str()), (Some(0), ""));
        assert_eq!(quiet.out, loud.out);
    }
    let wrong = borescope(["-q", "compare", RIG, "missing.csv"]);
    assert!(wrong.status == Some(2) && wrong.err.contains("missing.csv"), "{}", wrong.err);
}

#[test]
fn colour_pictures_and_progress_are_for_terminals_only() {
    let folder = tempfile::tempdir().unwrap();
    let record = record(folder.path());
    let line = format!("borescope diagnose {RIG} {record} --all");
    let piped = borescope(["diagnose", RIG, &record]);
    assert_eq!(piped.status, Some(0), "{}", piped.err);
    assert!(piped.out.lines().count() <= 15, "{}", piped.out);
    assert!(piped.out.lines().all(|line| line.starts_with("Next: ") || line.chars().count() <= 80), "{}", piped.out);
    assert!(!piped.out.contains('\u{1b}') && !piped.out.contains('●') && !piped.err.contains('\u{1b}'));
    let wide = format!("stty rows 40 cols 160; {line}");
    let shown = on_a_terminal(&wide, &[]);
    assert!(shown.contains("\u{1b}[1;32mHEALTHY"), "{shown}");
    assert!(shown.contains('●') && shown.contains("within bounds") && shown.contains("misfit over time"), "{shown}");
    assert!(shown.contains("intervals of the faults: ") && shown.contains(" s left"), "{shown}");
    let narrow = on_a_terminal(&wide.replace("cols 160", "cols 60"), &[]);
    assert!(!narrow.contains("within bounds"), "{narrow}");
    let plain = on_a_terminal(&wide, &[("NO_COLOR", "1")]);
    assert!(!plain.contains("\u{1b}[1;") && plain.contains("HEALTHY"), "{plain}");
    let quiet = on_a_terminal(&format!("{wide} --quiet"), &[]);
    assert!(!quiet.contains("intervals of the faults") && !quiet.contains("note: "), "{quiet}");
}
