//! Files at the edge: whole texts in, whole files out, each failure a message to the user.

#[cfg(feature = "cli")]
mod outputs;
mod temporary;
mod write;

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use sha2::{Digest, Sha256};

use crate::complaint::{Complaint, Kind, Place};

#[cfg(feature = "cli")]
pub use outputs::Outputs;
#[cfg(all(unix, feature = "cli"))]
pub(crate) use temporary::remove_unfinished;
#[cfg(feature = "store")]
pub use write::check_folder;
#[cfg(feature = "cli")]
pub(crate) use write::is_closed_pipe;
pub use write::write_atomically;
#[cfg(feature = "cli")]
pub use write::{is_kept, is_standard_output};

const UTF8_MARK: &[u8] = b"\xEF\xBB\xBF";
const UTF16_MARKS: [&[u8]; 2] = [b"\xFF\xFE", b"\xFE\xFF"];

/// The bytes of a file, as they were at one moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Content {
    /// Every byte.
    pub bytes: Vec<u8>,
    /// When the file was last written to; `None` where the system does not say, as of a pipe.
    pub modified: Option<SystemTime>,
}

/// SHA-256 of bytes, in hexadecimal digits.
pub fn digest(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Reads a whole file of at most `most` bytes; `-` is the standard input.
///
/// # Errors
/// A file that does not exist or cannot be read, a folder, one that is larger, and one that changes while it is read.
pub fn read(path: &Path, most: u64) -> Result<Content, Complaint> {
    let failed = |error: &io::Error| not_read(path, error);
    if is_standard(path) {
        let bytes = read_up_to(io::stdin().lock(), path, most)?;
        return Ok(Content { bytes, modified: None });
    }
    let file = File::open(path).map_err(|error| failed(&error))?;
    let before = file.metadata().map_err(|error| failed(&error))?;
    if before.is_file() && before.len() > most {
        return Err(too_large(path, most));
    }
    let bytes = read_up_to(&file, path, most)?;
    let after = file.metadata().map_err(|error| failed(&error))?;
    if !before.is_file() {
        return Ok(Content { bytes, modified: None });
    }
    let modified = after.modified().ok();
    if after.len() != bytes.len() as u64 || before.modified().ok() != modified {
        return Err(changed(path));
    }
    Ok(Content { bytes, modified })
}

/// A file that is read piece by piece.
pub(crate) struct Open {
    pub from: Box<dyn Read + Send>,
    /// What it was when it was opened; of a pipe nothing.
    before: Option<(File, fs::Metadata)>,
}

/// Opens a file; `-` is the standard input.
///
/// # Errors
/// A file that does not exist or cannot be read.
pub(crate) fn open(path: &Path) -> Result<Open, Complaint> {
    let failed = |error: &io::Error| not_read(path, error);
    if is_standard(path) {
        return Ok(Open { from: Box::new(io::stdin()), before: None });
    }
    let file = File::open(path).map_err(|error| failed(&error))?;
    let metadata = file.metadata().map_err(|error| failed(&error))?;
    let again = file.try_clone().map_err(|error| failed(&error))?;
    Ok(Open { from: Box::new(file), before: metadata.is_file().then_some((again, metadata)) })
}

/// The digest of everything that was read through a [`Digesting`].
#[derive(Clone, Default)]
pub(crate) struct Digested(Arc<Mutex<Sha256>>);

impl Digested {
    /// SHA-256 in hexadecimal digits.
    pub(crate) fn digest(&self) -> String {
        hexadecimal(&self.0.lock().unwrap_or_else(PoisonError::into_inner).clone().finalize())
    }
}

/// Passes bytes on, and takes their digest on the way.
pub(crate) struct Digesting {
    from: Box<dyn Read + Send>,
    into: Digested,
}

impl Digesting {
    pub(crate) fn new(from: Box<dyn Read + Send>) -> (Self, Digested) {
        let into = Digested::default();
        (Self { from, into: into.clone() }, into)
    }
}

impl Read for Digesting {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.from.read(into)?;
        self.into.0.lock().unwrap_or_else(PoisonError::into_inner).update(into.get(..count).unwrap_or_default());
        Ok(count)
    }
}

