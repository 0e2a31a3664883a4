//! What takes longer than a moment: which task, how far it is, what a judgement says.

use serde::{Deserialize, Serialize};

use crate::context::Context;
use crate::learn::comparison::Comparison;

/// What takes longer than a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Task {
    /// Which effect is missing.
    Find,
    /// The effects on the desk, with the faults that the record shows.
    Fit,
    /// Both records, as `compare` does.
    Judge,
}

/// A task on its way.
#[derive(Debug)]
pub struct Running {
    pub task: Task,
    pub context: Context,
    pub stage: String,
    pub done: usize,
    pub of: Option<usize>,
}

/// What `compare` says of the rig file as it stands.
#[derive(Debug, Clone, Serialize)]
pub struct Judged {
    pub fit: Comparison,
    pub check: Option<Comparison>,
}
