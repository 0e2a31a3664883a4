//! The rows of a record, checked one by one.

use std::path::Path;

use super::Origin;
use super::care::{Care, Standing};
use super::dialect::{has_thousands, proves_decimal_comma};
use super::field::{Decimals, is_missing, since};
use super::header::{Column, Header};
use super::line::Line;
use super::stamp::{self, Stamp};
use super::{Channel, Record};
use crate::complaint::{Complaint, Kind, Place};
use crate::units::Unit;

/// Rows from which the number of decimals of the last column is taken as a rule.
const ROWS_FOR_A_RULE: usize = 10;

pub(super) fn unclosed_quote(place: Place) -> Complaint {
    Complaint::new(Kind::Syntax, "a quotation mark opens and is not closed").at(place).help("close it, or remove it")
}

/// Most numbers of a record, 1 GiB of memory.
const MOST_NUMBERS: usize = 1 << 27;
/// Rows of a hydraulic record are not closer, s: waves of pressure take microseconds through a fitting.
const CLOSEST: f64 = 1e-9;
/// A row of the file.
pub(super) struct Row<'a> {
    pub fields: &'a csv::StringRecord,
    pub line: Line<'a>,
    /// Whether the file ends in it without a line end.
    pub cut: bool,
    /// Whether it is the last one.
    pub last: bool,
}

/// The rows read so far.
pub(super) struct Table<'a> {
    path: &'a Path,
    separator: u8,
    columns: Vec<Column>,
    values: Vec<Vec<f64>>,
    decimals: Vec<Decimals>,
    care: Care,
    /// What a strict reader would have said first.
    refused: Option<Complaint>,
    /// The decimal mark of the first number that has one.
    mark: Option<u8>,
    /// The first number with a comma, its column and place, until one can only have a decimal comma.
    doubtful: Option<(String, usize, Place)>,
    /// Whether some comma can only be a decimal mark.
    proved: bool,
    last_line: usize,
    /// The time of the last row, SI, and how many rows there were.
    last_time: Option<f64>,
    rows: usize,
    /// Of the rows since the last call of [`take`](Self::take).
    held: usize,
    /// What the times count from, in their unit as written.
    begins_at: Option<f64>,
    /// The first time and its text, where the times are dates.
    first_date: Option<(Stamp, String)>,
    /// What is to be said of the header, unless the times are dates.
    no_time_unit: Option<Complaint>,
}

impl<'a> Table<'a> {
    pub(super) fn new(path: &'a Path, separator: u8, header: Header, care: Care) -> Self {
        let Header { columns, no_time_unit, .. } = header;
        let count = columns.len();
        Self {
            path,
            separator,
            columns,
            values: vec![Vec::new(); count],
            decimals: vec![Decimals::Unknown; count],
            care,
            refused: None,
            mark: None,
            doubtful: None,
            proved: false,
            last_line: 0,
            last_time: None,
            rows: 0,
            held: 0,
            begins_at: None,
            first_date: None,
            no_time_unit,
        }
    }

    /// A complaint about a field.
    fn complain(&self, kind: Kind, row: &Row<'_>, index: usize, what: String) -> Complaint {
        Complaint::new(kind, what).at(row.line.field(self.path, index))
    }

    /// Takes the next row.
    pub(super) fn push(&mut self, row: &Row<'_>) -> Result<(), Complaint> {
        if row.fields.iter().any(|field| field.contains('\n')) {
            return Err(unclosed_quote(row.line.place(self.path)));
        }
        if row.fields.len() != self.columns.len() {
            return Err(self.wrong_length(row));
        }
        self.held += self.columns.len();
        if self.held > MOST_NUMBERS {
            return Err(self
                .complain(Kind::Bounds, row, 0, format!("the record has more than {MOST_NUMBERS} numbers up to here"))
                .help("split it, leave away columns that the rig does not name, or diagnose it with `--window`"));
        }
        for (index, field) in row.fields.iter().enumerate() {
            let field = field.trim();
            let read = if index == 0 { self.time(field, row) } else { self.number(field, index, row) };
            let (written, decimals) = match read {
                // The time says where the rest belongs: it must be there.
                Err(complaint) if index == 0 || !is_missing(field) || complaint.kind == Kind::Shape => {
                    return Err(complaint);
                }
                Err(_) => (f64::NAN, None),
                Ok(number) => number,
            };
            let is_last = index + 1 == self.columns.len();
            if row.cut && is_last && written.is_finite() {
                self.check_not_cut(field, index, decimals, row)?;
            }
            let Some(column) = self.columns.get(index) else { continue };
            let value = match index {
                0 if self.first_date.is_some() => written,
                0 => column.unit.to_si(since(&mut self.begins_at, written, decimals, &column.unit)),
                _ => column.unit.to_si(written),
            };
            if index == 0
                && let Some(before) = self.last_time.replace(value)
                && value - before < CLOSEST
            {
                let complaint = self.time_not_rising(field, value - before, row);
                if self.care == Care::Strict {
                    return Err(complaint);
                }
                self.refused.get_or_insert(complaint);
            }
            if let (Some(values), Some(rule)) = (self.values.get_mut(index), self.decimals.get_mut(index)) {
                values.push(value);
                if written.is_finite() {
                    *rule = rule.with(decimals);
                }
            }
        }
        self.last_line = row.line.number;
        self.rows += 1;
        Ok(())
    }

