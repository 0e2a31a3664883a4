//! Profile likelihood: the interval that the data allow for one parameter, whatever the others do.
//!
//! The ends lie where the best cost with the parameter held there has risen by the quantile of chi-square. The local model
//! tells where that should be and how everything else should follow, a simulation tells what the cost is there, and the
//! root of the rise, nearly a straight line, is searched from there. An end that no value within the bounds reaches stays
//! open.
//!
//! Source: Venzon and Moolgavkar, Applied Statistics 37 (1988); Bates and Watts, *Nonlinear Regression Analysis and Its
//! Applications* (1988), chapter 6; Raue et al., Bioinformatics 25 (2009) for open ends.

mod from_bound;
mod way;

use std::fmt;

use nalgebra::DVector;

pub use self::from_bound::interval_from_bound;
use self::way::Way;
use super::parabola::Parabola;
use super::{Fit, Held, LocalModel, Options, Problem, StoppedBecause, fit_along};

/// Rise of `2 F` that ends a 95 % interval: quantile of chi-square with one degree of freedom.
pub const RISE: f64 = 3.841_459;
/// Standard normal quantile of the same.
pub const QUANTILE: f64 = 1.959_964;
/// Most values that are tried for one end: four times as far each time, then a bracket halved at worst, ends a thousand
/// expected widths away are found to a percent.
const MOST_VALUES: usize = 16;
/// So many times as far as it has been found does a profile go on as found at most: a rise of rounding alone is a straight line too.
const FARTHER: f64 = 4.0;
/// Error of an end, as a share of its distance: a hundredth.
const EXACT: f64 = 0.01;
/// A cost lower than the best by this share of the threshold is another optimum.
const BETTER: f64 = 0.25;
/// A rise up to so many thresholds is near: twice as far along a straight root.
const NEAR: f64 = 4.0;
/// A promise left beyond this share of the threshold asks for a relinearisation: ends then lie within half a hundredth of their
/// distance from where the cost is exact.
const STALE: f64 = 0.01;
/// Share of what a fit leaves undone that a relinearisation may leave where it converges: half the length of the step (natural
/// monotonicity test; Deuflhard, *Newton Methods for Nonlinear Problems*, section 3.3).
const CONTRACTS: f64 = 0.25;
/// Most relinearisations for one end, those of fits that do not settle left out.
const MOST_RELINEARISATIONS: usize = 6;
/// Steps of the fit at each value, and of one that has been relinearised.
const STEPS: (u64, u64) = (2, 3);

/// Why an interval ends where it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The threshold is crossed there.
    Crossed,
    /// The bound comes first: the interval is open.
    BoundReached,
    /// The model fails before the threshold is crossed: open as far as can be told.
    ModelFails,
    /// A better optimum turned up; the interval of the old one means nothing.
    BetterOptimum,
    /// The search did not settle within its budget.
    GaveUp,
}

/// What the data say about one parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Identifiable {
    /// Both ends are known.
    Bounded,
    /// The data bound it from below only.
    LowerBoundOnly,
    /// The data bound it from above only.
    UpperBoundOnly,
    /// Neither end is known.
    Unidentifiable,
}

impl fmt::Display for Identifiable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bounded => "bounded",
            Self::LowerBoundOnly => "lower-bound-only",
            Self::UpperBoundOnly => "upper-bound-only",
            Self::Unidentifiable => "unidentifiable",
        })
    }
}

/// A point of a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// The value at which the parameter was held, in its unit.
    pub value: f64,
    /// `2 (F - least F)` there, not inflated.
    pub rise: f64,
}

/// One end of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// In the unit of the parameter; `None` where it is open.
    pub end: Option<f64>,
    pub why: End,
    /// Rise of chi-square at the bound, where that was reached.
    pub rise: f64,
}

/// What a record leaves of one parameter, at a level of 95 %.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// Best value, in the unit of the parameter.
    pub value: f64,
    /// Standard error by the local model, inflated; `None` where the record says nothing or the value is at a bound.
    pub sigma: Option<f64>,
    pub lower: Side,
    pub upper: Side,
    /// Rise of `2 F` that ends the interval.
    pub threshold: f64,
    /// What the search visited, by rising value, the best included; rises as they are, not deflated.
    pub points: Vec<ProfilePoint>,
    /// A better fit, where the search found one.
    pub better: Option<Fit>,
}

impl Interval {
    /// Variance inflation by autocorrelation; without it the threshold is [`RISE`] for all parameters.
    pub fn inflation(&self) -> f64 {
        self.threshold / RISE
    }

