//! Runs out of the store.

use rusqlite::types::Type;
use rusqlite::{Error, Row, params};

use super::{Moment, Store, StoredFault, StoredRun};
use crate::complaint::Complaint;

const RUN: &str = "SELECT id, rig, rig_name, rig_digest, record, record_digest, measured_at, dated_by, diagnosed_at, \
                   verdict, chi2_reduced, model_version, options FROM run";

impl Store {
    /// Every run, in the order of their times; of equal times, in the order of storing.
    ///
    /// # Errors
    /// A store that is damaged.
    pub fn runs(&self) -> Result<Vec<StoredRun>, Complaint> {
        self.patiently(|| self.select("?1 IS NULL", None).map_err(|error| self.failed(&error)))
    }

    /// The runs of the rig with this key, in the same order.
    ///
    /// # Errors
    /// A store that is damaged.
    pub fn runs_of(&self, key: &str) -> Result<Vec<StoredRun>, Complaint> {
        self.patiently(|| self.select("rig_key = ?1", Some(key)).map_err(|error| self.failed(&error)))
    }

    /// Names of the rigs that have runs, without repetition; of a rig without name its path.
    ///
    /// # Errors
    /// A store that is damaged.
    pub fn rigs(&self) -> Result<Vec<String>, Complaint> {
        let rigs = || -> Result<Vec<String>, Error> {
            let mut statement = self.connection.prepare("SELECT DISTINCT rig_key FROM run ORDER BY rig_key")?;
            let keys = statement.query_map([], |row| row.get::<_, String>(0))?;
            keys.collect()
        };
        let keys = rigs().map_err(|error| self.failed(&error))?;
        Ok(keys.into_iter().map(|key| key.split_once(' ').map_or_else(String::new, |(_, name)| name.into())).collect())
    }

    /// The time that a user gave to the record with this digest; the latest of several.
    ///
    /// # Errors
    /// A store that is damaged.
    pub fn time_given(&self, record_digest: &str) -> Result<Option<Moment>, Complaint> {
        let found = self.connection.query_row(
            "SELECT measured_at FROM run WHERE record_digest = ?1 AND dated_by = 'given' ORDER BY id DESC LIMIT 1",
            params![record_digest],
            |row| moment(row, 0),
        );
        match found {
            Ok(moment) => Ok(Some(moment)),
            Err(Error::QueryReturnedNoRows) => Ok(None),
            Err(error) => Err(self.failed(&error)),
        }
    }

    /// Whether SQLite finds every page and index of the file in order.
    ///
    /// # Errors
    /// A store that cannot be read.
    pub fn is_sound(&self) -> Result<bool, Complaint> {
        let answer = self.connection.query_row("PRAGMA integrity_check", [], |row| row.get::<_, String>(0));
        answer.map(|answer| answer == "ok").map_err(|error| self.failed(&error))
    }

    fn select(&self, which: &str, key: Option<&str>) -> Result<Vec<StoredRun>, Error> {
        // One snapshot, so that a run that is added meanwhile comes with its faults or not at all.
        let transaction = self.connection.unchecked_transaction()?;
        let mut statement = transaction.prepare(&format!("{RUN} WHERE {which} ORDER BY measured_at, id"))?;
        let mut runs = statement.query_map(params![key], run)?.collect::<Result<Vec<_>, _>>()?;
        let mut statement = transaction.prepare(
            "SELECT id, unit, value, low, high, healthy, present, probability, identifiable, biased, \
             limit_value, lower_bound, upper_bound FROM fault \
             WHERE run = ?1 ORDER BY position",
        )?;
        for run in &mut runs {
            run.faults = statement.query_map(params![run.id], fault)?.collect::<Result<Vec<_>, _>>()?;
        }
        Ok(runs)
    }
}

fn run(row: &Row<'_>) -> Result<StoredRun, Error> {
    Ok(StoredRun {
        id: row.get(0)?,
        rig: row.get(1)?,
        rig_name: row.get(2)?,
        rig_digest: row.get(3)?,
        record: row.get(4)?,
        record_digest: row.get(5)?,
        measured_at: moment(row, 6)?,
        dated_by: row.get(7)?,
        diagnosed_at: moment(row, 8)?,
        verdict: row.get(9)?,
        chi2_reduced: row.get(10)?,
        model_version: row.get(11)?,
        options: row.get(12)?,
        faults: Vec::new(),
    })
}

fn moment(row: &Row<'_>, column: usize) -> Result<Moment, Error> {
    let text: String = row.get(column)?;
    text.parse()
        .map_err(|complaint: Complaint| Error::FromSqlConversionFailure(column, Type::Text, complaint.what.into()))
}

fn fault(row: &Row<'_>) -> Result<StoredFault, Error> {
    Ok(StoredFault {
        id: row.get(0)?,
        unit: row.get(1)?,
        value: row.get(2)?,
        low: row.get(3)?,
        high: row.get(4)?,
        healthy: row.get(5)?,
        present: row.get(6)?,
        probability: row.get(7)?,
        identifiable: row.get(8)?,
        biased: row.get(9)?,
        limit: row.get(10)?,
        lower_bound: row.get(11)?,
        upper_bound: row.get(12)?,
    })
}
