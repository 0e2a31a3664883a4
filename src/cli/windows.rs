//! `diagnose --window`: records that are longer than memory, window by window.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::{Failure, Format, Status, terminal, write_json};
use crate::complaint::{Complaint, Kind};
use crate::diagnosis::DiagnosisOptions;
use crate::diagnosis::watch::{Watched, WatchedVerdict, Watching};
use crate::model::Model;
use crate::report::windows::write_styled;

/// Shortest window, s: what is shorter holds no switching with what follows it.
const SHORTEST: f64 = 1.0;

/// Refuses windows that cannot be meant.
pub fn check(window: f64) -> Result<(), Complaint> {
    if window.is_finite() && window >= SHORTEST {
        return Ok(());
    }
    Err(Complaint::new(Kind::Bounds, format!("`--window {window}` is no length of a window"))
        .help("write seconds, 1 or more, and best a few cycles of the machine: `--window 60`"))
}

/// Watches the records one after the other; a bad one does not stop the others.
pub fn run(
    model: &Model,
    records: &[PathBuf],
    watching: Watching,
    format: Format,
    out: &mut dyn Write,
) -> Result<Status, Failure> {
    let mut done: Vec<Watched> = Vec::new();
    let mut bad: Vec<Complaint> = Vec::new();
    for path in records {
        match one(model, path, watching) {
            Ok(watched) => {
                if format == Format::Text {
                    if !done.is_empty() {
                        writeln!(out)?;
                    }
                    terminal::clear();
                    out.write_all(write_styled(&watched, terminal::style()).as_bytes())?;
                    out.flush()?;
                }
                done.push(watched);
            }
            Err(complaint) => bad.push(complaint),
        }
    }
    if format == Format::Json {
        match done.as_slice() {
            [] => {}
            [one] if records.len() == 1 => write_json(out, one)?,
            several => write_json(out, &several)?,
        }
    }
    if !bad.is_empty() {
        return Err(Failure::Complaints(bad));
    }
    let found = done.iter().any(|watched| watched.conclusion != WatchedVerdict::Healthy);
    Ok(if found { Status::Found } else { Status::Done })
}

fn one(model: &Model, path: &Path, watching: Watching) -> Result<Watched, Complaint> {
    model.watch(path, watching, &DiagnosisOptions::default())
}
