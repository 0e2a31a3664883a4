//! What drives the circuit: the recorded commands and loads as pieces between which nothing jumps.

use std::borrow::Cow;

use super::piece::{Piece, merge, split, value};
use super::readings::{FirstReading, Shown, positions, readings, states};
use super::reshaped::{Following, acting, shifted};
use super::rows::cycle_times;
use super::stretch::{Stretch, broken_line, fit_line, through};
use crate::complaint::{Complaint, Kind, Place};
use crate::record::{Channel, Record, Sampling};
use crate::rig::{Cycle, Hold, Input, Rig, Target, Temperature};

/// The pieces of a whole record, one after the other without gap.
#[derive(Debug, Clone)]
pub struct InputSignals {
    /// In the order of time.
    pub pieces: Vec<Piece>,
    /// What was commanded, where that acts on parts with mass or after a dead time: `pieces` are then reshaped.
    pub commanded: Option<Vec<Piece>>,
    /// By how much later than commanded each input acts in `pieces` by its own dead time, s.
    pub dead_times: Vec<f64>,
    /// First readings of the nodes' gauge pressures; none where nothing measures.
    pub readings: Vec<FirstReading>,
    /// What is added to the pressure that each node starts with, Pa: zeros, but for asking what another start would do.
    pub nudges: Vec<f64>,
    /// Where parameters change within the record.
    pub onset: Option<Onset>,
    /// What sensors show at the start, which nodes then start with whatever the rig file says.
    pub shown: Vec<Shown>,
    /// When the run began of which this is a part, s: from there on time counts for what changes with it.
    pub begun: f64,
}

/// A moment until which some parameters have other values than after it, such as the beginning of a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Onset {
    /// s.
    pub time: f64,
    /// Indices among the rig's parameters with what they were before.
    pub before: Vec<(usize, Before)>,
}

/// What a parameter was before a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Before {
    /// SI.
    Value(f64),
    /// What the parameter with this index is.
    Like(usize),
}

/// By how much later than the record says inputs act, s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Late {
    /// Those with noise, which a sensor measures.
    pub measured: f64,
    /// Those without, which a controller gives.
    pub commanded: f64,
}

impl InputSignals {
    /// From the input columns of a record.
    ///
    /// # Errors
    /// A column that is missing or of another dimension; fewer than two rows. Of the sensors only those are needed that
    /// tell where a node starts.
    pub fn from_record(rig: &Rig, record: &Record) -> Result<Self, Complaint> {
        Self::from_late_record(rig, record, Late::default())
    }

    /// The same, had some inputs acted later than the record says.
    ///
    /// # Errors
    /// As [`InputSignals::from_record`].
    pub fn from_late_record(rig: &Rig, record: &Record, late: Late) -> Result<Self, Complaint> {
        let (readings, mut shown) = (readings(rig, record)?, positions(rig, record)?);
        shown.extend(states(rig, record));
        Ok(Self { readings, shown, ..Self::inputs(rig, record, late)? })
    }

    /// The same with nothing read of where the nodes start.
    ///
    /// # Errors
    /// As [`InputSignals::from_record`], but for the sensors.
    pub(crate) fn inputs(rig: &Rig, record: &Record, late: Late) -> Result<Self, Complaint> {
        let Some(interval) = record.sampling().map(|sampling| sampling.interval) else {
            return Err(Complaint::new(Kind::Shape, "the record has fewer than two rows, so no interval between rows")
                .at(record.header())
                .help("take a record of at least two rows"));
        };
        // Nothing leads through a time that runs backwards.
        if !record.time.is_sorted() {
            return Err(Complaint::new(Kind::Shape, "the time of the record runs backwards")
                .at(record.header())
                .help("sort the rows by the time"));
        }
        let mut lines = Vec::new();
        for input in &rig.inputs {
            let channel = rig.input_column(record, input)?;
            let (time, values) = present(&record.time, &channel.values);
            let own = Sampling::of(&time, record.time_decimals).map_or(interval, |sampling| sampling.interval);
            let own = if time.len() == record.time.len() { interval } else { own };
            let mut line = broken_line(input, &time, &values, own);
            let late = if input.noise > 0.0 { late.measured } else { late.commanded };
            line.iter_mut()
                .for_each(|stretch| (stretch.start, stretch.end) = (stretch.start + late, stretch.end + late));
            lines.push(line);
        }
        lines.extend(rig.temperature.as_ref().map(|temperature| warmth(temperature, record, interval)).transpose()?);
        let (Some(&first), Some(&last)) = (record.time.first(), record.time.last()) else {
            return Err(Complaint::new(Kind::Empty, "the record has no rows").at(Place::file(&record.path)));
        };
        // Where a row speaks of the interval before it, the first row begins one interval earlier.
        let before = rig.inputs.iter().any(|input| input.hold == Hold::Before);
        let start = if before { first - interval } else { first };
        // 0.004 - 0.004 is 0, whatever the rounding of the intervals says.
        let start = if start.abs() < 1e-6 * interval { 0.0 } else { start };
        let drive = Self {
            pieces: merge(&lines, rig.inputs.len(), start, last),
            commanded: None,
            dead_times: Vec::new(),
            begun: start,
            readings: vec![FirstReading::default(); rig.nodes.len()],
            nudges: vec![0.0; rig.nodes.len()],
            onset: None,
            shown: Vec::new(),
        };
        Ok(drive.followed(rig, &Following::of(rig, &rig.nominal())))
    }

