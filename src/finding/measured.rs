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

/// Rows over which noise is averaged out before a curve is read, as an eye does.
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
    let measured: Vec<Vec<f64>> = weighed::measured(rig, record)?.into_iter().zip(model).map(smoothed).collect();
    let runs = Runs {
        rig,
        record,
        drive: &drive,
        from: 0,
        with_fault: &measured,
        without_fault: model,
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
    found.extend((0..rig.sensors.len()).filter_map(|sensor| peak(&runs, sensor, &of_phases)));
    found.sort_by(|a, b| b.times_noise.total_cmp(&a.times_noise));
    found.truncate(MOST);
    Ok(found)
}

/// A measured curve without most of its noise; where rows have no value, what the model reads.
fn smoothed((measured, model): (&[f64], &Vec<f64>)) -> Vec<f64> {
    let filled: Vec<f64> = measured.iter().zip(model).map(|(y, m)| if y.is_nan() { *m } else { *y }).collect();
    let around = |row: usize| row.saturating_sub(SMOOTHED / 2)..(row + SMOOTHED / 2 + 1).min(filled.len());
    (0..filled.len()).map(|row| mean(&filled[around(row)])).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Rows between two switchings of the inputs.
fn phases(record: &Record, drive: &InputSignals) -> Vec<Range<usize>> {
    let ends: Vec<usize> = std::iter::once(0).chain(jumps(record, drive)).chain([record.time.len()]).collect();
    ends.windows(2).map(|pair| pair[0]..pair[1]).filter(|rows| rows.len() > SMOOTHED).collect()
}

/// The phase in which a pressure peaks by another height above its level than in the model, if any does by more than noise.
fn peak(runs: &Runs<'_>, index: usize, phases: &[Range<usize>]) -> Option<Consequence> {
    let sensor = &runs.rig.sensors[index];
    if sensor.quantity != Quantity::Pressure {
        return None;
    }
    let curves = [&runs.with_fault[index], &runs.without_fault[index]];
    let highest = |rows: &Range<usize>| {
        curves.map(|curve| rows.clone().max_by(|&a, &b| curve[a].total_cmp(&curve[b])).unwrap_or(rows.start))
    };
    let of = |rows: &Range<usize>| {
        let tops = highest(rows);
        let [measured, model] = [0, 1].map(|run| curves[run][tops[run]]);
        let [above, beside] = [measured - mean(&curves[0][rows.clone()]), model - mean(&curves[1][rows.clone()])];
        (above - beside, tops[usize::from(model > measured)], [measured, model])
    };
    let (differs, at, [measured, model]) = phases.iter().map(of).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    if differs.abs() < TELLING * sensor.noise {
        return None;
    }
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
        times_noise: rounded(differs.abs() / sensor.noise, DIGITS),
        text,
    })
}
