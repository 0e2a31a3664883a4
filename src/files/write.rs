//! Files written whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::{is_standard, temporary};
use crate::complaint::{Complaint, Kind};

/// Whether a path stands for the standard output: `-`, or one of the names that systems give it.
pub fn is_standard_output(path: &Path) -> bool {
    const NAMES: [&str; 3] = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];
    is_standard(path) || NAMES.iter().any(|name| path == Path::new(name))
}

/// Whether what was written to a path stays there as a file, so that a summary on the standard output does not get into it.
#[cfg(feature = "cli")]
pub fn is_kept(path: &Path) -> bool {
    !is_standard_output(path) && path.is_file()
}

/// Writes a file whole or not at all: what `write` puts out goes to a temporary file in the same folder, which takes
/// the place of `path` only when all of it is written. A device, such as `/dev/null`, is written directly, and so is the
/// standard output, `-`.
///
/// # Errors
/// A parent folder that does not exist, a folder in the place of the file, and everything that goes wrong in writing;
/// then `path` is as it was before.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Complaint> {
    let failed = |error: &io::Error| not_written(path, error);
    if is_standard_output(path) {
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
    let (temporary, unfinished) = temporary::create(&folder).map_err(|error| failed(&error))?;
    fill(temporary.as_file(), write).map_err(|error| failed(&error))?;
    // A machine that loses power must not be left with the new name and nothing behind it.
    temporary.as_file().sync_data().map_err(|error| failed(&error))?;
    if let Some(there) = before {
        fs::set_permissions(temporary.path(), there.permissions()).map_err(|error| failed(&error))?;
    }
    unfinished.end(|| temporary.persist(&target)).map_err(|error| failed(&error.error))?;
    Ok(())
}

/// Refuses a file whose folder does not exist, before long work is done for it.
///
/// # Errors
/// A parent folder that does not exist.
#[cfg(feature = "store")]
pub fn check_folder(path: &Path) -> Result<(), Complaint> {
    existing_folder(path, path).map(|_| ())
}

/// Whether somebody closed the pipe that is written to.
pub(crate) fn is_closed_pipe(error: &io::Error) -> bool {
    cause(error) == io::ErrorKind::BrokenPipe
}

/// What went wrong, also where the writer of tables has wrapped it.
fn cause(error: &io::Error) -> io::ErrorKind {
    let inner = error.get_ref().and_then(|inner| inner.downcast_ref::<csv::Error>());
    match inner.map(csv::Error::kind) {
        Some(csv::ErrorKind::Io(inner)) => inner.kind(),
        _ => error.kind(),
    }
}

fn existing_folder(target: &Path, path: &Path) -> Result<PathBuf, Complaint> {
    if is_standard_output(path) {
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

/// The folder in which a file is or would be.
pub(super) fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn fill(file: &File, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut buffer = BufWriter::new(file);
    write(&mut buffer)?;
    buffer.flush()
}

fn not_written(path: &Path, error: &io::Error) -> Complaint {
    let complaint = match cause(error) {
        io::ErrorKind::PermissionDenied => Complaint::new(Kind::Unwritable, "no permission to write the file")
            .help("name a folder that you may write to"),
        io::ErrorKind::FileTooLarge => Complaint::new(
            Kind::Unwritable,
            format!("cannot be written: {error}, the largest that may be written here"),
        )
        .help("raise the limit (`ulimit -f`), or write to another file system; the file is as it was before"),
        io::ErrorKind::StorageFull => Complaint::new(Kind::Unwritable, format!("cannot be written: {error}"))
            .help("make room on the disk, and run again; the file is as it was before"),
        _ => Complaint::new(Kind::Unwritable, format!("cannot be written: {error}")),
    };
    complaint.in_file(path)
}
