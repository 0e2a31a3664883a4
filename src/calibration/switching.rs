//! How spools follow their commands, as healthy records together show it.

use rayon::prelude::*;

use super::joint::{Healthy, Solutions};
use crate::diagnosis::{estimate, switching};
use crate::model::Model;
use crate::rig::{FaultSet, Rig};

/// Linearisations with which each record is fitted on its own before its switchings are looked at.
const FORMS: usize = 1;

/// The rig as stated but for spools that follow as the records show it, the model at `theta`; `None` where nothing speaks against the
/// rig file, or the model cannot be solved there.
pub(super) fn found(solutions: &Solutions<'_>, stated: &Rig, theta: &[f64]) -> Option<Rig> {
    let mut fitted = solutions.model.rig.clone();
    for (parameter, value) in fitted.parameters.iter_mut().zip(solutions.parameters(theta)) {
        parameter.value = value;
    }
    for fault in &mut fitted.faults {
        fault.healthy = fitted.parameters[fault.parameter].value;
    }
    let model = Model::new(fitted);
    let start = estimate::picked(&model.rig, &model.rig.nominal());
    let near = solutions.records.par_iter().map(|one: &Healthy<'_>| {
        estimate::held_at(&model, one.record, &one.drive, (&start, FaultSet::EMPTY), FORMS).ok()
    });
    let near: Vec<_> = near.collect::<Option<_>>()?;
    let found = switching::found(&near.iter().collect::<Vec<_>>())?;
    let mut other = stated.clone();
    for own in switching::changed(stated, &found) {
        other.parameters[own].value = found.parameters[own].value;
    }
    Some(other)
}
