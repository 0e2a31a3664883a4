//! Temporary files beside the file whose place they take.
//!
//! Each is locked while it is written. A program that is killed leaves one behind whose lock is gone: the next program that
//! writes into the folder knows it by its name and removes it.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::{Builder, NamedTempFile};

const PREFIX: &str = ".borescope-";
const SUFFIX: &str = ".tmp";
/// Another program may take a new file for one that was left behind, in the moment before it is locked.
const ATTEMPTS: usize = 8;

/// Temporary files of this process that have not taken their place yet. An end of the program by a signal runs no destructors,
/// so whoever ends it has to find them.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// An entry of [`UNFINISHED`].
pub(super) struct Unfinished(PathBuf);

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
    pub(super) fn end<T>(&self, persist: impl FnOnce() -> T) -> T {
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
#[cfg(all(unix, feature = "cli"))]
pub(crate) fn remove_unfinished() {
    let all = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in all.iter() {
        // What cannot be removed stays: there is nobody left to tell.
        let _ = fs::remove_file(path);
    }
    // Never given back: the program ends.
    std::mem::forget(all);
}

/// A new temporary file in a folder, locked; those that killed programs left there are removed.
pub(super) fn create(folder: &Path) -> io::Result<(NamedTempFile, Unfinished)> {
    remove_left_behind(folder);
    Unfinished::begin(|| locked_file_in(folder))
}

fn locked_file_in(folder: &Path) -> io::Result<NamedTempFile> {
    for _ in 0..ATTEMPTS {
        let temporary = builder().tempfile_in(folder)?;
        match temporary.as_file().try_lock() {
            Ok(()) if is_there(&temporary) => return Ok(temporary),
            Ok(()) | Err(TryLockError::WouldBlock) => {}
            // Where files cannot be locked, nobody removes them either.
            Err(TryLockError::Error(_)) => return Ok(temporary),
        }
    }
    Err(io::Error::other("the temporary file is removed again and again by another program"))
}

/// Whether the name still leads to a file.
fn is_there(temporary: &NamedTempFile) -> bool {
    temporary.path().symlink_metadata().is_ok()
}

/// Removes the temporary files that nobody writes to any more. What cannot be removed stays: it is in nobody's way.
fn remove_left_behind(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !(is_file && name.starts_with(PREFIX) && name.ends_with(SUFFIX)) {
            continue;
        }
        let Ok(file) = File::options().write(true).open(entry.path()) else { continue };
        if file.try_lock().is_ok() {
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(unix)]
fn builder() -> Builder<'static, 'static> {
    use std::os::unix::fs::PermissionsExt;
    let mut builder = Builder::new();
    // A temporary file is private by default; a result is as readable as the user's mask lets any new file be.
    builder.prefix(PREFIX).suffix(SUFFIX).permissions(fs::Permissions::from_mode(0o666));
    builder
}

#[cfg(not(unix))]
fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_program_left_is_removed_and_what_is_being_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join(".borescope-dead.tmp");
        let other = folder.path().join(".other-dead.tmp");
        fs::write(&left, "half a res").unwrap();
        fs::write(&other, "not ours").unwrap();
        let (first, _first) = create(folder.path()).unwrap();
        assert!(!left.exists() && other.exists());
        let (second, _second) = create(folder.path()).unwrap();
        assert!(first.path().exists() && second.path().exists());
    }
}
