//! What is doubtful about a record, with its times: the clock, and each channel by itself.

mod channel;
mod clock;

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use super::{Channel, Record};
use crate::number::{in_unit, rounded, text, with_unit};
use crate::units::Unit;
use channel::Known;

/// A sort of doubt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Doubt {
    /// The time stands still from row to row.
    DuplicateStamp,
    /// The time runs backwards.
    ClockReset,
    /// Rows are missing.
    MissingRows,
    /// Intervals between rows that are not alike.
    Jitter,
    /// No value.
    Dropout,
    /// One value throughout.
    Constant,
    /// The same of a sensor that noise alone would move, in a record whose other channels are moved by theirs.
    Dead,
    /// One value for longer than noise allows.
    Stuck,
    /// The same at the greatest or the least value of the channel.
    Saturated,
    /// A value far from its neighbours on both sides.
    Spike,
}

/// One doubt.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Finding {
    /// What is doubtful.
    #[doc(hidden)]
    pub doubt: Doubt,
    /// The column; `None` for the clock.
    pub channel: Option<String>,
    /// First and last time, s, of the rows that it is about.
    pub from_s: f64,
    /// Last time of the rows that it is about, s.
    pub to_s: f64,
    /// Rows that it is about; of missing ones, and of a channel that lacks some, how many.
    pub rows: usize,
    /// The rows from its first to its last; of the clock none.
    #[serde(skip)]
    pub(crate) span: Range<usize>,
    /// The value at which it stands, or the one that is off, in `unit`; of jitter its root mean square; of a clock that was
    /// set the time before.
    pub value: Option<f64>,
    /// Unit of `value`; `None` without one.
    pub unit: Option<String>,
}

/// Every doubt: first those about the clock, then those about each column, in the order of the file and of their times.
///
/// Whether a channel stands still or leaps is judged only where `scatter` says what moves one of its samples; a leap only
/// where no other such channel bends within the rows before, since a circuit that switches leaps too. At times at which it `switches`
/// no other channel has to say so: the leap is then doubted only where it is far beyond all other values of its channel.
pub fn survey(
    record: &Record,
    scatter: impl Fn(&Channel) -> Option<Scatter>,
    switches: impl Fn(f64) -> bool,
) -> Vec<Finding> {
    let mut findings = clock::survey(record);
    let known: Vec<Known<'_>> = record.channels.iter().map(|channel| Known::new(channel, scatter(channel))).collect();
    let any_measured = known.iter().any(|known| known.is_measured);
    for (index, own) in known.iter().enumerate() {
        let restless = |row: usize| {
            let others = known.iter().enumerate().filter(|(other, _)| *other != index);
            others.into_iter().any(|(_, other)| channel::is_near(&other.bends, row))
        };
        findings.extend(channel::survey(own, &record.time, any_measured, (restless, &switches)));
    }
    findings
}

/// What moves a reading although what it reads stands still, SI.
#[derive(Debug, Clone, Copy)]
pub struct Scatter {
    /// Standard deviation of one sample.
    pub noise: f64,
    /// Step of the last digit; 0 where it does not matter.
    pub resolution: f64,
}

impl Scatter {
    /// Step of the last digit, in standard deviations of the noise, up to which noise moves readings: even if it were a third
    /// of what is declared, half of the rows would differ from the one before.
    const COARSEST: f64 = 0.6;
    /// Rows that are never alike by chance then.
    const FEWEST: usize = 20;

    /// Whether so many readings of one value are no chance.
    fn moves(self, rows: usize) -> bool {
        self.resolution <= Self::COARSEST * self.noise && rows >= Self::FEWEST
    }
}

impl Finding {
    fn of_rows(
        doubt: Doubt,
        channel: &Channel,
        time: &[f64],
        rows: std::ops::Range<usize>,
        value: Option<f64>,
    ) -> Self {
        let at = |row: usize| rounded(time.get(row).copied().unwrap_or_default(), 12);
        Self {
            doubt,
            channel: Some(channel.name.clone()),
            from_s: at(rows.start),
            to_s: at(rows.end.saturating_sub(1)),
            rows: rows.len(),
            span: rows,
            value: value.map(|value| in_unit(value, &channel.unit)),
            unit: Some(channel.unit.to_string()),
        }
    }

