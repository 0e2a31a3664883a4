//! Parts that are not as their data sheets have them, instead of several faults.
//!
//! A rig file as first written takes data sheets as exact. Where parts deviate as parts do, faults move in their place, and physics that
//! is not missing. So a record that the model as stated does not explain, or explains by a fault that nobody would need if parts may
//! deviate, is diagnosed once more with every value as uncertain as its part is ([`Rig::as_by_data_sheet`]). The two compete by their
//! evidence: what deviates has the Occam factor of what it may deviate by.

use std::cell::{Cell, OnceCell};

use super::doubtful::set_aside;
use super::estimate::{self, Estimate, picked};
use super::result::{FaultReport, OffDataSheet, OffSheetValue};
use super::search::roughly;
use super::weighed::unweighed;
use super::weighing::{Around, inflations};
use super::{DIGITS, Diagnosed, FittedReport};
use crate::estimation::profile::QUANTILE;
use crate::model::{InputSignals, Model};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::{Fault, FaultSet, Rig};

/// Whether questions may be spared because parts that deviate as parts do explain a record without any fault. That costs a fit, which is
/// made once and only where a question comes up.
pub(super) struct Sparing<'a> {
    model: &'a Model,
    record: &'a Record,
    left: OnceCell<Option<f64>>,
    has_spared: Cell<bool>,
}

impl<'a> Sparing<'a> {
    pub fn of(model: &'a Model, record: &'a Record) -> Self {
        Self { model, record, left: OnceCell::new(), has_spared: Cell::new(false) }
    }

    /// Whether a question is spared whose answer so far leaves so much, times the noise.
    pub fn spares(&self, so_far: f64) -> bool {
        let left = *self.left.get_or_init(|| left_of(self.model, self.record));
        let spares = left.is_some_and(|left| left <= so_far);
        self.has_spared.set(self.has_spared.get() || spares);
        spares
    }

    /// Whether any was.
    pub fn has_spared(&self) -> bool {
        self.has_spared.get()
    }
}

/// What parts that deviate as parts do leave of a record that they explain without any fault, times the noise; `None` where they do not.
fn left_of(model: &Model, record: &Record) -> Option<f64> {
    let commanded = model.rig.as_commanded([record]);
    let rig = commanded.as_ref().unwrap_or(&model.rig).as_by_data_sheet()?;
    let (believed, _) = set_aside(&rig, record);
    let record = believed.as_ref().unwrap_or(record);
    let model = roughly(&Model::new(rig));
    let drive = InputSignals::from_record(&model.rig, record).ok()?;
    let found = estimate::from_start(&model, record, &drive, None).ok()?;
    let is_as_parts_are = found.isolation.set().is_empty() && !found.case.is_strained(&found.isolation.best.theta);
    // Nothing is left of a record that cannot be simulated there.
    (found.explains() && is_as_parts_are).then(|| found.times_noise()).filter(|left| *left > 0.0)
}

/// The rig with parts that deviate, where a record should be diagnosed with it once more: what was found with every value as stated does
/// not explain it, or has a fault that could go.
pub(super) fn doubted(model: &Model, record: &Record, stated: &Diagnosed) -> Option<Rig> {
    if stated.diagnosis.is_misread() {
        return None;
    }
    let is_new = || as_new(&model.rig, &stated.diagnosis.faults).len() == stated.diagnosis.present().count();
    let is_replaced = || stated.is_as_old_as_the_record() && replaces_a_fault(model, record, stated);
    // No part leaves its new value by less than new parts differ within a record.
    let is_no_change = stated.diagnosis.onset_s.is_some() && is_new();
    let doubtful = !stated.diagnosis.is_explained() || is_no_change || is_replaced();
    if doubtful { model.rig.as_by_data_sheet() } else { None }
}

