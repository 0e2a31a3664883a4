//! `example`: a rig file and records to play with.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Overwriting, Status};
use crate::complaint::{Complaint, Kind};
use crate::context::Context;
use crate::files::write_atomically;
use crate::model::Model;
use crate::rig::Rig;
use crate::simulation::{SimulationOptions, simulate};

/// A press: small, and its faults differ.
const RIG: &str = include_str!("../../fixtures/press/rig.toml");

struct Recorded {
    file: &'static str,
    /// A parameter with another value than in the rig file.
    set: Option<(&'static str, &'static str)>,
    seed: u64,
    what: &'static str,
}

const RECORDS: [Recorded; 3] = [
    Recorded { file: "healthy.csv", set: None, seed: 1, what: "one pressing as the data sheet has it" },
    Recorded { file: "check.csv", set: None, seed: 2, what: "another" },
    Recorded {
        file: "leak.csv",
        set: Some(("cylinder.clearance", "0.15 mm")),
        seed: 3,
        what: "one with a worn piston",
    },
];

/// Write a rig file and records to play with into a folder
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope example press")]
pub struct Arguments {
    /// The folder; it is made where it is missing
    folder: PathBuf,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb; what was written is told on `out`.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let folder = &arguments.folder;
    std::fs::create_dir_all(folder).map_err(|error| {
        Complaint::new(Kind::Unwritable, format!("cannot be created: {error}")).in_file(folder).help("name another")
    })?;
    let rig_path = folder.join("rig.toml");
    let records = RECORDS.map(|recorded| folder.join(recorded.file));
    arguments.overwriting.outputs().writing_all(&records)?.writing(&rig_path)?;
    let rig = Rig::parse(&rig_path, RIG.to_owned())?.with_context(context);
    for (path, Recorded { set, seed, .. }) in records.iter().zip(RECORDS) {
        let mut rig = rig.clone();
        if let Some((id, value)) = set {
            rig.set(id, value)?;
        }
        let options = SimulationOptions { name: path.clone(), seed: Some(seed), ..SimulationOptions::default() };
        simulate(&Model::new(rig), None, &options)?.record.write(path)?;
    }
    write_atomically(&rig_path, |file| file.write_all(RIG.as_bytes()))?;
    let [healthy, check, leak] = records.each_ref().map(|path| path.display());
    let rig = rig_path.display();
    writeln!(out, "{rig}: a press")?;
    for (path, Recorded { what, .. }) in records.iter().zip(RECORDS) {
        writeln!(out, "{}: {what}", path.display())?;
    }
    writeln!(
        out,
        "\nNext: borescope check {rig} {healthy}\n      borescope diagnose {rig} {leak}\n      borescope calibrate {rig} {healthy} {check} -o {}",
        folder.join("calibrated.toml").display()
    )?;
    Ok(Status::Done)
}
