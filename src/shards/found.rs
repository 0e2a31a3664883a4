//! How a shard is found by a process that is to do it.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Done, Form, Hold, Journal, Numbered, Share};
use crate::complaint::Complaint;

/// A shard as it stands.
pub enum Found<W, R> {
    /// Nothing is left to do; by whom it was done, as the user reads it.
    Done(Done<W>, &'static str),
    /// To be gone on with, beside the rows that are there already. Nobody else writes the journal.
    Open(Journal, Vec<R>),
}

impl<W: Serialize + DeserializeOwned, R: Numbered> Found<W, R> {
    /// Looks at the shard in this folder, and holds its journal where it is not done.
    ///
    /// # Errors
    /// A folder of other work, files that cannot be read or written, a wait that was cancelled.
    pub fn of(folder: &Path, form: &Form, digest: &str, shard: Share, hold: &Hold<'_>) -> Result<Self, Complaint> {
        let done = || -> Result<Option<Done<W>>, Complaint> {
            let done = Done::read(folder, form)?;
            done.iter().try_for_each(|done| done.check(folder, form, digest, shard))?;
            Ok(done)
        };
        if let Some(done) = done()? {
            return Ok(Self::Done(done, "done before"));
        }
        let (journal, rows) = Journal::resume(folder, form, digest, hold)?;
        // Whoever was waited for may have done it all.
        Ok(done()?.map_or(Self::Open(journal, rows), |done| Self::Done(done, "done by another process")))
    }
}
