//! What a logger would have written of a disturbed rig: noise that is partly coloured, rounding.

use std::path::PathBuf;

use super::disturb::Disturbed;
use super::random::Stream;
use crate::model::{self, InputSignals, Outputs};
use crate::record::Record;

/// Share of the variance of the noise that is coloured.
const COLOURED: f64 = 0.3;
/// Time constant of its colour, s.
const COLOUR: f64 = 0.02;

/// The record of one run. Each column has a stream of `seed` of its own.
pub fn measured(
    disturbed: &Disturbed,
    path: impl Into<PathBuf>,
    drive: &InputSignals,
    times: &[f64],
    interval: f64,
    outputs: &Outputs,
    seed: u64,
) -> Record {
    let rig = &disturbed.rig;
    let mut inputs = model::input_columns(rig, drive, times);
    for (index, (values, input)) in inputs.iter_mut().zip(&rig.inputs).enumerate() {
        if input.noise > 0.0 {
            // Inputs count from the top, so that a sensor more leaves their noise as it was.
            add_noise(values, input.noise, interval, Stream::numbered(seed, u64::MAX - index as u64));
        }
    }
    let mut noisy = outputs.clone();
    for (index, (values, sensor)) in noisy.values.iter_mut().zip(&rig.sensors).enumerate() {
        add_noise(values, sensor.noise, interval, Stream::numbered(seed, index as u64));
        if sensor.resolution > 0.0 {
            values.iter_mut().for_each(|value| *value = (*value / sensor.resolution).round() * sensor.resolution);
        }
    }
    let mut record = model::recording(rig, path, times.to_vec(), inputs, &noisy, None);
    record.time_decimals = model::decimals_of(interval);
    record
}

/// Adds noise of standard deviation `sigma`: white, and first-order autoregressive.
fn add_noise(values: &mut [f64], sigma: f64, interval: f64, mut random: Stream) {
    let memory = (-interval / COLOUR).exp();
    let kick = (1.0 - memory * memory).sqrt();
    // It has been so for ever.
    let mut coloured = random.normal();
    for value in values {
        *value += sigma * ((1.0 - COLOURED).sqrt() * random.normal() + COLOURED.sqrt() * coloured);
        coloured = memory * coloured + kick * random.normal();
    }
}
