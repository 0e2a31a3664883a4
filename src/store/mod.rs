//! The fault information database: every diagnosis of many records, in one SQLite file.
//!
//! Each diagnosis is one transaction under a lock that other processes wait for, so several may write at once, and one that
//! is killed leaves the store as it was before.

mod export;
#[cfg(any(feature = "cli", feature = "internals"))]
mod fields;
#[cfg(any(feature = "cli", feature = "internals"))]
mod import;
mod insert;
mod moment;
#[cfg(feature = "parquet")]
mod parquet;
mod query;
mod run;
mod schema;

use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, ErrorCode, OpenFlags};

use crate::complaint::{Complaint, Kind};
use crate::files::check_folder;

pub use export::export_csv;
#[cfg(any(feature = "cli", feature = "internals"))]
pub use export::plain_cell;
#[cfg(any(feature = "cli", feature = "internals"))]
pub use import::import;
#[cfg(feature = "cli")]
pub use insert::Kept;
pub use moment::Moment;
#[cfg(feature = "parquet")]
pub use parquet::export_parquet;
#[cfg(any(feature = "cli", feature = "internals"))]
pub use run::Dated;
pub use run::{NewRun, RigIdentity, StoredFault, StoredRun};

/// How long a process waits for another one that writes, before it says so and after.
const SILENCE: Duration = Duration::from_secs(1);
const PATIENCE: Duration = Duration::from_secs(60);

/// Told the path of a store that another program holds, before the wait goes on.
pub type Waiting = fn(&Path);

/// A store that is open.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    connection: Connection,
    waiting: Waiting,
}

impl Store {
    /// Opens a store for writing; a file that is missing or empty becomes one.
    ///
    /// # Errors
    /// A folder that does not exist, a file that is no store or one of a newer version, and one that cannot be written.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Complaint> {
        Self::open_telling(path, |_| ())
    }

    /// The same; `waiting` is told when another program holds the store, now or later.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_telling(path: impl AsRef<Path>, waiting: Waiting) -> Result<Self, Complaint> {
        let path = path.as_ref();
        check_folder(path)?;
        let store = Self::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE, waiting)?;
        store.patiently(|| schema::prepare(&store))?;
        Ok(store)
    }

    /// Opens a store that is there.
    ///
    /// # Errors
    /// A file that is missing, no store, or one of a newer version.
    pub fn open_existing(path: impl AsRef<Path>) -> Result<Self, Complaint> {
        Self::open_existing_telling(path, |_| ())
    }

    /// The same; `waiting` is told when another program holds the store, now or later.
    ///
    /// # Errors
    /// As [`open_existing`](Self::open_existing).
    pub fn open_existing_telling(path: impl AsRef<Path>, waiting: Waiting) -> Result<Self, Complaint> {
        let path = path.as_ref();
        check_name(path)?;
        if !path.exists() {
            return Err(Complaint::new(Kind::Missing, "there is no such store")
                .in_file(path)
                .help("check the path; `borescope diagnose RIG.toml RECORD --store FILE` makes a store"));
        }
        // A run that was killed may have left something to undo, which takes the right to write.
        let store = Self::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE, waiting)?;
        store.patiently(|| schema::check(&store))?;
        Ok(store)
    }

    /// Does it, and where another program holds the store says so and does it again.
    fn patiently<T>(&self, act: impl Fn() -> Result<T, Complaint>) -> Result<T, Complaint> {
        let wait = |time| self.connection.busy_timeout(time).map_err(|error| self.failed(&error));
        wait(SILENCE)?;
        match act() {
            Err(complaint) if complaint.kind == Kind::Locked => {
                (self.waiting)(&self.path);
                wait(PATIENCE)?;
                act()
            }
            done => done,
        }
    }

    fn connect(path: &Path, flags: OpenFlags, waiting: Waiting) -> Result<Self, Complaint> {
        check_name(path)?;
        if path.is_dir() {
            return Err(Complaint::new(Kind::Unwritable, "this is a folder, not a file")
                .in_file(path)
                .help("name a file in it"));
        }
        let connection = Connection::open_with_flags(path, flags | OpenFlags::SQLITE_OPEN_NO_MUTEX)
            .map_err(|error| failed(path, &error))?;
        Ok(Self { path: path.to_path_buf(), connection, waiting })
    }

    fn failed(&self, error: &rusqlite::Error) -> Complaint {
        failed(&self.path, error)
    }
}

/// Refuses names that SQLite does not take for files, such as `:memory:`: nothing would be kept.
///
/// # Errors
/// A name that is empty or begins with a colon.
pub fn check_name(path: &Path) -> Result<(), Complaint> {
    let name = path.to_string_lossy();
    if name.is_empty() || name.starts_with(':') {
        return Err(Complaint::new(Kind::Unwritable, "this is no file, and nothing would be kept in it")
            .in_file(path)
            .help("name a file, such as `rig.db`; `./` in front makes any name that of a file"));
    }
    Ok(())
}

/// The complaint about what SQLite says.
fn failed(path: &Path, error: &rusqlite::Error) -> Complaint {
    let complaint = match error.sqlite_error_code() {
        Some(ErrorCode::NotADatabase) => return no_store(path),
        Some(ErrorCode::DatabaseCorrupt) => Complaint::new(Kind::Unreadable, format!("the store is damaged: {error}"))
            .help("take a copy from before, or begin another store"),
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => {
            let waited = PATIENCE.as_secs();
            Complaint::new(Kind::Locked, format!("another program has held the store for {waited} s"))
                .help("run again when it is done")
        }
        Some(ErrorCode::ReadOnly | ErrorCode::PermissionDenied) => {
            Complaint::new(Kind::Unwritable, "no permission to write the store")
                .help("name a file that you may write to")
        }
        Some(ErrorCode::DiskFull) => Complaint::new(Kind::Unwritable, "there is no room left on the disk")
            .help("make room and run again; the store is as it was before"),
        Some(ErrorCode::CannotOpen) => Complaint::new(Kind::Unreadable, "the store cannot be opened")
            .help("check the permissions of the file and of its folder"),
        _ => Complaint::new(Kind::Unreadable, format!("the store cannot be used: {error}")),
    };
    complaint.in_file(path)
}

/// The complaint about a file that is something else.
fn no_store(path: &Path) -> Complaint {
    Complaint::new(Kind::Syntax, "this is no store of diagnoses")
        .in_file(path)
        .help("name a file that `diagnose --store` has made, or a new one; the file is left as it is")
}
