//! What `diagnose` is asked for, whether of records of the command line or of a list.

use std::path::PathBuf;

use clap::Args;

use super::{Format, Overwriting};
use crate::shards::Share;

/// Diagnose records of a rig: which faults, how large, how probable
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  borescope diagnose rig.toml record.csv --report diagnosis.html\n  borescope diagnose rig.toml monday.csv tuesday.csv --store rig.db\n  borescope diagnose rig.toml week.csv --window 60\n  borescope diagnose rig.toml --records list.csv --shard 3/100 -o rows\n  borescope diagnose --merge rows --store fleet.db"
)]
pub struct Arguments {
    /// The rig file
    #[arg(required_unless_present = "merge")]
    pub(super) rig: Option<PathBuf>,
    /// Records of this rig
    #[arg(required_unless_present_any = ["manifest", "merge"])]
    pub(super) records: Vec<PathBuf>,
    /// Diagnose the records that this list names: CSV with the column `record` and, if wanted, `rig` (name of the machine) and
    /// `measured_at`. The folder gets a journal and tables, and a list that was interrupted is gone on with
    #[arg(long = "records", value_name = "MANIFEST.csv", requires = "output", conflicts_with_all = ["records", "report", "curves", "store", "at", "all", "window"])]
    pub(super) manifest: Option<PathBuf>,
    /// Do only this shard of so many, such as `3/100`, in a folder of its own in DIR
    #[arg(long, value_name = "I/N", requires = "manifest")]
    pub(super) shard: Option<Share>,
    /// Put the shards in this folder together: into `--store FILE`, a table `-o`, or both
    #[arg(long, value_name = "DIR", conflicts_with_all = ["rig", "records", "manifest", "shard", "report", "curves", "at", "all", "window", "exit_code"])]
    pub(super) merge: Option<PathBuf>,
    /// With `--records` the folder of the shards; with `--merge` a table, CSV or Parquet by its ending
    #[arg(short, long, value_name = "DIR|TABLE", conflicts_with = "records")]
    pub(super) output: Option<PathBuf>,
    /// How the diagnosis is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(super) format: Format,
    /// Every fault, interval, residual and sensor
    #[arg(long)]
    pub(super) all: bool,
    /// Also write a page with pictures; only with one record
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
    /// Also write the curves behind the diagnosis: measured, healthy model, and model with the faults; only with one record
    #[arg(long, value_name = "FILE.csv")]
    pub(super) curves: Option<PathBuf>,
    /// Keep each diagnosis in this store, an SQLite file; it is created if missing
    #[arg(long, value_name = "FILE")]
    pub(super) store: Option<PathBuf>,
    /// When the record was measured, such as `2026-05-01T12:00:00Z`; without it the time of its file
    #[arg(long, value_name = "TIME")]
    pub(super) at: Option<String>,
    /// Monitor a record of any length in windows of this many seconds, and diagnose those in which a residual raises an alarm
    #[arg(long, value_name = "SECONDS", conflicts_with_all = ["report", "curves", "store", "at"])]
    pub(super) window: Option<f64>,
    /// Largest number of windows that are diagnosed; the others are only listed
    #[arg(long, value_name = "N", default_value_t = 3, requires = "window")]
    pub(super) fits: usize,
    /// Exit with 1 if a fault or a misfit was found
    #[arg(long)]
    pub(super) exit_code: bool,
    #[command(flatten)]
    pub(super) overwriting: Overwriting,
}
