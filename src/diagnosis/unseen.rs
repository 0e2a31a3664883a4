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
use crate::estimation::{Fit, Options, Problem};
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
    let odds = prior_odds(case);
    for (_, other, mut theta) in screened.into_iter().take(case.settings().replacements_fitted) {
        for _ in 0..case.settings().replacement_linearisations {
            let near = case.local_model(&theta).ok()?;
            let Ok(fit) = case.fit(
                &near,
                other,
                &theta,
                Options::steps(case.settings().replacement_linearisations, case.settings().rough_decrease),
            ) else {
                break;
            };
            let inflation = inflation_between(other, set, &isolation.inflation);
            let occam = case.schur_complement(&near).occam(other.iter(), 1.0) - isolation.schur.occam(set.iter(), 1.0);
            let fewer = odds * (other.len() as f64 - set.len() as f64);
            if -0.5 * (fit.cost - fit.promised - point.cost) / inflation + occam + fewer > 0.0 {
                return Some((other, fit));
            }
            theta = fit.theta;
        }
    }
    None
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
    let mut theta = case.as_expected(&point.theta);
    let misfit = case.full.misfit(&theta).ok()?;
    if local.foresees(at(&point.theta, &point.misfit), at(&theta, &misfit), case.settings().unforeseen_share) {
        return None;
    }
    let set = isolation.set();
    for _ in 0..case.settings().replacement_linearisations {
        let near = case.local_model(&theta).ok()?;
        let fit = case
            .fit(
                &near,
                set,
                &theta,
                Options::steps(case.settings().replacement_linearisations, case.settings().rough_decrease),
            )
            .ok()?;
        if fit.cost < point.cost - case.settings().elsewhere_decrease {
            return Some((set, fit));
        }
        theta = fit.theta;
    }
    None
}

/// A better set than the best so far, with one fault more, that its quadratic form does not promise.
pub fn unseen(case: &Case<'_>, isolation: &Isolation) -> Option<(FaultSet, Fit)> {
    let odds = prior_odds(case);
    let Isolation { local, schur, best: point, inflation, .. } = isolation;
    let set = isolation.set();
    let others = (0..case.faults()).filter(|&fault| !set.contains(fault) && !case.is_of_sensor(fault));
    let probes = others.flat_map(|fault| case.levels(fault, &PROBES).map(move |value| (fault, value)));
    let gain = |(fault, value): (usize, f64)| {
        let mut theta = point.theta.clone();
        theta[fault] = value;
        let misfit = case.full.misfit(&theta).ok()?;
        if local.foresees(at(&point.theta, &point.misfit), at(&theta, &misfit), case.settings().unforeseen_share) {
            return None;
        }
        let more = set.with(fault);
        let held = Holding { parameter: fault, value };
        let near = case.fit_held(local, more, held, &theta, Options::steps(1, case.settings().rough_decrease)).ok()?;
        // The best value along the way is not known yet, so what the fault costs is taken at its cheapest.
        let gain = 0.5 * (point.cost - near.cost + near.promised) / inflation[fault] + odds;
        let price = schur.occam([fault].into_iter(), 1.0).min(0.0);
        (gain + price.max(-3.0) > 0.0).then_some((gain, more, near))
    };
    let gains: Vec<(f64, FaultSet, Fit)> = probes.collect::<Vec<_>>().into_par_iter().filter_map(gain).collect();
    let best = gains.into_iter().reduce(|best, next| if next.0 > best.0 { next } else { best });
    best.map(|(_, set, point)| (set, point))
}

fn at<'a>(theta: &'a [f64], misfit: &'a [f64]) -> Evaluated<'a> {
    Evaluated { theta, misfit }
}
