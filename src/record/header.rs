//! The line of column names: `time [s],p_A [bar],...`.

use std::path::Path;

use super::Asked;
use super::care::MOST_COLUMNS;
use super::dialect::UnitsIn;
use super::line::Line;
use super::stamp::may_be_date;
use crate::complaint::{Complaint, Kind, Place};
use crate::units::{Dimension, Unit};
use crate::visible::unusable_name;

/// One column as the header names it.
pub(super) struct Column {
    pub name: String,
    pub unit: Unit,
}

/// The row that complaints about columns point at: that of the units where they stand in one of their own.
pub(super) struct Heading<'a> {
    pub path: &'a Path,
    pub line: Line<'a>,
    pub around: Around,
}

impl Heading<'_> {
    fn place(&self) -> Place {
        self.line.place(self.path)
    }

    fn column(&self, index: usize) -> Place {
        self.line.field(self.path, index)
    }
}

/// What is known of a row of names from those around it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Around {
    /// Whether the row below begins with a date: the first column is the time then, whatever it is called.
    pub dated: bool,
    /// Whether rows above it were passed over.
    pub titled: bool,
}

/// The columns that a header names.
pub(super) struct Header {
    /// The time first.
    pub columns: Vec<Column>,
    /// What is to be said of a time without a unit, unless the rows show that it needs none: they begin with dates.
    pub no_time_unit: Option<Complaint>,
    pub units: UnitsIn,
}

/// Whether the row below such a header may hold the units: the header has none.
pub(super) fn lacks_units(fields: &csv::StringRecord) -> bool {
    fields.len() > 1 && !has_square_brackets(fields)
}

fn has_square_brackets(fields: &csv::StringRecord) -> bool {
    fields.iter().any(|field| field.contains('['))
}

/// Whether the row may be one of units: it begins with one of time, and no field is a number.
pub(super) fn is_unit_row(fields: &csv::StringRecord) -> bool {
    let is_number = |field: &str| field.trim().replace(',', ".").parse::<f64>().is_ok();
    fields.get(0).is_some_and(|first| Unit::parse_as(bare_unit(first), Dimension::TIME).is_ok())
        // The unit `1` of a pure number is one too.
        && !fields.iter().any(|field| field.trim() != "1" && is_number(field))
}

/// Whether a row of names and the one below it are header and first row of a table.
pub(super) fn stands_above(names: &csv::StringRecord, below: &csv::StringRecord) -> bool {
    let begins_with_digit = |row: &csv::StringRecord| {
        row.get(0).is_some_and(|first| first.trim().starts_with(|c: char| c.is_ascii_digit()))
    };
    names.len() > 1
        && names.len() == below.len()
        && !begins_with_digit(names)
        && !holds_values(names)
        && begins_with_digit(below)
        && holds_values(below)
}

/// Whether a row begins with a date.
pub(super) fn is_dated(row: &csv::StringRecord) -> bool {
    row.get(0).is_some_and(|first| may_be_date(first.trim()))
}

/// Whether a field behind the first is a number or a date, which no column is called.
pub(super) fn holds_values(fields: &csv::StringRecord) -> bool {
    let is_value = |field: &str| {
        let field = field.trim();
        field.contains(|c: char| c.is_ascii_digit())
            && field.chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | ',' | ':' | '-' | '+' | '/' | ' '))
    };
    fields.iter().skip(1).any(is_value)
}

/// The names of one row, each with the unit of another row.
pub(super) fn join(
    names: &csv::StringRecord,
    units: &csv::StringRecord,
    row: &Heading<'_>,
) -> Result<csv::StringRecord, Complaint> {
    if names.len() != units.len() {
        let what = format!("the row has {} units, but the header names {} columns", units.len(), names.len());
        return Err(Complaint::new(Kind::Shape, what)
            .at(row.place())
            .help("one unit for each column, `-` for a pure number"));
    }
    let mut joined = csv::StringRecord::new();
    for (index, (name, unit)) in names.iter().zip(units).enumerate() {
        let unit = bare_unit(unit);
        if unit.is_empty() {
            return Err(Complaint::new(Kind::Unit, format!("the column `{}` has no unit", tidy(name)))
                .at(row.column(index))
                .help("one unit for each column, `-` for a pure number"));
        }
        joined.push_field(&format!("{} [{unit}]", tidy(name)));
    }
    Ok(joined)
}

