//! Mean lags of parts as healthy records together show them: of relief valves, of the regulators of pumps, of valves of formulas; and
//! dead times of inputs that the rig file states as uncertain.
//!
//! Such a lag may be another in each switching, and weights forgive that within each phase. What a mean lag other than stated does to a
//! body lasts beyond its phase: the zero and gain of its position sensor would take up the error, and what it leaves in a closed line the
//! volume of that line. They are asked for behind the first fits, and again where the rounds have ended: until then values that are still
//! off hide what lags do.

use super::first_fits::{FIRST, first_fits};
use super::joint::Solutions;
use super::plain_error::Profile;
use super::{estimated, prior};
use crate::diagnosis::switching::{applied, patience};
use crate::estimation::Gaussian;
use crate::estimation::criteria::bic;
use crate::estimation::pattern::pattern_search;
use crate::rig::Rig;

/// What may have another mean lag or dead time: by index, with the values that a rig has, SI. An input whose one part has a dead time of
/// its own has none beside it: that is asked for with the part's lag and mass.
pub(super) fn of(rig: &Rig) -> Vec<(usize, f64)> {
    let has_its_own = |input: usize| {
        rig.followers().any(|part| part.input == input && part.dead_time.is_some() && rig.is_alone(&part))
    };
    let inputs = rig.inputs.iter().enumerate().filter(|&(input, _)| !has_its_own(input));
    let dead_times = inputs.filter_map(|(_, input)| input.dead_time).filter(|&own| rig.parameters[own].varies());
    let own = own(rig).chain(dead_times);
    own.map(|lag| (lag, rig.parameters[lag].value)).collect()
}

/// What may have another mean lag.
fn own(rig: &Rig) -> impl Iterator<Item = usize> + '_ {
    (0..rig.parameters.len()).filter(|&parameter| rig.is_own_lag(parameter))
}

/// Other mean lags.
pub(super) struct Found {
    /// By their indices, with their values, SI.
    pub lags: Vec<(usize, f64)>,
    /// The fit with them, of what all calibrations fit.
    pub theta: Vec<f64>,
}

/// Mean lags other than stated; `None` where they may be as stated. Asked for by the plain error, they are believed where the fit with
/// them is better by more than their number. Dead times of inputs that switch are asked for at the
/// end alone.
pub(super) fn other_lags(solutions: &Solutions<'_>, prior: &Gaussian, (theta, cost): (&[f64], f64)) -> Option<Found> {
    let rig = &solutions.model.rig;
    let lags: Vec<usize> = own(rig).collect();
    if lags.is_empty() {
        return None;
    }
    rig.context().stage("mean lags");
    let profile = Profile::at(solutions, prior, theta).ok()??;
    if !is_worth_it(&profile, theta, &lags) {
        return None;
    }
    let with_lags = Solutions::new(solutions.model, solutions.records, estimated(rig, &lags));
    // From the data sheet: wrong lags may have led the first fits into another valley.
    let own = self::prior(rig, &with_lags.estimated);
    let (found, reached) = first_fits(&with_lags, &own, &own.mean, &FIRST).ok()?;
    if bic(reached, lags.len(), profile.samples) >= cost {
        return None;
    }
    let pairs = || with_lags.estimated.iter().zip(&found);
    let (of_lags, others): (Vec<_>, Vec<_>) = pairs().partition(|(one, _)| lags.contains(&one.parameter));
    let values = of_lags.into_iter().map(|(one, &value)| (one.parameter, value)).collect();
    Some(Found { lags: values, theta: others.into_iter().map(|(_, &value)| value).collect() })
}

/// Mean lags asked for where a fit has ended.
pub(super) struct Asked {
    /// Least plain error with the lags that the fit has, in squares of the sensors' noise, what was known before of all values included.
    pub cost: f64,
    /// Others, by index, with their values, SI, with which it would be less by more than their number; `None` where none are.
    pub better: Option<Vec<(usize, f64)>>,
}

