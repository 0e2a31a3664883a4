//! Which effect is missing: candidates by score, joint refits of the best, one verdict.

use rayon::prelude::*;

use super::candidate::{Candidate, candidates, empirical};
use super::refit::{FORMS, Rough, Stand, quick, refitted};
use super::separate::{Experiment, separating};
use super::trial::{Run, Trial};
use super::verdict::{conclude, conclude_near, explains, warnings};
use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::case::members;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::{adequate, mean_squares};
use crate::model::{Drive, Model};
use crate::progress::{self, Count};
use crate::record::Record;
use crate::rig::Rig;

/// Candidates that are fitted.
const FITTED: usize = 8;
/// The same of those that show where no fault has bent to what is missing, and where the model is within its tolerance.
const FITTED_NEAR: usize = 4;
/// Share of the noise that an effect has to explain where the model is within its tolerance: what is less is tolerance.
const NEAR: f64 = 0.03;
/// Candidates of which pairs are fitted where none explains the record alone.
const PAIRED: usize = 5;
/// Ratio of two scores within which the refit has to say which effect explains more.
const SCORES_ALIKE: f64 = 1.2;
/// Share of the best one's gain within which others are fitted to their end too.
const CLOSE: f64 = 0.05;
/// Candidates that are isolated anew, faults and all.
const ISOLATED: usize = 2;
/// Candidates that go on to their end.
const CONTINUED: usize = 3;
/// Rounds of isolation of each fit.
pub(super) const ROUNDS: u64 = 4;
/// Difference of the information criterion within which two explanations are rivals (Kass and Raftery 1995: very strong).
pub const RIVAL: f64 = 10.0;

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
        joined(&self.effects)
    }

    /// Whether it makes no physical sense as fitted: a value that nobody would believe, or a size on a bound of its search;
    /// what only shapes an effect may end there.
    pub fn senseless(&self) -> bool {
        let sizes = self.trial.rig.effects.iter().filter_map(|effect| effect.parameters.first());
        let ids: Vec<&String> = sizes.map(|&index| &self.trial.rig.parameters[index].id).collect();
        let size_at_bound = |warning: &str| ids.iter().any(|id| warning.starts_with(&format!("at-bound: {id} ")));
        self.warnings.iter().any(|warning| warning.starts_with("implausible") || size_at_bound(warning))
    }
}

