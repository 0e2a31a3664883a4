//! `improve`: suggest, add and fit again, with the ledger of what each addition bought.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Overwriting, Status, read, terminal, write_file, write_json, write_page};
use crate::context::Context;
use crate::files::{is_kept, read_text};
use crate::learn::evaluated::Conclusion;
use crate::learn::improve::{ImprovementStep, improve};
use crate::report::curves::Curves;
use crate::report::ledger::Ledger;
use crate::report::provenance::{Provenance, WithProvenance};
use crate::report::{self, pages};
use crate::rig::Rig;

/// Add the physical effects that a model lacks, and show the improvement per effect
///
/// Effects are fitted to one record and judged on another record of the same rig under other loads.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  borescope improve rig.toml --fit monday.csv --check tuesday.csv \\\n    -o better.toml --report ledger.html"
)]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// The record to which effects are fitted
    #[arg(long, value_name = "RECORD")]
    fit: PathBuf,
    /// The record on which effects are judged; nothing is fitted to it
    #[arg(long, value_name = "RECORD2")]
    check: PathBuf,
    /// Where the improved rig file is written
    #[arg(short, long, value_name = "NEW.toml")]
    output: PathBuf,
    /// Reduced chi-square, errors of each sensor, caveats, and what was refused
    #[arg(long)]
    all: bool,
    /// How the ledger is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Also write the curves of the fit record: measured, your model as fitted, and the model with the effects that were added
    #[arg(long, value_name = "FILE.csv")]
    curves: Option<PathBuf>,
    /// Exit with 1 if an effect was missing
    #[arg(long)]
    exit_code: bool,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb; the ledger goes to `out`, unless the rig file itself goes to a device.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let records = [&arguments.fit, &arguments.check];
    // The rig file may take its own place.
    let outputs = arguments.overwriting.outputs().reading(records).writing(&arguments.output)?;
    outputs.reading([&arguments.rig]).writing_all(arguments.report.iter().chain(&arguments.curves))?;
    let text = read_text(&arguments.rig)?;
    let rig = Rig::parse(&arguments.rig, text.clone())?.with_context(context);
    let (fit, check) = (read::fitted(&rig, &arguments.fit)?, read::fitted(&rig, &arguments.check)?);
    read::not_itself(&arguments.fit, &arguments.check);
    let told = |step: &ImprovementStep| {
        if terminal::shows_progress() {
            let added = step.added.as_deref().unwrap_or("your model");
            terminal::note(format_args!("{added}: check error {:.3}", step.times_noise()[1]));
        }
    };
    let improvement = improve(&rig, &fit, &check, told)?;
    let new = rig.text_at(&improvement.rig_file(&text, &rig)?, &arguments.output)?;
    write_file(&arguments.output, |file| file.write_all(new.as_bytes()))?;
    let names = [&arguments.rig, &arguments.fit, &arguments.check].map(|path| path.display().to_string());
    let ledger = Ledger::new(&improvement, names);
    if let Some(path) = &arguments.report {
        let new = arguments.output.display().to_string();
        write_page(path, &pages::improvement::improvement(&rig, (&fit, &check), &improvement, (&ledger, &new))?)?;
    }
    if let Some(path) = &arguments.curves {
        let curves = Curves { model: &improvement.given.fit.outputs, found: &improvement.trial.fit.outputs };
        write_file(path, |file| curves.write_csv(&rig, &fit, file))?;
    }
    // With `-o /dev/stdout` the ledger would stand in the rig file.
    if is_kept(&arguments.output) {
        let provenance = Provenance::of(&rig, [&fit, &check]);
        match arguments.format {
            Format::Json => write_json(out, &WithProvenance { result: &ledger, provenance })?,
            Format::Text => {
                let page = if arguments.all {
                    let mut page = Vec::new();
                    ledger.write_text(&mut page)?;
                    provenance.below(report::table::fitted(&String::from_utf8_lossy(&page)))
                } else {
                    ledger.brief(&arguments.output.display().to_string())
                };
                terminal::clear();
                out.write_all(terminal::verdict(&page, report::learn::tone(ledger.conclusion)).as_bytes())?;
            }
        }
    }
    let missing = improvement.conclusion != Conclusion::Adequate;
    Ok(if arguments.exit_code && missing { Status::Found } else { Status::Done })
}
