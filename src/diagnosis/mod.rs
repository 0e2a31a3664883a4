//! Detection, isolation and identification: what is wrong, how large, how sure.
//!
//! [`diagnose`] walks the whole way: residuals that fire ([`crate::residual`]), all faults and everything uncertain fitted
//! together ([`estimate`]), every set of faults with its probability ([`hypotheses`]), and an interval for each fault that may
//! be open ([`interval`]).

mod alike;
pub(crate) mod candidates;
pub mod case;
mod cause;
mod common_cause;
mod data_sheet;
pub(crate) mod doubtful;
pub mod estimate;
pub(crate) mod events;
pub mod expected;
mod explained;
mod fitted;
pub mod hypotheses;
mod instead;
pub mod interval;
mod missed;
pub(crate) mod misstated;
pub mod noise;
pub mod onset;
pub(crate) mod preliminary;
pub mod problem;
mod reported;
mod result;
pub(crate) mod search;
mod spared;
pub mod starts;
pub(crate) mod summary;
pub(crate) mod switching;
pub(crate) mod undeclared;
mod unseen;
pub mod watch;
pub(crate) mod weighed;
mod weighing;

use crate::complaint::{Complaint, Kind, Place};
use crate::estimation::Interval;
use crate::model::{InputSignals, Model, Shown};
use crate::record::Record;
use crate::residual::{self, Detection};
use crate::rig::{FaultSet, Rig, Target};
pub(crate) use case::FAR_OFF;
use data_sheet::Sparing;
use estimate::Estimate;
use explained::{Asked, Explained, Instead, best_explained};
pub use hypotheses::Hypothesis;
pub(crate) use missed::{adequate, is_there, missed, tame_squares};
use reported::{Seen, reported};
pub(crate) use result::{CLEARLY_ABOVE_NOISE, OTHER_OIL};
pub use result::{
    ChannelReport, CommonCause, Diagnosis, DynamicsReport, FaultReport, FitReport, FittedReport, MissingEffect,
    OffDataSheet, OffSheetValue, ProfileReport, RivalEffect, SCHEMA, UncertainReport, Verdict,
};
pub(crate) use spared::Physics;
use spared::Spared;

/// What the user may choose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DiagnosisOptions {
    /// When residuals count as fired.
    pub detection: Detection,
}

/// A diagnosis with the curves behind it.
#[derive(Debug, Clone)]
pub struct Diagnosed {
    /// The result.
    pub diagnosis: Diagnosis,
    /// What the fitted model reads: `[sensor][row]`, SI.
    pub model: Vec<Vec<f64>>,
    /// What the healthy model reads; empty where it cannot be solved.
    pub healthy: Vec<Vec<f64>>,
    /// Weighted misfits of the fit: `[sensor][row]`, 1 is one standard deviation.
    pub misfit: Vec<Vec<f64>>,
    /// What the misfits are weighted with.
    pub(crate) weights: noise::Weights,
    /// What the record leaves of each fault, in the order of the rig; `None` where the model cannot be solved.
    pub(crate) intervals: Vec<Option<Interval>>,
    /// The record without the mistake that [`Diagnosis::common_cause`] names.
    pub corrected: Option<Record>,
    /// The rig with what [`Diagnosis::missing_effect`] and [`Diagnosis::dynamics`] name.
    pub other_rig: Option<Rig>,
    /// Logarithm of the evidence of the fault combination, up to what is the same for all of the record.
    evidence: f64,
    /// Logarithm of the share of what was open before that the record leaves of all that is uncertain.
    occam: f64,
}

impl Diagnosed {
    /// The record that was diagnosed, where `original` was given: without the mistake in taking it that was found.
    pub fn record<'a>(&'a self, original: &'a Record) -> &'a Record {
        self.corrected.as_ref().unwrap_or(original)
    }

    /// The rig that explains the record with the faults found, where `given` was given: with the effect that it lacked, and with
    /// spools that follow as the record shows it.
    pub fn rig<'a>(&'a self, given: &'a Rig) -> &'a Rig {
        self.other_rig.as_ref().unwrap_or(given)
    }
}

/// Digits of a reported number: more than any interval allows, fewer than rounding spoils.
const DIGITS: usize = 7;
/// Diagnoses one record of a rig as its file describes it; see [`crate::diagnose`] for one that may lack an effect.
///
/// # Errors
/// Columns that are missing, a model that cannot be solved, or a [context](crate::Context) that was cancelled.
pub fn diagnose(model: &Model, record: &Record, options: &DiagnosisOptions) -> Result<Diagnosed, Complaint> {
    model.rig.context().run(|| diagnose_here(model, record, options, None))
}

