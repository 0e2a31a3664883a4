//! The rows of a text that comes piece by piece: its titles, its header, its table.

use std::path::Path;

use super::care::{Care, Standing};
use super::dialect::{Dialect, UnitsIn, separator, stated_separator};
use super::header::{self, Around, Heading};
use super::line::Line;
use super::table::Row;
use super::table::{Table, unclosed_quote};
use super::{Asked, Record};
use crate::complaint::{Complaint, Kind};

/// A table whose text comes piece by piece, cut between lines.
pub(super) struct Rows<'a> {
    path: &'a Path,
    care: Care,
    asked: &'a Asked,
    begun: Option<Begun<'a>>,
    /// The line that the next piece begins with.
    line: usize,
}

/// A table whose header is read.
struct Begun<'a> {
    table: Table<'a>,
    separator: u8,
    header_line: usize,
    unit_row: Option<usize>,
    units: UnitsIn,
    /// Rows above the names of the columns.
    above: usize,
}

/// A text that begins with the names of the columns.
struct Names<'a> {
    text: &'a str,
    lines: Lines<'a>,
    separator: u8,
    /// Rows above them that were passed over.
    above: usize,
}

impl Names<'_> {
    /// Whether the row names columns: the first is the time, or the row below it holds their units.
    fn are_names(&self, path: &Path) -> bool {
        let mut piece = Piece::new(self.text, self.separator, self.lines);
        if !piece.next(path).is_ok_and(|found| found) || piece.row.len() < 2 || header::is_unit_row(&piece.row) {
            return false;
        }
        let names = std::mem::take(&mut piece.row);
        // Loggers write `Date/Time;12.03.2024 10:15` above the table.
        if header::begins_with_time(&names) && !header::holds_values(&names) {
            return true;
        }
        piece.next(path).is_ok_and(|found| found)
            && ((header::lacks_units(&names) && header::is_unit_row(&piece.row) && names.len() == piece.row.len())
                || (header::stands_above(&names, &piece.row) && header::is_dated(&piece.row)))
    }

    /// Whether the row stands above one of values, so that it names columns although the first is no time.
    fn stand_above_values(&self, path: &Path) -> bool {
        let mut piece = Piece::new(self.text, self.separator, self.lines);
        let mut next = || piece.next(path).is_ok_and(|found| found).then(|| std::mem::take(&mut piece.row));
        next().zip(next()).is_some_and(|(names, below)| header::stands_above(&names, &below))
    }
}

/// Rows above the names of the columns that may be titles.
const MOST_TITLES: usize = 50;

/// The rows of one piece of text with their lines.
struct Piece<'a> {
    text: &'a str,
    separator: u8,
    lines: Lines<'a>,
    reader: csv::Reader<&'a [u8]>,
    row: csv::StringRecord,
    /// Where in the text the row begins.
    start: usize,
}

impl<'a> Piece<'a> {
    fn new(text: &'a str, separator: u8, lines: Lines<'a>) -> Self {
        let reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .delimiter(separator)
            .from_reader(text.as_bytes());
        Self { text, separator, lines, reader, row: csv::StringRecord::new(), start: 0 }
    }

    /// Whether there is another row; it is in `row` then, and `lines` at its line.
    fn next(&mut self, path: &Path) -> Result<bool, Complaint> {
        let before = self.offset();
        let found = self.reader.read_record(&mut self.row).map_err(|error| {
            Complaint::new(Kind::Syntax, format!("cannot be split into columns: {error}")).in_file(path)
        })?;
        if found {
            self.start = self.lines.next_row(before).unwrap_or(before);
        }
        Ok(found)
    }

    /// The row as the file has it.
    fn line(&self) -> Line<'a> {
        let text = self.text.get(self.start..self.offset()).unwrap_or_default();
        Line { number: self.lines.line, text, separator: self.separator }
    }

    fn offset(&self) -> usize {
        usize::try_from(self.reader.position().byte()).unwrap_or(usize::MAX)
    }

    /// What is not yet read.
    fn rest(&self) -> &'a str {
        self.text.get(self.offset()..).unwrap_or_default()
    }
}

impl<'a> Rows<'a> {
    pub(super) fn new(path: &'a Path, care: Care, asked: &'a Asked) -> Self {
        Self { path, care, asked, begun: None, line: 1 }
    }

    /// Takes the next piece, `ends` if no other follows.
    ///
    /// # Errors
    /// The first mistake, with its line.
    pub(super) fn feed(&mut self, text: &str, ends: bool) -> Result<(), Complaint> {
        let mut lines = Lines::new(text, self.line);
        let mut piece = match &self.begun {
            Some(begun) => Piece::new(text, begun.separator, lines),
            None => match lines.next_row(0) {
                Some(start) => self.begin(text, start, lines)?,
                None => {
                    self.line = lines.line;
                    return Ok(());
                }
            },
        };
        let Some(begun) = &mut self.begun else { return Ok(()) };
        let mut pending = !piece.row.is_empty();
        while std::mem::take(&mut pending) || piece.next(self.path)? {
            // A line of blanks is no row.
            if piece.row.len() == 1 && piece.row.get(0).is_some_and(|field| field.trim().is_empty()) {
                continue;
            }
            let last = ends && piece.rest().trim_start().is_empty();
            let cut = last && !text.ends_with(['\n', '\r']);
            begun.table.push(&Row { fields: &piece.row, line: piece.line(), cut, last })?;
        }
        self.line = piece.lines.end();
        Ok(())
    }

