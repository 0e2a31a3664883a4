//! Runs out of a table that `export` has written.

use std::path::Path;

use super::fields::Fields;
use super::{Moment, StoredFault, StoredRun};
use crate::complaint::{Complaint, Kind, Place};
use crate::files;

/// Largest table, bytes.
const MOST: u64 = 1 << 32;

/// Reads the runs of a table, CSV or Parquet by its ending; rows of one run follow each other.
///
/// # Errors
/// A file that is no such table, or that is damaged.
pub fn import(path: &Path) -> Result<Vec<StoredRun>, Complaint> {
    let mut runs = Runs { path, runs: Vec::new() };
    let is_parquet = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"));
    if is_parquet {
        parquet(path, &mut runs)?
    } else {
        csv(path, &mut runs)?
    }
    let mut runs = runs.runs;
    // As a store gives them.
    runs.sort_by_key(|run| (run.measured_at, run.id));
    Ok(runs)
}

struct Runs<'a> {
    path: &'a Path,
    runs: Vec<StoredRun>,
}

impl Runs<'_> {
    /// Adds a row; `line` is its place in the file, where that has lines.
    fn add(&mut self, fields: &dyn Fields, line: Option<usize>) -> Result<(), Complaint> {
        let wrong = |kind, what: String| {
            let place = line.map_or_else(|| Place::file(self.path), |line| Place::line(self.path, line));
            Complaint::new(kind, what).at(place).help("name a store, or a table that `borescope export` has written")
        };
        let text = |name: &str| {
            fields.get(name).ok_or_else(|| wrong(Kind::MissingEntry, format!("the table has nothing in `{name}`")))
        };
        let optional = |name: &str| fields.get(name).unwrap_or_default();
        let number = |name: &str| -> Result<Option<f64>, Complaint> {
            let parse = |text: String| {
                text.parse().map_err(|_| wrong(Kind::Number, format!("`{text}` in `{name}` is no number")))
            };
            fields.get(name).map(parse).transpose()
        };
        let moment = |name: &str| -> Result<Moment, Complaint> {
            text(name)?.parse().map_err(|complaint: Complaint| wrong(Kind::Syntax, complaint.what))
        };
        let truth = |name: &str| -> Result<bool, Complaint> {
            let text = text(name)?;
            text.parse().map_err(|_| wrong(Kind::Syntax, format!("`{text}` in `{name}` is neither true nor false")))
        };
        let id =
            number("run")?.ok_or_else(|| wrong(Kind::MissingEntry, "the table has nothing in `run`".to_owned()))?;
        let id = id as i64;
        let fault = StoredFault {
            id: text("fault")?,
            unit: text("unit")?,
            value: number("value")?,
            low: number("low")?,
            high: number("high")?,
            healthy: number("healthy")?,
            present: truth("present")?,
            probability: number("probability")?,
            identifiable: optional("identifiable"),
            biased: truth("biased")?,
            limit: number("limit")?,
            lower_bound: number("lower_bound")?,
            upper_bound: number("upper_bound")?,
        };
        if let Some(run) = self.runs.last_mut().filter(|run| run.id == id) {
            run.faults.push(fault);
            return Ok(());
        }
        let run = StoredRun {
            id,
            rig: text("rig")?,
            rig_name: optional("rig_name"),
            rig_digest: optional("rig_digest"),
            record: text("record")?,
            record_digest: text("record_digest")?,
            measured_at: moment("measured_at")?,
            dated_by: optional("dated_by"),
            diagnosed_at: moment("diagnosed_at")?,
            verdict: text("verdict")?,
            chi2_reduced: number("chi2_reduced")?,
            model_version: optional("model_version"),
            options: String::new(),
            faults: vec![fault],
        };
        self.runs.push(run);
        Ok(())
    }
}

/// A row of CSV under its heads.
struct Line<'a> {
    heads: &'a csv::StringRecord,
    fields: &'a csv::StringRecord,
}

impl Fields for Line<'_> {
    fn get(&self, name: &str) -> Option<String> {
        let text = self.fields.get(self.heads.iter().position(|head| head == name)?)?;
        // What `plain_cell` put before it.
        let plain = text.strip_prefix('\'').filter(|rest| rest.starts_with(['=', '+', '-', '@', '\t', '\r']));
        Some(plain.unwrap_or(text).to_owned()).filter(|text| !text.is_empty())
    }
}

fn csv(path: &Path, runs: &mut Runs<'_>) -> Result<(), Complaint> {
    let text = files::text(path, files::read(path, MOST)?.bytes)?;
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let broken = |error: csv::Error| {
        let place = error.position().map_or_else(|| Place::file(path), |at| Place::line(path, at.line() as usize));
        Complaint::new(Kind::Syntax, format!("the table cannot be read: {error}"))
            .at(place)
            .help("name a store, or a table that `borescope export` has written")
    };
    let heads = table.headers().map_err(broken)?.clone();
    for fields in table.records() {
        let fields = fields.map_err(broken)?;
        let line = fields.position().map(|at| at.line() as usize);
        runs.add(&Line { heads: &heads, fields: &fields }, line)?;
    }
    Ok(())
}

#[cfg(not(feature = "parquet"))]
fn parquet(path: &Path, _: &mut Runs<'_>) -> Result<(), Complaint> {
    Err(Complaint::new(Kind::Unreadable, "this borescope was built without the feature `parquet`")
        .in_file(path)
        .help("build it with `cargo build --release --features parquet`, or name a `.csv`"))
}

#[cfg(feature = "parquet")]
fn parquet(path: &Path, runs: &mut Runs<'_>) -> Result<(), Complaint> {
    let bytes = files::read(path, MOST)?.bytes;
    super::parquet::read(path, bytes, |row| runs.add(row, None))
}
