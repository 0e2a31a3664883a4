//! Profile likelihood: the interval that the data allow for one parameter, whatever the others do.
//!
//! Source: Venzon and Moolgavkar, Applied Statistics 37 (1988); Bates and Watts, *Nonlinear Regression Analysis and Its
//! Applications* (1988), chapter 6 (the signed root, nearly a straight line, is what is searched); Raue et al.,
//! Bioinformatics 25 (2009) for open ends.

use super::conditional::{Conditional, ConditionalFit};
use super::{Fit, FitError, Noise, Problem, Uncertainty, UncertaintyOptions};
use statrs::distribution::{ContinuousCDF, Normal};
use std::fmt;

/// Why an interval ends where it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The threshold is crossed there.
    Crossed,
    /// The bound, or the reach where there is no bound, comes first: the interval is open.
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
    /// `2 (cost - least cost)` there, not inflated.
    pub rise: f64,
}

/// The interval of one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// Index of the parameter.
    pub parameter: usize,
    /// Its value at the optimum, in its unit.
    pub value: f64,
    /// Confidence level, between 0 and 1.
    pub level: f64,
    /// Rise of `2 F` that ends the interval.
    pub threshold: f64,
    /// Lower end, in the parameter's unit; `None` where it is open.
    pub lower: Option<f64>,
    /// Upper end, in the parameter's unit; `None` where it is open.
    pub upper: Option<f64>,
    /// Why the lower end is what it is.
    pub lower_end: End,
    /// Why the upper end is what it is.
    pub upper_end: End,
    /// Both ends in one word.
    pub identifiable: Identifiable,
    /// Calls of [`Problem::misfit`] for this interval.
    pub misfit_evaluations: u64,
    /// Calls of [`Problem::linearise`] for this interval.
    pub linearisations: u64,
    /// What was evaluated, by rising value, the optimum included.
    pub points: Vec<ProfilePoint>,
    /// A better optimum than the fit's, if one turned up: fit again from its `theta`.
    pub better: Option<ConditionalFit>,
}

/// Draws profiles around one optimum.
#[derive(Debug)]
pub struct Profiler<'a, P: Problem> {
    conditional: Conditional<'a, P>,
    variance: f64,
    /// White standard errors for misfits of variance 1.
    errors: Vec<Option<f64>>,
}

/// Deviation of the signed root, as a share of the root of the threshold, that an end may have.
const END_TOLERANCE: f64 = 0.01;
/// Decrease of `2 F`, as a share of the threshold, that the search over the others may leave.
const INNER_TOLERANCE: f64 = 0.01;
/// Decrease of `2 F` below the optimum, as a share of the threshold, that makes it another optimum: less is what the
/// fit's own termination leaves.
const BETTER: f64 = 0.05;
/// Points inside a bracket after which its outer side is the end: a cost that jumps there by what integration leaves would
/// be bisected for ever.
const MOST_INSIDE: usize = 6;
/// Such a jump, as a share of the root of the threshold.
const ROUGH: f64 = 0.15;
/// Where there is no bound, the interval is open if it is longer than this many magnitudes of the parameter.
const REACH: f64 = 1e3;
const MOST_POINTS: usize = 40;

impl<'a, P: Problem> Profiler<'a, P> {
    /// Profiles of `problem` around its optimum `fit`.
    ///
    /// # Errors
    /// If lengths or bounds of the problem do not fit together.
    pub fn new(problem: &'a P, fit: &Fit) -> Result<Self, FitError> {
        let options = UncertaintyOptions { noise: Noise::Known, ..UncertaintyOptions::default() };
        let errors = Uncertainty::at(fit, &options).standard_error.into_iter().map(Result::ok).collect();
        Ok(Self { conditional: Conditional::new(problem, fit)?, variance: 1.0, errors })
    }

    /// Variance of a misfit, 1 unless set; [`Uncertainty::variance`] where the noise is not known.
    #[must_use]
    pub fn variance(mut self, variance: f64) -> Self {
        self.variance = variance;
        self
    }

