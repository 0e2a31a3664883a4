//! Whether one more parameter is worth what it explains.

use nalgebra::DMatrix;

use super::triangle::Triangle;

/// The Bayesian information criterion: `cost` is `2 F` of a fit of so many `parameters` to so many `samples`. Fewer parameters
/// are better where both explain the samples alike. Source: Schwarz, Annals of Statistics 6 (1978).
pub fn bic(cost: f64, parameters: usize, samples: f64) -> f64 {
    cost + parameters as f64 * samples.ln()
}

/// Occam factor: logarithm of the share of their prior volume that a record leaves some parameters, at most 0. Laplace's
/// approximation with a normal prior; `ratio` is a root of the information of the record (`ratio' ratio`), each column per
/// standard deviation before the record. Source: MacKay, Neural Computation 4 (1992).
pub(super) fn occam(ratio: DMatrix<f64>) -> f64 {
    let (rows, n) = ratio.shape();
    let mut stacked = ratio.resize(rows + n, n + 1, 0.0);
    (0..n).for_each(|k| stacked[(rows + k, k)] = 1.0);
    // Half the logarithm of the determinant is the sum of those of the triangle's diagonal.
    -Triangle::of(stacked).r.diagonal().iter().map(|d| d.abs().ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_is_worth_the_logarithm_of_the_samples() {
        approx::assert_relative_eq!(bic(10.0, 2, 100.0), 10.0 + 2.0 * 100f64.ln());
    }

    #[test]
    fn the_occam_factor_is_half_the_logarithm_of_the_determinant() {
        let ratio = DMatrix::from_row_slice(3, 2, &[3.0, 1.0, 0.0, 4.0, 2.0, -1.0]);
        let information = ratio.tr_mul(&ratio) + DMatrix::identity(2, 2);
        approx::assert_relative_eq!(occam(ratio), -0.5 * information.determinant().ln(), max_relative = 1e-12);
    }

    #[test]
    fn a_record_that_says_nothing_leaves_all_of_the_prior_volume() {
        assert_eq!(occam(DMatrix::zeros(4, 3)), 0.0);
    }
}
