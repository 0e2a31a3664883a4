//! A sheet of an Excel workbook, as the text of a table.

use std::fmt::Display;
use std::io::Cursor;
use std::path::Path;

use calamine::{DataRef, ExcelDateTime, Reader, SheetType, Xlsx};

use super::Asked;
use super::care::{Care, MOST, MOST_COLUMNS, Standing};
use super::rows::Rows;
use crate::complaint::{Complaint, Kind};
use crate::files::too_large;

type Workbook<'a> = Xlsx<Cursor<&'a [u8]>>;

/// The record in the one sheet that holds anything.
pub(super) fn read(path: &Path, bytes: &[u8], care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    let mut workbook = Workbook::new(Cursor::new(bytes)).map_err(|error| unreadable(path, &error))?;
    let sheets = workbook.sheets_metadata().iter().filter(|sheet| sheet.typ == SheetType::WorkSheet);
    let names: Vec<String> = sheets.map(|sheet| sheet.name.clone()).collect();
    let mut filled = Vec::new();
    for name in names {
        let text = text_of(&mut workbook, &name, path)?;
        if !text.trim().is_empty() {
            filled.push((name, text));
        }
    }
    let complain = |kind, what| Complaint::new(kind, what).in_file(path);
    let (name, text) = match filled.as_slice() {
        [one] => one,
        [] => {
            return Err(complain(Kind::Empty, "no sheet of the workbook holds anything".to_owned())
                .help("the first row names the columns: `time [s]`, `p_A [bar]`, ..."));
        }
        several => {
            let names: Vec<String> = several.iter().map(|(name, _)| format!("`{name}`")).collect();
            let what = format!("any of {} sheets may be the record: {}", names.len(), names.join(", "));
            return Err(complain(Kind::Contradiction, what)
                .help("save the sheet of the record as CSV, or as the only one of a workbook"));
        }
    };
    let mut rows = Rows::new(path, care, asked);
    rows.feed(text, true)?;
    let ((mut record, refused), dialect) = rows.finish()?;
    record.origin.read_as = format!(", sheet `{name}`{}", dialect.behind_separators());
    Ok((record, refused))
}

/// The cells between tabs, each row in the line of its number, as wide as the first one of several cells at least.
fn text_of(workbook: &mut Workbook<'_>, sheet: &str, path: &Path) -> Result<String, Complaint> {
    let mut cells = workbook.worksheet_cells_reader(sheet).map_err(|error| unreadable(path, &error))?;
    let (mut text, mut line, mut column, mut width) = (String::new(), 0, 0, None);
    while let Some(cell) = cells.next_cell().map_err(|error| unreadable(path, &error))? {
        let (own_line, own_column) = cell.get_position();
        let field = field(cell.get_value());
        if field.is_empty() {
            continue;
        }
        if own_column as usize >= MOST_COLUMNS {
            return Err(Complaint::new(
                Kind::Bounds,
                format!("the sheet `{sheet}` has more than {MOST_COLUMNS} columns"),
            )
            .in_file(path)
            .help("leave away those that the rig does not name"));
        }
        if own_line > line {
            if !text.is_empty() && !text.ends_with('\n') {
                // Titles above the table stand in one cell.
                if column > 0 {
                    width.get_or_insert(column);
                }
                tabs(&mut text, column, width.unwrap_or(column));
            }
            text.extend((line..own_line).map(|_| '\n'));
            (line, column) = (own_line, 0);
        }
        tabs(&mut text, column, own_column);
        column = own_column;
        text.push_str(&field);
        if text.len() as u64 > MOST {
            return Err(too_large(path, MOST));
        }
    }
    tabs(&mut text, column, width.unwrap_or(column));
    Ok(text + "\n")
}

fn tabs(text: &mut String, from: u32, to: u32) {
    text.extend((from..to).map(|_| '\t'));
}

fn field(value: &DataRef<'_>) -> String {
    match value {
        DataRef::Empty => String::new(),
        DataRef::Int(number) => number.to_string(),
        DataRef::Float(number) => number.to_string(),
        DataRef::Bool(truth) => truth.to_string().to_uppercase(),
        DataRef::Error(error) => error.to_string(),
        DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => quoted(text),
        DataRef::SharedString(text) => quoted(text),
        DataRef::DateTime(moment) => date(moment),
    }
}

/// A date as its text; Excel keeps no more than milliseconds.
fn date(moment: &ExcelDateTime) -> String {
    if moment.is_duration() {
        return format!("P{}D", moment.as_f64());
    }
    let (year, month, day, hour, minute, second, milli) = moment.to_ymd_hms_milli();
    format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}.{milli:03}")
}

/// A text of one line, with what separates fields in quotation marks.
fn quoted(text: &str) -> String {
    let text = text.replace(['\n', '\r'], " ");
    if text.contains(['\t', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

fn unreadable(path: &Path, error: &impl Display) -> Complaint {
    Complaint::new(
        Kind::Syntax,
        format!("the file is a ZIP archive or a workbook of a spreadsheet, which cannot be read: {error}"),
    )
    .in_file(path)
    .help("unpack it, or save the sheet as CSV")
}
