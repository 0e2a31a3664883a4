//! A model beside a record, as programs read it.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::diagnosis::OffDataSheet;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.comparison/1";

/// The model with the values of its rig file beside a record, nothing fitted: what `simulate` gives, and what `calibrate` tells of the rig
/// file that it writes.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct AsStated {
    /// Root mean square of measured minus model over the noise of the sensor, over all sensors.
    pub times_noise: f64,
    /// Root mean square of measured minus model of each sensor, in its unit.
    pub rmse: BTreeMap<String, f64>,
}

/// A phase in which the model misses a sensor. The numbers are in the unit of the sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct MissedPhase {
    /// Its first time, s.
    pub from_s: f64,
    /// Its last time, s.
    pub to_s: f64,
    /// Such as `extend`.
    pub phase: String,
    /// Root mean square of measured minus model.
    pub rmse: f64,
    /// Mean size of the weighted misfit, by which the phases are ordered: 0.8 if the model is right.
    pub deviations: f64,
}

/// A quantity with which a misfit goes.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Correlation {
    /// An input, a sensor (what the model says of it), `velocity of x` or `direction of x`.
    pub signal: String,
    /// Coefficient of correlation with measured minus model, weighted by noise and tolerance.
    pub coefficient: f64,
}

/// How the model follows one sensor. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ChannelComparison {
    /// Of the sensor.
    pub name: String,
    /// Of its readings.
    pub unit: String,
    /// Root mean square of measured minus model.
    pub rmse: f64,
    /// Standard deviation of the noise of a reading.
    pub noise_sigma: f64,
    /// `rmse` over `noise_sigma`: about 1 where nothing but noise is left.
    pub times_noise: f64,
    /// `100 (1 - |y - m|/|y - mean y|)`; `None` where the sensor shows one value throughout.
    pub fit_percent: Option<f64>,
    /// Samples that the fit has; where there is none, the sensor says nothing and is called adequate.
    pub samples: usize,
    /// Mean square of the weighted misfit: 1 if the model is right within its tolerance.
    pub chi2_reduced: f64,
    /// Mean square of what the record asks of events at this sensor, over what the rig file leaves open of each; `None` without any.
    pub events_chi2: Option<f64>,
    /// Whether the model explains it within noise and tolerance, and asks no more of events than they may differ by.
    pub adequate: bool,
    /// Whether it does so where nothing is asked of events.
    #[serde(skip)]
    pub within_noise: bool,
    /// Of neighbouring weighted misfits: near 0 where nothing but noise is left, near 1 where something slow is.
    pub autocorrelation: f64,
    /// The quantities that the misfit goes with, closest first.
    pub goes_with: Vec<Correlation>,
    /// The phases in which the model misses most, in standard deviations, the worst first.
    pub worst: Vec<MissedPhase>,
}

/// Where physics is missing, as far as misfits tell.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct MisfitPlace {
    /// The balance of what the worst sensor shows; in a suggestion that of the effect that explains the misfit.
    pub equation: String,
    /// The worst sensor.
    pub channel: String,
    /// In which it misses most, such as `extend`.
    pub phase: String,
    /// First time of the phase, s.
    pub from_s: f64,
    /// Last time of the phase, s.
    pub to_s: f64,
    /// Quantities that the misfit goes with.
    pub depends_on: Vec<String>,
}

/// A parameter that was fitted, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FittedParameter {
    /// Such as `fluid.density`.
    pub id: String,
    /// Estimate.
    pub value: f64,
    /// As the rig file has it.
    pub unit: String,
    /// By the rig file.
    pub nominal: f64,
    /// Standard uncertainty before the record.
    pub sigma_before: f64,
    /// Whether it stands at an end of its search: the record may ask for more.
    #[serde(skip)]
    pub is_at_end: bool,
}

impl FittedParameter {
    /// How far it is from what the rig file has, in its uncertainty; 0 where that has none.
    pub(crate) fn deviations(&self) -> f64 {
        if self.sigma_before > 0.0 { ((self.value - self.nominal) / self.sigma_before).abs() } else { 0.0 }
    }
}

/// A fault that is present, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
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

/// The model with the faults that explain a record, or with parts off their data sheets, beside that record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct WithFaults {
    /// Those that are present.
    pub faults: Vec<PresentFault>,
    /// Parts that are not as their data sheets have them, where the record is explained only so.
    pub off_data_sheet: Option<OffDataSheet>,
    /// Root mean square of measured minus model over the noise of the sensor, over all sensors.
    pub times_noise: f64,
    /// Whether the model with these faults explains every sensor within noise and tolerance.
    pub adequate: bool,
    /// Every sensor of the rig, in its order.
    pub channels: Vec<ChannelComparison>,
}

/// The model beside a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// Name and version of the JSON schema: `borescope.comparison/1`.
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// The record, as the user named it.
    pub record: String,
    /// Whether the model explains every sensor within noise and tolerance, and no fault explains what is then far from healthy.
    pub adequate: bool,
    /// Root mean square of measured minus model over the noise of the sensor, over all sensors.
    pub times_noise: f64,
    /// The same with the values as the rig file has them, nothing fitted to the record.
    pub as_stated: Option<AsStated>,
    /// Mean square of the weighted misfit: 1 if the model is right within its tolerance.
    pub chi2_reduced: f64,
    /// Where the model misses most; `None` where it is adequate.
    #[serde(rename = "where")]
    pub place: Option<MisfitPlace>,
    /// Every sensor of the rig, in its order.
    pub channels: Vec<ChannelComparison>,
    /// What the rig file gives with an uncertainty, as it was fitted.
    pub fitted: Vec<FittedParameter>,
    /// The model with the faults that explain the record; `None` where the model alone is adequate, or no fault was found.
    pub with_faults: Option<WithFaults>,
    /// Values of the rig file that are still those of a draft.
    #[serde(skip)]
    pub unfilled: usize,
    /// Values that the rig file states without an uncertainty, although parts deviate from data sheets; none of a calibrated rig.
    #[serde(skip)]
    pub taken_as_exact: usize,
    /// The same record with an older rig file, where one was given.
    pub(crate) before: Option<Earlier>,
}

/// A comparison of the same record with an older rig file.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Earlier {
    /// The rig file, as the user named it.
    pub rig: String,
    /// Whether it is explained within noise and tolerance.
    pub adequate: bool,
    /// Error over all sensors, times the sensor noise.
    pub times_noise: f64,
    /// Sensor by sensor.
    pub channels: Vec<ChannelComparison>,
    /// The same with the faults that explain the record.
    pub with_faults: Option<WithFaults>,
}

#[cfg(feature = "cli")]
impl Comparison {
    /// The fitted value that is farthest from what the rig file has, where that is farther than chance puts one.
    pub(crate) fn far_off(&self) -> Option<&FittedParameter> {
        let farthest = self.fitted.iter().max_by(|a, b| a.deviations().total_cmp(&b.deviations()));
        farthest.filter(|one| one.deviations() > crate::diagnosis::FAR_OFF)
    }
}

#[cfg(feature = "cli")]
impl Earlier {
    /// What of a comparison stands beside a newer one.
    pub fn of(comparison: &Comparison) -> Self {
        let Comparison { rig, adequate, times_noise, channels, with_faults, .. } = comparison.clone();
        Self { rig, adequate, times_noise, channels, with_faults }
    }
}
