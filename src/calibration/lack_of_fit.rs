//! What is weighed while the model lacks something that the healthy records show.
//!
//! Noise is estimated from the fast part of the misfit and tolerance from the levels of its phases. Where the model misses by more,
//! both are shares of what it lacks, and the one that is small would force the other sensors aside. Such a sensor keeps the
//! noise that the rig file states, and its variance is raised to what the fit leaves (quasi-likelihood: Wedderburn, Biometrika 61,
//! 1974), as in the learning of effects.

use super::rounds::Rounds;
use crate::diagnosis::noise::Weights;
use crate::diagnosis::{adequate, tame_squares};
use crate::model::SimulationError;

impl Rounds<'_> {
    /// Weighs by noise and tolerance alone.
    pub(super) fn forget_lack_of_fit(&mut self) {
        self.rig.sensors.iter_mut().for_each(|sensor| sensor.lack_of_fit = 0.0);
    }

    /// Raises the variance of each sensor to what `weights`, of noise and tolerance alone, leave near `theta`. Whether any has to be.
    pub(super) fn estimate_lack_of_fit(&mut self, theta: &[f64], weights: &[Weights]) -> Result<bool, SimulationError> {
        let squares = self.squares(theta, weights)?;
        let stated = &self.solutions.model.rig.sensors;
        let settings = self.rig.settings().diagnosis.clone();
        let mut any = false;
        for ((sensor, (tame, all, samples)), stated) in self.rig.sensors.iter_mut().zip(squares).zip(stated) {
            if samples == 0 || adequate(&settings, tame / samples as f64, samples) {
                continue;
            }
            let lacking = sensor.variance() * (all / samples as f64 - 1.0).max(0.0);
            // More than noise: what the fast part of the misfit shows is not noise either.
            if lacking > sensor.variance() {
                sensor.noise = stated.noise;
            }
            sensor.lack_of_fit = lacking.sqrt();
            any = true;
        }
        Ok(any)
    }

    /// Misfits near `theta` weighed by noise and tolerance alone: what a calibration is judged by. One record after the other.
    pub(super) fn judged(&self, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        let mut rig = self.rig.clone();
        rig.sensors.iter_mut().for_each(|sensor| sensor.lack_of_fit = 0.0);
        let weights = Self::weights(&rig, &self.events(&rig, theta)?);
        let curves = self.solutions.curves(theta)?;
        let mut all = Vec::new();
        for (record, weights) in weights.iter().enumerate() {
            let mut misfit = self.solutions.misfit(&curves, record);
            weights.apply(&mut misfit);
            all.append(&mut misfit);
        }
        Ok(all)
    }

    /// Of each sensor over all records: squares of the weighted misfit, outliers cut off and not, and samples.
    fn squares(&self, theta: &[f64], weights: &[Weights]) -> Result<Vec<(f64, f64, usize)>, SimulationError> {
        let curves = self.solutions.curves(theta)?;
        let mut sums = vec![(0.0, 0.0, 0); self.rig.sensors.len()];
        for (record, weights) in weights.iter().enumerate() {
            let mut misfit = self.solutions.misfit(&curves, record);
            weights.apply(&mut misfit);
            let rows = misfit.len() / sums.len();
            for (sensor, (sum, own)) in sums.iter_mut().zip(misfit.chunks_exact(rows)).enumerate() {
                sum.0 += tame_squares(&self.rig.settings().diagnosis, own);
                sum.1 += own.iter().map(|r| r * r).sum::<f64>();
                sum.2 += weights.samples(sensor);
            }
        }
        Ok(sums)
    }
}
