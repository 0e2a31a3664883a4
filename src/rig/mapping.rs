//! Which columns of a record may be those that a rig asks for under other names.

use std::path::Path;

use serde::Serialize;

use super::{Input, Rig, Sensor, Temperature};
use crate::complaint::{Complaint, Kind, help_with_near};
use crate::record::{Channel, Record, named_place};
use crate::units::{Dimension, Unit};

/// A column that the rig asks for and the record does not have, with the column that it may be.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Proposal {
    /// The column that the rig file names.
    pub wanted: String,
    /// `sensor`, `input` or `temperature`.
    pub role: &'static str,
    /// The column of the record; `None` where none has its unit.
    pub column: Option<String>,
    /// How alike the names are, from 0 to 1.
    pub similarity: f64,
    /// What speaks for it: `name`, or `unit` where it is the only column left with that dimension.
    pub because: Option<&'static str>,
}

/// Similarity of names from which a column is proposed by its name.
const ALIKE: f64 = 0.5;

impl Rig {
    /// Reads a record of this rig as [`Record::read_as_it_stands`] does; the columns of scaled sensors come as what they stand
    /// for.
    ///
    /// # Errors
    /// As [`Record::read_as_it_stands`].
    pub(crate) fn record_as_it_stands(&self, path: impl AsRef<Path>) -> Result<(Record, Option<Complaint>), Complaint> {
        let (record, refused) = self.asked().read_as_it_stands(path)?;
        Ok((self.scaled(record), refused))
    }

    /// The column that a sensor reads, SI; it may be without any value.
    ///
    /// # Errors
    /// As [`Record::of_dimension`]; the column that may be meant is none that the rig reads for something else.
    pub(crate) fn sensor_column<'a>(&self, record: &'a Record, sensor: &Sensor) -> Result<&'a Channel, Complaint> {
        let found = record.of_dimension(&sensor.column, sensor.dimension, sensor.place.clone());
        found.map_err(|complaint| self.advised(record, &sensor.column, complaint))
    }

    /// The column that an input reads, SI.
    ///
    /// # Errors
    /// As [`Record::require`]; the column that may be meant is none that the rig reads for something else.
    pub(crate) fn input_column<'a>(&self, record: &'a Record, input: &Input) -> Result<&'a Channel, Complaint> {
        let found = record.require(&input.column, input.unit.dimension, input.place.clone());
        found.map_err(|complaint| self.advised(record, &input.column, complaint))
    }

    /// A complaint of a column that is missing, with the one that may be it.
    fn advised(&self, record: &Record, column: &str, complaint: Complaint) -> Complaint {
        if complaint.kind != Kind::UnknownName {
            return complaint;
        }
        let proposals = self.proposals(record);
        let near = proposals.iter().find(|proposal| proposal.wanted == column);
        let names = record.channels.iter().map(|channel| channel.name.as_str());
        complaint.help(help_with_near(near.and_then(|near| near.column.as_deref()), "columns", names))
    }

    /// For each column that the record lacks, the one of those that the rig does not name which is most alike in name, of the
    /// right dimension. No column is proposed twice.
    pub(crate) fn proposals(&self, record: &Record) -> Vec<Proposal> {
        let sensors = self.sensors.iter().map(|sensor| {
            let dimension = sensor.scale.as_ref().map_or(sensor.dimension, |scale| scale.raw.dimension);
            ("sensor", &sensor.column, dimension)
        });
        let inputs = self.inputs.iter().map(|input| {
            ("input", &input.column, input.scale.as_ref().map_or(&input.unit, |scale| &scale.raw).dimension)
        });
        let temperature = self
            .temperature
            .iter()
            .filter(|_| self.viscosity_varies())
            .map(|Temperature { input, .. }| ("temperature", &input.column, input.unit.dimension));
        let named: Vec<(&str, &String, Dimension)> = sensors.chain(inputs).chain(temperature).collect();
        let lacking: Vec<_> = named.iter().filter(|(_, column, _)| record.channel(column).is_none()).collect();
        let free: Vec<(&str, &Unit)> = record
            .channels
            .iter()
            .filter(|channel| !named.iter().any(|(_, column, _)| **column == channel.name))
            .map(|channel| (channel.name.as_str(), &channel.unit))
            .collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (want, (_, column, dimension)) in lacking.iter().enumerate() {
            let fitting = free.iter().enumerate().filter(|(_, (_, unit))| unit.dimension == *dimension);
            pairs.extend(fitting.filter_map(|(have, (name, _))| Some((similarity(column, name)?, want, have))));
        }
        // The most alike first; ties in the order of the files.
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut chosen: Vec<Option<(f64, usize, &'static str)>> = vec![None; lacking.len()];
        for (alike, want, have) in &pairs {
            let taken = |have: &usize, chosen: &[Option<(f64, usize, &str)>]| {
                chosen.iter().flatten().any(|(_, other, _)| other == have)
            };
            if chosen[*want].is_some() || taken(have, &chosen) {
                continue;
            }
            let rivals = pairs.iter().filter(|(_, other, _)| other == want);
            let alone = rivals.filter(|(_, _, other)| !taken(other, &chosen)).count() == 1;
            let because = if *alike >= ALIKE { Some("name") } else { alone.then_some("unit") };
            chosen[*want] = because.map(|because| (*alike, *have, because));
        }
        lacking
            .iter()
            .zip(chosen)
            .map(|((role, wanted, _), chosen)| Proposal {
                wanted: (*wanted).clone(),
                role,
                column: chosen.map(|(_, have, _)| free[have].0.to_owned()),
                similarity: chosen.map_or(0.0, |(alike, _, _)| crate::number::rounded(alike, 3)),
                because: chosen.map(|(_, _, because)| because),
            })
            .collect()
    }
}

/// How alike two names are, letters and digits alone counting. Names that say the same place of a circuit are alike in any language, names
/// that say two places are not.
fn similarity(a: &str, b: &str) -> Option<f64> {
    let placed = match (named_place(a), named_place(b)) {
        (Some(a), Some(b)) if a != b => return None,
        (Some(_), Some(_)) => ALIKE,
        _ => 0.0,
    };
    let bare =
        |name: &str| name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect::<String>();
    Some(strsim::normalized_damerau_levenshtein(&bare(a), &bare(b)).max(placed))
}
