//! What is in a record, and what is doubtful in it.

use std::path::Path;

use serde::Serialize;

use crate::complaint::Complaint;
use crate::diagnosis::doubtful::surveyed;
use crate::diagnosis::weighed::measured;
use crate::model::InputSignals;
use crate::number::{difference_in_unit, in_unit, rounded};
use crate::record::survey::{Finding, told};
use crate::record::{Channel, Record};
use crate::rig::{Proposal, Rig};

/// What is in a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct RecordPage {
    /// As the user named it.
    pub file: String,
    /// What was recognised of the file.
    pub read_as: String,
    /// Whether a diagnosis can use the record.
    pub usable: bool,
    /// How many there are.
    pub rows: usize,
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
    /// The most frequent one between rows, s; 0 with fewer than two rows.
    pub interval_s: f64,
    /// From the first to the last row, s.
    pub duration_s: f64,
    /// Every column but the time.
    pub channels: Vec<ChannelLine>,
    /// Between jumps of the inputs; empty where the record lacks an input.
    #[doc(hidden)]
    pub phases: Vec<PhaseLine>,
    /// Columns that the rig asks for and the record lacks, with those that they may be.
    pub(crate) mapping: Vec<Proposal>,
    /// What is doubtful, with its times.
    pub findings: Vec<Finding>,
    /// The same in words.
    pub warnings: Vec<String>,
}

/// A column of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ChannelLine {
    /// From the header.
    pub name: String,
    /// As the record has it.
    pub unit: String,
    /// In `unit`; `null` of a column without any value.
    pub least: Option<f64>,
    /// The same.
    pub greatest: Option<f64>,
    /// `sensor`, `input`, or nothing of this rig.
    pub role: Option<&'static str>,
}

/// What stands between two jumps of the inputs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct PhaseLine {
    /// Its beginning, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
    /// In the order of the rig file.
    pub inputs: Vec<PhaseInput>,
}

/// An input over a phase. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct PhaseInput {
    /// As the rig file has it.
    pub name: String,
    /// At the beginning.
    pub from: f64,
    /// At the end.
    pub to: f64,
    /// The least on the way, where that is not noise.
    pub least: f64,
    /// The most.
    pub most: f64,
    /// As the rig file has it.
    pub unit: String,
}

/// Standard deviations of an input's noise by which it does not stray.
const NOISE: f64 = 6.0;

impl PhaseInput {
    /// Takes for noise what its extremes differ by from its ends by so much, in `unit`.
    fn without_noise(&mut self, noise: f64) {
        let (low, high) = (self.from.min(self.to), self.from.max(self.to));
        self.least = if self.least < low - noise { self.least } else { low };
        self.most = if self.most > high + noise { self.most } else { high };
    }
}

/// The page, and what keeps a diagnosis from using the record.
pub(super) fn record_page(rig: &Rig, path: &Path) -> Result<(RecordPage, Option<Complaint>), Complaint> {
    let (record, refused) = rig.record_as_it_stands(path)?;
    let mapping = rig.proposals(&record);
    let drive = match refused {
        Some(complaint) => Err(complaint),
        None => columns(rig, &record),
    };
    let findings = surveyed(rig, &record);
    let (from, to) = (record.time.first().copied().unwrap_or(0.0), record.time.last().copied().unwrap_or(0.0));
    let sampling = record.sampling();
    let mut warnings: Vec<String> = Vec::new();
    if let Some(sampling) = sampling.filter(|sampling| !sampling.regular) {
        warnings.push(format!(
            "the sampling is irregular: intervals from {} s to {} s, mostly {} s",
            rounded(sampling.shortest, 6),
            rounded(sampling.longest, 6),
            rounded(sampling.interval, 6)
        ));
    }
    warnings.extend(rig.at_odds(&record));
    warnings.extend(rig.few_samples(&record));
    warnings.extend(super::sense::senseless(rig, &record));
    if drive.is_ok() {
        warnings.extend(super::model::doubts(rig, &record)?);
    }
    warnings.extend(told(&findings));
    let left_out = |(name, why): &(String, String)| format!("`{name}` of the file is no column of the record: {why}");
    warnings.extend(record.origin.left_out.iter().map(left_out));
    let role = |channel: &Channel| {
        if rig.sensors.iter().any(|sensor| sensor.column == channel.name) {
            Some("sensor")
        } else if rig.inputs.iter().any(|input| input.column == channel.name) {
            Some("input")
        } else {
            let temperature = rig.temperature.as_ref();
            temperature.filter(|temperature| temperature.input.column == channel.name).map(|_| "temperature")
        }
    };
    let channels = record.channels.iter().map(|channel| {
        let range = channel.range();
        ChannelLine {
            name: channel.name.clone(),
            unit: channel.unit.to_string(),
            least: range.map(|(least, _)| in_unit(least, &channel.unit)),
            greatest: range.map(|(_, greatest)| in_unit(greatest, &channel.unit)),
            role: role(channel),
        }
    });
    let page = RecordPage {
        file: record.path.display().to_string(),
        read_as: record.origin.read_as.clone(),
        usable: drive.is_ok(),
        rows: record.time.len(),
        from_s: rounded(from, 12),
        to_s: rounded(to, 12),
        interval_s: sampling.map_or(0.0, |sampling| rounded(sampling.interval, 9)),
        duration_s: rounded(to - from, 12),
        channels: channels.collect(),
        phases: drive.as_ref().map_or_else(|_| Vec::new(), |drive| phases(rig, drive)),
        mapping,
        findings,
        warnings,
    };
    Ok((page, drive.err()))
}

/// The drive, where the record has every column that the rig asks for.
fn columns(rig: &Rig, record: &Record) -> Result<InputSignals, Complaint> {
    let drive = InputSignals::from_record(rig, record)?;
    measured(rig, record)?;
    Ok(drive)
}

/// The pieces of the drive as commanded, joined up to the next jump.
fn phases(rig: &Rig, drive: &InputSignals) -> Vec<PhaseLine> {
    let mut phases: Vec<PhaseLine> = Vec::new();
    for piece in drive.commanded.as_ref().unwrap_or(&drive.pieces) {
        match phases.last_mut().filter(|_| !piece.jump) {
            Some(phase) => {
                phase.to_s = rounded(piece.end, 12);
                for ((own, to), input) in phase.inputs.iter_mut().zip(&piece.to).zip(&rig.inputs) {
                    own.to = in_unit(*to, &input.unit);
                    (own.least, own.most) = (own.least.min(own.to), own.most.max(own.to));
                }
            }
            None => phases.push(PhaseLine {
                from_s: rounded(piece.start, 12),
                to_s: rounded(piece.end, 12),
                inputs: rig
                    .inputs
                    .iter()
                    .zip(piece.from.iter().zip(&piece.to))
                    .map(|(input, (from, to))| {
                        let [from, to] = [from, to].map(|value| in_unit(*value, &input.unit));
                        let (name, unit) = (input.name.clone(), input.unit.to_string());
                        PhaseInput { name, from, to, least: from.min(to), most: from.max(to), unit }
                    })
                    .collect(),
            }),
        }
    }
    for phase in &mut phases {
        for (own, input) in phase.inputs.iter_mut().zip(&rig.inputs) {
            own.without_noise(difference_in_unit(NOISE * input.noise, &input.unit).abs());
        }
    }
    phases
}
