//! Isolation: which set of faults explains the record, each set with its probability.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::estimate::Estimate;
use crate::fit::{Conditional, Interval};

/// Probability of each fault before the record is seen.
const PRIOR: f64 = 0.1;
/// A set whose price alone makes it this much less probable (difference of logarithms) than the best is not fitted anew.
const HOPELESS: f64 = 12.0;
/// Nor is one whose rise, by the linear model, is this many times larger than what would decide: laws bend, but not so far.
const DECISIVE: f64 = 400.0;
/// Most sets that are fitted anew.
const MOST_FITS: usize = 64;
/// Up to this many faults every set is weighed.
const ALL_SETS: usize = 10;
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
/// Rises are taken from the linear model first; where that leaves a set in question, it is fitted anew.
/// Sets with a fault about which the record says nothing (`blind`) are left out: such a fault can neither be claimed nor bear
/// what others cannot.
pub fn weigh(
    estimate: &Estimate<'_>,
    intervals: &[Interval],
    blind: &[bool],
    conditional: &mut Conditional<'_, super::problem::RecordProblem<'_>>,
) -> Weighed {
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
    // How much colour in the misfits takes from the rise of a set.
    let calm = |set: u64| (0..n).filter(|i| set & (1 << i) == 0).map(|i| inflation[i]).fold(1.0, f64::max);
    let score = |set: u64, rise: f64| -> f64 {
        -0.5 * rise / calm(set) + (0..n).filter(|i| set & (1 << i) != 0).map(|i| price[i]).sum::<f64>()
    };
    let priced = |set: u64| score(set, 0.0);
    let information = Information::of(estimate, n);
    // The faults whose absence alone the record does not bear.
    let all: u64 = (1 << n) - 1;
    let unseen = (0..n).filter(|&i| blind.get(i).copied().unwrap_or(false)).fold(0_u64, |set, i| set | 1 << i);
    let near = (0..n).filter(|&i| information.rise(all & !(1 << i)) > DECISIVE).fold(0, |set, i| set | 1 << i);
    let mut sets: Vec<(u64, f64)> = candidates(n, near)
        .into_iter()
        .filter(|set| set & unseen == 0)
        .map(|set| (set, score(set, information.rise(set))))
        .collect();
    sets.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut fitted = 0;
    for index in 0..sets.len() {
        let set = sets[index].0;
        let best = sets.iter().map(|(_, score)| *score).fold(f64::NEG_INFINITY, f64::max);
        let decided = priced(set) < best - HOPELESS || information.rise(set) > DECISIVE * calm(set);
        if set == all || decided || fitted == MOST_FITS {
            continue;
        }
        let held: Vec<(usize, f64)> =
            (0..n).filter(|i| set & (1 << i) == 0).map(|i| (i, rig.faults[i].healthy)).collect();
        fitted += 1;
        let from = conditional.origin().clone();
        // A set with which the model cannot be solved keeps its guess.
        if let Ok(found) = conditional.walk(&from, &held, false) {
            sets[index].1 = score(set, 2.0 * (found.cost - estimate.fit.cost).max(0.0));
        }
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
    Weighed { hypotheses, faults: faults.into_iter().map(|p: f64| p.min(1.0)).collect() }
}

/// Sets to be weighed, as bits. Of few faults all; of many, those of up to two, and what lies within two faults of `near`,
/// the faults whose absence alone the record does not bear.
fn candidates(n: usize, near: u64) -> Vec<u64> {
    if n <= ALL_SETS {
        return (0..1 << n).collect();
    }
    let all = (1 << n) - 1;
    let mut sets = vec![all];
    for centre in [0, near] {
        for a in 0..n {
            for b in 0..=a {
                let (a, b) = (1 << a, 1 << b);
                sets.extend([centre, centre ^ a, centre ^ a ^ b]);
            }
        }
    }
    sets.sort_unstable();
    sets.dedup();
    sets
}

/// What the misfits say of the faults near the optimum: `J'J`, everything else free to follow.
struct Information {
    matrix: DMatrix<f64>,
    /// How far each fault is from its healthy value.
    away: Vec<f64>,
}

impl Information {
    fn of(estimate: &Estimate<'_>, n: usize) -> Self {
        let jacobian = &estimate.fit.linearised.jacobian;
        let faults = &estimate.problem.model.rig.faults;
        let away = (0..n).map(|i| estimate.fit.theta[i] - faults[i].healthy).collect();
        Self { matrix: jacobian.tr_mul(jacobian), away }
    }

    /// Rise of chi-square, in the linear model, when the faults outside `set` are held at their healthy values. Bounds of
    /// the others are ignored, so that it is never too high on their account.
    fn rise(&self, set: u64) -> f64 {
        let (mut held, mut free) = (Vec::new(), Vec::new());
        for j in 0..self.matrix.nrows() {
            let informed = self.matrix[(j, j)] > 0.0;
            if j < self.away.len() && set & (1 << j) == 0 {
                held.push(j);
            } else if informed {
                free.push(j);
            }
        }
        let pick = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |a, b| {
                // Scaled to a unit diagonal: parameters differ by many powers of ten.
                let size = |k: usize| self.matrix[(k, k)].sqrt().max(f64::MIN_POSITIVE);
                self.matrix[(rows[a], columns[b])] / (size(rows[a]) * size(columns[b]))
            })
        };
        let away = DVector::from_fn(held.len(), |k, _| self.away[held[k]] * self.matrix[(held[k], held[k])].sqrt());
        let direct = away.dot(&(pick(&held, &held) * &away));
        let across = pick(&free, &held) * &away;
        let mut inner = pick(&free, &free);
        for k in 0..free.len() {
            inner[(k, k)] += 1e-12;
        }
        let taken_up = inner.cholesky().map_or(direct, |factor| across.dot(&factor.solve(&across)));
        (direct - taken_up).max(0.0)
    }
}
