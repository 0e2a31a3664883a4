//! A calibration as text: what moved furthest and what is left in a few lines, or every value.

use std::path::Path;

use super::brief::{few, wrapped};
use super::digits::plus_minus;
use super::learn::multiple;
use super::table::{headless, headless_within};
use crate::calibration::{CalibratedParameter, CalibrationReport, ChannelFit, RecordFit};
use crate::diagnosis::problem::over_sensors;
use crate::number::{before_unit, rounded, text, with_unit};

/// Values that the short text shows.
const MOVED: usize = 5;
/// Records and names in a row that it shows.
const FEW: usize = 4;

/// What moved furthest from the data sheet, what the records left open, and the error of each record before and after.
pub fn brief(report: &CalibrationReport, output: &Path) -> String {
    let (informed, silent) = split(report);
    let mut lines = headline(report, output);
    let mut moved: Vec<&CalibratedParameter> = informed.clone();
    moved.sort_by(|a, b| deviations(b).total_cmp(&deviations(a)));
    lines.push("furthest from the data sheet, +- one standard deviation:".to_owned());
    lines.extend(headless(&moved.iter().take(MOVED).map(|one| parameter(one)).collect::<Vec<_>>()));
    if !silent.is_empty() {
        let ids: Vec<&str> = silent.iter().map(|one| one.id.as_str()).collect();
        lines.extend(wrapped(&format!("Hardly determined by the records: {}.", few(&ids, FEW)), "  "));
    }
    lines.push("error, times the sensor noise, data sheet -> calibrated:".to_owned());
    let rows = report.records.iter().take(FEW).map(|record| {
        let of = |rmse: fn(&ChannelFit) -> f64| {
            multiple(over_sensors(record.channels.iter().map(|channel| {
                let sensor = report.sensors.iter().find(|sensor| sensor.name == channel.name)?;
                Some(rmse(channel) / sensor.noise)
            })))
        };
        let change = format!("{} -> {}", of(|channel| channel.rmse_before), of(|channel| channel.rmse));
        vec![record.record.clone(), change, verdict(record)]
    });
    lines.extend(headless(&rows.collect::<Vec<_>>()));
    if report.records.len() > FEW {
        lines.push(format!("  and {} more", report.records.len() - FEW));
    }
    lines.join("\n") + "\n"
}

/// Every value, sensor and record.
pub fn full(report: &CalibrationReport, output: &Path) -> String {
    let (informed, silent) = split(report);
    let mut lines = headline(report, output);
    table(&mut lines, "parameters, +- one standard deviation", informed.iter().map(|one| parameter(one)));
    let ids: Vec<&str> = silent.iter().map(|parameter| parameter.id.as_str()).collect();
    if !ids.is_empty() {
        lines.extend(wrapped(&format!("  hardly determined by the records: {}", ids.join(", ")), "    "));
    }
    if !report.dynamics.is_empty() {
        let value = |value: f64| text(rounded(value, 4));
        let rows = report.dynamics.iter().map(|found| {
            vec![found.id.clone(), value(found.before), "->".to_owned(), before_unit(value(found.after), &found.unit)]
        });
        table(&mut lines, "dynamics, by search and without a standard deviation", rows);
    }
    let rows = report.sensors.iter().map(|sensor| {
        let shown = |value: f64| with_unit(rounded(value, 3), &sensor.unit);
        let noise = format!("noise {} -> {}", shown(sensor.noise_before), shown(sensor.noise));
        let tolerance = format!("tolerance {} -> {}", shown(sensor.tolerance_before), shown(sensor.tolerance));
        let colour = sensor.noise_correlation.filter(|r| *r > 0.0);
        let colour = colour.map_or_else(String::new, |r| format!("correlation of neighbouring samples {r}"));
        vec![sensor.name.clone(), noise, tolerance, colour]
    });
    table(&mut lines, "sensors", rows);
    let rows = report.records.iter().flat_map(|record| {
        record.channels.iter().map(|channel| {
            let shown = |value: f64| with_unit(rounded(value, 3), &channel.unit);
            let change = format!("{} -> {}", shown(channel.rmse_before), shown(channel.rmse));
            vec![channel.name.clone(), change, record.record.clone()]
        })
    });
    table(&mut lines, "error of each sensor (root mean square), data sheet -> calibrated", rows);
    let same = "  With the same values for all records. `compare` also fits what is uncertain to its record, so its error is smaller; it prints \
                the one with the values as the rig file has them beside it.";
    lines.extend(wrapped(same, "  "));
    let rows = report.records.iter().map(|record| {
        let chi2 = format!("chi2 {}", rounded(record.chi2_reduced, 3));
        vec![record.record.clone(), format!("{} rows", record.rows), chi2, verdict(record)]
    });
    table(&mut lines, "records", rows);
    lines.join("\n") + "\n"
}

/// What the records determine, and what they leave as it was.
fn split(report: &CalibrationReport) -> (Vec<&CalibratedParameter>, Vec<&CalibratedParameter>) {
    report.parameters.iter().partition(|parameter| parameter.informed)
}

fn headline(report: &CalibrationReport, output: &Path) -> Vec<String> {
    let rows: usize = report.records.iter().map(|record| record.rows).sum();
    let records = if report.records.len() == 1 { "record" } else { "records" };
    let line = format!(
        "{}: {} of {} parameters identified from {rows} rows of {} {records}",
        output.display(),
        split(report).0.len(),
        report.parameters.len(),
        report.records.len()
    );
    wrapped(&line, "  ")
}

/// How far a value moved, in standard deviations of the data sheet.
fn deviations(parameter: &CalibratedParameter) -> f64 {
    (parameter.after - parameter.before).abs() / parameter.sigma_before.max(f64::MIN_POSITIVE)
}

fn parameter(parameter: &CalibratedParameter) -> Vec<String> {
    let before = plus_minus(parameter.before, parameter.sigma_before);
    let after = before_unit(plus_minus(parameter.after, parameter.sigma_after), &parameter.unit);
    // A number, its deviation and its unit stay in one line.
    let [before, after] = [before, after].map(|cell| cell.replace(' ', "\u{a0}"));
    vec![parameter.id.clone(), before, "->".to_owned(), after]
}

fn verdict(record: &RecordFit) -> String {
    let missed: Vec<&str> = record.channels.iter().filter(|one| !one.adequate).map(|one| one.name.as_str()).collect();
    if missed.is_empty() { "explained".to_owned() } else { format!("not explained: {}", missed.join(", ")) }
}

/// A heading, and lines in columns.
fn table(lines: &mut Vec<String>, heading: &str, rows: impl Iterator<Item = Vec<String>>) {
    lines.push(format!("{heading}:"));
    lines.extend(headless_within(None, &rows.collect::<Vec<_>>()));
}
