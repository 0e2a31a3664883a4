//! Where a record comes from.

use std::time::SystemTime;

/// What is known of the file behind a record; empty for one that comes from no file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// SHA-256 of the bytes of the file, in hexadecimal digits.
    pub digest: String,
    /// When the file was last written to; `None` where nobody knows, as of a pipe.
    pub modified: Option<SystemTime>,
    /// What was recognised: format, separator, decimal mark, where the units stand, packing.
    pub read_as: String,
    /// What of the file is no column of the record, and why.
    pub left_out: Vec<(String, String)>,
}

/// What a file is read as that needs no word: the form that records are written in.
const PLAIN: &str = "CSV, columns between commas, decimal points";

impl Origin {
    /// Whether the file is in the form that records are written in, so that there was nothing to recognise.
    pub fn is_plain(&self) -> bool {
        self.read_as.is_empty() || self.read_as == PLAIN
    }
}
