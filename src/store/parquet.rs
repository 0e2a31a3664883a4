//! The table as Parquet, columns typed as they are.

use std::io::{self, Write};
#[cfg(any(feature = "cli", feature = "internals"))]
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
#[cfg(any(feature = "cli", feature = "internals"))]
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
#[cfg(any(feature = "cli", feature = "internals"))]
use parquet::record::{Field, Row};
use parquet::schema::parser::parse_message_type;

use super::export::{COLUMNS, Cell, rows};
#[cfg(any(feature = "cli", feature = "internals"))]
use super::fields::Fields;
use super::{Moment, StoredRun};
#[cfg(any(feature = "cli", feature = "internals"))]
use crate::complaint::{Complaint, Kind};

/// Writes the table as Parquet, compressed with Snappy; a number that there is not is null.
///
/// # Errors
/// A file that cannot be written.
pub fn export_parquet(runs: &[StoredRun], to: &mut dyn Write) -> io::Result<()> {
    let mut bytes = Vec::new();
    write(runs, &mut bytes).map_err(io::Error::other)?;
    to.write_all(&bytes)
}

fn write(runs: &[StoredRun], bytes: &mut Vec<u8>) -> Result<(), ParquetError> {
    let table: Vec<_> = rows(runs).collect();
    let field = |(name, cell): (&&str, &Cell<'_>)| match cell {
        Cell::Text(_) => format!("required binary {name} (STRING);"),
        Cell::Time(_) => format!("required int64 {name} (TIMESTAMP(MILLIS, true));"),
        Cell::Whole(_) => format!("required int64 {name};"),
        Cell::Number(_) => format!("optional double {name};"),
        Cell::Truth(_) => format!("required boolean {name};"),
    };
    let fields: String = COLUMNS.iter().zip(&kinds()).map(field).collect();
    let schema = Arc::new(parse_message_type(&format!("message diagnoses {{ {fields} }}"))?);
    let properties = Arc::new(WriterProperties::builder().set_compression(Compression::SNAPPY).build());
    let mut file = SerializedFileWriter::new(bytes, schema, properties)?;
    let mut group = file.next_row_group()?;
    let mut index = 0;
    while let Some(mut column) = group.next_column()? {
        let cells = || table.iter().map(|row| &row[index]);
        match column.untyped() {
            ColumnWriter::ByteArrayColumnWriter(writer) => {
                let values: Vec<ByteArray> = cells().map(|cell| ByteArray::from(text(cell))).collect();
                writer.write_batch(&values, None, None)?;
            }
            ColumnWriter::Int64ColumnWriter(writer) => {
                let values: Vec<i64> = cells().map(whole).collect();
                writer.write_batch(&values, None, None)?;
            }
            ColumnWriter::DoubleColumnWriter(writer) => {
                let values: Vec<f64> = cells().filter_map(number).collect();
                let levels: Vec<i16> = cells().map(|cell| i16::from(number(cell).is_some())).collect();
                writer.write_batch(&values, Some(&levels), None)?;
            }
            ColumnWriter::BoolColumnWriter(writer) => {
                let values: Vec<bool> = cells().map(|cell| *cell == Cell::Truth(true)).collect();
                writer.write_batch(&values, None, None)?;
            }
            _ => {}
        }
        column.close()?;
        index += 1;
    }
    group.close()?;
    file.close()?;
    Ok(())
}

/// A row that stands for the types of all, also of an empty table.
fn kinds() -> Vec<Cell<'static>> {
    let whole = ["run"];
    let times = ["measured_at", "diagnosed_at"];
    let numbers =
        ["chi2_reduced", "value", "low", "high", "healthy", "probability", "limit", "lower_bound", "upper_bound"];
    let truths = ["present", "biased"];
    let kind = |name: &&str| match *name {
        name if whole.contains(&name) => Cell::Whole(0),
        name if times.contains(&name) => Cell::Time(Moment::now()),
        name if numbers.contains(&name) => Cell::Number(None),
        name if truths.contains(&name) => Cell::Truth(false),
        _ => Cell::Text(""),
    };
    COLUMNS.iter().map(kind).collect()
}

fn text<'a>(cell: &Cell<'a>) -> &'a str {
    match cell {
        Cell::Text(text) => text,
        _ => "",
    }
}

fn whole(cell: &Cell<'_>) -> i64 {
    match cell {
        Cell::Whole(number) => *number,
        Cell::Time(moment) => (moment.seconds() * 1e3).round() as i64,
        _ => 0,
    }
}

fn number(cell: &Cell<'_>) -> Option<f64> {
    match cell {
        Cell::Number(number) => *number,
        _ => None,
    }
}

/// Hands on every row of a file.
#[cfg(any(feature = "cli", feature = "internals"))]
pub(super) fn read(
    path: &Path,
    bytes: Vec<u8>,
    mut each: impl FnMut(&dyn Fields) -> Result<(), Complaint>,
) -> Result<(), Complaint> {
    let broken = |error: ParquetError| {
        Complaint::new(Kind::Syntax, format!("the table cannot be read: {error}"))
            .in_file(path)
            .help("name a table that `borescope export` has written")
    };
    crate::record::parquet::unharmed(path, || {
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).map_err(broken)?;
        for row in reader.get_row_iter(None).map_err(broken)? {
            each(&row.map_err(broken)?)?;
        }
        Ok(())
    })
}

#[cfg(any(feature = "cli", feature = "internals"))]
impl Fields for Row {
    fn get(&self, name: &str) -> Option<String> {
        let (_, field) = self.get_column_iter().find(|(column, _)| *column == name)?;
        let text = match field {
            Field::Null => return None,
            Field::Str(text) => text.clone(),
            Field::Bool(truth) => truth.to_string(),
            Field::Long(number) => number.to_string(),
            Field::Double(number) => number.to_string(),
            Field::TimestampMillis(time) => Moment::of_seconds(*time as f64 / 1e3)?.to_string(),
            other => other.to_string(),
        };
        Some(text).filter(|text| !text.is_empty())
    }
}
