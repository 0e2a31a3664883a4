//! The diagnosis as programs read it (`borescope.diagnosis/1`) and writers print it.

use serde::{Serialize, Serializer};

use super::case::FAR_OFF;
use super::hypotheses::Hypothesis;
use crate::estimation::Identifiable;
use crate::estimation::profile::QUANTILE;
use crate::model::BelowVacuum;
use crate::record::survey::Finding;
use crate::residual::ResidualReport;
use crate::rig::Rig;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.diagnosis/1";

/// What is wrong, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The healthy model explains the record.
    Healthy,
    /// The model explains the record with at least one fault.
    Faulty,
    /// The model does not explain the record with any faults: physics is missing, or a sensor is wrong.
    ModelInadequate,
}

impl Verdict {
    /// The word that the JSON has for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Healthy => "healthy",
            Self::Faulty => "faulty",
            Self::ModelInadequate => "model-inadequate",
        }
    }
}

/// What one record says about one fault. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultReport {
    /// The parameter that it changes, such as `cylinder.clearance`.
    pub id: String,
    /// From the card of the component.
    pub meaning: String,
    /// Estimate.
    pub value: f64,
    /// As the rig file has it.
    pub unit: String,
    /// By the rig file, or by its calibration.
    pub healthy: f64,
    /// Standard uncertainty of the healthy value by the rig file; 0 where it is exact.
    pub healthy_sigma: f64,
    /// Ends of the range that was searched.
    pub bounds: [f64; 2],
    /// From which value on the part no longer serves; `None` where the rig file does not say.
    pub limit: Option<f64>,
    /// Ends of the 95 % interval; `None` where the record does not bound the value.
    pub ci95: [Option<f64>; 2],
    /// Ends of the 95 % interval of the change from its healthy value; `None` where that is exact. What calibration could not tell apart,
    /// such as two leaks in parallel, leaves each of them open, and a change of one of them known.
    pub change95: Option<[f64; 2]>,
    /// Whether it is in the most probable set of faults, and the record bounds its change away from nothing.
    pub present: bool,
    /// That it is present, over all sets of faults.
    pub probability: f64,
    /// Whether the record bounds it on both sides, on one or on none.
    #[serde(serialize_with = "identifiable")]
    #[cfg_attr(feature = "internals", schemars(schema_with = "of_identifiable"))]
    pub identifiable: Identifiable,
    /// Why an end is open or a figure is missing, in words.
    pub remark: Option<String>,
    /// Whether the model misses something, so that the value may be off by more than its interval.
    pub biased: bool,
}

impl FaultReport {
    /// What the rig file leaves open of the healthy value at 95 %, to both sides.
    pub fn healthy_tolerance(&self) -> f64 {
        QUANTILE * self.healthy_sigma
    }

    /// Whether the whole interval lies further than `room` from a value.
    pub fn interval_misses(&self, value: f64, room: f64) -> bool {
        self.ci95[0].is_some_and(|low| value + room < low) || self.ci95[1].is_some_and(|high| high < value - room)
    }
}

/// `true` or `false` for both ends or none, the open side in words otherwise.
fn identifiable<S: Serializer>(value: &Identifiable, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Identifiable::Bounded => serializer.serialize_bool(true),
        Identifiable::Unidentifiable => serializer.serialize_bool(false),
        open => serializer.collect_str(open),
    }
}

/// The schema of what [`identifiable`] writes.
#[cfg(feature = "internals")]
fn of_identifiable(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "type": ["boolean", "string"] })
}

/// Error of what is explained, times the noise, from which on it is said why it counts as explained.
pub(crate) const CLEARLY_ABOVE_NOISE: f64 = 1.5;

impl ChannelReport {
    /// Whether it counts as explained although clearly more than noise is left.
    pub(crate) fn is_above_noise(&self) -> bool {
        self.adequate && self.samples > 0 && self.times_noise > CLEARLY_ABOVE_NOISE
    }
}

