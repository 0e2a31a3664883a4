//! `check`: a rig file, and a record against it.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Status, write_json};
use crate::check::check;
use crate::context::Context;
use crate::finding::argument;
use crate::report::check::write_page;
use crate::rig::Rig;

/// Check a rig file, and a record against it
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope check rig.toml record.csv")]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// A record of this rig
    record: Option<PathBuf>,
    /// How the page is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Runs the verb; the page goes to `out`.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let rig = Rig::read(&arguments.rig)?.with_context(context);
    let checked = check(&rig, arguments.record.as_deref())?;
    match arguments.format {
        Format::Json => write_json(out, &checked.report)?,
        Format::Text => {
            write_page(out, &checked.report)?;
            if checked.refused.is_none() {
                let rig = argument(&arguments.rig);
                match &arguments.record {
                    Some(record) => {
                        writeln!(out, "\nNext: borescope compare {rig} {}", argument(record))?;
                    }
                    None => writeln!(out, "\nNext: borescope check {rig} RECORD")?,
                }
            }
        }
    }
    match checked.refused {
        None => Ok(Status::Done),
        Some(complaint) => {
            // What was found goes before why it is of no use.
            out.flush()?;
            Err(complaint.into())
        }
    }
}
