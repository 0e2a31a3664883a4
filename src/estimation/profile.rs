//! Profile likelihood: the interval that the data allow for one parameter, whatever the others do.
//!
//! The ends lie where the best cost with the parameter held there has risen by the quantile of chi-square. The local model
//! tells where that should be and how everything else should follow, a simulation tells what the cost is there, and the
//! root of the rise, nearly a straight line, is searched from there. An end that no value within the bounds reaches stays
//! open.
//!
//! Source: Venzon and Moolgavkar, Applied Statistics 37 (1988); Bates and Watts, *Nonlinear Regression Analysis and Its
//! Applications* (1988), chapter 6; Raue et al., Bioinformatics 25 (2009) for open ends.

use std::fmt;

use nalgebra::DVector;

use super::problem::cost;
use super::{Fit, Held, LocalModel, Loss, Options, Problem, StoppedBecause, fit_along};

/// Rise of `2 F` that ends a 95 % interval: quantile of chi-square with one degree of freedom.
pub const RISE: f64 = 3.841_459;
/// Standard normal quantile of the same.
pub const QUANTILE: f64 = 1.959_964;
/// Most values that are tried for one end: four times as far each time, then a bracket halved at worst, ends a thousand
/// expected widths away are found to a percent.
const MOST_VALUES: usize = 16;
/// A rise this close to the threshold, relative, is interpolated.
const CLOSE: f64 = 0.05;
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
    let points = vec![ProfilePoint { value, rise: 0.0 }];
    let mut search = Search { problem, parameter, best, direction, threshold, points, better: None };
    let wide = if (high - low).is_finite() { 0.25 * (high - low) } else { near.scale[parameter] };
    let reach = |search: &Search<'_, P>, bound: f64| {
        let reach =
            sigma.map_or_else(|| search.reach_alone(near.loss, (bound - value).clamp(-wide, wide)), |s| QUANTILE * s);
        reach.copysign(bound - value)
    };
    let (lower, upper) = (reach(&search, low), reach(&search, high));
    let (lower, upper) = (search.side(near, low, lower), search.side(near, high, upper));
    let sigma = sigma.filter(|_| value > low && value < high);
    let Search { mut points, better, .. } = search;
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    Interval { value, sigma, lower, upper, threshold, points, better }
}

struct Search<'a, P> {
    problem: &'a P,
    parameter: usize,
    best: &'a Fit,
    direction: DVector<f64>,
    threshold: f64,
    points: Vec<ProfilePoint>,
    better: Option<Fit>,
}

