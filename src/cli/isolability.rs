//! `isolability`: which faults a rig and its sensors can tell apart.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::simulate::assigned;
use super::{Failure, Format, Overwriting, Status, read, write_json, write_page};
use crate::context::Context;
use crate::finding::argument;
use crate::isolability::{TakenFault, isolability};
use crate::report::brief::next_line;
use crate::report::isolability::{brief, expected_text, signature_text};
use crate::report::pages::isolability::html;
use crate::report::provenance::{Provenance, WithProvenance};
use crate::report::table::fitted;
use crate::rig::Rig;

/// Find which faults of a rig its sensors can detect and isolate
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
    /// List which fault explains which, the tests, and how every residual answers
    #[arg(long)]
    all: bool,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// How the result is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let outputs = arguments.overwriting.outputs();
    outputs.reading(arguments.input.iter().chain([&arguments.rig])).writing_all(&arguments.report)?;
    let rig = Rig::read(&arguments.rig)?.with_context(context);
    let with = arguments.with.iter().map(|text| assigned("--with", text, |id, value| TakenFault::new(&rig, id, value)));
    let with = with.collect::<Result<Vec<_>, _>>()?;
    let source = arguments.input.as_deref().map(|path| read::record(&rig, path)).transpose()?;
    let report = isolability(&rig, source.as_ref(), &with)?;
    if let Some(path) = &arguments.report {
        write_page(path, &html(&rig, &report))?;
    }
    match arguments.format {
        Format::Text => {
            let text = match arguments.all {
                true => {
                    let mut text = report.structure.to_string() + &signature_text(&rig, report.signatures.as_deref());
                    text.extend(report.expected.as_ref().map(expected_text));
                    fitted(&text)
                }
                false => brief(&rig, &report),
            };
            out.write_all(text.as_bytes())?;
            let rig_file = argument(&arguments.rig);
            writeln!(out)?;
            if !arguments.all {
                writeln!(out, "`--all` shows which fault explains which, and how every residual answers.")?;
            }
            let command = match &rig.cycle {
                // What a diagnosis is worth on this rig, measured.
                Some(_) => format!("borescope campaign {rig_file} --cases 100"),
                None => format!("borescope diagnose {rig_file} RECORD"),
            };
            writeln!(out, "{}", next_line(&command))?;
        }
        Format::Json => {
            let provenance = Provenance::of(&rig, &source);
            write_json(out, &WithProvenance { result: &report, provenance })?;
        }
    }
    Ok(Status::Done)
}
