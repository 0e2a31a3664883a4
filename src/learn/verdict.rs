//! What speaks against an effect as fitted, what it explains, and the one word on the record.

use super::candidate::Candidate;
use super::evaluated::{Conclusion, EvaluatedModel, is_adequate};
use super::fitted_model::FittedModel;
use super::run::Run;
use super::warning::{Warning, ends_its_search};
use crate::diagnosis::CLEARLY_ABOVE_NOISE;
use crate::rig::InstalledEffect;
use crate::settings::LearningSettings;

/// What speaks against an effect as fitted.
pub(super) fn warnings(trial: &FittedModel, base: &FittedModel) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for effect in &trial.rig.effects {
        for (place, (free, &index)) in effect.placed.effect.parameters.iter().zip(&effect.parameters).enumerate() {
            let parameter = &trial.rig.parameters[index];
            if parameter.sigma == 0.0 {
                continue;
            }
            let (id, value) = (parameter.id.clone(), parameter.unit.from_si(trial.values[index]));
            let unit = trial.rig.effect_unit(&effect.placed, free.name);
            let in_card = unit.from_si(trial.values[index]);
            // A part of an effect that is not there says nothing against the rest, if there is a rest.
            if free.neutral == Some(in_card) && (place > 0 || acts_otherwise(trial, effect, place)) {
                continue;
            }
            let (low, high) = parameter.bounds;
            if trial.at_bound.contains(&index) || trial.values[index] <= low || trial.values[index] >= high {
                let (unit, is_size) = (parameter.unit.to_string(), place == 0);
                warnings.push(Warning::AtBound { id, value, unit, is_size });
            } else if !(free.plausible.0..=free.plausible.1).contains(&in_card) {
                warnings.push(Warning::Implausible { id, value, unit: parameter.unit.to_string() });
            }
        }
    }
    for (index, parameter) in base.rig.parameters.iter().enumerate() {
        let moved = (trial.values[index] - parameter.value).abs();
        if parameter.is_uncertain()
            && !base.rig.is_fault(index)
            && moved > 4.0 * parameter.sigma
            && !base.rig.is_of_effect(index)
            && !trial.rig.is_of_effect(index)
        {
            let far = moved / parameter.sigma;
            let at_end = ends_its_search(far, &trial.rig);
            warnings.push(Warning::Moved { id: parameter.id.clone(), deviations: far, at_end });
        }
    }
    for fault in trial.set.difference(base.set).iter() {
        warnings.push(Warning::FaultNeeded { id: base.rig.fault_id(fault).to_owned() });
    }
    warnings
}

/// Whether an effect does something by another of its parameters than this.
fn acts_otherwise(trial: &FittedModel, effect: &InstalledEffect, place: usize) -> bool {
    let own = effect.placed.effect.parameters.iter().zip(&effect.parameters).enumerate();
    own.filter(|(other, _)| *other != place).any(|(_, (free, &index))| {
        let value = trial.rig.effect_unit(&effect.placed, free.name).from_si(trial.values[index]);
        free.neutral.is_some_and(|neutral| value != neutral)
    })
}

/// Share of what the model misses that a run explains; 1 where it is within noise and tolerance.
pub(super) fn explained(before: &Run, after: &Run) -> f64 {
    if is_adequate(after) {
        return 1.0;
    }
    1.0 - ((after.chi2 - 1.0).max(0.0) / (before.chi2 - 1.0).max(1e-9))
}

/// Share of what the model misses that an explanation takes away, on the fit record and on the check record. One with which the plain
/// error rises on both, and stays clearly above the noise, buys moments at which curves are steep with all others: it takes nothing.
fn shares(judged: &EvaluatedModel, base: &FittedModel, base_check: &Option<Run>) -> (f64, f64) {
    let rises = |before: &Run, after: &Run| after.normalised > before.normalised.max(CLEARLY_ABOVE_NOISE);
    let on_check = base_check.as_ref().zip(judged.check.as_ref());
    if rises(&base.fit, &judged.trial.fit) && on_check.is_none_or(|(before, after)| rises(before, after)) {
        return (0.0, 0.0);
    }
    let on_check = match (base_check, &judged.check) {
        (Some(before), Some(after)) => explained(before, after),
        (None, _) => 1.0,
        (Some(_), None) => 0.0,
    };
    (explained(&base.fit, &judged.trial.fit), on_check)
}

