//! `calibrate`: what healthy records teach about a rig, written into a new rig file.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, Format, Overwriting, Status, read, terminal, write_file, write_json, write_page};
use crate::calibration::{CalibrationOptions, CalibrationReport, calibrate};
use crate::complaint::{Complaint, Kind, Place};
use crate::context::Context;
use crate::files::{is_kept, read_text};
use crate::finding::argument;
use crate::number::{before_unit, rounded, text, with_unit};
use crate::report::brief::wrapped;
use crate::report::digits::plus_minus;
use crate::report::pages;
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
        match arguments.format {
            Format::Json => write_json(out, &calibrated.report)?,
            Format::Text => {
                let mut text = Vec::new();
                write_text(&mut text, &arguments.output, &calibrated.report)?;
                out.write_all(fitted(&String::from_utf8_lossy(&text)).as_bytes())?;
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

fn write_text(out: &mut dyn Write, output: &Path, report: &CalibrationReport) -> io::Result<()> {
    let rows: usize = report.records.iter().map(|record| record.rows).sum();
    let (informed, silent): (Vec<_>, Vec<_>) = report.parameters.iter().partition(|parameter| parameter.informed);
    writeln!(
        out,
        "{}: {} of {} parameters identified from {rows} rows of {} record{}",
        output.display(),
        informed.len(),
        report.parameters.len(),
        report.records.len(),
        if report.records.len() == 1 { "" } else { "s" }
    )?;
    let cells = informed.iter().map(|parameter| {
        let before = plus_minus(parameter.before, parameter.sigma_before);
        let after = plus_minus(parameter.after, parameter.sigma_after);
        [parameter.id.clone(), before, "->".to_owned(), before_unit(after, &parameter.unit)]
    });
    write_table(out, "parameters, +- one standard deviation", cells.collect())?;
    let ids: Vec<&str> = silent.iter().map(|parameter| parameter.id.as_str()).collect();
    if !ids.is_empty() {
        for line in wrapped(&format!("  hardly determined by the records: {}", ids.join(", ")), "    ") {
            writeln!(out, "{line}")?;
        }
    }
    if !report.dynamics.is_empty() {
        let value = |value: f64| text(rounded(value, 4));
        let cells = report.dynamics.iter().map(|found| {
            [found.id.clone(), value(found.before), "->".to_owned(), before_unit(value(found.after), &found.unit)]
        });
        write_table(out, "dynamics, by search and without a standard deviation", cells.collect())?;
    }
    let cells = report.sensors.iter().map(|sensor| {
        let shown = |value: f64| with_unit(rounded(value, 3), &sensor.unit);
        let noise = format!("noise {} -> {}", shown(sensor.noise_before), shown(sensor.noise));
        let tolerance = format!("tolerance {} -> {}", shown(sensor.tolerance_before), shown(sensor.tolerance));
        let colour = sensor.noise_correlation.filter(|r| *r > 0.0);
        [
            sensor.name.clone(),
            noise,
            tolerance,
            colour.map_or_else(String::new, |r| format!("correlation of neighbouring samples {r}")),
        ]
    });
    write_table(out, "sensors", cells.collect())?;
    let cells = report.records.iter().flat_map(|record| {
        record.channels.iter().map(|channel| {
            let shown = |value: f64| with_unit(rounded(value, 3), &channel.unit);
            let change = format!("{} -> {}", shown(channel.rmse_before), shown(channel.rmse));
            [channel.name.clone(), change, record.record.clone()]
        })
    });
    write_table(out, "error of each sensor (root mean square), data sheet -> calibrated", cells.collect())?;
    let same = "  With the same values for all records. `compare` also fits what is uncertain to its record, so its error is smaller; it prints \
                the one with the values as the rig file has them beside it.";
    for line in wrapped(same, "  ") {
        writeln!(out, "{line}")?;
    }
    let cells = report.records.iter().map(|record| {
        let bad: Vec<&str> = record.channels.iter().filter(|one| !one.adequate).map(|one| one.name.as_str()).collect();
        let verdict =
            if bad.is_empty() { "explained".to_owned() } else { format!("not explained: {}", bad.join(", ")) };
        [
            record.record.clone(),
            format!("{} rows", record.rows),
            format!("chi2 {}", rounded(record.chi2_reduced, 3)),
            verdict,
        ]
    });
    write_table(out, "records", cells.collect())?;
    writeln!(out, "\nNext: {}", next(output, report))
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

/// A heading, and lines in columns.
fn write_table<const N: usize>(out: &mut dyn Write, heading: &str, rows: Vec<[String; N]>) -> io::Result<()> {
    writeln!(out, "{heading}:")?;
    let mut widths = [0; N];
    for row in &rows {
        widths.iter_mut().zip(row).for_each(|(width, cell)| *width = (*width).max(cell.chars().count()));
    }
    for row in &rows {
        let line: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        writeln!(out, "  {}", line.join("  ").trim_end())?;
    }
    Ok(())
}
