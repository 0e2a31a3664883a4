//! A record in windows as programs read it.

use serde::Serialize;

use crate::diagnosis::{Diagnosis, Verdict};
use crate::residual::Direction;

/// Name and number of the format; keys may be added under one number, never renamed.
pub const SCHEMA: &str = "borescope.windows/1";

/// What is said of the whole record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Conclusion {
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
pub struct Watched {
    pub schema: &'static str,
    pub rig: String,
    pub record: String,
    /// What was recognised of the file.
    pub read_as: String,
    pub conclusion: Conclusion,
    pub rows: usize,
    /// Times of the first and the last row, s.
    pub from_s: f64,
    pub to_s: f64,
    /// Length of a window, s.
    pub window_s: f64,
    /// Most windows that are diagnosed.
    pub fits: usize,
    pub episodes: Vec<Episode>,
    /// Those that have rows.
    pub windows: Vec<WindowReport>,
}

/// One window of the record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WindowReport {
    pub from_s: f64,
    pub to_s: f64,
    pub rows: usize,
    /// Values of residuals that count; without any nothing is said of the window.
    pub values: usize,
    pub alarms: usize,
}

/// A stretch over which residuals fire again and again.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Episode {
    /// When the first residual began to leave zero, s.
    pub onset_s: f64,
    pub first_alarm_s: f64,
    pub last_alarm_s: f64,
    pub alarms: usize,
    /// Residuals that fired, in the order of their first alarms.
    pub residuals: Vec<FiredResidual>,
    /// The stretch that was diagnosed, s.
    pub diagnosed_s: Option<[f64; 2]>,
    pub diagnosis: Option<Diagnosis>,
    /// Why nothing was diagnosed.
    pub not_diagnosed: Option<String>,
}

/// A residual of an episode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FiredResidual {
    pub id: String,
    pub first_alarm_s: f64,
    pub onset_s: f64,
    pub direction: Direction,
    pub phase: &'static str,
    pub alarms: usize,
}

impl Conclusion {
    /// The gravest of what the episodes say.
    pub(super) fn of(episodes: &[Episode]) -> Self {
        let verdicts = || episodes.iter().map(|episode| episode.diagnosis.as_ref().map(|diagnosis| diagnosis.verdict));
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
