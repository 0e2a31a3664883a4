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
//! - A phase therefore says no more about a constant or a slope than the tolerance allows, however many samples it has.
//! - *Throughout.* The pressure that an accumulator began with is remembered through all phases, and is one and the same in them:
//!   a direction over the whole record.

mod directions;
mod weights;

use std::ops::Range;

pub use self::weights::Weights;
use crate::model::{InputSignals, Late, is_measured_to_jump};
use crate::record::{Record, Sampling};
use crate::rig::{Hold, Rig};
use crate::units::Dimension;

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

#[cfg(test)]
mod tests;
