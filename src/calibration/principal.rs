//! Covariance of a calibration whose misfits are not white.
//!
//! Misfits that resemble their neighbours say less than as many independent ones. How much less differs between combinations of
//! parameters: healthy records may tell a displacement badly and the flow that it makes together with a leak and the gain of a
//! meter well. A factor on the variance of each parameter would lose the second: a combination whose parts are inflated
//! differently no longer cancels. So the factor is that of a principal direction of the white covariance, in standard deviations
//! of the data sheet, along which estimates are independent. Where the cost rises by less than its derivatives say, the white variance is
//! that of the cost ([`super::along`]).

use nalgebra::{DMatrix, DVector};

use super::along::{Along, per_sheet};
use crate::estimation::{LocalModel, Series};

/// What the covariance is made from, all in SI.
pub(super) struct Sources<'a> {
    /// Its principal directions, with what the cost does along them.
    pub along: &'a [Along],
    /// Of the estimate by the records, phases as the independent units.
    pub clustered: &'a DMatrix<f64>,
    /// Standard deviations of the data sheet.
    pub sheet: &'a [f64],
    /// The misfits at the optimum and their derivatives.
    pub local: &'a LocalModel,
    /// The misfits as time series.
    pub series: &'a dyn Series,
}

/// Covariance of the parameters, SI: each principal direction with the largest of its variances, white, autocorrelated and
/// clustered, and no more than the data sheet leaves open.
pub(super) fn covariance(from: &Sources<'_>) -> DMatrix<f64> {
    let sheet = DVector::from_column_slice(from.sheet);
    let clustered = per_sheet(from.clustered, from.sheet);
    let mut sum = DMatrix::zeros(sheet.len(), sheet.len());
    for one in from.along {
        let (direction, white) = (&one.direction, (one.white * one.flatness()).min(1.0));
        let along = direction.component_mul(&sheet);
        let per_scale = along.map_with_location(|i, _, value| value / from.local.scale[i]);
        let inflation =
            from.local.inflation(&(from.local.jacobian() * per_scale), &from.local.misfit, 0.0, from.series);
        let variance = inflated(white, inflation, direction.dot(&(&clustered * direction)));
        sum.ger(variance, &along, &along, 1.0);
    }
    sum
}

/// Variance along one direction in variances of the data sheet, from the white one, the inflation of what the records say, and
/// the variance by phases. Of the information `1/white` the data sheet has 1 and the records the rest, so that the
/// sandwich is `white² (1 + (1/white - 1) inflation)`: the data sheet's own part is not inflated.
fn inflated(white: f64, inflation: f64, clustered: f64) -> f64 {
    let of_sheet = white * white;
    let autocorrelated = of_sheet + white * (1.0 - white).max(0.0) * inflation;
    white.max(autocorrelated).max(of_sheet + clustered).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::inflated;

    #[test]
    fn white_misfits_leave_the_variance_as_it_is() {
        assert!((inflated(0.3, 1.0, 0.0) - 0.3).abs() < 1e-15);
    }

    #[test]
    fn only_what_the_records_say_is_inflated() {
        // Records and data sheet say as much: half of the variance, of which the records' share counts threefold.
        assert!((inflated(0.5, 3.0, 0.0) - (0.25 + 0.25 * 3.0)).abs() < 1e-15);
        // Records that say nothing leave the data sheet.
        assert_eq!(inflated(1.0, 100.0, 0.0), 1.0);
    }

    #[test]
    fn nothing_is_known_worse_than_before() {
        assert_eq!(inflated(0.1, 100.0, 0.0), 1.0);
        assert_eq!(inflated(0.1, 1.0, 7.0), 1.0);
    }

    #[test]
    fn phases_that_differ_by_more_count() {
        assert!((inflated(0.01, 2.0, 0.05) - 0.0501).abs() < 1e-15);
    }
}
