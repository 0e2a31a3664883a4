//! Faults behind physics that the model lacks.
//!
//! A model that lacks an effect is bent towards the record by whatever may move, faults first: friction that nobody wrote down
//! becomes a narrow opening with an interval as small as if it were the truth. So where faults, or none, do not explain
//! the record, effects compete with them under the one criterion of [`suggest`], and the faults are isolated again beside the
//! effect that wins; where one effect explains outright what they miss ([`super::outright`]), ahead of other questions. Where they do
//! explain it, effects that would explain it as well are named beside them ([`super::rivals`]); where one of these does better, or clearly
//! more than noise is left, effects compete all the same, also where no fault is present: what tolerances of switching forgive need not
//! be a matter of switching.

use super::evaluated::{Conclusion, EvaluatedModel};
use super::fitted_model::FittedModel;
use super::opened::neutral;
use super::outright::Asked;
use super::rivals::rival_effects;
use super::spools;
use super::suggest::suggest;
use crate::complaint::Complaint;
use crate::diagnosis::{
    self, CLEARLY_ABOVE_NOISE, Diagnosed, Diagnosis, DiagnosisOptions, DynamicsReport, MissingEffect, Physics,
    RivalEffect, Verdict,
};
use crate::estimation::profile::QUANTILE;
use crate::model::Model;
use crate::record::Record;
use crate::rig::{Location, Rig};

/// Diagnoses one record of a rig. Where faults do not explain it, they are sought beside the effect that the model lacks, if the
/// library has one that explains more; the verdict stays [`Verdict::ModelInadequate`], and
/// [`Diagnosis::missing_effect`] names the effect.
///
/// # Errors
/// Columns that are missing, a model that cannot be solved, or a [context](crate::Context) that was cancelled.
pub fn diagnose(model: &Model, record: &Record, options: &DiagnosisOptions) -> Result<Diagnosed, Complaint> {
    model.rig.context().run(|| diagnose_here(model, record, options))
}

/// The same on the threads of the caller.
fn diagnose_here(model: &Model, record: &Record, options: &DiagnosisOptions) -> Result<Diagnosed, Complaint> {
    let physics = Asked::default();
    let given = diagnosis::diagnose_unless(model, record, options, &physics)?;
    let is_by_physics = physics.has_explained() && !given.diagnosis.is_explained();
    let found = beside_physics(model, record, options, (given, physics.as_good()))?;
    if !is_by_physics || found.diagnosis.missing_effect.as_ref().is_some_and(|missing| missing.explained) {
        return Ok(found);
    }
    // What was spared for the sake of physics is owed where that is not the answer.
    beside_physics(model, record, options, (diagnosis::diagnose(model, record, options)?, &[]))
}

