//! How spools follow their commands, as healthy records together show it.

use rayon::prelude::*;

use super::joint::{Healthy, Solutions};
use crate::diagnosis::{estimate, switching};
use crate::model::Model;
use crate::rig::FaultSet;

/// Linearisations with which each record is fitted on its own before its switchings are looked at.
const FORMS: usize = 1;

/// Parameters of how spools follow, by index with their values, SI, as the records show them, the model at `theta`; `None` where
/// nothing speaks against the rig file, or the model cannot be solved there.
pub(super) fn found(solutions: &Solutions<'_>, theta: &[f64]) -> Option<Vec<(usize, f64)>> {
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
    switching::found(&near.iter().collect::<Vec<_>>())
}
