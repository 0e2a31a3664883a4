//! The commands of the README, of the tutorial, of the gallery and of how-to pages do what is printed under them.
//!
//! Every ```` ```console ```` block is run, line by line, in a copy of the fixtures. Lines of printed output must be those of the
//! real one, none left out, numbers apart; `...` stands for lines left out, and only standard error may be left out without it, or
//! the whole output. Verdicts must agree to the digit.
//! `BLESS=1 cargo test --release --test it -- docs::tutorial --include-ignored` writes the present numbers into the documents.

use crate::support::page;

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::process::Command;

/// What is run; other commands of a page are for the reader only.
const RUN: [&str; 3] = ["borescope ", "sed ", "mkdir "];
/// Lines into which one of a document may have been broken since.
const BROKEN: usize = 6;
const VERDICTS: [&str; 3] = ["HEALTHY:", "FAULTY:", "MODEL INADEQUATE:"];

/// What a command printed, and how far a document has it.
struct Printed {
    /// One line each, standard error behind standard output.
    lines: Vec<String>,
    /// So many are of standard output.
    out: usize,
    next: usize,
    /// Whether the document shows a line, and whether `...` stands for those that follow.
    shown: bool,
    open: bool,
}

impl Printed {
    /// The lines that a line of the document shows: one, or several where it was one before.
    fn place(&self, line: &str) -> Option<Range<usize>> {
        let places = (self.next..self.lines.len()).flat_map(|at| (1..=BROKEN).map(move |count| at..at + count));
        let begins = |at: &Range<usize>| at.len() == 1 || !self.lines[at.start].trim().is_empty();
        let mut places = places.filter(|at| at.end <= self.lines.len() && begins(at));
        places.find(|at| words(&self.lines[at.clone()].join(" ")) == words(line))
    }

    /// The lines of standard output that the document leaves out without saying so, before line `end`.
    fn left_out(&self, end: usize) -> &[String] {
        let end = end.min(self.out);
        if self.shown && !self.open && self.next < end { &self.lines[self.next..end] } else { &[] }
    }
}

/// Runs a command.
fn run(folder: &Path, command: &str) -> (Option<i32>, Printed) {
    // A shell, because a reader has one: pipes, `echo $?` and `cd` mean what they mean there.
    let output = Command::new("sh")
        .args(["-c", &format!("borescope() {{ \"$PROGRAM\" \"$@\"; }}\n{command}")])
        .env("PROGRAM", env!("CARGO_BIN_EXE_borescope"))
        .current_dir(folder)
        .output()
        .unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    let lines: Vec<String> = out.lines().chain(err.lines()).map(str::to_owned).collect();
    let out = out.lines().count();
    (output.status.code(), Printed { lines, out, next: 0, shown: false, open: false })
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
        "suction",
        "own_filter",
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
    let mut left: Option<Printed> = None;
    for (row, line) in document.lines().enumerate() {
        let mut shown = line.to_owned();
        let place = format!("{path}:{}", row + 1);
        let ends = line.starts_with("```") || (console && line.starts_with("$ "));
        if let Some(printed) = left.take_if(|_| ends) {
            for omitted in printed.left_out(printed.out) {
                stale.push(format!("{place}: printed, but left out: {omitted}"));
                now.push_str(&format!("{}\n", omitted.trim_end()));
            }
        }
        if line.starts_with("```") {
            console = line == "```console";
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| console) {
            let command = command.replace("cargo run --release -- ", "borescope ");
            if RUN.iter().any(|program| command.starts_with(program)) {
                let (status, printed) = run(&folder, &command);
                // A document shows an exit status other than 0 by `; echo $?`, which ends with 0 itself.
                if status != Some(0) {
                    wrong.push(format!("{place}: exit status {status:?}: {}", printed.lines.join("\n")));
                }
                left = Some(printed);
                ran += 1;
            }
        } else if let Some(printed) = left.as_mut().filter(|_| console) {
            if line == "..." {
                (printed.open, printed.shown) = (true, true);
            } else {
                match printed.place(line) {
                    None => {
                        wrong.push(format!("{place}: not printed, or not here: {line}"));
                        // What follows would only repeat this.
                        left = None;
                    }
                    Some(at) => {
                        printed.shown |= printed.next == 0 && at.start > 0;
                        for omitted in printed.left_out(at.start) {
                            stale.push(format!("{place}: printed, but left out: {omitted}"));
                            now.push_str(&format!("{}\n", omitted.trim_end()));
                        }
                        let real = &printed.lines[at.clone()];
                        let is_verdict = VERDICTS.iter().any(|verdict| line.starts_with(verdict));
                        if real.len() > 1 || (is_verdict && real[0] != line) {
                            stale.push(format!("{place}: stale, now: {}", real.join("\n")));
                        }
                        shown = real.iter().map(|line| line.trim_end()).collect::<Vec<_>>().join("\n");
                        (printed.next, printed.shown, printed.open) = (at.end, true, false);
                    }
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
fn the_how_tos_of_components_print_what_the_program_prints() {
    holds("docs/how-to/add-a-component.md");
    holds("docs/how-to/write-a-component.md");
}

#[test]
fn the_how_to_of_sensors_prints_what_the_program_prints() {
    holds("docs/how-to/place-sensors.md");
}

#[test]
fn the_how_to_of_calibration_prints_what_the_program_prints() {
    holds("docs/how-to/calibrate.md");
}
