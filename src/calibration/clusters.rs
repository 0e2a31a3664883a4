//! Covariance of the estimate with phases as the independent units.
//!
//! What the model lacks repeats within a phase, over all sensors at once, and not from sample to sample: autocorrelation of single
//! sensors does not see all of it. With the scores `g_p` of the phases (their share of the gradient of the cost) and the white
//! covariance `C` the covariance of the estimate is the sandwich `C (sum g_p g_p') C`, times `G/(G - 1)` for `G` phases.
//! Source: Liang and Zeger, Biometrika 73 (1986); Cameron and Miller, Journal of Human Resources 50 (2015), equation 11.

use nalgebra::{DMatrix, DVector};

use super::joint::Joint;
use crate::estimation::{Linearised, Loss};

/// Covariance of the parameters (SI), from all misfits and their derivatives at the optimum and the white covariance.
pub(super) fn covariance(joint: &Joint<'_>, at: &Linearised, loss: Loss, white: &DMatrix<f64>) -> DMatrix<f64> {
    let mut sum = DMatrix::<f64>::zeros(white.nrows(), white.ncols());
    let (mut first, mut phases) = (0, 0_usize);
    for (one, weights) in joint.solutions.records.iter().zip(&joint.weights) {
        let rows = one.record.time.len();
        for phase in weights.phases() {
            let mut score = DVector::<f64>::zeros(white.nrows());
            for sensor in 0..one.measured.len() {
                let range = first + sensor * rows + phase.start..first + sensor * rows + phase.end;
                let gradient = |(j, slot): (usize, &mut f64)| {
                    let column = at.jacobian.column(j);
                    *slot += range.clone().map(|k| column[k] * at.misfit[k] * loss.weight(at.misfit[k])).sum::<f64>();
                };
                score.iter_mut().enumerate().for_each(gradient);
            }
            let moved = white * score;
            sum.ger(1.0, &moved, &moved, 1.0);
            phases += 1;
        }
        first += rows * one.measured.len();
    }
    // One phase says nothing of how phases differ.
    let correction = if phases > 1 { phases as f64 / (phases - 1) as f64 } else { 0.0 };
    sum * correction
}
