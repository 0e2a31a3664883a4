//! What an engineer reads off a chart of a record beside its model: when it arrives, how high it peaks, where it settles.

use std::ops::Range;

use serde::Serialize;

use super::consequence::{Consequence, Measure, Runs};
use crate::complaint::Complaint;
use crate::diagnosis::weighed;
use crate::learn::comparison::Comparison;
use crate::learn::phase::jumps;
use crate::model::InputSignals;
use crate::number::{before_unit, difference_in_unit, in_unit, rounded, worth};
use crate::record::Record;
use crate::rig::{Quantity, Rig};

/// Rows over which noise is averaged out before curves are read, as an eye does.
const SMOOTHED: usize = 9;
/// Deviations of a sample within which almost all of so many averaged rows lie: they scatter by a third of one, over three to either side.
const SCATTER: f64 = 2.0;
/// Deviations of a sample by which peaks differ that are said to.
const TELLING: f64 = 5.0;
/// Events that are reported.
const MOST: usize = 3;
/// Digits of a reported number.
const DIGITS: usize = 6;

/// A comparison with its events, as `compare --format json` writes it.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct WithEvents<'a> {
    /// The comparison.
    #[serde(flatten)]
    pub comparison: &'a Comparison,
    /// Where the record differs from your model in what is read off a chart, largest first; `with_fault` is measured, `without_fault` the
    /// model.
    pub events: &'a [Consequence],
}

/// Where a record differs from what the model reads, `[sensor][row]`, SI: the time to an end position, a level, a peak; largest first, and
/// none that noise hides.
///
/// # Errors
/// Columns that the record lacks.
pub fn events(rig: &Rig, record: &Record, model: &[Vec<f64>]) -> Result<Vec<Consequence>, Complaint> {
    let drive = InputSignals::from_record(rig, record)?;
    let measured = weighed::measured(rig, record)?;
    let raw: Vec<Vec<f64>> = measured.into_iter().zip(model).map(filled).collect();
    // Both alike: a peak shorter than what is averaged over is as much lower in both.
    let [measured, smooth] =
        [&raw[..], model].map(|curves| curves.iter().map(|curve| smoothed(curve)).collect::<Vec<_>>());
    let runs = Runs {
        rig,
        record,
        drive: &drive,
        from: 0,
        with_fault: &measured,
        without_fault: &smooth,
        other: "model",
        noisy: SCATTER,
    };
    // A sensor that nothing stands still at differs by what its error says already.
    let mut found: Vec<Consequence> = runs
        .consequences(true)
        .into_iter()
        .filter(|one| one.measure != Measure::Rms && one.times_noise >= 1.0)
        .collect();
    let of_phases = phases(record, &drive);
    found.extend(
        (0..rig.sensors.len()).filter_map(|sensor| peak(&runs, (&raw[sensor], &model[sensor]), sensor, &of_phases)),
    );
    found.sort_by(|a, b| b.times_noise.total_cmp(&a.times_noise));
    found.truncate(MOST);
    Ok(found)
}

/// A measured curve; where rows have no value, what the model reads.
fn filled((measured, model): (&[f64], &Vec<f64>)) -> Vec<f64> {
    measured.iter().zip(model).map(|(y, m)| if y.is_nan() { *m } else { *y }).collect()
}

/// A curve without most of its noise.
fn smoothed(curve: &[f64]) -> Vec<f64> {
    let around = |row: usize| row.saturating_sub(SMOOTHED / 2)..(row + SMOOTHED / 2 + 1).min(curve.len());
    (0..curve.len()).map(|row| mean(&curve[around(row)])).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Rows between two switchings of the inputs.
fn phases(record: &Record, drive: &InputSignals) -> Vec<Range<usize>> {
    let ends: Vec<usize> = std::iter::once(0).chain(jumps(record, drive)).chain([record.time.len()]).collect();
    ends.windows(2).map(|pair| pair[0]..pair[1]).filter(|rows| rows.len() > SMOOTHED).collect()
}

/// The phase in which a pressure peaks by another height above its level than in the model, if any does by more than noise, averaged and as
/// it is read off a chart of `raw`, measured and model.
fn peak(runs: &Runs<'_>, raw: (&[f64], &[f64]), index: usize, phases: &[Range<usize>]) -> Option<Consequence> {
    let sensor = &runs.rig.sensors[index];
    if sensor.quantity != Quantity::Pressure {
        return None;
    }
    let highest = |curve: &[f64], rows: &Range<usize>| {
        let top = rows.clone().max_by(|&a, &b| curve[a].total_cmp(&curve[b])).unwrap_or(rows.start);
        (top, curve[top], mean(&curve[rows.clone()]))
    };
    let differs = |[measured, model]: [&[f64]; 2], rows: &Range<usize>| {
        let [measured, model] = [highest(measured, rows), highest(model, rows)];
        ((measured.1 - measured.2) - (model.1 - model.2), [measured, model])
    };
    let averaged = [&runs.with_fault[index][..], &runs.without_fault[index][..]];
    // What a phase begins or ends with is no peak.
    let peaks = |rows: &Range<usize>| {
        let (_, [(_, measured, _), (_, model, _)]) = differs([raw.0, raw.1], rows);
        let higher = if model > measured { raw.1 } else { raw.0 };
        measured.max(model) - higher[rows.start].max(higher[rows.end - 1]) >= TELLING * sensor.noise
    };
    // As much as both say, and in the same direction.
    let by_both = |rows: &Range<usize>| {
        let [averaged, read] = [averaged, [raw.0, raw.1]].map(|curves| differs(curves, rows).0);
        if averaged * read > 0.0 { averaged.abs().min(read.abs()) } else { 0.0 }
    };
    let of_peaks = phases.iter().filter(|rows| peaks(rows)).map(|rows| (by_both(rows), rows));
    let (differs_by, rows) = of_peaks.max_by(|a, b| a.0.total_cmp(&b.0))?;
    if differs_by < TELLING * sensor.noise {
        return None;
    }
    let (_, [(at, measured, _), (expected_at, model, _)]) = differs([raw.0, raw.1], rows);
    let at = if model > measured { expected_at } else { at };
    let unit = runs.rig.sensor_unit(sensor);
    let change = difference_in_unit(measured - model, &unit);
    let [measured, model] = [measured, model].map(|value| in_unit(value, &unit));
    let (name, time) = (&sensor.name, runs.record.time[at]);
    let [high, expected] =
        [measured, model].map(|value| worth(value, change.abs().max(difference_in_unit(sensor.noise, &unit))));
    let text =
        format!("{name} peaks at {high} instead of {} at {} s", before_unit(expected, &unit.symbol), rounded(time, 3));
    Some(Consequence {
        sensor: name.clone(),
        measure: Measure::Peak,
        change: rounded(change, DIGITS),
        with_fault: Some(rounded(measured, DIGITS)),
        without_fault: Some(rounded(model, DIGITS)),
        unit: unit.symbol.clone(),
        from_s: rounded(time, DIGITS),
        to_s: rounded(time, DIGITS),
        times_noise: rounded(differs_by / sensor.noise, DIGITS),
        text,
    })
}
