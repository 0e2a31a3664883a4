//! Isolation: which set of faults explains the record, each set with its probability.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::estimate::Estimate;
use crate::fit::{Conditional, FitError, Interval};

/// Probability of each fault before the record is seen.
const PRIOR: f64 = 0.1;
/// A set this much less probable (difference of log probabilities) than the best is not fitted anew: its place in the
/// list is certain whatever its exact figure.
const HOPELESS: f64 = 12.0;
/// Most sets that are fitted anew.
const MOST_FITS: usize = 64;
/// Sets with less probability are left out of the list.
const NEGLIGIBLE: f64 = 1e-6;

/// A set of faults and its probability.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hypothesis {
    /// Ids; empty for the healthy rig.
    pub faults: Vec<String>,
    pub probability: f64,
}

/// Sets of faults with their probabilities.
pub struct Weighed {
    /// The most probable first; probabilities sum to one but for what is negligible.
    pub hypotheses: Vec<Hypothesis>,
    /// Probability of each fault of the rig, over all sets.
    pub faults: Vec<f64>,
}

/// Weighs all sets of faults by Laplace's approximation to their evidence: the rise of chi-square when the faults outside
/// the set are held at their healthy values, and for each fault in it the share of its range that the record leaves,
/// `sqrt(2 pi) sigma / range`. Kass and Raftery, JASA 90 (1995), section 4.1.
///
/// Rises are taken from the quadratic form of the covariance first; where that leaves a set in question, it is fitted anew.
///
/// # Errors
/// If the model fails with faults held at their healthy values.
pub fn weigh(
    estimate: &Estimate<'_>,
    intervals: &[Interval],
    conditional: &mut Conditional<'_, super::problem::RecordProblem<'_>>,
) -> Result<Weighed, FitError> {
    let rig = &estimate.problem.model.rig;
    let n = rig.faults.len();
    let inflation = &estimate.uncertainty.inflation;
    let price: Vec<f64> = (0..n)
        .map(|i| {
            let fault = &rig.faults[i];
            let range = fault.bounds.1 - fault.bounds.0;
            let left = match &estimate.uncertainty.standard_error[i] {
                Ok(sigma) => *sigma,
                // At a bound: a one-sided interval tells the scale.
                Err(_) => {
                    let (low, high) =
                        (intervals[i].lower.unwrap_or(fault.bounds.0), intervals[i].upper.unwrap_or(fault.bounds.1));
                    (high - low) / 4.0
                }
            };
            ((2.0 * std::f64::consts::PI).sqrt() * left / range).min(1.0).ln() + (PRIOR / (1.0 - PRIOR)).ln()
        })
        .collect();
    let score = |set: usize, rise: f64| -> f64 {
        let out = (0..n).filter(|i| set & (1 << i) == 0).map(|i| inflation[i]);
        let calm = out.fold(1.0, f64::max);
        -0.5 * rise / calm + (0..n).filter(|i| set & (1 << i) != 0).map(|i| price[i]).sum::<f64>()
    };
    let mut sets: Vec<(usize, f64)> =
        candidates(n).into_iter().map(|set| (set, score(set, quadratic_rise(estimate, n, set)))).collect();
    sets.sort_by(|a, b| b.1.total_cmp(&a.1));
    let all = (1 << n) - 1;
    let mut fitted = 0;
    for index in 0..sets.len() {
        let (set, guess) = sets[index];
        let best = sets.iter().map(|(_, score)| *score).fold(f64::NEG_INFINITY, f64::max);
        if set == all || guess < best - HOPELESS || fitted == MOST_FITS {
            continue;
        }
        let held: Vec<(usize, f64)> =
            (0..n).filter(|i| set & (1 << i) == 0).map(|i| (i, rig.faults[i].healthy)).collect();
        fitted += 1;
        let from = conditional.origin().clone();
        let found = conditional.walk(&from, &held, false)?;
        sets[index].1 = score(set, 2.0 * (found.cost - estimate.fit.cost).max(0.0));
    }
    let best = sets.iter().map(|(_, score)| *score).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = sets.iter().map(|(_, score)| (score - best).exp()).sum();
    let mut faults = vec![0.0; n];
    let mut hypotheses = Vec::new();
    for (set, score) in sets {
        let probability = (score - best).exp() / total;
        let members: Vec<usize> = (0..n).filter(|i| set & (1 << i) != 0).collect();
        for &i in &members {
            faults[i] += probability;
        }
        if probability >= NEGLIGIBLE {
            let ids = members.iter().map(|&i| rig.parameters[rig.faults[i].parameter].id.clone()).collect();
            hypotheses.push(Hypothesis { faults: ids, probability });
        }
    }
    hypotheses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    Ok(Weighed { hypotheses, faults: faults.into_iter().map(|p| p.min(1.0)).collect() })
}

/// Sets to be weighed, as bits: all of up to three faults, and the set of all.
fn candidates(n: usize) -> Vec<usize> {
    let mut sets: Vec<usize> = Vec::new();
    for a in 0..n {
        for b in 0..=a {
            for c in 0..=b {
                sets.push(1 << a | 1 << b | 1 << c);
            }
        }
    }
    sets.push(0);
    sets.push((1 << n) - 1);
    sets.sort_unstable();
    sets.dedup();
    sets
}

/// Rise of chi-square, by the covariance, when the faults outside `set` are held at their healthy values.
fn quadratic_rise(estimate: &Estimate<'_>, n: usize, set: usize) -> f64 {
    let rig = &estimate.problem.model.rig;
    // A fault without a standard error sits at a bound; only a fit can say what leaving it costs.
    let held: Vec<usize> =
        (0..n).filter(|&i| set & (1 << i) == 0 && estimate.uncertainty.standard_error[i].is_ok()).collect();
    let away = DVector::from_fn(held.len(), |k, _| estimate.fit.theta[held[k]] - rig.faults[held[k]].healthy);
    let covariance =
        DMatrix::from_fn(held.len(), held.len(), |a, b| estimate.uncertainty.covariance[(held[a], held[b])]);
    covariance.cholesky().map_or(0.0, |factor| away.dot(&factor.solve(&away)))
}
