//! Records whose columns come whole, as from formats that are no text.

use std::path::Path;

use super::header;
use super::read::{Care, Standing};
use super::{Channel, Origin, Record};
use crate::complaint::{Complaint, Kind, Place};

/// A column under its name with its unit, `p_A [bar]`.
pub(super) struct Column {
    pub name: String,
    /// NaN where there is none.
    pub values: Vec<f64>,
}

/// The record of columns in any order, among them the time.
///
/// # Errors
/// What is wrong in the names; columns of different lengths; and, unless it is surveyed, a value that is not finite or a time
/// that does not rise, with its row counted from 1.
pub(super) fn assemble(path: &Path, mut columns: Vec<Column>, care: Care) -> Result<Standing, Complaint> {
    let place = Place::file(path);
    let is_time = |column: &Column| column.name.split('[').next().unwrap_or("").trim().eq_ignore_ascii_case("time");
    if let Some(index) = columns.iter().position(is_time) {
        let time = columns.remove(index);
        columns.insert(0, time);
    }
    let names: csv::StringRecord = columns.iter().map(|column| column.name.as_str()).collect();
    let headers = header::parse(&names, &place)?;
    let rows = columns.first().map_or(0, |time| time.values.len());
    if rows == 0 {
        return Err(Complaint::new(Kind::Empty, "the record has no rows").at(place).help("one row for each time"));
    }
    let mut refused: Option<Complaint> = None;
    let mut refuse = |complaint: Complaint| match care {
        Care::Strict => Err(complaint),
        Care::Survey => {
            refused.get_or_insert(complaint);
            Ok(())
        }
    };
    let mut series = Vec::new();
    for (header, column) in headers.into_iter().zip(columns) {
        let complain = |kind, what: String| Complaint::new(kind, what).at(place.clone());
        if column.values.len() != rows {
            let what = format!("the column `{}` has {} values for {rows} times", header.name, column.values.len());
            return Err(complain(Kind::Shape, what).help("one value for each time"));
        }
        if let Some(row) = column.values.iter().position(|value| !value.is_finite()) {
            let what = format!("column `{}` has no finite number in row {}", header.name, row + 1);
            refuse(complain(Kind::Number, what).help("remove rows with gaps, or split the record there"))?;
        }
        let values: Vec<f64> = column.values.iter().map(|value| header.unit.to_si(*value)).collect();
        if series.is_empty()
            && let Some(row) = values.windows(2).position(|pair| pair[1] <= pair[0])
        {
            let what =
                format!("the time does not rise to {} {} in row {}", column.values[row + 1], header.unit, row + 2);
            refuse(complain(Kind::Order, what).help("remove the repeated rows, or split the record there"))?;
        }
        series.push(Channel::new(header.name, header.unit, values));
    }
    let time = series.remove(0).values;
    // Without decimals there is nothing to say of the rounding of the time.
    let record = Record {
        path: path.to_path_buf(),
        time,
        time_decimals: None,
        channels: series,
        header_line: 1,
        origin: Origin::default(),
    };
    Ok((record, refused))
}
