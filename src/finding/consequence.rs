//! What a fault does to the readings of the sensors: the same run with the fault and without it.

use std::ops::Range;

use serde::Serialize;

use crate::learn::phase::jumps;
use crate::model::InputSignals;
use crate::number::{difference_in_unit, in_unit, rounded, with_unit};
use crate::record::Record;
use crate::rig::{Quantity, Rig, Sensor};

/// Consequences of one fault that are reported.
const MOST: usize = 3;
/// Rows over which a reading has to stand at least: with fewer, any curve stands that is sampled slowly.
const ROWS: usize = 10;
/// Digits of a reported number.
const DIGITS: usize = 6;

/// Which property of a reading changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The mean over a steady phase, in the unit of the sensor.
    Mean,
    /// The time from a switching of the inputs to the arrival at the end position, s.
    TravelTime,
    /// The root mean square of the change over the record, in the unit of the sensor: where no phase is steady.
    Rms,
}

/// One change that a fault causes at one sensor, by simulation of the inputs of the record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Consequence {
    /// Name of the sensor.
    pub sensor: String,
    /// Which property of its readings changes.
    pub measure: Measure,
    /// With the fault minus without it, in `unit`.
    pub change: f64,
    /// The unit of the sensor; s for a time.
    pub unit: String,
    /// The value with the fault, in `unit`; `None` for [`Measure::Rms`].
    pub with_fault: Option<f64>,
    /// The value without the fault, in `unit`; `None` for [`Measure::Rms`].
    pub without_fault: Option<f64>,
    /// Start of the phase, s.
    pub from_s: f64,
    /// End of the phase, s.
    pub to_s: f64,
    /// The greatest distance of the two curves there, or the size of the change of a mean, over the noise of a sample.
    pub times_noise: f64,
    /// The change in words.
    pub text: String,
}

/// Two runs of the sensors of a rig, `[sensor][row]`, SI, and where its inputs switch.
pub struct Runs<'a> {
    pub rig: &'a Rig,
    pub record: &'a Record,
    pub drive: &'a InputSignals,
    /// The first row with the fault.
    pub from: usize,
    pub with_fault: &'a [Vec<f64>],
    pub without_fault: &'a [Vec<f64>],
}