/// What effects together are called.
fn joined(effects: &[Candidate]) -> String {
    effects.iter().map(|effect| effect.id.as_str()).collect::<Vec<_>>().join(" + ")
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
    progress::stage("fit of the model as given");
    let near = estimate::near(&model, fit, &drive, None, estimate::FROM_HEALTHY)?;
    let base = Trial::of(&near)?;
    if is_adequate(&base.fit) {
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
    let rough =
        candidate.and_then(|candidate| refitted(base, &stands, record, &[Candidate { stand: None, ..candidate }]));
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
    let near = is_adequate(&base.fit) && base_check.as_ref().is_none_or(is_adequate);
    // Faults bend to what is missing: what they hide shows where there are none.
    let of_components = members(base.set).any(|fault| !estimate.case.is_of_sensor(fault));
    let without = (of_components || (base.set != 0 && !near)).then(|| estimate.without_faults(FORMS)).transpose()?;
    let mut lists = vec![candidates(estimate, 0)];
    lists.extend(without.as_ref().map(|without| candidates(without, 1)));
    let mut stands = vec![(base.values.clone(), base.set)];
    stands.extend(without.map(|without| (without.case.full.parameters(&without.isolation.best.theta), 0)));
    let looking = Looking { record: estimate.case.record, base: &base, base_check: &base_check, check, stands };
    let worth = significant(lists[0].len()) + if near { NEAR * base.fit.weights.all_samples() as f64 } else { 0.0 };
    let most = [if near { FITTED_NEAR } else { FITTED }, FITTED_NEAR];
    let promising = lists.iter().zip(most).flat_map(|(list, most)| {
        list.iter().filter(|candidate| candidate.score > worth).take(most).map(|candidate| vec![candidate.clone()])
    });
    let mut judged = looking.judge(promising.collect())?;
    let more = alike(&judged, &lists);
    looking.join(&mut judged, more)?;
    if !near && !judged.iter().any(|judged| explains(judged, &base, &base_check)) {
        let more = pairs(&judged);
        looking.join(&mut judged, more)?;
    }
    looking.settle(&mut judged)?;
    let conclusion =
        if near { conclude_near(&mut judged, &base, &base_check) } else { conclude(&mut judged, &base, &base_check) };
    if conclusion == Conclusion::UnknownEffect {
        // What no law explains, a curve may at least describe.
        looking.join(&mut judged, empirical(&base.rig).into_iter().map(|curve| vec![curve]).collect())?;
    }
    let experiment = apart(&judged, &base);
    let scored = lists.swap_remove(0);
    Ok(Suggestion { conclusion, base, base_check, judged, scored, experiment })
}

/// Candidates that promise as much as the best explanation where it was scored, and were not fitted.
fn alike(judged: &[Judged], lists: &[Vec<Candidate>]) -> Vec<Vec<Candidate>> {
    let Some([best]) = judged.first().map(|best| best.effects.as_slice()) else { return Vec::new() };
    let list = best.stand.and_then(|stand| lists.get(stand)).map_or(&[][..], Vec::as_slice);
    let known = |candidate: &Candidate| judged.iter().any(|one| one.id() == candidate.id);
    let close = list.iter().filter(|candidate| candidate.score * SCORES_ALIKE > best.score && !known(candidate));
    close.take(FITTED).map(|candidate| vec![candidate.clone()]).collect()
}

/// The best explanations, two by two.
fn pairs(judged: &[Judged]) -> Vec<Vec<Candidate>> {
    let best: Vec<&Judged> = judged.iter().take(PAIRED).collect();
    let mut pairs = Vec::new();
    for (place, a) in best.iter().enumerate() {
        pairs.extend(best[..place].iter().map(|b| [b.effects.clone(), a.effects.clone()].concat()));
    }
    pairs
}

/// What would tell the best explanation from the first that is alike: an effect, or the faults of the model as given.
fn apart(judged: &[Judged], base: &Trial) -> Option<Experiment> {
    let best = judged.first()?;
    let rival = best.confounded_with.first()?;
    let other = judged.iter().find(|other| other.id() == *rival).map_or(base, |other| &other.trial);
    separating([best.id(), rival.clone()], &best.trial, other)
}

/// Fall of chi-square that the best of so many candidates reaches by chance in one of 1,000 records (Bonferroni).
fn significant(candidates: usize) -> f64 {
    2.0 * (1000.0 * candidates.max(1) as f64).ln()
}

/// Whether a run is within noise and tolerance in every channel.
pub fn is_adequate(run: &Run) -> bool {
    mean_squares(&run.weights, &run.misfit).into_iter().all(|(square, samples)| adequate(square, samples))
}

/// A record that is looked at, with the model as given.
struct Looking<'a> {
    record: &'a Record,
    base: &'a Trial,
    base_check: &'a Option<Run>,
    check: Option<&'a Record>,
    /// Where refits start.
    stands: Vec<Stand>,
}

