//! `diagnose --records` and `--merge`: the records of a list, in pieces that any number of processes do.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::diagnose_arguments::Arguments;
use super::keep;
use super::progress::Progress;
use super::{Failure, Format, Status, export, terminal, write_json};
use crate::complaint::{Complaint, Kind};
use crate::context::{Context, work_off};
use crate::diagnosis::DiagnosisOptions;
use crate::files::is_standard_output;
use crate::fleet::manifest::Manifest;
use crate::fleet::rows::{Counts, FORM, Failure as NotDiagnosed, Row, Work, digest, failures, runs, write_tables};
use crate::model::Model;
use crate::rig::Rig;
use crate::shards::{Done, Found, Hold, Journal, Share, merge, missing, put_in_order};
use crate::store::{Kept, RigIdentity, Store};

/// Records without a diagnosis that are named on standard error; the table has all.
const NAMED: usize = 20;
/// All records in one piece.
const WHOLE: Share = Share { index: 1, of: 1 };

/// Does one shard of the records of a manifest, or says that it is done.
pub fn run(manifest: &Path, arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let (Some(rig), Some(work)) = (&arguments.rig, &arguments.output) else {
        // The command line asks for both.
        return Err(Complaint::new(Kind::MissingEntry, "`--records` needs a rig file and `-o DIR`").into());
    };
    if work.is_file() {
        return Err(Complaint::new(Kind::Contradiction, "this is a file, and `--records` fills a folder")
            .in_file(work)
            .help("name a folder; `borescope diagnose --merge DIR -o TABLE.csv` makes a table of it")
            .into());
    }
    let context = context.clone().without_progress();
    let threads = context.threads();
    let rig = Rig::read(rig)?.with_context(&context);
    let manifest = Manifest::read(manifest)?;
    if !manifest.unread.is_empty() {
        let columns = manifest.unread.join("`, `");
        terminal::note(format_args!("note: {}: columns that say nothing here: `{columns}`", manifest.path.display()));
    }
    let digest = digest(&rig.digest(), &manifest, &DiagnosisOptions::default());
    let shard = arguments.shard.unwrap_or(WHOLE);
    let folder = shard.folder(work);
    let say = |done: &Done<Work>, how: &str, counts: Option<Counts>, out: &mut dyn Write| -> std::io::Result<()> {
        match arguments.format {
            Format::Json => write_json(out, done),
            Format::Text => {
                let counts = counts.map_or_else(|| format!("{} records", done.count), |counts| counts.to_string());
                writeln!(out, "{}: shard {}, {how}; {counts}", folder.display(), done.shard)
            }
        }
    };
    let hold = Hold { context: &context, waiting: super::waiting };
    let (mut journal, mut rows) = match Found::of(&folder, &FORM, &digest, shard, &hold)? {
        Found::Done(done, by) => {
            say(&done, by, None, out)?;
            return Ok(Status::Done);
        }
        Found::Open(journal, rows) => (journal, rows),
    };
    let range = shard.range(manifest.entries.len());
    let identity = RigIdentity::new(&rig);
    let model = Model::new(rig);
    diagnose(&model, &identity, &manifest, range.clone(), &mut rows, (threads, &mut journal))?;
    write_tables(&folder, &rows)?;
    let whole = Work {
        rig: model.rig.path.display().to_string(),
        manifest: manifest.path.display().to_string(),
        records: manifest.entries.len(),
    };
    let done = Done::new(&FORM, &digest, shard, range, whole);
    done.write(&folder)?;
    let counts = Counts::of(&rows);
    say(&done, "done", Some(counts), out)?;
    if counts.failed > 0 {
        return Err(Failure::Complaints(failures(&rows).take(NAMED).map(|(_, why)| why.complaint()).collect()));
    }
    let found = counts.faulty + counts.model_inadequate > 0;
    Ok(if arguments.exit_code && found { Status::Found } else { Status::Done })
}

/// Diagnoses those records of the range that `rows` does not have, and adds each to it and to the journal; in the end they are in order.
fn diagnose(
    model: &Model,
    identity: &RigIdentity,
    manifest: &Manifest,
    range: std::ops::Range<usize>,
    rows: &mut Vec<Row>,
    (threads, journal): (usize, &mut Journal),
) -> Result<(), Complaint> {
    let todo = missing(range, rows);
    let mut counts = Counts::of(rows);
    let mut progress = Progress::new("records", rows.len(), todo.len());
    let each = |&number: &usize| Some(Row::new(model, identity, number, &manifest.entries[number]));
    let ran = work_off(&todo, threads, model.rig.context(), each, |row| {
        journal.add(&row)?;
        counts.add(&row);
        let Counts { faulty, failed, .. } = counts;
        progress.show(format_args!("{faulty} faulty, {failed} without a diagnosis"));
        rows.push(row);
        Ok(())
    });
    progress.end();
    put_in_order(rows);
    ran
}

/// What the records of a manifest came to, as programs read it.
#[derive(Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub(super) struct Merged<'a> {
    schema: &'static str,
    #[serde(flatten)]
    work: &'a Work,
    /// How many records came to what.
    counts: Counts,
    /// Records without a diagnosis, each with the reason.
    failures: Vec<Line<'a>>,
    /// Runs that the store did not have; `None` without a store.
    added: Option<usize>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
struct Line<'a> {
    /// The record, as the user named it.
    record: &'a str,
    #[serde(flatten)]
    failure: &'a NotDiagnosed,
}

/// Puts the shards in a folder together: into a store, a table, or both.
pub fn put_together(work: &Path, arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    if arguments.store.is_none() && arguments.output.is_none() {
        return Err(Complaint::new(Kind::MissingEntry, "`--merge` does not say where to")
            .help("add `--store FILE`, `-o TABLE.csv` or `-o TABLE.parquet`")
            .into());
    }
    let mut outputs = arguments.overwriting.outputs();
    if let Some(store) = &arguments.store {
        outputs = outputs.adding_to(store)?;
    }
    if let Some(table) = &arguments.output {
        export::check(table)?;
        outputs.writing(table)?;
    }
    let (whole, rows) = merge::<Work, Row>(work, &FORM)?;
    let added = arguments.store.as_ref().map(|path| store(path, &rows)).transpose()?;
    if let Some(table) = &arguments.output {
        export::write(table, &runs(&rows), out)?;
    }
    if arguments.output.as_deref().is_some_and(is_standard_output) {
        // The table alone, as the next program reads it.
        return Ok(Status::Done);
    }
    let counts = Counts::of(&rows);
    match arguments.format {
        Format::Json => {
            let failures = failures(&rows).map(|(record, failure)| Line { record, failure }).collect();
            write_json(out, &Merged { schema: "borescope.records/1", work: &whole, counts, failures, added })?;
        }
        Format::Text => {
            writeln!(out, "{}: {counts}", whole.manifest)?;
            for (_, NotDiagnosed { what, .. }) in failures(&rows) {
                writeln!(out, "  {what}")?;
            }
            if let (Some(added), Some(path)) = (added, &arguments.store) {
                let known = counts.records - counts.failed - added;
                let known = if known > 0 { format!(", {known} were there already") } else { String::new() };
                writeln!(out, "{}: {added} runs added{known}", path.display())?;
            }
            if let Some(table) = &arguments.output {
                writeln!(out, "{}: written", table.display())?;
            }
        }
    }
    Ok(Status::Done)
}

fn store(path: &Path, rows: &[Row]) -> Result<usize, Complaint> {
    let kept: Vec<&Kept> = rows.iter().filter_map(Row::diagnosed).collect();
    Store::open_telling(path, keep::waiting)?.add_new(&kept)
}
