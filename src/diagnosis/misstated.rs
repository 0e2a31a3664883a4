//! One value of the rig file that is another, declared as a fault or not.
//!
//! A load that nobody weighed, a spring of another batch, a part that nobody thought would wear: no declared fault explains such a
//! record, uncertain values cannot follow it, and a search for several faults, for a beginning, or for physics takes minutes to end in
//! nonsense. So a record that the faults of the rig miss, and no effect explains outright, is first diagnosed once more with a fault of
//! every value that is exact or that a calibration has found. One of them alone is believed, with no more declared faults beside it than a
//! record has: it is looked for from the healthy rig, and from the place that declared faults explain best, since what a gap leaks is not
//! seen from where it is shut.

use super::estimate::{self, Estimate};
use super::search::{self, Place};
use super::undeclared::{calibrated, fault, has_changed, may_be_a_fault, told, undeclared};
use super::{Attempt, Diagnosed, DiagnosisOptions, diagnose_again};
use crate::complaint::Complaint;
use crate::model::Model;
use crate::rig::{FaultSet, Rig};

/// What was found with a fault of one such value as the diagnosis of a record that the declared ones, in a `first` explanation, miss, and of
/// which `places` leave something too, the best first; `None` where that does not explain it.
///
/// # Errors
/// As [`super::diagnose`].
pub(super) fn instead(
    model: &Model,
    (first, places): (&Estimate<'_>, &[Place]),
    options: &DiagnosisOptions,
) -> Result<Option<Diagnosed>, Complaint> {
    let declared = model.rig.faults.len();
    let mut rig = model.rig.clone();
    let values = may_be_misstated(&model.rig);
    rig.faults.extend(values.take(FaultSet::CAPACITY - declared).map(|value| fault(&model.rig, value)));
    if rig.faults.len() == declared {
        return Ok(None);
    }
    let wider = Model::new(rig).with_tolerance(model.tolerance);
    let settings = &wider.rig.settings().diagnosis;
    // Told roughly: physics that is missing is no value of the file, and need not be missed exactly.
    let (roughly, healthy) = (search::roughly(&wider), wider.rig.healthy());
    let (record, drive) = (first.case.record, first.case.full.drive);
    let from = |values: &[f64], set: FaultSet| {
        let start = estimate::picked(&wider.rig, values);
        let found = estimate::near(&roughly, record, drive, Some((&start, set)), settings.isolation_rounds).ok()?;
        let one = the_one(&found, declared).filter(|_| !found.missed())?;
        Some((found, one))
    };
    let from_place = || {
        let place = places.first()?;
        let mut values = healthy.clone();
        place.faults.iter().for_each(|&(fault, value)| values[wider.rig.faults[fault].parameter] = value);
        from(&values, place.set())
    };
    let Some((found, one)) = from(&healthy, FaultSet::EMPTY).or_else(from_place) else { return Ok(None) };
    // The others have had their say: from here on it is this one beside those declared, and what may stand in its place.
    let mut rig = model.rig.clone();
    let all = std::iter::once(one).chain(in_its_place(&found, one, declared));
    rig.faults.extend(all.map(|fault| wider.rig.faults[fault].clone()));
    let with_one = Model::new(rig).with_tolerance(model.tolerance);
    let set: FaultSet = found.isolation.set().iter().map(|fault| fault.min(declared)).collect();
    let near = (&found.case.full.parameters(&found.isolation.best.theta)[..], set);
    let is_wanted = |estimate: &Estimate<'_>| the_one(estimate, declared).is_some() && estimate.explains();
    let attempt =
        Attempt { is_wanted: Some(&is_wanted), near: Some(near), reported: Some(declared), ..Attempt::default() };
    let found = diagnose_again(&with_one, record, (&[], None), options, attempt)?;
    let Some(found) = found.filter(|found| found.diagnosis.is_explained()) else { return Ok(None) };
    let names = undeclared(&with_one.rig, declared, &found, false).filter(|names| names.len() == 1);
    Ok(names.map(|names| told(declared, (with_one.rig, found), names)))
}

/// Faults behind the `declared` ones of combinations without `one` that are probable enough to be named beside it.
fn in_its_place<'e>(found: &'e Estimate<'_>, one: usize, declared: usize) -> impl Iterator<Item = usize> + use<'e> {
    let (case, isolation) = (&found.case, &found.isolation);
    let (probabilities, least) = (isolation.probabilities(), case.settings().ambiguity_probability);
    (declared..case.faults()).filter(move |&fault| isolation.of_instead(&probabilities, fault, one) >= least)
}

/// The one fault behind the `declared` ones of an explanation that takes few faults, where it has changed; `None` where there are others too.
fn the_one(estimate: &Estimate<'_>, declared: usize) -> Option<usize> {
    let (case, set) = (&estimate.case, estimate.isolation.set());
    let mut behind = set.iter().filter(|fault| *fault >= declared);
    let one = behind.next().filter(|_| behind.next().is_none() && set.len() < case.settings().several_faults);
    one.filter(|&one| has_changed(case.rig(), one, estimate.isolation.best.theta[one]))
}

/// Values that are no declared faults and may be another than the file has, by index among the rig's parameters.
pub(crate) fn may_be_misstated(rig: &Rig) -> impl Iterator<Item = usize> + '_ {
    exact(rig).chain(calibrated(rig))
}

/// Values of parts and sensors that the file takes as exact, and that are no faults. Of what is nothing nobody knows how far it could go.
fn exact(rig: &Rig) -> impl Iterator<Item = usize> + '_ {
    (0..rig.parameters.len()).filter(|&index| {
        let parameter = &rig.parameters[index];
        parameter.sigma == 0.0 && parameter.value != 0.0 && may_be_a_fault(rig, index)
    })
}
