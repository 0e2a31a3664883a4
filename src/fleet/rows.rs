//! What diagnosing the records of a manifest leaves: a journal that grows record by record, and tables.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::manifest::{Entry, Manifest};
use crate::complaint::{Complaint, Kind};
use crate::diagnosis::DiagnosisOptions;
use crate::files::{self, write_atomically};
use crate::learn::behind::diagnose;
use crate::model::Model;
use crate::shards::{Form, Numbered};
use crate::store::{Kept, NewRun, RigIdentity, StoredRun, export_csv, plain_cell};

/// Name of the table of a shard: a row for each fault of each record.
pub const FAULTS: &str = "faults.csv";
/// Name of the table of records without a diagnosis.
pub const FAILURES: &str = "failures.csv";

/// Diagnosing a manifest, as it is done in shards.
pub const FORM: Form = Form {
    journal: "borescope.diagnosis-journal/1",
    done: "borescope.diagnosis-shard/1",
    whole: "a list of records",
    row: "record",
};

/// Which work a shard is of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Work {
    /// Path of the rig file, as the user named it.
    pub rig: String,
    /// Path of the manifest, as the user named it.
    pub manifest: String,
    /// How many records it has.
    pub records: usize,
}

/// What tells two works apart: the rig file, the manifest, the options and the version of this crate, hashed.
pub fn digest(rig_digest: &str, manifest: &Manifest, options: &DiagnosisOptions) -> String {
    let version = env!("CARGO_PKG_VERSION");
    files::digest(format!("{version} {rig_digest} {} {options:?}", manifest.digest).as_bytes())
}

/// One record of the manifest.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    /// Its place in the manifest, from 0.
    pub number: usize,
    /// The path, as the manifest leads to it.
    pub record: String,
    pub outcome: Outcome,
}

/// What became of a record.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    Diagnosed(Box<Kept>),
    /// Why there is no diagnosis.
    Failed(Failure),
}

/// Why a record has no diagnosis.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Failure {
    /// What is wrong, and where.
    pub what: String,
    /// What would be right.
    pub help: Option<String>,
}

impl Failure {
    fn of(complaint: Complaint) -> Self {
        let help = complaint.help.clone();
        let what = Complaint { help: None, ..complaint }.to_string();
        Self { what: what.trim_start_matches("error: ").to_owned(), help }
    }

    /// As standard error has it.
    pub fn complaint(&self) -> Complaint {
        let complaint = Complaint::new(Kind::Computation, &self.what);
        Complaint { help: self.help.clone(), ..complaint }
    }
}

impl Numbered for Row {
    fn number(&self) -> usize {
        self.number
    }
}

impl Row {
    /// Diagnoses a record; one that cannot be read or fitted is a row too.
    pub fn new(model: &Model, rig: &RigIdentity, number: usize, entry: &Entry) -> Self {
        let outcome = Self::kept(model, rig, entry).map_or_else(
            |complaint| Outcome::Failed(Failure::of(complaint)),
            |kept| Outcome::Diagnosed(Box::new(kept)),
        );
        Self { number, record: entry.record.display().to_string(), outcome }
    }

    fn kept(model: &Model, rig: &RigIdentity, entry: &Entry) -> Result<Kept, Complaint> {
        let record = model.rig.record(&entry.record)?;
        let options = DiagnosisOptions::default();
        let diagnosis = diagnose(model, &record, &options)?.diagnosis;
        let rig = entry.rig.as_ref().map_or_else(|| rig.clone(), |name| rig.named(name));
        Kept::new(&NewRun::now(&rig, &record, entry.measured_at, &options, &diagnosis))
    }

    /// What the store keeps of it.
    pub fn diagnosed(&self) -> Option<&Kept> {
        match &self.outcome {
            Outcome::Diagnosed(kept) => Some(kept),
            Outcome::Failed(_) => None,
        }
    }
}

/// How many records came to what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Counts {
    /// All of them.
    pub records: usize,
    /// Records without one.
    pub healthy: usize,
    /// Records with a fault.
    pub faulty: usize,
    /// Records that the model does not explain.
    pub model_inadequate: usize,
    /// Without a diagnosis.
    pub failed: usize,
}

impl Counts {
    pub fn of(rows: &[Row]) -> Self {
        let mut counts = Self::default();
        rows.iter().for_each(|row| counts.add(row));
        counts
    }

    /// Counts one more.
    pub fn add(&mut self, row: &Row) {
        self.records += 1;
        *match row.diagnosed().map(|kept| kept.run.verdict.as_str()) {
            None => &mut self.failed,
            Some("healthy") => &mut self.healthy,
            Some("faulty") => &mut self.faulty,
            Some(_) => &mut self.model_inadequate,
        } += 1;
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { records, healthy, faulty, model_inadequate, failed } = self;
        let plural = if *records == 1 { "" } else { "s" };
        write!(f, "{records} record{plural}: {healthy} healthy, {faulty} faulty, {model_inadequate} model inadequate")?;
        if *failed > 0 {
            write!(f, ", {failed} without a diagnosis")?;
        }
        Ok(())
    }
}

/// The runs of a merged work, numbered by their place in the manifest, from 1.
pub fn runs(rows: &[Row]) -> Vec<StoredRun> {
    let run = |row: &Row| Some(StoredRun { id: row.number as i64 + 1, ..row.diagnosed()?.run.clone() });
    rows.iter().filter_map(run).collect()
}

/// Writes both tables into a folder; the one of failures only where there are any.
///
/// # Errors
/// Files that cannot be written.
pub fn write_tables(folder: &Path, rows: &[Row]) -> Result<(), Complaint> {
    write_atomically(&folder.join(FAULTS), |file| export_csv(&runs(rows), file))?;
    if failures(rows).next().is_none() {
        return Ok(());
    }
    write_atomically(&folder.join(FAILURES), |file| {
        let mut table = csv::Writer::from_writer(file);
        table.write_record(["record", "failure", "help"])?;
        for (record, Failure { what, help }) in failures(rows) {
            table.write_record([record, what, help.as_deref().unwrap_or_default()].map(plain_cell))?;
        }
        table.flush()
    })
}

/// Records without a diagnosis, each with the reason.
pub fn failures(rows: &[Row]) -> impl Iterator<Item = (&str, &Failure)> {
    rows.iter().filter_map(|row| match &row.outcome {
        Outcome::Failed(why) => Some((row.record.as_str(), why)),
        Outcome::Diagnosed(_) => None,
    })
}
