//! Compressed files, known by their first bytes.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};

use crate::complaint::{Complaint, Kind};
use crate::files::{self, too_large};

const GZIP: &[u8] = b"\x1F\x8B";
const ZSTD: &[u8] = b"\x28\xB5\x2F\xFD";
/// Kinds of packing that are told rather than unpacked, by their first bytes.
const OTHERS: &[(&[u8], &str)] = &[
    (b"BZh", "packed with bzip2; unpack it with `bunzip2`"),
    (b"\xFD7zXZ\x00", "packed with xz; unpack it with `unxz`"),
    (b"7z\xBC\xAF\x27\x1C", "a 7z archive; unpack it"),
    (b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", "an old workbook of a spreadsheet; save the sheet as CSV"),
];

fn check_other(path: &Path, bytes: &[u8]) -> Result<(), Complaint> {
    let Some((_, what)) = OTHERS.iter().find(|(mark, _)| bytes.starts_with(mark)) else { return Ok(()) };
    let (what, help) = what.split_once("; ").unwrap_or((what, ""));
    Err(Complaint::new(Kind::Syntax, format!("the file is {what}")).in_file(path).help(help))
}

/// Bytes that come piece by piece.
pub(super) type Bytes = Box<dyn Read + Send>;

/// The bytes of a file that begins with `head`, unpacked as they come, and with what it is packed.
///
/// # Errors
/// Kinds of packing that are not unpacked.
pub(super) fn unpacking(path: &Path, head: &[u8], from: Bytes) -> Result<(Bytes, Option<&'static str>), Complaint> {
    if head.starts_with(GZIP) {
        return Ok((Box::new(MultiGzDecoder::new(from)), Some("gzip")));
    }
    if head.starts_with(ZSTD) {
        return Ok((Box::new(Frames::Between(BufReader::new(from))), Some("zstd")));
    }
    check_other(path, head)?;
    Ok((from, None))
}

/// Frames of zstd, one behind the other.
enum Frames {
    Between(BufReader<Bytes>),
    Within(Box<StreamingDecoder<BufReader<Bytes>, FrameDecoder>>),
    Ended,
}

impl Read for Frames {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            *self = match std::mem::replace(self, Self::Ended) {
                Self::Between(mut from) => {
                    if from.fill_buf()?.is_empty() {
                        return Ok(0);
                    }
                    Self::Within(Box::new(StreamingDecoder::new(from).map_err(io::Error::other)?))
                }
                Self::Within(mut frame) => match frame.read(into)? {
                    0 => Self::Between(frame.into_inner()),
                    count => {
                        *self = Self::Within(frame);
                        return Ok(count);
                    }
                },
                Self::Ended => return Ok(0),
            };
        }
    }
}

/// All bytes of a file that is no text, `most` at most.
///
/// # Errors
/// A file that is cut off, damaged or larger.
pub(super) fn gather(from: Bytes, path: &Path, packing: Option<&'static str>, most: u64) -> Result<Vec<u8>, Complaint> {
    let mut plain = Vec::new();
    let read = from.take(most.saturating_add(1)).read_to_end(&mut plain);
    read.map_err(|error| not_read(path, packing, &error))?;
    if plain.len() as u64 > most { Err(too_large(path, most)) } else { Ok(plain) }
}

/// The complaint about a file that could not be read on, packed or not.
pub(super) fn not_read(path: &Path, packing: Option<&'static str>, error: &io::Error) -> Complaint {
    packing.map_or_else(|| files::not_read(path, error), |kind| not_unpacked(path, kind, error))
}

/// The complaint about a packed file that could not be read on.
fn not_unpacked(path: &Path, kind: &str, error: &io::Error) -> Complaint {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => damaged(path, kind, "it ends too early"),
        _ => damaged(path, kind, &error.to_string()),
    }
}

fn damaged(path: &Path, kind: &str, why: &str) -> Complaint {
    Complaint::new(Kind::Syntax, format!("the file is packed with {kind}, but cannot be unpacked: {why}"))
        .in_file(path)
        .help("copy it again, or unpack it by hand and see what is left")
}
