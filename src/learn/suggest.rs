//! Which effect is missing: candidates by score, joint refits of the best, one verdict.

use super::candidate::{Candidate, empirical};
use super::evaluated::{Conclusion, EvaluatedModel, is_adequate};
use super::fitted_model::FittedModel;
use super::form::{is_refuted, refute};
use super::free_curve::curves;
use super::lack_of_fit::{is_alike, with_lack_of_fit, with_shown_noise};
use super::opened::opened;
use super::refit::{BasePoint, charged, quick, refitted};
use super::run::{Run, misses};
use super::scoring::{candidates, tolerated, worth};
use super::screening::{Screening, promised};
use super::separate::{Experiment, separating};
use super::spools::{self, with_spools};
use super::verdict::{conclude, conclude_near, in_order, is_part, leans, stands_alone, takes_most};
use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::DynamicsReport;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::search;
use crate::estimation::criteria::bic;
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::Rig;
use crate::settings::LearningSettings;

/// What [`suggest`] found.
#[derive(Debug, Clone)]
pub struct Suggestion {
    /// Whether the model lacks something, and what.
    pub conclusion: Conclusion,
    /// The model as given, everything uncertain and all faults fitted.
    #[doc(hidden)]
    pub base: FittedModel,
    #[doc(hidden)]
    pub base_check: Option<Run>,
    /// Fitted candidates, the best first.
    #[doc(hidden)]
    pub judged: Vec<EvaluatedModel>,
    /// Every candidate by its score, the best first.
    #[doc(hidden)]
    pub scored: Vec<Candidate>,
    /// What would tell the best from its first rival, where it has one.
    #[doc(hidden)]
    pub experiment: Option<Experiment>,
    /// How spools follow their commands, where the fit record asks for other than the rig file has; all else is said of the rig
    /// with it.
    pub dynamics: Vec<DynamicsReport>,
}

impl Suggestion {
    /// The model that explains the records best.
    fn best(&self) -> &FittedModel {
        self.judged.first().filter(|best| best.supported).map_or(&self.base, |best| &best.trial)
    }

    /// Whether the best explanation leaves nothing to explain, on the check record too.
    fn explains_all(&self) -> bool {
        let all = |best: &EvaluatedModel| is_adequate(&best.trial.fit) && best.check.as_ref().is_none_or(is_adequate);
        self.conclusion == Conclusion::Adequate || self.judged.first().is_some_and(|best| best.supported && all(best))
    }
}

/// Looks for the effect that a model lacks. What the rig file states of the size of effects with an uncertainty is where the fit starts,
/// and no knowledge.
///
/// # Errors
/// Columns that are missing, a model that cannot be solved, or a [context](crate::Context) that was cancelled.
pub fn suggest(rig: &Rig, fit: &Record, check: Option<&Record>) -> Result<Suggestion, Complaint> {
    let suggested = |rig: &Rig, near: Option<&FittedModel>| {
        rough_base((rig, near), fit, Suggestion::explains_all, |estimate, base| suggest_from(estimate, base, check))
    };
    let found = rig.context().run(|| {
        let mut found = with_spools(&opened(rig), fit, suggested, Suggestion::best)?;
        while let Some(best) = found.judged.first_mut().filter(|best| best.supported) {
            best.finish(fit, check)?;
            let on_check = found.base_check.as_ref().zip(best.check.as_ref());
            let runs = std::iter::once((&found.base.fit, &best.trial.fit)).chain(on_check);
            if found.conclusion == Conclusion::EffectFound && !takes_most(runs) {
                found.conclusion = Conclusion::PartlyExplained;
            }
            let before = found.base_check.as_ref().unwrap_or(&found.base.fit).normalised;
            // Led to its end, what seemed nearest may explain no more of a record that nothing was fitted to.
            if found.conclusion != Conclusion::UnknownEffect || best.error() < before {
                break;
            }
            best.supported = false;
            found.judged.sort_by_key(|one| !one.supported);
        }
        Ok::<_, Complaint>(found)
    })?;
    Ok(Suggestion { dynamics: spools::report(rig, &found.base.rig), ..found })
}