    /// From the cycle of a rig file. A jump of an input that runs straight from row to row takes the time between two rows, as
    /// its column says.
    pub fn from_cycle(rig: &Rig, cycle: &Cycle) -> Self {
        let mut start = 0.0;
        let mut pieces: Vec<Piece> = Vec::new();
        for phase in &cycle.phases {
            let warmer = rig.temperature.iter().map(|_| 0.0);
            let from: Vec<f64> = phase.inputs.iter().map(|profile| profile.from).chain(warmer.clone()).collect();
            let to = phase.inputs.iter().map(|profile| profile.to).chain(warmer).collect();
            let jump = pieces.last().is_none_or(|last| last.to != from);
            let end = start + phase.duration;
            pieces.push(Piece { start, end, from, to, jump });
            start = end;
        }
        let phases = Self {
            begun: 0.0,
            pieces,
            commanded: None,
            dead_times: Vec::new(),
            readings: vec![FirstReading::default(); rig.nodes.len()],
            nudges: vec![0.0; rig.nodes.len()],
            onset: None,
            shown: Vec::new(),
        };
        phases.with_rows(rig, cycle).followed(rig, &Following::of(rig, &rig.nominal()))
    }

    /// A drive of a cycle whose straight inputs run from row to row, as their columns have them.
    fn with_rows(self, rig: &Rig, cycle: &Cycle) -> Self {
        if rig.inputs.iter().all(|input| input.hold != Hold::Linear) {
            return self;
        }
        let times = cycle_times(rig, cycle);
        let inputs = rig.inputs.len() + usize::from(rig.temperature.is_some());
        let line = |input: usize| match rig.inputs.get(input).map(|input| input.hold) {
            Some(Hold::Linear) if times.len() > 1 => through(times.iter().map(|&time| (time, self.value(input, time)))),
            _ => self.pieces.iter().map(|piece| piece.stretch(input)).collect(),
        };
        let lines: Vec<Vec<Stretch>> = (0..inputs).map(line).collect();
        let end = self.pieces.last().map_or(0.0, |piece| piece.end);
        Self { pieces: merge(&lines, rig.inputs.len(), 0.0, end), ..self }
    }

    /// The same inputs in the run of another drive: from its beginning, from what its sensors show there, and with its onset.
    #[must_use]
    pub(crate) fn in_run_of(self, other: &Self) -> Self {
        let drive = Self { shown: other.shown.clone(), begun: other.begun, ..self };
        match &other.onset {
            Some(onset) => drive.with_onset(onset.clone()),
            None => drive,
        }
    }

    /// Whether anything starts where this sensor shows it.
    pub(crate) fn starts_by(&self, sensor: usize) -> bool {
        self.shown.iter().any(|shown| shown.sensor == sensor)
            || self.readings.iter().any(|reading| reading.sensor == Some(sensor))
    }

    /// A run that starts where this one does with the parameters `found`, SI, whatever sensors with `other` ones would show of it.
    #[cfg(feature = "cli")]
    #[must_use]
    pub(crate) fn started_alike(&self, rig: &Rig, found: &[f64], other: &[f64]) -> Self {
        let readings = self.readings.iter().map(|one| one.shown_with(rig, found, other)).collect();
        let shown = self.shown.iter().map(|one| one.shown_with(rig, found, other)).collect();
        Self { readings, shown, ..self.clone() }
    }

    /// The same commands, had an input been none until a moment, s, behind the beginning: what follows it then starts at rest.
    #[must_use]
    pub(crate) fn without_at_first(mut self, input: usize, moment: f64) -> Self {
        let pieces = self.commanded.as_mut().unwrap_or(&mut self.pieces);
        if let Some(start) = pieces.first().map(|first| first.start) {
            split(pieces, start + moment);
            (pieces[0].from[input], pieces[0].to[input]) = (0.0, 0.0);
        }
        self
    }