    /// The best fits with parameters held, from the same optimum and on the same count of evaluations.
    pub fn conditional(&mut self) -> &mut Conditional<'a, P> {
        &mut self.conditional
    }

    /// The interval of parameter `i` at confidence `level`, from the threshold `inflation * variance * chi2_1(level)`.
    /// `inflation` is that of [`Uncertainty::inflation`]; 1 for white misfits.
    ///
    /// # Errors
    /// If there is no parameter `i`, or `level` is not between 0 and 1.
    pub fn interval(&mut self, i: usize, level: f64, inflation: f64) -> Result<Interval, FitError> {
        let p = self.errors.len();
        if i >= p {
            return Err(FitError::Length { what: "parameter to profile below the number", expected: p, found: i });
        }
        if !(level > 0.0 && level < 1.0) {
            return Err(FitError::Level { level });
        }
        let root = Normal::standard().inverse_cdf(0.5 * (1.0 + level));
        let unit = self.variance * inflation;
        let before = (self.conditional.misfit_evaluations, self.conditional.linearisations);
        self.conditional.set_tolerance(INNER_TOLERANCE * root * root * unit);
        let origin = self.conditional.origin().clone();
        let mut search = Search { i, root, unit, points: Vec::new(), better: None };
        search.points.push(ProfilePoint { value: origin.theta[i], rise: 0.0 });
        let (lower, lower_end) = search.end(&mut self.conditional, -1.0, self.errors[i]);
        let (upper, upper_end) = if search.better.is_some() {
            (None, End::BetterOptimum)
        } else {
            search.end(&mut self.conditional, 1.0, self.errors[i])
        };
        search.points.sort_by(|a, b| a.value.total_cmp(&b.value));
        let identifiable = match (lower, upper) {
            (Some(_), Some(_)) => Identifiable::Bounded,
            (Some(_), None) => Identifiable::LowerBoundOnly,
            (None, Some(_)) => Identifiable::UpperBoundOnly,
            (None, None) => Identifiable::Unidentifiable,
        };
        Ok(Interval {
            parameter: i,
            value: origin.theta[i],
            level,
            threshold: root * root * unit,
            lower,
            upper,
            lower_end,
            upper_end,
            identifiable,
            misfit_evaluations: self.conditional.misfit_evaluations - before.0,
            linearisations: self.conditional.linearisations - before.1,
            points: search.points,
            better: search.better,
        })
    }
}

/// `2 (cost - least cost)` and the parameters, with parameter `i` held at `value` and all others at their best.
///
/// # Errors
/// If the model fails wherever it is tried with this value.
pub fn profile_cost_at<P: Problem>(
    problem: &P,
    fit: &Fit,
    i: usize,
    value: f64,
) -> Result<(f64, ConditionalFit), FitError> {
    let found = Conditional::new(problem, fit)?.minimise_with_fixed(&[(i, value)])?;
    Ok((2.0 * (found.cost - fit.cost), found))
}

/// The search for the ends of one interval.
struct Search {
    i: usize,
    root: f64,
    unit: f64,
    points: Vec<ProfilePoint>,
    better: Option<ConditionalFit>,
}

