//! What a fault does to the readings of the sensors: the same run with the fault and without it.

use std::ops::Range;

use serde::Serialize;

use crate::learn::phase::jumps;
use crate::model::{InputSignals, input_columns};
use crate::number::{before_unit, difference_in_unit, in_unit, rounded, with_unit, worth};
use crate::record::Record;
use crate::residual::settling;
use crate::rig::{Input, Quantity, Rig, Sensor};

/// Consequences of one fault that are reported.
const MOST: usize = 3;
/// Rows over which a reading has to stand at least: with fewer, any curve stands that is sampled slowly.
const ROWS: usize = 10;
/// Share of its travel by which a piston is at an end: stops give way under loads.
const END: f64 = 0.01;
/// Share of the change that is sustained anywhere from which on that of a steady phase is named instead: by the larger half it says how
/// large the consequence is, and a level is easier to check than a moment.
const TELLING: f64 = 0.5;
/// Standard deviations of the noise of an input that no two of its values differ by.
const MOVED: f64 = 6.0;
/// Digits of a reported number.
const DIGITS: usize = 6;

/// Which property of a reading changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The mean over a steady phase, in the unit of the sensor.
    Mean,
    /// The mean over the moment with the largest change that is sustained for a switching, in the unit of the sensor: where steady phases
    /// show less than half of it.
    Sustained,
    /// The time from a switching of the inputs to the arrival at the end position, s.
    TravelTime,
    /// The highest reading between two switchings, in the unit of the sensor.
    #[cfg(feature = "cli")]
    Peak,
    /// The root mean square of the change over the record, in the unit of the sensor: where no phase is steady.
    Rms,
}

/// One change that a fault causes at one sensor, by simulation of the inputs of the record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Consequence {
    /// Name of the sensor.
    pub sensor: String,
    /// Which property of its readings changes.
    pub measure: Measure,
    /// With the fault minus without it, in `unit`. Of a time to an end that one of the two does not reach before the inputs switch: that to
    /// the switching, which it is at least.
    pub change: f64,
    /// The unit of the sensor; s for a time.
    pub unit: String,
    /// The value with the fault, in `unit`; `None` for [`Measure::Rms`], and where the end is not reached.
    pub with_fault: Option<f64>,
    /// The value without the fault, in `unit`; `None` for [`Measure::Rms`], and where the end is not reached.
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
    /// What the second run is called beside the first.
    pub other: &'static str,
    /// Noise that is left in the first run, over that of a sample of its sensor; of a simulation none.
    pub noisy: f64,
}

