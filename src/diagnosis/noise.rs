//! How far a sample may be from the model: noise and rounding of the sensor, and the tolerance of the model.
//!
//! A model that is right but for the moment of an event misses by tens of standard deviations while valves or the load
//! switch, and trapped oil remembers it: an edge of a valve that closes a tenth of a millisecond later than the other
//! leaves a third of a bar more in both chambers until the valve opens again. Four things follow, none of them taken from
//! the misfit:
//!
//! - *Events.* Their moment is uncertain by `tau`: a jump that a logger shows between two rows may have come anywhere
//!   between them (rms distance from the earlier row: interval/sqrt(3)), and every time constant of the rig is uncertain by
//!   what its data sheet says. Moving a curve by `tau` changes it by `tau y'`. Of this the steady part, the median slope
//!   around, is a shift of the whole curve that the phases below account for; the rest is the sample's own tolerance.
//! - *Phases.* Between two events, model and sensor may differ by a constant and by a slope of the size of the sensor's
//!   tolerance, and by what each uncertain time constant (and valve edge's progression) would have done had it been another in
//!   this one switching, by what a measured load would have done had it acted later, and at the
//!   beginning by what another starting pressure would have done. These are random effects: directions of the misfit in which
//!   a phase has `1 + (size)²` times the variance of noise.
//! - *Throughout.* The pressure that an accumulator began with is remembered through all phases, and is one and the same in them:
//!   a direction over the whole record.
//! - A phase therefore says no more about a constant or a slope than the tolerance allows, however many samples it has.

mod directions;

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use self::directions::random_directions;
use crate::estimation::Shared;
use crate::model::{InputSignals, Late, is_measured_to_jump};
use crate::numeric::{dot, take_along};
use crate::record::{Record, Sampling};
use crate::rig::{Hold, Rig};
use crate::settings::DiagnosisSettings;
use crate::units::Dimension;

/// Columns that are weighed one after the other, phase by phase: enough that what a phase shares is fetched for many, few enough that
/// threads have their share.
const TOGETHER: usize = 8;

/// One standard deviation of the moment at which inputs acted, s: an edge that shows between two rows came anywhere between them. From
/// the row at which a held input shows it that is interval/sqrt(3), from the middle, where one that runs straight has it,
/// interval/sqrt(12); 0 of those that run straight and do not jump.
pub fn input_timing(rig: &Rig, record: &Record) -> Late {
    let slowest = |is_measured: bool| {
        let inputs = rig.inputs.iter().filter(|input| (input.noise > 0.0) == is_measured);
        let timing = inputs.filter_map(|input| {
            let channel = record.channel(&input.column)?;
            let rows = present(&channel.values);
            let values: Vec<f64> = rows.iter().map(|&row| channel.values[row]).collect();
            let part: f64 = match input.hold {
                Hold::Before | Hold::After => 3.0,
                Hold::Linear if is_measured_to_jump(input, &values) => 12.0,
                Hold::Linear => return None,
            };
            Some(own_interval(record, &rows) / part.sqrt())
        });
        timing.fold(0.0, f64::max)
    };
    Late { measured: slowest(true), commanded: slowest(false) }
}

/// The rows in which a channel has a value.
fn present(values: &[f64]) -> Vec<usize> {
    (0..values.len()).filter(|&row| !values[row].is_nan()).collect()
}

/// The usual interval between some rows of a record, s.
fn own_interval(record: &Record, rows: &[usize]) -> f64 {
    let sampling = if rows.len() == record.time.len() {
        record.sampling()
    } else {
        let times: Vec<f64> = rows.iter().map(|&row| record.time[row]).collect();
        Sampling::of(&times, record.time_decimals)
    };
    sampling.map_or(0.0, |sampling| sampling.interval)
}

/// One standard deviation of the moment of an event, s.
fn timing(rig: &Rig, record: &Record) -> f64 {
    let Late { measured, commanded } = input_timing(rig, record);
    let hold = measured.max(commanded);
    let lags = rig.parameters.iter().filter(|lag| lag.per_event && lag.unit.dimension == Dimension::TIME);
    lags.map(|parameter| parameter.sigma.powi(2)).sum::<f64>().mul_add(1.0, hold * hold).sqrt()
}

