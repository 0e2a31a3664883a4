//! The signature matrix of `isolability`: which residual answers to which fault, how strongly, at an operating point.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::complaint::{Complaint, Kind};
use crate::model::{self, Drive, Model};
use crate::record::Record;
use crate::report::html::{Cell, Column, Table};
use crate::report::number::{self, difference_in_unit, in_unit, rounded};
use crate::residual::{self, Detection, Sensitivity};
use crate::rig::{Fault, Rig};
use crate::simulation;
use crate::units::Unit;

/// One residual in one phase. Numbers in `unit`.
#[derive(Debug, Serialize)]
pub struct Row {
    pub residual: String,
    pub equation: &'static str,
    pub meaning: &'static str,
    pub unit: String,
    pub phase: &'static str,
    /// Windows of the operating point that count.
    pub windows: usize,
    /// Standard deviation of one window by sensor noise.
    pub sigma: f64,
    /// Standard deviation of the mean over the phase by sensor noise.
    pub sigma_of_mean: f64,
    /// One standard deviation by what is uncertain but constant.
    pub tolerance: f64,
    /// Faults that it answers to.
    pub faults: Vec<Answer>,
    /// Offsets and gains of sensors that it answers to and that are no faults of the rig.
    pub sensors: Vec<Answer>,
}

/// How a residual answers to one parameter.
#[derive(Debug, Serialize)]
pub struct Answer {
    pub id: String,
    /// Change of the parameter that `response` belongs to, in `unit`: from healthy to the far end of its range; for a
    /// sensor one standard deviation of its noise, or 1 % of gain.
    pub change: f64,
    pub unit: String,
    /// Change of the residual, in its unit.
    pub response: f64,
    /// Change of the residual per `unit` of the parameter at its healthy value.
    pub slope: f64,
    /// `response` over noise of the mean and tolerance together.
    pub deviations: f64,
}

/// The healthy rig along a record's commands and loads, or along the cycle; `None` where there is neither.
///
/// # Errors
/// An unreadable record, or one without the inputs; a healthy rig that cannot be simulated.
pub fn operating_point(rig: &Rig, input: Option<&Path>) -> Result<Option<(Drive, Record)>, Complaint> {
    let source = input.map(|path| super::read::record(rig, path)).transpose()?;
    let (drive, times) = match simulation::drive(rig, source.as_ref()) {
        Ok(found) => found,
        Err(_) if source.is_none() => return Ok(None),
        Err(complaint) => return Err(complaint),
    };
    let outputs = Model::new(rig.clone()).solve(&rig.healthy(), &drive, &times).map_err(|error| {
        Complaint::new(Kind::Computation, format!("the healthy rig could not be simulated: {error}"))
            .in_file(&rig.path)
            .help("look for values without physical sense; `borescope check` lists them all")
    })?;
    let inputs = model::input_columns(rig, &drive, &times);
    let record = model::recording(rig, "simulated", times, inputs, &outputs, None);
    Ok(Some((drive, record)))
}

/// The matrix at the healthy readings of an operating point.
///
/// # Errors
/// Columns that are missing.
pub fn rows(rig: &Rig, drive: &Drive, record: &Record) -> Result<Vec<Row>, Complaint> {
    let matrix = residual::signatures(rig, record, drive, Detection::default().window)?;
    let row = |signature: residual::Signature| {
        let unit = &signature.generator.unit;
        let (own, others): (Vec<&Sensitivity>, Vec<&Sensitivity>) = signature
            .answers
            .iter()
            .filter(|answer| answer.slope != 0.0 || answer.at_limit != 0.0)
            .partition(|answer| rig.is_fault(answer.index));
        let spread = signature.sigma_of_mean.hypot(signature.tolerance);
        let list = |answers: Vec<&Sensitivity>| answers.into_iter().map(|own| answer(rig, own, unit, spread)).collect();
        Row {
            residual: signature.generator.id.clone(),
            equation: signature.generator.equation,
            meaning: signature.generator.meaning,
            unit: unit.symbol.clone(),
            phase: signature.phase,
            windows: signature.windows,
            sigma: difference_in_unit(signature.sigma, unit),
            sigma_of_mean: difference_in_unit(signature.sigma_of_mean, unit),
            tolerance: difference_in_unit(signature.tolerance, unit),
            faults: list(own),
            sensors: list(others),
        }
    };
    Ok(matrix.into_iter().map(row).collect())
}

fn answer(rig: &Rig, answer: &Sensitivity, residual: &Unit, spread: f64) -> Answer {
    let unit = &rig.parameters[answer.index].unit;
    Answer {
        id: answer.parameter.clone(),
        change: difference_in_unit(answer.step, unit),
        unit: unit.symbol.clone(),
        response: difference_in_unit(answer.at_limit, residual),
        slope: rounded(residual.difference_from_si(answer.slope) / unit.difference_from_si(1.0), 9),
        deviations: rounded(answer.at_limit / spread, 4),
    }
}