impl Search {
    /// The end in one direction. The unknown is the distance from the optimum, the function the signed root of the rise.
    fn end<P: Problem>(
        &mut self,
        on: &mut Conditional<'_, P>,
        direction: f64,
        error: Option<f64>,
    ) -> (Option<f64>, End) {
        let origin = on.origin().clone();
        let center = origin.theta[self.i];
        let (lower, upper) = on.space().bounds[self.i];
        let scale = on.space().scale[self.i];
        let bound = if direction > 0.0 { upper } else { lower };
        let start = error.map_or(0.1 * scale, |e| self.root * self.unit.sqrt() * e);
        let open = REACH * scale.max(center.abs());
        let most = if bound.is_finite() { (bound - center).abs() } else { open };
        if most == 0.0 {
            return (None, End::BoundReached);
        }
        let value_at = |t: f64| {
            if t >= most && bound.is_finite() { bound } else { center + direction * t }
        };
        let mut inside = (0.0, 0.0);
        let mut nearest = origin.clone();
        let mut outside: Option<(f64, f64)> = None;
        let mut bracketed = 0;
        let mut fails: Option<f64> = None;
        let mut t = start.min(most);
        for round in 0..MOST_POINTS {
            let held = [(self.i, value_at(t))];
            let Some((mut found, mut z)) = self.root_at(on, &nearest, &held, false) else {
                fails = Some(t);
                if t - inside.0 < 1e-2 * t || round > MOST_POINTS / 2 {
                    return (None, End::ModelFails);
                }
                t = 0.5 * (inside.0 + t);
                continue;
            };
            let settled = (z - self.root).abs() <= END_TOLERANCE * self.root;
            let last = outside.is_some_and(|(o, above)| {
                let settled = bracketed >= MOST_INSIDE && above - inside.1 <= ROUGH * self.root;
                settled || o - inside.0 <= 1e-6 * o
            });
            bracketed += usize::from(outside.is_some());
            // Only an end that counts is worth a linearisation: a stale Jacobian can leave the cost too high.
            if (settled || last) && !found.exact {
                let Some(certain) = self.root_at(on, &found, &held, true) else {
                    return (None, End::ModelFails);
                };
                (found, z) = certain;
            }
            self.points.push(ProfilePoint { value: held[0].1, rise: 2.0 * (found.cost - origin.cost) });
            if 2.0 * (found.cost - origin.cost) < -BETTER * self.root * self.root * self.unit {
                self.better = Some(found);
                return (None, End::BetterOptimum);
            }
            if (z - self.root).abs() <= END_TOLERANCE * self.root {
                return (Some(value_at(t)), End::Crossed);
            }
            if let (true, Some((beyond, _))) = (last, outside) {
                // The outer side: an interval rather too long than too short.
                return (Some(value_at(if z < self.root { beyond } else { t })), End::Crossed);
            }
            if z < self.root {
                if t >= most {
                    return (None, End::BoundReached);
                }
                let slope = (z - inside.1) / (t - inside.0);
                inside = (t, z);
                nearest = found;
                outside = outside.filter(|(o, _)| *o > t);
                if outside.is_none() {
                    let ahead = if slope > 0.0 { 1.02 * (self.root - z) / slope } else { f64::INFINITY };
                    t = (t + ahead.max(1e-3 * t)).min(4.0 * t).min(most);
                    // Past a place where the model fails there is nothing to extrapolate to.
                    t = fails.filter(|f| t >= *f).map_or(t, |f| 0.5 * (inside.0 + f));
                    continue;
                }
            } else {
                outside = Some((t, z));
            }
            if let Some((o, above)) = outside {
                let width = o - inside.0;
                let secant = inside.0 + width * (self.root - inside.1) / (above - inside.1);
                let safe = secant.max(inside.0 + 0.02 * width).min(o - 0.02 * width);
                t = if round % 4 == 3 || !safe.is_finite() { inside.0 + 0.5 * width } else { safe };
            }
        }
        // Where there is a bracket its outer side is an end, if not a sharp one.
        (outside.map(|(o, _)| value_at(o)), End::GaveUp)
    }

    fn root_at<P: Problem>(
        &self,
        on: &mut Conditional<'_, P>,
        from: &ConditionalFit,
        held: &[(usize, f64)],
        certain: bool,
    ) -> Option<(ConditionalFit, f64)> {
        let found = on.walk(from, held, certain).ok()?;
        let rise = 2.0 * (found.cost - on.origin().cost);
        let z = (rise.max(0.0) / self.unit).sqrt();
        Some((found, z))
    }
}
