//! Which effect is missing: candidates by score, joint refits of the best, one verdict.

use rayon::prelude::*;

use super::candidate::{Candidate, candidates, empirical};
use super::refit::{FORMS, Rough, Stand, quick, refitted};
use super::separate::{Experiment, separating};
use super::trial::{Run, Trial};
use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::case::members;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::{adequate, tame_squares};
use crate::model::{Drive, Model};
use crate::record::Record;
use crate::rig::Rig;

/// Candidates that are fitted.
const FITTED: usize = 8;
/// Candidates of which pairs are fitted where none explains the record alone.
const PAIRED: usize = 5;
/// Candidates that are isolated anew, faults and all.
const ISOLATED: usize = 2;
/// Candidates that go on to their end.
const CONTINUED: usize = 3;
/// Rounds of isolation of each fit.
pub(super) const ROUNDS: u64 = 4;
/// Difference of the information criterion within which two explanations are rivals (Kass and Raftery 1995: very strong).
pub const RIVAL: f64 = 10.0;
/// Share of what is missed that an effect has to explain to be called found.
const EXPLAINED: f64 = 0.8;

/// One word on what the record says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Conclusion {
    /// The model explains the record within its tolerance.
    Adequate,
    /// One effect, or a pair, explains what the model misses, and nothing else does.
    EffectFound,
    /// Several explain it alike.
    Confounded,
    /// Nothing in the library explains it.
    UnknownEffect,
}

/// An effect, or a pair, with what the records say of it.
#[derive(Debug, Clone)]
pub struct Judged {
    pub effects: Vec<Candidate>,
    /// The joint refit.
    pub trial: Trial,
    /// Its free run on the check record.
    pub check: Option<Run>,
    /// Fall of the information criterion against the model as given; the noise scaled up to what the best leaves.
    pub delta_bic: f64,
    /// Whether it explains more than chance does, on the check record too.
    pub supported: bool,
    /// Others that explain the record alike.
    pub confounded_with: Vec<String>,
    pub warnings: Vec<String>,
}

impl Judged {
    pub fn id(&self) -> String {
        self.effects.iter().map(|effect| effect.id.as_str()).collect::<Vec<_>>().join(" + ")
    }
}

/// What [`suggest`] found.
#[derive(Debug, Clone)]
pub struct Suggestion {
    pub conclusion: Conclusion,
    /// The model as given, everything uncertain and all faults fitted.
    pub base: Trial,
    pub base_check: Option<Run>,
    /// Fitted candidates, the best first.
    pub judged: Vec<Judged>,
    /// Every candidate by its score, the best first.
    pub scored: Vec<Candidate>,
    /// What would tell the best from its first rival, where it has one.
    pub experiment: Option<Experiment>,
}

/// Looks for the effect that a model lacks.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub fn suggest(rig: &Rig, fit: &Record, check: Option<&Record>) -> Result<Suggestion, Complaint> {
    rough_base(rig, fit, |estimate, base| suggest_from(estimate, base, check))
}

