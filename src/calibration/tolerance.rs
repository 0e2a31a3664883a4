//! Tolerance of the model: how far model and sensor differ throughout a phase, from all phases of all records.
//!
//! The misfit of a phase is taken as constant and slope of unknown size (the wanted variance), plus noise, plus what events
//! may do, plus what parameters do that are not known exactly. Everything but the constants and slopes is integrated out,
//! so that offsets and coefficients, which the fit has bent to make the constants small, do not make the tolerance too
//! small: restricted likelihood (Patterson and Thompson, Biometrika 58 (1971)) with what is known of the parameters as prior.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use crate::diagnosis::noise::Weights;
use crate::rig::Rig;
use crate::settings::CalibrationSettings;

/// Sizes of a tolerance, in standard deviations of its sensor's noise, at which its likelihood is evaluated: the least, the
/// largest, and the ratio of neighbours.
const GRID: (f64, f64, f64) = (0.01, 30.0, 1.6);
/// Directions that hold less than this share of the largest are rounding.
const NOTHING: f64 = 1e-9;

/// What one phase of one record says of the levels.
struct Levels {
    /// Levels seen, what parameters explain in the best case taken off.
    seen: DVector<f64>,
    /// What a level of one standard deviation of each sensor's noise does: constants first, then slopes.
    of_level: DMatrix<f64>,
    /// What parameters do.
    of_parameter: DMatrix<f64>,
    /// Covariance of `seen` by noise.
    noise: DMatrix<f64>,
}

/// All that the records say of the tolerances.
pub(super) struct Evidence {
    phases: Vec<Levels>,
    /// Inverse covariance of the parameters by everything but the levels.
    precision: DMatrix<f64>,
    /// Standard deviation of each sensor's noise, SI.
    noise: Vec<f64>,
    /// Scale of the prior, in standard deviations of the noise.
    scale: Vec<f64>,
    settings: CalibrationSettings,
}

/// One record as the tolerances see it.
pub(super) struct PortVariables {
    /// Weights without any tolerance.
    pub weights: Weights,
    pub phases: Vec<Range<usize>>,
    /// Model minus measurement, SI, one sensor after the other.
    pub misfit: Vec<f64>,
    /// Its derivatives by the parameters.
    pub columns: DMatrix<f64>,
}

impl Evidence {
    /// From the records at one point: `precision` of the parameters by the prior and `pull`, the prior's precision times the
    /// way from this point to its mean; `colour` by how much the noise of each sensor is stronger in means than if white.
    pub fn new(
        rig: &Rig,
        records: Vec<PortVariables>,
        precision: DMatrix<f64>,
        pull: DVector<f64>,
        colour: &[f64],
        scale: Vec<f64>,
    ) -> Self {
        let noise: Vec<f64> = rig.sensors.iter().map(|sensor| sensor.variance().sqrt()).collect();
        let mut evidence =
            Self { phases: Vec::new(), precision, noise, scale, settings: rig.settings().calibration.clone() };
        let mut pull = pull;
        for record in records {
            evidence.add(record, &mut pull, colour);
        }
        // What everything but the levels says of the parameters.
        let best = evidence.precision.clone().cholesky().map(|factor| factor.solve(&pull));
        if let Some(best) = best {
            for phase in &mut evidence.phases {
                phase.seen += &phase.of_parameter * &best;
            }
        }
        evidence
    }