    fn of_clock(doubt: Doubt, from: f64, to: f64, rows: usize, value: Option<f64>) -> Self {
        Self {
            doubt,
            channel: None,
            from_s: rounded(from, 12),
            to_s: rounded(to, 12),
            rows,
            span: 0..0,
            value: value.map(|value| rounded(value, 6)),
            unit: Some(Unit::second().to_string()),
        }
    }
}

impl fmt::Display for Finding {
    /// The doubt in words.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.channel.as_deref().unwrap_or_default();
        let (from, to, rows) = (rounded(self.from_s, 9), rounded(self.to_s, 9), self.rows);
        let value = with_unit(self.value.unwrap_or_default(), self.unit.as_deref().unwrap_or("-"));
        let when = if from == to { format!("at {from} s") } else { format!("from {from} s to {to} s") };
        let many = if rows == 1 { "1 row".to_owned() } else { format!("{rows} rows") };
        match self.doubt {
            Doubt::DuplicateStamp => write!(f, "the time {from} s stands in {many}"),
            Doubt::ClockReset => write!(f, "the clock was set back from {value} to {from} s"),
            Doubt::MissingRows => write!(f, "{many} missing {when}"),
            Doubt::Jitter => {
                write!(
                    f,
                    "the intervals between rows scatter by {value}, most {when} with {} s",
                    text(rounded(to - from, 6))
                )
            }
            Doubt::Dropout => write!(f, "`{name}` has no value in {many} {when}"),
            Doubt::Constant => write!(f, "`{name}` stays at {value}: is the sensor connected?"),
            Doubt::Dead => write!(
                f,
                "`{name}` stays at {value} in all {rows} rows, which the noise that the rig file gives it would not allow: a dead sensor"
            ),
            Doubt::Stuck => write!(f, "`{name}` is stuck at {value} for {many} {when}"),
            Doubt::Saturated => write!(f, "`{name}` may be saturated: it rests at its extreme value {value} {when}"),
            Doubt::Spike => write!(f, "`{name}` leaps to {value} {when}"),
        }
    }
}

/// Findings of one doubt about one channel that are told together from so many on.
const TOGETHER: usize = 4;

/// Findings in words: first those of whole sensors, and those of one doubt about one channel together where they are many.
pub fn told<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> Vec<String> {
    // In the order in which each doubt about a channel comes first.
    let mut places: BTreeMap<(Doubt, &Option<String>), usize> = BTreeMap::new();
    let mut alike: Vec<Vec<&Finding>> = Vec::new();
    for finding in findings {
        let place = *places.entry((finding.doubt, &finding.channel)).or_insert(alike.len());
        if place == alike.len() {
            alike.push(Vec::new());
        }
        alike[place].push(finding);
    }
    let throughout = |alike: &Vec<&Finding>| matches!(alike[0].doubt, Doubt::Dead | Doubt::Constant);
    alike.sort_by_key(|alike| !throughout(alike));
    let words = |alike: Vec<&Finding>| match alike.len() {
        ..TOGETHER => alike.into_iter().map(Finding::to_string).collect(),
        _ => vec![together(&alike)],
    };
    alike.into_iter().flat_map(words).collect()
}

/// Many findings of one doubt about one channel.
fn together(alike: &[&Finding]) -> String {
    let (Some(first), Some(last)) = (alike.first(), alike.last()) else { return String::new() };
    let name = first.channel.as_deref().unwrap_or_default();
    let (count, rows) = (alike.len(), alike.iter().map(|finding| finding.rows).sum::<usize>());
    let when = format!("{count} times from {} s to {} s", rounded(first.from_s, 9), rounded(last.to_s, 9));
    match first.doubt {
        Doubt::DuplicateStamp => format!("a time stands in several rows {when}"),
        Doubt::ClockReset => format!("the clock was set back {when}"),
        Doubt::MissingRows => format!("rows are missing {when}, {rows} in all"),
        Doubt::Jitter => format!("the intervals between rows scatter {when}"),
        Doubt::Dropout => format!("`{name}` has no value {when}, in {rows} rows in all"),
        Doubt::Constant | Doubt::Dead | Doubt::Stuck => format!("`{name}` is stuck {when}, for {rows} rows in all"),
        Doubt::Saturated => {
            format!("`{name}` may be saturated: it rests at an extreme value {when}, for {rows} rows in all")
        }
        Doubt::Spike => format!("`{name}` leaps {when}"),
    }
}
