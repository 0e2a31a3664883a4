//! What speaks against an effect as fitted, what it explains, and the one word on the record.

use super::suggest::{Conclusion, Judged, RIVAL, is_adequate};
use super::trial::{Run, Trial};
use crate::diagnosis::case::REACH;

/// Share of what is missed that an effect has to explain to be called found.
const EXPLAINED: f64 = 0.8;

/// What speaks against an effect as fitted.
pub(super) fn warnings(trial: &Trial, base: &Trial) -> Vec<String> {
    let mut warnings = Vec::new();
    for effect in &trial.rig.effects {
        for (place, (free, &index)) in effect.placed.effect.parameters.iter().zip(&effect.parameters).enumerate() {
            let parameter = &trial.rig.parameters[index];
            if parameter.sigma == 0.0 {
                continue;
            }
            let value = parameter.unit.from_si(trial.values[index]);
            let unit = trial.rig.effect_unit(&effect.placed, free.name);
            let in_card = unit.from_si(trial.values[index]);
            // A further part of an effect that is not there says nothing against the rest.
            if place > 0 && free.neutral == Some(in_card) {
                continue;
            }
            let (low, high) = parameter.bounds;
            if trial.at_bound.contains(&index) || trial.values[index] <= low || trial.values[index] >= high {
                warnings.push(format!("at-bound: {} = {value:.4} {}", parameter.id, parameter.unit));
            } else if !(free.plausible.0..=free.plausible.1).contains(&in_card) {
                warnings.push(format!("implausible: {} = {value:.4} {}", parameter.id, parameter.unit));
            }
        }
    }
    for (index, parameter) in base.rig.parameters.iter().enumerate() {
        let moved = (trial.values[index] - parameter.value).abs();
        if parameter.sigma > 0.0
            && !parameter.anew
            && !base.rig.is_fault(index)
            && moved > 4.0 * parameter.sigma
            && !base.rig.is_of_effect(index)
            && !trial.rig.is_of_effect(index)
        {
            let far = moved / parameter.sigma;
            let end = if far > 0.999 * REACH { ", the end of its search" } else { "" };
            warnings.push(format!("moved: {} by {far:.1} standard uncertainties{end}", parameter.id));
        }
    }
    for fault in trial.set.difference(base.set).iter() {
        warnings.push(format!("fault: {} is needed too", base.rig.fault_id(fault)));
    }
    warnings
}

/// Share of what the model misses that a run explains; 1 where it is within noise and tolerance.
fn explained(before: &Run, after: &Run) -> f64 {
    if is_adequate(after) {
        return 1.0;
    }
    1.0 - ((after.chi2 - 1.0).max(0.0) / (before.chi2 - 1.0).max(1e-9))
}

pub(super) fn explains(judged: &Judged, base: &Trial, base_check: &Option<Run>) -> bool {
    let on_check = match (base_check, &judged.check) {
        (Some(before), Some(after)) => explained(before, after),
        (None, _) => 1.0,
        (Some(_), None) => 0.0,
    };
    judged.supported && explained(&base.fit, &judged.trial.fit).min(on_check) >= EXPLAINED
}

/// What a model that is within its tolerance lacks nevertheless: an effect that explains both records better, with sense, or
/// what several faults would have to stand in for. A fall of chi-square within `tolerance` says nothing.
pub(super) fn conclude_near(
    judged: &mut Vec<Judged>,
    base: &Trial,
    base_check: &Option<Run>,
    tolerance: f64,
) -> Conclusion {
    let fall = |before: &Run, after: &Run| (before.chi2 - after.chi2) * after.weights.all_samples() as f64;
    judged.retain_mut(|one| {
        let on_check = base_check.as_ref().zip(one.check.as_ref()).map(|(before, after)| fall(before, after));
        let better = one.delta_bic > RIVAL.max(tolerance) && on_check.is_none_or(|fall| fall > RIVAL);
        // Fewer faults with an effect in their place may explain the records as well.
        let alike = one.trial.set.len() < base.set.len() && one.delta_bic > -RIVAL;
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

pub(super) fn conclude(judged: &mut [Judged], base: &Trial, base_check: &Option<Run>) -> Conclusion {
    let Some(best) = judged.first() else { return Conclusion::UnknownEffect };
    if !explains(best, base, base_check) {
        return Conclusion::UnknownEffect;
    }
    let (top, size) = (best.delta_bic, best.effects.len());
    let close: Vec<bool> = judged
        .iter()
        .map(|one| one.effects.len() <= size && one.delta_bic > top - RIVAL && explains(one, base, base_check))
        .collect();
    let ids: Vec<String> = judged.iter().map(Judged::id).collect();
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
    if rivals > 1 { Conclusion::Confounded } else { Conclusion::EffectFound }
}
