//! `isolability`: which faults a rig and its sensors can tell apart: from the structure, and at an operating point by the
//! residuals and by how well they could be sized.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Failure, Format, Overwriting, Status, expected, signatures, write_json, write_page};
use crate::context::Context;
use crate::report::pages::isolability::{Point, html};
use crate::rig::Rig;
use crate::structure::{Isolability, analyse, render};

/// Tell which faults of a rig its sensors can detect and tell apart
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope isolability rig.toml --with cylinder.clearance=0.2mm")]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// Take commands and loads of the operating point from this record; without it from the `[cycle]` of the rig file
    #[arg(long, value_name = "RECORD")]
    input: Option<PathBuf>,
    /// Take this fault as present at the operating point, such as `cylinder.clearance=0.2mm`; may be repeated
    #[arg(long, value_name = "FAULT=VALUE")]
    with: Vec<String>,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// How the result is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

#[derive(Serialize)]
struct Page<'a> {
    schema: &'static str,
    rig: String,
    #[serde(flatten)]
    structure: &'a Isolability,
    signatures: Option<Vec<signatures::Row>>,
    expected: Option<expected::Numbers>,
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let outputs = arguments.overwriting.outputs();
    outputs.reading(arguments.input.iter().chain([&arguments.rig])).writing_all(&arguments.report)?;
    let rig = Rig::read(&arguments.rig)?.with_context(context);
    context.stage("structure of the circuit");
    let structure = analyse(&rig);
    context.check()?;
    context.stage("operating point");
    let point = signatures::operating_point(&rig, arguments.input.as_deref())?;
    let (signatures, expected) = match &point {
        Some((drive, record)) => {
            let rows = signatures::rows(&rig, drive, record)?;
            (Some(rows), Some(expected::numbers(&rig, drive, record, &arguments.with)?))
        }
        None => (None, None),
    };
    if let Some(path) = &arguments.report {
        let point = signatures.as_deref().zip(expected.as_ref()).map(|(rows, numbers)| Point {
            signatures: signatures::table(&rig, rows),
            said: expected::said(numbers),
            widths: expected::table(numbers),
        });
        write_page(path, &html(&rig, &structure, point))?;
    }
    match arguments.format {
        Format::Text => {
            out.write_all(render(&structure).as_bytes())?;
            out.write_all(signatures::render(&rig, signatures.as_deref()).as_bytes())?;
            if let Some(numbers) = &expected {
                out.write_all(expected::render(numbers).as_bytes())?;
            }
        }
        Format::Json => {
            let rig = arguments.rig.display().to_string();
            let page = Page { schema: "borescope.isolability/1", rig, structure: &structure, signatures, expected };
            write_json(out, &page)?;
        }
    }
    Ok(Status::Done)
}
