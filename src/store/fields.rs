//! A row of a table that is read, whatever its format.

/// The fields of one row by the names of their columns.
pub(super) trait Fields {
    /// `None` where there is no such column or nothing in it.
    fn get(&self, name: &str) -> Option<String>;
}
