//! Identification: the interval that a record leaves one fault, whatever everything else does.
//!
//! The intervals are those of [`crate::estimation::profile`], each with the faults of the best set free too. Where nothing explains
//! the record they are those of the local quadratic model: what is left is no noise, so that a profile says no more, and an optimum
//! nearby that is a little lower no better.

use nalgebra::DVector;
use rayon::prelude::*;

use super::case::Case;
use super::estimate::Estimate;
use super::hypotheses::Isolation;
use super::weighing::prior_odds;
use crate::estimation::profile::{QUANTILE, RISE};
use crate::estimation::{
    End, Fit, Interval, LocalModel, Options, ProfilePoint, Side, interval as profile, interval_from_bound,
};
use crate::rig::FaultSet;

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
        let best = fitted(case, &isolation.local, set, &isolation.best.theta)?;
        let base = Self { best, local: None };
        // From afar: the steps that are left need a Jacobian of their own.
        if base.best.promised < case.settings().interval_decrease {
            Some(base)
        } else {
            Self::relinearised(case, set, &base.best.theta)
        }
    }

    /// The same from elsewhere, with a local model of there.
    fn relinearised(case: &Case<'_>, set: FaultSet, theta: &[f64]) -> Option<Self> {
        let most = (case.settings().interval_relinearisations, case.settings().interval_decrease);
        let (local, best) = case.settled(set, theta, steps(case), most)?;
        Some(Self { best, local: Some(local) })
    }

    /// Whether it is more than `fault`, which the best set does not have, that makes it better than what was isolated: the fault is
    /// worth its price, or the best set alone comes lower from here.
    fn leads_on(&self, case: &Case<'_>, isolation: &Isolation, fault: usize) -> bool {
        let (set, best) = (isolation.set(), isolation.best.cost);
        let near = self.local.as_ref().unwrap_or(&isolation.local);
        let occam = case.schur_complement(near).occam([fault].into_iter(), 1.0);
        let evidence = 0.5 * (best - self.best.cost) / isolation.compared[fault] + prior_odds(case) + occam;
        let without = || fitted(case, near, set, &case.without_others(&self.best.theta, set));
        evidence > 0.0 || without().is_some_and(|alone| alone.cost < best - case.settings().restart_decrease)
    }
}

/// The fit of a fault combination along a local model, from values of all estimated parameters.
fn fitted(case: &Case<'_>, near: &LocalModel, set: FaultSet, theta: &[f64]) -> Option<Fit> {
    case.fit(near, set, theta, steps(case)).ok()
}

/// Steps of such a fit.
fn steps(case: &Case<'_>) -> Options {
    Options::steps(case.settings().interval_steps, case.settings().exact_decrease)
}

/// The intervals of faults, and the estimate that they are drawn around: where a profile leads to a better one, that. Faults behind the
/// first `reported` ones have one only where they are present.
pub fn settled(mut estimate: Estimate<'_>, reported: usize) -> (Estimate<'_>, Vec<Option<Interval>>) {
    let mut restarts = estimate.case.settings().interval_restarts;
    let mut may_change = true;
    loop {
        estimate.walk_to_the_bottom();
        if estimate.explains() && estimate.ask_instead(may_change) {
            may_change = false;
            continue;
        }
        let (case, isolation) = (&estimate.case, &estimate.isolation);
        if !estimate.explains() {
            let of = |fault: usize| straight(case, isolation, isolation.set().with(fault), fault);
            let intervals = widened(case, isolation, (0..case.faults()).map(of).collect());
            return (estimate, intervals);
        }
        if let Some(drawn) = drawn_or_led_on(&mut estimate, &mut restarts, reported) {
            let intervals = widened(&estimate.case, &estimate.isolation, drawn);
            return (estimate, intervals);
        }
    }
}

/// The intervals of faults around an estimate; `None` where a profile leads to a better one, which the estimate then is, as long as
/// restarts are left.
fn drawn_or_led_on(
    estimate: &mut Estimate<'_>,
    restarts: &mut usize,
    reported: usize,
) -> Option<Vec<Option<Interval>>> {
    let set = estimate.isolation.set();
    // Those of present faults first: where one of them leads elsewhere, the others need not be drawn here.
    let faults = (0..estimate.case.faults()).filter(|&fault| fault < reported || set.contains(fault));
    let (present, absent): (Vec<usize>, Vec<usize>) = faults.partition(|&fault| set.contains(fault));
    let mut drawn: Vec<Option<Interval>> = vec![None; estimate.case.faults()];
    for faults in [present, absent] {
        for (fault, interval) in faults.iter().zip(each(&estimate.case, &estimate.isolation, &faults)) {
            drawn[*fault] = interval;
        }
        if *restarts == 0 {
            continue;
        }
        let others = drawn.iter().flatten().filter_map(|interval| interval.better.as_ref());
        let Some(better) = others.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { continue };
        match estimate.resume(&better.theta) {
            Some(gained) => {
                let leads_on = 2.0 * gained > estimate.case.settings().restart_decrease;
                *restarts = if leads_on { *restarts - 1 } else { 0 };
                return None;
            }
            None => *restarts = 0,
        }
    }
    Some(drawn)
}

