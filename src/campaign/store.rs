//! What a campaign leaves in its folder: a journal that grows case by case, and tables at the end.

use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::row::Row;
use super::score::Scores;
use super::statistics::quantile;
use super::{Campaign, CampaignOptions};
use crate::complaint::Complaint;
use crate::files::{self, write_atomically};
use crate::rig::Rig;
use crate::shards::{Form, Numbered, Share};

/// Name and version of the format.
pub const SCHEMA: &str = "borescope.campaign/1";
/// Names of the files in the folder.
pub const CASES: &str = "cases.csv";
pub const RESULT: &str = "campaign.json";
pub const REPORT: &str = "report.txt";

/// A campaign as it is done in shards; so is its journal where it is done in one piece.
pub const FORM: Form = Form {
    journal: "borescope.campaign-journal/1",
    done: "borescope.campaign-shard/1",
    whole: "a campaign",
    row: "case",
};

impl Numbered for Row {
    fn number(&self) -> usize {
        self.case
    }
}

/// Which campaign a shard is of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Work {
    /// Path of the rig file, as the user named it.
    pub rig: String,
    /// Of the whole campaign.
    pub options: CampaignOptions,
}

impl Campaign {
    /// What its shards say of it.
    pub fn whole(&self) -> Work {
        Work { rig: self.rig.path.display().to_string(), options: self.options.clone() }
    }

    /// The cases of a shard: those of its part of the disturbed rigs, as the calibration of one serves all of its cases.
    pub fn cases_of(&self, shard: Share) -> Range<usize> {
        let rigs = shard.range(self.options.rigs);
        // The first case of a rig is the first one that `rig_of` does not put before it.
        let first = |rig: usize| (rig * self.options.cases).div_ceil(self.options.rigs);
        first(rigs.start)..first(rigs.end)
    }
}

/// What tells two campaigns apart: the options, the rig file with the files that it includes, and the version of this crate,
/// hashed.
pub fn digest(options: &CampaignOptions, rig: &Rig) -> String {
    files::digest(format!("{} {options:?}\n{}", env!("CARGO_PKG_VERSION"), rig.digest()).as_bytes())
}

/// Durations of a diagnosis, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Times {
    /// s.
    pub median: Option<f64>,
    /// 95 % of the cases take no longer.
    pub most95: Option<f64>,
}

/// A finished campaign as programs read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Finished {
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// As they were asked for.
    pub options: CampaignOptions,
    /// What the cases come to.
    pub scores: Scores,
    /// Of each case, with [`Row::seconds`] of the rows, all that depends on the machine.
    pub time_s: Times,
    /// Case by case.
    pub cases: Vec<Row>,
}

impl Finished {
    /// From rows in any order, one of each case.
    pub fn new(of: Work, mut rows: Vec<Row>) -> Self {
        rows.sort_by_key(|row| row.case);
        rows.dedup_by_key(|row| row.case);
        let seconds: Vec<f64> = rows.iter().map(|row| row.seconds).collect();
        Self {
            schema: SCHEMA,
            rig: of.rig,
            options: of.options,
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
        write_cases(folder, &self.cases)?;
        write_atomically(&folder.join(RESULT), |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            writeln!(file)
        })?;
        write_atomically(&folder.join(REPORT), |file| file.write_all(report.as_bytes()))
    }
}

/// Writes the table of cases into a folder.
///
/// # Errors
/// A file that cannot be written.
pub fn write_cases(folder: &Path, rows: &[Row]) -> Result<(), Complaint> {
    write_atomically(&folder.join(CASES), |file| write_table(file, rows))
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
