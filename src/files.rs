//! Files at the edge: whole texts in, whole files out, each failure a message to the user.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::complaint::{Complaint, Kind, Place};

const UTF8_MARK: &[u8] = b"\xEF\xBB\xBF";
const UTF16_MARKS: [&[u8]; 2] = [b"\xFF\xFE", b"\xFE\xFF"];

/// Reads a whole text file; a UTF-8 byte-order mark at its start is dropped.
///
/// # Errors
/// A file that does not exist or cannot be read, a folder, and bytes that are not UTF-8 (with their line).
pub fn read_text(path: &Path) -> Result<String, Complaint> {
    let mut bytes = fs::read(path).map_err(|error| not_read(path, &error))?;
    if UTF16_MARKS.iter().any(|mark| bytes.starts_with(mark)) {
        return Err(Complaint::new(Kind::Encoding, "the file is UTF-16 text")
            .at(Place::line(path, 1))
            .help("save it as UTF-8"));
    }
    if bytes.starts_with(UTF8_MARK) {
        bytes.drain(..UTF8_MARK.len());
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let (before, bad) = error.as_bytes().split_at(good);
        let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
        let byte = bad.first().copied().unwrap_or_default();
        Complaint::new(Kind::Encoding, format!("the byte 0x{byte:02X} is not UTF-8 text"))
            .at(Place::line(path, line))
            .help("save the file as UTF-8; write `degC` and `um` where the degree or micro sign is in the way")
    })
}

fn not_read(path: &Path, error: &io::Error) -> Complaint {
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
/// the place of `path` only when all of it is written. A device, such as `/dev/stdout`, is written directly.
///
/// # Errors
/// A parent folder that does not exist, a folder in the place of the file, and everything that goes wrong in writing;
/// then `path` is as it was before.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Complaint> {
    let failed = |error: &io::Error| not_written(path, error);
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
    let temporary = temporary_in(&folder).map_err(|error| failed(&error))?;
    fill(temporary.as_file(), write).map_err(|error| failed(&error))?;
    if let Some(there) = before {
        fs::set_permissions(temporary.path(), there.permissions()).map_err(|error| failed(&error))?;
    }
    temporary.persist(&target).map_err(|error| failed(&error.error))?;
    Ok(())
}

/// Refuses a file whose folder does not exist, before long work is done for it.
///
/// # Errors
/// A parent folder that does not exist.
pub fn check_folder(path: &Path) -> Result<(), Complaint> {
    existing_folder(path, path).map(|_| ())
}

fn existing_folder(target: &Path, path: &Path) -> Result<PathBuf, Complaint> {
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

#[cfg(unix)]
fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    // A temporary file is private by default; a result is as readable as the user's mask lets any new file be.
    Builder::new().permissions(fs::Permissions::from_mode(0o666)).tempfile_in(folder)
}

#[cfg(not(unix))]
fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
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
