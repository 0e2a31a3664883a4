//! Records in Parquet: flat columns of numbers, each named with its unit.

use std::path::Path;

use bytes::Bytes;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use super::Asked;
use super::care::{Care, Standing};
use super::groups::{Column, Group, Groups, is_time, split_name};
use super::unharmed;
use crate::complaint::{Complaint, Kind};

/// Most rows of a record: a small file may promise more than the memory holds.
const MOST_ROWS: i64 = 50_000_000;

/// Reads the record.
///
/// # Errors
/// A file that is damaged or packed otherwise than with Snappy, columns that hold no numbers, and what is wrong in the record.
pub(super) fn read(path: &Path, bytes: &[u8], care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    let mut columns = unharmed(path, || columns(path, bytes))?;
    let mut group = Group::default();
    if let Some(index) = columns.iter().position(|column| is_time(&column.name)) {
        let time = columns.remove(index);
        (group.time, group.time_unit) = (time.values, time.unit.unwrap_or_else(|| "s".to_owned()));
    }
    group.columns = columns;
    let mut groups = Groups::default();
    groups.push(group);
    groups.assemble(path, care, asked)
}

fn unread(path: &Path, why: impl std::fmt::Display) -> Complaint {
    Complaint::new(Kind::Syntax, format!("the Parquet file cannot be read: {why}"))
        .in_file(path)
        .help("write it again, uncompressed or with Snappy, or write the record as CSV")
}

/// What is read, also where the library panics: it does at some damaged files.
pub(crate) fn unharmed<T>(path: &Path, read: impl FnOnce() -> Result<T, Complaint>) -> Result<T, Complaint> {
    unharmed::unharmed(read).unwrap_or_else(|| Err(unread(path, "it is damaged")))
}

/// The columns of the file, the time among them.
fn columns(path: &Path, bytes: &[u8]) -> Result<Vec<Column>, Complaint> {
    let damaged = |error: parquet::errors::ParquetError| unread(path, error);
    let reader = SerializedFileReader::new(Bytes::copy_from_slice(bytes)).map_err(damaged)?;
    let file = reader.metadata().file_metadata();
    if file.num_rows() > MOST_ROWS {
        return Err(Complaint::new(Kind::Bounds, format!("the file has {} rows", file.num_rows()))
            .in_file(path)
            .help(format!("no more than {MOST_ROWS} are read; split it")));
    }
    let fields = file.schema().get_fields();
    let named = |field: &std::sync::Arc<parquet::schema::types::Type>| {
        let (name, unit) = split_name(field.name());
        Column { name, unit, values: Vec::new() }
    };
    let mut columns: Vec<Column> = fields.iter().map(named).collect();
    for row in reader.get_row_iter(None).map_err(damaged)? {
        let row = row.map_err(damaged)?;
        for ((_, field), column) in row.get_column_iter().zip(&mut columns) {
            column.values.push(number(field).ok_or_else(|| {
                Complaint::new(Kind::Number, format!("the column `{}` holds no numbers, but {field}", column.name))
                    .in_file(path)
                    .help("leave it away, or write numbers; the time counts from the start of the record")
            })?);
        }
    }
    Ok(columns)
}

fn number(field: &Field) -> Option<f64> {
    Some(match field {
        Field::Null => f64::NAN,
        Field::Bool(value) => f64::from(u8::from(*value)),
        Field::Byte(value) => f64::from(*value),
        Field::Short(value) => f64::from(*value),
        Field::Int(value) => f64::from(*value),
        Field::Long(value) => *value as f64,
        Field::UByte(value) => f64::from(*value),
        Field::UShort(value) => f64::from(*value),
        Field::UInt(value) => f64::from(*value),
        Field::ULong(value) => *value as f64,
        Field::Float16(value) => f64::from(*value),
        Field::Float(value) => f64::from(*value),
        Field::Double(value) => *value,
        _ => return None,
    })
}
