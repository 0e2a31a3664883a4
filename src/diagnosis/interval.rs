//! Identification: the interval that a record leaves one fault, whatever everything else does.
//!
//! The ends lie where the best cost with the fault held there has risen by the quantile of chi-square (profile likelihood;
//! Venzon and Moolgavkar, Applied Statistics 37 (1988)). The quadratic form tells where that should be and how everything
//! else should follow, a simulation tells what the cost is there, and the root of the rise, nearly a straight line, is
//! searched from there. An end that no value within the bounds reaches stays open.

use nalgebra::DVector;
use rayon::prelude::*;

use super::case::Case;
use super::descend::{EXACT, Point, descend};
use super::hypotheses::Isolation;
use super::quadratic::Quadratic;
use crate::fit::{End, ProfilePoint};
use crate::rig::FaultSet;

/// Rise of `2 F` that ends a 95 % interval: quantile of chi-square with one degree of freedom.
pub const RISE: f64 = 3.841_459;
/// Standard normal quantile of the same.
pub const QUANTILE: f64 = 1.959_964;
/// A set of this probability is as good as open.
const OPEN: f64 = 0.05;
/// Most values that are tried for one end.
const MOST_VALUES: usize = 10;
/// A rise this close to the threshold, relative, is interpolated.
const CLOSE: f64 = 0.15;
/// A cost lower than the best by this share of the threshold is another optimum.
const BETTER: f64 = 0.25;
/// A promise left beyond this share of the threshold asks for a new form.
const STALE: f64 = 0.1;
/// Steps of each fit.
const STEPS: usize = 6;
/// A new form that gains less is the last one.
const ENOUGH: f64 = 0.1;
/// Most new forms for one end.
const MOST_FORMS: usize = 2;
/// Points of a profile that is known in full, and how far it is told, in standard errors.
const TOLD: (usize, f64) = (21, 3.0);

/// One end of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// SI; `None` where it is open.
    pub end: Option<f64>,
    pub why: End,
    /// Rise of chi-square at the bound, where that was reached.
    pub rise: f64,
}

/// What a record leaves of one fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// Best value, SI.
    pub value: f64,
    /// Standard error by the quadratic form, SI; `None` where the record says nothing or the value is at a bound.
    pub sigma: Option<f64>,
    pub lower: Side,
    pub upper: Side,
    /// Rise of chi-square that ends the interval.
    pub threshold: f64,
    /// What the search visited, by rising value (SI), the best included; rises as they are, colour not taken off.
    pub points: Vec<ProfilePoint>,
    /// A better fit, where the search found one.
    pub better: Option<Point>,
}

impl Interval {
    /// The factor by which coloured misfits lift a rise; without it the level of 95 % is [`RISE`] for all faults.
    pub fn colour(&self) -> f64 {
        self.threshold / RISE
    }

    /// Adds what no record tells, one standard deviation, SI.
    fn widen(&mut self, sigma: f64, (low, high): (f64, f64)) {
        let further = |end: f64| (end - self.value).hypot(QUANTILE * sigma);
        if let Some(end) = self.lower.end {
            self.lower.end = Some((self.value - further(end)).max(low));
        }
        if let Some(end) = self.upper.end {
            self.upper.end = Some((self.value + further(end)).min(high));
        }
        self.sigma = self.sigma.map(|own| own.hypot(sigma));
    }
}

/// A set of faults fitted for an interval: its best point, with the form there.
struct Base {
    best: Point,
    /// Where it was renewed.
    form: Option<Quadratic>,
}

