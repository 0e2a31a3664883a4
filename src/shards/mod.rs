//! Work in shards: a piece of long work that one process does alone, in a folder of its own, and the merge of them all.
//!
//! The journal of a shard grows row by row and outlives whoever writes it; `done.json` comes last and in one piece, so that a
//! shard is either done or to be gone on with. Several processes in one shard wait for each other.

mod done;
mod found;
mod journal;
mod merge;
mod share;

use std::collections::HashSet;
use std::ops::Range;

pub use done::{DONE, Done};
pub use found::Found;
pub use journal::{Hold, JOURNAL, Journal};
pub use merge::merge;
pub use share::Share;

/// What is done in shards, and what its messages call it.
#[derive(Debug)]
pub struct Form {
    /// Name and version of the format of its journal.
    pub journal: &'static str,
    /// Name and version of the format of its `done.json`.
    pub done: &'static str,
    /// All of it, such as `a campaign`.
    pub whole: &'static str,
    /// One line of its journal, such as `case`.
    pub row: &'static str,
}

/// A line of a journal: knows which one it is of the whole.
pub trait Numbered: serde::Serialize + serde::de::DeserializeOwned {
    /// From 0; two processes that do the same shard write the same number twice.
    fn number(&self) -> usize;
}

/// The numbers of a range that no row has.
pub fn missing<R: Numbered>(range: Range<usize>, rows: &[R]) -> Vec<usize> {
    let finished: HashSet<usize> = rows.iter().map(R::number).collect();
    range.filter(|number| !finished.contains(number)).collect()
}

/// Puts rows in the order of their numbers, each number once.
pub fn put_in_order<R: Numbered>(rows: &mut Vec<R>) {
    rows.sort_by_key(R::number);
    rows.dedup_by_key(|row| row.number());
}
