//! Records that are read piece by piece, so that no more of them is in memory than is looked at.

use std::io::{self, Cursor, Read};
use std::path::Path;

use super::binary::Binary;
use super::care::{Care, Standing};
use super::packed::{Bytes, not_read, unpacking};
use super::rows::Rows;
use super::{Asked, Record};
use crate::complaint::{Complaint, Kind, Place};
use crate::files::{self, Open};

/// Bytes that are read at a time.
const PIECE: usize = 1 << 20;
/// Most bytes of a line: as many columns as a record may have, each with a name of 256 bytes.
const LONGEST: usize = 1 << 20;
/// Bytes by which a format is known.
const HEAD: u64 = 16;

/// A file that is begun: unpacked as it comes, and its format known.
pub(super) enum Begun<'a> {
    Text(Box<Stream<'a>>),
    Binary { format: Binary, from: Bytes, packing: Option<&'static str> },
}

/// Looks what a file is. Of a text no more than `most` bytes are read.
///
/// # Errors
/// A file that cannot be read, and kinds of packing that are not unpacked.
pub(super) fn begin<'a>(
    path: &'a Path,
    from: Bytes,
    care: Care,
    asked: &'a Asked,
    most: u64,
) -> Result<Begun<'a>, Complaint> {
    let (head, from) = peek(from).map_err(|error| not_read(path, None, &error))?;
    let (from, packing) = unpacking(path, &head, from)?;
    let (head, from) = peek(from).map_err(|error| not_read(path, packing, &error))?;
    Ok(match Binary::of(&head) {
        Some(format) => Begun::Binary { format, from, packing },
        None => {
            let rows = Rows::new(path, care, asked);
            let text = Text {
                from,
                packing,
                bytes: Vec::new(),
                left: most,
                most,
                begun: false,
                ended: false,
                encoding: Encoding::Ascii,
            };
            Begun::Text(Box::new(Stream { path, file: None, text, rows }))
        }
    })
}

/// The text of a file, piece by piece.
struct Text {
    from: Bytes,
    packing: Option<&'static str>,
    /// Read, but not yet taken apart.
    bytes: Vec<u8>,
    /// Bytes that may still come, of how many.
    left: u64,
    most: u64,
    begun: bool,
    ended: bool,
    encoding: Encoding,
}

/// How the characters of a text are written, as far as those show that were read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Utf8,
    Latin1,
}

impl Encoding {
    /// With these bytes behind those read so far. One of both encodings, or with control characters, stays UTF-8, as which it is
    /// refused: it is damaged, or no text.
    fn with(self, bytes: &[u8]) -> Self {
        let shows = |byte: &u8| byte.is_ascii_graphic() || matches!(byte, b' ' | b'\t' | b'\r' | b'\n' | 0xA0..);
        match self {
            Self::Ascii if bytes.is_ascii() => Self::Ascii,
            Self::Ascii if bytes.utf8_chunks().all(|chunk| chunk.valid().is_ascii()) && bytes.iter().all(shows) => {
                Self::Latin1
            }
            Self::Ascii => Self::Utf8,
            known => known,
        }
    }
}

/// A table, plain or packed with gzip or zstd, whose rows come piece by piece; each mistake is told as by [`Record::read`].
pub struct Stream<'a> {
    path: &'a Path,
    file: Option<Open>,
    text: Text,
    rows: Rows<'a>,
}

impl<'a> Stream<'a> {
    /// # Errors
    /// A file that cannot be read, and a format that is not read piece by piece.
    pub fn open(path: &'a Path, asked: &'a Asked) -> Result<Self, Complaint> {
        let mut file = files::open(path)?;
        let from = std::mem::replace(&mut file.from, Box::new(std::io::empty()));
        match begin(path, from, Care::Strict, asked, u64::MAX)? {
            Begun::Text(stream) => Ok(Self { file: Some(file), ..*stream }),
            Begun::Binary { format, .. } => Err(format.not_in_pieces(path)),
        }
    }