/// What was found with parts that deviate as the diagnosis of the record; `None` where what was found as stated is the better explanation.
pub(super) fn preferred(
    rig: &Rig,
    record: &Record,
    stated: &Diagnosed,
    (freed, mut found): (Rig, Diagnosed),
) -> Option<Diagnosed> {
    if !is_as_parts_are(&freed, &found) || !found.explains_better_than(stated, rig, record, 0.0) {
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
    /// Whether this explains the record, and better than another diagnosis of it: that does not, or has less evidence under the weights of
    /// the one and of the other. What may be missed where the model switches depends on the explanation, and neither is known to be
    /// right. `odds`: logarithm of those before the record. `rig`: that of the other.
    pub(super) fn explains_better_than(&self, other: &Self, rig: &Rig, record: &Record, odds: f64) -> bool {
        let (believed, _) = set_aside(rig, record);
        let record = believed.as_ref().unwrap_or(record);
        let has_more_evidence = |under: &Self| {
            let [own, others] = [self, other].map(|one| one.evidence_under(&under.weights, rig, record) + one.occam);
            own + odds > others
        };
        self.diagnosis.is_explained()
            && (!other.diagnosis.is_explained() || has_more_evidence(self) && has_more_evidence(other))
    }

    /// Whether an explanation may be the better one once it has intervals: so far it is under its own weights.
    pub(super) fn is_outdone_by(&self, better: &Estimate<'_>, rig: &Rig, record: &Record, odds: f64) -> bool {
        let Estimate { case, isolation } = better;
        let (believed, _) = set_aside(rig, record);
        let own = || self.evidence_under(&case.full.weights, rig, believed.as_ref().unwrap_or(record)) + self.occam;
        better.explains()
            && (!self.diagnosis.is_explained() || isolation.evidence(case) + better.occam() + odds > own())
    }

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

/// Present faults that are no further off than parts of their kind are when they are new: what a data sheet is not exact enough to tell.
pub(super) fn as_new(rig: &Rig, faults: &[FaultReport]) -> Vec<String> {
    let is_new = |(own, fault): (&Fault, &FaultReport)| {
        let parameter = &rig.parameters[own.parameter];
        let away = (parameter.unit.to_si(fault.value) - own.healthy).abs();
        (fault.present && away <= QUANTILE * parameter.spread).then(|| fault.id.clone())
    };
    if rig.calibration.is_some() { Vec::new() } else { rig.faults.iter().zip(faults).filter_map(is_new).collect() }
}

/// All that was fitted and is no fault: its index in the rig, and how far off it is, in standard deviations before the record.
fn deviations<'a>(freed: &'a Rig, found: &'a Diagnosed) -> impl Iterator<Item = (usize, f64, &'a FittedReport)> {
    let healthy = freed.healthy();
    let fitted = found.diagnosis.fit.parameters.iter().filter(|fitted| !fitted.fault);
    fitted.filter_map(move |fitted| {
        let index = freed.parameter(&fitted.id)?;
        let parameter = &freed.parameters[index];
        Some((index, (parameter.unit.to_si(fitted.value) - healthy[index]).abs() / parameter.sigma, fitted))
    })
}

/// Parameters of declared faults that were freed and found further from healthy than new parts differ (95 %), others than those present: what
/// a rig file declares as a fault is one then, and no deviation of a new part.
pub(super) fn changed(stated: &Rig, freed: &Rig, found: &Diagnosed) -> Vec<usize> {
    deviations(freed, found)
        .filter(|&(index, away, _)| away > QUANTILE && is_freed(stated, freed, index) && stated.is_fault(index))
        .map(|(index, ..)| index)
        .collect()
}

/// Whether a value is less certain than the file has it. Margins stand behind the parameters of the file, which says nothing of them.
fn is_freed(stated: &Rig, freed: &Rig, index: usize) -> bool {
    stated.parameters.get(index).is_some_and(|parameter| parameter.sigma < freed.parameters[index].sigma)
}

/// Whether nothing is further off than parts are: neither values of the file nor margins.
fn is_as_parts_are(freed: &Rig, found: &Diagnosed) -> bool {
    deviations(freed, found).all(|(_, away, _)| away <= freed.settings().diagnosis.off_sheet_deviations)
}

/// What was freed, the furthest from what is stated first.
fn values(stated: &Rig, freed: &Rig, found: &Diagnosed) -> Vec<OffSheetValue> {
    let healthy = freed.healthy();
    let mut values: Vec<_> = deviations(freed, found).filter(|&(index, ..)| is_freed(stated, freed, index)).collect();
    values.sort_by(|a, b| b.1.total_cmp(&a.1));
    let one = |(index, _, fitted): (usize, f64, &FittedReport)| {
        let parameter = &freed.parameters[index];
        OffSheetValue {
            id: fitted.id.clone(),
            value: fitted.value,
            nominal: rounded(parameter.unit.from_si(healthy[index]), DIGITS),
            unit: fitted.unit.clone(),
            sigma_before: rounded(parameter.unit.difference_from_si(parameter.sigma), DIGITS),
        }
    };
    values.into_iter().map(one).collect()
}
