//! `suggest`: which physical effect the model lacks.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Overwriting, Status, read, terminal, write_file, write_json, write_page};
use crate::context::Context;
use crate::finding::lacking::{WithFinding, lacking};
use crate::learn::evaluated::Conclusion;
use crate::learn::result::SuggestionReport;
use crate::learn::suggest::suggest;
use crate::report;
use crate::report::curves::Curves;
use crate::report::provenance::{Provenance, WithProvenance};
use crate::report::unknown::Rise;
use crate::rig::Rig;

/// Suggest the physical effect that the model of a rig lacks
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  borescope suggest rig.toml monday.csv --check tuesday.csv \\\n    --report candidates.html"
)]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// The record to which effects are fitted
    record: PathBuf,
    /// Another record, to which nothing is fitted: an effect must improve it too
    #[arg(long, value_name = "RECORD")]
    check: Option<PathBuf>,
    /// Every candidate with its size and caveats, and what the record could have shown
    #[arg(long)]
    all: bool,
    /// How the suggestion is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Also write the curves of the fit record: measured, your model as fitted, and the model with the best supported effect
    #[arg(long, value_name = "FILE.csv")]
    curves: Option<PathBuf>,
    /// Exit with 1 if an effect is missing
    #[arg(long)]
    exit_code: bool,
    #[command(flatten)]
    overwriting: Overwriting,
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let outputs = arguments.overwriting.outputs();
    outputs
        .reading(arguments.check.iter().chain([&arguments.rig, &arguments.record]))
        .writing_all(arguments.report.iter().chain(&arguments.curves))?;
    let rig = Rig::read(&arguments.rig)?.with_context(context);
    read::doubts_of(&rig);
    let record = read::fitted(&rig, &arguments.record)?;
    let check = arguments.check.as_ref().map(|path| read::fitted(&rig, path)).transpose()?;
    if let Some(check) = &arguments.check {
        read::not_itself(&arguments.record, check);
    }
    let suggestion = suggest(&rig, &record, check.as_ref())?;
    let shown = SuggestionReport::new(&suggestion, &record, check.as_ref())?;
    let rise = Rise::of_suggestion(&suggestion);
    let command = report::suggestion::next(&shown, rise.as_ref());
    let finding = lacking(&suggestion, (&record, &shown), command)?;
    if let Some(path) = &arguments.report {
        let page = report::pages::suggestion::suggestion(
            &rig,
            (&record, check.as_ref()),
            &suggestion,
            (&shown, finding.as_ref()),
        )?;
        write_page(path, &page)?;
    }
    if let Some(path) = &arguments.curves {
        let model = &suggestion.base.fit.outputs;
        let best = suggestion.judged.first().filter(|best| best.supported);
        let curves = Curves { model, found: best.map_or(model, |best| &best.trial.fit.outputs) };
        write_file(path, |file| curves.write_csv(&rig, &record, file))?;
    }
    let provenance = Provenance::of(&rig, std::iter::once(&record).chain(&check));
    match arguments.format {
        Format::Text => {
            let page = if arguments.all {
                provenance.below(report::learn::suggestion(&shown))
            } else {
                report::suggestion::brief(&shown, finding.as_ref(), rise.as_ref())
            };
            terminal::clear();
            out.write_all(terminal::verdict(&page, report::learn::tone(shown.conclusion)).as_bytes())?;
        }
        Format::Json => {
            let result = WithFinding { suggestion: &shown, finding: finding.as_ref() };
            write_json(out, &WithProvenance { result, provenance })?;
        }
    }
    let found = shown.conclusion != Conclusion::Adequate;
    Ok(if arguments.exit_code && found { Status::Found } else { Status::Done })
}
