//! Sums over long series.

use super::wide::wide;

/// Running sums of a scalar product, so that the additions need not wait for each other: four wide registers of them.
const SUMS: usize = 16;

/// [`dot`] where it is called, for code that is compiled for wide registers itself.
#[inline(always)]
pub(crate) fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (whole_a, whole_b) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = whole_a.remainder().iter().zip(whole_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in whole_a.zip(whole_b) {
        for k in 0..SUMS {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

wide! {
    /// Scalar product of two series of one length.
    pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
        sum_of_products(a, b)
    }
}

wide! {
    /// Takes from a series what it has along a direction of length 1, times a share.
    pub(crate) fn take_along(series: &mut [f64], direction: &[f64], share: f64) {
        let along = share * sum_of_products(series, direction);
        for (slot, direction) in series.iter_mut().zip(direction) {
            *slot -= along * direction;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_is_taken_by_its_share() {
        let direction: Vec<f64> = (0..37).map(|i| (f64::from(i) * 0.7).sin()).collect();
        let length = dot(&direction, &direction).sqrt();
        let unit: Vec<f64> = direction.iter().map(|value| value / length).collect();
        approx::assert_relative_eq!(length.powi(2), direction.iter().map(|v| v * v).sum::<f64>(), max_relative = 1e-14);
        let mut series: Vec<f64> = unit.iter().enumerate().map(|(i, value)| 3.0 * value + 0.1 * i as f64).collect();
        let before = dot(&series, &unit);
        take_along(&mut series, &unit, 0.75);
        approx::assert_relative_eq!(dot(&series, &unit), 0.25 * before, max_relative = 1e-13);
    }
}
