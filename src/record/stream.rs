//! Records that are read piece by piece, so that no more of them is in memory than is looked at.

use std::io::{self, Cursor, Read};
use std::path::Path;

use super::binary::Binary;
use super::packed::{Bytes, not_unpacked, unpacking};
use super::read::{Care, Rows};
use super::{Asked, Record};
use crate::complaint::{Complaint, Kind, Place};
use crate::files::{self, Open};

/// Bytes that are read at a time.
const PIECE: usize = 1 << 20;
/// Most bytes of a line.
const LONGEST: usize = 1 << 24;
/// Bytes by which a format is known.
const HEAD: u64 = 16;

/// A table, plain or packed with gzip or zstd, whose rows come piece by piece; each mistake is told as by [`Record::read`].
pub struct Stream<'a> {
    path: &'a Path,
    file: Open,
    from: Bytes,
    packing: Option<&'static str>,
    rows: Rows<'a>,
    /// Read, but not yet taken apart.
    bytes: Vec<u8>,
    begun: bool,
    ended: bool,
}

impl<'a> Stream<'a> {
    /// # Errors
    /// A file that cannot be read, and a format that is not read piece by piece.
    pub fn open(path: &'a Path, asked: &'a Asked) -> Result<Self, Complaint> {
        let mut file = files::open(path)?;
        let from = std::mem::replace(&mut file.from, Box::new(std::io::empty()));
        let (head, from) = peek(from).map_err(|error| not_read(path, None, &error))?;
        let (from, packing) = unpacking(path, &head, from)?;
        let (head, from) = peek(from).map_err(|error| not_read(path, packing, &error))?;
        if let Some(format) = Binary::of(&head) {
            return Err(format.not_in_pieces(path));
        }
        let rows = Rows::new(path, Care::Strict, asked);
        Ok(Self { path, file, from, packing, rows, bytes: Vec::new(), begun: false, ended: false })
    }

    /// The next rows, some or many; `None` behind the last one.
    ///
    /// # Errors
    /// Those of [`Record::read`], with the line in the file.
    pub fn next_rows(&mut self) -> Result<Option<Record>, Complaint> {
        while !self.ended {
            let text = self.text()?;
            self.rows.feed(&text, self.ended)?;
            if self.ended {
                self.rows.check_whole()?;
                self.file.check_unchanged(self.path)?;
            }
            if let Some(rows) = self.rows.take().filter(|rows| !rows.time.is_empty()) {
                return Ok(Some(rows));
            }
        }
        Ok(None)
    }

    /// What was recognised of the file; to be asked behind its end.
    ///
    /// # Errors
    /// As [`Stream::next_rows`].
    pub fn read_as(&self) -> Result<String, Complaint> {
        let packed = self.packing.map_or(String::new(), |packing| format!(", packed with {packing}"));
        Ok(format!("CSV, {}{packed}", self.rows.check_whole()?))
    }

    /// The next whole lines. What is left behind them is more than blanks, so that the last row is known as such.
    fn text(&mut self) -> Result<String, Complaint> {
        let mut cut = None;
        while cut.is_none() && !self.ended {
            self.fill()?;
            cut = self.cut();
            if cut.is_none() && self.bytes.len() > LONGEST {
                return Err(self.too_long());
            }
        }
        let rest = if self.ended { Vec::new() } else { self.bytes.split_off(cut.unwrap_or(0)) };
        let bytes = std::mem::replace(&mut self.bytes, rest);
        if std::mem::replace(&mut self.begun, true) {
            files::text_behind(self.path, bytes, self.rows.line() - 1)
        } else {
            files::text(self.path, bytes)
        }
    }

    fn fill(&mut self) -> Result<(), Complaint> {
        let read = self.from.by_ref().take(PIECE as u64).read_to_end(&mut self.bytes);
        let count = read.map_err(|error| not_read(self.path, self.packing, &error))?;
        self.ended = count < PIECE;
        Ok(())
    }

    /// Where the last line ends behind which something stands.
    fn cut(&self) -> Option<usize> {
        let something = self.bytes.iter().rposition(|byte| !byte.is_ascii_whitespace())?;
        self.bytes[..something].iter().rposition(is_break).map(|at| at + 1)
    }

    fn too_long(&self) -> Complaint {
        Complaint::new(Kind::Bounds, format!("there is no line break in {} MiB", LONGEST >> 20))
            .at(Place::line(self.path, self.rows.line()))
            .help("a record is a table of lines; this file is something else, or damaged")
    }
}

fn not_read(path: &Path, packing: Option<&'static str>, error: &io::Error) -> Complaint {
    packing.map_or_else(|| files::not_read(path, error), |kind| not_unpacked(path, kind, error))
}

fn is_break(byte: &u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// The first bytes, and all bytes.
fn peek(mut from: Bytes) -> io::Result<(Vec<u8>, Bytes)> {
    let mut head = Vec::new();
    from.by_ref().take(HEAD).read_to_end(&mut head)?;
    Ok((head.clone(), Box::new(Cursor::new(head).chain(from))))
}
