//! A calibrated value that has changed although the rig file declares no fault of it.
//!
//! Nobody foresees every fault. A part that wears without being declared moves its own value against what calibration has found, as far
//! as the search goes, or declared faults in its place. So where the record pulls calibrated values far from where they were, it is
//! diagnosed once more with faults of those values too, and the two compete by their evidence. All values that are not declared share
//! the odds of one declared fault.

use std::cell::RefCell;

use super::estimate::Estimate;
use super::result::{FaultReport, UncertainReport};
use super::{Attempt, Diagnosed, DiagnosisOptions, diagnose_again};
use crate::complaint::Complaint;
use crate::estimation::profile::QUANTILE;
use crate::model::Model;
use crate::record::Record;
use crate::rig::{Fault, FaultSet, Rig};

/// Share of what was uncertain of a value that a record has to determine to pull it.
const KNOWN: f64 = 1e-4;

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
    let candidates: Vec<usize> = calibrated(given).collect();
    let moved = moved(given, &candidates, declared);
    if moved.is_empty() || declared.diagnosis.is_misread() {
        return Ok(None);
    }
    let mut rig = given.clone();
    let room = FaultSet::CAPACITY - rig.faults.len();
    rig.faults.extend(moved.into_iter().take(room).map(|parameter| fault(given, parameter)));
    // What has moved is where it explains most already.
    let values = declared.diagnosis.found(given);
    let odds = |undeclared: usize| -(undeclared as f64) * (candidates.len() as f64).ln();
    let (known, takes_several) = (given.faults.len(), declared.diagnosis.present().count() > 1);
    while rig.faults.len() > known {
        let set = (0..rig.faults.len()).filter(|&fault| is_off(&rig, &values, fault)).collect();
        let wider = Model::new(rig).with_tolerance(model.tolerance);
        let as_new = RefCell::new(FaultSet::EMPTY);
        let is_better = |estimate: &Estimate<'_>| {
            let undeclared: FaultSet = estimate.isolation.set().iter().filter(|fault| *fault >= known).collect();
            let theta = &estimate.isolation.best.theta;
            let has_changed = |&fault: &usize| has_changed(&wider.rig, fault, theta[fault]);
            let new: FaultSet = undeclared.iter().filter(|fault| !has_changed(fault)).collect();
            // One value that explains by itself what takes several declared faults is believed, however little it has changed.
            let is_alone = takes_several && estimate.isolation.set().len() == 1;
            let is_one = !undeclared.is_empty() && (new.is_empty() || is_alone);
            as_new.replace(if estimate.explains() { new } else { FaultSet::EMPTY });
            is_one && declared.is_outdone_by(estimate, given, seen, odds(undeclared.len()))
        };
        let near = Some((&values[..], set));
        let is_as_old = declared.diagnosis.onset_s.is_none();
        let attempt =
            Attempt { is_wanted: Some(&is_better), near, reported: Some(known), is_as_old, ..Attempt::default() };
        let found = diagnose_again(&wider, seen, (&[], None), options, attempt)?;
        let Some(found) = found else {
            // Asked once more without those that differ as new parts do: they are no faults, and stood beside one or in its place.
            let as_new = as_new.into_inner();
            if as_new.is_empty() {
                return Ok(None);
            }
            rig = wider.rig;
            let mut fault = 0..;
            rig.faults.retain(|_| fault.next().is_none_or(|fault| !as_new.contains(fault)));
            continue;
        };
        let is_alone = takes_several && found.diagnosis.present().count() == 1;
        let Some(names) = undeclared(&wider.rig, known, &found, is_alone) else { return Ok(None) };
        let is_preferred = !names.is_empty() && found.explains_better_than(declared, given, seen, odds(names.len()));
        return Ok(is_preferred.then(|| {
            let mut found = told(known, (wider.rig, found), names);
            found.corrected.clone_from(&declared.corrected);
            found.diagnosis.common_cause.clone_from(&declared.diagnosis.common_cause);
            found.diagnosis.dynamics.splice(0..0, declared.diagnosis.dynamics.iter().cloned());
            found
        }));
    }
    Ok(None)
}

/// Whether an explanation has the value of a fault elsewhere than in a healthy rig.
fn is_off(rig: &Rig, values: &[f64], fault: usize) -> bool {
    let Fault { parameter, healthy, .. } = rig.faults[fault];
    values[parameter] != healthy
}

/// Parameters whose values a calibration has found, of parts and sensors, that are no faults and may be one.
pub(super) fn calibrated(rig: &Rig) -> impl Iterator<Item = usize> + '_ {
    let calibrated = rig.calibration.iter().flat_map(|known| known.parameters.iter().copied());
    calibrated.filter(|&parameter| may_be_a_fault(rig, parameter))
}

/// Whether a value is of a part or a sensor, is no fault, and may be one.
pub(super) fn may_be_a_fault(rig: &Rig, parameter: usize) -> bool {
    let of_a_part = rig.parts().any(|(_, part)| part.owns(parameter)) && !rig.is_of_effect(parameter);
    let may_be = !rig.is_fault(parameter) && rig.parameters[parameter].role.may_wear();
    (of_a_part || rig.is_of_sensor(parameter)) && may_be
}

