//! Tables that the formulas of a component call: CSV files beside the file that describes it.

use std::path::Path;
use std::sync::Arc;

use crate::complaint::{Complaint, Kind, Place};
use crate::expression::{Expression, Name, Sheet};
use crate::files::{digest, read_text};
use crate::rig::Beside;
use crate::rig::source::{Table, Value};
use crate::units::{Dimension, Unit};

/// Most rows of one table: a surface of 100 by 100 knots.
const MOST_ROWS: usize = 10_000;

/// A column of a file.
struct Column {
    name: String,
    dimension: Dimension,
    /// SI.
    values: Vec<f64>,
}

/// The functions that the tables of a component give to its formulas, and the files that they came from.
pub(super) fn read(table: &Table<'_>) -> Result<(Vec<Arc<Sheet>>, Vec<Beside>), Complaint> {
    let (mut sheets, mut files) = (Vec::new(), Vec::new());
    let Some(value) = table.get("tables") else { return Ok((sheets, files)) };
    for (name, value) in value.table(format!("`tables` of {}", table.what))?.named_entries()? {
        let (file, smooth, over) = line(name, &value)?;
        let path = file.beside(file.text()?);
        let text = read_text(&path).map_err(|complaint| complaint.at(file.place()))?;
        files.push(Beside { path: path.clone(), digest: digest(text.as_bytes()) });
        let columns = columns(&path, &text)?;
        let what = format!("it has {} columns, and {} are needed at least", columns.len(), over + 1);
        if columns.len() <= over {
            return Err(Complaint::new(Kind::MissingEntry, what)
                .at(Place::line(&path, 1))
                .at(file.place())
                .help("write what it is over first, then what it gives: `x [mm],force [kN]`"));
        }
        let called = |column: &Column| {
            if columns.len() == over + 1 { name.to_owned() } else { format!("{name}.{}", column.name) }
        };
        let arguments: Vec<Vec<f64>> = if over == 1 { vec![columns[0].values.clone()] } else { grid(&path, &columns)? };
        arguments.iter().zip(&columns).try_for_each(|(knots, column)| grows(&path, knots, column, over))?;
        for column in &columns[over..] {
            let (name, heights) = (called(column), column.values.clone());
            sheets.push(Arc::new(match arguments.as_slice() {
                [x, y] => {
                    let dimensions = [columns[0].dimension, columns[1].dimension, column.dimension];
                    Sheet::surface(name, dimensions, x.clone(), y.clone(), heights)
                }
                _ => Sheet::line(
                    name,
                    [columns[0].dimension, column.dimension],
                    columns[0].values.clone(),
                    heights,
                    smooth,
                ),
            }));
        }
    }
    Ok((sheets, files))
}

/// The file of a line, whether it is smooth, and over how many columns.
fn line<'a>(name: &str, value: &Value<'a>) -> Result<(Value<'a>, bool, usize), Complaint> {
    let Ok(line) = value.table(format!("table `{name}`")) else {
        value.text()?;
        return Ok((value.clone(), false, 1));
    };
    let file = line.require("file", "add the file, such as `file = \"lever.csv\"`")?;
    let smooth = line.get("smooth").map(|value| value.flag()).transpose()?.unwrap_or(false);
    let over = match line.get("over") {
        None => 1,
        Some(value) => {
            match value.quantity(Dimension::NONE)?.value {
                1.0 => 1,
                2.0 if !smooth => 2,
                _ => {
                    return Err(Complaint::new(Kind::Bounds, format!("{} is neither 1 nor 2, or smooth over two", value.what))
                    .at(value.place())
                    .help("write `over = 2` where the first two columns are the arguments; between its knots it is bilinear"));
                }
            }
        }
    };
    line.finish()?;
    Ok((file, smooth, over))
}

