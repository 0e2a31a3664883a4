//! Each wrong rig file gives one message: the line, what is wrong, what would be right.
//!
//! A case of `rig_wrong/cases.txt` takes the text behind `-` out of the right rig file, puts that behind `+` in its
//! place, and states the message. `BLESS=1` writes the messages.

use crate::support::{command, page};

use std::fs;

use command::borescope;

const RIGHT: &str = include_str!("rig_wrong/right.toml");
const CASES: &str = include_str!("rig_wrong/cases.txt");

struct Case {
    /// The lines behind `-` and `+`.
    change: String,
    from: String,
    to: String,
    /// `RIG` in the place of the path.
    message: String,
}

fn cases() -> Vec<Case> {
    let part = |block: &str, mark: &str| {
        let lines = block.lines().filter_map(|line| line.strip_prefix(mark)).map(|line| line.get(1..).unwrap_or(""));
        lines.collect::<Vec<_>>().join("\n")
    };
    let message = |block: &str| {
        let lines = block.lines().filter(|line| !line.starts_with(['-', '+']));
        lines.collect::<Vec<_>>().join("\n")
    };
    let change = |block: &str| {
        let lines = block.lines().filter(|line| line.starts_with(['-', '+']));
        lines.collect::<Vec<_>>().join("\n")
    };
    let case =
        |block| Case { change: change(block), from: part(block, "-"), to: part(block, "+"), message: message(block) };
    CASES.trim_end().split("\n\n").map(case).collect()
}

#[test]
fn the_right_rig_is_right() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    fs::write(&rig, RIGHT).unwrap();
    let ran = borescope(["check", rig.to_str().unwrap()]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
}

#[test]
fn each_wrong_rig_gives_its_message_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (rig, record) = (folder.path().join("rig.toml"), folder.path().join("record.csv"));
    let (mut missed, mut blessed) = (Vec::new(), Vec::new());
    for Case { change, from, to, message } in cases() {
        assert!(RIGHT.contains(&from), "{from}");
        fs::write(&rig, RIGHT.replacen(&from, &to, 1)).unwrap();
        let path = rig.to_str().unwrap();
        for arguments in [vec!["check", path], vec!["simulate", path, "-o", record.to_str().unwrap()]] {
            let ran = borescope(arguments);
            let told = ran.err.replace(path, "RIG");
            assert!(ran.status == Some(2) && told.starts_with("error: RIG:"), "{told}");
            if page::blessed() {
                blessed.push(format!("{change}\n{}\n", told.trim_end()));
            } else if (ran.status, ran.out.as_str(), told.trim_end()) != (Some(2), "", message.as_str()) {
                missed.push(format!("{from} -> {to}\n{:?} {}{told}", ran.status, ran.out));
            }
            assert!(!record.exists(), "{from} -> {to} leaves a record");
        }
    }
    if page::blessed() {
        // Both verbs say the same.
        assert!(blessed.chunks(2).all(|pair| pair[0] == pair[1]));
        fs::write("tests/it/cli/rig_wrong/cases.txt", blessed.into_iter().step_by(2).collect::<Vec<_>>().join("\n"))
            .unwrap();
    }
    println!("{} wrong rigs", cases().len());
    assert!(
        missed.is_empty(),
        "{}\nif that is meant: BLESS=1 cargo test --release --test it -- cli::rig_wrong",
        missed.join("\n")
    );
}