/// [`diagnose`] where physics that the model lacks may be behind a record. Where it is, what was found is what declared faults leave of the
/// record, and neither a value that nobody declared, nor a beginning, nor parts that deviate were looked for.
///
/// # Errors
/// As [`diagnose`].
pub(crate) fn diagnose_unless(
    model: &Model,
    record: &Record,
    options: &DiagnosisOptions,
    physics: &dyn Physics,
) -> Result<Diagnosed, Complaint> {
    model.rig.context().run(|| diagnose_here(model, record, options, Some(physics)))
}

/// The same on the threads of the caller.
fn diagnose_here(
    model: &Model,
    record: &Record,
    options: &DiagnosisOptions,
    physics: Option<&dyn Physics>,
) -> Result<Diagnosed, Complaint> {
    let mut found = believed(model, record, options, physics)?;
    if !found.diagnosis.is_explained() {
        found.diagnosis.at_odds = model.rig.at_odds(record);
    }
    Ok(found)
}

/// The explanation that is believed among those with every value as stated, with others that nobody declared, and by data sheet.
fn believed(
    model: &Model,
    record: &Record,
    options: &DiagnosisOptions,
    physics: Option<&dyn Physics>,
) -> Result<Diagnosed, Complaint> {
    let sparing = Sparing::of(model, record);
    let found = believed_among(model, record, options, Spared { sparing: Some(&sparing), physics })?;
    // What was spared for the sake of parts that deviate is owed where they are not the answer.
    if sparing.has_spared() && found.diagnosis.off_data_sheet.is_none() {
        return believed_among(model, record, options, Spared { sparing: None, physics });
    }
    Ok(found)
}

/// The same, questions spared where they may be.
fn believed_among(
    model: &Model,
    record: &Record,
    options: &DiagnosisOptions,
    spared: Spared<'_>,
) -> Result<Diagnosed, Complaint> {
    let stated = diagnose_as_stated(model, record, options, spared)?;
    if spared.by_physics(&stated) {
        return Ok(stated);
    }
    // No value brings a body to where it starts.
    if !stated.diagnosis.is_explained() && model.rig.begins_within_a_run(record) {
        return Ok(stated);
    }
    if !stated.diagnosis.undeclared.is_empty() {
        return Ok(stated);
    }
    if let Some(found) = undeclared::preferred(model, record, &stated, options)? {
        return Ok(found);
    }
    or_by_data_sheet(model, record, stated, options)
}

/// What was found with every value as stated, or with parts that deviate as their data sheets allow, whichever explains the record better.
fn or_by_data_sheet(
    model: &Model,
    record: &Record,
    stated: Diagnosed,
    options: &DiagnosisOptions,
) -> Result<Diagnosed, Complaint> {
    let Some(mut freed) = data_sheet::doubted(model, record, &stated) else { return Ok(stated) };
    let is_better = |estimate: &Estimate<'_>| stated.is_outdone_by(estimate, &model.rig, record, 0.0);
    loop {
        let deviating = Model::new(freed).with_tolerance(model.tolerance);
        let is_as_old = stated.diagnosis.onset_s.is_none();
        let attempt = Attempt { is_wanted: Some(&is_better), is_as_old, ..Attempt::default() };
        let found = diagnose_again(&deviating, record, (&[], None), options, attempt)?;
        freed = deviating.rig;
        let Some(found) = found.filter(|found| found.diagnosis.is_explained()) else { return Ok(stated) };
        let changed = data_sheet::changed(&model.rig, &freed, &found);
        if changed.is_empty() {
            return Ok(data_sheet::preferred(&model.rig, record, &stated, (freed, found)).unwrap_or(stated));
        }
        // They are faults or nothing.
        let stated = &model.rig.parameters;
        changed.into_iter().for_each(|parameter| freed.parameters[parameter].sigma = stated[parameter].sigma);
    }
}

