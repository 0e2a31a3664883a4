//! What a run reads and writes, declared before it begins: no output may be another output, a store or an input.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use super::is_standard;
use super::write::{check_folder, folder_of, is_standard_output};
use crate::complaint::{Complaint, Kind, Place};

/// Links that are followed one after the other before they are taken for a circle.
const MOST_LINKS: usize = 40;

/// What makes two paths one file.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Identity {
    StandardOutput,
    /// A file that is there, by whatever name: hard links, other spellings of one name, paths around corners.
    There(same::Inode),
    /// A file that is yet to be made: its folder, and its name in lower case, as some file systems take `A` and `a` for one.
    ToCome(same::Inode, String),
}

/// What a run does with a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Reads,
    Writes,
    /// A store, to which runs are added.
    AddsTo,
}

/// The files of one run. Outputs are declared here before long work begins; what would lose data is refused then.
#[derive(Debug)]
pub struct Outputs {
    force: bool,
    files: Vec<(Identity, PathBuf, Use)>,
}

impl Outputs {
    /// No files yet; `force` lets outputs take the place of files that are there.
    pub fn new(force: bool) -> Self {
        Self { force, files: Vec::new() }
    }

    /// Files that the run reads; the standard input and what does not exist are nobody's output.
    pub fn reading<'a>(mut self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        for path in paths.into_iter().filter(|path| !is_standard(path) && path.is_file()) {
            self.files.extend(identity(path).map(|identity| (identity, path.clone(), Use::Reads)));
        }
        self
    }

    /// Declares a store, with the files that SQLite keeps beside it.
    ///
    /// # Errors
    /// A file that the run uses otherwise.
    pub fn adding_to(mut self, store: &Path) -> Result<Self, Complaint> {
        self.take(store, Use::AddsTo)?;
        for suffix in ["-journal", "-wal", "-shm"] {
            let mut name = OsString::from(store);
            name.push(suffix);
            self.take(&PathBuf::from(name), Use::AddsTo)?;
        }
        Ok(self)
    }

    /// Declares an output.
    ///
    /// # Errors
    /// A folder that does not exist; a file that the run reads, or writes for another purpose; without `force` a file that
    /// is there and holds something.
    pub fn writing(mut self, path: &Path) -> Result<Self, Complaint> {
        check_folder(path)?;
        if path.is_dir() {
            return Err(Complaint::new(Kind::Unwritable, "this is a folder, not a file")
                .in_file(path)
                .help("name a file in it"));
        }
        self.take(path, Use::Writes)?;
        let there = fs::metadata(path).is_ok_and(|there| there.is_file() && there.len() > 0);
        if there && !self.force && !is_standard_output(path) {
            return Err(Complaint::new(Kind::Unwritable, "there is such a file already, and it would be overwritten")
                .in_file(path)
                .help("name another file, or add `--force`; this one is left as it is"));
        }
        Ok(self)
    }

    /// Declares an output that goes on with what an earlier run of the same work wrote.
    ///
    /// # Errors
    /// A file that the run uses otherwise.
    pub fn going_on_with(mut self, path: &Path) -> Result<Self, Complaint> {
        self.take(path, Use::Writes)?;
        Ok(self)
    }

    /// Declares outputs that may not be asked for.
    ///
    /// # Errors
    /// Those of [`writing`](Self::writing).
    pub fn writing_all<'a>(self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Result<Self, Complaint> {
        paths.into_iter().try_fold(self, |outputs, path| outputs.writing(path))
    }

    fn take(&mut self, path: &Path, purpose: Use) -> Result<(), Complaint> {
        let Some(identity) = identity(path) else { return Ok(()) };
        if let Some((_, other, before)) = self.files.iter().find(|(known, ..)| *known == identity) {
            return Err(conflict(path, purpose, other, *before));
        }
        self.files.push((identity, path.to_path_buf(), purpose));
        Ok(())
    }
}