    fn add(&mut self, record: PortVariables, pull: &mut DVector<f64>, colour: &[f64]) {
        let PortVariables { weights, phases, mut misfit, mut columns } = record;
        let sensors = self.noise.len();
        let rows = misfit.len() / sensors.max(1);
        weights.apply(&mut misfit);
        weights.apply_to_columns(&mut columns);
        // Phases are weighed apart, so one column holds the levels of all of them.
        let mut levels = DMatrix::zeros(misfit.len(), 2 * sensors);
        for sensor in 0..sensors {
            for phase in &phases {
                let last = (phase.len().max(2) - 1) as f64;
                for row in phase.clone() {
                    let along = 3.0_f64.sqrt() * (2.0 * (row - phase.start) as f64 / last - 1.0);
                    levels[(sensor * rows + row, sensor)] = self.noise[sensor];
                    levels[(sensor * rows + row, sensors + sensor)] = self.noise[sensor] * along;
                }
            }
        }
        weights.apply_to_columns(&mut levels);
        for phase in &phases {
            let picked: Vec<usize> = (0..sensors).flat_map(|s| s * rows + phase.start..s * rows + phase.end).collect();
            let (level, columns) = (levels.select_rows(&picked), columns.select_rows(&picked));
            let misfit = DVector::from_fn(picked.len(), |k, _| misfit[picked[k]]);
            let coloured =
                DMatrix::from_fn(picked.len(), level.ncols(), |k, j| level[(k, j)] * colour[picked[k] / rows]);
            let eigen = SymmetricEigen::new(level.tr_mul(&level));
            let largest = eigen.eigenvalues.max();
            let kept: Vec<usize> =
                (0..eigen.eigenvalues.len()).filter(|&k| eigen.eigenvalues[k] > NOTHING * largest).collect();
            // Q = L V / sqrt(lambda): orthonormal directions of the levels.
            let turn = DMatrix::from_fn(level.ncols(), kept.len(), |j, k| {
                eigen.eigenvectors[(j, kept[k])] / eigen.eigenvalues[kept[k]].sqrt()
            });
            let directions = &level * &turn;
            let flat = &directions * directions.tr_mul(&misfit);
            // Levels stay; only what is left of a sample is tamed.
            let most = self.settings.level_outlier_misfit;
            let tamed = DVector::from_fn(picked.len(), |k, _| flat[k] + (misfit[k] - flat[k]).clamp(-most, most));
            let seen = directions.tr_mul(&tamed);
            let of_parameter = directions.tr_mul(&columns);
            *pull -= columns.tr_mul(&tamed) - of_parameter.tr_mul(&seen);
            self.precision += columns.transpose() * &columns - of_parameter.tr_mul(&of_parameter);
            let noise = turn.tr_mul(&level.tr_mul(&coloured)) * &turn;
            self.phases.push(Levels { seen, of_level: directions.tr_mul(&level), of_parameter, noise });
        }
    }

    /// Twice the logarithm of the likelihood of tolerances, in standard deviations of the noise, but for a constant.
    fn score(&self, tolerance: &[f64]) -> Option<f64> {
        let p = self.precision.nrows();
        let (mut information, mut pull) = (self.precision.clone(), DVector::zeros(p));
        let mut score = 0.0;
        for phase in &self.phases {
            let mut scaled = phase.of_level.clone();
            for (column, mut values) in scaled.column_iter_mut().enumerate() {
                values *= tolerance[column % tolerance.len()];
            }
            let factor = Cholesky::new(&phase.noise + &scaled * scaled.transpose())?;
            let seen = factor.l_dirty().solve_lower_triangular(&phase.seen)?;
            let across = factor.l_dirty().solve_lower_triangular(&phase.of_parameter)?;
            score -= factor.ln_determinant() + seen.norm_squared();
            information += across.tr_mul(&across);
            pull += across.tr_mul(&seen);
        }
        let factor = Cholesky::new(information)?;
        Some(score - factor.ln_determinant() + pull.dot(&factor.solve(&pull)))
    }

    /// Tolerances, SI: geometric means of the posterior, each sensor's on a grid with the others at theirs, `sweeps` times.
    /// They are too large about as often as too small; roots of the mean squares, which the long tail of few phases rules,
    /// make intervals wider than their name.
    pub fn tolerances(&self, start: &[f64], sweeps: usize) -> Vec<f64> {
        let ((least, most, ratio), freedom) = (GRID, self.settings.tolerance_freedom);
        let mut sizes: Vec<f64> =
            start.iter().zip(&self.noise).map(|(start, noise)| (start / noise).clamp(least, most)).collect();
        let grid: Vec<f64> =
            std::iter::successors(Some(least), |size| Some(size * ratio)).take_while(|s| *s < most).collect();
        for _ in 0..sweeps {
            for sensor in 0..sizes.len() {
                let mut tried = sizes.clone();
                let scores: Vec<f64> = grid
                    .iter()
                    .map(|&size| {
                        tried[sensor] = size;
                        let distance = (size / self.scale[sensor]).powi(2) / freedom;
                        // On a logarithmic grid each point stands for an interval as long as its size.
                        let prior = -(freedom + 1.0) * distance.ln_1p() + 2.0 * size.ln();
                        self.score(&tried).map_or(f64::NEG_INFINITY, |score| score + prior)
                    })
                    .collect();
                let best = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                if !best.is_finite() {
                    continue;
                }
                let (mut logarithms, mut total) = (0.0, 0.0);
                for (size, score) in grid.iter().zip(&scores) {
                    let weight = (0.5 * (score - best)).exp();
                    logarithms += weight * size.ln();
                    total += weight;
                }
                sizes[sensor] = (logarithms / total).exp();
            }
        }
        sizes.iter().zip(&self.noise).map(|(size, noise)| size * noise).collect()
    }
}