    /// Reads the header of a text whose first row begins at byte `start`. A row of data that was read with it is left in the piece.
    fn begin<'t>(&mut self, text: &'t str, start: usize, lines: Lines<'t>) -> Result<Piece<'t>, Complaint> {
        let Names { text, lines, separator, above } = self.names(text, start, lines)?;
        let header_line = lines.line;
        let mut piece = Piece::new(text, separator, lines);
        piece.next(self.path)?;
        let names_line = piece.line();
        if names_line.text.matches('"').count() % 2 == 1 {
            return Err(unclosed_quote(names_line.place(self.path)));
        }
        let names = std::mem::take(&mut piece.row);
        let mut unit_row = None;
        let below = piece.next(self.path)?;
        let header = if below && header::lacks_units(&names) && header::is_unit_row(&piece.row) {
            unit_row = Some(piece.lines.line);
            let units = std::mem::take(&mut piece.row);
            let row = Heading { path: self.path, line: piece.line(), around: Around::default() };
            header::parse(&header::join(&names, &units, &row)?, &row, self.asked)?
        } else {
            let dated = below && header::stands_above(&names, &piece.row) && header::is_dated(&piece.row);
            let around = Around { dated, titled: above > 0 };
            header::parse(&names, &Heading { path: self.path, line: names_line, around }, self.asked)?
        };
        let units = header.units;
        let table = Table::new(self.path, separator, header, self.care);
        self.begun = Some(Begun { table, separator, header_line, unit_row, units, above });
        Ok(piece)
    }

    /// Where the names of the columns begin: behind a line that states the separator, as Excel writes it, and behind titles.
    fn names<'t>(&self, text: &'t str, start: usize, mut lines: Lines<'t>) -> Result<Names<'t>, Complaint> {
        let behind = |at: usize| text[at..].find(['\n', '\r']).map_or(text.len(), |length| at + length);
        let stated = stated_separator(&text[start..behind(start)]);
        let start = match stated {
            Some(_) => lines.next_row(behind(start)).unwrap_or(text.len()),
            None => start,
        };
        let names = |at: usize, line: usize, titles: usize| -> Result<Names<'t>, Complaint> {
            let text = &text[at..];
            let separator = stated
                .map_or_else(|| separator(text), Ok)
                .map_err(|complaint| complaint.at(Line { number: line, text, separator: b',' }.place(self.path)))?;
            let above = titles + usize::from(stated.is_some());
            Ok(Names { text, lines: Lines::new(text, line), separator, above })
        };
        let mut first = names(start, lines.line, 0);
        let mut likely = false;
        let mut at = start;
        for titles in 0..=MOST_TITLES {
            if let Ok(names) = names(at, lines.line, titles) {
                if names.are_names(self.path) {
                    return Ok(names);
                }
                if !likely && names.stand_above_values(self.path) {
                    (first, likely) = (Ok(names), true);
                }
            }
            let Some(next) = lines.next_row(behind(at)) else { break };
            at = next;
        }
        first
    }

    /// The rows since the last call; `None` before there is a header.
    pub(super) fn take(&mut self) -> Option<Record> {
        self.begun.as_mut().map(|begun| begun.table.take(begun.header_line))
    }

    /// The line that the next piece begins with.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// What can only be said at the end, and how the file is written.
    pub(super) fn check_whole(&self) -> Result<Dialect, Complaint> {
        let begun = self.begun.as_ref().ok_or_else(|| empty(self.path))?;
        begun.table.check_whole(begun.header_line)?;
        Ok(begun.dialect())
    }

    pub(super) fn finish(self) -> Result<(Standing, Dialect), Complaint> {
        let begun = self.begun.ok_or_else(|| empty(self.path))?;
        let dialect = begun.dialect();
        Ok((begun.table.finish(begun.header_line)?, dialect))
    }
}

impl Begun<'_> {
    fn dialect(&self) -> Dialect {
        let begins_at = self.table.begins_at();
        Dialect {
            separator: self.separator,
            commas: self.table.commas(),
            unit_row: self.unit_row,
            units: self.units,
            above: self.above,
            begins_at,
        }
    }
}

fn empty(path: &Path) -> Complaint {
    Complaint::new(Kind::Empty, "the file is empty")
        .in_file(path)
        .help("the first row names the columns: `time [s],p_A [bar],...`")
}

/// Finds the line of each row. The positions of the csv crate are those before the comments and blank lines that it
/// skips, so the lines are counted here.
#[derive(Clone, Copy)]
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, line: usize) -> Self {
        Self { bytes: text.as_bytes(), at: 0, line }
    }

    /// The line behind the last one.
    fn end(mut self) -> usize {
        while self.at < self.bytes.len() {
            self.step();
        }
        self.line
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