    /// Both ends in one word.
    #[cfg(feature = "internals")]
    pub fn identifiable(&self) -> Identifiable {
        match (self.lower.end, self.upper.end) {
            (Some(_), Some(_)) => Identifiable::Bounded,
            (Some(_), None) => Identifiable::LowerBoundOnly,
            (None, Some(_)) => Identifiable::UpperBoundOnly,
            (None, None) => Identifiable::Unidentifiable,
        }
    }
}

/// The interval of a parameter around the fit `best` of a problem. `direction` is that of the parameter in the local model
/// `near` the fit ([`super::local_model::Information::direction`]), `inflation` that of its variance.
pub fn interval<P: Problem>(
    problem: &P,
    near: &LocalModel,
    best: &Fit,
    parameter: usize,
    direction: DVector<f64>,
    inflation: f64,
) -> Interval {
    let threshold = RISE * inflation;
    let sigma = (direction[parameter] * inflation).sqrt() * near.scale[parameter];
    let (low, high) = problem.bounds()[parameter];
    let sigma = Some(sigma).filter(|sigma| *sigma < high - low);
    let value = best.theta[parameter];
    let mut search = Search::new(problem, near, parameter, best.clone(), threshold);
    let mut side = |bound: f64| {
        let straight = Way::straight(direction.clone(), (bound - value).signum());
        // Where the local model sees nothing of it, a law may begin with a power.
        let secant = if sigma.is_none() { search.secant(&straight, bound) } else { None };
        search.side(secant.as_ref().map_or(&straight, |(way, _)| way), bound)
    };
    let sides = (side(low), side(high));
    let sigma = sigma.filter(|_| value > low && value < high);
    search.interval(sides, sigma)
}

struct Search<'a, P> {
    problem: &'a P,
    near: &'a LocalModel,
    parameter: usize,
    best: Fit,
    threshold: f64,
    points: Vec<ProfilePoint>,
    better: Option<Fit>,
}

impl<'a, P: Problem> Search<'a, P> {
    fn new(problem: &'a P, near: &'a LocalModel, parameter: usize, best: Fit, threshold: f64) -> Self {
        let points = vec![ProfilePoint { value: best.theta[parameter], rise: 0.0 }];
        Self { problem, near, parameter, best, threshold, points, better: None }
    }

    /// What was found, with the lower and the upper side.
    fn interval(self, (lower, upper): (Side, Side), sigma: Option<f64>) -> Interval {
        let Self { mut points, better, threshold, best, parameter, .. } = self;
        points.sort_by(|a, b| a.value.total_cmp(&b.value));
        Interval { value: best.theta[parameter], sigma, lower, upper, threshold, points, better }
    }

    /// The value of the parameter at a coordinate.
    fn value_at(&self, way: &Way, at: f64) -> f64 {
        let (low, high) = self.problem.bounds()[self.parameter];
        (self.best.theta[self.parameter] + way.sign * way.distance(at)).clamp(low, high)
    }

    /// Slope of the root of the rise where the profile begins, by a local model.
    fn slope(&self, way: &Way) -> f64 {
        (way.direction[self.parameter].sqrt() * self.near.scale[self.parameter]).recip()
    }

    /// The end between the value and `bound`.
    fn side(&mut self, way: &Way, bound: f64) -> Side {
        let value = self.best.theta[self.parameter];
        let target = self.threshold.sqrt();
        if value == bound {
            return Side { end: None, why: End::BoundReached, rise: 0.0 };
        }
        let last = way.coordinate((bound - value).abs());
        let slope = self.slope(way);
        let mut ahead = Ahead { left: MOST_RELINEARISATIONS, fresh: None };
        // Coordinates with the root of their rise: the last below the threshold, the first above.
        let mut below = (0.0, 0.0);
        let mut above: Option<(f64, f64)> = None;
        let mut from = (self.best.clone(), 0.0);
        let (mut turns, mut last_side) = (0, None);
        let reach = (target / slope).min(last);
        let mut at = reach;
        // How far from a coordinate below the next may lie: a stride that has failed is halved, and doubled again from where it holds.
        let mut stride = f64::INFINITY;
        for _ in 0..MOST_VALUES {
            let point = match self.held_at(way, &mut ahead, (&from.0, from.1), at) {
                Ok(point) => point,
                Err(why) => {
                    if (at - below.0).abs() < 1e-3 * reach {
                        return Side { end: None, why, rise: below.1 * below.1 };
                    }
                    stride = 0.5 * (at - below.0);
                    at = f64::midpoint(at, below.0);
                    continue;
                }
            };
            // What a further step promises is taken as done.
            let rise = point.cost - point.promised.max(0.0) - self.best.cost;
            if rise < -BETTER * self.threshold && self.better.as_ref().is_none_or(|better| point.cost < better.cost) {
                self.better = Some(point);
                return Side { end: None, why: End::BetterOptimum, rise: 0.0 };
            }
            self.points.push(ProfilePoint { value: self.value_at(way, at), rise: rise.max(0.0) });
            let root = rise.max(0.0).sqrt();
            let inner = root < target;
            if inner && at >= last {
                return Side { end: None, why: End::BoundReached, rise };
            }
            let parabola = Parabola::through(slope, below, (at, root));
            if target <= FARTHER * root && parabola.error(target) < EXACT {
                let end = self.value_at(way, parabola.crossing(target).min(last));
                return Side { end: Some(end), why: End::Crossed, rise };
            }
            turns = if last_side == Some(inner) { turns + 1 } else { 0 };
            last_side = Some(inner);
            if inner {
                stride *= 2.0;
                below = (at, root);
                from = (point, at);
            } else {
                above = Some((at, root));
            }
            at = match above {
                // On the chord between a value below and one above, but not at its ends; halfway where that keeps falling on one side.
                Some(above) => {
                    let chord = (target - below.1) / (above.1 - below.1);
                    let share = if turns > 1 { 0.5 } else { chord.clamp(0.1, 0.9) };
                    below.0 + share * (above.0 - below.0)
                }
                None => (below.0 * (target / below.1).min(FARTHER)).min(last),
            };
            at = at.min(below.0 + stride);
        }
        Side { end: None, why: End::GaveUp, rise: below.1 * below.1 }
    }

