//! Identification: the interval that a record leaves one fault, whatever everything else does.
//!
//! The intervals are those of [`crate::estimation::profile`], each with the faults of the best set free too.

use rayon::prelude::*;

use super::case::{Case, EXACT};
use super::hypotheses::Isolation;
use crate::estimation::profile::{QUANTILE, RISE};
use crate::estimation::{End, Fit, Interval, LocalModel, Options, ProfilePoint, Side, interval as profile};
use crate::rig::FaultSet;

/// A set of this probability is as good as open.
const OPEN: f64 = 0.05;
/// Steps of a fit along one local model.
const STEPS: u64 = 6;
/// A fit that a relinearisation would lower by less is at its end.
const ENOUGH: f64 = 0.1;
/// Most relinearisations of the fit that an interval is drawn around.
const MOST_RELINEARISATIONS: usize = 2;
/// Points of a profile that is known in full, and how far it is drawn, in standard errors.
const DRAWN: (usize, f64) = (21, 3.0);

/// Adds what no record determines, one standard deviation, SI.
fn widen(interval: &mut Interval, sigma: f64, (low, high): (f64, f64)) {
    let further = |end: f64| (end - interval.value).hypot(QUANTILE * sigma);
    if let Some(end) = interval.lower.end {
        interval.lower.end = Some((interval.value - further(end)).max(low));
    }
    if let Some(end) = interval.upper.end {
        interval.upper.end = Some((interval.value + further(end)).min(high));
    }
    interval.sigma = interval.sigma.map(|own| own.hypot(sigma));
}

/// A set of faults fitted for an interval: its best point, with the local model there.
struct Base {
    best: Fit,
    /// Where it was taken again.
    local: Option<LocalModel>,
}

impl Base {
    /// Fits `set` from where the search ended; `None` where the model cannot be solved.
    fn new(case: &Case<'_>, isolation: &Isolation, set: FaultSet) -> Option<Self> {
        let from = |near: &LocalModel, theta: &[f64]| case.fit(near, set, theta, Options::steps(STEPS, EXACT)).ok();
        let mut best = from(&isolation.local, &isolation.best.theta)?;
        let mut local = None;
        for _ in 0..MOST_RELINEARISATIONS {
            if best.promised < ENOUGH {
                break;
            }
            // From afar: the steps that are left need a Jacobian of their own.
            let fresh = case.local_model(&best.theta).ok()?;
            best = from(&fresh, &best.theta)?;
            local = Some(fresh);
        }
        Some(Self { best, local })
    }
}

/// The intervals of all faults, each with those of the best set free too; where other sets are as good as open, each
/// interval holds what they say too.
pub fn intervals(case: &Case<'_>, isolation: &Isolation) -> Vec<Option<Interval>> {
    let count = case.rig().context().count("intervals of the faults", case.faults());
    let one = |fault| {
        case.rig().context().check().ok()?;
        let interval = interval(case, isolation, fault);
        count.one();
        interval
    };
    let mut intervals: Vec<_> = (0..case.faults()).into_par_iter().map(one).collect();
    for (fault, interval) in case.rig().faults.iter().zip(&mut intervals) {
        if let Some(interval) = interval {
            widen(interval, case.rig().never_known(fault), fault.bounds);
        }
    }
    for (other, probability) in isolation.weighed.iter().zip(isolation.probabilities()) {
        let Some(point) = other.point.as_ref().filter(|_| probability >= OPEN && other.set != isolation.set()) else {
            continue;
        };
        for fault in other.set.iter() {
            let Some(interval) = &mut intervals[fault] else { continue };
            let sigma = isolation
                .schur
                .sigma(other.set.iter(), fault)
                .map(|sigma| sigma * isolation.local.scale[fault] * isolation.inflation[fault].sqrt());
            let Some(sigma) = sigma else { continue };
            let value = point.theta[fault];
            let sigma = sigma.hypot(case.rig().never_known(&case.rig().faults[fault]));
            if let Some(end) = &mut interval.lower.end {
                *end = end.min(value - QUANTILE * sigma);
            }
            if let Some(end) = &mut interval.upper.end {
                *end = end.max(value + QUANTILE * sigma);
            }
        }
    }
    intervals
}

/// The interval of `fault` while those of the best set are free too.
fn interval(case: &Case<'_>, isolation: &Isolation, fault: usize) -> Option<Interval> {
    let set = isolation.set().with(fault);
    if case.is_of_sensor(fault) {
        return straight(case, isolation, set, fault);
    }
    let Base { best, local } = Base::new(case, isolation, set)?;
    let near = local.as_ref().unwrap_or(&isolation.local);
    let direction = case.information(near, set).ok()?.direction(fault)?;
    let problem = case.problem(set);
    let inflation = near.inflation_along(&problem, &direction, &best.misfit, &case.full.series());
    Some(profile(&problem, near, &best, fault, direction, inflation))
}

/// The interval of an offset or a gain: readings follow it in a straight line, so the local quadratic model is the profile.
fn straight(case: &Case<'_>, isolation: &Isolation, set: FaultSet, fault: usize) -> Option<Interval> {
    let (near, best) = (&isolation.local, &isolation.best);
    let direction = case.information(near, set).ok()?.direction(fault)?;
    let problem = case.problem(set);
    let inflation = near.inflation_along(&problem, &direction, &best.misfit, &case.full.series());
    let sigma = (direction[fault] * inflation).sqrt() * near.scale[fault];
    // One step along the model from the best of all sets: where this fault is not in it, it stands at its healthy value.
    let gradient = near.gradient_of(&problem, &best.theta, &best.misfit);
    let step = -direction.dot(&gradient) * near.scale[fault];
    let (low, high) = case.rig().faults[fault].bounds;
    let value = (best.theta[fault] + step).clamp(low, high);
    let side = |end: f64, bound: f64| {
        if (low..=high).contains(&end) {
            Side { end: Some(end), why: End::Crossed, rise: RISE * inflation }
        } else {
            Side { end: None, why: End::BoundReached, rise: ((bound - value) / sigma).powi(2) * inflation }
        }
    };
    let (lower, upper) = (side(value - QUANTILE * sigma, low), side(value + QUANTILE * sigma, high));
    let known = sigma.is_finite() && sigma < high - low;
    let at = |held: f64| ProfilePoint { value: held, rise: ((held - value) / sigma).powi(2) * inflation };
    let step = |k: usize| value + DRAWN.1 * sigma * (2.0 * k as f64 / (DRAWN.0 - 1) as f64 - 1.0);
    let points: Vec<ProfilePoint> =
        (0..DRAWN.0).map(step).filter(|value| (low..=high).contains(value)).map(at).collect();
    Some(Interval {
        value,
        sigma: known.then_some(sigma),
        lower,
        upper,
        threshold: RISE * inflation,
        points,
        better: None,
    })
}
