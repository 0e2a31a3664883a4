//! How far a sample may be from the model: noise and rounding of the sensor, and the tolerance of the model.
//!
//! A model that is right but for the moment of an event misses by tens of standard deviations while valves or the load
//! switch, and trapped oil remembers it: closing a valve 0.1 ms late leaves both chambers bars higher until it opens
//! again. Three things follow, none of them taken from the misfit:
//!
//! - *Events.* Their moment is uncertain by `tau`: a jump that a logger shows between two rows may have come anywhere
//!   between them (rms distance from the earlier row: interval/sqrt(3)), and every time constant of the rig is uncertain by
//!   what its data sheet says. Moving a curve by `tau` changes it by `tau y'`; the part that is not a shift of the whole
//!   curve is its curvature, so a sample's own tolerance is `(tau/2h) |y(t+h) - 2 y(t) + y(t-h)|`, the largest within `h` of
//!   it, `h` being the sampling interval or `tau`, whichever is longer.
//! - *Phases.* Between two jumps of the inputs, model and sensor may differ by a constant of the size of the sensor's
//!   tolerance, and by what each uncertain time constant would have done had it been another in this one switching. Both are
//!   random effects: directions of the misfit in which a phase has `1 + (size)²` times the variance of noise.
//! - A phase therefore says no more about a constant than its tolerance allows, however many samples it has.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::model::Drive;
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

/// Rows between jumps of the inputs.
pub fn phases(drive: &Drive, times: &[f64]) -> Vec<Range<usize>> {
    let mut starts: Vec<usize> = drive
        .pieces
        .iter()
        .filter(|piece| piece.jump)
        .map(|piece| times.partition_point(|&time| time <= piece.start))
        .collect();
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
    /// `1/sigma` of each sample, `[sensor][row]`.
    inverse: Vec<Vec<f64>>,
    /// Tolerance of each sensor, SI.
    tolerance: Vec<f64>,
    phases: Vec<Phase>,
}

#[derive(Debug, Clone)]
struct Phase {
    rows: Range<usize>,
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
            tolerance: rig.sensors.iter().map(|sensor| sensor.tolerance).collect(),
            phases: phases
                .iter()
                .map(|rows| Phase { rows: rows.clone(), directions: Vec::new(), taken: Vec::new() })
                .collect(),
        };
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
        weights
    }

    /// Misfits in SI, or a derivative of them, one sensor after the other, into independent ones of variance 1. Entries
    /// beyond the samples are left.
    pub fn apply(&self, column: &mut [f64]) {
        self.scale(column);
        self.level(column);
        for phase in &self.phases {
            let length = phase.rows.len();
            for (direction, taken) in phase.directions.iter().zip(&phase.taken) {
                let blocks = || direction.chunks_exact(length.max(1)).enumerate();
                let along: f64 =
                    blocks().map(|(sensor, part)| dot(part, &column[sensor * self.rows..][phase.rows.clone()])).sum();
                for (sensor, part) in blocks() {
                    for (slot, direction) in column[sensor * self.rows..][phase.rows.clone()].iter_mut().zip(part) {
                        *slot -= taken * along * direction;
                    }
                }
            }
        }
    }

    fn scale(&self, column: &mut [f64]) {
        for (slot, weight) in column.iter_mut().zip(self.inverse.iter().flatten()) {
            *slot *= weight;
        }
    }

    /// Takes from each phase of each sensor what a shared constant can explain: multiplies by `(I + v v')^(-1/2)`, `v` the
    /// tolerance over the standard deviation of each sample.
    fn level(&self, column: &mut [f64]) {
        for (sensor, (inverse, tolerance)) in self.inverse.iter().zip(&self.tolerance).enumerate() {
            for phase in &self.phases {
                let block = &mut column[sensor * self.rows..][phase.rows.clone()];
                let weights = &inverse[phase.rows.clone()];
                let square = tolerance * tolerance * dot(weights, weights);
                if square == 0.0 {
                    continue;
                }
                let along = tolerance * dot(weights, block);
                let factor = (1.0 - 1.0 / (1.0 + square).sqrt()) * along / square * tolerance;
                for (slot, weight) in block.iter_mut().zip(weights) {
                    *slot -= factor * weight;
                }
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// For effects `G` (columns): orthonormal `U` and shares `f` with `(I + G G')^(-1/2) = I - U diag(f) U'`.
fn random_directions(effects: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let m = effects.len();
    if m == 0 {
        return (Vec::new(), Vec::new());
    }
    // G = U S V' from the small matrix G'G = V S² V'.
    let gram = DMatrix::from_fn(m, m, |i, j| dot(&effects[i], &effects[j]));
    let eigen = SymmetricEigen::new(gram);
    let largest = eigen.eigenvalues.max();
    let (mut directions, mut taken) = (Vec::new(), Vec::new());
    for (index, &square) in eigen.eigenvalues.iter().enumerate() {
        // Below this, rounding is all that is left of the direction, and its effect is none.
        if square <= 1e-6 || square <= 1e-12 * largest {
            continue;
        }
        let v: DVector<f64> = eigen.eigenvectors.column(index).into();
        let mut direction = vec![0.0; effects[0].len()];
        for (effect, share) in effects.iter().zip(v.iter()) {
            for (slot, value) in direction.iter_mut().zip(effect) {
                *slot += share * value / square.sqrt();
            }
        }
        directions.push(direction);
        taken.push(1.0 - 1.0 / (1.0 + square).sqrt());
    }
    (directions, taken)
}