/// The same with every value as the rig file has it.
fn diagnose_as_stated(
    model: &Model,
    record: &Record,
    options: &DiagnosisOptions,
    spared: Spared<'_>,
) -> Result<Diagnosed, Complaint> {
    let first = Attempt { asks_otherwise: true, spared, ..Attempt::default() };
    let plain = diagnose_again(model, record, (&[], None), options, first)?.ok_or_else(|| no_explanation(record))?;
    if plain.diagnosis.common_cause.is_some() {
        return Ok(plain);
    }
    let faults = |one: &Diagnosed| one.diagnosis.present().count();
    // Nobody needs a mistake in taking a record of which parts that deviate leave less than faults do.
    let left = if plain.diagnosis.is_explained() { plain.diagnosis.times_noise } else { f64::INFINITY };
    let is_asked = common_cause::is_asked(model, &plain) && !spared.sparing.is_some_and(|sparing| sparing.spares(left));
    let corrected = if is_asked { common_cause::instead(model, record, &plain) } else { None };
    let Some(corrected) = corrected else { return Ok(plain) };
    let diagnosed = diagnose_from(&corrected.model, &corrected.record, (&[], None), options)?;
    // A cause that leaves the record unexplained explains nothing, and one that takes more faults than the record as it stands is no
    // simpler story.
    if !diagnosed.diagnosis.is_explained() || faults(&diagnosed) > faults(&plain).max(1) {
        return Ok(plain);
    }
    Ok(diagnosed.of(corrected))
}

/// The same for a record that begins in the middle of a run, with what sensors show of their nodes there.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_from(
    model: &Model,
    record: &Record,
    start: (&[Shown], Option<f64>),
    options: &DiagnosisOptions,
) -> Result<Diagnosed, Complaint> {
    diagnose_again(model, record, start, options, Attempt::default())?.ok_or_else(|| no_explanation(record))
}

/// Diagnoses a record that another explanation has come near to: values of the rig's parameters, SI, and the faults present. What was
/// asked of that one, mistakes in taking the record and faults that nobody declared, is not asked again.
///
/// # Errors
/// As [`diagnose`].
pub(crate) fn diagnose_near(
    model: &Model,
    record: &Record,
    near: (&[f64], FaultSet),
    options: &DiagnosisOptions,
) -> Result<Diagnosed, Complaint> {
    let attempt = Attempt { near: Some(near), ..Attempt::default() };
    let found = diagnose_again(model, record, (&[], None), options, attempt)?;
    or_by_data_sheet(model, record, found.ok_or_else(|| no_explanation(record))?, options)
}

fn no_explanation(record: &Record) -> Complaint {
    Complaint::new(Kind::Computation, "no explanation was kept").at(Place::file(&record.path))
}

/// A diagnosis among others of the same record.
#[derive(Clone, Copy, Default)]
struct Attempt<'a> {
    /// How often spools have been found to follow otherwise.
    found: usize,
    /// What has to hold of it; given up, before intervals are drawn, where that does not.
    is_wanted: Option<&'a dyn Fn(&Estimate<'_>) -> bool>,
    /// Values of the rig's parameters, SI, and faults that are near already.
    near: Option<(&'a [f64], FaultSet)>,
    /// Whether one mistake in taking the record, or one value that the file takes as exact, may be it where its faults miss the record.
    asks_otherwise: bool,
    /// What may spare further questions.
    spared: Spared<'a>,
    /// How many of the first faults are reported even where they are absent, if not all.
    reported: Option<usize>,
    /// Whether no beginning within the record was found with other values open: asked for again only where these do not explain it.
    is_as_old: bool,
}