impl Looking<'_> {
    /// Refits the model with each set of effects.
    fn judge(&self, chosen: Vec<Vec<Candidate>>) -> Result<Vec<Judged>, Complaint> {
        let Self { record, base, check, ref stands, .. } = *self;
        let count = Count::new("effects fitted", chosen.len());
        let mut rough: Vec<(Vec<Candidate>, Rough)> = chosen
            .into_par_iter()
            .filter_map(|effects| {
                let rough = refitted(base, stands, record, &effects);
                count.one();
                Some((effects, rough?))
            })
            .collect();
        let samples = base.fit.weights.all_samples() as f64;
        rough.sort_by(|a, b| a.1.priced(samples).total_cmp(&b.1.priced(samples)));
        // From several stands the same effect comes twice.
        let mut known: Vec<String> = Vec::new();
        rough.retain(|(effects, _)| {
            let id = joined(effects);
            let new = !known.contains(&id);
            known.push(id);
            new
        });
        // The best go on to their end; of the others it is enough to know that they are worse.
        rough.par_iter_mut().take(CONTINUED).for_each(|(_, rough)| {
            if let Some(further) = quick(&rough.rig, record, &rough.values, rough.set, FORMS) {
                *rough = further;
            }
        });
        rough.sort_by(|a, b| a.1.priced(samples).total_cmp(&b.1.priced(samples)));
        let count = Count::new("effects judged", rough.len());
        let mut judged: Vec<Judged> = rough
            .into_par_iter()
            .enumerate()
            .filter_map(|(place, (effects, rough))| {
                // With faults isolated anew.
                let rounds = if place < ISOLATED { ROUNDS } else { 0 };
                let trial = Trial::fitted(&rough.rig, record, &rough.values, rough.set, rounds).ok()?;
                let check = check.and_then(|record| trial.check(record).ok());
                let warnings = warnings(&trial, base);
                count.one();
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
        self.rank(&mut judged)?;
        Ok(judged)
    }

    /// Fits those that come near the best to their end: what decides between them is smaller than what rough fits leave.
    fn settle(&self, judged: &mut [Judged]) -> Result<(), Complaint> {
        let Some(top) = judged.first().map(|best| best.delta_bic) else { return Ok(()) };
        let close = judged.iter().take_while(|one| one.delta_bic > (1.0 - CLOSE) * top).count();
        if top <= RIVAL || close < 2 {
            return Ok(());
        }
        judged[..close].par_iter_mut().for_each(|one| {
            let Trial { rig, values, set, .. } = &one.trial;
            let Ok(trial) = Trial::fitted(rig, self.record, values, *set, ROUNDS) else { return };
            one.check = self.check.and_then(|record| trial.check(record).ok());
            one.warnings = warnings(&trial, self.base);
            one.trial = trial;
        });
        self.rank(judged)
    }

    /// Refits with further sets of effects, and ranks all anew.
    fn join(&self, judged: &mut Vec<Judged>, chosen: Vec<Vec<Candidate>>) -> Result<(), Complaint> {
        if chosen.is_empty() {
            return Ok(());
        }
        judged.extend(self.judge(chosen)?);
        self.rank(judged)
    }

    /// Costs under the weights of the best, what they support, and the order by the information criterion.
    fn rank(&self, judged: &mut [Judged]) -> Result<(), Complaint> {
        let Self { record, base, .. } = *self;
        let best = judged.iter().min_by(|a, b| a.trial.fit.chi2.total_cmp(&b.trial.fit.chi2));
        let Some((weights, scale)) = best.map(|best| (best.trial.fit.weights.clone(), best.trial.fit.chi2.max(1.0)))
        else {
            return Ok(());
        };
        let before = base.cost_under(record, &weights)?;
        let samples = base.fit.weights.all_samples() as f64;
        for one in judged.iter_mut() {
            let cost = one.trial.cost_under(record, &weights)?;
            let more = one.trial.effect_parameters() as f64 - base.effect_parameters() as f64
                + f64::from(one.trial.set.count_ones())
                - f64::from(base.set.count_ones());
            one.delta_bic = (before - cost) / scale - more * samples.ln();
            let on_check = match (self.base_check, &one.check) {
                (Some(before), Some(after)) => after.normalised < before.normalised,
                (None, _) => true,
                (Some(_), None) => false,
            };
            one.supported = one.delta_bic > RIVAL && on_check;
        }
        judged.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
        Ok(())
    }
}
