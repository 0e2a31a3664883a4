//! What speaks against an effect as fitted, as facts with their numbers.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::rig::Rig;

/// What speaks against an effect as fitted.
#[derive(Debug, Clone, PartialEq)]
pub enum Warning {
    /// A parameter of an effect stands at the end of its search.
    AtBound {
        /// Of the parameter.
        id: String,
        /// In `unit`.
        value: f64,
        /// As the rig file writes it.
        unit: String,
        /// Whether it is the size of the effect; the others only shape it.
        is_size: bool,
    },
    /// A parameter of an effect has a value that makes no physical sense.
    Implausible {
        /// Of the parameter.
        id: String,
        /// In `unit`.
        value: f64,
        /// As the rig file writes it.
        unit: String,
    },
    /// A parameter that was known before moved far from what was known.
    Moved {
        /// Of the parameter.
        id: String,
        /// Standard uncertainties of before.
        deviations: f64,
        /// Whether its search ends there.
        at_end: bool,
    },
    /// A fault that the model does without elsewhere.
    FaultNeeded {
        /// Of the fault.
        id: String,
    },
    /// A curve without a formula explains more than the law, whose form may be another.
    WrongForm {
        /// The curve, as an effect.
        curve: String,
        /// Share that it explains of the error above the noise, of both records.
        share: f64,
        /// Whether that is as much as an effect has to explain.
        is_refuted: bool,
    },
}

/// Whether an uncertain value so many standard deviations from where it was known to be stands at the end of its search, but for the digits
/// of a fit.
pub(super) fn ends_its_search(deviations: f64, rig: &Rig) -> bool {
    deviations > 0.999 * rig.settings().diagnosis.search_reach
}

impl Warning {
    /// Whether the model makes no physical sense as it is fitted: a value that nobody would believe, a size at the end of its
    /// search, or a law of another form than the record shows; what only shapes an effect may end there.
    pub fn is_senseless(&self) -> bool {
        match self {
            Self::AtBound { is_size, .. } => *is_size,
            Self::Implausible { .. } => true,
            Self::WrongForm { is_refuted, .. } => *is_refuted,
            Self::Moved { .. } | Self::FaultNeeded { .. } => false,
        }
    }

    /// Whether something that was known before stands at the end of its search: the model leans on it for physics that it lacks.
    pub fn is_at_end(&self) -> bool {
        matches!(self, Self::Moved { at_end: true, .. })
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtBound { id, value, unit, .. } => write!(f, "at-bound: {id} = {value:.4} {unit}"),
            Self::Implausible { id, value, unit } => write!(f, "implausible: {id} = {value:.4} {unit}"),
            Self::Moved { id, deviations, at_end } => {
                let end = if *at_end { ", the end of its search" } else { "" };
                write!(f, "moved: {id} by {deviations:.1} standard uncertainties{end}")
            }
            Self::FaultNeeded { id } => write!(f, "fault: {id} is needed too"),
            Self::WrongForm { curve, share, .. } => {
                write!(f, "form: {curve} in its place explains {:.0} % of what it leaves", (100.0 * share).floor())
            }
        }
    }
}

/// Warnings in one line.
#[cfg(feature = "cli")]
pub fn joined(warnings: &[Warning]) -> String {
    warnings.iter().map(Warning::to_string).collect::<Vec<_>>().join("; ")
}

impl Serialize for Warning {
    /// As its text.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
