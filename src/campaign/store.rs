//! What a campaign leaves in its folder: a journal that grows case by case, and tables at the end.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::row::Row;
use super::score::Scores;
use super::statistics::quantile;
use super::{Campaign, CampaignOptions};
use crate::complaint::{Complaint, Kind, Place};
use crate::files::{read_text, write_atomically};

/// Names and versions of the formats.
pub const SCHEMA: &str = "borescope.campaign/1";
const JOURNAL_SCHEMA: &str = "borescope.campaign-journal/1";
/// Names of the files in the folder.
pub const CASES: &str = "cases.csv";
pub const RESULT: &str = "campaign.json";
pub const REPORT: &str = "report.txt";
pub const JOURNAL: &str = "journal.jsonl";

/// First line of a journal.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    schema: String,
    digest: String,
}

/// What tells two campaigns apart: the options, the rig file and the version of this crate, hashed (FNV-1a, 64 bit).
pub fn digest(options: &CampaignOptions, rig_text: &str) -> String {
    let text = format!("{} {options:?}\n{rig_text}", env!("CARGO_PKG_VERSION"));
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x}")
}

/// The finished cases of a campaign, one line of JSON each, behind a header.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Begins a journal in a folder, which is created where it is missing.
    ///
    /// # Errors
    /// A folder that holds a journal already, or cannot be written.
    pub fn begin(folder: &Path, digest: &str) -> Result<Self, Complaint> {
        let path = folder.join(JOURNAL);
        fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        let file = File::options().write(true).create_new(true).open(&path).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => {
                Complaint::new(Kind::Contradiction, "the folder holds the journal of a campaign already")
                    .at(Place::file(&path))
                    .help("add `--resume` to go on with it, or name another folder")
            }
            _ => unwritable(&path, &error),
        })?;
        let mut journal = Self { path, file };
        journal.write(&Header { schema: JOURNAL_SCHEMA.to_owned(), digest: digest.to_owned() })?;
        Ok(journal)
    }

    /// Goes on with the journal of a folder, or begins one; a line that was cut off is dropped. The rows come with it.
    ///
    /// # Errors
    /// A journal of other options or another rig file; lines that are no rows; files that cannot be read or written.
    pub fn resume(folder: &Path, digest: &str) -> Result<(Self, Vec<Row>), Complaint> {
        let path = folder.join(JOURNAL);
        if !path.exists() {
            return Ok((Self::begin(folder, digest)?, Vec::new()));
        }
        let text = read_text(&path)?;
        let whole = text.rfind('\n').map_or(0, |last| last + 1);
        let mut lines = text[..whole].lines().enumerate();
        let wrong = |line: usize, what: &str| {
            Complaint::new(Kind::Syntax, what)
                .at(Place::line(&path, line + 1))
                .help("name another folder, or delete it")
        };
        let Some((_, first)) = lines.next() else {
            fs::remove_file(&path).map_err(|error| unwritable(&path, &error))?;
            return Ok((Self::begin(folder, digest)?, Vec::new()));
        };
        let header: Header = serde_json::from_str(first)
            .ok()
            .filter(|header: &Header| header.schema == JOURNAL_SCHEMA)
            .ok_or_else(|| wrong(0, "this is not the journal of a campaign"))?;
        if header.digest != digest {
            let what = "the journal is of a campaign with other options, another rig file or another version";
            return Err(Complaint::new(Kind::Contradiction, what)
                .at(Place::line(&path, 1))
                .help("resume with the options that it was begun with, or name another folder"));
        }
        let row = |(line, text): (usize, &str)| {
            serde_json::from_str(text).map_err(|error| wrong(line, &format!("this line is no case: {error}")))
        };
        let rows: Vec<Row> = lines.map(row).collect::<Result<_, _>>()?;
        let open = || {
            let file = File::options().append(true).open(&path)?;
            file.set_len(whole as u64)?;
            Ok(file)
        };
        let file = open().map_err(|error: io::Error| unwritable(&path, &error))?;
        Ok((Self { path, file }, rows))
    }

    /// Adds a finished case.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn add(&mut self, row: &Row) -> Result<(), Complaint> {
        self.write(row)
    }

    /// In one piece, so that an interruption leaves whole lines.
    fn write(&mut self, value: &impl Serialize) -> Result<(), Complaint> {
        let written = serde_json::to_string(value).map_err(io::Error::from).and_then(|mut line| {
            line.push('\n');
            self.file.write_all(line.as_bytes())
        });
        written.map_err(|error| unwritable(&self.path, &error))
    }
}

