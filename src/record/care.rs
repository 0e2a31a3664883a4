//! How much of a record is taken, and how strictly, whatever its format.

use super::Record;
use crate::complaint::Complaint;

/// Most bytes of a record.
pub(super) const MOST: u64 = 1 << 30;
/// Most columns of a record.
pub(super) const MOST_COLUMNS: usize = 4096;

/// Whether what a diagnosis cannot use is refused, or taken to be told about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Care {
    /// The time rises.
    Strict,
    /// Times as they stand.
    Survey,
}

/// A record, and what a strict reader would have said of it.
pub(super) type Standing = (Record, Option<Complaint>);
