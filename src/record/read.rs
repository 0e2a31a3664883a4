//! From the text of a file to a record.

use std::path::Path;

use super::binary::Binary;
use super::dialect::{Dialect, separator};
use super::packed::unpack;
use super::table::{Table, unclosed_quote};
use super::{Asked, Record, header};
use crate::complaint::{Complaint, Kind, Place};
use crate::files;

/// Most bytes of a record.
pub(super) const MOST: u64 = 1 << 30;

/// Whether what a diagnosis cannot use is refused, or taken to be told about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Care {
    /// The time rises.
    Strict,
    /// Times as they stand.
    Survey,
}

/// A record, and what a strict reader would have said of it.
pub(super) type Standing = (Record, Option<Complaint>);

/// The record, and under [`Care::Survey`] the complaint that a strict reader would have made.
pub(super) fn read(path: &Path, care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    let content = files::read(path, MOST)?;
    let (digest, modified) = (content.digest(), content.modified);
    let (mut record, refused) = of_bytes(path, content.bytes, care, asked)?;
    (record.origin.digest, record.origin.modified) = (digest, modified);
    Ok((record, refused))
}

/// The record of the bytes of a file.
pub(super) fn of_bytes(path: &Path, bytes: Vec<u8>, care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    let (bytes, packing) = unpack(path, bytes, MOST)?;
    let ((mut record, refused), mut read_as) = match Binary::of(&bytes) {
        Some(format) => (format.read(path, &bytes, care, asked)?, format.name().to_owned()),
        None => {
            let (read, dialect) = parse(path, &files::text(path, bytes)?, care, asked)?;
            (read, format!("CSV, {dialect}"))
        }
    };
    if let Some(packing) = packing {
        read_as.push_str(&format!(", packed with {packing}"));
    }
    record.origin.read_as = read_as;
    Ok((record, refused))
}

fn parse(path: &Path, text: &str, care: Care, asked: &Asked) -> Result<(Standing, Dialect), Complaint> {
    let mut lines = Lines::new(text);
    let Some(header_start) = lines.next_row(0) else {
        return Err(Complaint::new(Kind::Empty, "the file is empty")
            .in_file(path)
            .help("the first row names the columns: `time [s],p_A [bar],...`"));
    };
    let header_line = lines.line;
    let header_place = Place::line(path, header_line);
    let separator = separator(text.get(header_start..).unwrap_or_default(), &header_place)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(separator)
        .from_reader(text.as_bytes());

    let mut row = csv::StringRecord::new();
    next(&mut reader, &mut row, path)?;
    let header_end = offset(&reader);
    let quotes = text.get(header_start..header_end).map_or(0, |header| header.matches('"').count());
    if quotes % 2 == 1 {
        return Err(unclosed_quote(header_place));
    }
    let names = row.clone();
    let mut unit_row = None;
    let mut pending = false;
    let mut before = offset(&reader);
    let columns = if header::lacks_units(&names) && next(&mut reader, &mut row, path)? {
        lines.next_row(before);
        if header::is_unit_row(&row) {
            unit_row = Some(lines.line);
            let joined = header::join(&names, &row, Place::line(path, lines.line))?;
            header::parse(&joined.fields, &joined.place, asked)?
        } else {
            pending = true;
            header::parse(&names, &header_place, asked)?
        }
    } else {
        header::parse(&names, &header_place, asked)?
    };
    let mut table = Table::new(path, separator, columns, care);

    loop {
        if !pending {
            before = offset(&reader);
            if !next(&mut reader, &mut row, path)? {
                break;
            }
            lines.next_row(before);
        }
        pending = false;
        // A line of blanks is no row.
        if row.len() == 1 && row.get(0).is_some_and(|field| field.trim().is_empty()) {
            continue;
        }
        let last = text.get(offset(&reader)..).unwrap_or_default().trim_start().is_empty();
        let cut = last && !text.ends_with(['\n', '\r']);
        table.push(&row, lines.line, cut, last)?;
    }
    let commas = table.commas();
    Ok((table.finish(header_line)?, Dialect { separator, commas, unit_row }))
}

fn offset(reader: &csv::Reader<&[u8]>) -> usize {
    usize::try_from(reader.position().byte()).unwrap_or(usize::MAX)
}

fn next(reader: &mut csv::Reader<&[u8]>, row: &mut csv::StringRecord, path: &Path) -> Result<bool, Complaint> {
    reader
        .read_record(row)
        .map_err(|error| Complaint::new(Kind::Syntax, format!("cannot be split into columns: {error}")).in_file(path))
}

/// Finds the line of each row. The positions of the csv crate are those before the comments and blank lines that it
/// skips, so the lines are counted here.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        Self { bytes: text.as_bytes(), at: 0, line: 1 }
    }

    /// Moves on to byte `from`, then over blank lines and comments; gives where the row starts, if there is one.
    fn next_row(&mut self, from: usize) -> Option<usize> {
        while self.at < from {
            self.step();
        }
        loop {
            match self.bytes.get(self.at)? {
                b'\n' | b'\r' => self.step(),
                b'#' => {
                    while !matches!(self.bytes.get(self.at)?, b'\n' | b'\r') {
                        self.step();
                    }
                }
                _ => return Some(self.at),
            }
        }
    }

    fn step(&mut self) {
        let here = self.bytes.get(self.at);
        let next = self.bytes.get(self.at + 1);
        // Of a carriage return with a line feed, the line feed ends the line.
        if here == Some(&b'\n') || (here == Some(&b'\r') && next != Some(&b'\n')) {
            self.line += 1;
        }
        self.at += 1;
    }
}
