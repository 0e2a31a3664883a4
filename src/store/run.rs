//! What the store keeps of a diagnosis.

use std::path::Path;

use super::Moment;
use crate::diagnosis::{Diagnosis, DiagnosisOptions};
use crate::record::Record;
use crate::rig::Rig;

/// Which rig a run is of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigIdentity {
    /// What the runs of one rig share: the name in the rig file, or its path where it has none.
    pub key: String,
    /// The path as given.
    pub path: String,
    /// The name in the rig file, which may be empty.
    pub name: String,
    /// SHA-256 of the rig file, in hexadecimal digits.
    pub digest: String,
}

impl RigIdentity {
    /// The identity of a rig whose file has this digest.
    pub fn new(rig: &Rig, digest: String) -> Self {
        let absolute = |path: &Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let key = if rig.name.is_empty() {
            format!("file {}", absolute(&rig.path).display())
        } else {
            format!("name {}", rig.name)
        };
        Self { key, path: rig.path.display().to_string(), name: rig.name.clone(), digest }
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
#[derive(Debug, Clone, PartialEq)]
pub struct StoredRun {
    /// Number of the run, rising in the order of storing.
    pub id: i64,
    /// Key of the rig.
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
    pub measured_at: Moment,
    /// Where `measured_at` comes from: `given`, `file` or `diagnosis`.
    pub dated_by: String,
    /// When it was diagnosed.
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

/// What a run says about one fault. Numbers in `unit`; `None` where there was no finite one.
#[derive(Debug, Clone, PartialEq)]
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
}