    /// The best fit with the parameter held, from where everything is led; relinearised where much is still promised. Why there is none,
    /// where the model fails, or the fit does not settle: from where it was led, the best is not near.
    fn held_at(&self, way: &Way, ahead: &mut Ahead, from: (&Fit, f64), to: f64) -> Result<Fit, End> {
        let enough = 0.5 * STALE * self.threshold;
        let value = self.value_at(way, to);
        let held = Held::new(self.problem, self.parameter, value);
        let fresh = ahead.fresh.as_ref();
        let (model, along) = fresh.map_or((self.near, way), |fresh| (&fresh.model, &fresh.way));
        let [before, after] = [from.1, to].map(|at| along.coordinate(way.distance(at)));
        let start = self.follow(model, along, from.0, after - before);
        let mut point =
            fit_along(&held, model, &start, Options::steps(STEPS.0, enough)).map_err(|_| End::ModelFails)?;
        let better = |point: &Fit| point.cost < self.best.cost - BETTER * self.threshold;
        let (mut taken, mut retaken) = (0, None);
        while undone(&point) > STALE * self.threshold && taken < ahead.left {
            let before = undone(&point);
            let Ok(model) = LocalModel::at(&held, &point.theta, self.near.loss) else { break };
            let Ok(further) = fit_along(&held, &model, &point.theta, Options::steps(STEPS.1, enough)) else { break };
            point = further;
            if undone(&point) > CONTRACTS * before && !better(&point) {
                return Err(End::GaveUp);
            }
            taken += 1;
            let direction = model.information(self.problem).ok().and_then(|known| known.direction(self.parameter));
            retaken = direction.map(|direction| Fresh { model, way: Way::straight(direction, way.sign) }).or(retaken);
        }
        if undone(&point) > STALE * self.threshold && !better(&point) {
            return Err(End::GaveUp);
        }
        ahead.left -= taken;
        // A model from far beyond the end says nothing of it.
        if retaken.is_some() && point.cost - self.best.cost < NEAR * self.threshold {
            ahead.fresh = retaken;
        }
        Ok(point)
    }

    /// Everything as a local model expects it so much further along a way.
    fn follow(&self, model: &LocalModel, way: &Way, from: &Fit, further: f64) -> Vec<f64> {
        let share = way.sign * further / (way.direction[self.parameter] * model.scale[self.parameter]);
        let moved = way.direction.iter().zip(&model.scale).map(|(along, scale)| share * along * scale);
        from.theta.iter().zip(moved).map(|(theta, moved)| theta + moved).collect()
    }
}

/// Decrease of `2 F` that a fit could still make by its local model, whether or not a step could be found that makes it.
fn undone(fit: &Fit) -> f64 {
    match fit.stopped {
        StoppedBecause::NoFurtherDecrease { promised, .. } => promised * fit.cost,
        _ => fit.promised,
    }
}

/// What the search of an end goes on with.
struct Ahead {
    /// Relinearisations left.
    left: usize,
    /// The last local model taken on the way.
    fresh: Option<Fresh>,
}

/// A local model taken on the way, and the way on by it.
struct Fresh {
    model: LocalModel,
    way: Way,
}
