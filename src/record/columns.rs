//! Records from columns in memory, for programs that measure themselves.

use super::{Channel, Record};
use crate::complaint::{Complaint, Kind, Place};
use crate::units::Unit;

/// What messages call a record that comes from no file.
const NAME: &str = "record";

/// What drives a run, seen from a record: its times, commands and loads, and of the sensors where each node starts.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    pub(crate) record: &'a Record,
}

impl Record {
    /// A record of columns in memory: times in seconds, then of each column its name, its unit and its values in that unit, one
    /// for each time; NaN where there is none.
    ///
    /// Columns of a sensor that writes another quantity than it measures (`scale` in the rig file) are turned into that by
    /// [`Rig::scaled`](crate::rig::Rig::scaled).
    ///
    /// # Errors
    /// No rows; times that are not finite or do not rise; a column without name, with a name that appears twice, with a unit that
    /// is not known, of another length than the times, or with an infinite value. The first mistake is reported.
    ///
    /// ```
    /// use borescope::Record;
    ///
    /// let record = Record::from_columns(vec![0.0, 0.1], [("p_A", "bar", vec![20.0, 21.5])])?;
    /// assert_eq!(record.channels[0].values, [2.0e6, 2.15e6]);
    /// let wrong = Record::from_columns(vec![0.0, 0.1], [("p_A", "bar", vec![20.0])]).unwrap_err();
    /// assert_eq!(wrong.what, "the column `p_A` has 1 value, but there are 2 times");
    /// # Ok::<(), borescope::Complaint>(())
    /// ```
    pub fn from_columns<N, U>(
        time: Vec<f64>,
        columns: impl IntoIterator<Item = (N, U, Vec<f64>)>,
    ) -> Result<Self, Complaint>
    where
        N: Into<String>,
        U: AsRef<str>,
    {
        check_times(&time)?;
        let mut channels: Vec<Channel> = Vec::new();
        for (name, unit, values) in columns {
            let channel = channel(name.into(), unit.as_ref(), values, &time)?;
            if channels.iter().any(|known| known.name == channel.name) {
                return Err(wrong(Kind::Duplicate, format!("the column `{}` appears twice", channel.name))
                    .help("give every column a name of its own"));
            }
            channels.push(channel);
        }
        Ok(Self { header_line: 0, ..Self::new(NAME, time, channels) })
    }

    /// What drives a run as this record was driven.
    pub fn inputs(&self) -> Inputs<'_> {
        Inputs { record: self }
    }
}

fn wrong(kind: Kind, what: String) -> Complaint {
    Complaint::new(kind, what).at(Place::file(NAME))
}

fn check_times(time: &[f64]) -> Result<(), Complaint> {
    if time.is_empty() {
        return Err(wrong(Kind::Empty, "the record has no rows".to_owned()).help("give at least two times"));
    }
    if let Some(row) = time.iter().position(|time| !time.is_finite()) {
        return Err(wrong(Kind::Number, format!("the time of row {} is {}, not a finite number", row + 1, time[row]))
            .help("give seconds"));
    }
    if let Some(row) = time.windows(2).position(|pair| pair[1] <= pair[0]) {
        let what =
            format!("the time does not rise from row {} ({} s) to the next ({} s)", row + 1, time[row], time[row + 1]);
        return Err(wrong(Kind::Order, what).help("sort the rows by time, and keep one of those that repeat"));
    }
    Ok(())
}

fn channel(name: String, unit: &str, written: Vec<f64>, time: &[f64]) -> Result<Channel, Complaint> {
    if name.trim().is_empty() {
        return Err(wrong(Kind::MissingEntry, "a column has no name".to_owned())
            .help("give the name that the rig file has for it"));
    }
    let unit = Unit::parse(unit)
        .map_err(|error| wrong(Kind::Unit, format!("the column `{name}`: {error}")).help(error.help()))?;
    if written.len() != time.len() {
        let values = if written.len() == 1 { "value" } else { "values" };
        let what = format!("the column `{name}` has {} {values}, but there are {} times", written.len(), time.len());
        return Err(wrong(Kind::Shape, what).help("give one value for each time, NaN where there is none"));
    }
    if let Some(row) = written.iter().position(|value| value.is_infinite()) {
        return Err(wrong(Kind::Number, format!("the column `{name}` is infinite in row {}", row + 1))
            .help("give NaN where there is no value"));
    }
    let values = written.into_iter().map(|value| unit.to_si(value)).collect();
    Ok(Channel::new(name, unit, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaint(time: &[f64], columns: Vec<(&str, &str, Vec<f64>)>) -> Complaint {
        Record::from_columns(time.to_vec(), columns).unwrap_err()
    }

    #[test]
    fn values_are_taken_in_their_unit() {
        let columns = [("p", "bar", vec![1.0, f64::NAN]), ("T", "degC", vec![20.0, 21.0])];
        let record = Record::from_columns(vec![0.0, 0.5], columns).unwrap();
        assert_eq!(record.channels[0].values[0], 1e5);
        assert!(record.channels[0].values[1].is_nan());
        assert_eq!(record.channels[1].values, [293.15, 294.15]);
        assert_eq!(record.header(), Place::file(NAME));
    }

    #[test]
    fn every_mistake_has_its_complaint() {
        let p = |values: &[f64]| vec![("p", "bar", values.to_vec())];
        assert_eq!(complaint(&[], p(&[])).kind, Kind::Empty);
        assert_eq!(complaint(&[0.0, f64::NAN], p(&[1.0, 2.0])).kind, Kind::Number);
        assert_eq!(complaint(&[0.0, 0.0], p(&[1.0, 2.0])).kind, Kind::Order);
        assert_eq!(complaint(&[0.0, 1.0], p(&[1.0])).kind, Kind::Shape);
        assert_eq!(complaint(&[0.0, 1.0], p(&[1.0, f64::INFINITY])).kind, Kind::Number);
        assert_eq!(complaint(&[0.0], vec![("p", "bra", vec![1.0])]).kind, Kind::Unit);
        assert_eq!(complaint(&[0.0], vec![(" ", "bar", vec![1.0])]).kind, Kind::MissingEntry);
        let twice = vec![("p", "bar", vec![1.0]), ("p", "bar", vec![1.0])];
        assert_eq!(complaint(&[0.0], twice).kind, Kind::Duplicate);
    }
}