impl Open {
    /// When the file was last written to; `None` where the system does not say, as of a pipe.
    pub(crate) fn modified(&self) -> Option<SystemTime> {
        self.before.as_ref().and_then(|(_, metadata)| metadata.modified().ok())
    }

    /// Bytes of the file; `None` of a pipe.
    pub(crate) fn length(&self) -> Option<u64> {
        self.before.as_ref().map(|(_, metadata)| metadata.len())
    }

    /// To be asked behind the last piece.
    ///
    /// # Errors
    /// A file that was written to since it was opened.
    pub(crate) fn check_unchanged(&self, path: &Path) -> Result<(), Complaint> {
        let Some((file, before)) = &self.before else { return Ok(()) };
        let after = file.metadata().map_err(|error| not_read(path, &error))?;
        let same = after.len() == before.len() && after.modified().ok() == before.modified().ok();
        if same { Ok(()) } else { Err(changed(path)) }
    }
}

fn changed(path: &Path) -> Complaint {
    Complaint::new(Kind::Unreadable, "the file changed while it was read")
        .in_file(path)
        .help("wait until it is written to its end, or read a copy")
}

/// Whether a path stands for standard input or output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn read_up_to(from: impl Read, path: &Path, most: u64) -> Result<Vec<u8>, Complaint> {
    let mut bytes = Vec::new();
    from.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(|error| not_read(path, &error))?;
    if bytes.len() as u64 > most {
        return Err(too_large(path, most));
    }
    Ok(bytes)
}

/// The complaint about a file of more than `most` bytes.
pub fn too_large(path: &Path, most: u64) -> Complaint {
    Complaint::new(Kind::Bounds, format!("the file is larger than {} MiB", most >> 20))
        .in_file(path)
        .help("split it; no more is read, so that a wrong file cannot fill the memory")
}

/// Most bytes of a text that people write, such as a rig file.
pub const MOST_TEXT: u64 = 4 << 20;

/// Reads a whole text file of at most [`MOST_TEXT`] bytes; a UTF-8 byte-order mark at its start is dropped.
///
/// # Errors
/// Those of [`read`], and bytes that are not UTF-8 (with their line).
pub fn read_text(path: &Path) -> Result<String, Complaint> {
    text(path, read(path, MOST_TEXT)?.bytes)
}

/// The bytes of the file `path` as text; a UTF-8 byte-order mark at its start is dropped.
///
/// # Errors
/// Bytes that are not UTF-8, with their line.
pub fn text(path: &Path, mut bytes: Vec<u8>) -> Result<String, Complaint> {
    if UTF16_MARKS.iter().any(|mark| bytes.starts_with(mark)) {
        return Err(Complaint::new(Kind::Encoding, "the file is UTF-16 text")
            .at(Place::line(path, 1))
            .help("save it as UTF-8"));
    }
    if bytes.starts_with(UTF8_MARK) {
        bytes.drain(..UTF8_MARK.len());
    }
    text_behind(path, bytes, 0)
}

/// The bytes of a file behind its first `lines` lines as text.
///
/// # Errors
/// Bytes that are not UTF-8, with their line.
pub(crate) fn text_behind(path: &Path, bytes: Vec<u8>, lines: usize) -> Result<String, Complaint> {
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let (before, bad) = error.as_bytes().split_at(good);
        let line = lines + before.iter().filter(|byte| **byte == b'\n').count() + 1;
        let byte = bad.first().copied().unwrap_or_default();
        Complaint::new(Kind::Encoding, format!("the byte 0x{byte:02X} is not UTF-8 text"))
            .at(Place::line(path, line))
            .help("save the file as UTF-8; write `degC` and `um` where the degree or micro sign is in the way")
    })
}

pub(crate) fn not_read(path: &Path, error: &io::Error) -> Complaint {
    let complaint = match error.kind() {
        io::ErrorKind::NotFound => Complaint::new(Kind::Missing, "there is no such file")
            .help("check the path; a relative one counts from the current folder"),
        io::ErrorKind::IsADirectory => {
            Complaint::new(Kind::Unreadable, "this is a folder, not a file").help("name one file in it")
        }
        io::ErrorKind::PermissionDenied => Complaint::new(Kind::Unreadable, "no permission to read the file")
            .help("change its permissions, or read a copy"),
        _ => Complaint::new(Kind::Unreadable, format!("cannot be read: {error}")),
    };
    complaint.in_file(path)
}
