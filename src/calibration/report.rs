//! What a calibration found, for people and programs.

use serde::Serialize;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.calibration/1";

/// What a calibration found. Numbers carry the unit beside them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CalibrationReport {
    /// Name and version of the JSON schema: `borescope.calibration/1`.
    pub schema: &'static str,
    /// The rig file, as it was called.
    pub rig: String,
    /// Every parameter that was calibrated, in the order of the rig.
    pub parameters: Vec<CalibratedParameter>,
    /// How spools follow their commands, mean lags and dead times of inputs, where the records show them otherwise than the data sheet has them.
    pub dynamics: Vec<CalibratedDynamics>,
    /// Every sensor, in the order of the rig.
    pub sensors: Vec<CalibratedSensor>,
    /// Every record, in the order given.
    #[doc(hidden)]
    pub records: Vec<RecordFit>,
    /// Whether the calibrated model explains every channel of every record.
    pub adequate: bool,
    /// What speaks against taking the records for healthy ones of this rig.
    pub warnings: Vec<String>,
    /// Mean square of the weighted misfit over all samples.
    pub chi2_reduced: f64,
    /// How often noise and tolerance were estimated anew.
    pub rounds: usize,
    /// Whether nothing moved any more when they ended.
    pub settled: bool,
    /// Simulations of a record, those with sensitivities included.
    pub solves: u64,
}

/// A calibrated parameter. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CalibratedParameter {
    /// Such as `cylinder.clearance`.
    pub id: String,
    /// From its card.
    pub meaning: String,
    /// As the rig file has it.
    pub unit: String,
    /// Data sheet, or the healthy value of the fault.
    pub before: f64,
    /// Standard deviation between data sheet and part.
    pub sigma_before: f64,
    /// With the records.
    pub after: f64,
    /// Standard error with the records, inflated where the misfit is coloured.
    pub sigma_after: f64,
    /// Whether the records told anything: `sigma_after` well below `sigma_before`.
    pub informed: bool,
    /// Whether it is a fault, whose healthy value was calibrated.
    pub fault: bool,
}

/// A lag, mass time or dead time that was searched for and found otherwise than stated. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CalibratedDynamics {
    /// Such as `valve.lag`.
    pub id: String,
    /// From its card.
    pub meaning: String,
    /// As the rig file has it.
    pub unit: String,
    /// Data sheet.
    pub before: f64,
    /// With the records. A search among whole switchings has no standard error.
    pub after: f64,
}

/// Noise and tolerance of a sensor. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CalibratedSensor {
    /// As the rig file has it.
    pub name: String,
    /// Of its readings.
    pub unit: String,
    /// Standard deviation of a reading by the rig file.
    pub noise_before: f64,
    /// The same, estimated from the records.
    pub noise: f64,
    /// Correlation of the noise of neighbouring samples; `None` where the noise could not be estimated and stays.
    pub noise_correlation: Option<f64>,
    /// How far the model may be off throughout a phase, by the rig file.
    pub tolerance_before: f64,
    /// The same, estimated from the records.
    pub tolerance: f64,
}

/// How the calibrated model follows one record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct RecordFit {
    /// The record, as the user named it.
    pub record: String,
    /// Rows of the record.
    pub rows: usize,
    /// Mean square of the weighted misfit.
    pub chi2_reduced: f64,
    /// Sensor by sensor.
    pub channels: Vec<ChannelFit>,
}

/// How the calibrated model follows one sensor in one record. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ChannelFit {
    /// Of the sensor.
    pub name: String,
    /// Unit of the numbers beside it.
    pub unit: String,
    /// Root mean square of measured minus model, with the values of the data sheet.
    pub rmse_before: f64,
    /// The same with the calibrated values.
    pub rmse: f64,
    /// Mean square of the weighted misfit: 1 if the model is right within its tolerance.
    pub chi2_reduced: f64,
    /// Whether it is explained within noise and tolerance.
    pub adequate: bool,
}
