//! What the store keeps of a diagnosis.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Moment;
use crate::diagnosis::{Diagnosis, DiagnosisOptions, FaultReport};
use crate::record::Record;
use crate::rig::Rig;

/// Which rig a run is of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigIdentity {
    /// What the runs of one rig share: the name in the rig file, or its path where it has none, or its digest where the file is of one call.
    pub key: String,
    /// The path as given.
    pub path: String,
    /// The name in the rig file, which may be empty.
    pub name: String,
    /// SHA-256 of the rig file, in hexadecimal digits; where it names other files, of all their digests.
    pub digest: String,
}

impl RigIdentity {
    /// The identity of a rig.
    pub fn new(rig: &Rig) -> Self {
        let digest = rig.digest();
        let absolute = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let path = rig.context().name_of(&rig.path);
        let key = if !rig.name.is_empty() {
            Self::key_of(&rig.name)
        } else if path == rig.path {
            format!("file {}", absolute(&rig.path).display())
        } else {
            // A file of one call has another path in the next.
            format!("digest {digest}")
        };
        Self { key, path: path.display().to_string(), name: rig.name.clone(), digest }
    }

    /// The identity of a machine of this name that the same rig file describes.
    #[must_use]
    pub fn named(&self, name: &str) -> Self {
        Self { key: Self::key_of(name), name: name.to_owned(), ..self.clone() }
    }

    fn key_of(name: &str) -> String {
        format!("name {name}")
    }
}

/// Where the time of a run comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dated {
    /// The user gave it.
    Given,
    /// When the record was last written to.
    File,
    /// The diagnosis itself, of a record that came through a pipe.
    Diagnosis,
}

impl Dated {
    /// The word in the store.
    pub fn word(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::File => "file",
            Self::Diagnosis => "diagnosis",
        }
    }
}

/// A diagnosis to be kept.
#[derive(Debug, Clone)]
pub struct NewRun<'a> {
    /// The rig that was diagnosed.
    #[doc(hidden)]
    pub rig: &'a RigIdentity,
    /// SHA-256 of the record's file, in hexadecimal digits.
    #[doc(hidden)]
    pub record_digest: &'a str,
    /// When the record was measured.
    #[doc(hidden)]
    pub measured_at: Moment,
    /// When the record was measured, and how that is known.
    #[doc(hidden)]
    pub dated: Dated,
    /// When it was diagnosed.
    #[doc(hidden)]
    pub diagnosed_at: Moment,
    /// With which it was diagnosed.
    #[doc(hidden)]
    pub options: &'a DiagnosisOptions,
    /// The result.
    #[doc(hidden)]
    pub diagnosis: &'a Diagnosis,
}

impl<'a> NewRun<'a> {
    /// A run that ends now. Without a time given, it is that of the record's file, or now where it came through a pipe.
    pub fn now(
        rig: &'a RigIdentity,
        record: &'a Record,
        given: Option<Moment>,
        options: &'a DiagnosisOptions,
        diagnosis: &'a Diagnosis,
    ) -> Self {
        let diagnosed_at = Moment::now();
        let file = record.origin.modified.and_then(Moment::of_system);
        let (measured_at, dated) = match (given, file) {
            (Some(given), _) => (given, Dated::Given),
            (None, Some(file)) => (file, Dated::File),
            (None, None) => (diagnosed_at, Dated::Diagnosis),
        };
        Self { rig, record_digest: &record.origin.digest, measured_at, dated, diagnosed_at, options, diagnosis }
    }
}

