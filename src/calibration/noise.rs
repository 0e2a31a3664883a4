//! Noise of a sensor from the fast part of its misfit, so that what the model does wrong slowly is not taken for noise.

use super::joint::{Curves, Solutions};
use crate::diagnosis::noise;
use crate::rig::Rig;
use crate::settings::CalibrationSettings;

/// Noise of one sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// One standard deviation of a sample, rounding left out, SI.
    pub sigma: f64,
    /// Correlation of neighbouring samples; 0 where it cannot be told from none.
    pub correlation: f64,
}

impl Noise {
    /// By how much the variance of a mean over many samples exceeds that of independent ones.
    pub fn colour(&self) -> f64 {
        (1.0 + self.correlation) / (1.0 - self.correlation)
    }
}

/// Deviations count as no more than this many standard deviations (Huber's proposal 2).
const TAME: f64 = 2.0;
/// Mean of `min(z², 4)` over a normal distribution.
const TAME_MEAN: f64 = 0.920_537;

/// The noise of every sensor; `None` where too few quiet rows show it.
///
/// Deviations from straight lines over 40 quiet rows, their variance by Huber's proposal 2 (Huber and Ronchetti,
/// *Robust Statistics*, 6.4), less what rounding adds. Colour as of first order.
pub(super) fn estimate(rig: &Rig, solutions: &Solutions<'_>, curves: &Curves) -> Vec<Option<Noise>> {
    let settings = &rig.settings().calibration;
    let mut stretches: Vec<Vec<Vec<f64>>> = vec![Vec::new(); rig.sensors.len()];
    for (one, curves) in solutions.records.iter().zip(curves) {
        let views: Vec<&[f64]> = curves.iter().map(Vec::as_slice).collect();
        let variance = noise::variances(rig, one.record, &views, false);
        let phases = noise::phases(rig, &one.drive, &one.record.time, &variance);
        for (index, sensor) in rig.sensors.iter().enumerate() {
            let quiet = |row: usize| variance[index][row] <= (1.0 + settings.quiet_share) * sensor.variance();
            for phase in &phases {
                let rows: Vec<usize> = phase.clone().filter(|&row| variance[index][row].is_finite()).collect();
                for run in rows.chunk_by(|&a, &b| quiet(a) == quiet(b)).filter(|run| quiet(run[0])) {
                    let count = run.len().div_ceil(settings.noise_rows).max(1);
                    for block in
                        run.chunks(run.len().div_ceil(count)).filter(|block| block.len() >= settings.noise_rows_least)
                    {
                        let misfit = |&row: &usize| curves[index][row] - one.measured[index][row];
                        stretches[index].push(straightened(block.iter().map(misfit).collect()));
                    }
                }
            }
        }
    }
    let each = rig.sensors.iter().zip(&stretches);
    each.map(|(sensor, stretches)| {
        let (variance, correlation) = pooled(settings, stretches)?;
        let rounding = sensor.resolution * sensor.resolution / 12.0;
        let floor =
            (settings.noise_floor_resolution * sensor.resolution).max(settings.noise_floor_stated * sensor.noise);
        Some(Noise { sigma: (variance - rounding).max(floor * floor).sqrt(), correlation })
    })
    .collect()
}

/// Values less their least-squares straight line.
fn straightened(mut values: Vec<f64>) -> Vec<f64> {
    let n = values.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = values.iter().sum::<f64>() / n;
    let along: f64 = values.iter().enumerate().map(|(row, value)| (row as f64 - middle) * value).sum();
    let slope = along / (n * (n * n - 1.0) / 12.0);
    for (row, value) in values.iter_mut().enumerate() {
        *value -= mean + slope * (row as f64 - middle);
    }
    values
}

/// Variance and correlation of neighbours of what straightened stretches were before.
fn pooled(settings: &CalibrationSettings, stretches: &[Vec<f64>]) -> Option<(f64, f64)> {
    if stretches.len() < settings.noise_stretches {
        return None;
    }
    let all: Vec<f64> = stretches.iter().flatten().copied().collect();
    let total = all.len() as f64;
    let mut variance = all.iter().map(|value| value * value).sum::<f64>() / total;
    for _ in 0..50 {
        let tame: f64 = all.iter().map(|value| (value * value).min(TAME * TAME * variance)).sum::<f64>() / total;
        let next = tame / TAME_MEAN;
        let settled = (next - variance).abs() <= 1e-9 * variance;
        variance = next;
        if settled || variance == 0.0 {
            break;
        }
    }
    let most = TAME * variance.sqrt();
    let tame = |value: f64| value.clamp(-most, most);
    let (mut product, mut square) = (0.0, 0.0);
    for stretch in stretches {
        product += stretch.windows(2).map(|pair| tame(pair[0]) * tame(pair[1])).sum::<f64>();
        square += stretch.iter().map(|&value| tame(value).powi(2)).sum::<f64>() * (1.0 - 1.0 / stretch.len() as f64);
    }
    let raw = if square > 0.0 { product / square } else { 0.0 };
    // The line takes two directions of low frequency with it: the more of them, the more coloured the noise.
    let rows = total / stretches.len() as f64;
    let mut correlation: f64 = 0.0;
    let mut lost = 0.0;
    for _ in 0..20 {
        lost = (2.0 * (1.0 + correlation) / (1.0 - correlation) / rows).min(0.5);
        correlation = (raw * (1.0 - lost) + lost).clamp(0.0, settings.correlation_most);
        if correlation < 3.0 / total.sqrt() {
            correlation = 0.0;
        }
    }
    Some((variance / (1.0 - lost), correlation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn stretches(correlation: f64, seed: u64) -> Vec<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut state: f64 = 0.0;
        (0..100)
            .map(|_| {
                let mut draw = || {
                    let new: f64 = StandardNormal.sample(&mut random);
                    state = correlation * state + (1.0 - correlation * correlation).sqrt() * new;
                    state
                };
                straightened(
                    (0..CalibrationSettings::default().noise_rows).map(|row| draw() + 3.0 + 0.2 * row as f64).collect(),
                )
            })
            .collect()
    }

    #[test]
    fn variance_and_colour_are_found_again() {
        for (seed, truth) in [(1, 0.0), (2, 0.3), (3, 0.6)] {
            let (variance, correlation) = pooled(&CalibrationSettings::default(), &stretches(truth, seed)).unwrap();
            assert!((variance - 1.0).abs() < 0.12, "{truth}: variance {variance}");
            assert!((correlation - truth).abs() < 0.06, "{truth}: correlation {correlation}");
        }
    }

    #[test]
    fn wild_samples_hardly_count() {
        let mut wild = stretches(0.0, 4);
        for stretch in wild.iter_mut().step_by(4) {
            stretch[5] = 100.0;
        }
        let (variance, _) = pooled(&CalibrationSettings::default(), &wild).unwrap();
        assert!((variance - 1.0).abs() < 0.12, "{variance}");
    }

    #[test]
    fn the_mean_of_tame_squares_is_that_of_a_normal_distribution() {
        // Simpson over 2 * phi(z) min(z², 4), 0 to 10.
        let f = |z: f64| 2.0 * (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt() * (z * z).min(TAME * TAME);
        let n = 20_000;
        let h = 10.0 / n as f64;
        let sum: f64 = (0..=n)
            .map(|k| {
                f(k as f64 * h)
                    * if k == 0 || k == n {
                        1.0
                    } else if k % 2 == 1 {
                        4.0
                    } else {
                        2.0
                    }
            })
            .sum();
        approx::assert_abs_diff_eq!(sum * h / 3.0, TAME_MEAN, epsilon = 1e-5);
    }
}
