//! What is left of a misfit once the faults that explain the record, or parts that are off their data sheets, are in the model.

use super::behind::beside_physics;
use super::comparison::{Comparison, PresentFault, WithFaults};
use super::outright::Asked;
use super::run::run_of;
use crate::complaint::Complaint;
use crate::diagnosis::{DiagnosisOptions, Physics, diagnose_unless};
use crate::model::Model;
use crate::number::rounded;
use crate::record::Record;

/// Digits with which a fault is named.
const NAMED: usize = 4;

/// A model with the faults that explain a record, with the curves behind it.
pub(super) struct Explained {
    pub with_faults: WithFaults,
    /// What its sensors would show, `[sensor][row]`, SI.
    pub outputs: Vec<Vec<f64>>,
}

/// The faults that a diagnosis of the record finds, with how the model follows it then; `None` where it finds none and parts as stated, or physics in their
/// place. Faults that do not explain the record are what they are: physics beside them is sought by [`suggest`](super::suggest).
///
/// # Errors
/// As [`diagnose_unless`].
pub(super) fn with_faults(model: &Model, record: &Record) -> Result<Option<Explained>, Complaint> {
    if model.rig.faults.is_empty() {
        return Ok(None);
    }
    let options = DiagnosisOptions::default();
    let physics = Asked::default();
    let mut diagnosed = diagnose_unless(model, record, &options, &physics)?;
    if physics.has_explained() && !diagnosed.diagnosis.is_explained() {
        return Ok(None);
    }
    if diagnosed.diagnosis.is_explained() {
        diagnosed = beside_physics(model, record, &options, (diagnosed, &[]))?;
    }
    if diagnosed.diagnosis.missing_effect.is_some() {
        return Ok(None);
    }
    let present = diagnosed.diagnosis.present().map(|fault| PresentFault {
        id: fault.id.clone(),
        meaning: fault.meaning.clone(),
        value: fault.value,
        unit: fault.unit.clone(),
        healthy: fault.healthy,
        ci95: fault.ci95,
    });
    // What differs from new by less than is shown would be told as a fault of a part as good as new.
    let differs = |fault: &PresentFault| rounded(fault.value, NAMED) != rounded(fault.healthy, NAMED);
    let faults: Vec<PresentFault> = present.filter(differs).collect();
    let off_data_sheet = diagnosed.diagnosis.off_data_sheet;
    if faults.is_empty() && off_data_sheet.is_none() {
        return Ok(None);
    }
    let run = run_of(&model.rig, record, diagnosed.model, diagnosed.weights)?;
    let Comparison { times_noise, adequate, channels, .. } = Comparison::of(model, record, &run)?;
    let with_faults = WithFaults { faults, off_data_sheet, times_noise, adequate, channels };
    Ok(Some(Explained { with_faults, outputs: run.outputs }))
}
