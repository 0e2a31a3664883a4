//! How far a sample may be from the model: noise and rounding of the sensor, and the tolerance of the model where
//! things happen fast.
//!
//! A model that is right but for the moment of an event misses by tens of standard deviations while valves or the load
//! switch. The moment is uncertain by `tau`: a jump that a logger shows between two rows may have come anywhere between
//! them (rms distance from the earlier row: interval/sqrt(3)), and every time constant of the rig is uncertain by what its
//! data sheet says. Moving a curve by `tau` changes it by `tau y'`, of which the steady part is a shift of the whole curve
//! that estimated lags account for; what is left is the curvature, so the tolerance of a sample is
//! `(tau/2h) |y(t+h) - 2 y(t) + y(t-h)|`, the largest within `h` of it, with `h` the sampling interval or `tau`, whichever
//! is longer.

use crate::record::Record;
use crate::rig::{Hold, Rig};
use crate::units::Dimension;

/// One standard deviation of the moment of an event, s.
pub fn timing(rig: &Rig, record: &Record) -> f64 {
    let interval = record.sampling().map_or(0.0, |sampling| sampling.interval);
    // A command is the logger's own; only what is measured jumps between rows.
    let measured = rig.inputs.iter().any(|input| input.noise > 0.0 && input.hold != Hold::Linear);
    let hold = if measured { interval / 3.0_f64.sqrt() } else { 0.0 };
    let lags = rig.parameters.iter().filter(|parameter| parameter.unit.dimension == Dimension::TIME);
    lags.map(|parameter| parameter.sigma.powi(2)).sum::<f64>().mul_add(1.0, hold * hold).sqrt()
}

/// Variance of each sample, SI squared: `[sensor][row]`. `curves` is what the sensors read, by the model or as measured;
/// `curve_noise` its own standard deviation per sensor (0 for the model), whose curvature is not mistaken for an event.
pub fn variances(rig: &Rig, record: &Record, curves: &[&[f64]], measured: bool) -> Vec<Vec<f64>> {
    let interval = record.sampling().map_or(0.0, |sampling| sampling.interval);
    let tau = timing(rig, record);
    let stride = if interval > 0.0 { (tau / interval).round().max(1.0) as usize } else { 1 };
    let share = if interval > 0.0 { tau / (2.0 * stride as f64 * interval) } else { 0.0 };
    rig.sensors
        .iter()
        .zip(curves)
        .map(|(sensor, curve)| {
            let variance = sensor.variance();
            // The second difference of noise has six times its variance.
            let floor = if measured { 6.0 * variance } else { 0.0 };
            let bend: Vec<f64> = (0..curve.len())
                .map(|row| {
                    let (early, late) = (row.saturating_sub(stride), (row + stride).min(curve.len() - 1));
                    let second = curve[late] - 2.0 * curve[row] + curve[early];
                    (second * second - floor).max(0.0)
                })
                .collect();
            (0..curve.len())
                .map(|row| {
                    let near = row.saturating_sub(stride)..(row + stride + 1).min(curve.len());
                    let worst = bend[near].iter().copied().fold(0.0, f64::max);
                    variance + share * share * worst
                })
                .collect()
        })
        .collect()
}
