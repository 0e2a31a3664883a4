//! Effects fitted and judged: roughly first, then as far as they could still win.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::evaluated::{EvaluatedModel, is_adequate, joined};
use super::fitted_model::{FittedModel, Judge, effect_parameters, run_under, values_on};
use super::refit::{BasePoint, PreliminaryModel, charged, quick, refitted};
use super::run::Run;
use super::verdict::{is_among, warnings};
use crate::complaint::Complaint;
use crate::diagnosis::noise::Weights;
use crate::diagnosis::search::ROUGH;
use crate::record::Record;
use crate::settings::LearningSettings;

/// A record that is looked at, with the model as given.
pub(super) struct Screening<'a> {
    pub record: &'a Record,
    pub base: &'a FittedModel,
    pub base_check: &'a Option<Run>,
    pub check: Option<&'a Record>,
    /// Where refits start.
    pub base_points: Vec<BasePoint>,
}

/// What fits have to come down to.
struct PruningThreshold {
    /// The least cost so far with its faults and effects priced, and what the others may be above it.
    cost: f64,
    room: f64,
}

impl PruningThreshold {
    /// Whether a fit has no hope to come near.
    fn is_beyond(&self, rough: &PreliminaryModel, samples: f64) -> bool {
        let hope = rough.rig.settings().diagnosis.predicted_decreases;
        !rough.cost.is_finite() || rough.priced(samples) - hope * rough.gained > self.cost + self.room
    }
}

/// What an effect promises to cost where it was scored.
pub(super) fn promised(candidate: &Candidate, base_points: &[BasePoint]) -> Option<f64> {
    Some(base_points.get(candidate.base_point?)?.cost - candidate.score)
}

/// Effects as they are, then with the first of them that may begin elsewhere at each of its other places.
fn starts(effects: &[Candidate]) -> Vec<Vec<Candidate>> {
    let mut starts = vec![effects.to_vec()];
    let Some(place) = effects.iter().position(|effect| !effect.others.is_empty()) else { return starts };
    let own = &effects[place];
    for (index, other) in own.others.iter().enumerate() {
        let mut others = own.others.clone();
        others[index] = Candidate { others: Vec::new(), ..own.clone() };
        let mut start = effects.to_vec();
        start[place] = Candidate { others, ..other.clone() };
        starts.push(start);
    }
    starts
}

