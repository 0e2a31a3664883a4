//! How spools follow their commands, as healthy records together show it.
//!
//! The weights of events forgive what mass and dead time of a spool do, and values that a record tells by its transients, such as the
//! bulk modulus, would take their place. Other dynamics are therefore asked for by the plain error, measured minus model over the
//! noise of the sensor, everything else following along its derivatives (variable projection: Golub and Pereyra, Inverse
//! Problems 19 (2003)).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::joint::{Healthy, Solutions};
use super::{first_fits, open, taken};
use crate::diagnosis::noise::Weights;
use crate::diagnosis::problem::{away, over_sensors};
use crate::diagnosis::switching::{self as spools, DYNAMICS, Open, beyond_noise};
use crate::estimation::Gaussian;
use crate::estimation::criteria::bic;
use crate::model::{InputSignals, Model, SimulationError};
use crate::rig::{Rig, Sensor};

/// The rig of the model with spools that follow as the records show, and the fit with them; `None` where they may be as stated, or the
/// model cannot be solved with others. They are believed where they take away most of what the model misses beyond noise.
pub(super) fn with_other_spools(solutions: &Solutions<'_>, prior: &Gaussian, theta: &[f64]) -> Option<(Rig, Vec<f64>)> {
    let stated = &solutions.model.rig;
    // The search costs a linearisation, which a rig without spools has no use for.
    stated.followers().find(|follower| stated.is_alone(follower))?;
    stated.context().stage("how spools follow");
    let missed = missed_by(stated, &solutions.errors(theta).ok()?);
    let found = followed(stated, (solutions, theta, missed), prior, stated.settings().calibration.dynamics_rounds)?;
    (found.missed < stated.settings().diagnosis.dynamics_left_share * missed).then_some((found.rig, found.theta))
}

/// A fit with other spools.
struct Found {
    rig: Rig,
    theta: Vec<f64>,
    /// Beyond noise.
    missed: f64,
}

/// From a fit and what it misses beyond noise: the best of so many rounds of search and fit.
fn followed(
    stated: &Rig,
    (solutions, theta, missed): (&Solutions<'_>, &[f64], f64),
    prior: &Gaussian,
    rounds: usize,
) -> Option<Found> {
    let rounds = rounds.checked_sub(1)?;
    let rig = searched(stated, solutions, prior, theta)?;
    let model = Model::new(rig);
    let taken = taken(&model.rig, solutions.records.iter().map(|one| one.record)).ok()?;
    let other = Solutions::new(&model, &taken, open(&model.rig));
    let theta = first_fits(&other, prior, theta, &[stated.settings().calibration.search_reach; 3]).ok()?;
    let reached = missed_by(&model.rig, &other.errors(&theta).ok()?);
    if reached >= missed {
        return None;
    }
    let further = followed(stated, (&other, &theta, reached), prior, rounds);
    drop(other);
    Some(further.unwrap_or_else(|| Found { rig: model.rig, theta, missed: reached }))
}

/// The rig of the model with the spools with which it would miss the records by least; `None` where those that it has are as good.
fn searched(stated: &Rig, solutions: &Solutions<'_>, prior: &Gaussian, theta: &[f64]) -> Option<Rig> {
    let rig = &solutions.model.rig;
    let profile = Profile::at(solutions, prior, theta).ok()??;
    let fall = |other: &Rig| {
        let fall = profile.cost - profile.of(&profile.curves(other, theta)?);
        fall.is_finite().then_some(fall)
    };
    let excess = profile.cost - profile.samples;
    let worth = |gain: f64| {
        gain > stated.settings().diagnosis.dynamics_gain_share * excess && bic(-gain, DYNAMICS, profile.samples) < 0.0
    };
    Some(spools::searched(stated, rig, &fall, worth, Open::All)?.0)
}

/// Least cost of other curves, in squares of the sensors' noise, with everything estimated following along its derivatives.
struct Profile<'s, 'a> {
    solutions: &'s Solutions<'a>,
    /// One per record: noise alone.
    weights: Vec<Weights>,
    /// One per record: weighted derivatives by what is estimated, in standard deviations of what was known before.
    columns: Vec<DMatrix<f64>>,
    information: Cholesky<f64, Dyn>,
    /// How far the estimate is from what was known before, in its standard deviations.
    away: DVector<f64>,
    /// Of the curves at hand.
    cost: f64,
    samples: f64,
}

impl<'s, 'a> Profile<'s, 'a> {
    fn at(solutions: &'s Solutions<'a>, prior: &Gaussian, theta: &[f64]) -> Result<Option<Self>, SimulationError> {
        let rig = &solutions.model.rig;
        let weights: Vec<Weights> = solutions.records.iter().map(|one| by_noise(rig, one)).collect();
        let sigma = DVector::from_column_slice(&prior.sigma);
        let mut information = DMatrix::identity(theta.len(), theta.len());
        let mut columns = Vec::new();
        for (record, weights) in weights.iter().enumerate() {
            let mut of_record = solutions.columns(theta, record)?;
            for (mut column, sigma) in of_record.column_iter_mut().zip(sigma.iter()) {
                column *= *sigma;
                weights.apply(column.as_mut_slice());
            }
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

    /// What the sensors read with the spools of another rig, `[record][sensor][row]`, SI.
    fn curves(&self, other: &Rig, theta: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let is_estimated = |lag: usize| self.solutions.estimated.iter().any(|one| one.parameter == lag);
        let solve = |(record, one): (usize, &Healthy<'_>)| {
            let mut parameters = self.solutions.parameters(theta, record);
            for lag in other.followers().map(|follower| follower.lag).filter(|&lag| !is_estimated(lag)) {
                parameters[lag] = other.parameters[lag].value;
            }
            let drive = InputSignals::from_record(other, one.record).ok()?;
            Some(self.solutions.model.solve(&parameters, &drive, &one.record.time).ok()?.values)
        };
        self.solutions.records.iter().enumerate().map(solve).collect()
    }

    fn of(&self, curves: &[Vec<Vec<f64>>]) -> f64 {
        let mut squares = self.away.norm_squared();
        let mut gradient = self.away.clone();
        for (record, (curves, one)) in curves.iter().zip(self.solutions.records).enumerate() {
            let mut misfit = away(curves, &one.measured);
            self.weights[record].apply(&mut misfit);
            let misfit = DVector::from_vec(misfit);
            squares += misfit.norm_squared();
            gradient += self.columns[record].tr_mul(&misfit);
        }
        squares - gradient.dot(&self.information.solve(&gradient))
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
fn missed_by(rig: &Rig, errors: &[Vec<f64>]) -> f64 {
    let each = errors.iter().flat_map(|errors| errors.iter().zip(&rig.sensors));
    beyond_noise(over_sensors(each.map(|(error, sensor)| Some(error / sensor.variance().sqrt()))))
}
