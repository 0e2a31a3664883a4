//! `fleet`: how all rigs of a store stand, the worst first.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, Format, Overwriting, Status, keep, write_json, write_page};
use crate::complaint::{Complaint, Kind};
use crate::finding::argument;
use crate::fleet::fleet;
use crate::report;
use crate::report::brief::next_line;
use crate::store::{Store, StoredRun, import};

/// Show how all rigs of a store stand, the worst first
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope fleet fleet.db --report fleet.html")]
pub struct Arguments {
    /// The store that `diagnose --store` has filled, or a table that `export` or `diagnose --merge` has written
    #[arg(value_name = "STORE|TABLE")]
    source: PathBuf,
    /// Also write a page that can be searched and filtered
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Every rig, not only the worst
    #[arg(long)]
    all: bool,
    /// How the fleet is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb; the fleet goes to `out`.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    let source = &arguments.source;
    arguments.overwriting.outputs().reading([source]).writing_all(&arguments.report)?;
    let runs = runs(source)?;
    if runs.is_empty() {
        return Err(Complaint::new(Kind::Empty, "there are no runs in it")
            .in_file(source)
            .help("fill it with `borescope diagnose RIG.toml RECORD --store FILE`")
            .into());
    }
    let fleet = fleet(&source.display().to_string(), &runs);
    if let Some(path) = &arguments.report {
        write_page(path, &report::pages::fleet::html(&fleet))?;
    }
    match arguments.format {
        Format::Json => write_json(out, &fleet)?,
        Format::Text => {
            out.write_all(report::fleet::write_text(&fleet, arguments.all).as_bytes())?;
            let command = format!("borescope history RIG.toml --store {}", argument(store_of(source)));
            writeln!(out, "\n{}", next_line(&command))?;
        }
    }
    Ok(Status::Done)
}

/// The store that a trend is read from; a table is none.
fn store_of(source: &Path) -> String {
    if is_table(source) { "STORE".to_owned() } else { source.display().to_string() }
}

fn is_table(source: &Path) -> bool {
    let ending = source.extension();
    ending.is_some_and(|ending| ["csv", "parquet"].iter().any(|table| ending.eq_ignore_ascii_case(table)))
}

/// The runs of a store, or of a table: which one it is, its first bytes and its ending say.
fn runs(source: &Path) -> Result<Vec<StoredRun>, Complaint> {
    let mut first = Vec::new();
    let begin = std::fs::File::open(source).and_then(|file| file.take(16).read_to_end(&mut first));
    if begin.is_ok() && is_table(source) && !first.starts_with(b"SQLite format 3") {
        return import(source);
    }
    Store::open_existing_telling(source, keep::waiting)?.runs()
}
