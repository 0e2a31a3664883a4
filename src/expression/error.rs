//! What is wrong with a formula, and where.

use std::fmt;

/// A formula that cannot be used. `Display` writes the message alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpressionError {
    /// Where, in bytes from the start of the formula; always between two characters of it, or at its end.
    pub offset: usize,
    /// What is wrong: one sentence without a full stop.
    pub message: String,
    /// What would be right: one sentence without a full stop.
    pub help: String,
}

impl ExpressionError {
    pub(super) fn new(offset: usize, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { offset, message: message.into(), help: help.into() }
    }
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.message)
    }
}

impl std::error::Error for ExpressionError {}
