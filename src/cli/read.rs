//! Records as the verbs take them: what was recognised of an unusual file is told.

use std::fs;
use std::path::Path;

use super::terminal::note;
use crate::complaint::Complaint;
use crate::record::Record;
use crate::rig::Rig;

/// Says on standard error where a check record is the record that it is to check.
pub fn not_itself(fit: &Path, check: &Path) {
    if fs::canonicalize(fit).is_ok_and(|fit| fs::canonicalize(check).is_ok_and(|check| check == fit)) {
        note(format_args!("warning: {}: the check record is the fit record, and checks nothing", check.display()));
    }
}

/// Says on standard error what is doubtful in a rig file.
pub fn doubts_of(rig: &Rig) {
    for doubt in rig.doubts() {
        note(format_args!("warning: {doubt}"));
    }
}

/// Reads a record of a rig; how, is said on standard error where it is in another form than records are written in.
pub fn record(rig: &Rig, path: &Path) -> Result<Record, Complaint> {
    rig.context().check()?;
    rig.context().stage("reading the record");
    let mut record = rig.record(path)?;
    record.path = rig.context().name_of(path);
    let path = &record.path;
    if !record.origin.is_plain() {
        note(format_args!("note: {}: read as {}", path.display(), record.origin.read_as));
    }
    for gap in record.gaps().iter().filter(|gap| rig.reads(&gap.channel)) {
        let held = rig.inputs.iter().any(|input| input.column == gap.channel);
        let what = if held { "there it acts as its `hold` says" } else { "left out of the fit" };
        note(format_args!("note: {}: {gap}; {what}", path.display()));
    }
    for odd in rig.at_odds(&record) {
        note(format_args!("note: {}: {odd}", path.display()));
    }
    Ok(record)
}

/// The same of a record that is fitted to, with a note where its samples are too few to contradict a model.
pub fn fitted(rig: &Rig, path: &Path) -> Result<Record, Complaint> {
    let record = record(rig, path)?;
    if let Some(few) = rig.few_samples(&record) {
        note(format_args!("note: {}: {few}", record.path.display()));
    }
    Ok(record)
}
