//! A record in windows of equal length.

use super::{Record, Stream};
use crate::complaint::{Complaint, Kind, Place};

/// Most rows of a window.
const MOST: usize = 1 << 20;
/// Share of a window by which rounding may put a row on the wrong side of its end.
const ROUNDING: f64 = 1e-9;

/// The number of the window of this length that a time lies in, the first of which begins at `start`, all s.
pub(crate) fn window_at(start: f64, length: f64, time: f64) -> usize {
    ((time - start) / length + ROUNDING).floor() as usize
}

/// The rows of one window.
#[derive(Debug, Clone)]
pub struct Window {
    /// How many windows end before it, those without rows included.
    pub number: usize,
    /// Begin and nominal end, s.
    pub from_s: f64,
    /// Nominal end, s.
    pub to_s: f64,
    /// Its rows.
    pub record: Record,
    /// Whether no row follows.
    pub last: bool,
}

/// The windows of a record that is read piece by piece; those without rows are left out.
pub struct Windows<'a> {
    stream: Stream<'a>,
    length: f64,
    /// Time of the first row, s.
    start: Option<f64>,
    /// Rows behind the last window.
    rows: Option<Record>,
    ended: bool,
}

impl<'a> Windows<'a> {
    /// Windows of `length` s, the first of which begins with the first row.
    pub fn new(stream: Stream<'a>, length: f64) -> Self {
        Self { stream, length, start: None, rows: None, ended: false }
    }

    /// The next window; `None` behind the last one.
    ///
    /// # Errors
    /// Those of [`Stream::next_rows`], and a window of more rows than memory is meant to hold.
    pub fn next_window(&mut self) -> Result<Option<Window>, Complaint> {
        loop {
            if let Some(window) = self.cut()? {
                return Ok(Some(window));
            }
            if self.ended {
                return Ok(None);
            }
            match (self.stream.next_rows()?, &mut self.rows) {
                (None, _) => self.ended = true,
                (Some(later), Some(rows)) => rows.append(later),
                (Some(first), none) => *none = Some(first),
            }
        }
    }

    /// What was recognised of the file; to be asked behind its end.
    ///
    /// # Errors
    /// As [`Stream::read_as`].
    pub fn read_as(&self) -> Result<String, Complaint> {
        self.stream.read_as()
    }

    /// Takes a window off the rows that are there, if it is whole.
    fn cut(&mut self) -> Result<Option<Window>, Complaint> {
        let Some(rows) = self.rows.as_mut() else { return Ok(None) };
        let Some(&first) = rows.time.first() else { return Ok(None) };
        let start = *self.start.get_or_insert(first);
        let number = window_at(start, self.length, first);
        let end = start + (number + 1) as f64 * self.length;
        let count = rows.time.partition_point(|&time| time < end - ROUNDING * self.length);
        if count > MOST {
            let what = format!("a window of {} s has more than {MOST} rows", self.length);
            return Err(Complaint::new(Kind::Bounds, what)
                .at(Place::file(&rows.path))
                .help("choose shorter windows; each is held in memory"));
        }
        let last = count == rows.time.len();
        if last && !self.ended {
            return Ok(None);
        }
        Ok(Some(Window { number, from_s: end - self.length, to_s: end, record: rows.take_first(count), last }))
    }
}
