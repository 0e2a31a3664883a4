//! Whether one effect explains outright what the declared faults of a rig miss.
//!
//! Where physics is missing, the search for a value that nobody declared, for a beginning within the record and for parts that deviate
//! takes minutes and ends in nonsense. So the library is asked first, as cheaply as that can be told: effects scored where the faults
//! have ended and where there are none, the first few of them fitted. One that leaves nothing is what [`suggest`](super::suggest) goes
//! into; a value that promises nearly as much is asked about first.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::fitted_model::{FittedModel, run_under};
use super::lack_of_fit::with_lack_of_fit;
use super::refit::{BasePoint, PreliminaryModel, charged, quick, refitted};
use super::scoring::{candidates, worth};
use super::suggest::{Suggestion, finished, suggest_from};
use super::trial_steps::ScoreContext;
use crate::complaint::Complaint;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::misstated::{may_be_misstated, undeclared_fault};
use crate::diagnosis::search::ROUGH;
use crate::model::Model;
use crate::record::Record;
use crate::rig::{FaultSet, Location, Rig};

/// What explains a record outright that declared faults miss.
pub(super) enum Outright<T> {
    /// No single effect.
    Nothing,
    /// An effect, and a value that nobody declared nearly as well.
    AValue,
    /// An effect, and what was asked of it.
    Physics(T),
}

/// Whether one effect of the library explains a record that the declared faults of `first` miss, and no value that nobody declared does
/// nearly as well.
///
/// # Errors
/// Columns that are missing, a model that cannot be solved, or a [context](crate::Context) that was cancelled.
pub(super) fn explains_outright(first: &Estimate<'_>) -> Result<bool, Complaint> {
    Ok(matches!(outright(first, |_, _| Ok(()))?, Outright::Physics(())))
}

/// What is suggested where one effect does; nothing also where the best of all leaves something.
///
/// # Errors
/// As [`explains_outright`].
pub(super) fn suggested_outright(first: &Estimate<'_>) -> Result<Outright<Suggestion>, Complaint> {
    let record = first.case.record;
    let suggested = |with: &Estimate<'_>, base: FittedModel| finished(suggest_from(with, base, None)?, record, None);
    Ok(match outright(first, suggested)? {
        Outright::Physics(found) if !found.explains_all() => Outright::Nothing,
        found => found,
    })
}

/// What explains a record outright; with what `then` gives of the estimate, weighed by its lack of fit, and of the model fitted so.
fn outright<T>(
    first: &Estimate<'_>,
    then: impl FnOnce(&Estimate<'_>, FittedModel) -> Result<T, Complaint>,
) -> Result<Outright<T>, Complaint> {
    let (rig, record, full) = (first.case.rig(), first.case.record, &first.case.full);
    let settings = &rig.settings().learn;
    rig.context().stage("effects in place of faults");
    let lacking = with_lack_of_fit(rig, &FittedModel::of(first)?.fit);
    let model = Model::new(lacking);
    let start = (&first.isolation.best.theta[..], first.isolation.set());
    let few = rig.settings().diagnosis.first_linearisations;
    let with = estimate::held_at(&model, record, full.drive, start, few)?;
    let base = FittedModel::of(&with)?;
    let samples = base.fit.weights.all_samples() as f64;
    let mut stands = vec![with];
    // Faults that take less than half of what is missed may be bent to it: what they hide shows where there are none.
    if !base.set.is_empty() {
        let without = stands[0].without_faults(few)?;
        let half = 2.0 * stands[0].isolation.best.cost;
        stands.extend(Some(without).filter(|without| without.isolation.best.cost < half));
    }
    let base_points: Vec<BasePoint> = stands.iter().map(|stand| base_point(stand, samples)).collect();
    let is_physics = |one: &Candidate| !matches!(one.placed.spot, Location::Sensor(_));
    let of_stand = |(place, stand): (usize, &Estimate<'_>)| {
        let all = candidates(stand, place, 0.0);
        let least = worth(all.len(), 0.0);
        let promising = all.into_iter().filter(|one| one.score > least && is_physics(one));
        promising.take(settings.rivals_fitted).collect::<Vec<_>>()
    };
    let tried: Vec<Candidate> = stands.iter().enumerate().flat_map(of_stand).collect();
    let fitted = |effect: Candidate| {
        let rough = refitted(&base, &base_points, &[], record, &[effect], None)?;
        let start = (rough.set, settings.linearisations);
        let ended = quick(&rough.rig, record, &rough.values, start, Some(ROUGH)).unwrap_or(rough);
        let run = run_under(&ended.rig, record, &ended.values, None).ok()?;
        run.is_adequate.then(|| ended.priced(samples))
    };
    let left = tried.into_par_iter().filter_map(fitted).reduce_with(f64::min);
    rig.context().check()?;
    let Some(left) = left else { return Ok(Outright::Nothing) };
    let given = base_points[0].cost;
    let enough = given - settings.rival_share * (given - left);
    let values: Vec<(usize, &BasePoint)> = stands
        .iter()
        .zip(&base_points)
        .flat_map(|(stand, point)| promising_values(stand).into_iter().map(move |value| (value, point)))
        .collect();
    let is_as_good = |&(value, point): &(usize, &BasePoint)| {
        with_value(&base.rig, record, point, value).is_some_and(|with| with.priced(samples) <= enough)
    };
    if values.par_iter().any(is_as_good) {
        return Ok(Outright::AValue);
    }
    then(&stands[0], base).map(Outright::Physics)
}

/// Where a model without effects stands.
fn base_point(stand: &Estimate<'_>, samples: f64) -> BasePoint {
    let (isolation, full) = (&stand.isolation, &stand.case.full);
    let set = isolation.set();
    BasePoint {
        values: full.parameters(&isolation.best.theta),
        set,
        cost: charged(stand.case.rig(), isolation.best.cost, set, samples),
    }
}

/// The first few values that are no declared faults, by the fall of the cost that they promise in the local model, as free as faults; none
/// where the model cannot be solved.
fn promising_values(stand: &Estimate<'_>) -> Vec<usize> {
    let full = &stand.case.full;
    let by: Vec<usize> = may_be_misstated(&full.model.rig).collect();
    let values = full.parameters(&stand.isolation.local.theta);
    let Some(here) = ScoreContext::of(stand, 0.0) else { return Vec::new() };
    let Ok(solved) = full.model.sensitivities(&values, &by, full.drive, full.times) else { return Vec::new() };
    let promised = |(&value, derivative): (&usize, &Vec<Vec<f64>>)| {
        let mut change = derivative.concat();
        full.weights.apply(&mut change);
        let score = here.scoring.of(&change);
        (score.fall_at(score.factor), value)
    };
    let mut promised: Vec<(f64, usize)> = by.iter().zip(&solved.derivatives).map(promised).collect();
    promised.retain(|(fall, _)| fall.is_finite());
    promised.sort_by(|a, b| b.0.total_cmp(&a.0));
    promised.into_iter().map(|(_, value)| value).take(full.model.rig.settings().learn.rivals_fitted).collect()
}

/// The model with a value as free as a fault, fitted; `None` where it cannot be solved.
fn with_value(rig: &Rig, record: &Record, point: &BasePoint, value: usize) -> Option<PreliminaryModel> {
    if rig.faults.len() == FaultSet::CAPACITY {
        return None;
    }
    let mut rig = rig.clone();
    let set = point.set.with(rig.faults.len());
    rig.faults.push(undeclared_fault(&rig, value));
    quick(&rig, record, &point.values, (set, rig.settings().learn.linearisations), Some(ROUGH))
}
