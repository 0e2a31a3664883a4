//! What a rig asks of a record.

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
}
