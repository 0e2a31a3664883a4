//! Dates with times of day in the first column of a record.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// How messages show one.
pub(super) const EXAMPLE: &str = "2026-11-23 10:00:00.120";

/// A moment of the calendar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamp {
    /// Of a clock that is in UTC where the text does not say its zone.
    moment: Timestamp,
    /// Whether the text says its zone.
    pub zoned: bool,
    /// Digits behind the seconds.
    pub decimals: usize,
}

impl Stamp {
    /// A date and a time of day, with a blank or a `T` between them, with or without its distance to UTC: after ISO 8601, or day, month
    /// and year between points, an order that no country exchanges. Dates between slashes leave open which number is the day.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (date, time) = text.split_once(['T', ' ']).filter(|(_, time)| time.contains(':'))?;
        let date = iso(date)?;
        let text = format!("{date}T{}", time.replacen(',', ".", 1));
        let decimals = time
            .split_once(['.', ','])
            .map_or(0, |(_, fraction)| fraction.bytes().take_while(u8::is_ascii_digit).count());
        let zoned = text.parse::<Timestamp>().ok();
        let local = || text.parse::<DateTime>().ok()?.to_zoned(TimeZone::UTC).ok().map(|zoned| zoned.timestamp());
        let moment = zoned.or_else(local)?;
        Some(Self { moment, zoned: zoned.is_some(), decimals })
    }

    /// Seconds since another moment.
    pub(super) fn seconds_since(self, other: Self) -> f64 {
        (self.moment.as_nanosecond() - other.moment.as_nanosecond()) as f64 / 1e9
    }
}

/// A date as ISO 8601 has it.
fn iso(date: &str) -> Option<String> {
    let digits = |text: &str, count: &[usize]| count.contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    let parts = |sign: char| <[&str; 3]>::try_from(date.split(sign).collect::<Vec<_>>()).ok();
    if let Some([year, month, day]) = parts('-') {
        let is_date = digits(year, &[4]) && digits(month, &[2]) && digits(day, &[2]);
        return is_date.then(|| date.to_owned());
    }
    let [day, month, year] = parts('.')?;
    let is_date = digits(year, &[4]) && digits(month, &[1, 2]) && digits(day, &[1, 2]);
    is_date.then(|| format!("{year}-{month:0>2}-{day:0>2}"))
}

/// Whether a text looks like a date or a time of day.
pub(super) fn may_be_date(text: &str) -> bool {
    text.contains([':', '/']) || ['-', '.'].iter().any(|sign| text.matches(*sign).count() > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_with_times_of_day_are_moments() {
        let first = Stamp::parse("2026-11-23 10:00:00.120").unwrap();
        for (text, seconds, zoned, decimals) in [
            ("2026-11-23T10:00:00.120", 0.0, false, 3),
            ("2026-11-23 10:00:00,1205", 0.0005, false, 4),
            ("2026-11-23 10:01", 59.88, false, 0),
            ("2026-11-24 00:00:00", 50399.88, false, 0),
            ("23.11.2026 10:00:00,125", 0.005, false, 3),
            ("1.12.2026 10:00:00", 8.0 * 86400.0 - 0.12, false, 0),
            ("2026-11-23T10:00:00.120Z", 0.0, true, 3),
            ("2026-11-23 11:00:00.12+01:00", 0.0, true, 2),
        ] {
            let stamp = Stamp::parse(text).unwrap();
            assert_eq!((stamp.seconds_since(first), stamp.zoned, stamp.decimals), (seconds, zoned, decimals), "{text}");
        }
    }

    #[test]
    fn other_ways_to_write_a_date_are_none() {
        for text in [
            "2026-11-23",
            "10:00:00.120",
            "11.23.2026 10:00:00",
            "23.11.26 10:00:00",
            "11/12/2026 10:00",
            "2026-11-23 25:00:00",
            "2026-02-30 10:00:00",
            "20261123T100000",
            "1.5",
            "",
            "2026-11-23 10",
            "2026-11-23 10:00:00 PM",
        ] {
            assert_eq!(Stamp::parse(text), None, "{text}");
        }
    }
}
