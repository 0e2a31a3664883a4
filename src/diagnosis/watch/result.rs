//! A record in windows as programs read it.

use serde::Serialize;

use crate::diagnosis::{Diagnosis, Verdict};
use crate::residual::Direction;

/// Name and number of the format; keys may be added under one number, never renamed.
pub const SCHEMA: &str = "borescope.windows/1";

/// What is said of the whole record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum WatchedVerdict {
    /// No residual fired, or no diagnosis found anything where one did.
    Healthy,
    /// A diagnosis found faults.
    Faulty,
    /// A diagnosis found that the model does not explain the record.
    ModelInadequate,
    /// Residuals fired, and nothing that was diagnosed says why.
    NotDiagnosed,
}

/// A record that was watched window by window.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Watched {
    /// Name and version of the JSON schema: `borescope.windows/1`.
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// The record, as the user named it.
    pub record: String,
    /// What was recognised of the file.
    pub read_as: String,
    /// What is wrong, in a word.
    pub conclusion: WatchedVerdict,
    /// Rows of the record.
    pub rows: usize,
    /// Time of the first row, s.
    pub from_s: f64,
    /// Time of the last row, s.
    pub to_s: f64,
    /// Length of a window, s.
    pub window_s: f64,
    /// Most windows that are diagnosed.
    pub fits: usize,
    /// In the order of their beginning.
    pub episodes: Vec<Episode>,
    /// Where no residual fired: the last whole window, diagnosed in full, as faults that no residual answers to show only there. `None` where
    /// no window may be diagnosed, or it cannot be.
    pub sample: Option<Sample>,
    /// Those that have rows.
    pub(crate) windows: Vec<WindowReport>,
}

/// A stretch that was diagnosed although no residual fired.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Sample {
    /// The stretch, s.
    pub diagnosed_s: [f64; 2],
    /// Of that stretch.
    pub diagnosis: Diagnosis,
}

/// One window of the record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct WindowReport {
    /// Time of its first row, s.
    pub from_s: f64,
    /// Time of its last row, s.
    pub to_s: f64,
    /// How many it has.
    pub rows: usize,
    /// Values of residuals that count; without any nothing is said of the window.
    pub values: usize,
    /// How often residuals fired.
    pub alarms: usize,
}

/// A stretch over which residuals fire again and again.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Episode {
    /// When the first residual began to leave zero, s.
    pub onset_s: f64,
    /// Time of the first alarm, s.
    pub first_alarm_s: f64,
    /// Time of the last alarm, s.
    pub last_alarm_s: f64,
    /// How often residuals fired.
    pub alarms: usize,
    /// Residuals that fired, in the order of their first alarms.
    pub(crate) residuals: Vec<FiredResidual>,
    /// The stretch that was diagnosed, s.
    pub diagnosed_s: Option<[f64; 2]>,
    /// Of that stretch; `None` where nothing was diagnosed.
    pub diagnosis: Option<Diagnosis>,
    /// Why nothing was diagnosed.
    pub not_diagnosed: Option<String>,
}

/// A residual of an episode.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FiredResidual {
    /// As rig files and programs know it.
    pub id: String,
    /// Time of the first alarm, s.
    pub first_alarm_s: f64,
    /// Time from which on the residual had left zero, s.
    pub onset_s: f64,
    /// Whether the residual is too large or too small.
    pub direction: Direction,
    /// Position of the valve.
    pub phase: &'static str,
    /// How many there were.
    pub alarms: usize,
}

impl WatchedVerdict {
    /// The gravest of what the episodes say, and the sample where there are none.
    pub(super) fn of(episodes: &[Episode], sample: Option<&Sample>) -> Self {
        let of_episodes =
            || episodes.iter().map(|episode| episode.diagnosis.as_ref().map(|diagnosis| diagnosis.verdict));
        let verdicts = || of_episodes().chain(sample.map(|sample| Some(sample.diagnosis.verdict)));
        if verdicts().any(|verdict| verdict == Some(Verdict::Faulty)) {
            Self::Faulty
        } else if verdicts().any(|verdict| verdict == Some(Verdict::ModelInadequate)) {
            Self::ModelInadequate
        } else if verdicts().any(|verdict| verdict.is_none()) {
            Self::NotDiagnosed
        } else {
            Self::Healthy
        }
    }
}

impl Watched {
    /// Windows without alarms, with alarms, and of which nothing can be said.
    pub fn counts(&self) -> (usize, usize, usize) {
        let of = |wanted: &dyn Fn(&WindowReport) -> bool| self.windows.iter().filter(|window| wanted(window)).count();
        (
            of(&|window| window.alarms == 0 && window.values > 0),
            of(&|window| window.alarms > 0),
            of(&|window| window.values == 0),
        )
    }
}
