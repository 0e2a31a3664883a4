//! Fits that look where a start leads, and need not go to their end.

use super::case::Case;
use super::noise::Weights;
use super::weighed::{case_at, unsolvable};
use crate::complaint::Complaint;
use crate::estimation::{FitError, LocalModel, Options};
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::FaultSet;

/// A fit that did not have to go to its end.
pub struct PreliminaryFit {
    /// All estimated parameters, SI.
    pub theta: Vec<f64>,
    /// `2 F` of record and prior.
    pub cost: f64,
    /// By how much the last local model lowered it.
    pub gained: f64,
}

/// Fits a record with the faults of `set` present, from values of all estimated parameters.
/// Weights are those given or else of the start; the form is taken so many times, and as often again from what is expected of
/// everything uncertain where the fit is to go to its end.
///
/// # Errors
/// A model that cannot be solved there.
pub fn quick(
    model: &Model,
    record: &Record,
    drive: &InputSignals,
    (start, set): (&[f64], FaultSet),
    forms: usize,
    weights: Option<&Weights>,
) -> Result<PreliminaryFit, Complaint> {
    let (case, form) = case_at(model, record, drive, start, weights)?;
    let fit = walked(&case, form, (start, set), forms).map_err(|error| unsolvable(model, record, error))?;
    if forms <= model.rig.settings().diagnosis.first_linearisations {
        return Ok(fit);
    }
    let expected = case.as_expected(&fit.theta);
    if expected == start {
        return Ok(fit);
    }
    let again = |start: &[f64], forms: usize| {
        case.local_model(start).and_then(|form| walked(&case, form, (start, set), forms)).ok()
    };
    let near = |again: &PreliminaryFit| {
        again.cost - model.rig.settings().diagnosis.predicted_decreases * again.gained < fit.cost
    };
    let fresh = again(&expected, model.rig.settings().diagnosis.first_linearisations).filter(near);
    let further =
        fresh.and_then(|fresh| again(&fresh.theta, forms - model.rig.settings().diagnosis.first_linearisations));
    Ok(further.filter(|further| further.cost < fit.cost).unwrap_or(fit))
}

/// A fit from a form and where it was taken, the form taken so many times.
fn walked(
    case: &Case<'_>,
    mut form: LocalModel,
    (start, set): (&[f64], FaultSet),
    forms: usize,
) -> Result<PreliminaryFit, FitError> {
    let mut fit = PreliminaryFit { theta: start.to_vec(), cost: f64::INFINITY, gained: f64::INFINITY };
    let mut damping = 0.0;
    for left in (0..forms).rev() {
        let steps = Options::steps(case.settings().preliminary_steps, case.settings().rough_decrease).damped(damping);
        let Ok(point) = case.fit(&form, set, &fit.theta, steps) else { break };
        let before = if fit.cost.is_finite() { fit.cost } else { case.cost(set, &form.misfit, &form.theta) };
        damping = point.damping;
        fit = PreliminaryFit { theta: point.theta, cost: point.cost, gained: before - point.cost };
        let again = left + 1 < forms;
        if left == 0 || (again && fit.gained < 1e-3 * fit.cost) {
            break;
        }
        form = case.local_model(&fit.theta)?;
    }
    Ok(fit)
}