fn bare_unit(field: &str) -> &str {
    field.trim().trim_start_matches(['[', '(']).trim_end_matches([']', ')']).trim()
}

/// The columns. Units may stand in round brackets where none stands in square ones: in `p (A) [bar]` the round ones are part of the
/// name.
pub(super) fn parse(fields: &csv::StringRecord, row: &Heading<'_>, asked: &Asked) -> Result<Header, Complaint> {
    check_time(fields, row)?;
    if fields.len() > MOST_COLUMNS {
        return Err(Complaint::new(Kind::Bounds, format!("the header names {} columns", fields.len()))
            .at(row.place())
            .help(format!("no more than {MOST_COLUMNS} are read; leave away those that the rig does not name")));
    }
    let units = units_in(fields);
    let mut columns: Vec<Column> = Vec::with_capacity(fields.len());
    let mut no_time_unit = None;
    for (index, field) in fields.iter().enumerate() {
        let column = match parse_column(field, index, row, asked, units) {
            Err(complaint) if index == 0 && bare_name(field) == tidy(field) => {
                no_time_unit = Some(complaint);
                Column { name: tidy(field), unit: Unit::second() }
            }
            column => column?,
        };
        if columns.iter().any(|earlier| earlier.name == column.name) {
            return Err(Complaint::new(Kind::Duplicate, format!("the column `{}` appears twice", column.name))
                .at(row.column(index))
                .help("rename or remove one of the two"));
        }
        columns.push(column);
    }
    if columns.len() < 2 {
        return Err(Complaint::new(Kind::Empty, "the record has no column beside the time")
            .at(row.place())
            .help("name the columns as `time [s],p_A [bar],...`, separated by `,`, `;` or a tab"));
    }
    Ok(Header { columns, no_time_unit, units })
}

fn units_in(fields: &csv::StringRecord) -> UnitsIn {
    if has_square_brackets(fields) {
        UnitsIn::SquareBrackets
    } else if fields.iter().any(|field| round_brackets(&tidy(field)).is_some()) {
        UnitsIn::RoundBrackets
    } else if is_underscored_time(fields.get(0).unwrap_or_default()) {
        UnitsIn::Names
    } else {
        UnitsIn::SquareBrackets
    }
}

fn is_underscored_time(field: &str) -> bool {
    underscored(&tidy(field)).is_some_and(|(_, unit)| Unit::parse_as(unit, Dimension::TIME).is_ok())
}

/// Name and unit of `name_unit`.
fn underscored(field: &str) -> Option<(&str, &str)> {
    /// Units that names of columns cannot hold, and what they have instead.
    const WRITTEN: [(&str, &str); 4] = [("pct", "%"), ("percent", "%"), ("lpm", "L/min"), ("C", "degC")];
    let (name, unit) = field.rsplit_once('_')?;
    let unit = WRITTEN.iter().find(|(written, _)| *written == unit).map_or(unit, |(_, unit)| unit);
    (!name.is_empty() && Unit::parse(unit).is_ok()).then_some((name, unit))
}

fn is_time(field: &str) -> bool {
    let letters = bare_name(field).chars().filter(|letter| !matches!(letter, ' ' | '_' | '-' | '/'));
    let name: String = letters.flat_map(char::to_lowercase).collect();
    matches!(name.as_str(), "time" | "timestamp" | "datetime")
}

/// Whether the first column of a header is the time.
pub(super) fn begins_with_time(fields: &csv::StringRecord) -> bool {
    let first = fields.get(0).unwrap_or_default();
    // `Zeit [s]` in front is the time as well, unless another column is called so.
    let unit = |field: &str| match field.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((_, unit)) => Some(unit.trim().to_owned()),
        None => round_brackets(field).map(|(_, unit)| unit.to_owned()),
    };
    let is_unit_of_time = |unit: String| Unit::parse_as(&unit, Dimension::TIME).is_ok();
    let has_unit_of_time = || unit(&tidy(first)).is_some_and(is_unit_of_time) || units_in(fields) == UnitsIn::Names;
    is_time(first) || (!fields.iter().any(is_time) && has_unit_of_time())
}

