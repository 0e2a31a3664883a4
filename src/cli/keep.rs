//! `diagnose --store`: what keeps the diagnoses.

use std::path::{Path, PathBuf};

use super::terminal::note;
use crate::complaint::{Complaint, Kind};
use crate::diagnosis::{Diagnosis, DiagnosisOptions};
use crate::files::check_folder;
use crate::record::Record;
use crate::rig::Rig;
use crate::store::{Dated, Moment, NewRun, RigIdentity, Store, check_name};

/// Says on standard error that a store is held by another program.
pub fn waiting(store: &Path) {
    note(format_args!("note: {}: another program holds the store; waiting for it", store.display()));
}

/// An open store, and the rig whose runs it gets.
pub struct Keeper {
    /// `None` until the first run, where there is no such file yet.
    store: Option<Store>,
    path: PathBuf,
    rig: RigIdentity,
    at: Option<Moment>,
}

impl Keeper {
    /// Opens the store before long work is done for it, or makes sure that it can be made; `at` is the time that the user gives
    /// to the only one of `records`.
    pub fn open(store: Option<&Path>, at: Option<&str>, records: usize, rig: &Rig) -> Result<Option<Self>, Complaint> {
        let at = at
            .map(str::parse::<Moment>)
            .transpose()
            .map_err(|complaint| Complaint { what: format!("`--at`: {}", complaint.what), ..complaint })?;
        let Some(path) = store else {
            return match at {
                None => Ok(None),
                Some(_) => Err(Complaint::new(Kind::MissingEntry, "`--at` without `--store`")
                    .help("the time is kept with the diagnosis: name a store with `--store FILE`")),
            };
        };
        if at.is_some() && records > 1 {
            return Err(Complaint::new(Kind::Contradiction, "`--at` with more than one record")
                .help("call `diagnose` once for each, or leave `--at` away: each then has the time of its file"));
        }
        check_folder(path)?;
        check_name(path)?;
        let store = path.exists().then(|| Store::open_telling(path, waiting)).transpose()?;
        Ok(Some(Self { store, path: path.to_path_buf(), rig: RigIdentity::new(rig), at }))
    }

    /// Keeps a diagnosis, and says on standard error under which number and time.
    pub fn keep(
        &mut self,
        record: &Record,
        options: &DiagnosisOptions,
        diagnosis: &Diagnosis,
    ) -> Result<(), Complaint> {
        let store = match &mut self.store {
            Some(store) => store,
            none => none.insert(Store::open_telling(&self.path, waiting)?),
        };
        let before = match self.at {
            None => store.time_given(&record.origin.digest)?,
            Some(_) => None,
        };
        let run = NewRun::now(&self.rig, record, self.at.or(before), options, diagnosis);
        let number = store.add(&run)?;
        let dated = match run.dated {
            Dated::Given if before.is_some() => "as stated before with `--at`; `--at` changes it",
            Dated::Given => "stated with `--at`",
            Dated::File => "the time of the record's file; `--at` gives another",
            Dated::Diagnosis => "the time of the diagnosis; `--at` gives another",
        };
        note(format_args!(
            "note: {}: kept in {} as run {number}, measured {} ({dated})",
            diagnosis.record,
            self.path.display(),
            run.measured_at.short()
        ));
        Ok(())
    }
}
