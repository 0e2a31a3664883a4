//! `add`: an effect written into a new rig file.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Status, read};
use crate::files::{check_folder, read_text, write_atomically};
use crate::learn::add::add;
use crate::rig::Rig;

/// Add an effect to a rig file, fitted to a record if one is given
///
/// Comments and order of the file stay. Without a record the effect is there at its neutral value, uncertain, so that later
/// fits estimate it.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope add rig.toml external-leakage@A --fit record.csv -o new.toml")]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// The effect and its place, such as `external-leakage@A`; `borescope effects` lists them
    #[arg(value_name = "EFFECT[@PLACE]")]
    effect: String,
    /// Fit its parameters to this record, together with everything uncertain and all faults
    #[arg(long, value_name = "RECORD")]
    fit: Option<PathBuf>,
    /// Where the new rig file is written
    #[arg(short, long, value_name = "NEW.toml")]
    output: PathBuf,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    check_folder(&arguments.output)?;
    let text = read_text(&arguments.rig)?;
    let rig = Rig::parse(&arguments.rig, text.clone())?;
    let record = arguments.fit.as_ref().map(|path| read::record(&rig, path)).transpose()?;
    let new = add(&text, &rig, &arguments.effect, record.as_ref())?;
    write_atomically(&arguments.output, |file| file.write_all(new.as_bytes()))?;
    // With `-o /dev/stdout` more would stand in the rig file.
    if arguments.output.is_file() {
        let added = Rig::parse(&arguments.output, new)?;
        for effect in added.effects.iter().filter(|effect| rig.effects.iter().all(|old| old.id != effect.id)) {
            writeln!(out, "{}: {} added", arguments.output.display(), effect.id)?;
            for &index in &effect.parameters {
                let parameter = &added.parameters[index];
                let value = parameter.unit.from_si(parameter.value);
                let sigma = parameter.unit.difference_from_si(parameter.sigma);
                let (value, sigma) =
                    (crate::report::number::rounded(value, 6), crate::report::number::rounded(sigma, 3));
                writeln!(out, "  {} = {value} +- {sigma} {}", parameter.id, parameter.unit)?;
            }
        }
    }
    Ok(Status::Done)
}
