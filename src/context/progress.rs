//! How far long work has come.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::Context;

/// How far a stage of the work has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress<'a> {
    /// What is being done, in words.
    pub stage: &'a str,
    /// Pieces of it that are done.
    pub done: usize,
    /// Of how many; `None` where nobody knows beforehand.
    pub of: Option<usize>,
}

impl fmt::Display for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.of {
            Some(of) => write!(f, "{}: {} of {of}", self.stage, self.done),
            None => f.write_str(self.stage),
        }
    }
}

/// Who hears of progress.
pub(crate) type Listener = Arc<dyn Fn(Progress<'_>) + Send + Sync>;

/// A stage of so many equal pieces, done in any order by any thread.
#[derive(Debug)]
pub(crate) struct Count<'a> {
    context: &'a Context,
    stage: &'static str,
    done: AtomicUsize,
    of: usize,
}

impl<'a> Count<'a> {
    pub(super) fn new(context: &'a Context, stage: &'static str, of: usize) -> Self {
        context.report(Progress { stage, done: 0, of: Some(of) });
        Self { context, stage, done: AtomicUsize::new(0), of }
    }

    /// One piece is done.
    pub(crate) fn one(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.context.report(Progress { stage: self.stage, done, of: Some(self.of) });
    }
}