/// Fits a rig to a record as it is, with none or one of its components faulty, and hands it on; where what that gives is not
/// enough, with several. It begins at the healthy rig, or at a model of it that is near.
///
/// # Errors
/// Those of the fit, and what `then` gives.
pub(super) fn rough_base<T>(
    (rig, near): (&Rig, Option<&FittedModel>),
    fit: &Record,
    enough: impl Fn(&T) -> bool,
    then: impl Fn(&Estimate<'_>, FittedModel) -> Result<T, Complaint>,
) -> Result<T, Complaint> {
    rig.context().stage("fit of your model");
    let mut rig = with_shown_noise(rig.as_commanded([fit]).as_ref().unwrap_or(rig), fit);
    let mut weighings = 1;
    loop {
        let model = Model::new(rig.clone());
        let drive = InputSignals::from_record(&model.rig, fit)?;
        let guess = near.map(|near| (estimate::picked(&model.rig, &near.values), near.set));
        let guess = guess.as_ref().map(|(theta, set)| (&theta[..], *set));
        let near = estimate::near(&model, fit, &drive, guess, rig.settings().diagnosis.healthy_rounds)?;
        let base = FittedModel::of(&near)?;
        if guess.is_none() && weighings == 1 {
            rig.context().first_look(|| misses(base.fit.normalised));
        }
        if is_adequate(&base.fit) {
            return then(&near, base);
        }
        let lacking = with_lack_of_fit(&rig, &base.fit);
        if weighings == rig.settings().learn.weighings || is_alike(&lacking, &rig) {
            return with_faults_of_components(&near, enough, then);
        }
        (rig, weighings) = (lacking, weighings + 1);
    }
}

/// The same where the model as given does not explain the record.
fn with_faults_of_components<T>(
    near: &Estimate<'_>,
    enough: impl Fn(&T) -> bool,
    then: impl Fn(&Estimate<'_>, FittedModel) -> Result<T, Complaint>,
) -> Result<T, Complaint> {
    let (rig, fit) = (near.case.rig(), near.case.record);
    let settings = &rig.settings().learn;
    let simple = near.by_components_alone(search::Depth::single(near.case.settings()), settings.linearisations)?;
    // Its faults may explain much: the others are looked for by what they leave.
    let left = with_lack_of_fit(rig, &FittedModel::of(&simple)?.fit);
    let model = Model::new(if is_alike(&left, rig) { rig.clone() } else { left });
    let drive = InputSignals::from_record(&model.rig, fit)?;
    let theta = &simple.isolation.best.theta;
    let simple = estimate::held_at(&model, fit, &drive, (theta, simple.isolation.set()), settings.linearisations)?;
    let base = FittedModel::of(&simple)?;
    let (given, samples) = (then(&simple, base.clone())?, base.fit.weights.all_samples() as f64);
    if enough(&given) {
        return Ok(given);
    }
    rig.context().stage("fit with several faults");
    let deep = simple.by_components_alone(search::Depth::several(near.case.settings()), settings.linearisations)?;
    let cost = |estimate: &Estimate<'_>| bic(estimate.isolation.best.cost, estimate.isolation.set().len(), samples);
    if cost(&deep) < cost(&simple)
        && deep.isolation.set() != simple.isolation.set()
        && let Ok(found) = then(&deep, FittedModel::of(&deep)?)
    {
        return Ok(found);
    }
    Ok(given)
}

/// The model with one effect more, everything fitted jointly, and what its preliminary fit cost under the weights of the base.
///
/// # Errors
/// The model cannot be solved with it.
pub(super) fn refitted_alone(
    base: &FittedModel,
    record: &Record,
    candidate: Option<Candidate>,
) -> Result<(FittedModel, f64), Complaint> {
    let given = || BasePoint { values: base.values.clone(), set: base.set, cost: f64::INFINITY };
    let (samples, settings) = (base.fit.weights.all_samples() as f64, &base.rig.settings().learn);
    // It was scored at the first; from the other a fit may end elsewhere. Only where both have ended does it show which is better.
    let from = |start: &Candidate| {
        let ended = [given(), BasePoint::healthy(&base.rig)].into_iter().filter_map(|base_point| {
            let rough = refitted(base, &[base_point], &[], record, std::slice::from_ref(start), None)?;
            let further = (rough.set, settings.linearisations);
            quick(&rough.rig, record, &rough.values, further, Some(search::ROUGH)).or(Some(rough))
        });
        ended.min_by(|a, b| a.priced(samples).total_cmp(&b.priced(samples)))
    };
    let rough = candidate.and_then(|candidate| {
        let typical = candidate.as_typical(&base.rig);
        let scored = (candidate.score > 0.0).then(|| from(&Candidate { base_point: None, ..candidate }));
        scored.flatten().or_else(|| from(&typical))
    });
    let Some(rough) = rough else {
        return Err(Complaint::new(Kind::Computation, "the model cannot be solved with this effect")
            .at(Place::file(&base.rig.path))
            .at(Place::file(&record.path)));
    };
    let screened = rough.priced(samples);
    Ok((
        FittedModel::fitted(&rough.rig, record, &rough.values, rough.set, base.rig.settings().learn.isolation_rounds)?,
        screened,
    ))
}

/// The same for a model that is fitted already, `base` being what it is fitted as.
///
/// # Errors
/// As [`suggest`].
pub fn suggest_from(
    estimate: &Estimate<'_>,
    base: FittedModel,
    check: Option<&Record>,
) -> Result<Suggestion, Complaint> {
    let settings = &estimate.case.rig().settings().learn;
    let base_check = check.map(|record| base.check(record)).transpose()?;
    let near = is_adequate(&base.fit) && base_check.as_ref().is_none_or(is_adequate);
    // Faults bend to what is missing: what they hide shows where there are none.
    let of_components = base.set.iter().any(|fault| !estimate.case.is_of_sensor(fault));
    let bent = of_components || (!base.set.is_empty() && !near);
    let healthy = || bent.then(|| estimate.without_faults(settings.linearisations)).transpose();
    let samples = base.fit.weights.all_samples() as f64;
    let tolerance = if near { tolerated(settings, samples) } else { 0.0 };
    // What would put a value back to where it was known to be is looked at however little it promises.
    let beyond = if leans(&base) { 0.0 } else { tolerance };
    let (list, without) = rayon::join(|| candidates(estimate, 0, beyond), healthy);
    let without = without?;
    let mut lists = vec![list];
    lists.extend(without.as_ref().map(|without| candidates(without, 1, beyond)));
    let points = std::iter::once(estimate).chain(&without);
    let base_points: Vec<BasePoint> = points.map(|estimate| BasePoint::of(estimate, samples)).collect();
    let screening =
        Screening { record: estimate.case.record, base: &base, base_check: &base_check, check, base_points };
    let [chance, worth] = [0.0, beyond].map(|tolerance| worth(lists[0].len(), tolerance));
    let most = [
        if near { settings.candidates_fitted_near } else { settings.candidates_fitted },
        settings.candidates_fitted_near,
    ];
    let promising = lists.iter().zip(most).flat_map(|(list, most)| {
        let least = list.first().map_or(worth, |best| worth.max(settings.candidate_share * best.score));
        // What a fit has bent to promises less than it has to give: the first few are fitted whatever they promise beyond chance.
        let looked_at = move |(place, one): &(usize, &Candidate)| {
            one.score > if *place < settings.candidates_fitted_tolerated { chance } else { least }
        };
        list.iter().enumerate().filter(looked_at).map(|(_, one)| one).take(most)
    });
    let promising = once_each(promising.collect(), &screening.base_points);
    let mut judged = screening.judge(promising.into_iter().map(|candidate| vec![candidate.clone()]).collect(), &[])?;
    let more = alike(settings, &judged, &lists);
    screening.join(&mut judged, more)?;
    if !near && !judged.first().is_some_and(stands_alone) {
        let more = pairs(&judged, &base);
        screening.join(&mut judged, more)?;
        if let Some(best) = judged.iter().find(|one| is_part(one, &base, &base_check))
            && !stands_alone(best)
        {
            let more = beside(best, estimate.case.record)?;
            screening.join(&mut judged, more)?;
        }
        let fewer = without_one(&judged);
        screening.join(&mut judged, fewer)?;
    }
    screening.settle(&mut judged)?;
    if let Some(best) = judged.first()
        && let Some(better) = restarted(estimate, &base, (&best.trial, best.screened), best.delta_bic)?
    {
        return suggest_from(&better, FittedModel::of(&better)?, check);
    }
    let mut conclusion = if near {
        conclude_near(&mut judged, &base, &base_check, tolerance)
    } else {
        conclude(&mut judged, &base, &base_check)
    };
    if conclusion == Conclusion::UnknownEffect {
        // What no law explains, a curve may at least describe.
        let curves = curves(&base, estimate.case.record, empirical(&base.rig))?;
        screening.join(&mut judged, curves.into_iter().map(|curve| vec![curve.candidate]).collect())?;
        in_order(settings, &mut judged);
        refute(settings, &mut judged);
    } else if is_refuted(&screening, &mut judged)? {
        conclusion = Conclusion::UnknownEffect;
    }
    let experiment = apart(&judged, &base);
    let scored = lists.swap_remove(0);
    Ok(Suggestion { conclusion, base, base_check, judged, scored, experiment, dynamics: Vec::new() })
}

/// The model as given, fitted from where the best explanation left what both have, if it is nearly as good there: a fit that
/// only had to be helped over a ridge lacks nothing. The best explanation comes with what it cost under the weights of the base;
/// `gain` is what the information criterion falls by with it.
///
/// # Errors
/// The model cannot be solved there.
pub(super) fn restarted<'a>(
    estimate: &Estimate<'a>,
    base: &FittedModel,
    (best, screened): (&FittedModel, f64),
    gain: f64,
) -> Result<Option<Estimate<'a>>, Complaint> {
    let settings = &base.rig.settings().learn;
    if gain <= settings.rival_bic {
        return Ok(None);
    }
    // What an effect bends is as it was.
    let added = best.rig.effects.iter().filter(|effect| base.rig.effects.iter().all(|own| own.id != effect.id));
    let of_effects: Vec<usize> = added.flat_map(|effect| effect.parameters.clone()).collect();
    let kept = |(index, was): (usize, &f64)| if of_effects.contains(&index) { *was } else { best.values[index] };
    let values: Vec<f64> = base.values.iter().enumerate().map(kept).collect();
    let (full, record) = (&estimate.case.full, estimate.case.record);
    let samples = base.fit.weights.all_samples() as f64;
    let cost = charged(&base.rig, base.cost, base.set, samples);
    let least = cost - (settings.restart_share * (cost - screened)).max(settings.rival_bic);
    let fitted = quick(&base.rig, record, &values, (best.set, settings.linearisations), Some(search::ROUGH));
    let Some(rough) = fitted.filter(|rough| rough.priced(samples) < least) else { return Ok(None) };
    let start = estimate::picked(&base.rig, &rough.values);
    let better = estimate::isolated(full.model, record, full.drive, (&start, rough.set), settings.isolation_rounds)?;
    let cost = charged(&base.rig, better.isolation.best.cost, better.isolation.set(), samples);
    Ok((cost < least).then_some(better))
}

