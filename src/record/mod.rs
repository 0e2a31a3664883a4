//! Measured series: what a logger wrote, in SI.

mod asked;
mod binary;
mod bytes;
mod care;
mod columns;
mod dialect;
mod field;
mod gaps;
mod groups;
#[cfg(feature = "hdf5")]
mod hdf5;
mod header;
mod line;
mod mat;
mod mdf;
mod named;
mod origin;
mod packed;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
mod read;
mod rows;
mod sampling;
mod stamp;
mod stream;
pub mod survey;
mod table;
mod tdms;
#[cfg(any(feature = "hdf5", feature = "parquet"))]
mod unharmed;
mod windows;
#[cfg(feature = "excel")]
mod workbook;
mod write;

use std::path::{Path, PathBuf};

use crate::complaint::{Complaint, Kind, Place, help_with_names};
use crate::units::{Dimension, Unit, UnitError};

pub use asked::Asked;
pub use columns::Inputs;
pub(crate) use named::{NamedPlace, named_place};
pub use origin::Origin;
pub use sampling::Sampling;
pub use stream::Stream;
pub(crate) use windows::window_at;
pub use windows::{Window, Windows};

/// Series over one common time.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// The file, as the user named it; messages quote it.
    pub path: PathBuf,
    /// Seconds, rising from row to row.
    pub time: Vec<f64>,
    /// Decimals with which the time is written; `None` writes as many as each value needs.
    #[doc(hidden)]
    pub time_decimals: Option<usize>,
    /// Every column but the time, in the order of the file.
    pub channels: Vec<Channel>,
    /// The line of the column names, which messages about columns point to; 0 in formats without lines.
    pub(crate) header_line: usize,
    /// What is known of the file that it was read from.
    #[doc(hidden)]
    pub origin: Origin,
}

/// One column of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The name in the header, without the unit.
    pub name: String,
    /// The unit in which the file has it.
    pub unit: Unit,
    /// In SI, one for each time; NaN where the file has no value.
    pub values: Vec<f64>,
    /// Decimals with which it is written; `None` writes as many as each value needs.
    pub decimals: Option<usize>,
}

impl Channel {
    /// A channel of SI values, written with as many decimals as each value needs.
    pub fn new(name: impl Into<String>, unit: Unit, values: Vec<f64>) -> Self {
        Self { name: name.into(), unit, values, decimals: None }
    }

    /// Whether it has no value in any row.
    pub fn is_empty(&self) -> bool {
        self.values.iter().all(|value| value.is_nan())
    }

    /// Least and greatest value, SI; `None` without any.
    pub fn range(&self) -> Option<(f64, f64)> {
        let finite = || self.values.iter().copied().filter(|value| value.is_finite());
        finite().reduce(f64::min).zip(finite().reduce(f64::max))
    }

    /// Mean of its first readings, SI: so few that little happens meanwhile; `None` without any.
    pub(crate) fn begins_at(&self) -> Option<f64> {
        const READINGS: usize = 3;
        let first = || self.values.iter().filter(|value| value.is_finite()).take(READINGS);
        let count = first().count();
        (count > 0).then(|| first().sum::<f64>() / count as f64)
    }

    /// Step of the last decimal that is written, SI; 0 where that differs from value to value.
    pub(crate) fn last_digit(&self) -> f64 {
        self.decimals.map_or(0.0, |decimals| self.unit.difference_to_si(10_f64.powi(-(decimals as i32))))
    }

    /// The same channel, written with this number of decimals in its unit.
    pub fn with_decimals(mut self, decimals: usize) -> Self {
        self.decimals = Some(decimals);
        self
    }
}

impl Record {
    /// A record that comes from no file, such as a simulated one; `path` is the name that messages give it.
    pub fn new(path: impl Into<PathBuf>, time: Vec<f64>, channels: Vec<Channel>) -> Self {
        Self { path: path.into(), time, time_decimals: None, channels, header_line: 1, origin: Origin::default() }
    }

