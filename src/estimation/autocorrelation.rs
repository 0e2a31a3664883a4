//! The variance of the scores when neighbouring misfits resemble each other.

use super::LocalModel;
use nalgebra::DMatrix;
use std::ops::Range;

/// Strongest first-order autocorrelation that is believed: beyond it the plug-in formulas explode (Andrews and Monahan, 1992).
const STRONGEST: f64 = 0.97;

/// Long-run covariance of the scores `B^T J_t^T r_t`, summed over all series; the identity for white misfits of variance 1.
///
/// `B` makes the scores orthonormal, so that no parameter's unit weighs in the choice of the bandwidth. Each score is
/// whitened to first order, its Bartlett-weighted covariance summed, and the whitening undone: Andrews and Monahan,
/// Econometrica 60 (1992); kernel of Newey and West, Econometrica 55 (1987). Misfits outside every series count as white.
pub(super) fn scores_variance(
    model: &LocalModel,
    free: &[usize],
    inverse: &DMatrix<f64>,
    series: &[Range<usize>],
) -> DMatrix<f64> {
    let (m, n) = (model.misfit.len(), inverse.ncols());
    let mut scores = DMatrix::zeros(n, m); // one column per misfit: neighbours in time are neighbours in memory
    for (t, &r) in model.misfit.iter().enumerate() {
        let pull = model.loss.weight(r) * r;
        for c in 0..n {
            let row: f64 = free.iter().enumerate().map(|(a, &j)| model.jacobian()[(t, j)] * inverse[(a, c)]).sum();
            scores[(c, t)] = row * pull;
        }
    }
    let mut total = DMatrix::zeros(n, n);
    let mut covered = vec![false; m];
    for range in series {
        let range = range.start.min(m)..range.end.min(m);
        if range.is_empty() {
            continue;
        }
        covered[range.clone()].fill(true);
        total += long_run(scores.columns(range.start, range.len()).into_owned());
    }
    for t in (0..m).filter(|&t| !covered[t]) {
        let score = scores.column(t);
        total.ger(1.0, &score, &score, 1.0);
    }
    total
}

/// Long-run variance of a series of mean zero, times its length; its sum of squares if the series is white.
pub fn long_run_variance(scores: &[f64]) -> f64 {
    long_run(DMatrix::from_row_slice(1, scores.len(), scores))[(0, 0)]
}

/// Long-run covariance of one series of scores, times its length: Bartlett kernel, lags after Andrews.
fn long_run(scores: DMatrix<f64>) -> DMatrix<f64> {
    let (n, length) = scores.shape();
    let first: Vec<f64> = (0..n).map(|c| first_order(scores.row(c).iter().copied())).collect();
    let mut white = scores;
    for t in (1..length).rev() {
        for c in 0..n {
            white[(c, t)] -= first[c] * white[(c, t - 1)];
        }
    }
    // The first value has no predecessor; scaled, it keeps its share of the innovations' variance.
    for c in 0..n {
        white[(c, 0)] *= (1.0 - first[c] * first[c]).sqrt();
    }
    let lags = andrews(&white).min(length.saturating_sub(1));
    let mut sum = &white * white.transpose();
    for lag in 1..=lags {
        let weight = 1.0 - lag as f64 / (lags + 1) as f64;
        let shifted = white.columns(lag, length - lag) * white.columns(0, length - lag).transpose();
        sum += (&shifted + shifted.transpose()) * weight;
    }
    DMatrix::from_fn(n, n, |a, b| sum[(a, b)] / ((1.0 - first[a]) * (1.0 - first[b])))
}

/// First-order autocorrelation, clipped to what is believed.
fn first_order(values: impl Iterator<Item = f64>) -> f64 {
    let (mut before, mut product, mut square) = (0.0, 0.0, 0.0);
    for v in values {
        product += v * before;
        square += before * before;
        before = v;
    }
    if square > 0.0 { (product / square).clamp(-STRONGEST, STRONGEST) } else { 0.0 }
}

/// Andrews' lag for the Bartlett kernel: `1.1447 (alpha T)^(1/3)`, his equations 6.2 and 6.4 with equal weights.
fn andrews(values: &DMatrix<f64>) -> usize {
    let (mut above, mut below) = (0.0, 0.0);
    for row in values.row_iter() {
        let rho = first_order(row.iter().copied());
        let variance = row.norm_squared() * (1.0 - rho * rho) / values.ncols() as f64;
        above += 4.0 * (rho * variance).powi(2) / ((1.0 - rho).powi(6) * (1.0 + rho).powi(2));
        below += variance.powi(2) / (1.0 - rho).powi(4);
    }
    if below > 0.0 { (1.1447 * (above / below * values.ncols() as f64).cbrt()).ceil() as usize } else { 0 }
}