/// Of each effect that is promising at several base points, the one that promises to cost least.
fn once_each<'a>(promising: Vec<&'a Candidate>, base_points: &[BasePoint]) -> Vec<&'a Candidate> {
    let cost = |one: &Candidate| promised(one, base_points).unwrap_or(0.0);
    let beaten = |one: &Candidate| promising.iter().any(|other| other.id == one.id && cost(other) < cost(one));
    promising.iter().copied().filter(|one| !beaten(one)).collect()
}

/// Candidates that promise as much as the best explanation where it was scored, and were not fitted.
fn alike(settings: &LearningSettings, judged: &[EvaluatedModel], lists: &[Vec<Candidate>]) -> Vec<Vec<Candidate>> {
    let Some([best]) = judged.first().map(|best| best.effects.as_slice()) else { return Vec::new() };
    let list = best.base_point.and_then(|base_point| lists.get(base_point)).map_or(&[][..], Vec::as_slice);
    let known = |candidate: &Candidate| judged.iter().any(|one| one.id() == candidate.id);
    let close =
        list.iter().filter(|candidate| candidate.score * settings.score_ratio > best.score && !known(candidate));
    close.take(settings.candidates_fitted).map(|candidate| vec![candidate.clone()]).collect()
}

/// The best explanations, two by two, as far as they may explain together what is missed.
fn pairs(judged: &[EvaluatedModel], base: &FittedModel) -> Vec<Vec<Candidate>> {
    let settings = &base.rig.settings().learn;
    let best: Vec<&EvaluatedModel> = judged.iter().take(settings.effects_paired).collect();
    let scale = judged.iter().map(|one| one.trial.fit.chi2).fold(f64::INFINITY, f64::min).max(1.0);
    let missed = (base.fit.chi2 - 1.0).max(0.0) * base.fit.weights.all_samples() as f64 / scale;
    let gain = |one: &EvaluatedModel| one.delta_bic.max(0.0);
    let mut pairs = Vec::new();
    for (place, a) in best.iter().enumerate() {
        let others = best[..place].iter().filter(|b| gain(a) + gain(b) > settings.pair_gain_share * missed);
        pairs.extend(others.map(|b| [b.effects.clone(), a.effects.clone()].concat()));
    }
    pairs
}