/// Asks for them by the plain error, everything estimated following. `stated`: by index, with the values of the data sheet, SI. Where all
/// are as stated one of them has to be worth it, as behind the first fits.
///
/// The weights of the first fits have nothing left of what a lag does behind a jump, and values that are still off bend it to serve them.
pub(super) fn again(
    solutions: &Solutions<'_>,
    prior: &Gaussian,
    theta: &[f64],
    stated: &[(usize, f64)],
) -> Option<Asked> {
    let rig = &solutions.model.rig;
    if stated.is_empty() {
        return None;
    }
    rig.context().stage("mean lags and dead times");
    let at_hand: Vec<(usize, f64)> = stated.iter().map(|&(lag, _)| (lag, rig.parameters[lag].value)).collect();
    let profile = Profile::at(solutions, prior, theta).ok()??;
    let lags: Vec<usize> = stated.iter().map(|&(lag, _)| lag).collect();
    if at_hand == stated && !is_worth_it(&profile, theta, &lags) {
        return None;
    }
    let cost = |lags: &[(usize, f64)]| {
        let pairs = lags.iter().zip(stated);
        let away = pairs.map(|(&(lag, value), &(_, mean))| ((value - mean) / rig.parameters[lag].sigma).powi(2));
        let cost = profile.of(&profile.curves(&applied(rig, lags), theta)?) + away.sum::<f64>();
        cost.is_finite().then_some(cost)
    };
    let as_fitted = cost(&at_hand)?;
    let (best, least) = searched(rig, stated, (at_hand, as_fitted), &cost);
    let is_better = bic(least - as_fitted, stated.len(), profile.samples) < 0.0;
    Some(Asked { cost: as_fitted, better: is_better.then_some(best) })
}

/// Lags of least cost, from some at hand with theirs: one after the other by a standard deviation, and by half where none of it leads on.
fn searched(
    rig: &Rig,
    stated: &[(usize, f64)],
    at_hand: (Vec<(usize, f64)>, f64),
    cost: &(impl Fn(&[(usize, f64)]) -> Option<f64> + Sync),
) -> (Vec<(usize, f64)>, f64) {
    let lags: Vec<usize> = stated.iter().map(|&(lag, _)| lag).collect();
    let open = estimated(&applied(rig, stated), &lags);
    let ways: Vec<(usize, (f64, f64))> = (0..lags.len())
        .filter_map(|of| Some((of, open.iter().find(|one| one.parameter == lags[of])?.bounds)))
        .collect();
    let around = |best: &Vec<(usize, f64)>, share: f64| {
        let to = |&(of, (low, high)): &(usize, (f64, f64)), step: f64| {
            let mut lags = best.clone();
            let (lag, value) = &mut lags[of];
            *value = (*value + step * rig.parameters[*lag].sigma).clamp(low, high);
            lags
        };
        ways.iter().flat_map(|way| [-share, share].map(|step| to(way, step))).collect()
    };
    pattern_search(at_hand, patience(rig), around, |lags: &Vec<(usize, f64)>| cost(lags))
}

/// Whether any of the lags by itself takes a share of what is beyond noise, by the parabola through the costs at one standard deviation
/// to both sides, or as far as it may go.
fn is_worth_it(profile: &Profile<'_, '_>, theta: &[f64], lags: &[usize]) -> bool {
    let rig = &profile.solutions.model.rig;
    let rise = |lag: usize, away: f64| {
        let value = rig.parameters[lag].value + away;
        Some(profile.of(&profile.curves(&applied(rig, &[(lag, value)]), theta)?) - profile.cost)
    };
    let fall = |&lag: &usize| {
        let parameter = &rig.parameters[lag];
        let (down, up) = (parameter.sigma.min(parameter.value - parameter.bounds.0), parameter.sigma);
        let above = rise(lag, up)?;
        if down <= 0.0 {
            return Some(-above);
        }
        let below = rise(lag, -down)?;
        let bend = 2.0 * (below / down + above / up) / (down + up);
        let slope = above / up - 0.5 * bend * up;
        Some(if bend > 0.0 { 0.5 * slope * slope / bend } else { -below.min(above) })
    };
    let most = lags.iter().filter_map(fall).filter(|fall| fall.is_finite()).fold(f64::NEG_INFINITY, f64::max);
    let share = rig.settings().diagnosis.dynamics_gain_share * (profile.cost - profile.samples);
    most > share && bic(-most, lags.len(), profile.samples) < 0.0
}
