//! Mean lags of parts that follow pressures, as healthy records together show them: of relief valves, of the regulators of pumps.
//!
//! Such a lag may be another in each switching, and weights forgive that within each phase. What a mean lag other than stated does to a
//! body lasts beyond its phase: the zero and gain of its position sensor would take up the error.

use super::first_fits::{FIRST, first_fits};
use super::joint::Solutions;
use super::plain_error::Profile;
use super::{estimated, prior};
use crate::diagnosis::switching::applied;
use crate::estimation::Gaussian;
use crate::estimation::criteria::bic;

/// Other mean lags.
pub(super) struct Found {
    /// By their indices, with their values, SI.
    pub lags: Vec<(usize, f64)>,
    /// The fit with them, of what all calibrations fit.
    pub theta: Vec<f64>,
}

/// Mean lags other than stated; `None` where they may be as stated. Asked for by the plain error, they are believed where the fit with
/// them is better by more than their number.
pub(super) fn other_lags(solutions: &Solutions<'_>, prior: &Gaussian, (theta, cost): (&[f64], f64)) -> Option<Found> {
    let rig = &solutions.model.rig;
    let lags: Vec<usize> = (0..rig.parameters.len()).filter(|&parameter| rig.is_own_lag(parameter)).collect();
    if lags.is_empty() {
        return None;
    }
    rig.context().stage("mean lags");
    let samples = is_worth_it(solutions, prior, theta, &lags)?;
    let with_lags = Solutions::new(solutions.model, solutions.records, estimated(rig, &lags));
    // From the data sheet: wrong lags may have led the first fits into another valley.
    let own = self::prior(rig, &with_lags.estimated);
    let (found, reached) = first_fits(&with_lags, &own, &own.mean, &FIRST).ok()?;
    if bic(reached, lags.len(), samples) >= cost {
        return None;
    }
    let pairs = || with_lags.estimated.iter().zip(&found);
    let (of_lags, others): (Vec<_>, Vec<_>) = pairs().partition(|(one, _)| lags.contains(&one.parameter));
    let values = of_lags.into_iter().map(|(one, &value)| (one.parameter, value)).collect();
    Some(Found { lags: values, theta: others.into_iter().map(|(_, &value)| value).collect() })
}

/// Whether any of the lags by itself takes a share of what is beyond noise, by the parabola through the costs at one standard deviation
/// to both sides; the number of samples.
fn is_worth_it(solutions: &Solutions<'_>, prior: &Gaussian, theta: &[f64], lags: &[usize]) -> Option<f64> {
    let rig = &solutions.model.rig;
    let profile = Profile::at(solutions, prior, theta).ok()??;
    let rise = |lag: usize, factor: f64| {
        let value = rig.parameters[lag].value + factor * rig.parameters[lag].sigma;
        Some(profile.of(&profile.curves(&applied(rig, &[(lag, value)]), theta)?) - profile.cost)
    };
    let fall = |&lag: &usize| {
        let (below, above) = (rise(lag, -1.0)?, rise(lag, 1.0)?);
        let (slope, bend) = (0.5 * (above - below), above + below);
        Some(if bend > 0.0 { 0.5 * slope * slope / bend } else { -below.min(above) })
    };
    let most = lags.iter().filter_map(fall).filter(|fall| fall.is_finite()).fold(f64::NEG_INFINITY, f64::max);
    let share = rig.settings().diagnosis.dynamics_gain_share * (profile.cost - profile.samples);
    (most > share && bic(-most, lags.len(), profile.samples) < 0.0).then_some(profile.samples)
}
