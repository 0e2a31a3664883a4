//! Many starts, so that the best optimum in the box is found and not the nearest.

use super::problem::{Problem, Space, expect_length, try_misfit};
use super::{Fit, FitError, Loss, Tolerances, fit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Where to start from, and from how many of those a fit is worth its price.
#[derive(Debug, Clone, PartialEq)]
pub struct Starts {
    /// Starts that are always fitted, in this order; each has `p` parameters.
    pub given: Vec<Vec<f64>>,
    /// Points of a Latin hypercube over the bounds that are screened by their cost alone.
    pub sampled: usize,
    /// How many of the sampled points, the cheapest first, are fitted.
    pub fitted: usize,
    /// Seed of the hypercube: the same seed gives the same points on every machine.
    pub seed: u64,
}

/// One of the optima that were found.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// Where it is.
    pub theta: Vec<f64>,
    /// Its cost.
    pub cost: f64,
    /// How many starts ended here.
    pub reached: usize,
}

/// What many starts found.
#[derive(Debug, Clone, PartialEq)]
pub struct MultiStart {
    /// The best fit.
    pub best: Fit,
    /// Every distinct optimum, best first.
    pub optima: Vec<Optimum>,
    /// Fits that were run to their end.
    pub fitted: usize,
    /// Starts, given or sampled, at which the model fails.
    pub failed: usize,
    /// How many of the fits ended at the best cost; equal costs at different parameters (a tie) count too.
    pub reached_best: usize,
    /// Misfit evaluations in all, those of the screening included.
    pub misfit_evaluations: u64,
    /// Linearisations in all.
    pub linearisations: u64,
}

/// Costs closer than this share, and parameters closer than this share of their magnitude, are one optimum.
const SAME_COST: f64 = 1e-5;
const SAME_PLACE: f64 = 1e-3;
/// Where a bound is infinite, points are drawn within this many scales of the first given start.
const REACH: f64 = 10.0;

/// Fits `problem` from the given starts and from the most promising sampled ones. The same input gives the same output.
///
/// # Errors
/// If lengths or bounds do not fit together, or the model fails at every start.
pub fn multi_start<P: Problem>(
    problem: &P,
    starts: &Starts,
    loss: Loss,
    tolerances: Tolerances,
) -> Result<MultiStart, FitError> {
    let space = Space::of(problem)?;
    for start in &starts.given {
        expect_length("parameters of a start", space.len(), start.len())?;
    }
    let sampled = latin_hypercube(&draw_box(&space, starts.given.first()), starts.sampled, starts.seed);
    let tried = starts.given.len() + sampled.len();
    let mut screened: Vec<(f64, &Vec<f64>)> =
        sampled.iter().filter_map(|theta| Some((try_misfit(problem, theta, loss)?.1, theta))).collect();
    let mut failed = sampled.len() - screened.len();
    screened.sort_by(|a, b| a.0.total_cmp(&b.0));
    let chosen = starts.given.iter().chain(screened.iter().take(starts.fitted).map(|(_, theta)| *theta));
    let mut fits: Vec<Fit> = Vec::new();
    for start in chosen {
        match fit(problem, start, loss, tolerances) {
            Ok(found) => fits.push(found),
            Err(FitError::Start { .. } | FitError::StartNotFinite) => failed += 1,
            Err(other) => return Err(other),
        }
    }
    let misfit_evaluations = sampled.len() as u64 + fits.iter().map(|f| f.misfit_evaluations).sum::<u64>();
    let linearisations = fits.iter().map(|f| f.linearisations).sum();
    // A stable sort: among equals the earlier start wins, so a given start keeps its place.
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let optima = merge(&fits, &space);
    let fitted = fits.len();
    let Some(best) = fits.first().cloned() else {
        return Err(FitError::NoStart { tried });
    };
    let reached_best = fits.iter().filter(|f| same_cost(f.cost, best.cost)).count();
    Ok(MultiStart { best, optima, fitted, failed, reached_best, misfit_evaluations, linearisations })
}

fn same_cost(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_COST * a.abs().max(b.abs())
}

fn merge(fits: &[Fit], space: &Space) -> Vec<Optimum> {
    let mut optima: Vec<Optimum> = Vec::new();
    for found in fits {
        let known = optima.iter_mut().find(|known| {
            let step: Vec<f64> = known.theta.iter().zip(&found.theta).map(|(a, b)| a - b).collect();
            same_cost(known.cost, found.cost) && space.relative_step(&known.theta, &step) <= SAME_PLACE
        });
        match known {
            Some(known) => known.reached += 1,
            None => optima.push(Optimum { theta: found.theta.clone(), cost: found.cost, reached: 1 }),
        }
    }
    optima
}

fn draw_box(space: &Space, around: Option<&Vec<f64>>) -> Vec<(f64, f64)> {
    let bounds = space.bounds.iter().zip(&space.scale).enumerate();
    let draw = bounds.map(|(j, (&(lower, upper), scale))| {
        let anchor = around.map_or(0.0, |start| start[j]).max(lower).min(upper);
        let from = if lower.is_finite() { lower } else { anchor - REACH * scale };
        let to = if upper.is_finite() { upper } else { anchor + REACH * scale };
        (from, to)
    });
    draw.collect()
}

/// `n` points such that each of the `n` slices of each parameter's range holds exactly one.
/// Source: McKay, Beckman and Conover, Technometrics 21 (1979).
fn latin_hypercube(range: &[(f64, f64)], n: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut unit = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let mut points = vec![vec![0.0; range.len()]; n];
    for (j, (lower, upper)) in range.iter().enumerate() {
        let mut order: Vec<usize> = (0..n).collect();
        for k in (1..n).rev() {
            order.swap(k, (unit() * (k + 1) as f64) as usize);
        }
        for (point, slice) in points.iter_mut().zip(order) {
            point[j] = lower + (upper - lower) * (slice as f64 + unit()) / n as f64;
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slice_holds_one_point() {
        let points = latin_hypercube(&[(0.0, 1.0), (-5.0, 5.0)], 16, 7);
        for j in 0..2 {
            let (lower, width) = [(0.0, 1.0), (-5.0, 10.0)][j];
            let mut slices: Vec<usize> = points.iter().map(|p| ((p[j] - lower) / width * 16.0) as usize).collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..16).collect::<Vec<_>>());
        }
        assert_eq!(points, latin_hypercube(&[(0.0, 1.0), (-5.0, 5.0)], 16, 7));
    }
}
