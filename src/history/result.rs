//! The history as programs read it (`borescope.history/1`).

use serde::Serialize;

use super::forecast::State;
use super::regression::Line;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.history/1";

/// What the trend goes over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum By {
    /// The times at which the records were measured.
    Time,
    /// The order in which they were stored.
    Run,
}

impl By {
    /// The step that slopes are told over.
    pub fn step(self) -> &'static str {
        match self {
            Self::Time => "day",
            Self::Run => "run",
        }
    }
}

/// A place on the axis of the trend: a moment, or a count of runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Axis {
    /// A moment, such as `2026-05-01T12:00:00.000Z`.
    Time(String),
    /// How many runs came before it; a fraction lies between two.
    Run(f64),
}

/// A run that counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct RunLine {
    /// Number in the store.
    pub run: i64,
    /// When it was measured.
    pub measured_at: String,
    /// What says when it was measured.
    pub dated_by: String,
    /// The record, as it was named.
    pub record: String,
    /// Of the diagnosis.
    pub verdict: String,
    /// Version of the program that diagnosed it.
    pub model_version: String,
    /// SHA-256 of the rig file.
    pub rig_digest: String,
}

/// What one run said of a fault. Numbers in the unit of the fault.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct RunValue {
    /// Its number in the store.
    pub run: i64,
    /// Its place on the axis of the trend: days, or the count of runs.
    #[serde(skip)]
    pub x: f64,
    /// When its record was measured, such as `2026-05-01T12:00:00.000Z`.
    pub measured_at: String,
    /// Estimate.
    pub value: f64,
    /// Ends of the 95 % interval; `None` where the record did not bound the value.
    pub ci95: [Option<f64>; 2],
    /// Whether the diagnosis called the fault present.
    pub present: bool,
    /// Of its being present.
    pub probability: Option<f64>,
}

/// The straight line through the values. Numbers in the unit of the fault.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Trend {
    /// Change in a `per`.
    pub slope: f64,
    /// `day` or `run`.
    pub per: &'static str,
    /// The 95 % interval of the slope.
    pub ci95: [f64; 2],
    /// The line at the last run.
    pub now: f64,
    /// The 95 % interval of the line there.
    pub now_ci95: [f64; 2],
    /// Standard deviation between runs beyond what their intervals say.
    pub scatter: f64,
    /// Runs that the line goes through.
    pub runs: usize,
}

/// When the line passes the limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Forecast {
    /// Whether the line passes the limit.
    pub state: State,
    /// `None` where the line never does.
    pub passes_at: Option<Axis>,
    /// First and last passing within the uncertainty of the line, 95 %; an end is `None` where it never does.
    pub ci95: [Option<Axis>; 2],
}

/// The course of one fault. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultHistory {
    /// Such as `cylinder.clearance`.
    pub id: String,
    /// From the card of the component.
    pub meaning: String,
    /// As the rig file has it.
    pub unit: String,
    /// By the rig file.
    pub healthy: f64,
    /// From which value on the part no longer serves; `None` where the rig file has none.
    pub limit: Option<f64>,
    /// One for each run that counts, in the order of the axis.
    pub values: Vec<RunValue>,
    /// `None` where there are too few values.
    pub trend: Option<Trend>,
    /// The same line for pictures.
    #[serde(skip)]
    pub(crate) line: Option<Line>,
    /// `None` without a limit or a trend.
    pub forecast: Option<Forecast>,
    /// What was left out, why there is no trend, whether it bends; in words.
    pub remark: Option<String>,
}

/// The courses of all faults of a rig.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct History {
    /// Name and version of the JSON schema: `borescope.history/1`.
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// The `name` of `[rig]`; empty without.
    pub name: String,
    /// The store, as the user named it.
    pub store: String,
    /// What the trends go over.
    pub by: By,
    /// In the order of time.
    #[doc(hidden)]
    pub runs: Vec<RunLine>,
    /// Every fault of the rig, in its order.
    pub faults: Vec<FaultHistory>,
    /// What is doubtful about the runs, in words.
    pub warnings: Vec<String>,
}