fn check_time(fields: &csv::StringRecord, row: &Heading<'_>) -> Result<(), Complaint> {
    let Around { dated, titled } = row.around;
    if begins_with_time(fields) || (dated && !fields.iter().any(is_time)) {
        return Ok(());
    }
    let first = fields.get(0).unwrap_or_default();
    let found = fields.iter().position(is_time);
    let complaint = if let Some(index) = found {
        Complaint::new(Kind::Order, format!("`time` is column {}, but must be the first", index + 1))
            .help("move the time column to the front")
    } else if first.trim().parse::<f64>().is_ok() {
        Complaint::new(Kind::MissingEntry, "the first row holds numbers, not the names of the columns")
            .help("name the columns in the first row: `time [s],p_A [bar],...`")
    } else {
        let which =
            if titled { "no line begins with the time; this one looks like the header, but its" } else { "the" };
        Complaint::new(Kind::MissingEntry, format!("{which} first column is `{}`, not the time", tidy(first))).help(
            match bare_name(first) {
                "" => "name the first column `time [s]`".to_owned(),
                name => format!("write `{name} [s]` if it is; else put the time in front"),
            },
        )
    };
    Err(complaint.at(row.column(found.unwrap_or(0))))
}

/// Name and unit of `name (unit)`.
fn round_brackets(field: &str) -> Option<(&str, &str)> {
    let (name, unit) = field.strip_suffix(')')?.rsplit_once('(')?;
    let (name, unit) = (name.trim(), unit.trim());
    (!name.is_empty() && Unit::parse(unit).is_ok()).then_some((name, unit))
}

fn parse_column(
    field: &str,
    index: usize,
    row: &Heading<'_>,
    asked: &Asked,
    units: UnitsIn,
) -> Result<Column, Complaint> {
    let number = index + 1;
    let field = tidy(field);
    let (name, unit) = match field.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((name, unit)) => (name.trim(), unit.trim()),
        None => match units {
            UnitsIn::SquareBrackets => (bare_name(&field), ""),
            UnitsIn::RoundBrackets => round_brackets(&field).unwrap_or((bare_name(&field), "")),
            // A name that ends in no unit, as that of a switch, is of a pure number.
            UnitsIn::Names => {
                underscored(&field).unwrap_or((&field, if asked.unit(&field).is_some() { "" } else { "-" }))
            }
        },
    };
    if name.is_empty() {
        return Err(Complaint::new(Kind::MissingEntry, format!("column {number} has no name"))
            .at(row.column(index))
            .help("write `name [unit]`; remove a separator at the end of the lines"));
    }
    if let Some(why) = unusable_name(name) {
        return Err(Complaint::new(Kind::Bounds, format!("the name of column {number} {why}"))
            .at(row.column(index))
            .help("write a short name of visible characters"));
    }
    let told = asked.unit(name);
    if unit.is_empty()
        && let Some(unit) = told
    {
        return Ok(Column { name: name.to_owned(), unit: unit.clone() });
    }
    if unit.is_empty() {
        return Err(Complaint::new(Kind::Unit, format!("the column `{field}` has no unit in square brackets"))
            .at(row.column(index))
            .help(match round_brackets(&field) {
                Some((name, unit)) => format!("write `{name} [{unit}]`"),
                None if number == 1 => "write `time [s]`".to_owned(),
                None => {
                    format!("write its unit behind the name, such as `{name} [bar]`; `{name} [-]` for a pure number")
                }
            }));
    }
    let unit = if number == 1 { Unit::parse_as(unit, Dimension::TIME) } else { Unit::parse(unit) };
    unit.map(|unit| Column { name: name.to_owned(), unit }).map_err(|error| {
        Complaint::new(Kind::Unit, format!("column `{name}`: {error}")).at(row.column(index)).help(error.help())
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
