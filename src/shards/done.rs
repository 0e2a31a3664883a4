//! What a shard that is done says of itself.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{Form, Share};
use crate::complaint::{Complaint, Kind, Place};
use crate::files::{read_text, write_atomically};

/// Name of the file in the folder of the shard; it is written last.
pub const DONE: &str = "done.json";

/// A shard that is done; `W` is what its work was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Done<W> {
    /// Name and version of the format.
    pub schema: String,
    /// What tells its work from other work.
    pub digest: String,
    /// Of the program.
    pub version: String,
    /// Which shard.
    pub shard: Share,
    /// First row and the one behind the last, from 0.
    pub range: [usize; 2],
    /// How many rows its journal has, each counted once.
    pub count: usize,
    /// What the work was.
    #[serde(flatten)]
    pub work: W,
}

impl<W: Serialize + DeserializeOwned> Done<W> {
    /// Of a shard that is done now.
    pub fn new(form: &Form, digest: &str, shard: Share, range: std::ops::Range<usize>, work: W) -> Self {
        Self {
            schema: form.done.to_owned(),
            digest: digest.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            shard,
            range: [range.start, range.end],
            count: range.len(),
            work,
        }
    }

    /// What stands in the folder of a shard; `None` of one that is not done.
    ///
    /// # Errors
    /// A file that cannot be read, or says something else.
    pub fn read(folder: &Path, form: &Form) -> Result<Option<Self>, Complaint> {
        let path = folder.join(DONE);
        if !path.exists() {
            return Ok(None);
        }
        let wrong = |what: String| {
            Complaint::new(Kind::Syntax, what)
                .at(Place::file(&path))
                .help("delete the folder of the shard, and do the shard again")
        };
        let done: Self = serde_json::from_str(&read_text(&path)?)
            .map_err(|error| wrong(format!("this says nothing of a shard of {}: {error}", form.whole)))?;
        if done.schema != form.done {
            return Err(wrong(format!("this is `{}`, where `{}` is expected", done.schema, form.done)));
        }
        Ok(Some(done))
    }

    /// Writes it into the folder of the shard, in one piece.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Complaint> {
        write_atomically(&folder.join(DONE), |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            writeln!(file)
        })
    }

    /// Refuses a shard of other work than the one at hand.
    ///
    /// # Errors
    /// Another digest, or another number of shards.
    pub fn check(&self, folder: &Path, form: &Form, digest: &str, shard: Share) -> Result<(), Complaint> {
        if self.digest == digest && self.shard == shard {
            return Ok(());
        }
        let what = if self.shard != shard {
            format!("the folder holds shard {} of {}, not {shard}", self.shard, form.whole)
        } else {
            format!("the shard is of {} with other options, other files or another version", form.whole)
        };
        Err(Complaint::new(Kind::Contradiction, what).at(Place::file(folder.join(DONE))).help("name another folder"))
    }
}