/// Whether what events may do is as straight as their directions are: what drives the rig is known to within its fastest lag.
pub fn are_events_straight(rig: &Rig, record: &Record) -> bool {
    let Late { measured, commanded } = input_timing(rig, record);
    let lags = rig.parameters.iter().filter(|lag| {
        lag.per_event && !lag.role.is_of_the_drive() && lag.unit.dimension == Dimension::TIME && lag.value > 0.0
    });
    let fastest = lags.map(|lag| lag.value).fold(f64::INFINITY, f64::min);
    measured.max(commanded) <= fastest
}

/// Variance of each sample, SI squared: `[sensor][row]`, infinite where the record has none. `curves` is what the sensors
/// read, by the model or as measured (`measured`: then the slope of their noise is not mistaken for an event).
pub fn variances(rig: &Rig, record: &Record, curves: &[&[f64]], measured: bool) -> Vec<Vec<f64>> {
    let tau = timing(rig, record);
    let one = |(sensor, whole): (&crate::rig::Sensor, &&[f64])| {
        let variance = sensor.variance();
        // A channel is judged by its own samples, however many rows others have between them.
        let rows = record.channel(&sensor.column).map_or_else(Vec::new, |channel| present(&channel.values));
        let curve: Vec<f64> = rows.iter().map(|&row| whole[row]).collect();
        let interval = own_interval(record, &rows);
        let stride = if interval > 0.0 { (tau / interval).round().max(1.0) as usize } else { 1 };
        let rows_shifted = if interval > 0.0 { tau / interval } else { 0.0 };
        let sudden = sudden_slopes(&curve, stride, rig.settings().diagnosis.steady_strides * stride);
        // A central difference over `2 stride` rows has this variance by noise alone.
        let floor = if measured { 0.5 * variance / (stride * stride) as f64 } else { 0.0 };
        let mut all = vec![f64::INFINITY; whole.len()];
        for (index, &row) in rows.iter().enumerate() {
            let near = index.saturating_sub(stride)..(index + stride + 1).min(curve.len());
            let worst = sudden[near].iter().fold(0.0, |worst: f64, slope| worst.max(slope * slope));
            all[row] = variance + rows_shifted * rows_shifted * (worst - floor).max(0.0);
        }
        all
    };
    rig.sensors.iter().zip(curves).map(one).collect()
}

/// Slope at each row, per row, less the median slope around it.
fn sudden_slopes(curve: &[f64], stride: usize, steady: usize) -> Vec<f64> {
    let rows = curve.len();
    let slope = |row: usize| {
        let (early, late) = (row.saturating_sub(stride), (row + stride).min(rows - 1));
        (curve[late] - curve[early]) / (late - early).max(1) as f64
    };
    let slopes: Vec<f64> = (0..rows).map(slope).collect();
    let mut sudden = slopes.clone();
    for first in 0..stride.min(rows) {
        // Every `stride`-th slope: those around a row are those around the one before, less one and one more.
        let begin = (first..rows.min(first + steady)).step_by(stride);
        let mut around: Vec<f64> = begin.map(|row| slopes[row]).collect();
        around.sort_unstable_by(f64::total_cmp);
        for row in (first..rows).step_by(stride) {
            if let Some(next) = slopes.get(row + steady) {
                let place = around.partition_point(|slope| slope.total_cmp(next).is_lt());
                around.insert(place, *next);
            }
            sudden[row] -= around[around.len() / 2];
            if let Some(last) = row.checked_sub(steady).and_then(|row| slopes.get(row)) {
                let place = around.partition_point(|slope| slope.total_cmp(last).is_lt());
                around.remove(place);
            }
        }
    }
    sudden
}

