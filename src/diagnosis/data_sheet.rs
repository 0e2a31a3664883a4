//! Parts that are not as their data sheets have them, instead of several faults.
//!
//! A rig file as first written takes data sheets as exact. Where parts deviate as parts do, faults move in their place, and physics that
//! is not missing. So a record that the model as stated does not explain, or explains by a fault that nobody would need if parts may
//! deviate, is diagnosed once more with every value as uncertain as its part is ([`Rig::as_by_data_sheet`]). The two compete by their
//! evidence: what deviates has the Occam factor of what it may deviate by.

use super::DIGITS;
use super::estimate::picked;
use super::result::{OffDataSheet, OffSheetValue, Verdict};
use super::weighed::case_at;
use super::weighing::{Around, inflations};
use super::{Attempt, Diagnosed, DiagnosisOptions, diagnose_again};
use crate::complaint::Complaint;
use crate::model::{InputSignals, Model};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::{FaultSet, Rig};

/// The diagnosis with parts that deviate, where it is a better one than that with every value as stated.
pub(super) fn instead(
    model: &Model,
    record: &Record,
    stated: &Diagnosed,
    options: &DiagnosisOptions,
) -> Result<Option<Diagnosed>, Complaint> {
    // A column in another unit is a mistake in the record, which no part should be fitted to.
    if stated.diagnosis.channels.iter().any(|channel| channel.ratio_to_healthy.is_some()) {
        return Ok(None);
    }
    let explained = stated.diagnosis.verdict != Verdict::ModelInadequate;
    if explained && !(stated.is_as_old_as_the_record() && replaces_a_fault(model, record, stated)) {
        return Ok(None);
    }
    let Some(rig) = model.rig.as_by_data_sheet() else { return Ok(None) };
    let rig = Model::new(rig).with_tolerance(model.tolerance);
    let attempt = Attempt { only_if_explained: true, ..Attempt::default() };
    let Some(mut found) = diagnose_again(&rig, record, (&[], None), options, attempt)? else { return Ok(None) };
    let is_better = || {
        let stated = stated.evidence_under(&found.weights, &model.rig, record) + stated.occam;
        found.evidence + found.occam > stated
    };
    if found.diagnosis.verdict == Verdict::ModelInadequate || explained && !is_better() {
        return Ok(None);
    }
    found.diagnosis.off_data_sheet = Some(OffDataSheet {
        values: values(&model.rig, &rig.rig, &found),
        instead_of: stated.diagnosis.present().map(|fault| fault.id.clone()).collect(),
        times_noise_as_stated: stated.diagnosis.times_noise,
    });
    found.healthy.clone_from(&stated.healthy);
    found.other_rig.get_or_insert(rig.rig);
    Ok(Some(found))
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
    let model = Model::new(rig).with_tolerance(model.tolerance);
    let values = stated.diagnosis.found(&model.rig);
    let Ok(drive) = InputSignals::from_record(&model.rig, record) else { return false };
    let Ok((case, local)) = case_at(&model, record, &drive, &picked(&model.rig, &values)) else { return false };
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

/// What was freed, the furthest from what is stated first.
fn values(stated: &Rig, freed: &Rig, found: &Diagnosed) -> Vec<OffSheetValue> {
    let one = |fitted: &super::FittedReport| {
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