fn explains(judged: &EvaluatedModel, base: &FittedModel, base_check: &Option<Run>) -> bool {
    let settings = &base.rig.settings().learn;
    let (on_fit, on_check) = shares(judged, base, base_check);
    judged.supported && on_fit.min(on_check) >= settings.explained_share
}

/// Whether a law with physical sense explains what an effect has to, but on the check record only a part of it.
pub(super) fn is_part(judged: &EvaluatedModel, base: &FittedModel, base_check: &Option<Run>) -> bool {
    judged.supported
        && !judged.senseless()
        && !judged.is_empirical()
        && are_part(&base.rig.settings().learn, shares(judged, base, base_check))
}

/// Whether these shares on the fit record and on the check record are a part of the explanation.
pub(super) fn are_part(settings: &LearningSettings, (on_fit, on_check): (f64, f64)) -> bool {
    on_fit >= settings.explained_share && on_check >= settings.part_share_check
}

/// Whether an explanation leaves both records at their floor, and leans on nothing that was known otherwise.
pub(super) fn is_whole(judged: &EvaluatedModel) -> bool {
    let at_floor = is_adequate(&judged.trial.fit) && judged.check.as_ref().is_none_or(is_adequate);
    at_floor && !judged.warnings.iter().any(Warning::is_at_end)
}

/// Whether an explanation takes more of the plain error beyond noise than it leaves, of each record of which clearly more than noise is left:
/// what tolerances of switching forgive is not explained.
pub(super) fn takes_most<'a>(runs: impl IntoIterator<Item = (&'a Run, &'a Run)>) -> bool {
    let beyond = |run: &Run| (run.normalised * run.normalised - 1.0).max(0.0);
    let takes =
        |before: &Run, after: &Run| after.normalised <= CLEARLY_ABOVE_NOISE || beyond(after) < 0.5 * beyond(before);
    runs.into_iter().all(|(before, after)| takes(before, after))
}

/// Whether an explanation is whole and nothing else stands in for physics beside it: no fault that the model does without elsewhere, no
/// value far from where it was known to be.
pub(super) fn stands_alone(judged: &EvaluatedModel) -> bool {
    let stands_in = |warning: &Warning| matches!(warning, Warning::Moved { .. } | Warning::FaultNeeded { .. });
    is_whole(judged) && !judged.warnings.iter().any(stands_in)
}

/// Whether a model without further effects needs a value far from where it was known to be.
pub(super) fn leans(base: &FittedModel) -> bool {
    warnings(base, base).iter().any(|warning| matches!(warning, Warning::Moved { .. }))
}

/// Whether some effects are a part of more.
pub(super) fn is_among(some: &[Candidate], more: &[Candidate]) -> bool {
    some.len() < more.len() && some.iter().all(|one| more.iter().any(|other| other.id == one.id))
}

/// What is supported comes first; of that, fewer effects before more, and physics before effects of sensors, where the others do not
/// clearly explain more.
pub(super) fn in_order(settings: &LearningSettings, judged: &mut [EvaluatedModel]) {
    judged.sort_by_key(|one| !one.supported);
    let is_enough = |first: &EvaluatedModel, one: &EvaluatedModel| {
        one.supported
            && !one.senseless()
            && is_among(&one.effects, &first.effects)
            && one.error() <= first.error() / (1.0 - settings.clear_share)
    };
    if let Some(first) = judged.first()
        && let Some(place) = judged.iter().position(|one| is_enough(first, one))
    {
        judged[..=place].rotate_right(1);
    }
    let Some(first) = judged.first().filter(|first| first.is_of_sensor()) else { return };
    let most = first.error() / (1.0 - settings.clear_share);
    let is_physics =
        |one: &EvaluatedModel| one.supported && !one.senseless() && !one.is_of_sensor() && !one.is_empirical();
    if let Some(place) = judged.iter().position(|one| is_physics(one) && one.error() <= most) {
        judged[..=place].rotate_right(1);
    }
}

