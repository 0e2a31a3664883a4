//! The fits before noise and tolerance are known, which find the valley.

use super::joint::{Healthy, Joint, Solutions};
use crate::diagnosis::noise::{Weights, phases, variances};
use crate::estimation::{FitError, Gaussian, Loss, Options as Steps};
use crate::residual::settling;
use crate::rig::Rig;

/// How far each of the fits before the first round may go, in standard deviations of the data sheet: the box widens slowly,
/// because far steps over bent laws may end in another valley.
pub(super) const FIRST: [f64; 10] = [0.7, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 5.0, 5.0];

/// The fits before noise and tolerance are known, each within so many standard deviations of the data sheet, as long as they gain: the last
/// one and its cost.
pub(super) fn first_fits(
    solutions: &Solutions<'_>,
    prior: &Gaussian,
    start: &[f64],
    reaches: &[f64],
) -> Result<(Vec<f64>, f64), FitError> {
    let rig = &solutions.model.rig;
    let rough: Vec<Weights> = solutions.records.iter().map(|one| rough(rig, one)).collect();
    let (mut theta, mut cost) = (start.to_vec(), f64::INFINITY);
    let count = rig.context().count("first fits, at most", reaches.len());
    for &reach in reaches {
        let mut joint = Joint::new(solutions, rough.clone(), prior)
            .robust(&theta, Loss::SoftL1 { k: rig.settings().calibration.first_loss_width })?;
        joint.confine(reach);
        let fit = joint.fit(&theta, ends(rig))?;
        count.one();
        let gained = cost - fit.cost;
        (theta, cost) = (fit.theta, fit.cost);
        if gained.abs() < rig.settings().calibration.first_decrease * cost {
            break;
        }
    }
    Ok((theta, cost))
}

/// Where a fit of a round, or before the first, stops.
pub(super) fn ends(rig: &Rig) -> Steps {
    let settings = &rig.settings().calibration;
    Steps { function: settings.decrease, ..Steps::steps(settings.iterations, 0.0) }
}

/// Weights before anything has been fitted.
fn rough(rig: &Rig, one: &Healthy<'_>) -> Weights {
    let mut variance = variances(rig, one.record, &one.measured, true);
    let phases = phases(rig, &one.drive, &one.record.time, &variance);
    unsettled(rig, one, &mut variance);
    Weights::new(rig, &phases, &variance, &[])
}

/// Takes the weight from the samples behind each jump of an input until the lags have settled. Small physics that the model
/// left out is largest there, and thousands of precise samples would force it upon parameters that nothing else tells.
pub(super) fn unsettled(rig: &Rig, one: &Healthy<'_>, variance: &mut [Vec<f64>]) {
    /// As good as no sample.
    const NOTHING: f64 = 1e6;
    let settling = settling(rig);
    let time = &one.record.time;
    for jump in one.drive.pieces.iter().filter(|piece| piece.jump) {
        let from = time.partition_point(|&t| t <= jump.start);
        let to = time.partition_point(|&t| t <= jump.start + settling);
        variance.iter_mut().for_each(|sensor| sensor[from..to].iter_mut().for_each(|variance| *variance *= NOTHING));
    }
}
