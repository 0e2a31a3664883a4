//! Whether the cost of a calibration rises as its derivatives say, one standard deviation away.
//!
//! A pressure that begins to rise where a motor breaks away begins earlier with a little more flow. Rows at such a moment have steep
//! derivatives that hold for a thousandth of that flow only; a fit ends in the first dimple that they make, and its covariance is that
//! of the dimple. So the cost itself is asked to both sides along each principal direction.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::joint::Joint;
use crate::estimation::Problem;

/// Share of the variance of the data sheet from which on records say nothing of a direction: it is left as it is.
const UNTOLD: f64 = 0.9;

/// A principal direction of a covariance, in standard deviations of the data sheet.
pub(super) struct Along {
    /// Unit vector.
    pub direction: DVector<f64>,
    /// Variance by the derivatives.
    pub white: f64,
    /// What the cost rises by, one standard deviation by the derivatives to either side; infinite where the model cannot be solved.
    pub rises: [f64; 2],
}

impl Along {
    /// By how much more variance the cost leaves than its derivatives say.
    pub fn flatness(&self) -> f64 {
        let rise = 0.5 * (self.rises[0] + self.rises[1]);
        // A cost that does not rise at all leaves what the data sheet does.
        if rise > 0.0 { rise.recip().max(1.0) } else { f64::INFINITY }
    }

    /// How many standard deviations lead to the bottom of the parabola through the three values, where that is below the middle one.
    fn bottom(&self) -> Option<f64> {
        let [below, above] = self.rises;
        let curvature = 0.5 * (below + above);
        let least = below.min(above);
        if least >= 0.0 || !least.is_finite() {
            return None;
        }
        let side = if below < above { -1.0 } else { 1.0 };
        Some(if curvature > 0.0 { (0.25 * (below - above) / curvature).clamp(-1.0, 1.0) } else { side })
    }
}

/// The principal directions of a covariance (SI) that is white, with what the cost does along them.
pub(super) fn along(joint: &Joint<'_>, theta: &[f64], white: &DMatrix<f64>) -> Vec<Along> {
    let sheet = DVector::from_column_slice(&joint.prior.sigma);
    let per_sheet = DMatrix::from_fn(sheet.len(), sheet.len(), |i, j| white[(i, j)] / (sheet[i] * sheet[j]));
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(per_sheet);
    let middle = cost(joint, theta);
    let one = |(direction, &white): (nalgebra::DVectorView<'_, f64>, &f64)| {
        let direction = direction.into_owned();
        if white > UNTOLD {
            return Along { direction, white, rises: [1.0; 2] };
        }
        let rises = [-1.0, 1.0].map(|side| cost(joint, &moved(joint, theta, &direction, side * white.sqrt())) - middle);
        Along { direction, white, rises }
    };
    eigenvectors.column_iter().zip(eigenvalues.iter()).map(one).collect()
}

/// Where the cost is least along all directions together, by their parabolas; `None` where it is nowhere lower by a decrease.
pub(super) fn lower(joint: &Joint<'_>, theta: &[f64], all: &[Along], decrease: f64) -> Option<Vec<f64>> {
    let bottoms = all.iter().filter_map(|one| Some((one, one.bottom()?)));
    let mut found: Option<(f64, Vec<f64>)> = None;
    for (one, steps) in bottoms {
        let from = found.as_ref().map_or(theta, |(_, theta)| theta.as_slice());
        let there = moved(joint, from, &one.direction, steps * one.white.sqrt());
        let cost = cost(joint, &there);
        if cost < found.as_ref().map_or_else(|| self::cost(joint, theta) - decrease, |(least, _)| *least) {
            found = Some((cost, there));
        }
    }
    found.map(|(_, theta)| theta)
}

/// Some standard deviations of the data sheet along a direction, within the bounds.
fn moved(joint: &Joint<'_>, theta: &[f64], direction: &DVector<f64>, by: f64) -> Vec<f64> {
    let bounds = joint.bounds.iter().zip(&joint.prior.sigma);
    let one = |((theta, along), ((low, high), sigma)): ((&f64, &f64), (&(f64, f64), &f64))| {
        (theta + by * along * sigma).clamp(*low, *high)
    };
    theta.iter().zip(direction.iter()).zip(bounds).map(one).collect()
}

fn cost(joint: &Joint<'_>, theta: &[f64]) -> f64 {
    let records = joint.misfit(theta).map(|misfit| misfit.iter().map(|r| r * r).sum::<f64>());
    records.map_or(f64::INFINITY, |records| records + joint.prior.misfit(theta).norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dimple_is_told_from_the_bottom() {
        let of = |rises| Along { direction: DVector::from_element(1, 1.0), white: 1.0, rises };
        // A parabola with its bottom at 0.
        assert_eq!((of([1.0, 1.0]).flatness(), of([1.0, 1.0]).bottom()), (1.0, None));
        // (t - 0.8)^2 / 4 less its value at 0: a quarter as steep, and lower at 0.8.
        let flat = of([0.65, -0.15]);
        assert!((flat.flatness() - 4.0).abs() < 1e-12);
        assert!((flat.bottom().unwrap() - 0.8).abs() < 1e-12);
        // One that falls without end is followed for one standard deviation.
        assert_eq!(of([1.0, -2.0]).bottom(), Some(1.0));
        assert_eq!(of([1.0, -1.0]).flatness(), f64::INFINITY);
        assert_eq!(of([f64::INFINITY, f64::INFINITY]).flatness(), 1.0);
    }
}
