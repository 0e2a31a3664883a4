//! Records as the verbs take them: what was recognised of an unusual file is told.

use std::path::Path;

use super::terminal::note;
use crate::complaint::Complaint;
use crate::record::Record;
use crate::rig::Rig;

/// Reads a record of a rig; how, is said on standard error where it is in another form than records are written in.
pub fn record(rig: &Rig, path: &Path) -> Result<Record, Complaint> {
    let record = rig.record(path)?;
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
