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

/// Rise of the cost from which on its curvature is believed: half of that at one standard deviation.
const RISEN: f64 = 0.5;

/// A principal direction of a covariance, in standard deviations of the data sheet.
pub(super) struct Along {
    /// Unit vector.
    pub direction: DVector<f64>,
    /// Variance by the derivatives.
    pub white: f64,
    /// Standard deviations by the derivatives at which the cost was asked.
    pub step: f64,
    /// What it rises by there, to either side; infinite where the model cannot be solved.
    pub rises: [f64; 2],
}

impl Along {
    /// By how much more variance the cost leaves than its derivatives say.
    pub fn flatness(&self) -> f64 {
        // A cost that does not rise at all leaves what the data sheet does.
        if self.rise() > 0.0 { (self.step * self.step / self.rise()).max(1.0) } else { f64::INFINITY }
    }

    /// The mean of both sides.
    fn rise(&self) -> f64 {
        0.5 * (self.rises[0] + self.rises[1])
    }
}

/// A covariance (SI) in standard deviations of the data sheet.
pub(super) fn per_sheet(covariance: &DMatrix<f64>, sheet: &[f64]) -> DMatrix<f64> {
    covariance.map_with_location(|i, j, value| value / (sheet[i] * sheet[j]))
}

/// The principal directions of a covariance (SI) that is white, with what the cost does along them.
pub(super) fn along(joint: &Joint<'_>, theta: &[f64], white: &DMatrix<f64>) -> Vec<Along> {
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(per_sheet(white, &joint.prior.sigma));
    let middle = cost(joint, theta);
    let one = |(direction, &white): (nalgebra::DVectorView<'_, f64>, &f64)| {
        let direction = direction.into_owned();
        let mut one = Along { direction, white, step: 1.0, rises: [1.0; 2] };
        if white > UNTOLD {
            return one;
        }
        loop {
            let by = one.step * white.sqrt();
            one.rises = [-by, by].map(|by| cost(joint, &moved(joint, theta, &one.direction, by)) - middle);
            // Within a dimple it says little; beyond the data sheet nothing is asked.
            if one.rise() >= RISEN || 4.0 * by * by > 1.0 {
                return one;
            }
            one.step *= 2.0;
        }
    };
    eigenvectors.column_iter().zip(eigenvalues.iter()).map(one).collect()
}

/// Some standard deviations of the data sheet along a direction, within the bounds.
fn moved(joint: &Joint<'_>, theta: &[f64], direction: &DVector<f64>, by: f64) -> Vec<f64> {
    let one = |(index, theta): (usize, &f64)| {
        let (low, high) = joint.bounds[index];
        (theta + by * direction[index] * joint.prior.sigma[index]).clamp(low, high)
    };
    theta.iter().enumerate().map(one).collect()
}

fn cost(joint: &Joint<'_>, theta: &[f64]) -> f64 {
    let records = joint.misfit(theta).map(|misfit| misfit.iter().map(|r| r * r).sum::<f64>());
    records.map_or(f64::INFINITY, |records| records + joint.prior.misfit(theta).norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cost_that_rises_less_than_a_parabola_leaves_more() {
        let of = |rises| Along { direction: DVector::from_element(1, 1.0), white: 1.0, step: 1.0, rises };
        // A parabola with its bottom at 0.
        assert_eq!(of([1.0, 1.0]).flatness(), 1.0);
        // (t - 0.8)^2 / 4 less its value at 0: a quarter as steep, and lower at 0.8.
        let flat = of([0.65, -0.15]);
        assert!((flat.flatness() - 4.0).abs() < 1e-12);
        // One that does not rise.
        assert_eq!(of([1.0, -1.0]).flatness(), f64::INFINITY);
        assert_eq!(of([f64::INFINITY, f64::INFINITY]).flatness(), 1.0);
        // Four standard deviations away it has risen by 1.
        assert_eq!(Along { step: 4.0, ..of([1.0, 1.0]) }.flatness(), 16.0);
    }
}