impl Base {
    /// Fits `set` from where the search ended; `None` where the model cannot be solved.
    fn new(case: &Case<'_>, isolation: &Isolation, set: FaultSet) -> Option<Self> {
        let from = |near: &Quadratic, theta: &[f64]| descend(case, near, set, &[], theta, 0.0, (STEPS, EXACT));
        let mut best = from(&isolation.quadratic, &isolation.best.theta)?;
        let mut form = None;
        for _ in 0..MOST_FORMS {
            if best.promised < ENOUGH {
                break;
            }
            // From afar: the steps that are left need a slope of their own.
            let fresh = Quadratic::at(case, &best.theta).ok()?;
            best = from(&fresh, &best.theta)?;
            form = Some(fresh);
        }
        Some(Self { best, form })
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
            interval.widen(case.rig().never_known(fault), fault.bounds);
        }
    }
    for (other, probability) in isolation.weighed.iter().zip(isolation.probabilities()) {
        let Some(point) = other.point.as_ref().filter(|_| probability >= OPEN && other.set != isolation.set()) else {
            continue;
        };
        for fault in other.set.iter() {
            let Some(interval) = &mut intervals[fault] else { continue };
            let sigma = isolation
                .reduced
                .sigma(other.set, fault)
                .map(|sigma| sigma * isolation.quadratic.scale[fault] * isolation.inflation[fault].sqrt());
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
    let Base { best, form } = Base::new(case, isolation, set)?;
    let near = form.as_ref().unwrap_or(&isolation.quadratic);
    let along = near.direction(case, set, fault)?;
    let colour = near.inflation(&along, &case.full.series());
    let threshold = RISE * colour;
    let sigma = (along[fault] * colour).sqrt() * near.scale[fault];
    let (low, high) = case.rig().faults[fault].bounds;
    let sigma = Some(sigma).filter(|sigma| *sigma < high - low);
    let value = best.theta[fault];
    let points = vec![ProfilePoint { value, rise: 0.0 }];
    let mut search = Search { case, set, fault, best: &best, along, threshold, points, better: None };
    let reach = sigma.map_or(0.25 * (high - low), |sigma| QUANTILE * sigma);
    let lower = search.side(near, low, -reach);
    let upper = search.side(near, high, reach);
    let sigma = sigma.filter(|_| value > low && value < high);
    let Search { mut points, better, .. } = search;
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    Some(Interval { value, sigma, lower, upper, threshold, points, better })
}

/// The interval of an offset or a gain: readings follow it in a straight line, so the quadratic form is the profile.
fn straight(case: &Case<'_>, isolation: &Isolation, set: FaultSet, fault: usize) -> Option<Interval> {
    let (near, best) = (&isolation.quadratic, &isolation.best);
    let along = near.direction(case, set, fault)?;
    let colour = near.inflation(&along, &case.full.series());
    let sigma = (along[fault] * colour).sqrt() * near.scale[fault];
    // One step along the form from the best of all sets: where this fault is not in it, it stands at its healthy value.
    let pull = near.gradient(&best.misfit) + case.precision(set, &near.scale) * case.away(&best.theta, &near.scale);
    let step = -along.dot(&pull) * near.scale[fault];
    let (low, high) = case.rig().faults[fault].bounds;
    let value = (best.theta[fault] + step).clamp(low, high);
    let side = |end: f64, bound: f64| {
        if (low..=high).contains(&end) {
            Side { end: Some(end), why: End::Crossed, rise: RISE * colour }
        } else {
            Side { end: None, why: End::BoundReached, rise: ((bound - value) / sigma).powi(2) * colour }
        }
    };
    let (lower, upper) = (side(value - QUANTILE * sigma, low), side(value + QUANTILE * sigma, high));
    let known = sigma.is_finite() && sigma < high - low;
    let at = |held: f64| ProfilePoint { value: held, rise: ((held - value) / sigma).powi(2) * colour };
    let step = |k: usize| value + TOLD.1 * sigma * (2.0 * k as f64 / (TOLD.0 - 1) as f64 - 1.0);
    let points: Vec<ProfilePoint> =
        (0..TOLD.0).map(step).filter(|value| (low..=high).contains(value)).map(at).collect();
    Some(Interval {
        value,
        sigma: known.then_some(sigma),
        lower,
        upper,
        threshold: RISE * colour,
        points,
        better: None,
    })
}

struct Search<'a, 'b> {
    case: &'a Case<'b>,
    set: FaultSet,
    fault: usize,
    best: &'a Point,
    along: DVector<f64>,
    threshold: f64,
    points: Vec<ProfilePoint>,
    better: Option<Point>,
}

impl Search<'_, '_> {
    /// The end between the value and `bound`, `reach` away by the quadratic form.
    fn side(&mut self, near: &Quadratic, bound: f64, reach: f64) -> Side {
        let value = self.best.theta[self.fault];
        let target = self.threshold.sqrt();
        let enough = 0.5 * STALE * self.threshold;
        if value == bound {
            return Side { end: None, why: End::BoundReached, rise: 0.0 };
        }
        let inside = |at: f64| if reach < 0.0 { at.max(bound) } else { at.min(bound) };
        let (mut form, mut renewed) = (None, 0);
        // Values with the root of their rise: the last below the threshold, the first above.
        let mut below = (value, 0.0);
        let mut above: Option<(f64, f64)> = None;
        let mut from = self.best.clone();
        let mut at = inside(value + reach);
        for _ in 0..MOST_VALUES {
            let near = form.as_ref().unwrap_or(near);
            let start = self.follow(near, &from, at);
            let Some(mut point) = descend(self.case, near, self.set, &[(self.fault, at)], &start, 0.0, (2, enough))
            else {
                // The model fails there: nearer, if there is a nearer one.
                if (at - below.0).abs() < 1e-3 * reach.abs() {
                    return Side { end: None, why: End::ModelFails, rise: below.1 * below.1 };
                }
                at = f64::midpoint(at, below.0);
                continue;
            };
            if point.promised > STALE * self.threshold && renewed < MOST_FORMS {
                renewed += 1;
                if let Ok(fresh) = Quadratic::at(self.case, &point.theta)
                    && let Some(further) =
                        descend(self.case, &fresh, self.set, &[(self.fault, at)], &point.theta, 0.0, (3, enough))
                {
                    point = further;
                    form = Some(fresh);
                }
            }
            let rise = point.cost - self.best.cost;
            if rise < -BETTER * self.threshold && self.better.as_ref().is_none_or(|better| point.cost < better.cost) {
                self.better = Some(point.clone());
                return Side { end: None, why: End::BetterOptimum, rise: 0.0 };
            }
            self.points.push(ProfilePoint { value: at, rise: rise.max(0.0) });
            let root = rise.max(0.0).sqrt();
            if (rise / self.threshold - 1.0).abs() < CLOSE {
                let end = below.0 + (at - below.0) * ((target - below.1) / (root - below.1)).clamp(0.0, 2.0);
                return Side { end: Some(inside(end)), why: End::Crossed, rise };
            }
            if root < target {
                below = (at, root);
                from = point;
                if at == bound {
                    return Side { end: None, why: End::BoundReached, rise };
                }
            } else {
                above = Some((at, root));
            }
            at = match above {
                // Between a value below and one above: on the chord, but not at its ends.
                Some(above) => {
                    let share = ((target - below.1) / (above.1 - below.1)).clamp(0.1, 0.9);
                    below.0 + share * (above.0 - below.0)
                }
                None => {
                    let slope = below.1 / (below.0 - value);
                    let further = value + (target / slope).clamp(-1e300, 1e300);
                    let most = value + 4.0 * (below.0 - value);
                    inside(if reach < 0.0 { further.max(most) } else { further.min(most) })
                }
            };
        }
        Side { end: None, why: End::GaveUp, rise: below.1 * below.1 }
    }

    /// Everything as the quadratic form expects it with the fault held at a value.
    fn follow(&self, near: &Quadratic, from: &Point, at: f64) -> Vec<f64> {
        let share = (at - from.theta[self.fault]) / (self.along[self.fault] * near.scale[self.fault]);
        (0..self.case.count()).map(|i| from.theta[i] + share * self.along[i] * near.scale[i]).collect()
    }
}
