//! How well the parameters are known at an optimum, and why a figure is missing where it is.

use super::autocorrelation::scores_variance;
use super::{Bound, LocalModel};
use nalgebra::{DMatrix, DVector};
use std::fmt;
use std::ops::Range;

/// Why a parameter has no standard error.
#[derive(Debug, Clone, PartialEq)]
pub enum Missing {
    /// The optimum lies on a bound: the cost is not a parabola around it. A profile still gives the open-ended interval.
    AtBound,
    /// The misfits do not change with it at this point.
    Insensitive,
    /// Only a combination is known: `(k, slope)` says that parameter `k` can be moved by `slope` units per unit of this
    /// one without changing the misfits.
    TiedTo(Vec<(usize, f64)>),
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtBound => write!(f, "at a bound"),
            Self::Insensitive => write!(f, "without influence on the measurements"),
            Self::TiedTo(others) => {
                write!(f, "tied to")?;
                for (n, (k, slope)) in others.iter().enumerate() {
                    write!(f, "{} parameter {k} ({slope:.3e} per unit)", if n == 0 { "" } else { "," })?;
                }
                Ok(())
            }
        }
    }
}

/// What is known of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Noise {
    /// The misfits were divided by the true standard deviations: their variance is 1.
    #[default]
    Known,
    /// Their common variance is taken from the misfits, `sum r^2 / (m - free parameters)`.
    FromMisfit,
}

/// How the uncertainty is computed.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertaintyOptions {
    /// What is known of the noise.
    pub noise: Noise,
    /// The parts of the misfit vector that are time series at a constant rate, one per sensor and record. Different
    /// series are taken as independent. Empty: the misfit is taken as white, and nothing is inflated.
    pub series: Vec<Range<usize>>,
    /// Singular values of the Jacobian, its columns scaled to length one, below this are a tie. The default, 1e-8, is
    /// where rounding in the sensitivities ends; noisy sensitivities want more.
    pub tie: f64,
}

impl Default for UncertaintyOptions {
    fn default() -> Self {
        Self { noise: Noise::Known, series: Vec::new(), tie: 1e-8 }
    }
}

/// How well the parameters are known at an optimum.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Variance of a misfit that the covariance is based on: 1 if known, without unit.
    pub variance: f64,
    /// `p` by `p`, in the product of the units, for white misfits; NaN in rows and columns of a missing parameter.
    pub covariance: DMatrix<f64>,
    /// The same, with autocorrelated misfits accounted for (sandwich with a Bartlett kernel); equal to `covariance` where no
    /// series were given.
    pub sandwich: DMatrix<f64>,
    /// Standard error of each parameter, in its unit, inflated: `sqrt(covariance_ii * inflation_i)`.
    pub standard_error: Vec<Result<f64, Missing>>,
    /// `max(1, sandwich_ii / covariance_ii)`: by how much the variance of each parameter is underestimated if the misfit
    /// is taken as white (and, with known noise, of the size that the sensors promise). 1 where missing.
    pub inflation: Vec<f64>,
}

/// A column whose whole influence, over a typical magnitude, is below this share of the largest is no influence at all.
const INSENSITIVE: f64 = 1e-13;
/// Share of a parameter in a direction without influence that makes it part of the tie.
const LEAST_SHARE: f64 = 1e-4;