/// How well the model follows one sensor. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ChannelReport {
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
    /// Measured over healthy model, where the sensor is not explained and reads as if its column were in another unit than it
    /// says, or counted the other way.
    pub ratio_to_healthy: Option<f64>,
}

/// A parameter that is no fault but was estimated along. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct UncertainReport {
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
    /// Standard error with the record; `None` at a bound.
    pub sigma_after: Option<f64>,
}

impl UncertainReport {
    /// How far it is from where the rig file has it, in standard deviations before the record; 0 of what was exact.
    pub(crate) fn deviations(&self) -> f64 {
        if self.sigma_before > 0.0 { ((self.value - self.nominal) / self.sigma_before).abs() } else { 0.0 }
    }
}

/// A parameter that was fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FittedReport {
    /// Such as `cylinder.clearance`.
    pub id: String,
    /// Estimate, in `unit`.
    pub value: f64,
    /// As the rig file has it.
    pub unit: String,
    /// One standard error for white misfits, in `unit`; intervals are wider where misfits are correlated.
    pub standard_error: f64,
    /// Whether it is a fault that is present; others are uncertain values of the rig file, healthy ones of absent faults included.
    pub fault: bool,
}

/// Profile likelihood of a fault: how far the fit worsens where its value is held.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ProfileReport {
    /// Of the fault.
    pub id: String,
    /// Unit of the values.
    pub unit: String,
    /// Value, and rise of chi-square there, inflated misfits counted as the fewer that they are worth: 3.84 ends the interval.
    pub points: Vec<[f64; 2]>,
}

/// How the fit went.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FitReport {
    /// Mean square of the weighted misfit: 1 if the model is right within its tolerance.
    pub chi2_reduced: f64,
    /// Local models that were taken.
    pub iterations: u64,
    /// Simulations of the whole record, those with sensitivities included.
    pub solves: u64,
    /// What ended the search, in words.
    pub stopped_because: String,
    /// Present faults and uncertain parameters, as fitted, in the order of `correlation`.
    pub parameters: Vec<FittedReport>,
    /// Correlation of `parameters`, row by row.
    pub correlation: Vec<Vec<f64>>,
    /// Profile likelihood of each fault that is present.
    pub profiles: Vec<ProfileReport>,
}

/// [`CommonCause::kind`] of an oil whose viscosity is not that of the rig file.
pub(crate) const OTHER_OIL: &str = "other-oil";

/// What one mistake in taking the record, or another oil, explains.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CommonCause {
    /// `fast-clock`, `absolute-pressures`, `swapped-columns`, `turned-sign`, `late-inputs` or `other-oil`.
    pub kind: &'static str,
    /// The columns that it concerns.
    pub columns: Vec<String>,
    /// Relative rate of a clock, the time by which inputs are recorded late, s, or the viscosity of another oil, Pa·s; `None` for what has no
    /// size.
    pub value: Option<f64>,
    /// As a clause: `the clock of the logger is 1 % fast`.
    pub clause: String,
    /// Faults that it would take to explain the record without it.
    pub instead_of: Vec<String>,
}

/// Parts that are not as their data sheets have them, although the rig file takes those as exact: the record is explained only so.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct OffDataSheet {
    /// Values that are furthest from what is stated, the furthest first.
    pub values: Vec<OffSheetValue>,
    /// Faults that the record takes with every value as stated.
    pub instead_of: Vec<String>,
    /// Error with those, over the noise of the sensors.
    pub times_noise_as_stated: f64,
}

/// A value that is not as its data sheet has it. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct OffSheetValue {
    /// Such as `pump.displacement`.
    pub id: String,
    /// With which the record is explained.
    pub value: f64,
    /// As the rig file has it.
    pub nominal: f64,
    /// As the rig file has it.
    pub unit: String,
    /// How far parts deviate from data sheets, one standard deviation.
    pub sigma_before: f64,
}

impl OffDataSheet {
    /// Chance with which one of so many values of new parts is further off its data sheet than the furthest here.
    const BY_CHANCE: f64 = 0.05;