impl Screening<'_> {
    fn settings(&self) -> &LearningSettings {
        &self.base.rig.settings().learn
    }

    fn samples(&self) -> f64 {
        self.base.fit.weights.all_samples() as f64
    }

    /// What the best so far sets.
    fn bar(&self, best: f64) -> PruningThreshold {
        let scale = (best / self.samples()).max(1.0);
        let room =
            self.settings().close_share * (self.cost_of(self.base) - best).max(0.0) + self.settings().rival_bic * scale;
        PruningThreshold { cost: best, room }
    }

    /// Whether a preliminary fit leaves nothing to explain.
    fn explains_all(&self, rough: &PreliminaryModel) -> bool {
        run_under(&rough.rig, self.record, &rough.values, None).is_ok_and(|run| is_adequate(&run))
    }

    /// What a trial costs with its faults and effects priced, under its own weights.
    fn cost_of(&self, trial: &FittedModel) -> f64 {
        charged(&trial.rig, trial.cost, trial.set, self.samples())
    }

    /// Refits the model with each set of effects; `known` is what was judged before, the best first.
    pub fn judge(
        &self,
        chosen: Vec<Vec<Candidate>>,
        known: &[EvaluatedModel],
    ) -> Result<Vec<EvaluatedModel>, Complaint> {
        let mut rough = self.roughly(chosen, known);
        let samples = self.samples();
        let known = known.first();
        let mut best = known.map_or(f64::INFINITY, |best| best.screened);
        let continued = |rough: &mut [(Vec<Candidate>, PreliminaryModel)], best: f64| {
            let bar = self.bar(best);
            rough.par_iter_mut().filter(|(_, rough)| !bar.is_beyond(rough, samples)).for_each(|(_, rough)| {
                if let Some(further) = quick(
                    &rough.rig,
                    self.record,
                    &rough.values,
                    (rough.set, self.settings().linearisations),
                    Some(ROUGH),
                ) {
                    *rough = further;
                }
            });
        };
        // The best goes on to its end first; of the others it is enough to know that they are worse.
        let most = rough.len().min(self.settings().effects_continued);
        let (first, others) = rough[..most].split_at_mut(most.min(1));
        continued(first, best);
        best = first.iter().map(|(_, rough)| rough.priced(samples)).fold(best, f64::min);
        continued(others, best);
        rough.sort_by(|a, b| a.1.priced(samples).total_cmp(&b.1.priced(samples)));
        best = rough.first().map_or(best, |(_, rough)| best.min(rough.priced(samples)));
        let bar = self.bar(best);
        let explained = known.is_some_and(|best| is_adequate(&best.trial.fit))
            || rough.first().is_some_and(|(_, rough)| self.explains_all(rough));
        let count = self.base.rig.context().count("effects judged", rough.len());
        let one = |isolated: bool, weights: Option<(&Weights, Option<&Weights>)>, (effects, rough)| {
            let judged = self.judged(effects, &rough, isolated, weights.filter(|_| bar.is_beyond(&rough, samples)));
            count.one();
            judged
        };
        let behind = rough.split_off(rough.len().min(self.settings().effects_isolated));
        let in_front = rough.into_par_iter().enumerate().filter_map(|(place, (effects, rough))| {
            let isolated = !(bar.is_beyond(&rough, samples) && (place > 0 || known.is_some()) && explained);
            one(isolated, None, (effects, rough))
        });
        let mut judged: Vec<EvaluatedModel> = in_front.collect();
        // What is far behind is weighed as the best is.
        let best = judged.iter().min_by(|a, b| a.trial.fit.chi2.total_cmp(&b.trial.fit.chi2));
        let weights = best.map(|best| (&best.trial.fit.weights, best.check.as_ref().map(|check| &check.weights)));
        let others: Vec<EvaluatedModel> =
            behind.into_par_iter().filter_map(|rough| one(false, weights, rough)).collect();
        judged.extend(others);
        self.rank(&mut judged)?;
        Ok(judged)
    }

    /// Preliminary fits with each set of effects, the best first.
    fn roughly(
        &self,
        chosen: Vec<Vec<Candidate>>,
        known: &[EvaluatedModel],
    ) -> Vec<(Vec<Candidate>, PreliminaryModel)> {
        let Self { record, base, ref base_points, .. } = *self;
        let samples = self.samples();
        let count = base.rig.context().count("effects fitted", chosen.len());
        let fitted = |effects: Vec<Candidate>| {
            let smaller: Vec<&EvaluatedModel> = known.iter().filter(|one| is_among(&one.effects, &effects)).collect();
            let rough = refitted(base, base_points, &smaller, record, &effects, None);
            count.one();
            (effects, rough)
        };
        // Scores know nothing of what an effect's parameters are charged.
        let price_of_effects = |rough: &Option<PreliminaryModel>| {
            let more = |rough: &PreliminaryModel| effect_parameters(&rough.rig) - effect_parameters(&base.rig);
            rough.as_ref().map_or(0.0, |rough| more(rough) as f64 * samples.ln())
        };
        let mut rough: Vec<(Vec<Candidate>, Option<PreliminaryModel>)> = chosen.into_par_iter().map(fitted).collect();
        let cost =
            |rough: &Option<PreliminaryModel>| rough.as_ref().map_or(f64::INFINITY, |rough| rough.priced(samples));
        // Scores of one stand are compared with each other.
        let scores: Vec<(Option<usize>, f64)> =
            rough.iter().flat_map(|(effects, _)| effects).map(|effect| (effect.base_point, effect.score)).collect();
        let most = |base_point| scores.iter().filter(|one| one.0 == base_point).map(|one| one.1).fold(0.0, f64::max);
        rough.par_iter_mut().for_each(|(effects, rough)| {
            // At which level a law begins shows only beside what else is missing.
            if effects.len() > 1 && effects.iter().any(|effect| effect.placed.effect.has_level()) {
                if let Some((found, start)) = self.best_of_starts(starts(effects), rough.as_ref()) {
                    (*rough, *effects) = (Some(found), start);
                }
                return;
            }
            let [effect] = effects.as_slice() else { return };
            let Some(promised) = promised(effect, base_points) else { return };
            if effect.score <= self.settings().kept_share * most(effect.base_point) {
                return;
            }
            if !effect.others.is_empty() {
                if let Some((found, start)) = self.best_of_starts(starts(effects), rough.as_ref()) {
                    (*rough, *effects) = (Some(found), start);
                }
                return;
            }
            let kept =
                cost(rough) - price_of_effects(rough) <= promised + (1.0 - self.settings().kept_share) * effect.score;
            if !kept {
                let again = refitted(
                    base,
                    &[BasePoint::healthy(&base.rig)],
                    &[],
                    record,
                    &[effect.as_typical(&base.rig)],
                    None,
                );
                if cost(&again) < cost(rough) {
                    *rough = again;
                }
            }
        });
        let mut rough: Vec<(Vec<Candidate>, PreliminaryModel)> =
            rough.into_iter().filter_map(|(effects, rough)| Some((effects, rough?))).collect();
        rough.sort_by(|a, b| a.1.priced(samples).total_cmp(&b.1.priced(samples)));
        // From several stands the same effect comes twice.
        let mut known: Vec<String> = Vec::new();
        rough.retain(|(effects, _)| {
            let id = joined(effects);
            let new = !known.contains(&id);
            known.push(id);
            new
        });
        rough
    }

    /// Of refits from several starts the one that explains both records best: where a law begins may be anywhere between two
    /// pressures or levels at which the fit record stands. `first` is the refit from the first start.
    fn best_of_starts(
        &self,
        starts: Vec<Vec<Candidate>>,
        first: Option<&PreliminaryModel>,
    ) -> Option<(PreliminaryModel, Vec<Candidate>)> {
        let samples = self.samples();
        // Which start leads furthest shows at the ends.
        let ends = starts.into_iter().enumerate().filter_map(|(place, start)| {
            let rough = match place {
                0 => first.cloned()?,
                _ => refitted(self.base, &self.base_points, &[], self.record, &start, None)?,
            };
            let further =
                quick(&rough.rig, self.record, &rough.values, (rough.set, self.settings().linearisations), Some(ROUGH));
            let end = further.unwrap_or(rough);
            let on_check = self.check.map_or(Some(0.0), |record| {
                let values = values_on(&end.rig, &end.values, record).ok()?;
                let run = run_under(&end.rig, record, &values, None).ok()?;
                Some(run.chi2 * run.weights.all_samples() as f64)
            });
            Some((end.priced(samples) + on_check?, end, start))
        });
        let (_, end, start) = ends.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((end, start))
    }

    /// One refit on both records, with faults isolated anew or as it is, under its own weights or given ones of each.
    fn judged(
        &self,
        effects: Vec<Candidate>,
        rough: &PreliminaryModel,
        isolated: bool,
        weights: Option<(&Weights, Option<&Weights>)>,
    ) -> Option<EvaluatedModel> {
        let PreliminaryModel { rig, values, set, cost, .. } = rough;
        let trial = if isolated {
            FittedModel::fitted(rig, self.record, values, *set, self.settings().isolation_rounds)
        } else {
            FittedModel::at(rig, self.record, values, (*set, *cost), weights.map(|(fit, _)| fit))
        };
        let trial = trial.ok()?;
        let on_check = weights.and_then(|(_, check)| check);
        let check = self.check.and_then(|record| trial.check_under(record, on_check).ok());
        let warnings = warnings(&trial, self.base);
        Some(EvaluatedModel {
            effects,
            trial,
            preliminary: rough.cost,
            screened: rough.priced(self.samples()),
            check,
            delta_bic: 0.0,
            evidence: 0.0,
            supported: false,
            finished: false,
            isolated,
            confounded_with: Vec::new(),
            warnings,
        })
    }

    /// Fits those that come near the best to their end: what decides between them is smaller than what rough fits leave.
    pub fn settle(&self, judged: &mut [EvaluatedModel]) -> Result<(), Complaint> {
        let Some(top) = judged.first().map(|best| best.evidence) else { return Ok(()) };
        let near = |one: &EvaluatedModel| {
            let share = if one.isolated { self.settings().close_share_isolated } else { self.settings().close_share };
            one.evidence > top - (share * top).max(self.settings().rival_bic)
        };
        if top <= self.settings().rival_bic || judged.iter().filter(|one| near(one)).count() < 2 {
            return Ok(());
        }
        judged.par_iter_mut().filter(|one| near(one)).for_each(|one| {
            let FittedModel { rig, values, set, .. } = &one.trial;
            let Ok(trial) = FittedModel::fitted(rig, self.record, values, *set, self.settings().isolation_rounds)
            else {
                return;
            };
            one.check = self.check.and_then(|record| trial.check(record).ok());
            one.warnings = warnings(&trial, self.base);
            one.trial = trial;
            one.isolated = true;
        });
        self.rank(judged)
    }

    /// Refits with further sets of effects, and ranks all anew.
    pub fn join(&self, judged: &mut Vec<EvaluatedModel>, chosen: Vec<Vec<Candidate>>) -> Result<(), Complaint> {
        if chosen.is_empty() {
            return Ok(());
        }
        let more = self.judge(chosen, judged)?;
        judged.extend(more);
        self.rank(judged)
    }

    /// Costs under the weights of the best, what they support, and the order by what both records say.
    fn rank(&self, judged: &mut [EvaluatedModel]) -> Result<(), Complaint> {
        let Self { record, base, .. } = *self;
        let best = judged.iter().min_by(|a, b| a.trial.fit.chi2.total_cmp(&b.trial.fit.chi2));
        let Some(best) = best else { return Ok(()) };
        let judge = Judge::of(&best.trial, &best.trial.fit, record)?;
        let of_check = match (self.check, best.check.as_ref(), self.base_check) {
            (Some(record), Some(run), Some(before)) => Some((record, before, Judge::of(&best.trial, run, record)?)),
            _ => None,
        };
        for one in judged.iter_mut() {
            one.delta_bic = one.trial.gain_over(base, record, &judge)?;
            one.evidence = one.delta_bic;
            if let (Some((record, before, judge)), Some(after)) = (&of_check, &one.check) {
                one.evidence += judge.fall(record, (base, before), (&one.trial, after))?;
            }
            let on_check = match (self.base_check, &one.check) {
                (Some(before), Some(after)) => after.normalised < before.normalised,
                (None, _) => true,
                (Some(_), None) => false,
            };
            one.supported = one.delta_bic > self.settings().rival_bic && on_check;
        }
        judged.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        Ok(())
    }
}
