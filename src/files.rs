//! Files at the edge: whole texts in, whole files out, each failure a message to the user.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use sha2::{Digest, Sha256};
use tempfile::{Builder, NamedTempFile};

use crate::complaint::{Complaint, Kind, Place};

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

impl Content {
    /// SHA-256 of the bytes, in hexadecimal digits.
    pub fn digest(&self) -> String {
        Sha256::digest(&self.bytes).iter().map(|byte| format!("{byte:02x}")).collect()
    }
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

impl Open {
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
            .help("check the path; it counts from the folder in which the command runs"),
        io::ErrorKind::IsADirectory => {
            Complaint::new(Kind::Unreadable, "this is a folder, not a file").help("name one file in it")
        }
        io::ErrorKind::PermissionDenied => Complaint::new(Kind::Unreadable, "no permission to read the file")
            .help("change its permissions, or read a copy"),
        _ => Complaint::new(Kind::Unreadable, format!("cannot be read: {error}")),
    };
    complaint.in_file(path)
}

/// Writes a file whole or not at all: what `write` puts out goes to a temporary file in the same folder, which takes
/// the place of `path` only when all of it is written. A device, such as `/dev/stdout`, is written directly, and so is the
/// standard output, `-`.
///
/// # Errors
/// A parent folder that does not exist, a folder in the place of the file, and everything that goes wrong in writing;
/// then `path` is as it was before.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Complaint> {
    let failed = |error: &io::Error| not_written(path, error);
    if is_standard(path) {
        let mut out = BufWriter::new(io::stdout().lock());
        return match write(&mut out).and_then(|()| out.flush()) {
            // Whoever closed the pipe has seen enough.
            Err(error) if is_closed_pipe(&error) => Ok(()),
            done => done.map_err(|error| failed(&error)),
        };
    }
    // A link stays a link: the file behind it is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let before = fs::metadata(&target).ok();
    if let Some(there) = &before {
        if there.is_dir() {
            return Err(Complaint::new(Kind::Unwritable, "this is a folder, not a file")
                .in_file(path)
                .help("name a file in it"));
        }
        if !there.is_file() {
            let file = File::options().write(true).open(&target);
            return fill(&file.map_err(|error| failed(&error))?, write).map_err(|error| failed(&error));
        }
    }
    let folder = existing_folder(&target, path)?;
    let (temporary, unfinished) = temporary_in(&folder).map_err(|error| failed(&error))?;
    fill(temporary.as_file(), write).map_err(|error| failed(&error))?;
    // A machine that loses power must not be left with the new name and nothing behind it.
    temporary.as_file().sync_data().map_err(|error| failed(&error))?;
    if let Some(there) = before {
        fs::set_permissions(temporary.path(), there.permissions()).map_err(|error| failed(&error))?;
    }
    unfinished.end(|| temporary.persist(&target)).map_err(|error| failed(&error.error))?;
    Ok(())
}

/// Temporary files of this process that have not taken their place yet. An end of the program by a signal runs no destructors,
/// so whoever ends it has to find them.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// An entry of [`UNFINISHED`].
struct Unfinished(PathBuf);

impl Unfinished {
    /// Under the lock, so that no file appears while [`remove_unfinished`] clears up.
    fn begin(create: impl FnOnce() -> io::Result<NamedTempFile>) -> io::Result<(NamedTempFile, Self)> {
        let mut all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        let file = create()?;
        let path = file.path().to_path_buf();
        all.push(path.clone());
        Ok((file, Self(path)))
    }

    /// Does `persist` under the lock, for the same reason.
    fn end<T>(&self, persist: impl FnOnce() -> T) -> T {
        let _all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        persist()
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| *path != self.0);
    }
}

/// Removes what is half-written, for a program that ends without running destructors: from here on no file of this process
/// takes its place any more.
pub(crate) fn remove_unfinished() {
    let all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in all.iter() {
        // What cannot be removed stays: there is nobody left to tell.
        let _ = fs::remove_file(path);
    }
    // Never given back: the program ends.
    std::mem::forget(all);
}

/// Refuses a file whose folder does not exist, before long work is done for it.
///
/// # Errors
/// A parent folder that does not exist.
pub fn check_folder(path: &Path) -> Result<(), Complaint> {
    existing_folder(path, path).map(|_| ())
}

/// The same, and refuses a file that the same run reads: what is written would take its place.
///
/// # Errors
/// A parent folder that does not exist, and one of the files `read`.
pub fn check_output<'a>(path: &Path, read: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Complaint> {
    check_folder(path)?;
    let Ok(target) = fs::canonicalize(path) else { return Ok(()) };
    let same = |other: &PathBuf| fs::canonicalize(other).is_ok_and(|other| other == target && other.is_file());
    if read.into_iter().any(same) {
        return Err(Complaint::new(Kind::Unwritable, "this file is read, and would be overwritten")
            .in_file(path)
            .help("name another file; this one is left as it is"));
    }
    Ok(())
}

/// Whether somebody closed the pipe that is written to.
pub(crate) fn is_closed_pipe(error: &io::Error) -> bool {
    let inner = error.get_ref().and_then(|inner| inner.downcast_ref::<csv::Error>());
    match inner.map(csv::Error::kind) {
        Some(csv::ErrorKind::Io(inner)) => inner.kind() == io::ErrorKind::BrokenPipe,
        _ => error.kind() == io::ErrorKind::BrokenPipe,
    }
}

fn existing_folder(target: &Path, path: &Path) -> Result<PathBuf, Complaint> {
    if is_standard(path) {
        return Ok(PathBuf::new());
    }
    let folder = folder_of(target);
    if folder.is_dir() {
        return Ok(folder);
    }
    Err(Complaint::new(Kind::Missing, format!("there is no folder `{}` to write into", folder.display()))
        .in_file(path)
        .help("create the folder first, or name another one"))
}

fn fill(file: &File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut buffer = BufWriter::new(file);
    write(&mut buffer)?;
    buffer.flush()
}

fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn temporary_in(folder: &Path) -> io::Result<(NamedTempFile, Unfinished)> {
    Unfinished::begin(|| new_file_in(folder))
}

#[cfg(unix)]
fn new_file_in(folder: &Path) -> io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    // A temporary file is private by default; a result is as readable as the user's mask lets any new file be.
    Builder::new().permissions(fs::Permissions::from_mode(0o666)).tempfile_in(folder)
}

#[cfg(not(unix))]
fn new_file_in(folder: &Path) -> io::Result<NamedTempFile> {
    Builder::new().tempfile_in(folder)
}

fn not_written(path: &Path, error: &io::Error) -> Complaint {
    let complaint = match error.kind() {
        io::ErrorKind::PermissionDenied => Complaint::new(Kind::Unwritable, "no permission to write the file")
            .help("name a folder that you may write to"),
        _ => Complaint::new(Kind::Unwritable, format!("cannot be written: {error}")),
    };
    complaint.in_file(path)
}
