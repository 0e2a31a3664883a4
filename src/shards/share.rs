//! Which piece of the whole a process does.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Most shards of one work: their names sort as their numbers do.
const MOST: usize = 99_999;

/// One of several equal pieces, written `17/10000`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Share {
    /// From 1 to `of`.
    pub index: usize,
    /// How many there are.
    pub of: usize,
}

impl Share {
    /// Its part of `count` things that are counted from 0. The parts of all are disjoint, make up everything, and differ in
    /// length by one at most; where there are more pieces than things some are empty.
    pub fn range(self, count: usize) -> Range<usize> {
        let until = |index: usize| count * index / self.of;
        until(self.index - 1)..until(self.index)
    }

    /// The folder of the shard in that of the work, such as `shard-00017`.
    pub fn folder(self, work: &Path) -> PathBuf {
        work.join(format!("{PREFIX}{:05}", self.index))
    }
}

/// With which the folders of shards begin.
pub const PREFIX: &str = "shard-";

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
        let Some((index, of)) = parts else {
            return Err("write the number of the shard and how many there are, such as `3/10`".to_owned());
        };
        if !(1..=MOST).contains(&of) {
            return Err(format!("there are 1 to {MOST} shards, not {of}"));
        }
        if !(1..=of).contains(&index) {
            return Err(format!("shards of {of} count from 1 to {of}"));
        }
        Ok(Self { index, of })
    }
}

impl fmt::Display for Share {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{} of {}", self.index, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_make_up_the_whole() {
        for count in [0, 1, 5, 12, 1_000_000] {
            for of in [1, 2, 7, 12, 100] {
                let parts = (1..=of).map(|index| Share { index, of }.range(count));
                let lengths: Vec<usize> = parts.clone().map(|part| part.len()).collect();
                assert!(lengths.iter().max().unwrap() - lengths.iter().min().unwrap() <= 1, "{count} in {of}");
                let mut next = 0;
                parts.for_each(|part| {
                    assert_eq!(part.start, next);
                    next = part.end;
                });
                assert_eq!(next, count);
            }
        }
    }

    #[test]
    fn what_is_no_share_is_told() {
        assert_eq!("17/10000".parse(), Ok(Share { index: 17, of: 10_000 }));
        for (text, told) in [
            ("3", "such as `3/10`"),
            ("a/b", "such as `3/10`"),
            ("-1/3", "such as `3/10`"),
            ("0/3", "count from 1 to 3"),
            ("4/3", "count from 1 to 3"),
            ("1/0", "1 to 99999 shards, not 0"),
            ("1/100000", "1 to 99999 shards, not 100000"),
        ] {
            let error = text.parse::<Share>().unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
