//! Windows of a record: means and slopes of channels with their variances, and whether they stand or run straight.

use super::reading::Source;
use crate::complaint::Complaint;
use crate::model::{InputSignals, Late};
use crate::physics::card::Role;
use crate::record::Record;
use crate::rig::{Input, Quantity, Rig};

/// Readings of one window: `[order]` value (mean), rate, second derivative, SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Moment {
    pub value: [f64; 3],
    pub variance: [f64; 3],
    /// Whether the window holds a straight line (a parabola for a position) and nothing but noise around it.
    pub steady: bool,
}

impl Moment {
    /// Whether the channel has too few samples here.
    fn lacks(&self) -> bool {
        self.variance[0] == f64::INFINITY
    }
}

/// One window of all sources asked for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frame {
    /// Times of the first and last sample, s.
    pub from: f64,
    pub to: f64,
    pub moments: Vec<Moment>,
    /// Whether an input jumped inside, or so shortly before that lags have not settled, or rows are missing.
    pub disturbed: bool,
    /// Whether the frame follows the one before without a gap.
    pub follows: bool,
}

impl Frame {
    /// The frame as those see it who ask for these of its sources only.
    pub fn of(&self, sources: &[usize]) -> Self {
        let moments: Vec<Moment> = sources.iter().map(|&source| self.moments[source]).collect();
        let disturbed = self.disturbed || moments.iter().any(Moment::lacks);
        Self { moments, disturbed, ..*self }
    }
}

/// Channels in the order of `sources`; NaN where there is no sample.
///
/// # Errors
/// A column that is missing or of another dimension.
pub(super) fn channels<'a>(rig: &Rig, record: &'a Record, sources: &[Source]) -> Result<Vec<&'a [f64]>, Complaint> {
    let column = |source: &Source| {
        let channel = match *source {
            Source::Sensor(index) => rig.sensor_column(record, &rig.sensors[index])?,
            Source::Input(index) => {
                let Input { column, unit, place, .. } = &rig.inputs[index];
                record.of_dimension(column, unit.dimension, place.clone())?
            }
        };
        Ok(channel.values.as_slice())
    };
    sources.iter().map(column).collect()
}

/// Lags that a jump of an input takes to settle to e^-5, s: the slowest component's, then the slowest sensor's.
pub(crate) fn settling(rig: &Rig) -> f64 {
    let slowest = rig.parameters.iter().filter(|parameter| parameter.role == Role::Lag);
    let component = slowest.map(|parameter| parameter.value).fold(0.0, f64::max);
    let sensor = rig.sensors.iter().map(|sensor| sensor.lag).fold(0.0, f64::max);
    5.0 * (component + sensor)
}

/// Times at which an input jumps, s, rising.
pub(super) fn jumps(drive: &InputSignals) -> Vec<f64> {
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
    if values.iter().any(|value| value.is_nan()) {
        let there = || time.iter().zip(values).filter(|(_, value)| !value.is_nan());
        // Too few samples show neither a slope nor whether it is straight.
        if there().count() < FEWEST {
            return Moment { variance: [f64::INFINITY; 3], ..Moment::default() };
        }
        let (time, values): (Vec<f64>, Vec<f64>) = there().unzip();
        return moment(rig, source, &time, &values);
    }
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

/// Rows of a record, ready to be cut into windows.
pub(super) struct Prepared<'a> {
    time: &'a [f64],
    data: Vec<&'a [f64]>,
    /// Usual interval between rows and nominal length of a window, s.
    interval: f64,
    length: f64,
    jumps: Vec<f64>,
    settling: f64,
}

/// Share of a window that may pass without a row. What happens in between shows in the rows around it, or in the next window.
const GAP: f64 = 0.3;

impl<'a> Prepared<'a> {
    pub fn new(
        rig: &Rig,
        record: &'a Record,
        drive: &InputSignals,
        sources: &[Source],
        length: f64,
    ) -> Result<Self, Complaint> {
        let interval = interval(record);
        let data = channels(rig, record, sources)?;
        Ok(Self::over(rig, record, data, drive, (length, interval)))
    }

