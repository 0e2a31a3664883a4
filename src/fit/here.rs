//! One point of a search.

use super::problem::{Linearised, Space};
use super::{Loss, Triangle};

/// All that is known at the current parameters.
#[derive(Debug, Clone)]
pub(super) struct Here {
    pub theta: Vec<f64>,
    pub cost: f64,
    pub seen: Linearised,
    pub triangle: Triangle,
    /// Square roots of the weights of the damping, one per parameter; never zero.
    pub lengths: Vec<f64>,
}

impl Here {
    pub fn new(theta: Vec<f64>, seen: Linearised, loss: Loss, space: &Space, before: &[f64]) -> Self {
        let triangle = Triangle::reduce(&seen, loss);
        let norms = triangle.column_norms();
        let most = norms.iter().zip(&space.scale).map(|(n, s)| n * s).fold(f64::MIN_POSITIVE, f64::max);
        // A column of zeros keeps a weight, so that the step is unique: the parameter stays where it is.
        let floor = |(n, s): (&f64, &f64)| n.max(1e-12 * most / s);
        let mut lengths: Vec<f64> = norms.iter().zip(&space.scale).map(floor).collect();
        // Moré's rule: where a parameter loses its influence, its damping stays, or it would run away for good.
        for (length, old) in lengths.iter_mut().zip(before) {
            *length = length.max(*old);
        }
        Self { cost: loss.cost(&seen.misfit), theta, seen, triangle, lengths }
    }

    /// Largest cosine between the misfit and a direction that the bounds leave open.
    pub fn cosine(&self, space: &Space) -> f64 {
        let total = self.triangle.z.norm().hypot(self.triangle.rest);
        let norms = self.triangle.column_norms();
        let mut largest = 0.0_f64;
        for (j, slope) in self.triangle.gradient().iter().enumerate() {
            let (lower, upper) = space.bounds[j];
            let blocked = (self.theta[j] <= lower && *slope > 0.0) || (self.theta[j] >= upper && *slope < 0.0);
            if !blocked && norms[j] > 0.0 && total > 0.0 {
                largest = largest.max(slope.abs() / (norms[j] * total));
            }
        }
        largest
    }
}