/// A diagnosis with the physics that its faults compete with. Values of these ids, each alone and declared by nobody, are known to do as
/// well as any effect.
pub(super) fn beside_physics(
    model: &Model,
    record: &Record,
    options: &DiagnosisOptions,
    (mut given, as_good): (Diagnosed, &[String]),
) -> Result<Diagnosed, Complaint> {
    // A fault that began within the record is told from an effect by its beginning.
    if given.diagnosis.verdict == Verdict::Faulty && given.diagnosis.onset_s.is_none() {
        let record = given.record(record);
        let rivals = rival_effects(given.rig(&model.rig), record, &given)?;
        given.diagnosis.rival_effects = rivals;
        let is_as_good = matches!(&given.diagnosis.undeclared[..], [one] if as_good.contains(one));
        let is_left = given.diagnosis.is_above_noise() || may_be_bent(&given.diagnosis);
        if !is_outdone(&model.rig, &given.diagnosis) && (is_as_good || !is_left) {
            return Ok(given);
        }
    }
    let explained = given.diagnosis.is_explained();
    // What no fault bends may be forgiven as a matter of switching; what nothing explains may be where record and rig file differ.
    let is_bent = given.diagnosis.present().next().is_some() || given.diagnosis.is_above_noise();
    let is_asked = is_bent || !explained && given.diagnosis.at_odds.is_empty();
    // Before a calibration parts that deviate as parts do and physics that is missing are not told apart.
    let is_open = given.diagnosis.off_data_sheet.as_ref().is_some_and(|off| off.beyond_chance().is_none());
    if !is_asked || is_open || (explained && given.diagnosis.onset_s.is_some()) || given.diagnosis.is_misread() {
        return Ok(given);
    }
    let (noise, seen) = (given.diagnosis.times_noise, given.record(record));
    let suggestion = suggest(&model.rig, seen, None)?;
    let takes_place = |one: &EvaluatedModel| {
        let named = |rival: &str| one.effects.iter().any(|effect| effect.id == rival);
        given.diagnosis.rival_effects.iter().any(|one| named(&one.effect))
    };
    let is_physics = |one: &EvaluatedModel| !one.is_of_sensor() && !one.is_empirical();
    let best = suggestion.judged.iter().find(|one| one.supported && !one.senseless());
    let Some(best) = best.filter(|best| !explained || is_physics(best)) else { return Ok(given) };
    let with_effect = Model::new(installed(&model.rig, &best.trial)).with_tolerance(model.tolerance);
    let beside = diagnosis::diagnose_near(&with_effect, seen, (&best.trial.values, best.trial.set), options)?;
    // What comes nearest without explaining the record is not what the model lacks, and faults beside it mean nothing.
    let is_unknown = suggestion.conclusion == Conclusion::UnknownEffect && !beside.diagnosis.is_explained();
    let settings = &model.rig.settings().learn;
    // What takes the place of a fault has to do better; what comes beside faults that explain the record, all that they leave.
    let most = match explained {
        false => noise,
        true if takes_place(best) => (1.0 - settings.clear_share) * noise,
        true => (1.0 + (1.0 - settings.explained_share) * (noise * noise - 1.0)).sqrt(),
    };
    let no_better = explained && !beside.diagnosis.is_explained();
    if is_unknown || no_better || beside.diagnosis.times_noise >= most {
        return Ok(given);
    }
    let mut joined = joined(given, beside, best, with_effect.rig);
    let dynamics = spools::report(&model.rig, joined.rig(&model.rig));
    let is_told = |one: &DynamicsReport| dynamics.iter().any(|other| other.id == one.id);
    joined.diagnosis.dynamics.retain(|one| !is_told(one));
    joined.diagnosis.dynamics.splice(0..0, dynamics);
    Ok(joined)
}

/// Whether an effect that was added does anything as a diagnosis has fitted it: one that has a single size may have it within chance (95 %)
/// of nothing. Several sizes may do together what none of them does for sure.
fn is_at_work(rig: &Rig, diagnosis: &Diagnosis, id: &str) -> bool {
    let Some(present) = rig.effects.iter().find(|present| present.id == id) else { return false };
    let sizes: Vec<(usize, f64)> = present
        .placed
        .effect
        .parameters
        .iter()
        .zip(&present.parameters)
        .filter_map(|(free, &index)| Some((index, neutral(rig, &present.placed, free)?)))
        .collect();
    let [(index, nothing)] = sizes[..] else { return true };
    let parameter = &rig.parameters[index];
    let fitted = diagnosis.uncertain.iter().find(|one| one.id == parameter.id);
    let known = fitted.and_then(|fitted| Some((fitted.value, fitted.sigma_after?)));
    known.is_none_or(|(value, sigma)| {
        (parameter.unit.to_si(value) - nothing).abs() > QUANTILE * parameter.unit.difference_to_si(sigma)
    })
}

/// Whether faults that nobody declared may bend the model together as no rival is asked to: half as much again as the variance of noise is
/// left.
fn may_be_bent(diagnosis: &Diagnosis) -> bool {
    !diagnosis.undeclared.is_empty() && diagnosis.times_noise.powi(2) > CLEARLY_ABOVE_NOISE
}

