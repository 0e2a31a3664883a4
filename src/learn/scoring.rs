//! Which effects might be missing, ranked by the score test.
//!
//! With the misfits `r` at the optimum, the weighted sensitivities `J` of everything that is fitted, and `s` the change of
//! the misfits by the candidate, what nothing fitted can do is `s_perp = s - J H⁻¹ J' s`. Then `T = (s_perp' r)²/(s_perp' s_perp)`
//! estimates how far chi-square would fall (Rao's score test; Kristensen, Madsen and Jorgensen 2004), and `sqrt(T0)/||s_perp||` is
//! the smallest size that the record could show if a fall of `T0` is asked for. `s` is taken at a typical size, not at zero,
//! where friction has no slope.

use rayon::prelude::*;

use super::candidate::{Candidate, empirical};
use super::fitted_model::FittedModel;
use super::free_curve::curves;
use super::trial_steps::{ScoreContext, best_try};
use crate::complaint::Complaint;
use crate::diagnosis::estimate::Estimate;
use crate::physics::effect::Form;
use crate::rig::{EffectInstance, Rig};
use crate::settings::LearningSettings;

/// Fall of chi-square that one of so many effects has to promise to be looked at: more than the best of them does by chance in
/// one of 1,000 records (Bonferroni), and more than `tolerance`.
pub fn worth(effects: usize, tolerance: f64) -> f64 {
    2.0 * (1000.0 * effects.max(1) as f64).ln() + tolerance
}

/// Fall of chi-square that is within the tolerance of a model that explains so many samples.
pub(crate) fn tolerated(settings: &LearningSettings, samples: f64) -> f64 {
    settings.tolerated_share * samples
}

/// All effects that the rig may have and does not, the most promising first; `stand` is where the estimate stands, `tolerance`
/// the fall of chi-square that says nothing.
pub fn candidates(estimate: &Estimate<'_>, base_point: usize, tolerance: f64) -> Vec<Candidate> {
    let rig = estimate.case.rig();
    let places = places(rig);
    let count = rig.context().count("candidates screened", places.len());
    let Some(here) = ScoreContext::of(estimate, worth(places.len(), tolerance)) else { return Vec::new() };
    let one = |placed: &EffectInstance| {
        let tried = best_try(&here, placed);
        count.one();
        tried
    };
    let mut all: Vec<Candidate> = places.par_iter().flat_map_iter(one).collect();
    for candidate in &mut all {
        candidate.base_point = Some(base_point);
        candidate.others.iter_mut().for_each(|other| other.base_point = Some(base_point));
    }
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    all
}

/// Effects that the rig may have and does not, each at its place; curves without a formula are none.
pub(super) fn places(rig: &Rig) -> Vec<EffectInstance> {
    let is_there = |placed: &EffectInstance| {
        rig.effects
            .iter()
            .any(|present| present.id == rig.effect_id(placed) || rig.is_same_law(&present.placed, placed))
    };
    rig.distinct(rig.effect_places())
        .into_iter()
        .filter(|placed| !is_there(placed))
        .filter(|placed| !placed.effect.empirical)
        // What is a fault of the rig competes as one.
        .filter(|placed| !(matches!(placed.effect.form, Form::ParameterChange) && bends_a_fault(rig, placed)))
        .filter(|placed| !is_stated_as_exact(rig, placed))
        .collect()
}

/// One effect at its place, scored; a curve without a formula as high as the record asks for, or as it typically is.
///
/// # Errors
/// The model cannot be solved there.
pub fn candidate(
    estimate: &Estimate<'_>,
    base: &FittedModel,
    placed: &EffectInstance,
) -> Result<Option<Candidate>, Complaint> {
    if !placed.effect.empirical {
        return Ok(ScoreContext::of(estimate, worth(1, 0.0)).and_then(|here| best_try(&here, placed)));
    }
    let id = base.rig.effect_id(placed);
    let Some(typical) = empirical(&base.rig).into_iter().find(|candidate| candidate.id == id) else { return Ok(None) };
    let asked = curves(base, estimate.case.record, vec![typical.clone()])?.pop();
    Ok(Some(asked.map_or(typical, |asked| asked.candidate)))
}

/// Whether the first parameter that an effect bends is one of a sensor that the rig file states as exact, such as the gain `1 +- 0`
/// of an encoder that counts lines: of another value the prior has probability 0.
fn is_stated_as_exact(rig: &Rig, placed: &EffectInstance) -> bool {
    let first = placed.effect.parameters.first().and_then(|free| rig.bent(placed, free.name));
    let is_exact = |index: usize| {
        let parameter = &rig.parameters[index];
        parameter.sigma == 0.0 && parameter.spread == 0.0
    };
    first.is_some_and(|index| rig.is_of_sensor(index) && is_exact(index))
}

/// Whether the first parameter that an effect bends is a fault of the rig.
fn bends_a_fault(rig: &Rig, placed: &EffectInstance) -> bool {
    let first = placed.effect.parameters.first().and_then(|free| rig.bent(placed, free.name));
    first.is_some_and(|parameter| rig.is_fault(parameter))
}
