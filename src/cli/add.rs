//! `add`: an effect written into a new rig file.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Overwriting, Status, read, write_file, write_json};
use crate::context::Context;
use crate::files::{is_kept, read_text};
use crate::finding::argument;
use crate::learn::add::{Added, add};
use crate::learn::addition::AdditionReport;
use crate::report::brief::next_line;
use crate::report::provenance::{Provenance, WithProvenance};
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
    /// How the summary is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    // The rig file may take its own place.
    arguments.overwriting.outputs().reading(&arguments.fit).writing(&arguments.output)?;
    let text = read_text(&arguments.rig)?;
    let rig = Rig::parse(&arguments.rig, text.clone())?.with_context(context);
    let record = arguments.fit.as_ref().map(|path| read::fitted(&rig, path)).transpose()?;
    let new = add(&text, &rig, &arguments.effect, record.as_ref())?;
    let new = Added { text: rig.text_at(&new.text, &arguments.output)?, ..new };
    write_file(&arguments.output, |file| file.write_all(new.text.as_bytes()))?;
    // With `-o /dev/stdout` more would stand in the rig file.
    if is_kept(&arguments.output) {
        let report = AdditionReport::new(&rig, &new, &arguments.output)?;
        match arguments.format {
            Format::Json => {
                let provenance = Provenance::of(&rig, &record);
                write_json(out, &WithProvenance { result: &report, provenance })?;
            }
            Format::Text => {
                write!(out, "{report}")?;
                let new = argument(&arguments.output);
                match &arguments.fit {
                    Some(record) => {
                        let (record, rig) = (argument(record), argument(&arguments.rig));
                        // The file may have taken its own place.
                        let before = if rig == new { String::new() } else { format!(" --before {rig}") };
                        writeln!(out, "{}", next_line(&format!("borescope compare {new} {record}{before}")))?;
                    }
                    None => writeln!(out, "{}", next_line(&format!("borescope diagnose {new} RECORD")))?,
                }
            }
        }
    }
    Ok(Status::Done)
}
