//! The best fit of one set of faults: steps along a Jacobian from nearby, with fresh misfits.
//!
//! A simulation is an order of magnitude cheaper than one with sensitivities to everything, so a step takes its curvature from the
//! nearest [`Quadratic`] and only its gradient's misfits from here (simplified Gauss-Newton; Deuflhard, *Newton Methods for
//! Nonlinear Problems*, section 4.3).

use nalgebra::{Cholesky, DMatrix, DVector};

use super::case::{Case, ROBUST};
use super::quadratic::Quadratic;
use crate::fit::Problem;
use crate::rig::FaultSet;

/// A fit of a set of faults.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// All estimated parameters, SI.
    pub theta: Vec<f64>,
    /// Of the record alone.
    pub misfit: Vec<f64>,
    /// `2 F` of record and prior.
    pub cost: f64,
    /// Decrease of the cost that the next step promises, as far as the last one kept its promise.
    pub promised: f64,
    /// Damping (Levenberg and Marquardt) with which the last step was taken.
    pub damping: f64,
}

/// A promise of less is not worth a step towards a value that is reported.
pub const EXACT: f64 = 0.02;
/// Nor, where sets of faults are compared, one of less than this: the promise itself is counted.
pub const ROUGH: f64 = 0.5;
/// Damping of the first step after one that did not pay, and the factor to the next.
const DAMPING: (f64, f64) = (0.1, 10.0);
/// Damping beyond which no step is tried: it would be as short as the noise of the integration.
const MOST_DAMPING: f64 = 1e3;

/// Walks from `start` to the best fit of `set` with each `(parameter, value)` of `held` fixed, from this `damping`,
/// in at most `steps` steps, until the next promises less than `enough`.
/// `None` where the model cannot be solved at the start.
pub fn descend(
    case: &Case<'_>,
    near: &Quadratic,
    set: FaultSet,
    held: &[(usize, f64)],
    start: &[f64],
    damping: f64,
    (steps, enough): (usize, f64),
) -> Option<Point> {
    let fixed = |index: usize| case.is_held(set, index) || held.iter().any(|(other, _)| *other == index);
    let free: Vec<usize> = (0..case.count()).filter(|&index| !fixed(index)).collect();
    let mut theta = start.to_vec();
    for (index, value) in theta.iter_mut().enumerate() {
        let (low, high) = case.full.bounds()[index];
        *value = if case.is_held(set, index) { case.mean[index] } else { value.clamp(low, high) };
    }
    for &(index, value) in held {
        theta[index] = value;
    }
    let precision = case.precision(set, &near.scale);
    let total = |misfit: &[f64], theta: &[f64]| {
        let away = case.away(theta, &near.scale);
        2.0 * ROBUST.cost(misfit) + away.dot(&(&precision * &away))
    };
    let hessian = near.information(&precision, &free);
    // Where the form was taken its run is at hand.
    let misfit = if theta == near.theta { near.misfit.clone() } else { case.full.misfit(&theta).ok()? };
    let cost = total(&misfit, &theta);
    let mut here = Point { theta, misfit, cost, promised: 0.0, damping };
    if !cost.is_finite() {
        return None;
    }
    let mut kept = 1.0;
    let mut taken = 0;
    loop {
        let gradient = near.gradient(&here.misfit) + &precision * case.away(&here.theta, &near.scale);
        let slope = DVector::from_fn(free.len(), |a, _| gradient[free[a]]);
        let room: Vec<(f64, f64)> = free
            .iter()
            .map(|&i| {
                let (low, high) = case.full.bounds()[i];
                ((low - here.theta[i]) / near.scale[i], (high - here.theta[i]) / near.scale[i])
            })
            .collect();
        // Weakly determined directions move the furthest and bend the most: damping holds them back, not the others.
        let moved = loop {
            let mut damped = hessian.clone();
            for i in 0..free.len() {
                damped[(i, i)] *= 1.0 + here.damping;
            }
            let step = bounded_step(&damped, &slope, &room)?;
            let promised = -2.0 * slope.dot(&step) - step.dot(&(&hessian * &step));
            here.promised = promised * kept;
            if promised < enough || taken == steps {
                return Some(here);
            }
            let mut theta = here.theta.clone();
            for (a, &i) in free.iter().enumerate() {
                let (low, high) = case.full.bounds()[i];
                theta[i] = (theta[i] + step[a] * near.scale[i]).clamp(low, high);
            }
            let better = case.full.misfit(&theta).ok().map(|misfit| (total(&misfit, &theta), misfit));
            if let Some((cost, misfit)) = better.filter(|(cost, _)| *cost < here.cost) {
                kept = ((here.cost - cost) / promised).clamp(0.0, 1.0);
                let damping = if here.damping > DAMPING.0 { here.damping / DAMPING.1 } else { 0.0 };
                break Point { theta, misfit, cost, promised, damping };
            }
            here.damping = (here.damping * DAMPING.1).max(DAMPING.0);
            if here.damping > MOST_DAMPING {
                return Some(Point { promised: 0.0, damping: 0.0, ..here });
            }
        };
        here = moved;
        taken += 1;
    }
}

/// The step to the minimum of a quadratic form inside a box.
fn bounded_step(hessian: &DMatrix<f64>, slope: &DVector<f64>, room: &[(f64, f64)]) -> Option<DVector<f64>> {
    let count = slope.len();
    let mut ends: Vec<Option<f64>> = vec![None; count];
    loop {
        let free: Vec<usize> = (0..count).filter(|&i| ends[i].is_none()).collect();
        let pull = DVector::from_fn(free.len(), |a, _| {
            let others = (0..count).filter_map(|j| Some(hessian[(free[a], j)] * ends[j]?));
            -slope[free[a]] - others.sum::<f64>()
        });
        let inner = DMatrix::from_fn(free.len(), free.len(), |a, b| hessian[(free[a], free[b])]);
        let inside = Cholesky::new(inner)?.solve(&pull);
        let mut step = DVector::from_fn(count, |i, _| ends[i].unwrap_or(0.0));
        for (a, &i) in free.iter().enumerate() {
            step[i] = inside[a];
        }
        let mut hit = false;
        for &i in &free {
            let end = if step[i] < room[i].0 {
                room[i].0
            } else if step[i] > room[i].1 {
                room[i].1
            } else {
                continue;
            };
            ends[i] = Some(end);
            hit = true;
        }
        if !hit {
            return Some(step);
        }
    }
}