    /// The value that is further off than any of so many would be in 19 of 20 new machines: it has changed, or physics is missing.
    pub(crate) fn beyond_chance(&self) -> Option<&OffSheetValue> {
        let first = self.values.first()?;
        let away = (first.value - first.nominal).abs() / first.sigma_before;
        let chance = statrs::function::erf::erfc(away / std::f64::consts::SQRT_2) * self.values.len() as f64;
        (chance < Self::BY_CHANCE).then_some(first)
    }
}

/// A parameter of how a spool follows its command, where the record asks for another value than the rig file's. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct DynamicsReport {
    /// Such as `valve.inertia_time`.
    pub id: String,
    /// With which the record is explained.
    pub value: f64,
    /// As the rig file has it.
    pub unit: String,
    /// By the rig file.
    pub nominal: f64,
}

/// Physics that the model lacks, beside which the faults of a diagnosis were found.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct MissingEffect {
    /// Such as `seal-friction@cylinder`; two where one alone explains less.
    pub effects: Vec<String>,
    /// As estimated, beside faults and all else.
    pub parameters: Vec<UncertainReport>,
    /// Other effects that explain the record as well.
    pub confounded_with: Vec<String>,
    /// Whether faults and effects together explain the record.
    pub explained: bool,
    /// Root mean square of measured minus the model without the effects, its faults fitted, over the noise of the sensor.
    pub times_noise_without: f64,
}

/// An effect that explains the record in place of a fault: the model need not have that fault if it lacks the effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct RivalEffect {
    /// The fault that is then absent.
    pub fault: String,
    /// Such as `pump-leakage@pump`.
    pub effect: String,
    /// The parameter of it that does most, such as `breakaway`.
    pub part: String,
    /// The size of that as estimated, beside the other faults and all else.
    pub value: f64,
    /// Of `value`.
    pub unit: String,
    /// Fall of the information criterion from the faults found to the effect: positive where the effect explains more.
    pub delta_bic: f64,
}

/// The diagnosis of one record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Diagnosis {
    /// Name and version of the JSON schema: `borescope.diagnosis/1`.
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// The record, as the user named it.
    pub record: String,
    /// What is wrong, in a word.
    pub verdict: Verdict,
    /// A mistake in taking the record that explains what would take several faults; all else is said of the record without it.
    pub common_cause: Option<CommonCause>,
    /// An effect that the model lacks; faults, hypotheses and sensors are those of the model with it.
    pub missing_effect: Option<MissingEffect>,
    /// Parts that are not as their data sheets have them, where the record is explained only so; all else is said of the model with
    /// every value as uncertain as parts deviate.
    pub off_data_sheet: Option<OffDataSheet>,
    /// Ids of present faults that the rig file does not declare: values that it takes as exact or that its calibration has found, and
    /// that are others in this record. They stand behind those that it does among `faults`.
    pub undeclared: Vec<String>,
    /// How spools follow their commands, where the record asks for other than the rig file has; all else is said of the model with
    /// it.
    pub dynamics: Vec<DynamicsReport>,
    /// Effects that explain the record as well as a fault does that is present.
    pub rival_effects: Vec<RivalEffect>,
    /// Root mean square of measured minus the model with the faults found, over the noise of the sensor, over all sensors.
    pub times_noise: f64,
    /// The same, each sample by the share at which it counts: without the moments at which a curve is steep and a small shift in time
    /// is a large error.
    pub times_noise_weighed: f64,
    /// End of the window in which the first residual fired, s; where none did, when fitted and healthy model part.
    pub detected_at_s: Option<f64>,
    /// When the faults began, s; `None` where they are as old as the record, or absent.
    pub onset_s: Option<f64>,
    /// Groups of faults that this record cannot tell apart: one of each is there, which one stays open.
    pub ambiguity: Vec<Vec<String>>,
    /// Present faults, each followed by values of the rig file that are no declared faults and explain the record as well in its place.
    pub alike: Vec<Vec<String>>,
    /// Every fault of the rig, in its order.
    pub faults: Vec<FaultReport>,
    /// Sets of faults with their probabilities, the most probable first.
    pub hypotheses: Vec<Hypothesis>,
    /// What each residual says, without a fit.
    pub residuals: Vec<ResidualReport>,
    /// How the fit went.
    pub fit: FitReport,
    /// Every sensor of the rig, in its order.
    pub channels: Vec<ChannelReport>,
    /// Every parameter that was also estimated.
    pub uncertain: Vec<UncertainReport>,
    /// Parameters that the rig file states without an uncertainty, although parts deviate from data sheets: an error in one of them shows
    /// as a fault. None of a calibrated rig.
    pub taken_as_exact: Vec<String>,
    /// Faults that are present and no further from healthy than new parts of their kind are from their data sheets (95 %); none of a
    /// calibrated rig.
    #[serde(skip)]
    pub as_new: Vec<String>,
    /// Where the explanation has its lowest pressure, if that is below vacuum; `None` where it is nowhere.
    pub below_vacuum: Option<BelowVacuum>,
    /// What record and rig file say differently, in words, where the record is not explained.
    pub at_odds: Vec<String>,
    /// Values of the rig file that are still those of a draft.
    #[serde(skip)]
    pub unfilled: usize,
    /// What of the record the fit does not have: samples that are missing or not to be believed, missing rows.
    pub left_out: Vec<Finding>,
}