    fn wrong_length(&self, row: &Row<'_>) -> Complaint {
        let (found, wanted) = (row.fields.len(), self.columns.len());
        let fields = if found == 1 { "field" } else { "fields" };
        // The first field too many, or where the next one is missing.
        let complain = |what| self.complain(Kind::Shape, row, found.min(wanted), what);
        if found < wanted && row.last {
            return complain(format!("the file ends in the middle of a row: {found} {fields} of {wanted}"))
                .help("the writing broke off; remove the last line, or copy the file again");
        }
        let complaint = complain(format!("the row has {found} {fields}, but the header names {wanted} columns"));
        if found > wanted && self.separator == b',' {
            complaint
                .help("one field for each column; where numbers have decimal commas, separate the columns with `;`")
        } else {
            complaint.help("one field for each column")
        }
    }

    /// The time as written, in s since the first row where it is a date, and its decimals.
    fn time(&mut self, field: &str, row: &Row<'_>) -> Result<(f64, Option<usize>), Complaint> {
        if self.rows == 0 {
            self.first_date = Stamp::parse(field).map(|stamp| (stamp, field.to_owned()));
            match (&self.first_date, self.no_time_unit.take()) {
                (Some(_), _) => self.columns[0].unit = Unit::second(),
                (None, Some(_)) if stamp::may_be_date(field) => return Err(self.not_a_date(field, row)),
                (None, Some(complaint)) => return Err(complaint),
                (None, None) => {}
            }
        }
        let Some((first, _)) = self.first_date else { return self.number(field, 0, row) };
        let stamp = Stamp::parse(field).ok_or_else(|| self.not_a_date(field, row))?;
        if stamp.zoned != first.zoned {
            let what = format!("`{field}` in column `{}`: only some of the times say their zone", self.name(0));
            return Err(self
                .complain(Kind::Contradiction, row, 0, what)
                .help("write all of them with their distance to UTC, such as `+01:00`, or all without"));
        }
        Ok((stamp.seconds_since(first), Some(stamp.decimals)))
    }

    fn not_a_date(&self, field: &str, row: &Row<'_>) -> Complaint {
        let what = format!("`{field}` in column `{}` is not a date with a time of day", self.name(0));
        self.complain(Kind::Number, row, 0, what).help(format!(
            "write all times like `{}` or `23.11.2026 10:00:00.120`: another order could be read in two ways",
            stamp::EXAMPLE
        ))
    }

    /// The number in a field, and its decimals where it is written without an exponent.
    fn number(&mut self, field: &str, index: usize, row: &Row<'_>) -> Result<(f64, Option<usize>), Complaint> {
        let mark = field.bytes().find(|byte| matches!(byte, b',' | b'.'));
        if let Some(mark) = mark {
            match self.mark {
                None => self.mark = Some(mark),
                Some(before) if before != mark => {
                    return Err(self.mixed_marks(field, before, index, row));
                }
                Some(_) => {}
            }
        }
        if mark == Some(b',') && !self.proved {
            self.proved = proves_decimal_comma(field);
            if self.doubtful.is_none() {
                self.doubtful = Some((field.to_owned(), index, row.line.field(self.path, index)));
            }
        }
        let parsed = match mark {
            Some(b',') => field.replacen(',', ".", 1).parse::<f64>(),
            _ => field.parse::<f64>(),
        };
        match parsed {
            Ok(value) if value.is_finite() => {
                let decimals = match field.bytes().position(|byte| matches!(byte, b',' | b'.')) {
                    _ if field.contains(['e', 'E']) => None,
                    Some(at) => Some(field.len() - at - 1),
                    None => Some(0),
                };
                Ok((value, decimals))
            }
            _ => Err(self.not_a_number(field, index, row)),
        }
    }

    fn name(&self, index: usize) -> &str {
        self.columns.get(index).map_or("", |column| column.name.as_str())
    }

    fn not_a_number(&self, field: &str, index: usize, row: &Row<'_>) -> Complaint {
        let name = self.name(index);
        let is_last = index + 1 == self.columns.len();
        if row.cut && is_last && (field.is_empty() || matches!(field, "-" | "+" | ".")) {
            return self.cut_number(field, index, row);
        }
        if field.is_empty() {
            return self
                .complain(Kind::Number, row, index, format!("the field of `{name}` is empty"))
                .help("every row has its time; remove the rows without");
        }
        if has_thousands(field) {
            return self
                .complain(Kind::Number, row, index, format!("`{field}` in column `{name}` has separators of thousands"))
                .help("write all numbers with the same decimal mark and without separators of thousands");
        }
        let finite = field.parse::<f64>().is_err();
        let what = if finite { "a number" } else { "a finite number" };
        let help = match (index, stamp::may_be_date(field) && !is_missing(field)) {
            (0, true) => {
                "write all times as numbers, such as seconds from the first row, or all as dates with times of day, such as \
                 `2026-11-23 10:00:00.120`"
            }
            (0, false) => "every row has its time as a number, such as `1.5`; remove the rows without",
            _ => "write a number such as `-1.5` or `2e-3`, or nothing where there is no value",
        };
        self.complain(Kind::Number, row, index, format!("`{field}` in column `{name}` is not {what}")).help(help)
    }

