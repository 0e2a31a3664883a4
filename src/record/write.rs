//! From a record to a file that reads back as the same record.

use std::path::Path;

use super::Record;
use crate::complaint::{Complaint, Kind};
use crate::files::write_atomically;
use crate::units::Unit;

/// Decimal digits that every f64 keeps.
const SAFE_DIGITS: usize = 15;

pub(super) fn write(record: &Record, path: &Path) -> Result<(), Complaint> {
    check(record, path)?;
    let second = Unit::second();
    let time_decimals = record.time_decimals.filter(|decimals| rises_when_rounded(&record.time, *decimals));
    write_atomically(path, |file| {
        let mut table = csv::Writer::from_writer(file);
        let names = record.channels.iter().map(|channel| format!("{} [{}]", channel.name, channel.unit));
        table.write_record(std::iter::once("time [s]".to_owned()).chain(names))?;
        for (row, time) in record.time.iter().enumerate() {
            table.write_field(number(*time, &second, time_decimals))?;
            for channel in &record.channels {
                // `check` has seen that each channel is as long as the time.
                let value = channel.values.get(row).copied().unwrap_or(f64::NAN);
                table.write_field(number(value, &channel.unit, channel.decimals))?;
            }
            table.write_record(None::<&[u8]>)?;
        }
        table.flush()
    })
}

/// A record that could not be read back must not be written.
fn check(record: &Record, path: &Path) -> Result<(), Complaint> {
    let complain = |kind, what: String| Err(Complaint::new(kind, what).in_file(path));
    if record.time.is_empty() || record.channels.is_empty() {
        return complain(Kind::Empty, "a record without rows or channels is not written".to_owned());
    }
    let mut before = f64::NEG_INFINITY;
    for time in record.time.iter().copied() {
        if !(time.is_finite() && time > before) {
            return complain(Kind::Order, format!("the time does not rise to {time} s"));
        }
        before = time;
    }
    for (index, channel) in record.channels.iter().enumerate() {
        let name = &channel.name;
        let earlier = record.channels.iter().take(index);
        if name == "time" || earlier.into_iter().any(|other| other.name == *name) {
            return complain(Kind::Duplicate, format!("the column `{name}` appears twice"));
        }
        if name.trim().is_empty() {
            return complain(Kind::MissingEntry, format!("channel {} has no name", index + 1));
        }
        let (found, wanted) = (channel.values.len(), record.time.len());
        if found != wanted {
            return complain(Kind::Shape, format!("the column `{name}` has {found} values for {wanted} times"));
        }
        let bad = channel.values.iter().zip(&record.time).find(|(value, _)| !value.is_finite());
        if let Some((value, time)) = bad {
            return complain(Kind::Number, format!("the column `{name}` is {value} at {time} s"));
        }
    }
    Ok(())
}

/// Rounded times that repeat would be refused by the reader.
fn rises_when_rounded(time: &[f64], decimals: usize) -> bool {
    let last_digit = 10f64.powf(-(decimals as f64));
    time.iter().zip(time.iter().skip(1)).all(|(early, late)| (late / last_digit).round() > (early / last_digit).round())
}

/// The SI value in its unit: rounded to the decimals, or the shortest text that reads back as the same value.
fn number(si: f64, unit: &Unit, decimals: Option<usize>) -> String {
    let value = unit.from_si(si);
    if let Some(decimals) = decimals {
        return format!("{value:.decimals$}");
    }
    // The way through SI leaves 0.30000000000000004 where 0.3 was meant.
    let short = format!("{value:.*e}", SAFE_DIGITS - 1).parse::<f64>().unwrap_or(value);
    let chosen = if unit.to_si(short) == si { short } else { value };
    let magnitude = chosen.abs();
    if magnitude != 0.0 && !(1e-5..1e15).contains(&magnitude) { format!("{chosen:e}") } else { format!("{chosen}") }
}
