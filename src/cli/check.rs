//! `check`: a rig file, and a record against it.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Status, write_json};
use crate::check::check;
use crate::context::Context;
use crate::finding::argument;
use crate::report::brief::next_line;
use crate::report::check::{brief, write_page};
use crate::rig::Rig;

/// Check a rig file, and a record against it
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope check rig.toml record.csv")]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// A record of this rig
    record: Option<PathBuf>,
    /// List every node, component, parameter, sensor, fault, column and phase
    #[arg(long)]
    all: bool,
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
            match arguments.all {
                true => write_page(out, &checked.report)?,
                false => out.write_all(brief(&checked.report).as_bytes())?,
            }
            if checked.refused.is_none() {
                let rig = argument(&arguments.rig);
                let command = match &arguments.record {
                    Some(record) => format!("borescope compare {rig} {}", argument(record)),
                    None => format!("borescope check {rig} RECORD"),
                };
                writeln!(out)?;
                if !arguments.all {
                    writeln!(out, "`--all` lists every part, value, sensor, fault, column and phase.")?;
                }
                writeln!(out, "{}", next_line(&command))?;
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