/// Whether an effect in place of a fault does better than the fault that explains a record within what the rig file allows, and there is
/// clearly more than noise for it to explain. An effect of a sensor takes up what a rig file has wrong elsewhere.
fn is_outdone(rig: &Rig, diagnosis: &Diagnosis) -> bool {
    let (settings, noise) = (&rig.settings().learn, diagnosis.times_noise);
    let of_sensor = |effect: &str| rig.placed(effect).is_ok_and(|placed| matches!(placed.spot, Location::Sensor(_)));
    let does_better = |one: &RivalEffect| one.delta_bic > settings.rival_bic && !of_sensor(&one.effect);
    noise * (1.0 - settings.clear_share) > 1.0 && diagnosis.rival_effects.iter().any(does_better)
}

impl Model {
    /// [`diagnose`] with the default options, without the curves behind it.
    ///
    /// # Errors
    /// As [`diagnose`].
    pub fn diagnose(&self, record: &Record) -> Result<Diagnosis, Complaint> {
        Ok(diagnose(self, record, &DiagnosisOptions::default())?.diagnosis)
    }
}

/// The rig with the effects of a trial as they were fitted and still uncertain, its sensors as the rig file has them.
fn installed(rig: &Rig, trial: &FittedModel) -> Rig {
    let mut with_effect = trial.rig.clone();
    for (sensor, stated) in with_effect.sensors.iter_mut().zip(&rig.sensors) {
        (sensor.noise, sensor.tolerance, sensor.lack_of_fit) = (stated.noise, stated.tolerance, stated.lack_of_fit);
    }
    for (index, parameter) in with_effect.parameters.iter_mut().enumerate() {
        if trial.rig.is_of_effect(index) && !rig.is_of_effect(index) {
            parameter.value = trial.values[index];
        }
    }
    with_effect
}

/// The diagnosis beside an effect, as one of a rig file that lacks it.
fn joined(given: Diagnosed, mut beside: Diagnosed, best: &EvaluatedModel, rig: Rig) -> Diagnosed {
    // With the faults isolated again, one of several effects may explain nothing any more; its rivals then do not either.
    let all = best.effects.iter().map(|effect| effect.id.clone());
    let (mut at_work, mut idle): (Vec<String>, Vec<String>) =
        all.partition(|id| is_at_work(&rig, &beside.diagnosis, id));
    // Together they do what brought them here.
    if at_work.is_empty() {
        std::mem::swap(&mut at_work, &mut idle);
    }
    let is_of = |ids: &[String], parameter: &str| {
        let index = rig.parameter(parameter);
        let of = |index: usize| rig.effects.iter().any(|one| ids.contains(&one.id) && one.parameters.contains(&index));
        index.is_some_and(of)
    };
    let (parameters, uncertain) = std::mem::take(&mut beside.diagnosis.uncertain)
        .into_iter()
        .filter(|one| !is_of(&idle, &one.id))
        .partition(|one| is_of(&at_work, &one.id));
    let explained = beside.diagnosis.is_explained();
    beside.diagnosis = Diagnosis {
        verdict: Verdict::ModelInadequate,
        common_cause: given.diagnosis.common_cause,
        detected_at_s: given.diagnosis.detected_at_s,
        residuals: given.diagnosis.residuals,
        missing_effect: Some(MissingEffect {
            confounded_with: if idle.is_empty() { best.confounded_with.clone() } else { Vec::new() },
            effects: at_work,
            parameters,
            explained,
            times_noise_without: given.diagnosis.times_noise,
        }),
        uncertain,
        ..beside.diagnosis
    };
    (beside.healthy, beside.corrected) = (given.healthy, given.corrected);
    beside.other_rig.get_or_insert(rig);
    beside
}
