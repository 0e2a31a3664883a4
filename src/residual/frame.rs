//! Windows of a record: means and slopes of channels with their variances, and whether they stand or run straight.

use super::reading::Source;
use crate::complaint::Complaint;
use crate::model::Drive;
use crate::record::Record;
use crate::rig::{Quantity, Rig};

/// Readings of one window: `[order]` value (mean), rate, second derivative, SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Moment {
    pub value: [f64; 3],
    pub variance: [f64; 3],
    /// Whether the window holds a straight line (a parabola for a position) and nothing but noise around it.
    pub steady: bool,
}

/// One window of all sources asked for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frame {
    /// Times of the first and last sample, s.
    pub from: f64,
    pub to: f64,
    pub moments: Vec<Moment>,
    /// Whether an input jumped inside, or so shortly before that lags have not settled.
    pub disturbed: bool,
    /// Whether the frame follows the one before without a gap.
    pub follows: bool,
}

/// Channels in the order of `sources`.
///
/// # Errors
/// A column that is missing or of another dimension.
pub(super) fn channels<'a>(rig: &Rig, record: &'a Record, sources: &[Source]) -> Result<Vec<&'a [f64]>, Complaint> {
    let column = |source: &Source| {
        let (name, dimension, place) = match *source {
            Source::Sensor(index) => {
                let sensor = &rig.sensors[index];
                (&sensor.column, sensor.quantity.dimension(), &sensor.place)
            }
            Source::Input(index) => {
                let input = &rig.inputs[index];
                (&input.column, input.unit.dimension, &input.place)
            }
        };
        Ok(record.require(name, dimension, place.clone())?.values.as_slice())
    };
    sources.iter().map(column).collect()
}

/// Lags that a jump of an input takes to settle to e^-5, s: the slowest component's, then the slowest sensor's.
pub(super) fn settling(rig: &Rig) -> f64 {
    let slowest = rig.parameters.iter().filter(|parameter| parameter.id.ends_with(".lag"));
    let component = slowest.map(|parameter| parameter.value).fold(0.0, f64::max);
    let sensor = rig.sensors.iter().map(|sensor| sensor.lag).fold(0.0, f64::max);
    5.0 * (component + sensor)
}

/// Times at which an input jumps, s.
pub(super) fn jumps(drive: &Drive) -> Vec<f64> {
    drive.pieces.iter().filter(|piece| piece.jump).map(|piece| piece.start).collect()
}

/// One false refusal of a steady window in 10⁴ per channel: normal quantile for the Wilson-Hilferty cube.
const REFUSAL: f64 = 3.719;

/// Largest sum of squares of `freedom` standard normals at that quantile.
fn chi_square_limit(freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    freedom * (1.0 - spread + REFUSAL * spread.sqrt()).powi(3)
}

/// Least-squares parabola over a window: the mean, the slope at the middle and twice the quadratic coefficient.
pub(super) fn moment(rig: &Rig, source: Source, time: &[f64], values: &[f64]) -> Moment {
    let n = time.len() as f64;
    let (middle, mean) = (time.iter().sum::<f64>() / n, values.iter().sum::<f64>() / n);
    let power = |k: i32| time.iter().map(|t| (t - middle).powi(k)).sum::<f64>();
    let (t2, t3) = (power(2), power(3));
    // Second orthogonal polynomial of the sample times.
    let bend = |t: f64| (t - middle).powi(2) - t3 / t2 * (t - middle) - t2 / n;
    let b2 = time.iter().map(|&t| bend(t).powi(2)).sum::<f64>();
    let pairs = || time.iter().zip(values);
    let slope = pairs().map(|(t, y)| (t - middle) * (y - mean)).sum::<f64>() / t2;
    let curvature = pairs().map(|(&t, y)| bend(t) * (y - mean)).sum::<f64>() / b2;
    let variance = source.variance(rig);
    let parabola = matches!(source, Source::Sensor(sensor) if rig.sensors[sensor].quantity == Quantity::Position);
    let misfit = |&(&t, &y): &(&f64, &f64)| {
        let bent = if parabola { curvature * bend(t) } else { 0.0 };
        (y - mean - slope * (t - middle) - bent).powi(2)
    };
    let squares = pairs().map(|pair| misfit(&pair)).sum::<f64>();
    let freedom = n - if parabola { 3.0 } else { 2.0 };
    let steady = if variance > 0.0 {
        squares <= variance * chi_square_limit(freedom)
    } else {
        values.iter().all(|value| *value == values[0])
    };
    // A sensor with lag shows what was a lag ago.
    let lag = source.lag(rig);
    let rate_variance = variance / t2;
    Moment {
        value: [mean + lag * slope, slope, 2.0 * curvature],
        variance: [variance / n + lag * lag * rate_variance, rate_variance, 4.0 * variance / b2],
        steady,
    }
}

