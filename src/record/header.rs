//! The line of column names: `time [s],p_A [bar],...`.

use crate::complaint::{Complaint, Kind, Place};
use crate::units::{Dimension, Unit};

/// One column as the header names it.
pub(super) struct Column {
    pub name: String,
    pub unit: Unit,
}

/// The sign between columns: the one that the header has most of outside quotes and brackets.
pub(super) fn separator(header: &str) -> u8 {
    let mut counts = [(b',', 0_usize), (b';', 0), (b'\t', 0)];
    let (mut quoted, mut bracketed) = (false, false);
    for byte in header.bytes() {
        match byte {
            b'"' => quoted = !quoted,
            b'\n' | b'\r' if !quoted => break,
            b'[' => bracketed = true,
            b']' => bracketed = false,
            _ if quoted || bracketed => {}
            _ => {
                for (sign, count) in &mut counts {
                    *count += usize::from(*sign == byte);
                }
            }
        }
    }
    let mut best = (b',', 0);
    for candidate in counts {
        if candidate.1 > best.1 {
            best = candidate;
        }
    }
    best.0
}

/// The columns, the time first.
pub(super) fn parse(fields: &csv::StringRecord, place: &Place) -> Result<Vec<Column>, Complaint> {
    check_time(fields, place)?;
    let mut columns: Vec<Column> = Vec::with_capacity(fields.len());
    for (index, field) in fields.iter().enumerate() {
        let column = parse_column(field, index + 1, place)?;
        if columns.iter().any(|earlier| earlier.name == column.name) {
            return Err(Complaint::new(Kind::Duplicate, format!("the column `{}` stands twice", column.name))
                .at(place.clone())
                .help("rename or remove one of the two"));
        }
        columns.push(column);
    }
    if columns.len() < 2 {
        return Err(Complaint::new(Kind::Empty, "the record has no column beside the time")
            .at(place.clone())
            .help("name the columns as `time [s],p_A [bar],...`, separated by `,`, `;` or a tab"));
    }
    Ok(columns)
}

fn check_time(fields: &csv::StringRecord, place: &Place) -> Result<(), Complaint> {
    let is_time = |field: &str| bare_name(field) == "time";
    let first = fields.get(0).unwrap_or_default();
    if is_time(first) {
        return Ok(());
    }
    let complaint = if let Some(index) = fields.iter().position(is_time) {
        Complaint::new(Kind::Order, format!("`time` is column {}, but must be the first", index + 1))
            .help("move the time column to the front")
    } else if first.trim().parse::<f64>().is_ok() {
        Complaint::new(Kind::MissingEntry, "the first row holds numbers, not the names of the columns")
            .help("name the columns in the first row: `time [s],p_A [bar],...`")
    } else {
        Complaint::new(Kind::MissingEntry, format!("the first column is `{}`, not the time", tidy(first)))
            .help("name the first column `time [s]`")
    };
    Err(complaint.at(place.clone()))
}

fn parse_column(field: &str, number: usize, place: &Place) -> Result<Column, Complaint> {
    let field = tidy(field);
    let (name, unit) = match field.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((name, unit)) => (name.trim(), unit.trim()),
        None => (bare_name(&field), ""),
    };
    if name.is_empty() {
        return Err(Complaint::new(Kind::MissingEntry, format!("column {number} has no name"))
            .at(place.clone())
            .help("write `name [unit]`; remove a separator at the end of the lines"));
    }
    if unit.is_empty() {
        return Err(Complaint::new(Kind::Unit, format!("the column `{field}` has no unit in square brackets"))
            .at(place.clone())
            .help(if number == 1 {
                "write `time [s]`".to_owned()
            } else {
                format!("write its unit behind the name, such as `{name} [bar]`; `{name} [-]` for a pure number")
            }));
    }
    let unit = if number == 1 { Unit::parse_as(unit, Dimension::TIME) } else { Unit::parse(unit) };
    unit.map(|unit| Column { name: name.to_owned(), unit }).map_err(|error| {
        Complaint::new(Kind::Unit, format!("column `{name}`: {error}")).at(place.clone()).help(error.help())
    })
}

/// What stands before the bracket, square or round.
fn bare_name(field: &str) -> &str {
    field.split(['[', '(']).next().unwrap_or(field).trim()
}

/// Spreadsheets break long names into lines.
fn tidy(field: &str) -> String {
    field.split_whitespace().collect::<Vec<_>>().join(" ")
}