/// The intervals of some faults, each with those of the best set free too.
fn each(case: &Case<'_>, isolation: &Isolation, faults: &[usize]) -> Vec<Option<Interval>> {
    let count = case.rig().context().count("intervals of the faults", faults.len());
    let one = |&fault: &usize| {
        case.rig().context().check().ok()?;
        let interval = interval(case, isolation, fault);
        count.one();
        interval
    };
    faults.par_iter().map(one).collect()
}

/// The intervals of all faults with what no record determines; where other sets are as good as open, each holds what they say too.
fn widened(case: &Case<'_>, isolation: &Isolation, mut intervals: Vec<Option<Interval>>) -> Vec<Option<Interval>> {
    for (fault, interval) in case.rig().faults.iter().zip(&mut intervals) {
        if let Some(interval) = interval {
            widen(interval, case.rig().never_known(fault), fault.bounds);
        }
    }
    for (other, probability) in isolation.weighed.iter().zip(isolation.probabilities()) {
        let Some(point) = other
            .point
            .as_ref()
            .filter(|_| probability >= case.settings().interval_probability && other.set != isolation.set())
        else {
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
    let is_absent = !isolation.set().contains(fault);
    let from_bound = if is_absent { from_bound(case, isolation, set, fault) } else { None };
    let mut found = match from_bound {
        Some(found) => found,
        None => drawn(case, isolation, &Base::new(case, isolation, set)?, set, fault)?,
    };
    let mut redrawn = 0;
    loop {
        let Some(better) = found.better.as_ref().filter(|_| is_absent) else { return Some(found) };
        // Laws that bend have several optima: where that of an absent fault is another, its interval is drawn around that one.
        let other = Base::relinearised(case, set, &better.theta)?;
        if other.leads_on(case, isolation, fault) {
            return Some(found);
        }
        if redrawn == case.settings().interval_redraws {
            return Some(Interval { better: None, ..found });
        }
        redrawn += 1;
        found = drawn(case, isolation, &other, set, fault)?;
    }
}

/// The interval of an absent fault at a bound, from which on its law is a power; `None` of another, where a fit comes first.
fn from_bound(case: &Case<'_>, isolation: &Isolation, set: FaultSet, fault: usize) -> Option<Interval> {
    let (near, best) = (&isolation.local, &isolation.best);
    let (low, high) = case.rig().faults[fault].bounds;
    if best.theta[fault] > low && best.theta[fault] < high {
        return None;
    }
    let (direction, inflation) = along(case, near, set, fault, &best.misfit)?;
    interval_from_bound(&case.problem(set), near, best, fault, direction, inflation)
}

/// The interval of `fault` around a fit with the faults of `set`.
fn drawn(case: &Case<'_>, isolation: &Isolation, base: &Base, set: FaultSet, fault: usize) -> Option<Interval> {
    let near = base.local.as_ref().unwrap_or(&isolation.local);
    let (direction, inflation) = along(case, near, set, fault, &base.best.misfit)?;
    Some(profile(&case.problem(set), near, &base.best, fault, direction, inflation))
}

/// How everything moves with `fault` by a local model with the faults of `set` free, and the inflation of its variance by the misfits.
fn along(
    case: &Case<'_>,
    near: &LocalModel,
    set: FaultSet,
    fault: usize,
    misfit: &[f64],
) -> Option<(DVector<f64>, f64)> {
    let direction = case.information(near, set).ok()?.direction(fault)?;
    let inflation = near.inflation_along(&case.problem(set), &direction, misfit, &case.full);
    Some((direction, inflation))
}

/// The interval by the local quadratic model: for an offset or a gain, which readings follow in a straight line, that is the profile.
fn straight(case: &Case<'_>, isolation: &Isolation, set: FaultSet, fault: usize) -> Option<Interval> {
    let (near, best) = (&isolation.local, &isolation.best);
    let (direction, inflation) = along(case, near, set, fault, &best.misfit)?;
    let problem = case.problem(set);
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
