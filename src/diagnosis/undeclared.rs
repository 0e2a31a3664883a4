//! A calibrated value that has changed although the rig file declares no fault of it.
//!
//! Nobody foresees every fault. A part that wears without being declared moves its own value against what calibration has found, as far
//! as the search goes, or declared faults in its place. So where an explanation has calibrated values far from where they were, the
//! record is diagnosed once more with faults of those values too, and the two compete by their evidence. All values that are not declared
//! share the odds of one declared fault.

use super::estimate::Estimate;
use super::result::FaultReport;
use super::{Attempt, Diagnosed, DiagnosisOptions, diagnose_again};
use crate::complaint::Complaint;
use crate::estimation::profile::QUANTILE;
use crate::model::Model;
use crate::record::Record;
use crate::rig::{Fault, FaultSet, Rig};

/// What was found with faults of such values as the diagnosis of the record; `None` where none is as far off, or what was found with the
/// declared ones is the better explanation.
///
/// # Errors
/// As [`super::diagnose`].
pub(super) fn preferred(
    model: &Model,
    record: &Record,
    declared: &Diagnosed,
    options: &DiagnosisOptions,
) -> Result<Option<Diagnosed>, Complaint> {
    let (given, seen) = (declared.rig(&model.rig), declared.record(record));
    let candidates: Vec<usize> = candidates(given).collect();
    let moved = moved(given, &candidates, declared);
    if moved.is_empty() || declared.diagnosis.is_misread() {
        return Ok(None);
    }
    let mut rig = given.clone();
    let room = FaultSet::CAPACITY - rig.faults.len();
    rig.faults.extend(moved.into_iter().take(room).map(|parameter| fault(given, parameter)));
    // What has moved is where it explains most already.
    let values = declared.diagnosis.found(given);
    let set = (0..rig.faults.len()).filter(|&fault| is_off(&rig, &values, fault)).collect();
    let wider = Model::new(rig).with_tolerance(model.tolerance);
    let odds = |undeclared: usize| -(undeclared as f64) * (candidates.len() as f64).ln();
    let is_better = |estimate: &Estimate<'_>| {
        let undeclared = estimate.isolation.set().iter().filter(|fault| *fault >= given.faults.len()).count();
        undeclared > 0 && declared.is_outdone_by(estimate, given, seen, odds(undeclared))
    };
    let attempt = Attempt { is_wanted: Some(&is_better), near: Some((&values, set)), ..Attempt::default() };
    let Some(found) = diagnose_again(&wider, seen, (&[], None), options, attempt)? else { return Ok(None) };
    let Some(names) = undeclared(&wider.rig, given.faults.len(), &found) else { return Ok(None) };
    let is_preferred = !names.is_empty() && found.explains_better_than(declared, given, seen, odds(names.len()));
    Ok(is_preferred.then(|| told(declared, (wider.rig, found), names)))
}

/// Whether an explanation has the value of a fault elsewhere than in a healthy rig.
fn is_off(rig: &Rig, values: &[f64], fault: usize) -> bool {
    let Fault { parameter, healthy, .. } = rig.faults[fault];
    values[parameter] != healthy
}

/// Parameters whose values a calibration has found, of parts and sensors, that are no faults and may be one.
fn candidates(rig: &Rig) -> impl Iterator<Item = usize> + '_ {
    let calibrated = rig.calibration.iter().flat_map(|known| known.parameters.iter().copied());
    calibrated.filter(|&parameter| {
        let of_a_part = rig.parts().any(|(_, part)| part.owns(parameter)) && !rig.is_of_effect(parameter);
        let may_be = !rig.is_fault(parameter) && !rig.parameters[parameter].role.is_of_the_drive();
        (of_a_part || rig.is_of_sensor(parameter)) && may_be
    })
}

/// Those of them that an explanation has far off.
fn moved(rig: &Rig, candidates: &[usize], declared: &Diagnosed) -> Vec<usize> {
    let least = rig.settings().diagnosis.changed_deviations;
    let is_far = |parameter: &usize| {
        let fitted = declared.diagnosis.uncertain.iter().find(|one| one.id == rig.parameters[*parameter].id);
        fitted.is_some_and(|one| (one.value - one.nominal).abs() > least * one.sigma_before)
    };
    candidates.iter().copied().filter(is_far).collect()
}

/// A fault of a parameter of which nobody has said how far it may go: to a tenth of its value and to ten times as much, as far as the
/// physics allows; of one that is nothing, as far as uncertain values are searched.
fn fault(rig: &Rig, index: usize) -> Fault {
    let (parameter, settings) = (&rig.parameters[index], &rig.settings().diagnosis);
    let value = parameter.value;
    let (low, high) = match value.abs() {
        0.0 => (-settings.search_reach * parameter.sigma, settings.search_reach * parameter.sigma),
        size => {
            let ends = (value * settings.least_share, value / settings.least_share);
            if size == value { ends } else { (ends.1, ends.0) }
        }
    };
    let bounds = (low.max(parameter.bounds.0), high.min(parameter.bounds.1));
    Fault { parameter: index, healthy: value, bounds, limit: None, place: parameter.place.clone() }
}

/// Ids of the faults behind the `declared` ones that are present; `None` where one has changed by no more than new parts differ (95 %):
/// that is no wear, but a law that is not quite the part's and has calibrated values move with the point of work. The end of a search is
/// the value of no part either.
fn undeclared(rig: &Rig, declared: usize, found: &Diagnosed) -> Option<Vec<String>> {
    let behind = rig.faults.iter().zip(&found.diagnosis.faults).skip(declared);
    let one = |(fault, report): (&Fault, &FaultReport)| {
        let parameter = &rig.parameters[fault.parameter];
        let (value, (low, high)) = (parameter.unit.to_si(report.value), fault.bounds);
        // As far as the digits of a report go.
        let is_inside = (value - low).min(high - value) > 1e-6 * (high - low);
        let has_changed = (value - fault.healthy).abs() > QUANTILE * parameter.spread;
        (has_changed && is_inside).then(|| report.id.clone())
    };
    behind.filter(|(_, report)| report.present).map(one).collect()
}

/// The diagnosis with the undeclared faults of these names; others that were asked about are as if they had not been.
fn told(declared: &Diagnosed, (wider, mut found): (Rig, Diagnosed), names: Vec<String>) -> Diagnosed {
    let known = declared.diagnosis.faults.len();
    let keep: Vec<bool> =
        found.diagnosis.faults.iter().enumerate().map(|(at, fault)| at < known || names.contains(&fault.id)).collect();
    let mut rig = found.other_rig.take().unwrap_or(wider);
    let [mut of_rig, mut of_report, mut of_intervals] = [(); 3].map(|()| keep.iter().copied());
    rig.faults.retain(|_| of_rig.next().unwrap_or(true));
    found.diagnosis.faults.retain(|_| of_report.next().unwrap_or(true));
    found.intervals.retain(|_| of_intervals.next().unwrap_or(true));
    found.other_rig = Some(rig);
    found.corrected.clone_from(&declared.corrected);
    found.diagnosis.common_cause.clone_from(&declared.diagnosis.common_cause);
    found.diagnosis.dynamics.splice(0..0, declared.diagnosis.dynamics.iter().cloned());
    found.diagnosis.undeclared = names;
    found
}