/// Rows between events: jumps of the inputs, and moments at which a curve bends by more than its sensor's noise.
pub fn phases(rig: &Rig, drive: &InputSignals, times: &[f64], variance: &[Vec<f64>]) -> Vec<Range<usize>> {
    // Where the record begins is no event.
    let begins = times.first().copied().unwrap_or(f64::NEG_INFINITY);
    let jumps = drive.pieces.iter().filter(|piece| piece.jump && piece.start > begins);
    let mut starts: Vec<usize> = jumps.map(|piece| times.partition_point(|&time| time <= piece.start)).collect();
    let bends = |row: usize| {
        let of = |(sensor, variance): (&crate::rig::Sensor, &Vec<f64>)| {
            variance[row].is_finite() && variance[row] > 2.0 * sensor.variance()
        };
        rig.sensors.iter().zip(variance).any(of)
    };
    let mut quiet = 0;
    for row in 0..times.len() {
        if !bends(row) {
            quiet += 1;
            continue;
        }
        if quiet >= rig.settings().diagnosis.quiet_rows {
            starts.push(row);
        }
        quiet = 0;
    }
    starts.push(0);
    starts.push(times.len());
    starts.sort_unstable();
    starts.dedup();
    starts.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

/// Weights of the misfits: what makes them independent and of variance 1 if the model is right within its tolerance.
#[derive(Debug, Clone)]
pub struct Weights {
    rows: usize,
    /// `1/sigma` of each sample, `[sensor][row]`; 0 of those that the record does not have.
    inverse: Vec<Vec<f64>>,
    phases: Vec<Phase>,
    /// Orthonormal directions over all weighted samples, and the share that is taken away of each behind what phases take.
    throughout: (Vec<Vec<f64>>, Vec<f64>),
    /// What the samples of each sensor may have in common.
    pub shared: Vec<Shared>,
    /// Whether what is asked of events can be judged.
    events_are_judged: bool,
}

#[derive(Debug, Clone)]
struct Phase {
    rows: Range<usize>,
    /// Per sensor: directions over the phase's samples of what constant and slope do, and the share taken away of each.
    levels: Vec<(Vec<Vec<f64>>, Vec<f64>)>,
    /// Orthonormal directions over the phase's samples of all sensors, one sensor after the other.
    directions: Vec<Vec<f64>>,
    /// Share of each direction that is taken away, `1 - 1/sqrt(1 + size²)`.
    taken: Vec<f64>,
}

impl Weights {
    /// From the variance of each sample (`[sensor][row]`) and the changes of all readings by one standard deviation of each
    /// time constant (`[constant][sensor][row]`), all SI.
    pub fn new(rig: &Rig, phases: &[Range<usize>], variance: &[Vec<f64>], changes: &[Vec<Vec<f64>>]) -> Self {
        let mut weights = Self {
            rows: variance.first().map_or(0, Vec::len),
            inverse: variance.iter().map(|row| row.iter().map(|variance| 1.0 / variance.sqrt()).collect()).collect(),
            phases: Vec::new(),
            throughout: Default::default(),
            shared: Vec::new(),
            events_are_judged: true,
        };
        for rows in phases {
            let levels = rig.sensors.iter().zip(&weights.inverse);
            let levels = levels.map(|(sensor, inverse)| level_directions(sensor.tolerance, &inverse[rows.clone()]));
            let levels = levels.collect();
            weights.phases.push(Phase { rows: rows.clone(), levels, directions: Vec::new(), taken: Vec::new() });
        }
        let weighted: Vec<Vec<f64>> = changes
            .iter()
            .map(|change| {
                let mut column: Vec<f64> = change.iter().flatten().copied().collect();
                weights.scale(&mut column);
                weights.level(&mut column);
                column
            })
            .collect();
        let (rows, sensors) = (weights.rows, weights.inverse.len());
        for phase in &mut weights.phases {
            let pick = |column: &Vec<f64>| -> Vec<f64> {
                (0..sensors).flat_map(|sensor| column[sensor * rows..][phase.rows.clone()].iter().copied()).collect()
            };
            let effects: Vec<Vec<f64>> = weighted.iter().map(pick).collect();
            (phase.directions, phase.taken) = random_directions(&effects);
        }
        weights.shared = weights.shared_by_sensor();
        weights
    }

    /// These, and a direction over the whole record for each thing that is the same throughout: what it changes, off by one standard deviation,
    /// `[what][sensor][row]`, SI.
    #[must_use]
    pub fn with_throughout(mut self, changes: &[Vec<Vec<f64>>]) -> Self {
        let weighted = |change: &Vec<Vec<f64>>| {
            let mut column = change.concat();
            self.apply(&mut column);
            column
        };
        self.throughout = random_directions(&changes.iter().map(weighted).collect::<Vec<_>>());
        self.shared = self.shared_by_sensor();
        self
    }

    /// Those of so many first rows, up to the end of the phase in which the last of them lies, and how many rows that is.
    pub(crate) fn of_first_phases(&self, rows: usize) -> (usize, Self) {
        let last = self.phases.iter().find(|phase| phase.rows.end >= rows);
        let rows = last.map_or(rows, |phase| phase.rows.end).min(self.rows);
        let mut first = Self {
            rows,
            inverse: self.inverse.iter().map(|inverse| inverse[..rows].to_vec()).collect(),
            phases: self.phases.iter().filter(|phase| phase.rows.end <= rows).cloned().collect(),
            throughout: Default::default(),
            shared: Vec::new(),
            events_are_judged: self.events_are_judged,
        };
        first.throughout = random_directions(&self.throughout_in(rows));
        first.shared = first.shared_by_sensor();
        (rows, first)
    }

    /// What is the same throughout, by one standard deviation, in so many first rows: of the weighted samples.
    fn throughout_in(&self, rows: usize) -> Vec<Vec<f64>> {
        let (directions, taken) = &self.throughout;
        let part = |(direction, taken): (&Vec<f64>, &f64)| {
            let size = ((1.0 - taken).powi(-2) - 1.0).sqrt();
            let of_sensors = direction.chunks_exact(self.rows.max(1));
            of_sensors.flat_map(|part| part[..rows].iter().map(|value| size * value)).collect()
        };
        directions.iter().zip(taken).map(part).collect()
    }

    /// From the variance of each sample alone, with phases between the events that it shows.
    pub fn without_changes(rig: &Rig, drive: &InputSignals, times: &[f64], variance: &[Vec<f64>]) -> Self {
        Self::new(rig, &phases(rig, drive, times, variance), variance, &[])
    }

    /// The same where [`are_events_straight`] tells whether what is asked of events can be judged.
    #[must_use]
    pub fn judging_events(self, events_are_judged: bool) -> Self {
        Self { events_are_judged, ..self }
    }

    /// Misfits in SI, or a derivative of them, one sensor after the other, into independent ones of variance 1. Entries
    /// beyond the samples are left.
    pub fn apply(&self, column: &mut [f64]) {
        self.scale(column);
        self.level(column);
        self.take_events(&mut [&mut *column]);
        self.take_throughout(column);
    }

    /// The same to each column of a matrix.
    pub fn apply_to_columns(&self, matrix: &mut DMatrix<f64>) {
        let rows = matrix.nrows().max(1);
        matrix.as_mut_slice().par_chunks_mut(TOGETHER * rows).for_each(|some| {
            let mut columns: Vec<&mut [f64]> = some.chunks_exact_mut(rows).collect();
            for column in &mut columns {
                self.scale(column);
                self.level(column);
            }
            self.take_events(&mut columns);
            columns.iter_mut().for_each(|column| self.take_throughout(column));
        });
    }

    /// Takes what is the same throughout.
    fn take_throughout(&self, column: &mut [f64]) {
        let (directions, taken) = &self.throughout;
        let samples = self.rows * self.sensors();
        for (direction, taken) in directions.iter().zip(taken) {
            take_along(&mut column[..samples], direction, *taken);
        }
    }

    /// Takes from each phase what events can explain. The directions of a phase stay in the cache for all columns.
    fn take_events(&self, columns: &mut [&mut [f64]]) {
        let mut together = Vec::new();
        for phase in self.phases.iter().filter(|phase| !phase.directions.is_empty()) {
            for column in &mut *columns {
                together.clear();
                for part in column.chunks_exact(self.rows).take(self.sensors()) {
                    together.extend_from_slice(&part[phase.rows.clone()]);
                }
                for (direction, taken) in phase.directions.iter().zip(&phase.taken) {
                    take_along(&mut together, direction, *taken);
                }
                for (part, own) in column.chunks_exact_mut(self.rows).zip(together.chunks_exact(phase.rows.len())) {
                    part[phase.rows.clone()].copy_from_slice(own);
                }
            }
        }
    }

    /// Of weighted misfits: takes once more what samples of a phase, or of the record, have in common, so that what is left is their own. With weights
    /// `W = S D^(-1/2)`, this is `S'`.
    pub fn leave_own(&self, column: &mut [f64]) {
        self.take_throughout(column);
        self.take_events(&mut [&mut *column]);
        self.level(column);
    }

    fn shared_by_sensor(&self) -> Vec<Shared> {
        let share = |taken: f64| 1.0 - (1.0 - taken).powi(2);
        let mut shared = vec![Shared::default(); self.sensors()];
        for phase in &self.phases {
            for (shared, (_, taken)) in shared.iter_mut().zip(&phase.levels) {
                taken.iter().for_each(|&taken| shared.add(share(taken), 1.0));
            }
        }
        let of_phases = self.phases.iter().map(|phase| (phase.rows.len(), &phase.directions, &phase.taken));
        let throughout = (self.rows, &self.throughout.0, &self.throughout.1);
        for (rows, directions, taken) in of_phases.chain([throughout]) {
            for (direction, &taken) in directions.iter().zip(taken) {
                for (shared, part) in shared.iter_mut().zip(direction.chunks_exact(rows.max(1))) {
                    shared.add(share(taken), dot(part, part));
                }
            }
        }
        shared
    }

    /// By how much the weighted misfits differ where the sensors read `with` and not `plain`, `[sensor][row]`, SI.
    pub(crate) fn change(&self, with: &[Vec<f64>], plain: &[Vec<f64>]) -> Vec<f64> {
        let pairs = with.iter().flatten().zip(plain.iter().flatten());
        let mut change: Vec<f64> = pairs.map(|(with, plain)| with - plain).collect();
        self.apply(&mut change);
        change
    }

    /// What weighted misfits ask of the events at each sensor: the mean square over the ways in which phases may differ by events, in
    /// what each may differ by, and how many independent ones that is. A way counts at a sensor by the share that it has there; those
    /// that no sensor tells from noise are left out. What a part has otherwise than stated, it has so in all phases, so no more are
    /// independent than one phase has. Nothing where events cannot be judged, or are few.
    pub(crate) fn asked_of_events(&self, settings: &DiagnosisSettings, weighted: &[f64]) -> Vec<(f64, f64)> {
        /// `1 - 1/sqrt(1 + size²)` of a way as large as noise.
        const TOLD: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
        let mut asked = vec![(0.0, 0.0); self.inverse.len()];
        if !self.events_are_judged {
            return asked;
        }
        let mut most = 0;
        for phase in &self.phases {
            let length = phase.rows.len().max(1);
            let told = phase.directions.iter().zip(&phase.taken).filter(|(_, taken)| **taken >= TOLD);
            most = most.max(told.clone().count());
            for (direction, _) in told {
                let of_sensor = |sensor: usize| &weighted[sensor * self.rows..][phase.rows.clone()];
                let parts = || direction.chunks_exact(length).enumerate();
                let along: f64 = parts().map(|(sensor, part)| dot(part, of_sensor(sensor))).sum();
                for (sensor, part) in parts() {
                    let share = dot(part, part);
                    asked[sensor].0 += share * along.abs().min(settings.event_outlier_misfit).powi(2);
                    asked[sensor].1 += share;
                }
            }
        }
        // Shares of whole ways add up to their number but for rounding.
        let are_few = |ways: f64| ways * (1.0 + 1e-9) < settings.event_directions;
        let mean = |(sum, ways): (f64, f64)| {
            if are_few(ways) { (0.0, 0.0) } else { (sum / ways, ways.min(most as f64)) }
        };
        asked.into_iter().map(mean).collect()
    }

    /// Logarithm of the determinant of what [`Self::apply`] does to the samples that are there, SI: what a likelihood under these
    /// weights has beside its cost. The more they allow, the less it is.
    pub(crate) fn log_determinant(&self) -> f64 {
        let samples = self.inverse.iter().flatten().filter(|weight| **weight > 0.0).map(|weight| weight.ln());
        let taken = self.phases.iter().flat_map(|phase| {
            let of_levels = phase.levels.iter().flat_map(|(_, taken)| taken);
            of_levels.chain(&phase.taken)
        });
        let taken = taken.chain(&self.throughout.1);
        samples.sum::<f64>() + taken.map(|taken| (-taken).ln_1p()).sum::<f64>()
    }

    /// Mean square of misfits of a sensor, SI, each by the share at which it counts: where a curve is steep, a small shift in time is a large
    /// error, and a sample counts for little. `None` where none counts.
    pub(crate) fn mean_square(&self, sensor: usize, misfit: impl Iterator<Item = f64>) -> Option<f64> {
        let (mut squares, mut all) = (0.0, 0.0);
        for (weight, misfit) in self.inverse.get(sensor)?.iter().zip(misfit).filter(|(weight, _)| **weight > 0.0) {
            squares += (weight * misfit).powi(2);
            all += weight * weight;
        }
        (all > 0.0).then(|| squares / all)
    }

    /// How many samples of a sensor the record has.
    pub fn samples(&self, sensor: usize) -> usize {
        self.inverse.get(sensor).map_or(0, |inverse| inverse.iter().filter(|weight| **weight > 0.0).count())
    }

    /// The rows of each phase.
    pub fn phases(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.phases.iter().map(|phase| phase.rows.clone())
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many sensors.
    pub fn sensors(&self) -> usize {
        self.inverse.len()
    }

    /// How many samples the record has.
    pub fn all_samples(&self) -> usize {
        (0..self.inverse.len()).map(|sensor| self.samples(sensor)).sum()
    }

    /// The same for samples on their own, without what those of a phase have in common: misfits stay in their rows.
    pub fn scale(&self, column: &mut [f64]) {
        for (slot, weight) in column.iter_mut().zip(self.inverse.iter().flatten()) {
            // Of a sample that is not there, no number says anything.
            *slot = if *weight > 0.0 { *slot * weight } else { 0.0 };
        }
    }

    /// Takes from each phase of each sensor what a shared constant and slope can explain.
    fn level(&self, column: &mut [f64]) {
        for phase in &self.phases {
            for (sensor, (directions, taken)) in phase.levels.iter().enumerate() {
                let block = &mut column[sensor * self.rows..][phase.rows.clone()];
                for (direction, taken) in directions.iter().zip(taken) {
                    take_along(block, direction, *taken);
                }
            }
        }
    }
}

/// Directions of a constant and of a slope, one standard deviation of each, over weighted samples.
fn level_directions(tolerance: f64, weights: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
    if tolerance == 0.0 {
        return (Vec::new(), Vec::new());
    }
    let last = (weights.len().max(2) - 1) as f64;
    let constant: Vec<f64> = weights.iter().map(|weight| weight * tolerance).collect();
    // Straight from -sqrt(3) to sqrt(3): a mean square of 1 over the phase, as the constant has.
    let slope = constant.iter().enumerate().map(|(row, size)| size * 3.0_f64.sqrt() * (2.0 * row as f64 / last - 1.0));
    let slope: Vec<f64> = slope.collect();
    random_directions(&[constant, slope])
}

#[cfg(test)]
mod tests;
