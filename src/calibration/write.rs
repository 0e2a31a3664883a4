//! The `[calibration]` of a rig file as text.

use std::fmt::Write;
use std::path::Path;

use super::CalibrationReport;
use crate::complaint::Complaint;
use crate::number::written;
use crate::rig::{Rig, Scaling, Sensor, document};
use crate::units::Unit;

/// Digits of a value and of a standard deviation.
const DIGITS: (usize, usize) = (10, 6);

/// The text of a rig file without its `[calibration]`; everything else, comments and order included, is as it was.
pub(super) fn without_calibration(path: &Path, text: &str) -> Result<String, Complaint> {
    let mut document = document(path, text)?;
    if document.remove("calibration").is_none() {
        return Ok(text.to_owned());
    }
    Ok(document.to_string())
}

/// The `[calibration]` of a calibrated rig, to be put behind the rest.
pub(super) fn section(rig: &Rig, report: &CalibrationReport) -> String {
    let mut text = String::new();
    // Writing to a `String` cannot fail.
    let _ = write_section(&mut text, rig, report);
    text
}

fn write_section(out: &mut String, rig: &Rig, report: &CalibrationReport) -> std::fmt::Result {
    let Some(calibration) = &rig.calibration else { return Ok(()) };
    writeln!(out, "\n# Calibrated on healthy records; `borescope calibrate` replaces this part.")?;
    writeln!(out, "[calibration]")?;
    let records: Vec<String> = calibration.records.iter().map(|record| quoted(record)).collect();
    writeln!(out, "records = [{}]", records.join(", "))?;
    let margins: Vec<String> = calibration.margins.iter().map(|margin| quoted(margin)).collect();
    writeln!(out, "margins = [{}]", margins.join(", "))?;
    writeln!(out, "correlation = [")?;
    for i in 0..calibration.parameters.len() {
        let row: Vec<String> = (0..=i).map(|j| calibration.correlation[(i, j)].to_string()).collect();
        writeln!(out, "    [{}],", row.join(", "))?;
    }
    writeln!(out, "]\n\n[calibration.values]")?;
    for &index in &calibration.parameters {
        let parameter = &rig.parameters[index];
        let scaled = rig.sensors.iter().find(|sensor| sensor.first_parameter == index);
        let unit = &scaled.map_or_else(|| parameter.unit.clone(), |sensor| column_unit(rig, sensor));
        let (value, sigma) = (unit.from_si(parameter.value), unit.difference_from_si(parameter.sigma));
        let stated = format!("{} +- {}", written(value, DIGITS.0, unit), written(sigma, DIGITS.1, unit));
        let remark = match report.parameters.iter().find(|told| told.id == parameter.id) {
            Some(told) if told.informed => "",
            Some(_) => "  # the records say little of it",
            None => "  # mean of the records, each has its own; wins over `initial` of the node",
        };
        writeln!(out, "{} = {}{remark}", quoted(&parameter.id), quoted(&stated))?;
    }
    if !calibration.dynamics.is_empty() {
        writeln!(
            out,
            "\n# How spools follow their commands, mean lags of parts that follow pressures, dead times of inputs.\n[calibration.dynamics]"
        )?;
    }
    for parameter in calibration.dynamics.iter().map(|&own| &rig.parameters[own]) {
        let value = written(parameter.unit.from_si(parameter.value), DIGITS.0, &parameter.unit);
        writeln!(out, "{} = {}", quoted(&parameter.id), quoted(&value))?;
    }
    for sensor in &rig.sensors {
        let unit = column_unit(rig, sensor);
        let shown = |si| quoted(&written(unit.difference_from_si(si), DIGITS.1, &unit));
        writeln!(out, "\n[calibration.sensors.{}]", toml_edit::Key::new(&sensor.name))?;
        writeln!(out, "noise = {}\ntolerance = {}", shown(sensor.noise), shown(sensor.tolerance))?;
    }
    Ok(())
}

/// The unit in which the rig file describes what a sensor writes.
fn column_unit(rig: &Rig, sensor: &Sensor) -> Unit {
    sensor.scale.as_ref().map_or_else(|| rig.sensor_unit(sensor), Scaling::of_differences)
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    toml_edit::Value::from(text).to_string()
}
