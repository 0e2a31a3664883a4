//! Compressed files, known by their first bytes.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};

use crate::complaint::{Complaint, Kind};
use crate::files::too_large;

const GZIP: &[u8] = b"\x1F\x8B";
const ZSTD: &[u8] = b"\x28\xB5\x2F\xFD";
/// Kinds of packing that are told rather than unpacked, by their first bytes.
const OTHERS: &[(&[u8], &str)] = &[
    (b"PK\x03\x04", "a ZIP archive or a workbook of a spreadsheet; unpack it, or save the sheet as CSV"),
    (b"BZh", "packed with bzip2; unpack it with `bunzip2`"),
    (b"\xFD7zXZ\x00", "packed with xz; unpack it with `unxz`"),
    (b"7z\xBC\xAF\x27\x1C", "a 7z archive; unpack it"),
    (b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", "an old workbook of a spreadsheet; save the sheet as CSV"),
];

/// The bytes as they were before they were packed, and with what; of unpacked bytes themselves.
///
/// # Errors
/// A file that is cut off or damaged, one that unpacks to more than `most` bytes, and kinds that are not unpacked.
pub(super) fn unpack(path: &Path, bytes: Vec<u8>, most: u64) -> Result<(Vec<u8>, Option<&'static str>), Complaint> {
    if bytes.starts_with(GZIP) {
        let plain = gather(MultiGzDecoder::new(&bytes[..]), path, "gzip", most)?;
        return Ok((plain, Some("gzip")));
    }
    if bytes.starts_with(ZSTD) {
        let mut plain = Vec::new();
        let mut rest = &bytes[..];
        // One frame may follow another.
        while !rest.is_empty() {
            let frame = StreamingDecoder::new(&mut rest).map_err(|error| damaged(path, "zstd", &error.to_string()))?;
            plain.extend(gather(frame, path, "zstd", most - plain.len() as u64)?);
        }
        return Ok((plain, Some("zstd")));
    }
    check_other(path, &bytes)?;
    Ok((bytes, None))
}

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

fn gather(from: impl Read, path: &Path, kind: &str, most: u64) -> Result<Vec<u8>, Complaint> {
    let mut plain = Vec::new();
    let read = from.take(most.saturating_add(1)).read_to_end(&mut plain);
    read.map_err(|error| not_unpacked(path, kind, &error))?;
    if plain.len() as u64 > most {
        return Err(too_large(path, most));
    }
    Ok(plain)
}

/// The complaint about a packed file that could not be read on.
pub(super) fn not_unpacked(path: &Path, kind: &str, error: &io::Error) -> Complaint {
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
