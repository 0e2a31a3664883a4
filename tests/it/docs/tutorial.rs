//! The commands of the README, of the tutorial, of the gallery and of how-to pages do what is printed under them.
//!
//! Every ```` ```console ```` block is run, line by line, in a copy of the fixtures. A line of printed output must occur in the
//! real one, in its order, numbers apart; `...` stands for lines left out. Verdicts must agree to the digit.
//! `BLESS=1 cargo test --release --test it -- docs::tutorial --include-ignored` writes the present numbers into the documents.

use crate::support::page;

use std::fs;
use std::path::Path;
use std::process::Command;

/// What is run; other commands of a page are for the reader only.
const RUN: [&str; 3] = ["borescope ", "sed ", "mkdir "];
const VERDICTS: [&str; 3] = ["HEALTHY:", "FAULTY:", "MODEL INADEQUATE:"];

/// What a command printed, one line each, standard error behind standard output.
fn run(folder: &Path, command: &str) -> (Option<i32>, Vec<String>) {
    // A shell, because a reader has one: pipes, `echo $?` and `cd` mean what they mean there.
    let output = Command::new("sh")
        .args(["-c", &format!("borescope() {{ \"$PROGRAM\" \"$@\"; }}\n{command}")])
        .env("PROGRAM", env!("CARGO_BIN_EXE_borescope"))
        .current_dir(folder)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
    (output.status.code(), text.lines().map(str::to_owned).collect())
}

/// Words of a line, every number as `#`.
fn words(line: &str) -> String {
    // An error is a number of times the noise: `6.4x`.
    let is_number = |word: &str| word.trim_end_matches([',', '.', ';', ':', 'x']).parse::<f64>().is_ok();
    line.split_whitespace().map(|word| if is_number(word) { "#" } else { word }).collect::<Vec<_>>().join(" ")
}

/// Copies the fixtures that the documents name.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
    }
}

/// Runs the commands of a document; answers the document with the present numbers, what is wrong with it, and verdicts that are
/// stale.
fn check(path: &str) -> (String, Vec<String>, Vec<String>) {
    let around = tempfile::tempdir().unwrap();
    // A page may write beside the project.
    let folder = around.path().join("project");
    for fixtures in [
        "telescopic",
        "learning",
        "press",
        "two_tanks",
        "cascaded_tanks",
        "emps",
        "eha",
        "uci",
        "hydrostatic_drive",
        "servo_axis",
        "boom",
        "accumulator",
        "excavator",
        "robot",
    ] {
        let fixtures = format!("fixtures/{fixtures}");
        copy(Path::new(&fixtures), &folder.join(&fixtures));
    }
    // Records that stand beside the project, where they do.
    if let Ok(shared) = fs::canonicalize("../shared") {
        std::os::unix::fs::symlink(shared, around.path().join("shared")).unwrap();
    }
    let document = fs::read_to_string(path).unwrap();
    let (mut now, mut wrong, mut stale, mut ran) = (String::new(), Vec::new(), Vec::new(), 0);
    let mut console = false;
    let mut left: Option<std::vec::IntoIter<String>> = None;
    for (row, line) in document.lines().enumerate() {
        let mut shown = line.to_owned();
        let place = format!("{path}:{}", row + 1);
        if line.starts_with("```") {
            console = line == "```console";
            left = None;
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| console) {
            let command = command.replace("cargo run --release -- ", "borescope ");
            left = None;
            if RUN.iter().any(|program| command.starts_with(program)) {
                let (status, lines) = run(&folder, &command);
                // A document shows an exit status other than 0 by `; echo $?`, which ends with 0 itself.
                if status != Some(0) {
                    wrong.push(format!("{place}: exit status {status:?}: {}", lines.join("\n")));
                }
                left = Some(lines.into_iter());
                ran += 1;
            }
        } else if let Some(lines) = left.as_mut().filter(|_| console && line != "...") {
            match lines.find(|real| words(real) == words(line)) {
                None => {
                    wrong.push(format!("{place}: not printed, or not here: {line}"));
                    // What follows would only repeat this.
                    left = None;
                }
                Some(real) => {
                    if VERDICTS.iter().any(|verdict| line.starts_with(verdict)) && real != line {
                        stale.push(format!("{place}: stale verdict, now: {real}"));
                    }
                    shown = real;
                }
            }
        }
        now.push_str(shown.trim_end());
        now.push('\n');
    }
    assert!(ran > 0, "{path} has no commands");
    (now, wrong, stale)
}

fn holds(path: &str) {
    let (now, wrong, stale) = check(path);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    if page::blessed() {
        fs::write(path, now).unwrap();
    } else {
        assert!(stale.is_empty(), "{}", stale.join("\n"));
    }
}

#[test]
fn the_readme_prints_what_the_program_prints() {
    holds("README.md");
}

/// Stories of a minute each, which `.ci/run` goes through behind the tests.
mod gallery {
    use super::holds;

    #[test]
    #[ignore = "half a minute"]
    fn the_tutorial_prints_what_the_program_prints() {
        holds("docs/tutorial.md");
    }

    #[test]
    #[ignore = "a minute"]
    fn its_pages_print_what_the_program_prints() {
        holds("docs/gallery/missing-physics.md");
        holds("docs/gallery/the-papers-leakage.md");
        holds("docs/gallery/pages.md");
    }

    #[test]
    #[ignore = "half a minute"]
    fn other_machines_print_what_the_program_prints() {
        for page in ["hydrostatic-drive", "servo-axis", "boom", "accumulator"] {
            holds(&format!("docs/gallery/{page}.md"));
        }
    }

    #[test]
    #[ignore = "a minute"]
    fn the_arm_with_load_sensing_prints_what_the_program_prints() {
        holds("docs/gallery/load-sensing.md");
    }
}

/// Run by hand: nobody waits for it at each change.
mod long {
    #[test]
    #[ignore = "five minutes"]
    fn the_whole_robot_prints_what_the_program_prints() {
        super::holds("docs/gallery/robot.md");
    }
}

mod shared {
    #[test]
    #[ignore = "needs ../shared/records"]
    fn the_gallery_of_measured_machines_prints_what_the_program_prints() {
        super::holds("docs/gallery/measured.md");
    }
}

#[test]
fn the_how_to_of_diagnosis_prints_what_the_program_prints() {
    holds("docs/how-to/diagnose.md");
}

#[test]
fn the_how_to_of_sensors_prints_what_the_program_prints() {
    holds("docs/how-to/place-sensors.md");
}

#[test]
fn the_how_to_of_calibration_prints_what_the_program_prints() {
    holds("docs/how-to/calibrate.md");
}