/// An explanation with what its rest asks for: effects by their score where it stands, with none but faults of components.
///
/// # Errors
/// The model cannot be solved there.
fn beside(best: &EvaluatedModel, record: &Record) -> Result<Vec<Vec<Candidate>>, Complaint> {
    let rig = &best.trial.rig;
    let settings = &rig.settings().learn;
    let model = Model::new(with_lack_of_fit(rig, &best.trial.fit));
    let drive = InputSignals::from_record(&model.rig, record)?;
    let of_components = best.trial.set.iter().filter(|&fault| !rig.is_of_sensor(rig.faults[fault].parameter)).collect();
    let start = (&estimate::picked(rig, &best.trial.values)[..], of_components);
    let list = candidates(&estimate::held_at(&model, record, &drive, start, settings.linearisations)?, 0, 0.0);
    let least = worth(list.len(), 0.0);
    let asked = list.into_iter().filter(|one| one.score > least).take(settings.effects_beside);
    Ok(asked.map(|one| [best.effects.clone(), vec![Candidate { base_point: None, ..one }]].concat()).collect())
}

/// The best explanation without each of its effects in turn: one that others were found beside may be nothing with them.
fn without_one(judged: &[EvaluatedModel]) -> Vec<Vec<Candidate>> {
    let Some(best) = judged.first() else { return Vec::new() };
    let all =
        |out: usize| best.effects.iter().enumerate().filter(move |(at, _)| *at != out).map(|(_, one)| one.clone());
    let is_new = |some: &Vec<Candidate>| {
        let same = |one: &EvaluatedModel| {
            one.effects.len() == some.len() && some.iter().all(|own| one.effects.iter().any(|other| other.id == own.id))
        };
        !some.is_empty() && !judged.iter().any(same)
    };
    (0..best.effects.len()).map(|out| all(out).collect()).filter(is_new).collect()
}

/// What would tell the best explanation from the first that is alike: an effect, or the faults of the model as given.
fn apart(judged: &[EvaluatedModel], base: &FittedModel) -> Option<Experiment> {
    let best = judged.first()?;
    let rival = best.confounded_with.first()?;
    let other = judged.iter().find(|other| other.id() == *rival).map_or(base, |other| &other.trial);
    separating([best.id(), rival.clone()], &best.trial, other)
}
