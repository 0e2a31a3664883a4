//! Faults that do what a present one does, although from here they seem to do nothing.
//!
//! Two pistons that leak between the same lines leave the same record, and a leak begins with the cube of its gap: seen from the explanation
//! by one of them, the other has no slope, or leaves other traces than at its size. So an absent fault is tried without the present one, at the size at which it does as much.
//! Where the two do the same but for a factor, the combination with one in place of the other is fitted and weighed like the rest.

use rayon::prelude::*;

use super::case::Case;
use super::hypotheses::Isolation;
use super::unseen::gained;
use super::weighing::Weighed;
use crate::estimation::{Options, Problem, ScoreTest};
use crate::numeric::dot;
use crate::rig::FaultSet;

/// Shares of the way to a bound at which it is asked what an absent fault does, and with which power that begins.
const PROBES: [f64; 2] = [0.35, 0.175];

/// Share of the squares of what a fault does that may be left beside another at another size, for it to be asked at the size that does as
/// much: a leak twice as large has a piston stop elsewhere, and little of the one is like the other.
const MOST_LEFT: f64 = 0.9;
/// Sizes at which that is sought, from afar and near there, and the share of a size that a further one is worth.
const SIZES: usize = 4;
const SAME: f64 = 1e-3;

/// One fault in place of another: the share of what the other does that is left of it, and where to start.
struct Substitute {
    left: f64,
    set: FaultSet,
    theta: Vec<f64>,
}

