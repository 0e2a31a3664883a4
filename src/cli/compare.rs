//! `compare`: the model beside a record, and where it misses.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Overwriting, Status, read, terminal, write_file, write_json, write_page};
use crate::complaint::Complaint;
use crate::context::Context;
use crate::finding::measured::{WithEvents, events};
use crate::learn::compare::{compare, compared};
use crate::learn::comparison::{Comparison, Earlier};
use crate::report;
use crate::report::curves::Curves;
use crate::report::provenance::{Provenance, WithProvenance};
use crate::rig::Rig;

/// Compare the model with a record: how large the misfit is, at which sensor, in which phase
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  borescope compare rig.toml record.csv --report misfit.html\n  borescope compare better.toml record.csv --before rig.toml"
)]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// A record of this rig
    record: PathBuf,
    /// An older rig file of the same machine, whose misfit is shown beside the new one's
    #[arg(long, value_name = "OLD.toml")]
    before: Option<PathBuf>,
    /// All figures of each sensor, and the phases with its largest misfits
    #[arg(long)]
    all: bool,
    /// Also write the curves behind the comparison: measured, your model, and your model with the faults found
    #[arg(long, value_name = "FILE.csv")]
    curves: Option<PathBuf>,
    /// How the comparison is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Exit with 1 if the model does not explain the record
    #[arg(long)]
    exit_code: bool,
    #[command(flatten)]
    overwriting: Overwriting,
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let outputs = arguments.overwriting.outputs();
    outputs
        .reading(arguments.before.iter().chain([&arguments.rig, &arguments.record]))
        .writing_all(arguments.report.iter().chain(&arguments.curves))?;
    let rig = Rig::read(&arguments.rig)?.with_context(context);
    read::doubts_of(&rig);
    let record = read::fitted(&rig, &arguments.record)?;
    let before = arguments.before.as_ref().map(|path| -> Result<Comparison, Complaint> {
        let rig = Rig::read(path)?.with_context(context);
        let record = rig.record(&arguments.record)?;
        compare(&rig, &record)
    });
    let before = before.transpose()?;
    let mut compared = compared(&rig, &record)?;
    if let Some(path) = &arguments.curves {
        let model = &compared.run.outputs;
        let curves = Curves { model, found: compared.found.as_ref().unwrap_or(model) };
        write_file(path, |file| curves.write_csv(&rig, &record, file))?;
    }
    compared.comparison.before = before.as_ref().map(Earlier::of);
    let events = if compared.comparison.adequate { Vec::new() } else { events(&rig, &record, &compared.run.outputs)? };
    if let Some(path) = &arguments.report {
        write_page(path, &report::pages::learn::comparison(&rig, &record, &compared, &events)?)?;
    }
    let comparison = &compared.comparison;
    let explained = comparison.with_faults.as_ref().is_some_and(|with| with.adequate);
    if !comparison.adequate && !explained {
        for doubt in crate::check::doubts(&rig, &record)? {
            terminal::note(format_args!("note: {}: {doubt}", arguments.record.display()));
        }
    }
    let provenance = Provenance::of(&rig, [&record]);
    match arguments.format {
        Format::Text => {
            let mut page = report::comparison::brief(comparison, &events, arguments.all);
            if arguments.all {
                page.push('\n');
                page.push_str(&provenance.below(report::learn::comparison(comparison)));
            }
            terminal::clear();
            out.write_all(terminal::verdict(&page, report::learn::comparison_tone(comparison)).as_bytes())?;
        }
        Format::Json => {
            let result = WithEvents { comparison, events: &events };
            write_json(out, &WithProvenance { result, provenance })?;
        }
    }
    Ok(if arguments.exit_code && !comparison.adequate { Status::Found } else { Status::Done })
}