fn unwritable(path: &Path, error: &io::Error) -> Complaint {
    Complaint::new(Kind::Unwritable, format!("cannot be written: {error}")).in_file(path).help("name another folder")
}

/// Durations of a diagnosis, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Times {
    pub median: Option<f64>,
    /// 95 % of the cases take no longer.
    pub most95: Option<f64>,
}

/// A finished campaign as programs read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finished {
    pub schema: &'static str,
    pub rig: String,
    pub options: CampaignOptions,
    pub scores: Scores,
    /// Of each case, with [`Row::seconds`] of the rows, all that depends on the machine.
    pub time_s: Times,
    pub cases: Vec<Row>,
}

impl Finished {
    /// From rows in any order, one of each case.
    pub fn new(campaign: &Campaign, mut rows: Vec<Row>) -> Self {
        rows.sort_by_key(|row| row.case);
        rows.dedup_by_key(|row| row.case);
        let seconds: Vec<f64> = rows.iter().map(|row| row.seconds).collect();
        Self {
            schema: SCHEMA,
            rig: campaign.rig.path.display().to_string(),
            options: campaign.options.clone(),
            scores: Scores::of(&rows),
            time_s: Times { median: quantile(&seconds, 0.5), most95: quantile(&seconds, 0.95) },
            cases: rows,
        }
    }

    /// Writes table, JSON and the report, as people read it, into a folder.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn write(&self, folder: &Path, report: &str) -> Result<(), Complaint> {
        write_atomically(&folder.join(CASES), |file| write_table(file, &self.cases))?;
        write_atomically(&folder.join(RESULT), |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            writeln!(file)
        })?;
        write_atomically(&folder.join(REPORT), |file| file.write_all(report.as_bytes()))
    }
}

/// One line per case: what holds for the case, eight columns for each fault of the rig, and at the end the time, the only
/// column that is not reproducible.
fn write_table(file: &mut dyn Write, rows: &[Row]) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(file);
    let mut head: Vec<String> = [
        "case",
        "rig",
        "redrawn",
        "rig_redrawn",
        "rig_adequate",
        "count",
        "injected",
        "onset [s]",
        "motion [s]",
        "verdict",
        "failure",
        "detected_at [s]",
        "found",
        "alarmed",
        "isolated",
        "identifiable",
        "rival",
        "mistaken",
        "top",
        "top_probability",
        "truth_probability",
        "ambiguity",
        "chi2_reduced",
    ]
    .map(str::to_owned)
    .to_vec();
    for fault in rows.first().map_or(&[][..], |row| &row.faults) {
        let (id, unit) = (&fault.id, &fault.unit);
        let of = |what: &str, unit: &str| {
            if unit.is_empty() { format!("{id} {what}") } else { format!("{id} {what} [{unit}]") }
        };
        head.extend([of("healthy", unit), of("truth", unit), of("flow", "L/min"), of("estimate", unit)]);
        head.extend([of("low95", unit), of("high95", unit), of("present", ""), of("probability", "")]);
    }
    head.push("time [s]".to_owned());
    table.write_record(&head)?;
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for row in rows {
        let mut line = vec![
            row.case.to_string(),
            row.rig.to_string(),
            row.redrawn.to_string(),
            row.rig_redrawn.to_string(),
            row.rig_adequate.map_or(String::new(), |adequate| adequate.to_string()),
            row.count.to_string(),
            row.injected().join(";"),
            number(row.onset_s),
            row.motion_s.to_string(),
            row.outcome.name().to_owned(),
            row.failure.clone().unwrap_or_default(),
            number(row.detected_at_s),
            row.found().join(";"),
            row.alarmed().to_string(),
            row.isolated().to_string(),
            row.identifiable.map_or(String::new(), |known| known.to_string()),
            row.rival.join(";"),
            number(row.mistaken),
            row.top.join(";"),
            number(row.top_probability),
            number(row.truth_probability),
            row.ambiguity.map_or(String::new(), |count| count.to_string()),
            number(row.chi2_reduced),
        ];
        for fault in &row.faults {
            line.extend([fault.healthy.to_string(), fault.truth.to_string(), number(fault.flow_l_min)]);
            line.extend([number(fault.value), number(fault.ci95[0]), number(fault.ci95[1])]);
            line.extend([fault.present.to_string(), number(fault.probability)]);
        }
        line.push(row.seconds.to_string());
        table.write_record(&line)?;
    }
    table.flush()
}