impl Diagnosis {
    /// The faults that are present, the surest first; of those as sure to a tenth of a per cent, as people read it, in the order of the rig.
    pub fn present(&self) -> impl Iterator<Item = &FaultReport> {
        let mut present: Vec<&FaultReport> = self.faults.iter().filter(|fault| fault.present).collect();
        let doubt = |fault: &FaultReport| {
            let thousandths = 1e3 * (1.0 - fault.probability);
            if thousandths < 1.0 { 0.0 } else { thousandths.round() }
        };
        present.sort_by(|a, b| doubt(a).total_cmp(&doubt(b)));
        present.into_iter()
    }

    /// Whether all its faults are no further off than new parts may be.
    pub(crate) fn is_as_new(&self) -> bool {
        self.verdict == Verdict::Faulty && self.present().all(|fault| self.as_new.contains(&fault.id))
    }

    /// Whether a value that is uncertain is further from where the rig file has it than chance puts one of a right model.
    pub(crate) fn is_strained(&self) -> bool {
        self.uncertain.iter().any(|one| one.deviations() > FAR_OFF)
    }

    /// Whether faults, or none, explain the record.
    pub(crate) fn is_explained(&self) -> bool {
        self.verdict != Verdict::ModelInadequate
    }

    /// Whether the record is explained although half as much again as the variance of the noise is left of it, and not where a valve
    /// switches alone.
    pub(crate) fn is_above_noise(&self) -> bool {
        self.is_explained() && self.times_noise_weighed.powi(2) > CLEARLY_ABOVE_NOISE
    }

    /// Whether a column reads as if it were in another unit: a mistake in the record, which neither parts nor physics should be fitted to.
    pub(crate) fn is_misread(&self) -> bool {
        self.channels.iter().any(|channel| channel.ratio_to_healthy.is_some())
    }

    /// All parameters of a rig, SI, as the diagnosis found them: present faults and uncertain parameters as estimated, other faults
    /// healthy.
    pub(crate) fn found(&self, rig: &Rig) -> Vec<f64> {
        let mut parameters = rig.healthy();
        let faults = self.present().map(|fault| (&fault.id, fault.value));
        let uncertain = self.uncertain.iter().map(|parameter| (&parameter.id, parameter.value));
        for (id, value) in faults.chain(uncertain) {
            if let Some(index) = rig.parameter(id) {
                parameters[index] = rig.parameters[index].unit.to_si(value);
            }
        }
        parameters
    }
}
