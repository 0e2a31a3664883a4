//! Parts that are not as their data sheets have them, instead of several faults.
//!
//! A rig file as first written takes data sheets as exact. Where parts deviate as parts do, faults move in their place, and physics that
//! is not missing. So a record that the model as stated does not explain, or explains by a fault that nobody would need if parts may
//! deviate, is diagnosed once more with every value as uncertain as its part is ([`Rig::as_by_data_sheet`]). The two compete by their
//! evidence: what deviates has the Occam factor of what it may deviate by.

use super::doubtful::set_aside;
use super::estimate::picked;
use super::result::{OffDataSheet, OffSheetValue, Verdict};
use super::weighed::unweighed;
use super::weighing::{Around, inflations};
use super::{DIGITS, Diagnosed, FittedReport};
use crate::model::{InputSignals, Model};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::{FaultSet, Rig};

/// The rig with parts that deviate, where a record should be diagnosed with it once more: what was found with every value as stated does
/// not explain it, or has a fault that could go.
pub(super) fn doubted(model: &Model, record: &Record, stated: &Diagnosed) -> Option<Rig> {
    // A column in another unit is a mistake in the record, which no part should be fitted to.
    if stated.diagnosis.channels.iter().any(|channel| channel.ratio_to_healthy.is_some()) {
        return None;
    }
    let doubtful = match stated.diagnosis.verdict {
        Verdict::ModelInadequate => true,
        _ => stated.is_as_old_as_the_record() && replaces_a_fault(model, record, stated),
    };
    if doubtful { model.rig.as_by_data_sheet() } else { None }
}

/// What was found with parts that deviate as the diagnosis of the record; `None` where what was found as stated is the better explanation.
pub(super) fn preferred(
    rig: &Rig,
    record: &Record,
    stated: &Diagnosed,
    (freed, mut found): (Rig, Diagnosed),
) -> Option<Diagnosed> {
    let is_better = || {
        let (believed, _) = set_aside(rig, record);
        let record = believed.as_ref().unwrap_or(record);
        found.evidence + found.occam > stated.evidence_under(&found.weights, rig, record) + stated.occam
    };
    let explained = |one: &Diagnosed| one.diagnosis.verdict != Verdict::ModelInadequate;
    if !explained(&found) || !is_as_parts_are(&freed, &found) || explained(stated) && !is_better() {
        return None;
    }
    found.diagnosis.off_data_sheet = Some(OffDataSheet {
        values: values(rig, &freed, &found),
        instead_of: stated.diagnosis.present().map(|fault| fault.id.clone()).collect(),
        times_noise_as_stated: stated.diagnosis.times_noise,
    });
    found.healthy.clone_from(&stated.healthy);
    found.other_rig.get_or_insert(freed);
    Some(found)
}

impl Diagnosed {
    /// Whether it has faults that are as old as the record, and no mistake in taking it.
    fn is_as_old_as_the_record(&self) -> bool {
        let diagnosis = &self.diagnosis;
        diagnosis.common_cause.is_none() && diagnosis.onset_s.is_none() && diagnosis.present().next().is_some()
    }
}

/// Whether, near an explanation by faults, one of them less is more probable where parts may deviate: asked of the local model there,
/// which costs a linearisation.
fn replaces_a_fault(model: &Model, record: &Record, stated: &Diagnosed) -> bool {
    let Some(rig) = stated.rig(&model.rig).as_by_data_sheet() else { return false };
    let (believed, _) = set_aside(&model.rig, record);
    let record = believed.as_ref().unwrap_or(record);
    let model = Model::new(rig).with_tolerance(model.tolerance);
    let values = stated.diagnosis.found(&model.rig);
    let Ok(drive) = InputSignals::from_record(&model.rig, record) else { return false };
    let Ok(mut case) = unweighed(&model, record, &drive) else { return false };
    case.full.weights = stated.weights.clone();
    let Ok(local) = case.local_model(&picked(&model.rig, &values)) else { return false };
    let present = stated.diagnosis.faults.iter().enumerate().filter(|(_, fault)| fault.present);
    let set: FaultSet = present.map(|(fault, _)| fault).collect();
    let schur = case.schur_complement(&local);
    let inflation = inflations(&case, &local, &schur, set);
    let around = Around { local: &local, schur: &schur, centre: set, damping: 0.0, inflation: &inflation };
    let cost = |set: FaultSet| Some(schur.best(set.iter())?.cost);
    // A fault that would have to go where it cannot is one that nobody needs.
    let Some(reference) = cost(set) else { return true };
    let score = |set: FaultSet| cost(set).map(|cost| around.score(&case, set, cost, reference));
    let fewer = set.iter().filter_map(|fault| score(set.without(fault)));
    let best = fewer.fold(f64::NEG_INFINITY, f64::max);
    score(set).is_none_or(|all| best > all)
}

/// Whether nothing is further off than parts are: neither values of the file nor margins.
fn is_as_parts_are(freed: &Rig, found: &Diagnosed) -> bool {
    let (settings, healthy) = (&freed.settings().diagnosis, freed.healthy());
    found.diagnosis.fit.parameters.iter().filter(|fitted| !fitted.fault).all(|fitted| {
        let Some(index) = freed.parameter(&fitted.id) else { return true };
        let parameter = &freed.parameters[index];
        let away = (parameter.unit.to_si(fitted.value) - healthy[index]).abs();
        away <= settings.off_sheet_deviations * parameter.sigma
    })
}

/// What was freed, the furthest from what is stated first.
fn values(stated: &Rig, freed: &Rig, found: &Diagnosed) -> Vec<OffSheetValue> {
    let one = |fitted: &FittedReport| {
        let index = freed.parameter(&fitted.id)?;
        // Margins stand behind the parameters of the file, which says nothing of them.
        let (parameter, before) = (&freed.parameters[index], stated.parameters.get(index)?.sigma);
        if fitted.fault || before > 0.0 || parameter.sigma == 0.0 {
            return None;
        }
        let nominal = freed.healthy()[index];
        let away = (parameter.unit.to_si(fitted.value) - nominal).abs() / parameter.sigma;
        let value = OffSheetValue {
            id: fitted.id.clone(),
            value: fitted.value,
            nominal: rounded(parameter.unit.from_si(nominal), DIGITS),
            unit: fitted.unit.clone(),
            sigma_before: rounded(parameter.unit.difference_from_si(parameter.sigma), DIGITS),
        };
        Some((away, value))
    };
    let mut values: Vec<(f64, OffSheetValue)> = found.diagnosis.fit.parameters.iter().filter_map(one).collect();
    values.sort_by(|a, b| b.0.total_cmp(&a.0));
    values.into_iter().map(|(_, value)| value).collect()
}
