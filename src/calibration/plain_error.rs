//! The plain error of a fit, measured minus model over the noise of the sensors, and what other time constants would take from it.
//!
//! Everything estimated follows along its derivatives (variable projection: Golub and Pereyra, Inverse Problems 19 (2003)).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::joint::{Healthy, Solutions};
use crate::diagnosis::noise::Weights;
use crate::diagnosis::problem::{away, over_sensors};
use crate::diagnosis::switching::beyond_noise;
use crate::estimation::Gaussian;
use crate::model::{InputSignals, SimulationError};
use crate::rig::{Rig, Sensor};

/// Least cost of other curves, in squares of the sensors' noise, with everything estimated following along its derivatives.
pub(super) struct Profile<'s, 'a> {
    pub solutions: &'s Solutions<'a>,
    /// One per record: noise alone.
    weights: Vec<Weights>,
    /// One per record: weighted derivatives by what is estimated, in standard deviations of what was known before.
    columns: Vec<DMatrix<f64>>,
    information: Cholesky<f64, Dyn>,
    /// How far the estimate is from what was known before, in its standard deviations.
    away: DVector<f64>,
    /// Of the curves at hand.
    pub cost: f64,
    pub samples: f64,
}

impl<'s, 'a> Profile<'s, 'a> {
    pub fn at(solutions: &'s Solutions<'a>, prior: &Gaussian, theta: &[f64]) -> Result<Option<Self>, SimulationError> {
        let rig = &solutions.model.rig;
        let weights: Vec<Weights> = solutions.records.iter().map(|one| by_noise(rig, one)).collect();
        let sigma = DVector::from_column_slice(&prior.sigma);
        let mut information = DMatrix::identity(theta.len(), theta.len());
        let mut columns = Vec::new();
        for (record, weights) in weights.iter().enumerate() {
            let mut of_record = solutions.columns(theta, record)?;
            for (mut column, sigma) in of_record.column_iter_mut().zip(sigma.iter()) {
                column *= *sigma;
            }
            weights.apply_to_columns(&mut of_record);
            information += of_record.tr_mul(&of_record);
            columns.push(of_record);
        }
        let Some(information) = Cholesky::new(information) else { return Ok(None) };
        let away = DVector::from_fn(theta.len(), |i, _| (theta[i] - prior.mean[i]) / sigma[i]);
        let samples = weights.iter().map(|weights| weights.all_samples() as f64).sum();
        let mut profile = Self { solutions, weights, columns, information, away, cost: 0.0, samples };
        profile.cost = profile.of(&solutions.curves(theta)?);
        Ok(Some(profile))
    }

    /// What the sensors read with the lags and spools of another rig, `[record][sensor][row]`, SI.
    pub fn curves(&self, other: &Rig, theta: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let is_estimated = |lag: usize| self.solutions.estimated.iter().any(|one| one.parameter == lag);
        let solve = |(record, one): (usize, &Healthy<'_>)| {
            let mut parameters = self.solutions.parameters(theta, record);
            let own = (0..other.parameters.len()).filter(|&parameter| other.is_own_lag(parameter));
            for lag in other.followers().map(|follower| follower.lag).chain(own).filter(|&lag| !is_estimated(lag)) {
                parameters[lag] = other.parameters[lag].value;
            }
            let drive = InputSignals::from_record(other, one.record).ok()?;
            Some(self.solutions.model.solve(&parameters, &drive, &one.record.time).ok()?.values)
        };
        self.solutions.records.iter().enumerate().map(solve).collect()
    }

    pub fn of(&self, curves: &[Vec<Vec<f64>>]) -> f64 {
        let (squares, gradient) = self.gradient(curves, self.away.clone());
        squares - gradient.dot(&self.information.solve(&gradient))
    }

    /// What an estimated value changes of the curves by a standard deviation of what was known before, in those of the noise.
    pub fn size(&self, index: usize) -> f64 {
        self.columns.iter().map(|columns| columns.column(index).norm_squared()).sum::<f64>().sqrt()
    }

    /// Least cost with one value, SI, held elsewhere, and what all values are there; `None` where the model cannot be solved.
    pub fn held(&self, index: usize, value: f64, theta: &[f64], prior: &Gaussian) -> Option<(f64, Vec<f64>)> {
        let mut moved = theta.to_vec();
        moved[index] = value;
        let mut away = self.away.clone();
        away[index] = (value - prior.mean[index]) / prior.sigma[index];
        let (squares, gradient) = self.gradient(&self.solutions.solved(&moved).ok()?, away);
        // Of the step of all values so much is taken back along the held one's direction that it stays.
        let mut own = DVector::zeros(theta.len());
        own[index] = 1.0;
        let (all, own) = (self.information.solve(&gradient), self.information.solve(&own));
        let step = &all - &own * (all[index] / own[index]);
        for other in (0..theta.len()).filter(|&other| other != index) {
            let (low, high) = self.solutions.estimated[other].bounds;
            moved[other] = (moved[other] - step[other] * prior.sigma[other]).clamp(low, high);
        }
        Some((squares - gradient.dot(&step), moved))
    }

    /// Squares of curves whose values are so far away from what was known before, and half their gradient.
    fn gradient(&self, curves: &[Vec<Vec<f64>>], away: DVector<f64>) -> (f64, DVector<f64>) {
        let mut squares = away.norm_squared();
        let mut gradient = away;
        for (record, (curves, one)) in curves.iter().zip(self.solutions.records).enumerate() {
            let mut misfit = self::away(curves, &one.measured);
            self.weights[record].apply(&mut misfit);
            let misfit = DVector::from_vec(misfit);
            squares += misfit.norm_squared();
            gradient += self.columns[record].tr_mul(&misfit);
        }
        (squares, gradient)
    }
}

/// Weights by the noise of the sensors alone.
fn by_noise(rig: &Rig, one: &Healthy<'_>) -> Weights {
    let variance = |(sensor, measured): (&Sensor, &&[f64])| {
        measured.iter().map(|value| if value.is_nan() { f64::INFINITY } else { sensor.variance() }).collect()
    };
    let variance: Vec<Vec<f64>> = rig.sensors.iter().zip(&one.measured).map(variance).collect();
    Weights::new(rig, &[], &variance, &[])
}

/// What a model misses the records by beyond noise, as a square. `errors`: root mean squares, `[record][sensor]`, SI.
pub(super) fn missed_by(rig: &Rig, errors: &[Vec<f64>]) -> f64 {
    let each = errors.iter().flat_map(|errors| errors.iter().zip(&rig.sensors));
    beyond_noise(over_sensors(each.map(|(error, sensor)| Some(error / sensor.variance().sqrt()))))
}
