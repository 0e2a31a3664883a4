//! `export`: a store as a table for other programs.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, Overwriting, Status, keep, write_file};
use crate::complaint::{Complaint, Kind};
use crate::files::is_standard_output;
use crate::number::text;
use crate::store::{Store, StoredRun, export_csv};

/// Write a store as a table: a row for each fault of each run
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope export --store rig.db -o runs.csv")]
pub struct Arguments {
    /// The store that `diagnose --store` has filled
    #[arg(long, value_name = "FILE")]
    store: PathBuf,
    /// Where the table is written, as CSV or Parquet by its ending; `-` is CSV to standard output
    #[arg(short, long, value_name = "TABLE.csv|TABLE.parquet")]
    output: PathBuf,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb; what was written is told on `out`, unless the table goes there.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    let path = &arguments.output;
    check(path)?;
    arguments.overwriting.outputs().adding_to(&arguments.store)?.writing(path)?;
    let runs = Store::open_existing_telling(&arguments.store, keep::waiting)?.runs()?;
    write(path, &runs, out)?;
    if is_standard_output(path) {
        return Ok(Status::Done);
    }
    let rows: usize = runs.iter().map(|run| run.faults.len()).sum();
    let plural = if runs.len() == 1 { "" } else { "s" };
    writeln!(out, "{}: {} rows of {} run{plural}", path.display(), text(rows as f64), runs.len())?;
    Ok(Status::Done)
}

fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
}

/// Refuses what no table can be written to.
pub fn check(path: &Path) -> Result<(), Complaint> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    if is_parquet(path) && cfg!(not(feature = "parquet")) {
        return Err(without_parquet(path));
    }
    if !(is_standard_output(path) || ending == "csv" || is_parquet(path)) {
        return Err(Complaint::new(Kind::UnknownName, format!("the ending `{ending}` is that of no known table"))
            .in_file(path)
            .help("end it in `.csv` or `.parquet`"));
    }
    Ok(())
}

/// Writes the table of runs, where to as [`check`] allows it.
pub fn write(path: &Path, runs: &[StoredRun], out: &mut dyn Write) -> Result<(), Failure> {
    if is_standard_output(path) {
        export_csv(runs, out)?;
    } else if is_parquet(path) {
        parquet(path, runs)?;
    } else {
        write_file(path, |file| export_csv(runs, file))?;
    }
    Ok(())
}

fn without_parquet(path: &Path) -> Complaint {
    Complaint::new(Kind::Unwritable, "this borescope was built without the feature `parquet`")
        .in_file(path)
        .help("build it with `cargo build --release --features parquet`, or write a `.csv`")
}

#[cfg(feature = "parquet")]
fn parquet(path: &Path, runs: &[StoredRun]) -> Result<(), Complaint> {
    write_file(path, |file| crate::store::export_parquet(runs, file))
}

#[cfg(not(feature = "parquet"))]
fn parquet(path: &Path, _: &[StoredRun]) -> Result<(), Complaint> {
    Err(without_parquet(path))
}
