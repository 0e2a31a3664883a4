//! Intervals of parameters at a bound, from which on their law is a power that no local model knows.

use nalgebra::DVector;

use super::way::Way;
use super::{Ahead, End, Interval, MOST_RELINEARISATIONS, MOST_VALUES, NEAR, ProfilePoint, RISE, Search, Side};
use crate::estimation::local_model::Evaluated;
use crate::estimation::{Fit, Held, LocalModel, Problem};

/// A change of the misfits that the local model misses by so much of its square, a tenth of its length, is straight.
const STRAIGHT: f64 = 0.01;
/// Power with which a law is taken to begin until two values tell it: between that of a hole, 1, and of a gap, 3.
const POWER: f64 = 2.0;
/// So much farther or nearer than a value the next lies at most, while a law is looked for.
const FARTHER: f64 = 10.0;
/// Ratio of two distances that tell the power of a law, least and most.
const APART: (f64, f64) = (1.25, 5.0);

/// The interval of a parameter that stands at a bound in the fit `without` it, from which on its law is a power, as leak through a gap
/// is the third. `direction` and `inflation` as of [`interval`](super::interval).
///
/// What the parameter does alone at a few values tells the power, and where the best is with the parameter free. `None` where the local
/// model foresees what it does, so that a fit along it finds the best, and where the model fails.
pub fn interval_from_bound<P: Problem>(
    problem: &P,
    near: &LocalModel,
    without: &Fit,
    parameter: usize,
    direction: DVector<f64>,
    inflation: f64,
) -> Option<Interval> {
    let (low, high) = problem.bounds()[parameter];
    let value = without.theta[parameter];
    let further = if value <= low { high } else { low };
    let mut search = Search::new(problem, near, parameter, without.clone(), RISE * inflation);
    let (mut away, best_at) = search.secant(&Way::straight(direction, (further - value).signum()), further)?;
    if best_at > 0.0 {
        search.begin_from(&mut away, best_at);
    }
    // What the bound costs is known.
    let known = without.cost - search.best.cost;
    let inner = if known < search.threshold {
        Side { end: None, why: End::BoundReached, rise: known }
    } else {
        search.side(&away.back(), value)
    };
    let outer = search.side(&away, further);
    let sides = if value <= low { (inner, outer) } else { (outer, inner) };
    let sigma = (away.direction[parameter] * inflation).sqrt() * near.scale[parameter] / away.steepness();
    let within = search.best.theta[parameter] != value && sigma < high - low;
    Some(search.interval(sides, within.then_some(sigma)))
}

/// What a parameter does alone at a distance from the best.
struct Alone {
    distance: f64,
    theta: Vec<f64>,
    misfit: Vec<f64>,
    /// Squared length of the change of the misfits.
    size: f64,
}

impl Alone {
    /// The power of the distance that it is between two distances.
    fn power(&self, other: &Self) -> f64 {
        0.5 * (self.size / other.size).ln() / (self.distance / other.distance).ln()
    }

    /// Whether two distances are as far apart as tells a power, and no farther than that holds for.
    fn is_told_from(&self, other: &Self) -> bool {
        let ratio = (self.distance / other.distance).max(other.distance / self.distance);
        (APART.0..=APART.1).contains(&ratio)
    }
}

impl<P: Problem> Search<'_, P> {
    /// The way towards `bound` by what the parameter does alone at a distance at which that is near the threshold, and at another one,
    /// everything else following as the local model has it; and the coordinate of the best value on it, negative beyond its
    /// beginning. `None` where the local model foresees it, and where the model fails.
    pub(super) fn secant(&self, straight: &Way, bound: f64) -> Option<(Way, f64)> {
        let (near, best, parameter) = (self.near, &self.best, self.parameter);
        let value = best.theta[parameter];
        let (low, high) = self.problem.bounds()[parameter];
        let most = if (high - low).is_finite() { 0.25 * (high - low) } else { near.scale[parameter] };
        let last = (bound - value).abs();
        let mut distance = most.min(last).min(self.threshold.sqrt() / self.slope(straight));
        let mut tried: Vec<Alone> = Vec::new();
        for _ in 0..if distance > 0.0 { MOST_VALUES } else { 0 } {
            let Some(alone) = self.alone(straight, distance) else {
                distance *= FARTHER.recip();
                continue;
            };
            let before = Evaluated { theta: &best.theta, misfit: &best.misfit };
            if near.foresees(before, Evaluated { theta: &alone.theta, misfit: &alone.misfit }, STRAIGHT) {
                return None;
            }
            let (share, power) = (alone.size / self.threshold, tried.last().map_or(POWER, |other| alone.power(other)));
            tried.push(alone);
            if (1.0..=NEAR).contains(&share) || share < 1.0 && distance >= last {
                break;
            }
            let further = (NEAR.sqrt() / share).powf(0.5 / power.max(1.0)).clamp(FARTHER.recip(), FARTHER);
            distance = (distance * further).min(last);
        }
        let found = tried.pop()?;
        let known = tried.into_iter().rev().find(|other| found.is_told_from(other));
        let other = known.or_else(|| self.alone(straight, 0.5 * found.distance))?;
        let power = found.power(&other);
        let held = Held::new(self.problem, parameter, value);
        let change: Vec<f64> = found.misfit.iter().zip(&best.misfit).map(|(after, before)| after - before).collect();
        let score = near.score_test(&held, &best.theta, &best.misfit).ok()?.of(&change);
        let own = straight.sign * found.distance / near.scale[parameter];
        let variance = own * own / score.information;
        if !(power > 0.0 && power.is_finite() && variance.is_finite()) {
            return None;
        }
        let mut direction = DVector::zeros(near.count());
        for (free, falls) in score.following() {
            direction[free] = -falls * variance / own;
        }
        direction[parameter] = variance;
        let way = Way::straight(direction, straight.sign).in_power(power, found.distance);
        Some((way, score.factor * found.distance))
    }

    /// What the parameter does alone at a distance from the best; `None` where the model fails.
    fn alone(&self, straight: &Way, distance: f64) -> Option<Alone> {
        let mut theta = self.best.theta.clone();
        theta[self.parameter] += straight.sign * distance;
        let misfit = self.problem.misfit(&theta).ok()?;
        let size = misfit.iter().zip(&self.best.misfit).map(|(after, before)| (after - before).powi(2)).sum();
        Some(Alone { distance, theta, misfit, size })
    }

    /// Takes the best to a coordinate on a way that begins there, where it is better.
    fn begin_from(&mut self, way: &mut Way, at: f64) {
        let mut ahead = Ahead { left: MOST_RELINEARISATIONS, fresh: None };
        let Ok(point) = self.held_at(way, &mut ahead, (&self.best, 0.0), at) else { return };
        let rise = self.best.cost - point.cost;
        if rise <= 0.0 {
            return;
        }
        self.points = vec![ProfilePoint { value: self.best.theta[self.parameter], rise }];
        self.points.push(ProfilePoint { value: point.theta[self.parameter], rise: 0.0 });
        way.origin = way.distance(at);
        self.best = point;
    }
}