/// Deviations from which on a field of the page is darkest.
const DARKEST: f64 = 300.0;

/// The matrix for a page: each fault of a component in deviations of noise and tolerance, as dark as it is plain.
pub fn table(rig: &Rig, rows: &[Row]) -> Table {
    let faults = of_components(rig);
    let id = |fault: &&Fault| rig.parameters[fault.parameter].id.clone();
    let row = |row: &Row| -> Vec<Cell> {
        let cell = |fault: &&Fault| {
            let answer = row.faults.iter().find(|answer| answer.id == id(fault));
            answer.map_or(Cell::Shade(String::new(), 0.0), |answer| {
                let share = (answer.deviations.abs().max(1.0).ln() / DARKEST.ln()).min(1.0);
                Cell::Shade(number::text(rounded(answer.deviations, 2)), share)
            })
        };
        let name = Cell::from(format!("{} {}, {}", row.residual, row.equation, row.phase));
        std::iter::once(name).chain(faults.iter().map(cell)).collect()
    };
    let columns = faults.iter().map(|fault| Column::text(id(fault)));
    let mut table = Table::new(
        "How far each residual moves when a fault goes to the far end of its range, in standard deviations of noise and tolerance",
        std::iter::once(Column::text("residual, phase")).chain(columns).collect(),
        rows.iter().map(row).collect(),
    );
    table.upright = true;
    table
}

/// The faults that are not of sensors: those would be most of the columns; programs find them.
fn of_components(rig: &Rig) -> Vec<&Fault> {
    let of_sensor =
        |fault: &&Fault| rig.sensors.iter().any(|sensor| fault.parameter.wrapping_sub(sensor.first_parameter) < 2);
    rig.faults.iter().filter(|fault| !of_sensor(fault)).collect()
}

/// The matrix as plain text, lines ended by line feeds: a row for each residual and phase, a column for each fault of a
/// component.
pub fn render(rig: &Rig, rows: Option<&[Row]>) -> String {
    let Some(rows) = rows else {
        return "\nNo signatures: they need an operating point, a `[cycle]` in the rig file or `--input RECORD`.\n"
            .to_owned();
    };
    if rows.is_empty() {
        return "\nNo signatures: no residual of these sensors has windows that count.\n".to_owned();
    }
    let mut text = String::new();
    // Writing to a `String` cannot fail.
    let _ = write(&mut text, rig, rows);
    text
}

fn write(text: &mut String, rig: &Rig, rows: &[Row]) -> std::fmt::Result {
    writeln!(text, "\nSignatures: how far each residual moves when a fault goes to the far end of its range.")?;
    let faults = of_components(rig);
    for (index, fault) in faults.iter().enumerate() {
        let parameter = &rig.parameters[fault.parameter];
        let far = |end: f64| (end - fault.healthy).abs();
        let end = if far(fault.bounds.1) >= far(fault.bounds.0) { fault.bounds.1 } else { fault.bounds.0 };
        let [healthy, end] =
            [fault.healthy, end].map(|si| number::with_unit(in_unit(si, &parameter.unit), &parameter.unit.symbol));
        writeln!(text, "{:>4} {} from {healthy} to {end}", index + 1, parameter.id)?;
    }
    let width = rows.iter().map(|row| row.residual.len()).max().unwrap_or(0);
    let numbers: String = (1..=faults.len()).map(|number| format!("{number:>10}")).collect();
    writeln!(
        text,
        "  {:width$}  {:8}  {:6}  {:>8}  {:>9}{numbers}  unit",
        "", "equation", "phase", "noise", "tolerance"
    )?;
    for row in rows {
        let cell = |fault: &&Fault| {
            let id = &rig.parameters[fault.parameter].id;
            let answer = row.faults.iter().find(|answer| answer.id == *id);
            match answer.map(|answer| answer.response) {
                None => format!("{:>10}", "."),
                // `+0.000` would look like a response.
                Some(response) if response.abs() < 5e-4 => format!("{:>10}", "0"),
                Some(response) => format!("{response:>+10.3}"),
            }
        };
        let cells: String = faults.iter().map(cell).collect();
        let Row { residual, equation, phase, unit, sigma_of_mean, tolerance, .. } = row;
        writeln!(
            text,
            "  {residual:width$}  {equation:8}  {phase:6}  {sigma_of_mean:>8.4}  {tolerance:>9.4}{cells}  {unit}"
        )?;
    }
    writeln!(
        text,
        "noise: one standard deviation of the mean over the phase; tolerance: of what averaging does not lower.\n\
         Offsets and gains of sensors: with `--format json`."
    )
}
