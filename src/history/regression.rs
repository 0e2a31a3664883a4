//! A straight line through values of different certainty.

use nalgebra::{Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    /// Above 0.
    pub sigma: f64,
}

/// The line `y = level + slope (x - at)`, with `at` the weighted mean of `x`, so that level and slope are independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    pub at: f64,
    pub level: f64,
    pub slope: f64,
    /// Standard error of the level.
    pub level_sigma: f64,
    /// Standard error of the slope.
    pub slope_sigma: f64,
    /// Standard deviation between runs beyond what the standard errors of the values say.
    pub scatter: f64,
    /// Student's factor for 95 % on both sides.
    pub t: f64,
}

impl Line {
    /// The line through points, each weighted by its variance and the scatter between runs, which is as large as makes the
    /// squares of the weighted misfits add up to their number less two (Paule and Mandel, J. Res. Natl. Bur. Stand. 87 (1982)
    /// 377). `None` for fewer than three points, or all at one `x`.
    pub fn through(points: &[Point]) -> Option<Self> {
        let usable = points.iter().all(|point| point.sigma > 0.0 && point.x.is_finite() && point.y.is_finite());
        if points.len() < 3 || !usable {
            return None;
        }
        let freedom = (points.len() - 2) as f64;
        let excess = |scatter: f64| Some(weighted(points, scatter)?.squares - freedom);
        let mut scatter = 0.0;
        if excess(0.0)? > 0.0 {
            // More scatter makes smaller squares: double until it is too much, then halve the step in between.
            let (mut low, mut high) = (0.0, points.iter().map(|point| point.sigma).fold(f64::INFINITY, f64::min));
            while excess(high)? > 0.0 {
                (low, high) = (high, 2.0 * high);
            }
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                if excess(middle)? > 0.0 { low = middle } else { high = middle }
            }
            scatter = high;
        }
        let sums = weighted(points, scatter)?;
        let t = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975);
        Some(Self {
            at: sums.at,
            level: sums.level,
            slope: sums.slope,
            level_sigma: sums.weight.sqrt().recip(),
            slope_sigma: sums.spread.sqrt().recip(),
            scatter,
            t,
        })
    }

    /// The line at `x`.
    pub fn value(&self, x: f64) -> f64 {
        self.level + self.slope * (x - self.at)
    }

    /// Half the width of the 95 % interval of the line at `x`.
    pub fn half_width(&self, x: f64) -> f64 {
        self.t * self.level_sigma.hypot(self.slope_sigma * (x - self.at))
    }

    /// The 95 % interval of the slope.
    pub fn slope_interval(&self) -> [f64; 2] {
        [self.slope - self.t * self.slope_sigma, self.slope + self.t * self.slope_sigma]
    }
}

struct Sums {
    weight: f64,
    at: f64,
    level: f64,
    slope: f64,
    /// Weighted sum of squares of `x` about its mean.
    spread: f64,
    /// Weighted squares of the misfits.
    squares: f64,
}

fn weighted(points: &[Point], scatter: f64) -> Option<Sums> {
    let weight_of = |point: &Point| (point.sigma * point.sigma + scatter * scatter).recip();
    let weight: f64 = points.iter().map(weight_of).sum();
    let mean = |value: fn(&Point) -> f64| points.iter().map(|p| weight_of(p) * value(p)).sum::<f64>() / weight;
    let (at, level) = (mean(|point| point.x), mean(|point| point.y));
    let spread: f64 = points.iter().map(|p| weight_of(p) * (p.x - at).powi(2)).sum();
    if spread.is_nan() || spread <= 0.0 {
        return None;
    }
    let slope = points.iter().map(|p| weight_of(p) * (p.x - at) * (p.y - level)).sum::<f64>() / spread;
    let squares = points.iter().map(|p| weight_of(p) * (p.y - level - slope * (p.x - at)).powi(2)).sum();
    Some(Sums { weight, at, level, slope, spread, squares })
}

/// How clearly the values bend away from the line: the coefficient of a square term over its standard error, positive where
/// the slope rises. `None` for fewer than six points.
pub fn bend(points: &[Point], line: &Line) -> Option<f64> {
    if points.len() < 6 {
        return None;
    }
    let scale = points.iter().map(|point| (point.x - line.at).abs()).fold(0.0, f64::max);
    let mut normal = Matrix3::<f64>::zeros();
    let mut right = Vector3::<f64>::zeros();
    for point in points {
        let u = (point.x - line.at) / scale;
        let row = Vector3::new(1.0, u, u * u);
        let weight = (point.sigma * point.sigma + line.scatter * line.scatter).recip();
        normal += row * row.transpose() * weight;
        right += row * ((point.y - line.value(point.x)) * weight);
    }
    let covariance = normal.cholesky()?.inverse();
    let ratio = (covariance * right)[2] / covariance[(2, 2)].sqrt();
    ratio.is_finite().then_some(ratio)
}
