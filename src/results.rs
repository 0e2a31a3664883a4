//! What the verbs give, and its parts. Where the command prints JSON, its keys are the names of the fields.

pub use crate::calibration::{CalibratedDynamics, CalibratedParameter, CalibratedSensor, CalibrationReport};
pub use crate::campaign::score::{Group, Scores};
pub use crate::campaign::statistics::Rate;
pub use crate::campaign::{FaultRow, Outcome, Row};
pub use crate::check::{
    ChannelLine, CheckReport, FaultLine, InputLine, ParameterLine, RecordPage, RigPage, SensorLine,
};
pub use crate::diagnosis::watch::{Episode, WatchedVerdict};
pub use crate::diagnosis::{
    ChannelReport, CommonCause, DynamicsReport, FaultReport, FitReport, FittedReport, Hypothesis, MissingEffect,
    OffDataSheet, OffSheetValue, ProfileReport, RivalEffect, UncertainReport,
};
pub use crate::estimation::Identifiable;
#[cfg(feature = "store")]
pub use crate::history::forecast::State as ForecastState;
#[cfg(feature = "store")]
pub use crate::history::{Axis, FaultHistory, Forecast, RunValue, Trend};
pub use crate::isolability::{AssumedFault, Expectation, ExpectedWidth, IsolabilityReport};
pub use crate::learn::comparison::{
    AsStated, ChannelComparison, Comparison, Correlation, FittedParameter, MisfitPlace, MissedPhase, PresentFault,
    WithFaults,
};
pub use crate::learn::improve::ImprovementStep;
pub use crate::learn::result::{CandidateReport, EffectParameter, ScoredReport, SuggestionReport};
pub use crate::learn::separate::Experiment;
pub use crate::learn::warning::Warning;
pub use crate::model::BelowVacuum;
pub use crate::record::survey::Finding;
pub use crate::residual::ResidualReport;
#[cfg(feature = "store")]
pub use crate::store::StoredFault;
pub use crate::structure::{FaultPair, Isolability, StructuralTest};