    /// Rows that may be part of a record whose usual interval, s, is known.
    pub fn over(
        rig: &Rig,
        record: &'a Record,
        data: Vec<&'a [f64]>,
        drive: &InputSignals,
        (length, interval): (f64, f64),
    ) -> Self {
        Self {
            time: &record.time,
            data,
            interval,
            length: block_rows(length, interval) as f64 * interval,
            jumps: jumps(drive),
            settling: settling(rig),
        }
    }

    /// Rows of the window that begins with this one: those whose time stamps lie within its length, but never fewer than a
    /// parabola needs. `None` at the end of the record.
    fn window(&self, first: usize) -> Option<std::ops::Range<usize>> {
        let end = self.time.get(first)? + self.length - 0.5 * self.interval;
        let by_time = self.time.partition_point(|&t| t < end);
        let complete = by_time < self.time.len() || self.time.last()? + self.interval >= end;
        let rows = first..by_time.max(first + FEWEST);
        (complete && rows.end <= self.time.len()).then_some(rows)
    }

    /// The latest jump within these rows, or so shortly before that lags have not settled, s.
    ///
    /// A row speaks of the interval before it, so a jump within an interval of the start is inside.
    fn disturbance(&self, rows: &std::ops::Range<usize>) -> Option<f64> {
        let (from, to) = (self.time[rows.start], self.time[rows.end - 1]);
        let last = self.jumps.partition_point(|&jump| jump <= to).checked_sub(1)?;
        Some(self.jumps[last]).filter(|&jump| jump > from - self.settling)
    }

    fn gap(&self, rows: std::ops::Range<usize>) -> bool {
        self.time[rows].windows(2).any(|pair| pair[1] - pair[0] > (GAP * self.length).max(1.5 * self.interval))
    }

    /// Whether some channel has too few samples in these rows.
    #[cfg(feature = "internals")]
    fn lacks(&self, rows: &std::ops::Range<usize>) -> bool {
        let there = |values: &&[f64]| values[rows.clone()].iter().filter(|value| !value.is_nan()).count();
        self.data.iter().any(|values| there(values) < FEWEST.min(rows.len()))
    }

    fn moments(&self, rig: &Rig, sources: &[Source], rows: &std::ops::Range<usize>) -> Vec<Moment> {
        let pairs = sources.iter().zip(&self.data);
        pairs.map(|(&source, values)| moment(rig, source, &self.time[rows.clone()], &values[rows.clone()])).collect()
    }
}

/// How far the windows of a record are laid.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cursor {
    /// The row that the next window begins with.
    pub row: usize,
    /// Whether a window ends before that row.
    follows: bool,
}

impl Prepared<'_> {
    /// Lays windows on from the cursor, as long as they end by `until`, s.
    pub fn lay(&self, rig: &Rig, sources: &[Source], cursor: &mut Cursor, until: f64) -> Vec<Frame> {
        let mut frames: Vec<Frame> = Vec::new();
        while let Some(rows) = self.window(cursor.row) {
            let to = self.time[rows.end - 1];
            if to > until {
                break;
            }
            if let Some(jump) = self.disturbance(&rows) {
                let settled = self.time.partition_point(|&t| t < jump + self.settling);
                *cursor = Cursor { row: settled.max(cursor.row + 1), follows: false };
                continue;
            }
            frames.push(Frame {
                from: self.time[rows.start],
                to,
                moments: self.moments(rig, sources, &rows),
                disturbed: self.gap(rows.clone()),
                follows: cursor.follows && !self.gap(cursor.row - 1..cursor.row + 1),
            });
            *cursor = Cursor { row: rows.end, follows: true };
        }
        frames
    }
}

