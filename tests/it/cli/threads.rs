//! Answers do not depend on the number of threads, to the last digit.

use crate::support::command;

use std::process::Command;

use command::borescope;

#[test]
fn a_diagnosis_is_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = folder.path().join("record.csv");
    let rig = "fixtures/press/rig.toml";
    let simulated = borescope(["simulate", rig, "-o", record.to_str().expect("a path"), "--seed", "3"]);
    assert_eq!(simulated.status, Some(0), "{}{}", simulated.out, simulated.err);
    let [one, two, three] = ["1", "2", "3"].map(|threads| {
        let mut diagnose = Command::new(env!("CARGO_BIN_EXE_borescope"));
        diagnose.args(["diagnose", rig, "--threads", threads]).arg(&record).args(["--format", "json"]);
        let output = diagnose.output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    });
    assert!(one.contains("borescope.diagnosis/1"));
    assert_eq!(one, two);
    assert_eq!(one, three);
}