impl<'a> Runs<'a> {
    /// Two simulations, with a fault and without.
    pub fn simulated(
        (rig, record, drive): (&'a Rig, &'a Record, &'a InputSignals),
        from: usize,
        [with_fault, without_fault]: [&'a [Vec<f64>]; 2],
    ) -> Self {
        Self { rig, record, drive, from, with_fault, without_fault, other: "new", noisy: 0.0 }
    }
}

impl Runs<'_> {
    /// The largest changes in units of the noise of their sensors, largest first; `of_sensor` where only readings change.
    pub fn consequences(&self, of_sensor: bool) -> Vec<Consequence> {
        let same_motion = self.same_motion();
        let settled = self.settled(&same_motion);
        let mut found: Vec<Consequence> = Vec::new();
        for index in 0..self.rig.sensors.len() {
            let steady = self.steady(index, &same_motion);
            let sustained = self.sustained(index, &settled);
            let most = sustained.as_ref().map_or(0.0, |rows| self.size(index, rows));
            let telling = steady.filter(|rows| self.size(index, rows) >= TELLING * most);
            let rows = telling.map(|rows| (Measure::Mean, rows)).or(sustained.map(|rows| (Measure::Sustained, rows)));
            found.extend(rows.map(|rows| self.level(index, rows, of_sensor)).or_else(|| self.rms(index)));
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

    /// Rows in which each position moves in both runs or rests in both: elsewhere the change is a delay, not a level. Without those in
    /// which a machine at rest keeps what it began with.
    fn same_motion(&self) -> Vec<bool> {
        let mut same = vec![true; self.time().len()];
        same[..self.kept()].fill(false);
        for index in self.positions() {
            let (sensor, [with, without]) = self.curves(index);
            let limits = [sensor.noise * (1.0 + self.noisy), sensor.noise];
            let curves = [with, without].into_iter().zip(limits);
            let rests: Vec<_> =
                curves.map(|(curve, limit)| steady(self.time(), curve, limit, self.switching())).collect();
            for (row, same) in same.iter_mut().enumerate() {
                *same &= rests[0][row] == rests[1][row];
            }
        }
        same
    }

    fn positions(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.rig.sensors.len()).filter(|&index| self.rig.sensors[index].quantity == Quantity::Position)
    }

    /// The phase in which a sensor stands without the fault with the largest change of its mean; with it, it may drift there, as a pressure
    /// that leaks away does.
    fn steady(&self, index: usize, same_motion: &[bool]) -> Option<Range<usize>> {
        let time = self.time();
        let (sensor, [_, without]) = self.curves(index);
        let stands = steady(time, without, sensor.noise, self.switching());
        let stands: Vec<bool> = stands.iter().zip(same_motion).map(|(stands, same)| *stands && *same).collect();
        let long =
            |rows: &Range<usize>| rows.len() >= ROWS && time[rows.end - 1] - time[rows.start] >= self.switching();
        let phases = runs(&stands).into_iter().filter(long);
        phases.max_by(|a, b| self.size(index, a).total_cmp(&self.size(index, b)))
    }

    /// Those of the same motion that lie more than a switching behind the last one of the inputs, and behind the first row so far that the
    /// slowest part has forgotten where it began: both runs begin where the faulty machine stood.
    fn settled(&self, same_motion: &[bool]) -> Vec<bool> {
        let time = self.time();
        let jumps = jumps(self.record, self.drive).into_iter().filter_map(|row| row.checked_sub(self.from));
        let switched: Vec<f64> = jumps.filter_map(|row| time.get(row).copied()).collect();
        let begun = time.first().map_or(0.0, |first| first + settling(self.rig).max(self.switching()));
        let one = |(&at, &same): (&f64, &bool)| {
            let last = switched.partition_point(|&moment| moment <= at).checked_sub(1).map(|last| switched[last]);
            same && at > begun && last.is_none_or(|last| at - last > self.switching())
        };
        time.iter().zip(same_motion).map(one).collect()
    }

    /// The first rows in which a machine at rest keeps what it began with, as a line does that is locked in: until an input leaves where it
    /// began. None where something moves before that, where no position tells, and where no input ever does.
    fn kept(&self) -> usize {
        let columns = input_columns(self.rig, self.drive, self.time());
        let inputs = columns.iter().zip(&self.rig.inputs);
        let left = |(values, input): (&Vec<f64>, &Input)| {
            let moved = MOVED * input.noise;
            values.iter().position(|value| (value - values[0]).abs() > moved)
        };
        let Some(row) = inputs.filter_map(left).min() else { return 0 };
        let rests = |index: usize| {
            let (sensor, curves) = self.curves(index);
            let steady = |curve: &[f64]| steady(&self.time()[..row], &curve[..row], sensor.noise, self.switching());
            curves.into_iter().all(|curve| steady(curve).into_iter().all(|steady| steady))
        };
        let mut positions = self.positions().peekable();
        if positions.peek().is_some() && positions.all(rests) { row } else { 0 }
    }

    /// The rows, as long as a switching, over which the least change is largest: one that is sustained, not a delay of what is fast; all of
    /// them settled. A position that is otherwise while it moves is late, which its travel time says.
    fn sustained(&self, index: usize, settled: &[bool]) -> Option<Range<usize>> {
        let time = self.time();
        let (sensor, [with, without]) = self.curves(index);
        if sensor.quantity == Quantity::Position {
            return None;
        }
        let change = |row: usize| if settled[row] { with[row] - without[row] } else { 0.0 };
        let changes: Vec<f64> = (0..time.len()).map(change).collect();
        let window = |start: usize| {
            let end = time.partition_point(|&at| at <= time[start] + self.switching()).max(start + ROWS);
            (end <= time.len()).then_some(start..end)
        };
        // One window in half of ROWS: the least of neighbouring ones hardly differs.
        let least = |rows: &Range<usize>| {
            let sign = changes[rows.start].signum();
            changes[rows.clone()].iter().map(|change| sign * change).fold(f64::INFINITY, f64::min)
        };
        let windows = (0..time.len()).step_by(ROWS / 2).filter_map(window).map(|rows| (least(&rows), rows));
        let (size, rows) = windows.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (size > 0.0).then_some(rows)
    }

    /// The means of a sensor over some rows with the fault and without it.
    fn means(&self, index: usize, rows: &Range<usize>) -> [f64; 2] {
        self.curves(index).1.map(|curve| curve[rows.clone()].iter().sum::<f64>() / rows.len() as f64)
    }

    /// By how much they differ.
    fn size(&self, index: usize, rows: &Range<usize>) -> f64 {
        let [with, without] = self.means(index, rows);
        (with - without).abs()
    }

    /// The change of the mean of a sensor over some rows.
    fn level(&self, index: usize, (measure, rows): (Measure, Range<usize>), of_sensor: bool) -> Consequence {
        let (time, sensor) = (self.time(), self.curves(index).0);
        let [with, without] = self.means(index, &rows);
        let size = with - without;
        let unit = self.rig.sensor_unit(sensor);
        let shown = difference_in_unit(size, &unit);
        let number = with_unit(figure(shown), &unit.symbol);
        let name = &sensor.name;
        let (from_s, to_s) = (rounded(time[rows.start], DIGITS), rounded(time[rows.end - 1], DIGITS));
        let [with_fault, without_fault] = [with, without].map(|value| in_unit(value, &unit));
        let text = match (measure, sensor.quantity) {
            // What reverses is at a moment neither higher nor more.
            (Measure::Sustained, _) => {
                let [with, without] = [with_fault, without_fault].map(|value| worth(value, shown.abs()));
                let at = rounded(f64::midpoint(from_s, to_s), 3);
                format!("{name} {with} instead of {} at {at} s", before_unit(without, &unit.symbol))
            }
            // Of a flow that runs backwards less is nearer to nothing.
            (_, Quantity::Flow) if !of_sensor => {
                let less = if with * without > 0.0 { with.abs() < without.abs() } else { size < 0.0 };
                format!("{number} {} through {name}", if less { "less" } else { "more" })
            }
            _ => format!("{name} {number} {}", if size < 0.0 { "lower" } else { "higher" }),
        };
        Consequence {
            sensor: name.clone(),
            measure,
            change: rounded(shown, DIGITS),
            with_fault: Some(rounded(with_fault, DIGITS)),
            without_fault: Some(rounded(without_fault, DIGITS)),
            unit: unit.symbol,
            from_s,
            to_s,
            times_noise: rounded(size.abs() / sensor.noise, DIGITS),
            text,
        }
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

    /// The largest change of the time to an end position: of one that both runs reach, or only one of them before the inputs switch.
    fn travel_time(&self, index: usize) -> Option<Consequence> {
        let time = self.time();
        let (sensor, [with, without]) = self.curves(index);
        if sensor.quantity != Quantity::Position {
            return None;
        }
        let band = sensor.noise.max(END * travel(with).max(travel(without)));
        let jumps = jumps(self.record, self.drive).into_iter().filter_map(|row| row.checked_sub(self.from));
        let ends: Vec<usize> = std::iter::once(0).chain(jumps).chain([time.len()]).collect();
        let strokes = ends.windows(2).filter(|phase| phase[0] < phase[1]).filter_map(|phase| {
            let rows = phase[0]..phase[1];
            let limits = (band, sensor.noise, self.switching());
            let noisy = (band + self.noisy * sensor.noise, (1.0 + self.noisy) * sensor.noise, self.switching());
            let arrives = [arrival((time, with), &rows, noisy), arrival((time, without), &rows, limits)];
            // What has come to its end within a switching of the start was on its way from the stroke before.
            if arrives.iter().flatten().any(|&row| time[row] - time[rows.start] <= self.switching()) {
                return None;
            }
            let last = [with, without].map(|curve| curve[rows.end - 1]);
            // One that creeps on has been there all the same.
            let passes = |curve: &[f64], end: f64| rows.clone().find(|&row| (curve[row] - end).abs() <= band);
            let (end, arrives) = match arrives {
                [Some(_), Some(_)] if (last[0] - last[1]).abs() <= band => (last[1], arrives),
                [Some(a), None] => (last[0], [Some(a), passes(without, last[0])]),
                [None, Some(b)] => (last[1], [passes(with, last[1]), Some(b)]),
                _ => return None,
            };
            let late = time[arrives[0].unwrap_or(rows.end - 1)] - time[arrives[1].unwrap_or(rows.end - 1)];
            // The samples of a record show a time to one interval.
            let seen = match arrives {
                [Some(a), Some(b)] => a.abs_diff(b) > 1,
                _ => late != 0.0,
            };
            seen.then_some(Stroke { rows, end, arrives, late })
        });
        let Stroke { rows, end, arrives, late } = strokes.max_by(|a, b| a.late.abs().total_cmp(&b.late.abs()))?;
        let gap = rows.clone().map(|row| (with[row] - without[row]).abs()).fold(0.0, f64::max);
        let start = time[rows.start];
        let [with_fault, without_fault] = arrives.map(|row| row.map(|row| rounded(time[row] - start, DIGITS)));
        // Which of the two ends: of one stroke it may be late, of the other early.
        let unit = self.rig.sensor_unit(sensor);
        let shown = if end.abs() <= band { 0.0 } else { in_unit(end, &unit) };
        let (name, end) = (&sensor.name, with_unit(rounded(shown, 3), &unit.symbol));
        let text = match (with_fault, without_fault) {
            (Some(after), None) => {
                format!("{name} reaches {end} after {} s ({}: not at all)", figure(after), self.other)
            }
            (None, Some(after)) => {
                let no = if self.noisy > 0.0 { "does not reach" } else { "no longer reaches" };
                format!("{name} {no} {end} ({}: after {} s)", self.other, figure(after))
            }
            _ => format!("{name} reaches {end} {} s {}", figure(late), if late > 0.0 { "later" } else { "earlier" }),
        };
        Some(Consequence {
            sensor: name.clone(),
            measure: Measure::TravelTime,
            change: rounded(late, DIGITS),
            unit: "s".to_owned(),
            with_fault,
            without_fault,
            from_s: rounded(start, DIGITS),
            to_s: rounded(time[rows.end - 1], DIGITS),
            times_noise: rounded(gap / sensor.noise, DIGITS),
            text,
        })
    }
}

/// A stroke that at least one of two runs ends before the inputs switch: the rows in which it may, where, when with and without the
/// fault, and by how much later with it, s; at least so much where one does not arrive.
struct Stroke {
    rows: Range<usize>,
    end: f64,
    arrives: [Option<usize>; 2],
    late: f64,
}

/// From the least to the greatest position.
fn travel(curve: &[f64]) -> f64 {
    let (low, high) =
        curve.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
    (high - low).max(0.0)
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

/// The row from which on a curve is at its end: within the first limit, as a stop gives way under a load; `None` where it was there from
/// the start, or where it still moves by more than the second one, the noise, within the third, a switching.
fn arrival(
    (time, curve): (&[f64], &[f64]),
    rows: &Range<usize>,
    (band, noise, switching): (f64, f64, f64),
) -> Option<usize> {
    let last = rows.end - 1;
    let end = curve[last];
    let row = curve[rows.clone()].iter().rposition(|value| (value - end).abs() > band)? + 1 + rows.start;
    let before = time.partition_point(|&t| t < time[last] - switching);
    let rests = row <= before && (curve[before] - end).abs() <= noise;
    rests.then_some(row)
}