/// Those of them that the record pulls far from where calibration has them.
fn moved(rig: &Rig, candidates: &[usize], declared: &Diagnosed) -> Vec<usize> {
    let least = rig.settings().diagnosis.changed_deviations;
    let is_far = |parameter: &usize| {
        let fitted = declared.diagnosis.uncertain.iter().find(|one| one.id == rig.parameters[*parameter].id);
        fitted.is_some_and(|fitted| pull(fitted) > least)
    };
    candidates.iter().copied().filter(is_far).collect()
}

/// How far a record pulls a value from where it was expected, in standard deviations.
///
/// A value `v` that was expected at `m` with deviation `s0` and is known with `s1` afterwards has moved by `v - m`, which for a right model
/// scatters with `sqrt(s0² - s1²)`; the square of the quotient is what the cost falls by where the value is set free. So a value that the record
/// hardly determines may be pulled hard although it moves little.
fn pull(fitted: &UncertainReport) -> f64 {
    let known = fitted.sigma_before.powi(2) - fitted.sigma_after.unwrap_or(0.0).powi(2);
    // Below that it is the digits of the report, and of the fit, that have moved.
    if known > KNOWN * fitted.sigma_before.powi(2) { (fitted.value - fitted.nominal).abs() / known.sqrt() } else { 0.0 }
}

/// A fault of a parameter of which nobody has said how far it may go: to a tenth of its value and to ten times as much, as far as the
/// physics allows; of one that is nothing, as far as uncertain values are searched.
pub(crate) fn fault(rig: &Rig, index: usize) -> Fault {
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

/// Whether a fault at a value, SI, is further from healthy than new parts differ (95 %): one that is not is no wear, but a law that is not
/// quite the part's and has calibrated values move with the point of work.
pub(super) fn has_changed(rig: &Rig, fault: usize, value: f64) -> bool {
    let Fault { parameter, healthy, .. } = rig.faults[fault];
    (value - healthy).abs() > QUANTILE * rig.parameters[parameter].spread
}

/// Ids of the faults behind the `declared` ones that are present; `None` where one has not changed, unless it may be as new parts are. The
/// end of a search is the value of no part either.
pub(super) fn undeclared(rig: &Rig, declared: usize, found: &Diagnosed, may_be_as_new: bool) -> Option<Vec<String>> {
    let behind = found.diagnosis.faults.iter().enumerate().skip(declared);
    let one = |(fault, report): (usize, &FaultReport)| {
        let (parameter, (low, high)) = (rig.faults[fault].parameter, rig.faults[fault].bounds);
        let value = rig.parameters[parameter].unit.to_si(report.value);
        // As far as the digits of a report go.
        let is_inside = (value - low).min(high - value) > 1e-6 * (high - low);
        ((may_be_as_new || has_changed(rig, fault, value)) && is_inside).then(|| report.id.clone())
    };
    behind.filter(|(_, report)| report.present).map(one).collect()
}

/// The diagnosis with the undeclared faults of these names behind the `known` ones; others that were asked about are as if they had not
/// been.
pub(super) fn told(known: usize, (wider, mut found): (Rig, Diagnosed), names: Vec<String>) -> Diagnosed {
    let keep: Vec<bool> =
        found.diagnosis.faults.iter().enumerate().map(|(at, fault)| at < known || names.contains(&fault.id)).collect();
    let mut rig = found.other_rig.take().unwrap_or(wider);
    let [mut of_rig, mut of_report, mut of_intervals] = [(); 3].map(|()| keep.iter().copied());
    rig.faults.retain(|_| of_rig.next().unwrap_or(true));
    found.diagnosis.faults.retain(|_| of_report.next().unwrap_or(true));
    found.intervals.retain(|_| of_intervals.next().unwrap_or(true));
    found.other_rig = Some(rig);
    found.diagnosis.undeclared = names;
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_pulls_by_more_than_a_value_moves() {
        // Expected at 10 with deviation 1; a record that says 16 with deviation 2 leaves (10 / 1 + 16 / 4) / (1 + 1 / 4) = 11.2 with
        // deviation sqrt(0.8). The cost falls by 6² / (1 + 4) where the value is free.
        let report = |value: f64, sigma_after: Option<f64>| UncertainReport {
            id: "cylinder.mass".to_owned(),
            value,
            unit: "kg".to_owned(),
            nominal: 10.0,
            sigma_before: 1.0,
            sigma_after,
        };
        approx::assert_relative_eq!(
            pull(&report(11.2, Some(0.8_f64.sqrt()))).powi(2),
            36.0 / 5.0,
            max_relative = 1e-12
        );
        // Nothing is learnt of a value that stays; one at the end of its search is as far as anybody looked.
        assert_eq!((pull(&report(10.0, Some(1.0))), pull(&report(16.0, None))), (0.0, 6.0));
    }
}
