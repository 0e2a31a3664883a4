//! Diagnoses into the store: all that are given or none.

use rusqlite::{Transaction, TransactionBehavior, params};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use super::{NewRun, Store, StoredFault, StoredRun};
use crate::complaint::{Complaint, Kind};

/// A run on its way into a store, with what only the store itself has of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Kept {
    /// Its number is given by the store.
    pub run: StoredRun,
    /// What the runs of one rig share.
    pub rig_key: String,
    /// The whole diagnosis, as JSON.
    pub diagnosis: Box<RawValue>,
}

impl Kept {
    /// What is kept of a run.
    ///
    /// # Errors
    /// A diagnosis that cannot be written as JSON.
    pub fn new(run: &NewRun<'_>) -> Result<Self, Complaint> {
        let diagnosis = serde_json::value::to_raw_value(run.diagnosis).map_err(|error| {
            Complaint::new(Kind::Computation, format!("the diagnosis cannot be written as JSON: {error}"))
        })?;
        Ok(Self { run: StoredRun::of(run), rig_key: run.rig.key.clone(), diagnosis })
    }
}

impl Store {
    /// Keeps a diagnosis; gives the number of the run.
    ///
    /// # Errors
    /// A store that cannot be written, or that another process does not let go of for a minute.
    pub fn add(&self, run: &NewRun<'_>) -> Result<i64, Complaint> {
        let kept = Kept::new(run)?;
        self.patiently(|| self.transact(|transaction| insert(transaction, &kept)))
    }

    /// Keeps those of many diagnoses that it does not have; gives how many that were.
    ///
    /// # Errors
    /// As of [`add`](Self::add); then none is kept.
    pub fn add_new(&self, runs: &[&Kept]) -> Result<usize, Complaint> {
        self.patiently(|| {
            self.transact(|transaction| {
                let mut added = 0;
                for kept in runs {
                    if !is_there(transaction, kept)? {
                        insert(transaction, kept)?;
                        added += 1;
                    }
                }
                Ok(added)
            })
        })
    }

    fn transact<T>(&self, act: impl FnOnce(&Transaction<'_>) -> Result<T, rusqlite::Error>) -> Result<T, Complaint> {
        // The lock is taken at once: a reader that wants to write later may not wait for another of its kind.
        let done = || {
            let transaction = Transaction::new_unchecked(&self.connection, TransactionBehavior::Immediate)?;
            let done = act(&transaction)?;
            transaction.commit()?;
            Ok(done)
        };
        done().map_err(|error| self.failed(&error))
    }
}

/// Whether this very diagnosis is in the store.
fn is_there(transaction: &Transaction<'_>, kept: &Kept) -> Result<bool, rusqlite::Error> {
    let run = &kept.run;
    let mut statement = transaction.prepare(
        "SELECT 1 FROM run WHERE rig_key = ?1 AND measured_at = ?2 AND record = ?3 AND record_digest = ?4 \
         AND diagnosed_at = ?5",
    )?;
    let times = [run.measured_at, run.diagnosed_at].map(|moment| moment.to_string());
    statement.exists(params![kept.rig_key, times[0], run.record, run.record_digest, times[1]])
}

fn insert(transaction: &Transaction<'_>, kept: &Kept) -> Result<i64, rusqlite::Error> {
    let run = &kept.run;
    let mut statement = transaction.prepare(
        "INSERT INTO run (rig_key, rig, rig_name, rig_digest, record, record_digest, measured_at, dated_by, \
         diagnosed_at, verdict, chi2_reduced, model_version, options, diagnosis) \
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)",
    )?;
    statement.execute(params![
        kept.rig_key,
        run.rig,
        run.rig_name,
        run.rig_digest,
        run.record,
        run.record_digest,
        run.measured_at.to_string(),
        run.dated_by,
        run.diagnosed_at.to_string(),
        run.verdict,
        run.chi2_reduced,
        run.model_version,
        run.options,
        kept.diagnosis.get(),
    ])?;
    let id = transaction.last_insert_rowid();
    for (position, fault) in run.faults.iter().enumerate() {
        insert_fault(transaction, id, position, fault)?;
    }
    Ok(id)
}

fn insert_fault(
    transaction: &Transaction<'_>,
    run: i64,
    position: usize,
    fault: &StoredFault,
) -> Result<(), rusqlite::Error> {
    let mut statement = transaction.prepare(
        "INSERT INTO fault (run, position, id, unit, value, low, high, healthy, present, probability, identifiable, \
         biased, limit_value, lower_bound, upper_bound) \
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15)",
    )?;
    statement.execute(params![
        run,
        position as i64,
        fault.id,
        fault.unit,
        fault.value,
        fault.low,
        fault.high,
        fault.healthy,
        fault.present,
        fault.probability,
        fault.identifiable,
        fault.biased,
        fault.limit,
        fault.lower_bound,
        fault.upper_bound,
    ])?;
    Ok(())
}
