//! Moments of the calendar, in UTC, to the millisecond.

use std::fmt;
use std::str::FromStr;
use std::time::SystemTime;

use jiff::civil::{Date, DateTime};
use jiff::{Timestamp, Unit};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::complaint::{Complaint, Kind};

/// A moment; its text `2026-05-01T12:00:00.000Z` sorts as the moments do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment(Timestamp);

impl Moment {
    /// The present moment.
    pub fn now() -> Self {
        Self::of(Timestamp::now())
    }

    /// The moment of a file's clock; `None` where it lies outside the calendar, years -9999 to 9999.
    pub fn of_system(time: SystemTime) -> Option<Self> {
        Timestamp::try_from(time).ok().map(Self::of)
    }

    /// The moment this many seconds behind the beginning of 1970; `None` where it lies outside the calendar.
    pub fn of_seconds(seconds: f64) -> Option<Self> {
        if seconds.is_nan() || seconds.abs() >= 1e12 {
            return None;
        }
        Timestamp::from_millisecond((seconds * 1e3).round() as i64).ok().map(Self)
    }

    /// Seconds since the beginning of 1970.
    pub fn seconds(self) -> f64 {
        self.0.as_millisecond() as f64 / 1e3
    }

    /// The day, the time and the zone, `2026-05-01 12:00 UTC`.
    pub fn short(self) -> String {
        self.0.strftime("%Y-%m-%d %H:%M UTC").to_string()
    }

    fn of(timestamp: Timestamp) -> Self {
        Self(timestamp.round(Unit::Millisecond).unwrap_or(timestamp))
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3}", self.0)
    }
}

impl Serialize for Moment {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Moment {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(|complaint: Complaint| D::Error::custom(complaint.what))
    }
}

impl FromStr for Moment {
    type Err = Complaint;

    /// Reads a date with time and zone, `2026-05-01T12:00:00Z` or `2026-05-01T14:00:00+02:00`, or a date alone, which is its
    /// beginning in UTC.
    fn from_str(text: &str) -> Result<Self, Complaint> {
        if let Ok(timestamp) = text.parse::<Timestamp>() {
            return Ok(Self::of(timestamp));
        }
        let wrong = |what: String, help: &str| Err(Complaint::new(Kind::Syntax, what).help(help));
        // A text with a time parses as a date too.
        if text.contains([':', 'T']) && text.parse::<DateTime>().is_ok() {
            let help = "add `Z` for UTC, or the distance to it: `2026-05-01T14:00:00+02:00`";
            return wrong(format!("`{text}` does not say its time zone"), help);
        }
        match text.parse::<Date>().ok().and_then(|date| date.to_zoned(jiff::tz::TimeZone::UTC).ok()) {
            Some(day) if !text.contains([':', 'T']) => Ok(Self::of(day.timestamp())),
            _ => wrong(format!("`{text}` is no moment"), "write a moment such as `2026-05-01T12:00:00Z`, or a date"),
        }
    }
}
