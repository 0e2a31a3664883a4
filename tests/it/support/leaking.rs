//! The telescopic rig with a leak that the model lacks, on a short stroke.

use std::fs;
use std::path::Path;

use crate::support::command::borescope;

/// Writes `rig.toml`, without the leak, and two records of the leaking one: `fit.csv`, `check.csv`.
pub fn leaking(folder: &Path) {
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let whole = fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
    let (rig, _) = whole.split_once("phases = [").unwrap();
    // Out and back.
    let phases = [(0.2, 0, 3000), (1.0, 1, 3000), (0.4, 0, 3000), (0.5, -1, 500), (0.3, 0, 500)];
    let phases = phases.map(|(duration, command, load)| {
        format!("    {{ duration = \"{duration} s\", valve_command = {command}, F_load = \"{load} N\" }},\n")
    });
    let rig = format!("{rig}phases = [\n{}]\n", phases.concat());
    let leak = "\n[effects]\n\"external-leakage@A\" = { conductance = \"0.01 L/min/bar\" }\n";
    fs::write(path("rig.toml"), &rig).unwrap();
    fs::write(path("leaks.toml"), rig + leak).unwrap();
    for (seed, name) in [("3", "fit.csv"), ("4", "check.csv")] {
        let ran = borescope(["simulate", &path("leaks.toml"), "--seed", seed, "-o", &path(name)]);
        assert_eq!(ran.status, Some(0), "{}", ran.err);
    }
}