/// Non-overlapping windows of about `length` s, laid anew after every jump. They follow the time stamps: a window has as many
/// rows as the record has in its time.
pub(super) fn blocks(
    rig: &Rig,
    record: &Record,
    drive: &InputSignals,
    sources: &[Source],
    length: f64,
) -> Result<Vec<Frame>, Complaint> {
    let all: Vec<usize> = (0..sources.len()).collect();
    let prepared = Prepared::new(rig, record, drive, sources, length)?;
    let frames = prepared.lay(rig, sources, &mut Cursor::default(), f64::INFINITY);
    Ok(frames.iter().map(|frame| frame.of(&all)).collect())
}

/// The usual interval between the rows of a record, s.
pub(super) fn interval(record: &Record) -> f64 {
    record.sampling().map_or(0.0, |sampling| sampling.interval)
}

/// Fewest samples that fit a parabola and show whether it fits.
const FEWEST: usize = 8;

/// Samples of a regular window of about `length` s.
pub(super) fn block_rows(length: f64, interval: f64) -> usize {
    if interval > 0.0 { ((length / interval).round() as usize).max(FEWEST) } else { FEWEST }
}

/// One frame per sample: the sample itself, its derivatives from the rows of about `length` s around it.
#[cfg(feature = "internals")]
pub(super) fn samples(
    rig: &Rig,
    record: &Record,
    drive: &InputSignals,
    sources: &[Source],
    length: f64,
) -> Result<Vec<Frame>, Complaint> {
    let prepared = Prepared::new(rig, record, drive, sources, length)?;
    let half = block_rows(length, prepared.interval) / 2;
    let count = record.time.len();
    if count < 2 * half + 1 {
        return Ok(Vec::new());
    }
    let frame = |row: usize| {
        let first = row.saturating_sub(half).min(count - 2 * half - 1);
        let rows = first..first + 2 * half + 1;
        let mut moments = prepared.moments(rig, sources, &rows);
        for ((own, &source), values) in moments.iter_mut().zip(sources).zip(&prepared.data) {
            let lag = source.lag(rig);
            own.value[0] = values[row] + lag * own.value[1];
            own.variance[0] = source.variance(rig) + lag * lag * own.variance[1];
        }
        let disturbed = row < half
            || row + half >= count
            || prepared.disturbance(&rows).is_some()
            || prepared.lacks(&rows)
            || prepared.data.iter().any(|values| values[row].is_nan())
            || prepared.gap(rows);
        Frame { from: record.time[row], to: record.time[row], moments, disturbed, follows: row > 0 }
    };
    Ok((0..count).map(frame).collect())
}

/// What a channel shows over a stretch in which it runs straight, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shows {
    pub value: f64,
    pub variance: f64,
    pub rate: f64,
    pub rate_variance: f64,
}

/// A stretch in which every channel asked for runs straight.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Times of its middle and of its last row, s.
    pub middle: f64,
    pub to: f64,
    /// The row behind it.
    pub end: usize,
    /// Of each sensor.
    pub shows: Vec<Shows>,
}

/// The windows of about `length` s in which all of these sensors stand or run straight.
///
/// # Errors
/// A column that the record lacks or has in another dimension.
pub fn straight(rig: &Rig, record: &Record, sensors: &[usize], length: f64) -> Result<Vec<Stretch>, Complaint> {
    let drive = InputSignals::inputs(rig, record, Late::default())?;
    let sources: Vec<Source> = sensors.iter().map(|&sensor| Source::Sensor(sensor)).collect();
    let mut frames = blocks(rig, record, &drive, &sources, length)?;
    frames.retain(|frame| !frame.disturbed && frame.moments.iter().all(|moment| moment.steady));
    let shows = |moment: &Moment| Shows {
        value: moment.value[0],
        variance: moment.variance[0],
        rate: moment.value[1],
        rate_variance: moment.variance[1],
    };
    let stretch = |frame: Frame| Stretch {
        middle: f64::midpoint(frame.from, frame.to),
        to: frame.to,
        end: record.time.partition_point(|&time| time <= frame.to),
        shows: frame.moments.iter().map(shows).collect(),
    };
    Ok(frames.into_iter().map(stretch).collect())
}
