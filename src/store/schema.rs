//! The tables, and the marks by which a file is known as a store.

use rusqlite::TransactionBehavior;

use super::{Store, no_store};
use crate::complaint::{Complaint, Kind};

/// `bore`, in the header of the file.
const APPLICATION: i64 = 0x626F_7265;
/// Version of the tables.
const VERSION: i64 = 2;

const TABLES: &str = "
CREATE TABLE run (
    id INTEGER PRIMARY KEY,
    rig_key TEXT NOT NULL,
    rig TEXT NOT NULL,
    rig_name TEXT NOT NULL,
    rig_digest TEXT NOT NULL,
    record TEXT NOT NULL,
    record_digest TEXT NOT NULL,
    measured_at TEXT NOT NULL,
    dated_by TEXT NOT NULL,
    diagnosed_at TEXT NOT NULL,
    verdict TEXT NOT NULL,
    chi2_reduced REAL,
    model_version TEXT NOT NULL,
    options TEXT NOT NULL,
    diagnosis TEXT NOT NULL
) STRICT;
CREATE TABLE fault (
    run INTEGER NOT NULL REFERENCES run (id) ON DELETE CASCADE,
    position INTEGER NOT NULL,
    id TEXT NOT NULL,
    unit TEXT NOT NULL,
    value REAL,
    low REAL,
    high REAL,
    healthy REAL,
    present INTEGER NOT NULL,
    probability REAL,
    identifiable TEXT NOT NULL,
    biased INTEGER NOT NULL,
    limit_value REAL,
    lower_bound REAL,
    upper_bound REAL,
    PRIMARY KEY (run, position)
) STRICT, WITHOUT ROWID;
CREATE INDEX run_of_rig ON run (rig_key, measured_at);
";

/// What version 2 has beyond version 1.
const SINCE_1: &str = "
ALTER TABLE fault ADD COLUMN limit_value REAL;
ALTER TABLE fault ADD COLUMN lower_bound REAL;
ALTER TABLE fault ADD COLUMN upper_bound REAL;
";

/// Makes the tables where there are none, and refuses what is no store.
pub(super) fn prepare(store: &Store) -> Result<(), Complaint> {
    let failed = |error| store.failed(&error);
    if is_empty(store).map_err(failed)? {
        // Another process may make the tables at the same time: look again under the lock.
        let transaction = rusqlite::Transaction::new_unchecked(&store.connection, TransactionBehavior::Immediate);
        let transaction = transaction.map_err(failed)?;
        if is_empty(store).map_err(failed)? {
            transaction.execute_batch(TABLES).map_err(failed)?;
            transaction.pragma_update(None, "application_id", APPLICATION).map_err(failed)?;
            transaction.pragma_update(None, "user_version", VERSION).map_err(failed)?;
        }
        transaction.commit().map_err(failed)?;
    }
    check(store)
}

/// Refuses what is no store, and stores of a newer version; one of the version before gets the columns that it lacks.
pub(super) fn check(store: &Store) -> Result<(), Complaint> {
    let failed = |error| store.failed(&error);
    let empty = is_empty(store).map_err(failed)?;
    let pragma = |name: &str| store.connection.pragma_query_value(None, name, |row| row.get::<_, i64>(0));
    let application = pragma("application_id").map_err(failed)?;
    if empty || application != APPLICATION {
        return Err(no_store(&store.path));
    }
    let version = || pragma("user_version").map_err(failed);
    if version()? == 1 {
        let transaction = rusqlite::Transaction::new_unchecked(&store.connection, TransactionBehavior::Immediate);
        let transaction = transaction.map_err(failed)?;
        // Another process may have done it meanwhile.
        if version()? == 1 {
            transaction.execute_batch(SINCE_1).map_err(failed)?;
            transaction.pragma_update(None, "user_version", VERSION).map_err(failed)?;
        }
        transaction.commit().map_err(failed)?;
    }
    let version = version()?;
    if version != VERSION {
        return Err(Complaint::new(Kind::Contradiction, format!("the store has version {version} of its tables"))
            .in_file(&store.path)
            .help(format!("this borescope knows version {VERSION}; use the one that made the store")));
    }
    Ok(())
}

fn is_empty(store: &Store) -> Result<bool, rusqlite::Error> {
    store.connection.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get::<_, i64>(0)).map(|n| n == 0)
}
