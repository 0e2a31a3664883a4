//! The whole store as one table: a row for each fault of each run.

use std::io::{self, Write};

use super::StoredRun;

/// One cell of the table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell<'a> {
    /// A text.
    Text(&'a str),
    /// Milliseconds are written, UTC.
    Time(super::Moment),
    /// A whole number.
    Whole(i64),
    /// A number; `None` where there is none.
    Number(Option<f64>),
    /// Yes or no.
    Truth(bool),
}

/// Names of the columns, in their order.
pub const COLUMNS: [&str; 25] = [
    "run",
    "measured_at",
    "dated_by",
    "diagnosed_at",
    "rig",
    "rig_name",
    "rig_digest",
    "record",
    "record_digest",
    "verdict",
    "chi2_reduced",
    "model_version",
    "fault",
    "unit",
    "value",
    "low",
    "high",
    "healthy",
    "present",
    "probability",
    "biased",
    "identifiable",
    "limit",
    "lower_bound",
    "upper_bound",
];

/// The rows of the table, in the order of the runs and of the faults in each.
pub fn rows(runs: &[StoredRun]) -> impl Iterator<Item = [Cell<'_>; COLUMNS.len()]> {
    runs.iter().flat_map(|run| {
        run.faults.iter().map(move |fault| {
            [
                Cell::Whole(run.id),
                Cell::Time(run.measured_at),
                Cell::Text(&run.dated_by),
                Cell::Time(run.diagnosed_at),
                Cell::Text(&run.rig),
                Cell::Text(&run.rig_name),
                Cell::Text(&run.rig_digest),
                Cell::Text(&run.record),
                Cell::Text(&run.record_digest),
                Cell::Text(&run.verdict),
                Cell::Number(run.chi2_reduced),
                Cell::Text(&run.model_version),
                Cell::Text(&fault.id),
                Cell::Text(&fault.unit),
                Cell::Number(fault.value),
                Cell::Number(fault.low),
                Cell::Number(fault.high),
                Cell::Number(fault.healthy),
                Cell::Truth(fault.present),
                Cell::Number(fault.probability),
                Cell::Truth(fault.biased),
                Cell::Text(&fault.identifiable),
                Cell::Number(fault.limit),
                Cell::Number(fault.lower_bound),
                Cell::Number(fault.upper_bound),
            ]
        })
    })
}

/// Writes the table as CSV; a number that there is not is an empty field, and a text that a spreadsheet would take for a
/// formula stands behind an apostrophe.
///
/// # Errors
/// A file that cannot be written.
pub fn export_csv(runs: &[StoredRun], to: &mut dyn Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(to);
    table.write_record(COLUMNS)?;
    for row in rows(runs) {
        table.write_record(row.iter().map(text))?;
    }
    table.flush()
}

/// A text of strangers as the cell of a table: a spreadsheet would run one that begins as a formula does, so an apostrophe goes
/// before it, which spreadsheets take as "this is text".
pub fn plain_cell(text: &str) -> String {
    // A sign alone, as the unit of a pure number, is no formula.
    let is_formula = text.len() > 1 && text.starts_with(['=', '+', '-', '@', '\t', '\r']);
    if is_formula { format!("'{text}") } else { text.to_owned() }
}

fn text(cell: &Cell<'_>) -> String {
    match cell {
        Cell::Text(text) => plain_cell(text),
        Cell::Time(moment) => moment.to_string(),
        Cell::Whole(number) => number.to_string(),
        Cell::Number(number) => number.map_or_else(String::new, |number| number.to_string()),
        Cell::Truth(truth) => truth.to_string(),
    }
}