/// Every column, by its heading.
fn columns(path: &Path, text: &str) -> Result<Vec<Column>, Complaint> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let refuse = |number: usize, line: &str, what: String, help: &str| {
        Complaint::new(Kind::Syntax, what).at(Place::line(path, number + 1).showing(line, 0..line.len())).help(help)
    };
    let Some((first, heading)) = lines.next() else {
        return Err(Complaint::new(Kind::Empty, "the table is empty")
            .at(Place::file(path))
            .help("write a heading and rows, such as `x [mm],force [kN]`"));
    };
    let mark = [';', '\t'].into_iter().find(|mark| heading.contains(*mark)).unwrap_or(',');
    let mut units = Vec::new();
    let mut columns = Vec::new();
    for field in heading.split(mark) {
        let (name, unit) =
            field.split_once('[').map_or((field, "-"), |(name, unit)| (name, unit.trim().trim_end_matches(']')));
        let (name, unit) = (name.trim().trim_matches('"'), unit.trim());
        let unit = Unit::parse(unit).map_err(|error| refuse(first, heading, error.to_string(), &error.help()))?;
        if Expression::parse("0", &[Name::new(name, Dimension::NONE)]).is_err() || name.contains('.') {
            let help = "write one word per column, of letters, digits and `_`, and its unit: `x [mm]`";
            return Err(refuse(first, heading, format!("`{name}` cannot be named in a formula"), help));
        }
        if columns.iter().any(|column: &Column| column.name == name) {
            return Err(refuse(
                first,
                heading,
                format!("two columns are called `{name}`"),
                "take another name for one",
            ));
        }
        columns.push(Column { name: name.to_owned(), dimension: unit.dimension, values: Vec::new() });
        units.push(unit);
    }
    for (number, line) in lines {
        let fields: Vec<&str> = line.split(mark).map(str::trim).collect();
        if fields.len() != columns.len() {
            let what = format!("the row has {} fields, the heading {}", fields.len(), columns.len());
            return Err(refuse(number, line, what, "give every row a number for each column"));
        }
        if columns[0].values.len() == MOST_ROWS {
            return Err(refuse(
                number,
                line,
                format!("more than {MOST_ROWS} rows"),
                "leave out rows where little bends",
            ));
        }
        for ((field, column), unit) in fields.iter().zip(&mut columns).zip(&units) {
            match field.parse::<f64>() {
                Ok(value) if value.is_finite() => column.values.push(unit.to_si(value)),
                _ => {
                    let help = "write numbers with a point, and a `;` or `,` between them";
                    return Err(refuse(number, line, format!("`{field}` is no number"), help));
                }
            }
        }
    }
    Ok(columns)
}

/// That knots grow from row to row, and are at least two.
fn grows(path: &Path, knots: &[f64], column: &Column, over: usize) -> Result<(), Complaint> {
    let name = &column.name;
    let falls = knots.windows(2).position(|pair| pair[0] >= pair[1]);
    let what = match falls {
        None if knots.len() >= 2 => return Ok(()),
        None => format!("`{name}` has fewer than two values"),
        Some(row) if over == 1 => format!("`{name}` does not grow from row {} to the next", row + 1),
        Some(_) => format!("`{name}` does not grow"),
    };
    Err(Complaint::new(Kind::Order, what)
        .at(Place::file(path))
        .help("sort the rows by what the table is over, each value once"))
}

/// The two arguments of a surface, whose rows have every second with every first.
fn grid(path: &Path, columns: &[Column]) -> Result<Vec<Vec<f64>>, Complaint> {
    let (first, second) = (&columns[0].values, &columns[1].values);
    let count = first.iter().take_while(|value| Some(*value) == first.first()).count().max(1);
    let y = second[..count.min(second.len())].to_vec();
    let x: Vec<f64> = first.iter().step_by(count).copied().collect();
    let whole = first.len() == x.len() * count
        && (0..first.len()).all(|row| first[row] == x[row / count] && second[row] == y[row % count]);
    if whole {
        return Ok(vec![x, y]);
    }
    let (a, b) = (&columns[0].name, &columns[1].name);
    Err(Complaint::new(Kind::Order, format!("the rows are no grid of `{a}` and `{b}`"))
        .at(Place::file(path))
        .help(format!("write for each `{a}`, rising, the same values of `{b}`, rising")))
}
