//! The fall of the error, a named bar for each model.

use crate::number::{rounded, text};
use crate::report::brief::ErrorRow;
use crate::report::html::{Cell, Column, Mark, Scale, Table};

/// Errors model by model, each with a bar from zero and a tick at the noise.
pub(super) fn bars(caption: &str, rows: &[ErrorRow]) -> Table {
    let checked = rows.iter().any(|row| row.check.is_some());
    let last = |row: &ErrorRow| row.check.unwrap_or(row.fit);
    let most = rows.iter().map(last).fold(1.0, f64::max);
    let number = |value: f64| Cell::from(format!("{}x", text(rounded(value, 3))));
    let mut columns = vec![Column::text("model"), Column::number(if checked { "fit record" } else { "error" }, "")];
    if checked {
        columns.push(Column::number("check record", ""));
    }
    columns.push(Column::text("tick: the noise"));
    let cells = rows.iter().map(|row| {
        let mut cells = vec![Cell::from(row.name.clone()), number(row.fit)];
        if checked {
            cells.push(row.check.map_or(Cell::from("-"), number));
        }
        cells.push(Cell::Scale(Scale {
            from: 0.0,
            to: most,
            marks: vec![Mark::Length(last(row)), Mark::Stroke(1.0)],
            text: format!("{}: {} times the noise", row.name, text(rounded(last(row), 3))),
        }));
        cells
    });
    Table::new(caption, columns, cells.collect())
}
