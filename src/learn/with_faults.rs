//! What is left of a misfit once the faults that explain the record are in the model.

use serde::Serialize;

use super::compare::{ChannelComparison, Comparison};
use super::fitted_model::run_of;
use crate::complaint::Complaint;
use crate::diagnosis::{DiagnosisOptions, diagnose};
use crate::model::Model;
use crate::record::Record;

/// A fault that is present, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PresentFault {
    /// The parameter that it changes.
    pub id: String,
    /// From the card of the component.
    pub meaning: String,
    /// Estimate.
    pub value: f64,
    /// As the rig file has it.
    pub unit: String,
    /// By the rig file.
    pub healthy: f64,
    /// Ends of the 95 % interval; `None` where the record does not bound the value.
    pub ci95: [Option<f64>; 2],
}

/// The model with the faults that explain a record, beside that record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WithFaults {
    /// Those that are present.
    pub faults: Vec<PresentFault>,
    /// Root mean square of measured minus model over the noise of the sensor, over all sensors.
    pub times_noise: f64,
    /// Whether the model with these faults explains every sensor within noise and tolerance.
    pub adequate: bool,
    /// Every sensor of the rig, in its order.
    pub channels: Vec<ChannelComparison>,
}

/// A model with the faults that explain a record, with the curves behind it.
pub(super) struct Explained {
    pub with_faults: WithFaults,
    /// What its sensors would show, `[sensor][row]`, SI.
    pub outputs: Vec<Vec<f64>>,
}

/// The faults that a diagnosis of the record finds, with how the model follows it then; `None` where it finds none.
///
/// # Errors
/// As [`diagnose`].
pub(super) fn with_faults(model: &Model, record: &Record) -> Result<Option<Explained>, Complaint> {
    if model.rig.faults.is_empty() {
        return Ok(None);
    }
    let diagnosed = diagnose(model, record, &DiagnosisOptions::default())?;
    let present = diagnosed.diagnosis.present().map(|fault| PresentFault {
        id: fault.id.clone(),
        meaning: fault.meaning.clone(),
        value: fault.value,
        unit: fault.unit.clone(),
        healthy: fault.healthy,
        ci95: fault.ci95,
    });
    let faults: Vec<PresentFault> = present.collect();
    if faults.is_empty() {
        return Ok(None);
    }
    let run = run_of(&model.rig, record, diagnosed.model, diagnosed.weights)?;
    let Comparison { times_noise, adequate, channels, .. } = Comparison::of(model, record, &run)?;
    let with_faults = WithFaults { faults, times_noise, adequate, channels };
    Ok(Some(Explained { with_faults, outputs: run.outputs }))
}