/// Fits a rig to a record as it is, and hands it on.
///
/// # Errors
/// Those of the fit, and what `then` gives.
pub(super) fn rough_base<T>(
    rig: &Rig,
    fit: &Record,
    then: impl FnOnce(&Estimate<'_>, Trial) -> Result<T, Complaint>,
) -> Result<T, Complaint> {
    let model = Model::new(rig.clone());
    let drive = Drive::from_record(&model.rig, fit)?;
    let near = estimate::near(&model, fit, &drive, None, estimate::FROM_HEALTHY)?;
    let base = Trial::of(&near)?;
    if is_adequate(&base.fit, rig) {
        return then(&near, base);
    }
    let estimate = near.by_components_alone(FORMS)?;
    let base = Trial::of(&estimate)?;
    then(&estimate, base)
}

/// The model with one effect more, everything fitted jointly.
///
/// # Errors
/// The model cannot be solved with it.
pub(super) fn refitted_alone(base: &Trial, record: &Record, candidate: Option<Candidate>) -> Result<Trial, Complaint> {
    let stands = [(base.values.clone(), base.set), (base.rig.healthy(), 0)];
    // It was scored at the first; the other is tried too.
    let rough = candidate.and_then(|candidate| refitted(base, &stands, record, &[Candidate { stand: None, ..candidate }]));
    let Some(rough) = rough else {
        return Err(Complaint::new(Kind::Computation, "the model cannot be solved with this effect")
            .at(Place::file(&base.rig.path))
            .at(Place::file(&record.path)));
    };
    Trial::fitted(&rough.rig, record, &rough.values, rough.set, ROUNDS)
}

/// The same for a model that is fitted already, `base` being what it is fitted as.
///
/// # Errors
/// As [`suggest`].
pub fn suggest_from(estimate: &Estimate<'_>, base: Trial, check: Option<&Record>) -> Result<Suggestion, Complaint> {
    let base_check = check.map(|record| base.check(record)).transpose()?;
    let explained =
        is_adequate(&base.fit, &base.rig) && base_check.as_ref().is_none_or(|run| is_adequate(run, &base.rig));
    if explained {
        let scored = candidates(&[estimate]);
        let (conclusion, judged) = (Conclusion::Adequate, Vec::new());
        return Ok(Suggestion { conclusion, base, base_check, judged, scored, experiment: None });
    }
    // Faults bend to what is missing: what they hide shows where there are none.
    let without = (base.set != 0).then(|| estimate.without_faults(FORMS)).transpose()?;
    let scored = candidates(&[Some(estimate), without.as_ref()].into_iter().flatten().collect::<Vec<_>>());
    let mut stands = vec![(base.values.clone(), base.set)];
    stands.extend(without.map(|without| (without.case.full.parameters(&without.isolation.best.theta), 0)));
    let worth = significant(scored.len());
    let chosen: Vec<Vec<Candidate>> = scored
        .iter()
        .filter(|candidate| candidate.score > worth)
        .take(FITTED)
        .map(|candidate| vec![candidate.clone()])
        .collect();
    let mut judged = judge(estimate, (&base, &stands), &base_check, check, chosen)?;
    if !judged.iter().any(|judged| explains(judged, &base, &base_check)) {
        let best: Vec<&Judged> = judged.iter().take(PAIRED).collect();
        let mut pairs = Vec::new();
        for (place, a) in best.iter().enumerate() {
            pairs.extend(best[..place].iter().map(|b| [b.effects.clone(), a.effects.clone()].concat()));
        }
        judged.extend(judge(estimate, (&base, &stands), &base_check, check, pairs)?);
        rank(&mut judged, &base, estimate.case.record)?;
    }
    let conclusion = conclude(&mut judged, &base, &base_check);
    if conclusion == Conclusion::UnknownEffect {
        // What no law explains, a curve may at least describe.
        let curves = empirical(&base.rig).into_iter().map(|curve| vec![curve]).collect();
        judged.extend(judge(estimate, (&base, &stands), &base_check, check, curves)?);
        rank(&mut judged, &base, estimate.case.record)?;
    }
    let experiment = rivals(&judged).and_then(|[best, rival]| {
        separating([best.id(), rival.id()], &best.trial, &rival.trial)
    });
    Ok(Suggestion { conclusion, base, base_check, judged, scored, experiment })
}

/// The best explanation and the first that is alike.
fn rivals(judged: &[Judged]) -> Option<[&Judged; 2]> {
    let best = judged.first()?;
    let rival = best.confounded_with.first()?;
    Some([best, judged.iter().find(|other| other.id() == *rival)?])
}

/// Fall of chi-square that the best of so many candidates reaches by chance in one of 1,000 records (Bonferroni).
fn significant(candidates: usize) -> f64 {
    2.0 * (1000.0 * candidates.max(1) as f64).ln()
}

/// Whether a run is within noise and tolerance in every channel.
pub fn is_adequate(run: &Run, rig: &Rig) -> bool {
    channel_chi2(run, rig).into_iter().all(|(chi2, rows)| adequate(chi2, rows))
}

/// Mean square of the weighted misfits and number of samples of each sensor.
pub fn channel_chi2(run: &Run, rig: &Rig) -> Vec<(f64, usize)> {
    let rows = run.misfit.len() / rig.sensors.len().max(1);
    run.misfit
        .chunks(rows.max(1))
        .take(rig.sensors.len())
        .map(|misfit| (tame_squares(misfit) / rows.max(1) as f64, rows.max(1)))
        .collect()
}

/// Refits the model with each set of effects.
fn judge(
    estimate: &Estimate<'_>,
    (base, stands): (&Trial, &[Stand]),
    base_check: &Option<Run>,
    check: Option<&Record>,
    chosen: Vec<Vec<Candidate>>,
) -> Result<Vec<Judged>, Complaint> {
    let record = estimate.case.record;
    let mut rough: Vec<(Vec<Candidate>, Rough)> = chosen
        .into_par_iter()
        .filter_map(|effects| {
            let rough = refitted(base, stands, record, &effects)?;
            Some((effects, rough))
        })
        .collect();
    rough.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    // The best go on to their end; of the others it is enough to know that they are worse.
    rough.par_iter_mut().take(CONTINUED).for_each(|(_, rough)| {
        if let Some(further) = quick(&rough.rig, record, &rough.values, rough.set, FORMS) {
            *rough = further;
        }
    });
    rough.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut judged: Vec<Judged> = rough
        .into_par_iter()
        .enumerate()
        .filter_map(|(place, (effects, rough))| {
            // With faults isolated anew.
            let rounds = if place < ISOLATED { ROUNDS } else { 0 };
            let trial = Trial::fitted(&rough.rig, record, &rough.values, rough.set, rounds).ok()?;
            let check = check.and_then(|record| trial.check(record).ok());
            let warnings = warnings(&trial, base);
            Some(Judged {
                effects,
                trial,
                check,
                delta_bic: 0.0,
                supported: false,
                confounded_with: Vec::new(),
                warnings,
            })
        })
        .collect();
    rank(&mut judged, base, record)?;
    for one in &mut judged {
        let better = |before: &Run, after: &Run| after.normalised < before.normalised;
        let on_check = match (base_check, &one.check) {
            (Some(before), Some(after)) => better(before, after),
            (None, _) => true,
            (Some(_), None) => false,
        };
        one.supported = one.delta_bic > RIVAL && on_check;
    }
    Ok(judged)
}

/// Costs under the weights of the best, and the order by the information criterion.
fn rank(judged: &mut [Judged], base: &Trial, record: &Record) -> Result<(), Complaint> {
    let best = judged.iter().min_by(|a, b| a.trial.fit.chi2.total_cmp(&b.trial.fit.chi2));
    let Some((weights, scale)) = best.map(|best| (best.trial.fit.weights.clone(), best.trial.fit.chi2.max(1.0))) else {
        return Ok(());
    };
    let before = base.cost_under(record, &weights)?;
    let samples = (record.time.len() * base.rig.sensors.len()) as f64;
    for one in judged.iter_mut() {
        let cost = one.trial.cost_under(record, &weights)?;
        let more = one.trial.effect_parameters() as f64 - base.effect_parameters() as f64
            + f64::from(one.trial.set.count_ones())
            - f64::from(base.set.count_ones());
        one.delta_bic = (before - cost) / scale - more * samples.ln();
    }
    judged.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
    Ok(())
}

/// What speaks against an effect as fitted.
fn warnings(trial: &Trial, base: &Trial) -> Vec<String> {
    let mut warnings = Vec::new();
    for effect in &trial.rig.effects {
        for (free, &index) in effect.placed.effect.parameters.iter().zip(&effect.parameters) {
            let parameter = &trial.rig.parameters[index];
            if parameter.sigma == 0.0 {
                continue;
            }
            let value = parameter.unit.from_si(trial.values[index]);
            let unit = trial.rig.effect_unit(&effect.placed, free.name);
            let in_card = unit.from_si(trial.values[index]);
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
            && base.rig.effects.iter().all(|effect| !effect.parameters.contains(&index))
            && trial.rig.effects.iter().all(|effect| !effect.parameters.contains(&index))
        {
            warnings.push(format!("moved: {} by {:.1} standard uncertainties", parameter.id, moved / parameter.sigma));
        }
    }
    for fault in members(trial.set & !base.set) {
        warnings.push(format!("fault: {} is needed too", base.rig.parameters[base.rig.faults[fault].parameter].id));
    }
    warnings
}

/// Share of what the model misses that a run explains; 1 where it is within noise and tolerance.
fn explained(before: &Run, after: &Run, rig: &Rig) -> f64 {
    if is_adequate(after, rig) {
        return 1.0;
    }
    1.0 - ((after.chi2 - 1.0).max(0.0) / (before.chi2 - 1.0).max(1e-9))
}

fn explains(judged: &Judged, base: &Trial, base_check: &Option<Run>) -> bool {
    let on_check = match (base_check, &judged.check) {
        (Some(before), Some(after)) => explained(before, after, &base.rig),
        (None, _) => 1.0,
        (Some(_), None) => 0.0,
    };
    judged.supported && explained(&base.fit, &judged.trial.fit, &base.rig).min(on_check) >= EXPLAINED
}

fn conclude(judged: &mut [Judged], base: &Trial, base_check: &Option<Run>) -> Conclusion {
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