/// Combinations with an absent fault in place of a present one that are as good as the best but for what the local model may be wrong
/// by, fitted.
pub fn instead(case: &Case<'_>, isolation: &Isolation) -> Vec<Weighed> {
    let set = isolation.set();
    let absent = || (0..case.faults()).filter(|&other| !set.contains(other) && !case.is_of_sensor(other));
    if absent().next().is_none() {
        return Vec::new();
    }
    let present: Vec<Present<'_>> = set.iter().filter_map(|fault| Present::new(case, isolation, fault)).collect();
    let pairs: Vec<(&Present<'_>, usize, f64)> = present
        .iter()
        .flat_map(|one| absent().map(move |other| (one, other)))
        .flat_map(|(one, other)| case.levels(other, &PROBES[..1]).map(move |value| (one, other, value)))
        .collect();
    let replaced = |(one, other, value): (&Present<'_>, usize, f64)| one.replaced_by(other, value);
    let mut found: Vec<Substitute> = pairs.into_par_iter().filter_map(replaced).collect();
    found.sort_by(|a, b| a.left.total_cmp(&b.left));
    // Each combination once, from its best start: weighed twice it would count twice.
    let mut known: Vec<FaultSet> = Vec::new();
    found.retain(|one| {
        let is_new = !known.contains(&one.set);
        known.push(one.set);
        is_new
    });
    found.truncate(case.settings().replacements_fitted);
    found.into_par_iter().filter_map(|one| weighed(case, isolation, one)).collect()
}

/// A present fault, and what the record would be without it.
struct Present<'a> {
    case: &'a Case<'a>,
    fault: usize,
    set: FaultSet,
    /// All estimated parameters of the best explanation, SI, with this fault healthy, and the misfits there.
    without: (Vec<f64>, Vec<f64>),
    /// What it does to the misfits.
    does: Vec<f64>,
    /// Of changes beside the best explanation, everything uncertain following but absent faults of components.
    test: ScoreTest<'a>,
}

impl<'a> Present<'a> {
    /// `None` where the model cannot be solved without it.
    fn new(case: &'a Case<'a>, isolation: &'a Isolation, fault: usize) -> Option<Self> {
        let (set, best) = (isolation.set(), &isolation.best);
        let others = set.difference(FaultSet::of(fault));
        // Neither it nor what may stand in its place follows: one that a calibration has found would take over its own change.
        let may_stand = |other: usize| !others.contains(other) && !case.is_of_sensor(other);
        let held = (0..case.faults()).filter(|&other| other == fault || may_stand(other));
        let beside = case.problem_beside(others, held, &best.theta);
        let test = isolation.local.score_test(&beside, &best.theta, &best.misfit).ok()?;
        let mut theta = best.theta.clone();
        theta[fault] = case.mean[fault];
        let misfit = case.full.misfit(&theta).ok()?;
        let does = best.misfit.iter().zip(&misfit).map(|(with, without)| with - without).collect();
        Some(Self { case, fault, set, without: (theta, misfit), does, test })
    }

    /// What nothing that follows can take over of a change, squared.
    fn own(&self, change: &[f64]) -> f64 {
        self.test.of(change).information
    }

    /// The same of the product of two.
    fn product(&self, one: &[f64], other: &[f64]) -> f64 {
        let both: Vec<f64> = one.iter().zip(other).map(|(a, b)| a + b).collect();
        0.5 * (self.own(&both) - self.own(one) - self.own(other))
    }

    /// What another fault does in place of it at a value, SI.
    fn done_by(&self, other: usize, value: f64) -> Option<Vec<f64>> {
        let (mut theta, misfit) = self.without.clone();
        theta[other] = value;
        let there = self.case.full.misfit(&theta).ok()?;
        Some(there.iter().zip(&misfit).map(|(with, without)| with - without).collect())
    }

    /// The start with another fault in its place, which is tried first at a value, SI; `None` where it does the opposite or something else.
    fn replaced_by(&self, other: usize, value: f64) -> Option<Substitute> {
        let (case, healthy) = (self.case, self.case.mean[other]);
        let alike_at = |change: &[f64]| {
            alike(dot(&self.does, &self.does), dot(change, change), dot(&self.does, change), MOST_LEFT)
        };
        let (low, high) = case.rig().faults[other].bounds;
        let far = self.done_by(other, value)?;
        alike_at(&far)?;
        let between = healthy + PROBES[1] / PROBES[0] * (value - healthy);
        let (mut before, mut value, mut does) = ((between, self.done_by(other, between)?), value, far);
        let this = self.own(&self.does);
        let own_alike_at = |change: &[f64]| alike(this, self.own(change), self.product(&self.does, change), MOST_LEFT);
        // From afar by all that it does, near there by what nothing that follows takes over: the two may be a third apart.
        let mut ends: Vec<(f64, f64)> = Vec::new();
        for is_near in [false, true] {
            for _ in 0..SIZES {
                let Some(Alike { factor, .. }) = (if is_near { own_alike_at(&does) } else { alike_at(&does) }) else {
                    break;
                };
                // It does as much where it would with the power with which it grew from the size before to this one.
                let grown = 0.5 * (dot(&does, &does) / dot(&before.1, &before.1)).ln();
                let power = grown / ((value - healthy) / (before.0 - healthy)).ln();
                let next = (healthy + factor.powf(power.recip()) * (value - healthy)).clamp(low, high);
                if !next.is_finite() || (next - value).abs() <= SAME * (value - healthy).abs() {
                    break;
                }
                let Some(there) = self.done_by(other, next) else { break };
                before = (value, std::mem::replace(&mut does, there));
                value = next;
            }
            ends.extend(own_alike_at(&does).map(|end| (end.left, value)));
        }
        // The later size is the better one, although the earlier may leave a smaller share.
        let (left, value) = ends.into_iter().rev().find(|(left, _)| *left <= case.settings().unforeseen_share)?;
        let mut theta = self.without.0.clone();
        theta[other] = value;
        Some(Substitute { left, set: self.set.difference(FaultSet::of(self.fault)).with(other), theta })
    }
}

/// Two changes that are the same but for a factor on the second and a share of the squares of the first.
struct Alike {
    factor: f64,
    left: f64,
}

/// From the squares of two changes and their product; `None` where more than a share of the first is left.
fn alike(first: f64, second: f64, product: f64, most: f64) -> Option<Alike> {
    let (factor, left) = (product / second, 1.0 - product * product / (first * second));
    (factor > 0.0 && left <= most).then_some(Alike { factor, left })
}

/// The combination at its best; `None` where the best one is the better by more than the local model may be wrong by.
fn weighed(case: &Case<'_>, isolation: &Isolation, Substitute { set, theta, .. }: Substitute) -> Option<Weighed> {
    let settings = case.settings();
    let most = settings.replacement_linearisations;
    let steps = Options::steps(most as u64, settings.exact_decrease);
    let (near, fit) = case.settled(set, &theta, steps, (most, settings.isolation_decrease))?;
    let gained = gained(case, isolation, (set, &near), fit.cost);
    let score = isolation.weighed.first()?.score + gained;
    (gained > -settings.isolation_evidence).then_some(Weighed { set, score, point: Some(fit) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_alike_but_for_a_factor() {
        // (3, 4) and (6, 8) are the same but for a half; (4, -3) has nothing of it, (-3, -4) is the opposite.
        let of = |a: [f64; 2], b: [f64; 2]| alike(dot(&a, &a), dot(&b, &b), dot(&a, &b), 0.5);
        let same = of([3.0, 4.0], [6.0, 8.0]).unwrap();
        assert_eq!((same.factor, same.left), (0.5, 0.0));
        assert!(of([3.0, 4.0], [4.0, -3.0]).is_none() && of([3.0, 4.0], [-3.0, -4.0]).is_none());
        // At 45 degrees half of the squares are left; what does nothing is like nothing.
        assert!((of([1.0, 0.0], [1.0, 1.0]).unwrap().left - 0.5).abs() < 1e-15);
        assert!(of([1.0, 0.0], [0.0, 0.0]).is_none());
    }
}