impl<P: Problem> Search<'_, P> {
    /// Where the local model does not know how far an end is, as at a law that begins with a power: a distance, `wide` at most, at which the rise
    /// is not far beyond the threshold with all else where it is. What follows makes it less, and from afar that takes many steps.
    fn reach_alone(&self, loss: Loss, wide: f64) -> f64 {
        let mut theta = self.best.theta.clone();
        let mut reach = wide;
        let values = if wide == 0.0 { 0 } else { MOST_VALUES };
        for _ in 0..values {
            theta[self.parameter] = self.best.theta[self.parameter] + reach;
            let rise =
                self.problem.misfit(&theta).map(|misfit| cost(self.problem, loss, &misfit, &theta) - self.best.cost);
            match rise {
                Ok(rise) if rise <= NEAR * self.threshold => break,
                Ok(rise) => reach *= (self.threshold / rise).sqrt().max(0.1),
                Err(_) => reach *= 0.1,
            }
        }
        reach
    }

    /// The end between the value and `bound`, `reach` away by the local model.
    fn side(&mut self, near: &LocalModel, bound: f64, reach: f64) -> Side {
        let value = self.best.theta[self.parameter];
        let target = self.threshold.sqrt();
        if value == bound {
            return Side { end: None, why: End::BoundReached, rise: 0.0 };
        }
        let inside = |at: f64| if reach < 0.0 { at.max(bound) } else { at.min(bound) };
        let mut fresh: Option<Fresh> = None;
        let mut left = MOST_RELINEARISATIONS;
        // Values with the root of their rise: the last below the threshold, the first above.
        let mut below = (value, 0.0);
        let mut above: Option<(f64, f64)> = None;
        let mut from = self.best.clone();
        let (mut turns, mut last_side) = (0, None);
        // Distance and root of the rise of the last value.
        let mut last: Option<(f64, f64)> = None;
        let mut at = inside(value + reach);
        // How far from a value below the next may lie: a stride that has failed is halved, and doubled again from where it holds.
        let mut stride = f64::INFINITY;
        for _ in 0..MOST_VALUES {
            let point = match self.held_at(near, &mut fresh, &from, at, &mut left) {
                Ok(point) => point,
                Err(why) => {
                    if (at - below.0).abs() < 1e-3 * reach.abs() {
                        return Side { end: None, why, rise: below.1 * below.1 };
                    }
                    stride = 0.5 * (at - below.0).abs();
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
            self.points.push(ProfilePoint { value: at, rise: rise.max(0.0) });
            let root = rise.max(0.0).sqrt();
            if (rise / self.threshold - 1.0).abs() < CLOSE {
                let seen = [below, (at, root)].map(|(at, root)| (at - value, root));
                let end = value + self.crossing(near, seen, target);
                return Side { end: Some(inside(end)), why: End::Crossed, rise };
            }
            let here = ((at - value).abs(), root);
            let powered = last.replace(here).and_then(|last| along_a_power([last, here], target));
            let powered = powered.map(|distance| value + distance.copysign(reach));
            let inner = root < target;
            turns = if last_side == Some(inner) { turns + 1 } else { 0 };
            last_side = Some(inner);
            if inner {
                stride *= 2.0;
                below = (at, root);
                from = point;
                if at == bound {
                    return Side { end: None, why: End::BoundReached, rise };
                }
            } else {
                above = Some((at, root));
            }
            at = match above {
                // Between a value below and one above: where the rise of the last two leads, else on the chord, but not at its ends;
                // halfway where that keeps falling on one side.
                Some(above) => {
                    let chord = (target - below.1) / (above.1 - below.1);
                    let led = powered.map_or(chord, |at| (at - below.0) / (above.0 - below.0));
                    let share = if turns > 1 { 0.5 } else { led.clamp(0.1, 0.9) };
                    below.0 + share * (above.0 - below.0)
                }
                None => {
                    let slope = below.1 / (below.0 - value);
                    let straight = value + (target / slope).clamp(-1e300, 1e300);
                    let further = powered.unwrap_or(straight);
                    let most = value + 4.0 * (below.0 - value);
                    inside(if reach < 0.0 { further.max(most) } else { further.min(most) })
                }
            };
            at = at.clamp(below.0 - stride, below.0 + stride);
        }
        Side { end: None, why: End::GaveUp, rise: below.1 * below.1 }
    }

    /// The best fit with the parameter held, from another one; relinearised where much is still promised. Why there is none, where
    /// the model fails, or the fit does not settle: from where it was led, the best is not near.
    fn held_at(
        &self,
        near: &LocalModel,
        fresh: &mut Option<Fresh>,
        from: &Fit,
        at: f64,
        left: &mut usize,
    ) -> Result<Fit, End> {
        let enough = 0.5 * STALE * self.threshold;
        let held = Held::new(self.problem, self.parameter, at);
        let (model, direction) =
            fresh.as_ref().map_or((near, &self.direction), |fresh| (&fresh.model, &fresh.direction));
        let start = self.follow(model, direction, from, at);
        let mut point =
            fit_along(&held, model, &start, Options::steps(STEPS.0, enough)).map_err(|_| End::ModelFails)?;
        let better = |point: &Fit| point.cost < self.best.cost - BETTER * self.threshold;
        let (mut taken, mut retaken) = (0, None);
        while undone(&point) > STALE * self.threshold && taken < *left {
            let before = undone(&point);
            let Ok(model) = LocalModel::at(&held, &point.theta, near.loss) else { break };
            let Ok(further) = fit_along(&held, &model, &point.theta, Options::steps(STEPS.1, enough)) else { break };
            point = further;
            if undone(&point) > CONTRACTS * before && !better(&point) {
                return Err(End::GaveUp);
            }
            taken += 1;
            let direction = model.information(self.problem).ok().and_then(|known| known.direction(self.parameter));
            retaken = direction.map(|direction| Fresh { model, direction }).or(retaken);
        }
        // A rise that is off by more than two values may be apart says nothing.
        if undone(&point) > CLOSE * self.threshold && !better(&point) {
            return Err(End::GaveUp);
        }
        *left -= taken;
        if retaken.is_some() {
            *fresh = retaken;
        }
        Ok(point)
    }

    /// Everything as a local model expects it with the parameter held at a value.
    fn follow(&self, model: &LocalModel, direction: &DVector<f64>, from: &Fit, at: f64) -> Vec<f64> {
        let own = direction[self.parameter] * model.scale[self.parameter];
        let share = (at - from.theta[self.parameter]) / own;
        let moved = direction.iter().zip(&model.scale).map(|(along, scale)| share * along * scale);
        from.theta.iter().zip(moved).map(|(theta, moved)| theta + moved).collect()
    }

    /// Distance from the best value at which the root of the rise is `target`: on the parabola through the best value, and
    /// two `seen` distances with their roots. Where the first of them is the best value itself, the parabola has the slope
    /// that the local model gives it there.
    fn crossing(&self, near: &LocalModel, seen: [(f64, f64); 2], target: f64) -> f64 {
        let [(inner, inner_root), (outer, outer_root)] = seen;
        let slope = (self.direction[self.parameter].sqrt() * near.scale[self.parameter]).recip() * outer.signum();
        let (first, last) = (if inner == 0.0 { slope } else { inner_root / inner }, outer_root / outer);
        let bend = (last - first) / (outer - inner);
        let straight = inner + (outer - inner) * (target - inner_root) / (outer_root - inner_root);
        // Newton's method from the chord; the parabola is all but straight between two points of one side.
        let mut at = straight;
        for _ in 0..4 {
            let (chord, rise) = (first + bend * (at - inner), first + bend * (2.0 * at - inner));
            at -= (at * chord - target) / rise;
        }
        // A parabola that has turned back says nothing.
        let near_chord = (at - straight).abs() <= 0.25 * (straight - inner).abs() && at.is_finite();
        if near_chord { at } else { straight }
    }
}

/// The distance from the best value at which the root of the rise is `target`, on the power of the distance that goes through two others:
/// it vanishes at the best value, and behind a law that bends it is no straight line (leak through a gap: its third power). `None` where
/// they are on none that rises.
fn along_a_power([(one, root), (other, other_root)]: [(f64, f64); 2], target: f64) -> Option<f64> {
    let power = (other_root / root).ln() / (other / one).ln();
    let distance = other * (target / other_root).powf(power.recip());
    (power.is_finite() && power > 0.0 && distance.is_finite() && distance > 0.0).then_some(distance)
}

/// Decrease of `2 F` that a fit could still make by its local model, whether or not a step could be found that makes it.
fn undone(fit: &Fit) -> f64 {
    match fit.stopped {
        StoppedBecause::NoFurtherDecrease { promised, .. } => promised * fit.cost,
        _ => fit.promised,
    }
}

/// A local model taken on the way, and the direction of the parameter in it.
struct Fresh {
    model: LocalModel,
    direction: DVector<f64>,
}