impl Uncertainty {
    /// The uncertainty at an optimum, from the local model there and the bounds that parameters lie on. Ranges in
    /// `options.series` beyond the misfits are cut off.
    ///
    /// Parameters at a bound are taken as fixed there. Source: Seber and Wild, *Nonlinear Regression* (1989), 2.1 and
    /// 6.2; Newey and West, Econometrica 55 (1987); for robust losses Huber and Ronchetti, *Robust Statistics*, 7.6.
    pub fn at(model: &LocalModel, at_bound: &[Option<Bound>], options: &UncertaintyOptions) -> Self {
        let p = model.count();
        let norms = model.triangle().column_norms();
        let influence = |j: usize| norms[j] / model.scale[j] * model.theta[j].abs().max(f64::MIN_POSITIVE.sqrt());
        let most = (0..p).map(influence).fold(0.0, f64::max);
        let mut missing: Vec<Option<Missing>> = (0..p)
            .map(|j| match at_bound[j] {
                _ if norms[j] == 0.0 => Some(Missing::Insensitive),
                Some(_) => Some(Missing::AtBound),
                None if model.theta[j] != 0.0 && influence(j) < INSENSITIVE * most => Some(Missing::Insensitive),
                None => None,
            })
            .collect();
        let free: Vec<usize> = (0..p).filter(|&j| missing[j].is_none()).collect();
        let inverse = scaled_inverse(model, &free, &norms, options.tie, &mut missing);
        let m = model.misfit.len();
        let known = inverse.ncols();
        let variance = match options.noise {
            Noise::Known => 1.0,
            Noise::FromMisfit => 2.0 * model.loss.cost(&model.misfit) / m.saturating_sub(known).max(1) as f64,
        };
        // In the units of the parameters from here on.
        let units = DMatrix::from_diagonal(&DVector::from_iterator(free.len(), free.iter().map(|&j| model.scale[j])));
        let naive = &units * &inverse * inverse.transpose() * &units * variance;
        let inflated = if options.series.is_empty() || known == 0 {
            naive.clone()
        } else {
            let correction = m as f64 / m.saturating_sub(known).max(1) as f64;
            let middle = scores_variance(model, &free, &inverse, &options.series) * correction;
            &units * &inverse * middle * inverse.transpose() * &units
        };
        let mut covariance = DMatrix::from_element(p, p, f64::NAN);
        let mut sandwich = covariance.clone();
        for (a, &i) in free.iter().enumerate().filter(|(_, i)| missing[**i].is_none()) {
            for (b, &j) in free.iter().enumerate().filter(|(_, j)| missing[**j].is_none()) {
                covariance[(i, j)] = naive[(a, b)];
                sandwich[(i, j)] = inflated[(a, b)];
            }
        }
        // f64::max ignores a NaN, so a missing parameter gets 1.
        let inflation: Vec<f64> = (0..p).map(|i| (sandwich[(i, i)] / covariance[(i, i)]).max(1.0)).collect();
        let standard_error = missing
            .into_iter()
            .enumerate()
            .map(|(i, reason)| reason.map_or_else(|| Ok((covariance[(i, i)] * inflation[i]).sqrt()), Err))
            .collect();
        Self { variance, covariance, sandwich, standard_error, inflation }
    }
}

/// `B` (free parameters per scale by known directions) with `B B^T = (J^T J)^+`; names the parameters that are tied.
fn scaled_inverse(
    model: &LocalModel,
    free: &[usize],
    norms: &[f64],
    tie: f64,
    missing: &mut [Option<Missing>],
) -> DMatrix<f64> {
    let n = free.len();
    let r = &model.triangle().r;
    let scaled = DMatrix::from_fn(r.nrows(), n, |i, a| r[(i, free[a])] / norms[free[a]]);
    if n == 0 {
        return DMatrix::zeros(0, 0);
    }
    let svd = scaled.svd(false, true);
    let Some(directions) = svd.v_t else {
        return DMatrix::zeros(n, 0);
    };
    let known: Vec<usize> = (0..n).filter(|&k| svd.singular_values[k] > tie).collect();
    let lost: Vec<DVector<f64>> =
        (0..n).filter(|k| !known.contains(k)).map(|k| directions.row(k).transpose()).collect();
    for (a, &i) in free.iter().enumerate() {
        let share = lost.iter().map(|v| v[a] * v[a]).sum::<f64>().sqrt();
        if share < LEAST_SHARE {
            continue;
        }
        // Of all directions without influence, the one that moves parameter i most: the projection of its axis.
        let along: DVector<f64> = lost.iter().map(|v| v * v[a]).fold(DVector::zeros(n), |sum, v| sum + v);
        let others = free.iter().enumerate().filter(|(b, _)| *b != a && along[*b].abs() > LEAST_SHARE * along[a]);
        let in_units = |j: usize| norms[j] / model.scale[j];
        let slopes = others.map(|(b, &j)| (j, along[b] / in_units(j) * in_units(i) / along[a]));
        missing[i] = Some(Missing::TiedTo(slopes.collect()));
    }
    DMatrix::from_fn(n, known.len(), |a, c| {
        directions[(known[c], a)] / (svd.singular_values[known[c]] * norms[free[a]])
    })
}
