//! From what the model reads to a record as a logger would have written it.

use std::path::PathBuf;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::{InputSignals, Outputs, Piece};
use crate::record::{Channel, Record};
use crate::rig::{Hold, Rig};

/// Most decimals that a rounded column is written with.
const DECIMALS: usize = 12;

/// What each input's column says at `times`, SI: `[input][row]`; behind them that of the temperature of the fluid, where it is
/// not at its reference throughout.
///
/// A held value is the one in the middle of its interval, as long as the one before (at the first and last row: after and
/// before) the row.
pub fn input_columns(rig: &Rig, drive: &InputSignals, times: &[f64]) -> Vec<Vec<f64>> {
    let step = |row: usize| times.get(row + 1).zip(times.get(row)).map(|(late, early)| late - early);
    let column = |(index, hold): (usize, Hold)| {
        let value = |(row, &time): (usize, &f64)| {
            let before = row.checked_sub(1).and_then(step);
            let after = step(row);
            let at = match hold {
                Hold::Before => time - 0.5 * before.or(after).unwrap_or(0.0),
                Hold::After => time + 0.5 * after.or(before).unwrap_or(0.0),
                Hold::Linear => time,
            };
            drive.value(index, at)
        };
        times.iter().enumerate().map(value).collect()
    };
    let mut columns: Vec<Vec<f64>> = rig.inputs.iter().map(|input| input.hold).enumerate().map(column).collect();
    let place = rig.inputs.len();
    let warms = |piece: &Piece| piece.from.get(place).is_some_and(|from| *from != 0.0);
    let temperature = rig.temperature.as_ref().filter(|_| drive.pieces.iter().any(warms));
    columns.extend(
        temperature
            .map(|temperature| times.iter().map(|&time| temperature.reference + drive.value(place, time)).collect()),
    );
    columns
}

/// A record of every sensor and input, each in the unit that the rig file writes it in.
///
/// `inputs` are the input columns in SI, `[input][row]`, as [`input_columns`] gives them. Without `seed` the values are exact.
/// With it every sensor has its noise and is rounded to its resolution, and every input has its noise; the same seed gives the
/// same record.
pub fn recording(
    rig: &Rig,
    path: impl Into<PathBuf>,
    times: Vec<f64>,
    inputs: Vec<Vec<f64>>,
    outputs: &Outputs,
    seed: Option<u64>,
) -> Record {
    let mut channels = Vec::new();
    let temperature = rig.temperature.iter().map(|temperature| &temperature.input);
    for (index, (input, mut values)) in rig.inputs.iter().chain(temperature).zip(inputs).enumerate() {
        let unit = input.scale.as_ref().map_or(&input.unit, |scale| &scale.unit);
        let mut decimals = None;
        if let Some(seed) = seed.filter(|_| input.noise > 0.0) {
            // A digit below a tenth of the noise says nothing.
            decimals = Some(decimals_above(unit.difference_from_si(input.noise).abs() / 10.0));
            // Inputs count from the top, so that a sensor more leaves their noise as it was.
            add_noise(&mut values, input.noise, seed, u64::MAX - index as u64);
        }
        channels.push(Channel { name: input.column.clone(), unit: unit.clone(), values, decimals });
    }
    for (index, (sensor, values)) in rig.sensors.iter().zip(&outputs.values).enumerate() {
        let unit = rig.column_unit(sensor);
        let mut values = values.clone();
        let mut decimals = None;
        if let Some(seed) = seed {
            add_noise(&mut values, sensor.noise, seed, index as u64);
            if sensor.resolution > 0.0 {
                for value in &mut values {
                    *value = (*value / sensor.resolution).round() * sensor.resolution;
                }
                decimals = decimals_of(unit.difference_from_si(sensor.resolution).abs());
            }
        }
        channels.push(Channel { name: sensor.column.clone(), unit, values, decimals });
    }
    Record::new(path, times, channels)
}

/// Adds white noise; each stream of a seed is independent of the others.
fn add_noise(values: &mut [f64], sigma: f64, seed: u64, stream: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    for value in values {
        let standard: f64 = StandardNormal.sample(&mut random);
        *value += sigma * standard;
    }
}

/// Decimals that write a step exactly: 3 for 0.005; `None` where no number of them does.
pub fn decimals_of(step: f64) -> Option<usize> {
    (0..=DECIMALS).find(|&decimals| {
        let scaled = step * 10f64.powi(decimals as i32);
        scaled.round() >= 1.0 && (scaled - scaled.round()).abs() < 1e-9 * scaled
    })
}

/// Fewest decimals whose last digit is no coarser than a step.
fn decimals_above(step: f64) -> usize {
    (0..DECIMALS).find(|&decimals| 10f64.powi(-(decimals as i32)) <= step).unwrap_or(DECIMALS)
}