    /// Parameters (all of the rig's, SI) as they are until the moment at which some change, and that moment; they never
    /// change without one.
    pub fn before(&self, parameters: &[f64]) -> (Vec<f64>, f64) {
        let mut before = parameters.to_vec();
        let Some(onset) = &self.onset else { return (before, f64::NEG_INFINITY) };
        for &(parameter, was) in &onset.before {
            before[parameter] = match was {
                Before::Value(value) => value,
                Before::Like(other) => parameters[other],
            };
        }
        (before, onset.time)
    }

    /// The same drive, had parameters other values until `onset`; a time outside the drive is moved to its nearer end.
    #[must_use]
    pub fn with_onset(mut self, mut onset: Onset) -> Self {
        let (Some(first), Some(last)) = (self.pieces.first(), self.pieces.last()) else { return self };
        onset.time = onset.time.clamp(first.start, last.end);
        if let Some(commanded) = &mut self.commanded {
            split(commanded, onset.time);
        }
        self.onset = Some(onset);
        self.beginning_at_onset()
    }

    /// The same commands, had the parts behind the inputs of a rig followed them like this.
    #[must_use]
    pub(crate) fn followed(mut self, rig: &Rig, followings: &[Following]) -> Self {
        if let Some(commanded) = self.commanded.take() {
            self.pieces = commanded;
        }
        if let Some(acting) = acting(&self.pieces, rig, followings) {
            self.commanded = Some(std::mem::replace(&mut self.pieces, acting));
        }
        let dead_time = |input: &Input| input.dead_time.map_or(0.0, |own| rig.parameters[own].value);
        self.dead_times = rig.inputs.iter().map(dead_time).collect();
        self.beginning_at_onset()
    }

    /// The same, a piece beginning where parameters change: inputs that act later take their corners with them.
    fn beginning_at_onset(mut self) -> Self {
        if let Some(onset) = &self.onset {
            split(&mut self.pieces, onset.time);
        }
        self
    }

    /// The drive as it acts with the parameters of a rig, SI, where dead times that are fitted like any other value are others than it has.
    pub(crate) fn with_dead_times(&self, rig: &Rig, parameters: &[f64]) -> Cow<'_, Self> {
        let later = rig.fitted_dead_times().map(|(input, own)| (input, parameters[own] - self.dead_times[input]));
        let by: Vec<(usize, f64)> = later.filter(|&(_, later)| later != 0.0).collect();
        if by.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut drive = self.clone();
        let pieces = shifted(&drive.pieces, &by, rig.inputs.len());
        drive.commanded.get_or_insert(std::mem::replace(&mut drive.pieces, pieces));
        by.into_iter().for_each(|(input, later)| drive.dead_times[input] += later);
        Cow::Owned(drive.beginning_at_onset())
    }

    /// What a sensor shows of a node at the start, if one does.
    pub fn shown_at(&self, rig: &Rig, node: usize) -> Option<&Shown> {
        self.shown.iter().find(|shown| rig.sensors[shown.sensor].target == Target::Node(node))
    }

    /// Value of an input at a time, SI, as it was commanded; at a jump the value before it.
    pub fn value(&self, input: usize, t: f64) -> f64 {
        value(self.commanded.as_ref().unwrap_or(&self.pieces), input, t)
    }
}

/// How much warmer the fluid is than its temperature of reference, K; not at all in a record that does not say.
fn warmth(temperature: &Temperature, record: &Record, interval: f64) -> Result<Vec<Stretch>, Complaint> {
    let Temperature { input, reference } = temperature;
    if record.channel(&input.column).is_none_or(Channel::is_empty) {
        let ends =
            (record.time.first().map_or(0.0, |t| t - interval), record.time.last().map_or(0.0, |t| t + interval));
        return Ok(vec![Stretch { start: ends.0, end: ends.1, from: 0.0, to: 0.0, may_jump: false }]);
    }
    let channel = record.require(&input.column, input.unit.dimension, input.place.clone())?;
    let (time, values) = present(&record.time, &channel.values);
    let warmer: Vec<f64> = values.iter().map(|value| value - reference).collect();
    // Oil warms up slowly: steps are those of the logger.
    let (first, last) = (time[0] - interval, time[time.len() - 1] + interval);
    Ok(fit_line(&time, &warmer, first, last, input.noise))
}

/// The times at which a channel has a value, and the values.
fn present(time: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    time.iter().zip(values).filter(|(_, value)| !value.is_nan()).map(|(time, value)| (*time, *value)).unzip()
}
