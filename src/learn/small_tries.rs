//! Effects tried in small, where what they do is straight: whether one may take the place of a fault.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::highest::highest;
use super::trial_steps::{ONSETS, SIZES, ScoreContext, TYPICAL, TrialStep, attempt, begins_at_a_level, levels};
use crate::estimation::Score;
use crate::model::{InputSignals, Model};
use crate::physics::effect::Form;
use crate::rig::{EffectInstance, Quantity};

/// The smallest, with no level from which on it acts.
const SMALL: (f64, f64) = (SIZES[0], 0.0);

/// Effects as they may be tried in small, each with the score of what each try changes in the weighted misfits: a tenth of its
/// typical size, along the derivative as what is fitted has it, and that. One with a level that has to be searched has none.
pub(super) fn small_tries(here: &ScoreContext<'_, '_>, places: &[EffectInstance]) -> Vec<Vec<(Candidate, Score)>> {
    let slopes = slopes(here, places);
    let scored = |one: TrialStep| {
        let score = one.score.unwrap_or_else(|| here.scoring.of(&one.change));
        (one.candidate, score)
    };
    let one = |(placed, slope): (&EffectInstance, Option<Vec<f64>>)| {
        if levels(placed).is_some() {
            return Vec::new();
        }
        let begins = begins_at_a_level(placed);
        let top = if begins { highest(here.estimate, placed.spot, Quantity::Pressure) } else { 0.0 };
        let onsets: Vec<f64> = if begins { ONSETS.iter().map(|share| share * top).collect() } else { vec![0.0] };
        let along = slope.map(|change| TrialStep::of(here, placed, SMALL, change, None));
        let first = if along.is_some() { TYPICAL } else { 0 };
        let steps = onsets.iter().flat_map(|&onset| SIZES[first..=TYPICAL].iter().map(move |&step| (step, onset)));
        let tried = steps.filter_map(|step| TrialStep::at(here, placed, step, None));
        along.into_iter().chain(tried).map(scored).collect()
    };
    places.par_iter().zip(slopes).map(one).collect()
}

/// By how much each effect would change the weighted misfits at a tenth of its typical size along the derivatives where all of them do
/// nothing, all in one run: in the steps of the local model and where that is, since what a slope is at an edge between two rows depends
/// on both. `None` for one that moves nothing so, that begins at a level, or that is no law joined to the circuit, nor parameters of one;
/// and where the model cannot be solved.
fn slopes(here: &ScoreContext<'_, '_>, places: &[EffectInstance]) -> Vec<Option<Vec<f64>>> {
    let (estimate, full) = (here.estimate, &here.estimate.case.full);
    let mut rig = full.model.rig.clone();
    let mut values = full.parameters(&estimate.isolation.local.theta);
    let mut install = |placed: &EffectInstance| {
        let is_law = match placed.effect.form {
            Form::Shunt { card, .. } => card.states.is_empty(),
            Form::ParameterChange => true,
            _ => false,
        };
        if !is_law || levels(placed).is_some() || begins_at_a_level(placed) {
            return Vec::new();
        }
        let [still, tried] = [0.0, SMALL.0].map(|step| attempt(estimate, placed, (step, 0.0)));
        let Ok(indices) = rig.give_effect(placed, &still) else { return Vec::new() };
        let moved = still.iter().zip(&tried).zip(indices).map(|((from, to), index)| (index, to.value - from.value));
        moved.filter(|(_, size)| *size != 0.0).collect()
    };
    let moved: Vec<Vec<(usize, f64)>> = places.iter().map(&mut install).collect();
    values.extend(rig.parameters[values.len()..].iter().map(|parameter| parameter.value));
    let mut by: Vec<usize> = moved.iter().flatten().map(|(index, _)| *index).collect();
    by.sort_unstable();
    by.dedup();
    let drive = InputSignals::from_record(&rig, estimate.case.record);
    let model = Model::new(rig).with_tolerance(full.model.tolerance);
    let solved = drive.ok().and_then(|drive| model.sensitivities(&values, &by, &drive, full.times).ok());
    let Some(solved) = solved else { return vec![None; places.len()] };
    let one = |moved: &Vec<(usize, f64)>| {
        let mut change = vec![0.0; full.weights.rows() * full.weights.sensors()];
        for (index, size) in moved {
            let derivative = &solved.derivatives[by.binary_search(index).ok()?];
            change.iter_mut().zip(derivative.iter().flatten()).for_each(|(slot, value)| *slot += size * value);
        }
        let acts = change.iter().all(|value| value.is_finite()) && change.iter().any(|value| *value != 0.0);
        full.weights.apply(&mut change);
        acts.then_some(change)
    };
    moved.iter().map(one).collect()
}
