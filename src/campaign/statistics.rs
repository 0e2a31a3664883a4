//! Rates with their bounds, quantiles, and the size found in most cases.

use serde::Serialize;
use statrs::distribution::{Beta, ContinuousCDF};

use crate::number::rounded;

/// Digits of a reported figure.
const DIGITS: usize = 6;
/// Standard normal quantile of one-sided 95 %.
const ONE_SIDED: f64 = 1.644_853_627;

/// How often something happened, with exact bounds (Clopper and Pearson, Biometrika 26 (1934), 404).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Rate {
    /// How often it happened.
    pub count: usize,
    /// How often it could have.
    pub of: usize,
    /// `None` of nothing.
    pub share: Option<f64>,
    /// Two-sided 95 % bounds.
    pub low95: f64,
    /// Upper two-sided 95 % bound.
    pub high95: f64,
    /// One-sided upper 95 % bound.
    pub upper95: f64,
}

impl Rate {
    /// `count` times of `of` chances.
    #[doc(hidden)]
    pub fn new(count: usize, of: usize) -> Self {
        Self {
            count,
            of,
            share: (of > 0).then(|| rounded(count as f64 / of as f64, DIGITS)),
            low95: rounded(lower(count, of, 0.025), DIGITS),
            high95: rounded(upper(count, of, 0.025), DIGITS),
            upper95: rounded(upper(count, of, 0.05), DIGITS),
        }
    }

    /// The share of items for which `is` holds.
    pub(crate) fn of<T>(items: impl IntoIterator<Item = T>, is: impl Fn(&T) -> bool) -> Self {
        let (mut count, mut of) = (0, 0);
        for item in items {
            of += 1;
            count += usize::from(is(&item));
        }
        Self::new(count, of)
    }
}

/// Least share at which `count` or more of `of` are still as probable as `tail`.
pub fn lower(count: usize, of: usize, tail: f64) -> f64 {
    if count == 0 { 0.0 } else { beta(count, of + 1 - count, tail, 0.0) }
}

/// Greatest share at which `count` or fewer of `of` are still as probable as `tail`.
pub fn upper(count: usize, of: usize, tail: f64) -> f64 {
    if count >= of { 1.0 } else { beta(count + 1, of - count, 1.0 - tail, 1.0) }
}

fn beta(a: usize, b: usize, at: f64, otherwise: f64) -> f64 {
    Beta::new(a as f64, b as f64).map_or(otherwise, |beta| beta.inverse_cdf(at))
}

/// The value that this share of the values does not exceed (the smallest that does); `None` of nothing.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).map(|value| rounded(*value, DIGITS))
}

/// Arithmetic mean; `None` of nothing.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| rounded(values.iter().sum::<f64>() / values.len() as f64, DIGITS))
}

/// The size from which on faults are found in 90 % of cases.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Found {
    /// Its size, in the unit of the parameter.
    pub size: f64,
    /// One-sided upper 95 % bound of it.
    pub upper95: f64,
    /// Sizes drawn: the smallest and the largest. Beyond them the curve is only continued.
    pub drawn: [f64; 2],
}

/// Sizes above 0 with whether they were found: logistic regression of the logarithm of the size, biased least by Firth's
/// penalty (Biometrika 80 (1993), 27), which also keeps it finite where all were found. The bound is by the delta method.
/// `None` where fewer than [`LEAST`] sizes tell, or larger ones are found no more often.
pub fn found_in_most(cases: &[(f64, bool)]) -> Option<Found> {
    let sizes: Vec<f64> = cases.iter().map(|(size, _)| size.ln()).collect();
    let count = sizes.len() as f64;
    if cases.len() < LEAST || sizes.iter().any(|size| !size.is_finite()) {
        return None;
    }
    let centre = sizes.iter().sum::<f64>() / count;
    let scale = (sizes.iter().map(|size| (size - centre).powi(2)).sum::<f64>() / count).sqrt();
    if scale <= 0.0 {
        return None;
    }
    let x: Vec<f64> = sizes.iter().map(|size| (size - centre) / scale).collect();
    let found: Vec<f64> = cases.iter().map(|(_, found)| f64::from(u8::from(*found))).collect();
    let ([a, b], inverse) = firth(&x, &found)?;
    if b <= 0.0 {
        return None;
    }
    let level = (MOST / (1.0 - MOST)).ln();
    let at = (level - a) / b;
    // Of at(a, b): derivatives -1/b and -at/b.
    let variance = (inverse[0][0] + 2.0 * at * inverse[0][1] + at * at * inverse[1][1]) / (b * b);
    let size = |at: f64| rounded((centre + scale * at).exp(), DIGITS);
    let drawn =
        [f64::min as fn(f64, f64) -> f64, f64::max].map(|pick| cases.iter().map(|(size, _)| *size).reduce(pick));
    Some(Found {
        size: size(at),
        upper95: size(at + ONE_SIDED * variance.sqrt()),
        drawn: [rounded(drawn[0]?, DIGITS), rounded(drawn[1]?, DIGITS)],
    })
}

/// Share of the cases in which a size is to be found.
pub const MOST: f64 = 0.9;
/// Fewest sizes that a curve is laid through.
pub const LEAST: usize = 8;

/// Penalised likelihood fit of `p = 1/(1 + exp(-a - b x))`: the coefficients, and their covariance.
fn firth(x: &[f64], found: &[f64]) -> Option<([f64; 2], [[f64; 2]; 2])> {
    const STEPS: usize = 200;
    let mut at = [0.0, 0.0];
    for _ in 0..STEPS {
        let p: Vec<f64> = x.iter().map(|x| 1.0 / (1.0 + (-at[0] - at[1] * x).exp())).collect();
        let sum = |term: &dyn Fn(usize) -> f64| (0..x.len()).map(term).sum::<f64>();
        let weight = |i: usize| p[i] * (1.0 - p[i]);
        let (h00, h01, h11) = (sum(&weight), sum(&|i| weight(i) * x[i]), sum(&|i| weight(i) * x[i] * x[i]));
        let determinant = h00 * h11 - h01 * h01;
        if determinant.is_nan() || determinant <= 0.0 {
            return None;
        }
        let inverse = [[h11 / determinant, -h01 / determinant], [-h01 / determinant, h00 / determinant]];
        let score = |i: usize| {
            let leverage = weight(i) * (inverse[0][0] + 2.0 * x[i] * inverse[0][1] + x[i] * x[i] * inverse[1][1]);
            found[i] - p[i] + leverage * (0.5 - p[i])
        };
        let gradient = [sum(&score), sum(&|i| score(i) * x[i])];
        let step = [0, 1].map(|k| inverse[k][0] * gradient[0] + inverse[k][1] * gradient[1]);
        let length = step[0].abs().max(step[1].abs());
        // A full step from far away may overshoot; one at most is safe on standardised sizes.
        let damping = 1.0 / length.max(1.0);
        at = [at[0] + damping * step[0], at[1] + damping * step[1]];
        if length < 1e-9 {
            return Some((at, inverse));
        }
    }
    None
}
