//! What a rig asks of a record.

use std::path::Path;

use super::Record;
use super::read::{self, Care};
use crate::complaint::Complaint;
use crate::units::Unit;

/// The columns that a rig names, with the units that its file tells.
#[derive(Debug, Clone, Default)]
pub struct Asked {
    columns: Vec<(String, Option<Unit>)>,
}

impl Asked {
    /// Each column, with its unit for files that have none.
    pub fn new(columns: impl IntoIterator<Item = (String, Option<Unit>)>) -> Self {
        Self { columns: columns.into_iter().collect() }
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|(column, _)| column == name)
    }

    /// The unit that the rig file tells of a column.
    pub(super) fn unit(&self, name: &str) -> Option<&Unit> {
        self.columns.iter().filter(|(column, _)| column == name).find_map(|(_, unit)| unit.as_ref())
    }

    /// Reads a record as [`Record::read`] does; columns without a unit of their own have that of the rig file, and groups of
    /// channels that the rig does not ask for make no rows.
    ///
    /// # Errors
    /// As [`Record::read`].
    pub fn read(&self, path: impl AsRef<Path>) -> Result<Record, Complaint> {
        read::read(path.as_ref(), Care::Strict, self).map(|(record, _)| record)
    }

    /// Reads a record as [`Record::read_as_it_stands`] does, units and groups as [`read`](Self::read).
    ///
    /// # Errors
    /// As [`Record::read_as_it_stands`].
    pub fn read_as_it_stands(&self, path: impl AsRef<Path>) -> Result<(Record, Option<Complaint>), Complaint> {
        read::read(path.as_ref(), Care::Survey, self)
    }

    /// Reads the bytes of a file; `path` is the name that messages give it.
    ///
    /// # Errors
    /// As [`Record::read`], but for those of the file itself.
    #[cfg(feature = "internals")]
    pub fn read_bytes(&self, path: impl AsRef<Path>, bytes: Vec<u8>) -> Result<Record, Complaint> {
        read::of_bytes(path.as_ref(), bytes, Care::Strict, self).map(|(record, _)| record)
    }
}