/// A run as the store has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct StoredRun {
    /// Number of the run, rising in the order of storing.
    pub id: i64,
    /// Path of the rig file, as the user named it.
    pub rig: String,
    /// Name of the rig; empty without.
    pub rig_name: String,
    /// SHA-256 of the rig file.
    pub rig_digest: String,
    /// The record, as the user named it.
    pub record: String,
    /// SHA-256 of the record.
    pub record_digest: String,
    /// When the record was measured.
    #[cfg_attr(feature = "internals", schemars(with = "String"))]
    pub measured_at: Moment,
    /// Where `measured_at` comes from: `given`, `file` or `diagnosis`.
    pub dated_by: String,
    /// When it was diagnosed.
    #[cfg_attr(feature = "internals", schemars(with = "String"))]
    pub diagnosed_at: Moment,
    /// The word of the verdict.
    pub verdict: String,
    /// Of the fit; `None` where there is none.
    pub chi2_reduced: Option<f64>,
    /// Version of the program, whose laws the model is made of.
    pub model_version: String,
    /// As JSON.
    pub options: String,
    /// Every fault of the rig, in its order.
    pub faults: Vec<StoredFault>,
}

impl StoredRun {
    /// What is kept of a run that has no number yet.
    pub fn of(run: &NewRun<'_>) -> Self {
        let diagnosis = run.diagnosis;
        Self {
            id: 0,
            rig: run.rig.path.clone(),
            rig_name: run.rig.name.clone(),
            rig_digest: run.rig.digest.clone(),
            record: diagnosis.record.clone(),
            record_digest: run.record_digest.to_owned(),
            measured_at: run.measured_at,
            dated_by: run.dated.word().to_owned(),
            diagnosed_at: run.diagnosed_at,
            verdict: diagnosis.verdict.word().to_owned(),
            chi2_reduced: finite(diagnosis.fit.chi2_reduced),
            model_version: env!("CARGO_PKG_VERSION").to_owned(),
            options: options(run.options),
            faults: diagnosis.faults.iter().map(StoredFault::of).collect(),
        }
    }
}

/// The options, each with its unit in its name.
fn options(options: &DiagnosisOptions) -> String {
    let detection = &options.detection;
    serde_json::json!({
        "hours_between_false_alarms": detection.hours_between_false_alarms,
        "window_s": detection.window,
        "shift": detection.shift,
        "coverage": detection.coverage,
    })
    .to_string()
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// What a run says about one fault. Numbers in `unit`; `None` where there was no finite one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct StoredFault {
    /// The parameter that it changes.
    pub id: String,
    /// Of all its numbers.
    pub unit: String,
    /// Estimate; `None` where there is none.
    pub value: Option<f64>,
    /// Ends of the 95 % interval; `None` where the record does not bound the value.
    pub low: Option<f64>,
    /// Upper end of the 95 % interval; `None` where it is open.
    pub high: Option<f64>,
    /// Healthy value.
    pub healthy: Option<f64>,
    /// Whether it is there.
    pub present: bool,
    /// Of its being there.
    pub probability: Option<f64>,
    /// `bounded`, `lower-bound-only`, `upper-bound-only` or `unidentifiable`.
    pub identifiable: String,
    /// Whether the model missed something, so that the value may be off by more than its interval.
    pub biased: bool,
    /// From which value on the part no longer serves; `None` where the rig file did not say, or the run was kept before version 2 of
    /// the tables.
    pub limit: Option<f64>,
    /// Ends of the range that was searched; `None` of a run that was kept before version 2 of the tables.
    pub lower_bound: Option<f64>,
    /// The upper end.
    pub upper_bound: Option<f64>,
}

impl StoredFault {
    fn of(fault: &FaultReport) -> Self {
        let [low, high] = fault.ci95;
        Self {
            id: fault.id.clone(),
            unit: fault.unit.clone(),
            value: finite(fault.value),
            low: low.and_then(finite),
            high: high.and_then(finite),
            healthy: finite(fault.healthy),
            present: fault.present,
            probability: finite(fault.probability),
            identifiable: fault.identifiable.to_string(),
            biased: fault.biased,
            limit: fault.limit.and_then(finite),
            lower_bound: finite(fault.bounds[0]),
            upper_bound: finite(fault.bounds[1]),
        }
    }
}
