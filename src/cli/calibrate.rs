//! `calibrate`: what healthy records teach about a rig, written into a new rig file.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, Format, Overwriting, Status, read, terminal, write_file, write_json, write_page};
use crate::calibration::{CalibrationOptions, CalibrationReport, calibrate};
use crate::complaint::{Complaint, Kind, Place};
use crate::context::Context;
use crate::files::{is_kept, read_text};
use crate::finding::argument;
use crate::report::brief::next_line;
use crate::report::calibration::{brief, full};
use crate::report::pages;
use crate::report::provenance::{Provenance, WithProvenance};
use crate::report::table::fitted;
use crate::rig::Rig;

/// Calibrate a rig on healthy records, and write a new rig file
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  borescope calibrate rig.toml healthy_1.csv healthy_2.csv \\\n    -o calibrated.toml --report calibration.html"
)]
pub struct Arguments {
    /// The rig file; its own calibration, if it has one, is not used
    rig: PathBuf,
    /// Records of this rig while it was healthy
    #[arg(required = true)]
    records: Vec<PathBuf>,
    /// Where the calibrated rig file is written
    #[arg(short, long, value_name = "NEW.toml")]
    output: PathBuf,
    /// Show every value, every sensor and its error in each record
    #[arg(long)]
    all: bool,
    /// How the summary is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb; the summary goes to `out`, unless the rig file itself goes to a device.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    // The rig file may take its own place.
    let outputs = arguments.overwriting.outputs().reading(&arguments.records).writing(&arguments.output)?;
    outputs.reading([&arguments.rig]).writing_all(&arguments.report)?;
    check_files(arguments)?;
    let rig_text = read_text(&arguments.rig)?;
    let rig = Rig::parse(&arguments.rig, rig_text.clone())?.with_context(context);
    let mut records = Vec::new();
    let mut bad = Vec::new();
    for path in &arguments.records {
        match read::fitted(&rig, path) {
            Ok(record) => records.push(record),
            Err(complaint) => bad.push(complaint),
        }
    }
    if !bad.is_empty() {
        return Err(Failure::Complaints(bad));
    }
    let calibrated = calibrate(&rig_text, &rig, &records, &CalibrationOptions::default())?;
    let text = rig.text_at(&calibrated.text, &arguments.output)?;
    write_file(&arguments.output, |file| file.write_all(text.as_bytes()))?;
    if let Some(path) = &arguments.report {
        write_page(path, &pages::calibration::html(&rig, &calibrated, &records)?)?;
    }
    // With `-o /dev/stdout` the summary would stand in the rig file.
    if is_kept(&arguments.output) {
        let provenance = Provenance::of(&rig, &records);
        match arguments.format {
            Format::Json => write_json(out, &WithProvenance { result: &calibrated.report, provenance })?,
            Format::Text => {
                let report = &calibrated.report;
                let text =
                    if arguments.all { full(report, &arguments.output) } else { brief(report, &arguments.output) };
                let text = fitted(&text);
                match arguments.all {
                    true => write!(out, "{}", provenance.below(text))?,
                    false => writeln!(out, "{text}\n`--all` shows every value, the sensors, and the error of each.")?,
                }
                writeln!(out, "{}", next_line(&next(&arguments.output, report)))?;
            }
        }
        out.flush()?;
    }
    for warning in &calibrated.report.warnings {
        terminal::note(format_args!("warning: {warning}"));
    }
    Ok(Status::Done)
}

/// No file twice.
fn check_files(arguments: &Arguments) -> Result<(), Complaint> {
    let real = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    for (index, record) in arguments.records.iter().enumerate() {
        if let Some(before) = arguments.records[..index].iter().find(|before| real(before) == real(record)) {
            return Err(Complaint::new(Kind::Duplicate, "the same record is given twice, and would count twice")
                .at(Place::file(before))
                .at(Place::file(record))
                .help("give each record once"));
        }
    }
    Ok(())
}

/// The command that leads further: where it is doubtful that machine and model are healthy, with the rig file as it was.
fn next(output: &Path, report: &CalibrationReport) -> String {
    match report.records.first().filter(|_| !report.warnings.is_empty()) {
        Some(doubtful) => {
            let [rig, record] = [&report.rig, &doubtful.record].map(|path| argument(Path::new(path)));
            format!("borescope diagnose {rig} {record}")
        }
        None => format!("borescope diagnose {} ANOTHER_RECORD", argument(output)),
    }
}