/// What a model that is within its tolerance lacks nevertheless: an effect that explains both records better, with sense, or
/// what several faults would have to stand in for. A fall of chi-square within `tolerance` says nothing, unless with it every value is
/// where it was known to be, and without it one is not.
pub(super) fn conclude_near(
    judged: &mut Vec<EvaluatedModel>,
    base: &FittedModel,
    base_check: &Option<Run>,
    tolerance: f64,
) -> Conclusion {
    let settings = &base.rig.settings().learn;
    let leans = leans(base);
    let fall = |before: &Run, after: &Run| (before.chi2 - after.chi2) * after.weights.all_samples() as f64;
    judged.retain_mut(|one| {
        let on_check = base_check.as_ref().zip(one.check.as_ref()).map(|(before, after)| fall(before, after));
        let tolerance = if leans && stands_alone(one) { 0.0 } else { tolerance };
        let better =
            one.delta_bic > settings.rival_bic.max(tolerance) && on_check.is_none_or(|fall| fall > settings.rival_bic);
        // Fewer faults with an effect in their place may explain the records as well, both of them.
        let alike = one.trial.set.len() < base.set.len()
            && one.delta_bic > -settings.rival_bic
            && on_check.is_none_or(|fall| fall > -settings.rival_bic);
        one.supported = better;
        (better || alike) && !one.senseless()
    });
    if judged.is_empty() {
        return Conclusion::Adequate;
    }
    // What explains the records better comes before what only does with fewer faults, each in its order.
    judged.sort_by_key(|one| !one.supported);
    if judged[0].supported {
        return conclude(judged, base, base_check);
    }
    let faults: Vec<&str> = base.set.iter().map(|fault| base.rig.fault_id(fault)).collect();
    let faults = faults.join(" + ");
    for one in judged.iter_mut() {
        one.confounded_with.push(faults.clone());
    }
    Conclusion::Confounded
}

pub(super) fn conclude(judged: &mut [EvaluatedModel], base: &FittedModel, base_check: &Option<Run>) -> Conclusion {
    let settings = &base.rig.settings().learn;
    in_order(settings, judged);
    let Some(best) = judged.first() else { return Conclusion::UnknownEffect };
    if !explains(best, base, base_check) {
        let part = judged.iter().position(|one| is_part(one, base, base_check));
        let Some(place) = part else { return Conclusion::UnknownEffect };
        judged[..=place].rotate_right(1);
        return Conclusion::PartlyExplained;
    }
    let whole = is_whole(best);
    let (top, size) = (best.evidence, best.effects.len());
    // What was known before, and weights of moments at which curves are steep, decide against none that leaves clearly less on both records.
    let (on_fit, on_check) = (best.trial.fit.normalised, best.error());
    let leaves_less = |one: &EvaluatedModel| {
        let share = 1.0 - settings.clear_share;
        one.supported && one.trial.fit.normalised < share * on_fit && one.error() < share * on_check
    };
    let close: Vec<bool> = judged
        .iter()
        .map(|one| {
            let is_near = one.evidence > top - settings.rival_bic || leaves_less(one) && !one.senseless();
            one.effects.len() <= size && is_near && explains(one, base, base_check)
        })
        .collect();
    let ids: Vec<String> = judged.iter().map(EvaluatedModel::id).collect();
    let rivals = close.iter().filter(|close| **close).count();
    for (place, one) in judged.iter_mut().enumerate() {
        if close[place] && rivals > 1 {
            let others = ids.iter().zip(&close).enumerate();
            one.confounded_with = others
                .filter(|(other, (_, close))| **close && *other != place)
                .map(|(_, (id, _))| id.clone())
                .collect();
        }
    }
    match rivals {
        2.. => Conclusion::Confounded,
        _ if whole => Conclusion::EffectFound,
        _ => Conclusion::PartlyExplained,
    }
}