impl Runs<'_> {
    /// The largest changes in units of the noise of their sensors, largest first; `of_sensor` where only readings change.
    pub fn consequences(&self, of_sensor: bool) -> Vec<Consequence> {
        let same_motion = self.same_motion();
        let mut found: Vec<Consequence> = Vec::new();
        for index in 0..self.rig.sensors.len() {
            found.extend(self.mean(index, &same_motion, of_sensor).or_else(|| self.rms(index)));
            found.extend(self.travel_time(index));
        }
        found.sort_by(|a, b| b.times_noise.total_cmp(&a.times_noise));
        // A change below the noise of one sample is not visible in a chart; the largest stays in any case.
        let visible = found.iter().filter(|one| one.times_noise >= 1.0).count();
        found.truncate(visible.clamp(1, MOST));
        found
    }

    fn curves(&self, index: usize) -> (&Sensor, [&[f64]; 2]) {
        (&self.rig.sensors[index], [&self.with_fault[index][self.from..], &self.without_fault[index][self.from..]])
    }

    /// How long a switching takes, s.
    fn switching(&self) -> f64 {
        self.rig.settings().learn.switching_time
    }

    fn time(&self) -> &[f64] {
        &self.record.time[self.from..]
    }

    /// Rows in which each position moves in both runs or rests in both: elsewhere the change is a delay, not a level.
    fn same_motion(&self) -> Vec<bool> {
        let mut same = vec![true; self.time().len()];
        for index in self.positions() {
            let (sensor, [with, without]) = self.curves(index);
            let rests = [with, without].map(|curve| steady(self.time(), curve, sensor.noise, self.switching()));
            for (row, same) in same.iter_mut().enumerate() {
                *same &= rests[0][row] == rests[1][row];
            }
        }
        same
    }

    fn positions(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.rig.sensors.len()).filter(|&index| self.rig.sensors[index].quantity == Quantity::Position)
    }

    /// The largest change of the mean of a sensor over a phase in which it stands without the fault; with it, it may drift there, as a
    /// pressure that leaks away does.
    fn mean(&self, index: usize, same_motion: &[bool], of_sensor: bool) -> Option<Consequence> {
        let time = self.time();
        let (sensor, [with, without]) = self.curves(index);
        let stands = steady(time, without, sensor.noise, self.switching());
        let stands: Vec<bool> = stands.iter().zip(same_motion).map(|(stands, same)| *stands && *same).collect();
        let mean = |curve: &[f64], rows: &Range<usize>| curve[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
        let change = |rows: &Range<usize>| mean(with, rows) - mean(without, rows);
        let long =
            |rows: &Range<usize>| rows.len() >= ROWS && time[rows.end - 1] - time[rows.start] >= self.switching();
        let phases = runs(&stands).into_iter().filter(long);
        let rows = phases.max_by(|a, b| change(a).abs().total_cmp(&change(b).abs()))?;
        let size = change(&rows);
        let unit = self.rig.sensor_unit(sensor);
        let shown = difference_in_unit(size, &unit);
        let number = with_unit(figure(shown), &unit.symbol);
        let name = &sensor.name;
        let text = match (sensor.quantity, size < 0.0) {
            (Quantity::Flow, less) if !of_sensor => {
                format!("{number} {} through {name}", if less { "less" } else { "more" })
            }
            (_, less) => format!("{name} {number} {}", if less { "lower" } else { "higher" }),
        };
        Some(Consequence {
            sensor: name.clone(),
            measure: Measure::Mean,
            change: rounded(shown, DIGITS),
            with_fault: Some(rounded(in_unit(mean(with, &rows), &unit), DIGITS)),
            without_fault: Some(rounded(in_unit(mean(without, &rows), &unit), DIGITS)),
            unit: unit.symbol,
            from_s: rounded(time[rows.start], DIGITS),
            to_s: rounded(time[rows.end - 1], DIGITS),
            times_noise: rounded(size.abs() / sensor.noise, DIGITS),
            text,
        })
    }

    /// The change of a sensor whose readings never stand.
    fn rms(&self, index: usize) -> Option<Consequence> {
        let time = self.time();
        let (sensor, [with, without]) = self.curves(index);
        let square = with.iter().zip(without).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let rms = (square / with.len().max(1) as f64).sqrt();
        let unit = self.rig.sensor_unit(sensor);
        let shown = difference_in_unit(rms, &unit);
        Some(Consequence {
            sensor: sensor.name.clone(),
            measure: Measure::Rms,
            change: rounded(shown, DIGITS),
            with_fault: None,
            without_fault: None,
            text: format!("{} changes by {} (rms)", sensor.name, with_unit(figure(shown), &unit.symbol)),
            unit: unit.symbol,
            from_s: rounded(*time.first()?, DIGITS),
            to_s: rounded(*time.last()?, DIGITS),
            times_noise: rounded(rms / sensor.noise, DIGITS),
        })
    }

    /// The largest change of the time to an end position that both runs reach.
    fn travel_time(&self, index: usize) -> Option<Consequence> {
        let time = self.time();
        let (sensor, [with, without]) = self.curves(index);
        if sensor.quantity != Quantity::Position {
            return None;
        }
        let jumps = jumps(self.record, self.drive).into_iter().filter_map(|row| row.checked_sub(self.from));
        let ends: Vec<usize> = std::iter::once(0).chain(jumps).chain([time.len()]).collect();
        let late = |phase: &[usize]| {
            let rows = phase[0]..phase[1];
            let [a, b] = [with, without]
                .map(|curve| arrival((time, &curve[rows.clone()]), rows.start, sensor.noise, self.switching()));
            let (a, b) = (a?, b?);
            let same_end = (with[rows.end - 1] - without[rows.end - 1]).abs() <= sensor.noise;
            // The samples of a record show a time to one interval.
            let seen = a.abs_diff(b) > 1;
            (same_end && seen).then_some((rows, a, b))
        };
        let size = |(_, a, b): &(Range<usize>, usize, usize)| (time[*a] - time[*b]).abs();
        let phases = ends.windows(2).filter(|phase| phase[0] < phase[1]).filter_map(late);
        let (rows, a, b) = phases.max_by(|one, other| size(one).total_cmp(&size(other)))?;
        let gap = rows.clone().map(|row| (with[row] - without[row]).abs()).fold(0.0, f64::max);
        let start = time[rows.start];
        let change = time[a] - time[b];
        let when = if change > 0.0 { "later" } else { "earlier" };
        // Which of the two ends: of one stroke it may be late, of the other early.
        let unit = self.rig.sensor_unit(sensor);
        let end = with_unit(rounded(in_unit(without[rows.end - 1], &unit), 3), &unit.symbol);
        Some(Consequence {
            sensor: sensor.name.clone(),
            measure: Measure::TravelTime,
            change: rounded(change, DIGITS),
            unit: "s".to_owned(),
            with_fault: Some(rounded(time[a] - start, DIGITS)),
            without_fault: Some(rounded(time[b] - start, DIGITS)),
            from_s: rounded(start, DIGITS),
            to_s: rounded(time[rows.end - 1], DIGITS),
            times_noise: rounded(gap / sensor.noise, DIGITS),
            text: format!("{} reaches {end} {} s {when}", sensor.name, figure(change)),
        })
    }
}

/// The size of a change with two digits: more would say that the model is exact.
fn figure(change: f64) -> f64 {
    rounded(change.abs(), 2)
}

/// Rows around which a curve without noise moves by no more than the noise of one sample within a switching.
fn steady(time: &[f64], curve: &[f64], noise: f64, switching: f64) -> Vec<bool> {
    let one = |row: usize| {
        let from = time.partition_point(|&t| t < time[row] - 0.5 * switching).min(row.saturating_sub(ROWS / 2));
        let to = time.partition_point(|&t| t <= time[row] + 0.5 * switching).max((row + ROWS / 2 + 1).min(time.len()));
        let (low, high) = curve[from..to]
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)));
        high - low <= noise
    };
    (0..time.len()).map(one).collect()
}

/// Ranges of consecutive rows that are marked.
fn runs(marked: &[bool]) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut found = Vec::new();
    for run in marked.chunk_by(|a, b| a == b) {
        if run[0] {
            found.push(start..start + run.len());
        }
        start += run.len();
    }
    found
}

/// The row from which on a curve differs from its last value by no more than the noise of one sample; `None` where it moves
/// by no more at all, or still moves at the end.
fn arrival((time, curve): (&[f64], &[f64]), first: usize, noise: f64, switching: f64) -> Option<usize> {
    let end = *curve.last()?;
    let row = curve.iter().rposition(|value| (value - end).abs() > noise)? + 1 + first;
    let last = first + curve.len() - 1;
    (time[last] - time[row.min(last)] >= switching).then_some(row)
}