fn conflict(path: &Path, purpose: Use, other: &Path, before: Use) -> Complaint {
    let (what, help) = match (before, purpose) {
        (Use::Reads, _) => {
            ("this file is read, and would be overwritten", "name another file; this one is left as it is")
        }
        (Use::AddsTo, _) | (_, Use::AddsTo) => {
            ("this file is the store, and would be overwritten", "name another file; the store is left as it is")
        }
        (Use::Writes, _) => ("two outputs would go to this file", "name a file for each; nothing was written"),
    };
    let complaint = Complaint::new(Kind::Contradiction, what).help(help);
    if path == other { complaint.in_file(path) } else { complaint.at(Place::file(other)).at(Place::file(path)) }
}

/// What the path leads to, links followed; `None` of devices and pipes, which hold nothing that could be lost.
fn identity(path: &Path) -> Option<Identity> {
    if is_standard_output(path) {
        return Some(Identity::StandardOutput);
    }
    if let Ok(there) = fs::metadata(path) {
        return there.is_file().then(|| same::of(path, &there)).flatten().map(Identity::There);
    }
    // A link to a file that is yet to be made.
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&path) else { break };
        path = folder_of(&path).join(next);
    }
    let folder = folder_of(&path);
    let there = fs::metadata(&folder).ok()?;
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    same::of(&folder, &there).map(|folder| Identity::ToCome(folder, name))
}

#[cfg(unix)]
mod same {
    use std::fs::Metadata;
    use std::os::unix::fs::MetadataExt;
    use std::path::Path;

    /// Device and number.
    pub(super) type Inode = (u64, u64);

    pub(super) fn of(_: &Path, there: &Metadata) -> Option<Inode> {
        Some((there.dev(), there.ino()))
    }
}

#[cfg(not(unix))]
mod same {
    use std::fs::{self, Metadata};
    use std::path::{Path, PathBuf};

    /// The whole path, links followed.
    pub(super) type Inode = PathBuf;

    pub(super) fn of(path: &Path, _: &Metadata) -> Option<Inode> {
        fs::canonicalize(path).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(outputs: Outputs, path: &Path) -> Option<String> {
        outputs.writing(path).err().map(|complaint| complaint.what)
    }

    #[test]
    fn no_two_outputs_are_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let own = |name: &str| folder.path().join(name);
        let first = || Outputs::new(true).writing(&own("a.html")).unwrap();
        let twice = "two outputs would go to this file";
        for name in ["a.html", "A.html", "./a.html", "../x/../a.html"] {
            let path = if name.starts_with("..") {
                folder.path().join("..").join(folder.path().file_name().unwrap()).join("a.html")
            } else {
                own(name)
            };
            assert_eq!(refused(first(), &path).as_deref(), Some(twice), "{}", path.display());
        }
        assert_eq!(refused(first(), &own("b.html")), None);
        let both = Outputs::new(true).writing(Path::new("-")).unwrap();
        assert_eq!(refused(both, Path::new("/dev/stdout")).as_deref(), Some(twice));
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_to_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let own = |name: &str| folder.path().join(name);
        std::os::unix::fs::symlink("new.db", own("link")).unwrap();
        let store = Outputs::new(true).adding_to(&own("new.db")).unwrap();
        assert!(refused(store, &own("link")).is_some_and(|what| what.contains("is the store")));
        std::fs::write(own("rig.toml"), "[rig]").unwrap();
        std::fs::hard_link(own("rig.toml"), own("hard")).unwrap();
        let outputs = Outputs::new(true).reading([&own("rig.toml")]);
        assert!(refused(outputs, &own("hard")).is_some_and(|what| what.contains("this file is read")));
        let store = Outputs::new(true).adding_to(&own("new.db")).unwrap();
        assert!(refused(store, &own("new.db-journal")).is_some());
    }

    #[test]
    fn a_file_is_overwritten_only_on_request() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.csv");
        std::fs::write(&path, "").unwrap();
        assert_eq!(refused(Outputs::new(false), &path), None, "an empty file holds nothing");
        std::fs::write(&path, "kept").unwrap();
        assert!(refused(Outputs::new(false), &path).is_some_and(|what| what.contains("already")));
        assert_eq!(refused(Outputs::new(true), &path), None);
    }
}