    fn mixed_marks(&self, field: &str, before: u8, index: usize, row: &Row<'_>) -> Complaint {
        let mark = if before == b',' { "comma" } else { "point" };
        self.complain(
            Kind::Number,
            row,
            index,
            format!("`{field}` in column `{}`: the decimal mark of this file is the {mark}", self.name(index)),
        )
        .help("write all numbers with the same decimal mark and without separators of thousands")
    }

    /// A file cut within its last number still looks whole, but for the missing decimals.
    fn check_not_cut(
        &self,
        field: &str,
        index: usize,
        decimals: Option<usize>,
        row: &Row<'_>,
    ) -> Result<(), Complaint> {
        let rule = self.decimals.get(index).and_then(|rule| rule.known());
        match (rule, decimals) {
            (Some(rule), Some(found)) if self.rows >= ROWS_FOR_A_RULE && found < rule => {
                Err(self.cut_number(field, index, row))
            }
            _ => Ok(()),
        }
    }

    fn cut_number(&self, field: &str, index: usize, row: &Row<'_>) -> Complaint {
        self.complain(Kind::Shape, row, index, format!("the file ends in the middle of a number: `{field}`"))
            .help("the writing broke off; remove the last line, or copy the file again")
    }

    fn time_not_rising(&self, field: &str, step: f64, row: &Row<'_>) -> Complaint {
        let time = match self.columns.first() {
            Some(time) if self.first_date.is_none() => format!("{field} {}", time.unit.symbol),
            _ => field.to_owned(),
        };
        let what = if step < 0.0 {
            format!("the time runs backwards to {time}")
        } else if step > 0.0 {
            format!("the time rises by {step:e} s only, to {time}")
        } else {
            format!("the time {time} repeats")
        };
        Complaint::new(Kind::Order, what)
            .at(Place::line(self.path, self.last_line))
            .at(row.line.field(self.path, 0))
            .help(
                "the time rises from row to row; sort the rows, remove those that repeat, or split the record where the clock \
                 was set",
            )
    }

    /// What the times are counted from, where that is not 0 s.
    pub(super) fn begins_at(&self) -> Option<String> {
        if let Some((_, text)) = &self.first_date {
            return Some(text.clone());
        }
        let unit = &self.columns.first()?.unit;
        self.begins_at.filter(|start| *start != 0.0).map(|start| format!("{} s", unit.to_si(start)))
    }

    /// Whether the decimal mark is the comma.
    pub(super) fn commas(&self) -> bool {
        self.mark == Some(b',')
    }

    /// What can only be said at the end of the file.
    ///
    /// # Errors
    /// Numbers with a comma that may be of thousands; no rows.
    pub(super) fn check_whole(&self, header_line: usize) -> Result<(), Complaint> {
        if let Some((field, index, place)) = self.doubtful.as_ref().filter(|_| !self.proved) {
            let what = format!(
                "`{field}` in column `{}` may be {} or {}, and so may all numbers with a comma",
                self.name(*index),
                field.replace(',', "."),
                field.replace(',', "")
            );
            return Err(Complaint::new(Kind::Contradiction, what).at(place.clone()).help(
                "write the numbers with decimal points and without separators of thousands, or some with another number \
                 of decimals",
            ));
        }
        if self.rows == 0 {
            return Err(Complaint::new(Kind::Empty, "the record has no rows below its header")
                .at(Place::line(self.path, header_line))
                .help("one row of numbers for each time"));
        }
        Ok(())
    }

    /// The rows since the last call, as a record.
    pub(super) fn take(&mut self, header_line: usize) -> Record {
        self.held = 0;
        let mut decimals = self.decimals.iter().map(|rule| rule.known());
        let mut columns = self.columns.iter().zip(self.values.iter_mut().map(std::mem::take));
        let (time_unit, time) = columns
            .next()
            .map_or_else(|| (Unit::second(), Vec::new()), |(column, values)| (column.unit.clone(), values));
        // Decimals of milliseconds are not those of seconds.
        let time_decimals = decimals.next().flatten().filter(|_| time_unit.factor == 1.0);
        let channel = |((column, values), decimals): ((&Column, Vec<f64>), Option<usize>)| Channel {
            name: column.name.clone(),
            unit: column.unit.clone(),
            values,
            decimals,
        };
        let channels = columns.zip(decimals).map(channel).collect();
        let (path, origin) = (self.path.to_path_buf(), Origin::default());
        Record { path, time, time_decimals, channels, header_line, origin }
    }

    pub(super) fn finish(mut self, header_line: usize) -> Result<Standing, Complaint> {
        self.check_whole(header_line)?;
        Ok((self.take(header_line), self.refused))
    }
}
