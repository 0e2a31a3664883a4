//! `isolability`: which faults a rig and its sensors can tell apart: from the structure, and by the residuals at an operating
//! point.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Failure, Format, Status, signatures, write_json};
use crate::rig::Rig;
use crate::structure::{Isolability, analyse, render};

/// Tell which faults of a rig its sensors can detect and tell apart
#[derive(Debug, Args)]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// Take commands and loads of the operating point from this record; without it from the `[cycle]` of the rig file
    #[arg(long, value_name = "RECORD")]
    input: Option<PathBuf>,
    /// How the result is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Serialize)]
struct Page<'a> {
    schema: &'static str,
    rig: String,
    #[serde(flatten)]
    structure: &'a Isolability,
    signatures: Option<Vec<signatures::Row>>,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    let rig = Rig::read(&arguments.rig)?;
    let structure = analyse(&rig);
    let signatures = signatures::rows(&rig, arguments.input.as_deref())?;
    match arguments.format {
        Format::Text => {
            out.write_all(render(&structure).as_bytes())?;
            out.write_all(signatures::render(&rig, signatures.as_deref()).as_bytes())?;
        }
        Format::Json => {
            let rig = arguments.rig.display().to_string();
            write_json(out, &Page { schema: "borescope.isolability/1", rig, structure: &structure, signatures })?;
        }
    }
    Ok(Status::Done)
}