/// Non-overlapping windows of about `length` s, laid anew after every jump.
pub(super) fn blocks(
    rig: &Rig,
    record: &Record,
    drive: &Drive,
    sources: &[Source],
    length: f64,
) -> Result<Vec<Frame>, Complaint> {
    let data = channels(rig, record, sources)?;
    let interval = record.sampling().map_or(0.0, |sampling| sampling.interval);
    let rows = block_rows(length, interval);
    let (jumps, settling) = (jumps(drive), settling(rig));
    let mut frames: Vec<Frame> = Vec::new();
    let (mut row, mut follows) = (0, false);
    while row + rows <= record.time.len() {
        let time = &record.time[row..row + rows];
        let (from, to) = (time[0], time[rows - 1]);
        // A row speaks of the interval before it, so a jump within an interval of the start is inside.
        let disturbance = jumps
            .iter()
            .copied()
            .filter(|&jump| jump > from - settling && jump <= to)
            .fold(f64::NEG_INFINITY, f64::max);
        let gap = time.windows(2).any(|pair| pair[1] - pair[0] > 1.5 * interval);
        if disturbance.is_finite() {
            row = record.time.partition_point(|&t| t < disturbance + settling).max(row + 1);
            follows = false;
            continue;
        }
        let moments =
            sources.iter().zip(&data).map(|(&source, values)| moment(rig, source, time, &values[row..row + rows]));
        frames.push(Frame { from, to, moments: moments.collect(), disturbed: gap, follows });
        follows = true;
        row += rows;
    }
    Ok(frames)
}

/// Samples of a window of about `length` s: enough to fit a parabola and to see whether it fits.
pub(super) fn block_rows(length: f64, interval: f64) -> usize {
    const FEWEST: usize = 8;
    if interval > 0.0 { ((length / interval).round() as usize).max(FEWEST) } else { FEWEST }
}

/// One frame per sample: the sample itself, its derivatives from the window of about `length` s around it.
pub(super) fn samples(
    rig: &Rig,
    record: &Record,
    drive: &Drive,
    sources: &[Source],
    length: f64,
) -> Result<Vec<Frame>, Complaint> {
    let data = channels(rig, record, sources)?;
    let interval = record.sampling().map_or(0.0, |sampling| sampling.interval);
    let half = block_rows(length, interval) / 2;
    let (jumps, settling) = (jumps(drive), settling(rig));
    let count = record.time.len();
    if count < 2 * half + 1 {
        return Ok(Vec::new());
    }
    let frame = |row: usize| {
        let first = row.saturating_sub(half).min(count - 2 * half - 1);
        let window = first..first + 2 * half + 1;
        let time = &record.time[window.clone()];
        let (from, to) = (time[0], time[2 * half]);
        let moments = sources.iter().zip(&data).map(|(&source, values)| {
            let around = moment(rig, source, time, &values[window.clone()]);
            let (variance, lag) = (source.variance(rig), source.lag(rig));
            let mut own = around;
            own.value[0] = values[row] + lag * around.value[1];
            own.variance[0] = variance + lag * lag * around.variance[1];
            own
        });
        let disturbed =
            row < half || row + half >= count || jumps.iter().any(|&jump| jump > from - settling && jump <= to);
        Frame { from: record.time[row], to: record.time[row], moments: moments.collect(), disturbed, follows: row > 0 }
    };
    Ok((0..count).map(frame).collect())
}