/// The same as one of several attempts; `None` where that is given up.
fn diagnose_again(
    model: &Model,
    record: &Record,
    (shown, begun): (&[Shown], Option<f64>),
    options: &DiagnosisOptions,
    attempt: Attempt<'_>,
) -> Result<Option<Diagnosed>, Complaint> {
    let start = (shown, begun);
    if let Some(commanded) = model.rig.as_commanded([record]) {
        let commanded = Model::new(commanded).with_tolerance(model.tolerance);
        let again = diagnose_again(&commanded, record, start, options, attempt)?;
        return Ok(again.map(|mut again| {
            again.other_rig.get_or_insert(commanded.rig);
            again
        }));
    }
    let rig = &model.rig;
    if rig.sensors.is_empty() {
        return Err(Complaint::new(Kind::MissingEntry, "the rig has no sensors, so a record shows nothing of it")
            .at(Place::file(&rig.path))
            .help("add `[sensors]`, one line per measured column"));
    }
    let (cleared, left_out) = doubtful::set_aside(rig, record);
    let record = cleared.as_ref().unwrap_or(record);
    let drive = InputSignals::from_record(rig, record)?;
    let of_state = |one: &&Shown| matches!(rig.sensors[one.sensor].target, Target::State(..));
    let shown = match shown {
        [] => drive.shown.clone(),
        shown => shown.iter().chain(drive.shown.iter().filter(of_state)).copied().collect(),
    };
    let drive = InputSignals { shown, begun: begun.unwrap_or(drive.begun), ..drive };
    weighed::measured(rig, record)?;
    rig.context().stage("residuals and fit");
    let residuals = residual::detect(rig, record, &drive, &options.detection)?;
    // The way is gone roughly; where it ends is walked over once more, exactly.
    let (roughly, before) = (search::roughly(model), Model::new(rig.with_before()).with_tolerance(model.tolerance));
    let before_roughly = search::roughly(&before);
    let near = attempt.near.map(|(values, set)| (picked_of(rig, values), set));
    let guess = near.as_ref().map(|(theta, set)| (&theta[..], *set));
    let first = estimate::from_start(&roughly, record, &drive, guess)?;
    // Before a calibration parts that deviate as parts do and physics that is missing are not told apart; where record and rig file differ
    // neither is asked for.
    let physics = attempt.spared.physics.filter(|_| rig.exact_by_sheet().is_empty() && rig.at_odds(record).is_empty());
    let otherwise = |first: &Estimate<'_>, places: Option<&[search::Place]>, physics: Option<&dyn Physics>| {
        if places.is_some() {
            rig.context().first_look(|| summary::first_look(first));
        }
        if let Some(found) = common_cause::at_once(model, first.case.record, options)? {
            return Ok(Instead::Found(Box::new(found)));
        }
        let is_spared = || attempt.spared.sparing.is_some_and(|sparing| sparing.spares(f64::INFINITY));
        let Some(places) = places.filter(|_| !is_spared()) else { return Ok(Instead::Nothing) };
        if physics.map_or(Ok(false), |physics| physics.explains(first))? {
            return Ok(Instead::Physics);
        }
        let found = misstated::instead(model, (first, places), options)?;
        Ok(found.map_or(Instead::Nothing, |found| Instead::Found(Box::new(found))))
    };
    let asked =
        Asked { from_everywhere: guess.is_none(), otherwise: attempt.asks_otherwise, begun: !attempt.is_as_old };
    let (first, begun) = match best_explained(first, &before_roughly, (asked, physics), otherwise)? {
        Explained::Declared(declared) => *declared,
        Explained::Otherwise(found) => return Ok(Some(*found)),
    };
    let (exact, estimate) = match &begun {
        Some(begun) => {
            let guess = Some((&begun.theta[..], begun.set));
            (&before, estimate::from_start(&before_roughly, record, &begun.drive, guess)?)
        }
        None => (model, first),
    };
    rig.context().first_look(|| summary::first_look(&estimate));
    let with_other_spools = |estimate: &Estimate<'_>| -> Result<Option<Diagnosed>, Complaint> {
        let doubtful = attempt.found < rig.settings().diagnosis.dynamics_renewals
            && !(estimate.explains() && estimate.isolation.set().is_empty());
        let Some(dynamics) = doubtful.then(|| switching::found(estimate)).flatten() else { return Ok(None) };
        let other = Model::new(switching::applied(rig, &dynamics)).with_tolerance(model.tolerance);
        let explains = |estimate: &Estimate<'_>| estimate.explains();
        let next = Attempt {
            found: attempt.found + 1,
            is_wanted: Some(&explains),
            reported: attempt.reported,
            ..Attempt::default()
        };
        let again = diagnose_again(&other, record, start, options, next)?;
        Ok(again.map(|mut again| {
            let found = again.other_rig.get_or_insert(other.rig);
            again.diagnosis.dynamics = switching::report(rig, found, switching::Open::All);
            again
        }))
    };
    if let Some(again) = with_other_spools(&estimate)? {
        return Ok(Some(again));
    }
    // What misses by more than noise is not wanted, however exactly it is solved.
    if attempt.is_wanted.is_some() && estimate.missed() {
        return Ok(None);
    }
    let estimate = estimate.with_model(exact)?;
    let without_faults = estimate.isolation.set().is_empty();
    if attempt.is_wanted.is_some_and(|is_wanted| !is_wanted(&estimate)) {
        return Ok(None);
    }
    let (estimate, intervals) = interval::settled(estimate, attempt.reported.unwrap_or(rig.faults.len()));
    // A profile may have led to faults where there were none.
    if without_faults && let Some(again) = with_other_spools(&estimate)? {
        return Ok(Some(again));
    }
    let seen =
        Seen { residuals, left_out, onset: begun.as_ref().map(|begun| begun.time), detection: &options.detection };
    Ok(Some(reported(model, &estimate, intervals, seen)))
}

/// What is estimated, of values of a rig's parameters; what a command opens for its own record comes last and may be left out.
fn picked_of(rig: &Rig, values: &[f64]) -> Vec<f64> {
    let mut all = rig.healthy();
    all.iter_mut().zip(values).for_each(|(slot, value)| *slot = *value);
    estimate::picked(rig, &all)
}
