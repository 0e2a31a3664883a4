//! The variance of the scores when neighbouring misfits resemble each other.

#[cfg(feature = "internals")]
use std::ops::Range;

use nalgebra::DMatrix;
#[cfg(feature = "internals")]
use nalgebra::DVector;

#[cfg(feature = "internals")]
use super::LocalModel;
use crate::numeric::dot;

/// Strongest first-order autocorrelation that is believed: beyond it the plug-in formulas explode (Andrews and Monahan, 1992).
const STRONGEST: f64 = 0.97;

/// Long-run covariance of the scores `B^T J_t^T r_t`, summed over all series; the identity for white misfits of variance 1.
///
/// `B` makes the scores orthonormal, so that no parameter's unit weighs in the choice of the bandwidth. Each score is
/// whitened to first order, its Bartlett-weighted covariance summed, and the whitening undone: Andrews and Monahan,
/// Econometrica 60 (1992); kernel of Newey and West, Econometrica 55 (1987). Misfits outside every series count as white.
#[cfg(feature = "internals")]
pub(super) fn scores_variance(
    model: &LocalModel,
    free: &[usize],
    inverse: &DMatrix<f64>,
    series: &[Range<usize>],
) -> DMatrix<f64> {
    let (m, n) = (model.misfit.len(), inverse.ncols());
    let pull: Vec<f64> = model.misfit.iter().map(|&r| model.loss.weight(r) * r).collect();
    let scores: Vec<Vec<f64>> = (0..n)
        .map(|c| {
            let mut score = vec![0.0; m];
            for (a, &j) in free.iter().enumerate() {
                let share = inverse[(a, c)];
                score.iter_mut().zip(&model.jacobian().column(j)).for_each(|(sum, slope)| *sum += share * slope);
            }
            score.iter_mut().zip(&pull).for_each(|(score, pull)| *score *= pull);
            score
        })
        .collect();
    let mut total = DMatrix::zeros(n, n);
    let mut covered = vec![false; m];
    for range in series {
        let range = range.start.min(m)..range.end.min(m);
        if range.is_empty() {
            continue;
        }
        covered[range.clone()].fill(true);
        total += long_run(scores.iter().map(|score| score[range.clone()].to_vec()).collect());
    }
    for t in (0..m).filter(|&t| !covered[t]) {
        let score = DVector::from_iterator(n, scores.iter().map(|score| score[t]));
        total.ger(1.0, &score, &score, 1.0);
    }
    total
}

/// Long-run variance of a series of mean zero, times its length; its sum of squares if the series is white.
pub fn long_run_variance(scores: Vec<f64>) -> f64 {
    long_run(vec![scores])[(0, 0)]
}

/// Long-run covariance of scores `[score][time]` of one length, times that length: Bartlett kernel, lags after Andrews.
fn long_run(scores: Vec<Vec<f64>>) -> DMatrix<f64> {
    let (n, length) = (scores.len(), scores.first().map_or(0, Vec::len));
    let first: Vec<f64> = scores.iter().map(|score| first_order(score)).collect();
    let mut white = scores;
    for (score, first) in white.iter_mut().zip(&first) {
        for t in (1..length).rev() {
            score[t] -= first * score[t - 1];
        }
        // The first value has no predecessor; scaled, it keeps its share of the innovations' variance.
        if let Some(score) = score.first_mut() {
            *score *= (1.0 - first * first).sqrt();
        }
    }
    let lags = andrews(&white).min(length.saturating_sub(1));
    let mut sum = DMatrix::from_fn(n, n, |a, b| dot(&white[a], &white[b]));
    for lag in 1..=lags {
        let weight = 1.0 - lag as f64 / (lags + 1) as f64;
        let shifted = DMatrix::from_fn(n, n, |a, b| dot(&white[a][lag..], &white[b][..length - lag]));
        sum += (&shifted + shifted.transpose()) * weight;
    }
    DMatrix::from_fn(n, n, |a, b| sum[(a, b)] / ((1.0 - first[a]) * (1.0 - first[b])))
}

/// First-order autocorrelation, clipped to what is believed.
fn first_order(values: &[f64]) -> f64 {
    let Some(before) = values.len().checked_sub(1).map(|last| &values[..last]) else { return 0.0 };
    let square = dot(before, before);
    if square > 0.0 { (dot(&values[1..], before) / square).clamp(-STRONGEST, STRONGEST) } else { 0.0 }
}

/// Andrews' lag for the Bartlett kernel: `1.1447 (alpha T)^(1/3)`, his equations 6.2 and 6.4 with equal weights.
fn andrews(series: &[Vec<f64>]) -> usize {
    let length = series.first().map_or(0, Vec::len) as f64;
    let (mut above, mut below) = (0.0, 0.0);
    for values in series {
        let rho = first_order(values);
        let variance = dot(values, values) * (1.0 - rho * rho) / length;
        above += 4.0 * (rho * variance).powi(2) / ((1.0 - rho).powi(6) * (1.0 + rho).powi(2));
        below += variance.powi(2) / (1.0 - rho).powi(4);
    }
    if below > 0.0 { (1.1447 * (above / below * length).cbrt()).ceil() as usize } else { 0 }
}
