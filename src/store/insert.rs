//! A diagnosis into the store: whole or not at all.

use rusqlite::{Transaction, TransactionBehavior, params};

use super::{NewRun, Store};
use crate::complaint::{Complaint, Kind};
use crate::diagnosis::{DiagnosisOptions, FaultReport};

impl Store {
    /// Keeps a diagnosis; gives the number of the run.
    ///
    /// # Errors
    /// A store that cannot be written, or that another process does not let go of for a minute.
    pub fn add(&self, run: &NewRun<'_>) -> Result<i64, Complaint> {
        let diagnosis = serde_json::to_string(run.diagnosis).map_err(|error| {
            Complaint::new(Kind::Computation, format!("the diagnosis cannot be written as JSON: {error}"))
        })?;
        self.patiently(|| self.insert(run, &diagnosis).map_err(|error| self.failed(&error)))
    }

    fn insert(&self, run: &NewRun<'_>, json: &str) -> Result<i64, rusqlite::Error> {
        // The lock is taken at once: a reader that wants to write later may not wait for another of its kind.
        let transaction = Transaction::new_unchecked(&self.connection, TransactionBehavior::Immediate)?;
        let diagnosis = run.diagnosis;
        transaction.execute(
            "INSERT INTO run (rig_key, rig, rig_name, rig_digest, record, record_digest, measured_at, dated_by, \
             diagnosed_at, verdict, chi2_reduced, model_version, options, diagnosis) \
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)",
            params![
                run.rig.key,
                run.rig.path,
                run.rig.name,
                run.rig.digest,
                diagnosis.record,
                run.record_digest,
                run.measured_at.to_string(),
                run.dated.word(),
                run.diagnosed_at.to_string(),
                diagnosis.verdict.word(),
                finite(diagnosis.fit.chi2_reduced),
                env!("CARGO_PKG_VERSION"),
                options(run.options),
                json,
            ],
        )?;
        let id = transaction.last_insert_rowid();
        for (position, fault) in diagnosis.faults.iter().enumerate() {
            insert_fault(&transaction, id, position, fault)?;
        }
        transaction.commit()?;
        Ok(id)
    }
}

fn insert_fault(
    transaction: &Transaction<'_>,
    run: i64,
    position: usize,
    fault: &FaultReport,
) -> Result<(), rusqlite::Error> {
    let mut statement = transaction.prepare(
        "INSERT INTO fault (run, position, id, unit, value, low, high, healthy, present, probability, identifiable, \
         biased) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)",
    )?;
    let [low, high] = fault.ci95;
    statement.execute(params![
        run,
        position as i64,
        fault.id,
        fault.unit,
        finite(fault.value),
        low.and_then(finite),
        high.and_then(finite),
        finite(fault.healthy),
        fault.present,
        finite(fault.probability),
        fault.identifiable.to_string(),
        fault.biased,
    ])?;
    Ok(())
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
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