    /// All rows, and what was recognised of the file.
    ///
    /// # Errors
    /// Those of [`Record::read`].
    pub(super) fn read_whole(mut self) -> Result<(Standing, String), Complaint> {
        while !self.text.ended {
            let text = self.text.next(self.path, self.rows.line())?;
            self.rows.feed(&text, self.text.ended)?;
        }
        let (format, packed) = (self.format(), self.packed());
        let (standing, dialect) = self.rows.finish()?;
        Ok((standing, format!("{format}, {dialect}{packed}")))
    }

    fn format(&self) -> &'static str {
        if self.text.encoding == Encoding::Latin1 { "CSV in Latin-1" } else { "CSV" }
    }

    fn packed(&self) -> String {
        self.text.packing.map_or(String::new(), |packing| format!(", packed with {packing}"))
    }

    /// The next rows, some or many; `None` behind the last one.
    ///
    /// # Errors
    /// Those of [`Record::read`], with the line in the file.
    pub fn next_rows(&mut self) -> Result<Option<Record>, Complaint> {
        while !self.text.ended {
            let text = self.text.next(self.path, self.rows.line())?;
            self.rows.feed(&text, self.text.ended)?;
            if self.text.ended {
                self.rows.check_whole()?;
                self.file.as_ref().map_or(Ok(()), |file| file.check_unchanged(self.path))?;
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
        Ok(format!("{}, {}{}", self.format(), self.rows.check_whole()?, self.packed()))
    }
}

impl Text {
    /// The next whole lines, the first of which is `line`. What is left behind them is more than blanks, so that the last
    /// row is known as such.
    fn next(&mut self, path: &Path, line: usize) -> Result<String, Complaint> {
        let mut cut = None;
        while cut.is_none() && !self.ended {
            self.fill(path)?;
            cut = self.cut();
            if self.longest_line(cut) > LONGEST {
                return Err(too_long(path, line, self.bytes.iter().any(is_break)));
            }
        }
        let rest = if self.ended { Vec::new() } else { self.bytes.split_off(cut.unwrap_or(0)) };
        let bytes = std::mem::replace(&mut self.bytes, rest);
        self.encoding = self.encoding.with(&bytes);
        if self.encoding == Encoding::Latin1 {
            // The characters of Latin-1 are the first of Unicode.
            self.begun = true;
            return Ok(bytes.into_iter().map(char::from).collect());
        }
        if std::mem::replace(&mut self.begun, true) {
            files::text_behind(path, bytes, line - 1)
        } else {
            files::text(path, bytes)
        }
    }

    fn fill(&mut self, path: &Path) -> Result<(), Complaint> {
        let read = self.from.by_ref().take(PIECE as u64).read_to_end(&mut self.bytes);
        let count = read.map_err(|error| not_read(path, self.packing, &error))?;
        self.left = self.left.checked_sub(count as u64).ok_or_else(|| files::too_large(path, self.most))?;
        self.ended = count < PIECE;
        Ok(())
    }

    /// Bytes of the last line that is there, at least; a longer one before it was whole in memory when it was the last.
    fn longest_line(&self, cut: Option<usize>) -> usize {
        self.bytes.len() - cut.unwrap_or(0)
    }

    /// Where the last line ends behind which something stands.
    fn cut(&self) -> Option<usize> {
        let something = self.bytes.iter().rposition(|byte| !byte.is_ascii_whitespace())?;
        self.bytes[..something].iter().rposition(is_break).map(|at| at + 1)
    }
}

fn too_long(path: &Path, line: usize, blank: bool) -> Complaint {
    let what = if blank { "nothing but blank lines" } else { "no line break" };
    Complaint::new(Kind::Bounds, format!("there is {what} in {} MiB", LONGEST >> 20))
        .at(Place::line(path, line))
        .help("a record is a table of lines; this file is something else, or damaged")
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
