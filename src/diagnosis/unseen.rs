//! What the quadratic form at the best explanation cannot see: laws that bend.
//!
//! Seen from the healthy rig a clearance leaks nothing to first order, and a throttle that is half shut does nothing. What such a
//! fault does is then told by others that act in a straight line, above all by offset and gain of one sensor together, which
//! make a bend of any slope. So the faults of components are tried where they would act.

use rayon::prelude::*;

use super::case::{Case, Holding};
use super::hypotheses::Isolation;
use super::weighing::{inflation_between, prior_odds};
use crate::estimation::criteria::bic;
use crate::estimation::local_model::Evaluated;
use crate::estimation::{Fit, LocalModel, Options, Problem};
use crate::rig::FaultSet;

/// Shares of the way to a bound at which a fault is tried that the form may not see: a clearance leaks with its cube.
const PROBES: [f64; 2] = [0.08, 0.35];
/// Levels at which a fault is tried in place of others, as shares of the way to a bound.
const LEVELS: [f64; 4] = [0.1, 0.25, 0.45, 0.7];

/// A fault of a component that explains the record better than several of the best set do, or one of two that are of the same
/// sensor.
pub fn simpler(case: &Case<'_>, isolation: &Isolation) -> Option<(FaultSet, Fit)> {
    let (set, point) = (isolation.set(), &isolation.best);
    let samples = case.full.weights.all_samples() as f64;
    let mut tried: Vec<(FaultSet, usize)> = Vec::new();
    for part in replaceable(case, set) {
        let components = (0..case.faults()).filter(|&fault| !set.contains(fault) && !case.is_of_sensor(fault));
        tried.extend(components.map(|fault| (set.difference(part), fault)));
    }
    let at_its_best_level = |(kept, fault): (FaultSet, usize)| {
        let other = kept.with(fault);
        let levels = case.levels(fault, &LEVELS).filter_map(|at| {
            let start = case.without_others(&point.theta, kept);
            let held = Holding { parameter: fault, value: at };
            let near = case
                .fit_held(&isolation.local, other, held, &start, Options::steps(1, case.settings().rough_decrease))
                .ok()?;
            Some((bic(near.cost, other.len(), samples), other, near.theta))
        });
        levels.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let mut screened: Vec<(f64, FaultSet, Vec<f64>)> = tried.into_par_iter().filter_map(at_its_best_level).collect();
    screened.sort_by(|a, b| a.0.total_cmp(&b.0));
    let most = case.settings().replacements_fitted;
    screened
        .into_iter()
        .take(most)
        .find_map(|(_, other, theta)| Some((other, overtaking(case, isolation, other, &theta)?)))
}

/// The fit of another set, from values of all estimated parameters, where it explains the record better than the best so far.
fn overtaking(case: &Case<'_>, isolation: &Isolation, other: FaultSet, theta: &[f64]) -> Option<Fit> {
    let is_better =
        |(near, fit): &(LocalModel, Fit)| gained(case, isolation, (other, near), fit.cost - fit.promised) > 0.0;
    replaced(case, other, theta).find(is_better).map(|(_, fit)| fit)
}

/// Fits of a set that stands in for the best one.
fn replaced<'s>(case: &'s Case<'_>, set: FaultSet, theta: &[f64]) -> impl Iterator<Item = (LocalModel, Fit)> + use<'s> {
    let most = case.settings().replacement_linearisations;
    case.relinearised(set, theta, Options::steps(most as u64, case.settings().rough_decrease)).take(most)
}

/// Logarithm of the evidence of another set over that of the best, where it leaves a cost near a local model of its own.
pub(super) fn gained(case: &Case<'_>, isolation: &Isolation, (other, near): (FaultSet, &LocalModel), cost: f64) -> f64 {
    let set = isolation.set();
    let inflation = inflation_between(other, set, &isolation.compared);
    let occam = case.schur_complement(near).occam(other.iter(), 1.0) - isolation.schur.occam(set.iter(), 1.0);
    let more = prior_odds(case) * (other.len() as f64 - set.len() as f64);
    -0.5 * (cost - isolation.best.cost) / inflation + occam + more
}

/// Faults of a set in whose place one of a component may stand: all of them; of a sensor with both, offset, gain, or the two.
fn replaceable(case: &Case<'_>, set: FaultSet) -> Vec<FaultSet> {
    let mut parts = Vec::new();
    if set.len() > 1 {
        parts.push(set);
    }
    for sensor in &case.rig().sensors {
        let own = |fault: &usize| sensor.owns(case.rig().faults[*fault].parameter);
        let own: Vec<FaultSet> = set.iter().filter(own).map(FaultSet::of).collect();
        if let [offset, gain] = own[..] {
            parts.extend([offset.union(gain), offset, gain]);
        }
    }
    parts.dedup();
    parts
}

/// The same set, explained better from what is expected of everything uncertain: oil that rings is in step with the record at
/// several bulk moduli, and a fit ends at the nearest.
pub fn in_step(case: &Case<'_>, isolation: &Isolation) -> Option<(FaultSet, Fit)> {
    let Isolation { local, best: point, .. } = isolation;
    let theta = case.as_expected(&point.theta);
    let misfit = case.full.misfit(&theta).ok()?;
    if local.foresees(at(&point.theta, &point.misfit), at(&theta, &misfit), case.settings().unforeseen_share) {
        return None;
    }
    let is_lower = |(_, fit): &(LocalModel, Fit)| fit.cost < point.cost - case.settings().elsewhere_decrease;
    let (_, fit) = replaced(case, isolation.set(), &theta).find(is_lower)?;
    Some((isolation.set(), fit))
}

/// A better set than the best so far, with one fault more, that its quadratic form does not promise. The form is asked for what the
/// fault does at a probe, at any size of it: a record that shows a fault smaller than the probe shows the same in small.
pub fn unseen(case: &Case<'_>, isolation: &Isolation) -> Option<(FaultSet, Fit)> {
    let odds = prior_odds(case);
    let Isolation { local, best: point, compared, .. } = isolation;
    let set = isolation.set();
    let test = local.score_test(&case.problem(set), &point.theta, &point.misfit).ok()?;
    let others = (0..case.faults()).filter(|&fault| !set.contains(fault) && !case.is_of_sensor(fault));
    let probes = others.flat_map(|fault| case.levels(fault, &PROBES).map(move |value| (fault, value)));
    let gain = |(fault, value): (usize, f64)| {
        let mut theta = point.theta.clone();
        theta[fault] = value;
        let misfit = case.full.misfit(&theta).ok()?;
        if local.foresees(at(&point.theta, &point.misfit), at(&theta, &misfit), case.settings().unforeseen_share) {
            return None;
        }
        let change: Vec<f64> = misfit.iter().zip(&point.misfit).map(|(there, here)| there - here).collect();
        let score = test.of(&change);
        let gain = 0.5 * score.fall_at(score.factor.max(0.0)) / compared[fault] + odds;
        (gain > 0.0).then_some((gain, set.with(fault), theta))
    };
    let mut gains: Vec<(f64, FaultSet, Vec<f64>)> =
        probes.collect::<Vec<_>>().into_par_iter().filter_map(gain).collect();
    gains.sort_by(|a, b| b.0.total_cmp(&a.0));
    let most = case.settings().replacements_fitted;
    gains.into_iter().take(most).find_map(|(_, more, theta)| Some((more, overtaking(case, isolation, more, &theta)?)))
}

fn at<'a>(theta: &'a [f64], misfit: &'a [f64]) -> Evaluated<'a> {
    Evaluated { theta, misfit }
}