    /// Reads a table of columns `name [unit]`, the first of them `time`, separated by commas, semicolons or tabs.
    ///
    /// Lines that start with `#`, blank lines, quoted names, a byte-order mark, Latin-1 text and any line ends are accepted; so are
    /// decimal commas where the columns are separated by another sign or the numbers quoted, units in round brackets where none
    /// stands in square ones, units behind the last `_` of the names where the time has its own there, and times that are dates after ISO 8601. A column keeps the number of its decimals where all of its
    /// values have as many, so that writing gives back what was read.
    ///
    /// # Errors
    /// A file that cannot be read or is no text in UTF-8 or Latin-1; a missing time column; a column without name or unit, with an
    /// unknown unit, or twice; a row that is too short or too long; a text that is neither a number nor a word for none; a time
    /// that is missing, repeats or runs backwards; a file that ends in the middle of a row, or has no rows. The first mistake is
    /// told, with its line.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Complaint> {
        Asked::default().read(path)
    }

    /// Reads a table as [`read`](Self::read) does, but takes the times as they stand, risen or not. What [`read`](Self::read)
    /// would say of them comes along.
    ///
    /// # Errors
    /// Those of [`read`](Self::read) but for these.
    pub fn read_as_it_stands(path: impl AsRef<Path>) -> Result<(Self, Option<Complaint>), Complaint> {
        Asked::default().read_as_it_stands(path)
    }

    /// Writes the table, with the path of the record unchanged; what it gives, [`read`](Self::read) takes.
    ///
    /// # Errors
    /// A missing folder or whatever else goes wrong in writing: then the file is as it was before. A record that could not be read
    /// back: a channel of another length than the time, a value that is not finite, a time that does not rise, a name that appears
    /// twice.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Complaint> {
        write::write(self, path.as_ref())
    }

    /// Adds the rows of a later piece of the same file.
    pub(crate) fn append(&mut self, later: Self) {
        self.time.extend(later.time);
        for (channel, later) in self.channels.iter_mut().zip(later.channels) {
            channel.values.extend(later.values);
        }
    }

    /// Drops the first `count` rows.
    pub(crate) fn forget(&mut self, count: usize) {
        self.time.drain(..count);
        self.channels.iter_mut().for_each(|channel| drop(channel.values.drain(..count)));
    }

    /// Takes the first `count` rows off.
    pub(crate) fn take_first(&mut self, count: usize) -> Self {
        fn first<T>(values: &mut Vec<T>, count: usize) -> Vec<T> {
            let rest = values.split_off(count);
            std::mem::replace(values, rest)
        }
        let channel = |channel: &mut Channel| {
            let values = first(&mut channel.values, count);
            Channel { values, name: channel.name.clone(), unit: channel.unit.clone(), decimals: channel.decimals }
        };
        Self {
            path: self.path.clone(),
            time: first(&mut self.time, count),
            time_decimals: self.time_decimals,
            channels: self.channels.iter_mut().map(channel).collect(),
            header_line: self.header_line,
            origin: self.origin.clone(),
        }
    }

    /// The place of the column names.
    pub(crate) fn header(&self) -> Place {
        match self.header_line {
            0 => Place::file(&self.path),
            line => Place::line(&self.path, line),
        }
    }

    /// The channel of this name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// The channel of this name, which must measure `dimension`; `asked_from` is the place that needs it.
    ///
    /// # Errors
    /// As [`Record::of_dimension`], and one without any value.
    #[doc(hidden)]
    pub fn require(&self, name: &str, dimension: Dimension, asked_from: Place) -> Result<&Channel, Complaint> {
        let channel = self.of_dimension(name, dimension, asked_from.clone())?;
        if channel.is_empty() {
            return Err(Complaint::new(Kind::Empty, format!("the column `{name}` has no value in any row"))
                .at(asked_from)
                .at(self.header())
                .help("take a record that has it, or leave it out of the rig file"));
        }
        Ok(channel)
    }

    /// The same, which may be without any value.
    ///
    /// # Errors
    /// No such channel, or one of another dimension: both places, the near miss, and what the record has.
    pub(crate) fn of_dimension(
        &self,
        name: &str,
        dimension: Dimension,
        asked_from: Place,
    ) -> Result<&Channel, Complaint> {
        let header = self.header();
        let Some(channel) = self.channel(name) else {
            if let Some((_, why)) = self.origin.left_out.iter().find(|(left, _)| left == name) {
                return Err(Complaint::new(Kind::Unit, format!("the column `{name}` is left out: {why}"))
                    .at(asked_from)
                    .at(header)
                    .help(
                        "write its unit into its line of the rig file, such as `unit = \"bar\"`, or convert the record",
                    ));
            }
            let names = self.channels.iter().map(|channel| channel.name.as_str());
            return Err(Complaint::new(Kind::UnknownName, format!("the record has no column `{name}`"))
                .at(asked_from)
                .at(header)
                .help(help_with_names(name, "columns", names)));
        };
        if channel.unit.dimension == dimension {
            return Ok(channel);
        }
        let error = UnitError::WrongDimension {
            unit: channel.unit.symbol.clone(),
            found: channel.unit.dimension,
            wanted: dimension,
        };
        Err(Complaint::new(Kind::Dimension, format!("column `{name}`: {error}"))
            .at(asked_from)
            .at(header)
            .help(error.help()))
    }

    /// How the rows follow each other; `None` with fewer than two rows.
    #[doc(hidden)]
    pub fn sampling(&self) -> Option<Sampling> {
        Sampling::of(&self.time, self.time_decimals)
    }
}
