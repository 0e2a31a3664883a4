//! Samples that a record does not have.

use std::fmt;

use super::Record;
use crate::number::rounded;

/// The rows in which one channel has no value.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// Its name.
    pub channel: String,
    /// Rows without a value, and all rows.
    pub missing: usize,
    /// Rows of the record.
    pub rows: usize,
    /// Times of the first and the last row without a value, s.
    pub from_s: f64,
    /// Time of the last row without a value, s.
    pub to_s: f64,
}

impl Record {
    /// The channels that lack samples, in the order of the file.
    #[doc(hidden)]
    pub fn gaps(&self) -> Vec<Gap> {
        let of = |channel: &super::Channel| {
            let pairs = || self.time.iter().zip(&channel.values).filter(|(_, value)| value.is_nan());
            let (first, last) = (pairs().next()?, pairs().next_back()?);
            Some(Gap {
                channel: channel.name.clone(),
                missing: pairs().count(),
                rows: self.time.len(),
                from_s: rounded(*first.0, 9),
                to_s: rounded(*last.0, 9),
            })
        };
        self.channels.iter().filter_map(of).collect()
    }
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { channel, missing, rows, from_s, to_s } = self;
        let when = if from_s == to_s { format!("at {from_s} s") } else { format!("between {from_s} s and {to_s} s") };
        write!(f, "`{channel}` has no value in {missing} of {rows} rows {when}")
    }
}
