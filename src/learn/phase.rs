//! Phases of a cycle: what the circuit does over each stretch of a record.

use std::ops::Range;

use crate::model::InputSignals;
use crate::physics::card::PortKind;
use crate::record::Record;
use crate::rig::{Quantity, Rig, Target};
use crate::settings::LearningSettings;

/// Consecutive rows over which the circuit does one thing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stretch {
    pub rows: Range<usize>,
    /// `extend`, `retract`, `hold`, `switch`, `last 20 mm`; without a position `phase 1` and so on.
    pub name: String,
}

/// Way before an end stop that is a phase of its own, m, and the least stroke that has one.
const LAST: f64 = 0.02;
const STROKE_WITH_LAST: f64 = 4.0 * LAST;

/// The stretches of a record, one after the other without gap. `measured` are the readings of the rig's sensors, SI.
pub fn stretches(rig: &Rig, record: &Record, drive: &InputSignals, measured: &[&[f64]]) -> Vec<Stretch> {
    let settings = &rig.settings().learn;
    let rows = record.time.len();
    let mut jumps = jumps(record, drive);
    let switching: Vec<Range<usize>> = jumps.iter().map(|&row| switch(settings, &record.time, row)).collect();
    let mut switches = vec![false; rows];
    for range in switching {
        switches[range].fill(true);
    }
    // Inputs that never stand still have no switchings.
    if 2 * switches.iter().filter(|switch| **switch).count() > rows {
        jumps.clear();
        switches.fill(false);
    }
    // A dead sensor shows one value.
    let shows = |values: &[f64]| {
        let mut there = values.iter().filter(|value| !value.is_nan());
        there.next().is_some_and(|first| there.any(|value| value != first))
    };
    let mut sensors = rig.sensors.iter().zip(measured);
    let position = sensors.position(|(sensor, values)| sensor.quantity == Quantity::Position && shows(values));
    match position {
        Some(sensor) => merged(settings.phase_rows, &labels(rig, sensor, &record.time, measured[sensor], &switches)),
        None => between(&jumps, rows),
    }
}

/// First rows behind the jumps of the inputs, without that at the start.
pub(crate) fn jumps(record: &Record, drive: &InputSignals) -> Vec<usize> {
    let times = &record.time;
    let first = times.first().copied().unwrap_or(0.0);
    let jumps = drive.pieces.iter().filter(|piece| piece.jump && piece.start > first);
    let mut rows: Vec<usize> = jumps.map(|piece| times.partition_point(|&time| time <= piece.start)).collect();
    rows.retain(|&row| row < times.len());
    rows.dedup();
    rows
}

fn switch(settings: &LearningSettings, times: &[f64], row: usize) -> Range<usize> {
    let end =
        times.partition_point(|&time| time < times[row] + settings.switching_time).max(row + settings.switching_rows);
    row..end.min(times.len())
}

/// Stretches between jumps; thirds where nothing jumps.
fn between(jumps: &[usize], rows: usize) -> Vec<Stretch> {
    let (inner, names): (Vec<usize>, Vec<String>) = if jumps.is_empty() {
        let names = ["first third", "middle third", "last third"];
        (vec![rows / 3, 2 * rows / 3], names.map(str::to_owned).to_vec())
    } else {
        (jumps.to_vec(), (0..=jumps.len()).map(|number| format!("phase {}", number + 1)).collect())
    };
    let ends: Vec<usize> = [vec![0], inner, vec![rows]].concat();
    ends.windows(2).zip(names).map(|(pair, name)| Stretch { rows: pair[0]..pair[1], name }).collect()
}

/// What the body does in each row.
fn labels(rig: &Rig, sensor: usize, times: &[f64], position: &[f64], switches: &[bool]) -> Vec<&'static str> {
    let settings = &rig.settings().learn;
    let speeds: Vec<(f64, f64)> =
        (0..times.len()).map(|row| speed(settings.speed_rows, times, position, row)).collect();
    let greatest = speeds.iter().map(|(speed, _)| speed.abs()).fold(0.0, f64::max);
    let noise = rig.sensors[sensor].noise;
    let (low, high) = travel(rig, sensor).unwrap_or_else(|| ends(position));
    let has_last = high - low >= STROKE_WITH_LAST;
    (0..times.len())
        .map(|row| {
            let (speed, per_noise) = speeds[row];
            let moves =
                speed.abs() > (settings.moving_deviations * per_noise * noise).max(settings.moving_share * greatest);
            let ahead = if speed > 0.0 { high - position[row] } else { position[row] - low };
            match (switches[row], moves) {
                (true, _) => "switch",
                (false, false) => "hold",
                (false, true) if has_last && ahead < LAST => "last 20 mm",
                (false, true) if speed > 0.0 => "extend",
                (false, true) => "retract",
            }
        })
        .collect()
}

/// Slope of a straight line through the rows around one, and its standard error for noise 1.
fn speed(half: usize, times: &[f64], values: &[f64], row: usize) -> (f64, f64) {
    let near = |half: usize| -> Vec<usize> {
        (row.saturating_sub(half)..(row + half + 1).min(times.len())).filter(|&row| !values[row].is_nan()).collect()
    };
    let mut half = half;
    let mut rows = near(half);
    // Where samples are rare, as far as the nearest few.
    while rows.len() < 3 && half < times.len() {
        half *= 2;
        rows = near(half);
    }
    let count = rows.len() as f64;
    let middle = rows.iter().map(|&row| times[row]).sum::<f64>() / count;
    let square: f64 = rows.iter().map(|&row| (times[row] - middle).powi(2)).sum();
    if rows.is_empty() || square == 0.0 {
        return (0.0, 0.0);
    }
    let along: f64 = rows.into_iter().map(|row| (times[row] - middle) * values[row]).sum();
    (along / square, 1.0 / square.sqrt())
}

/// Ends of the travel of the body where a position sensor sits, from the stroke of its cylinder.
fn travel(rig: &Rig, sensor: usize) -> Option<(f64, f64)> {
    let Target::Node(body) = rig.sensors[sensor].target else { return None };
    rig.components
        .iter()
        .filter(|component| {
            let mut ports = component.card.ports.iter().zip(&component.ports);
            ports.any(|(port, node)| port.kind == PortKind::Mechanical && *node == body)
        })
        .find_map(|component| rig.parameter(&format!("{}.stroke", component.name)))
        .map(|stroke| (0.0, rig.parameters[stroke].value))
}

fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Runs of equal labels, short ones counted to that before them.
fn merged(short: usize, labels: &[&'static str]) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut start = 0;
    for run in labels.chunk_by(|a, b| a == b) {
        let end = start + run.len();
        match stretches.last_mut() {
            Some(last) if run.len() < short || last.name == run[0] => last.rows.end = end,
            _ => stretches.push(Stretch { rows: start..end, name: run[0].to_owned() }),
        }
        start = end;
    }
    stretches
}
