//! `campaign --case`: one case alone, with all that it is made of.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Arguments, create};
use crate::calibration;
use crate::campaign::case::Replay;
use crate::campaign::{Campaign, Row};
use crate::cli::{Failure, Format, Overwriting, Status, terminal, write_json, write_page};
use crate::complaint::{Complaint, Kind};
use crate::diagnosis::Diagnosis;
use crate::files::write_atomically;
use crate::finding::findings;
use crate::model::Model;
use crate::report;

/// One case alone.
#[derive(Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub(in crate::cli) struct Alone<'a> {
    schema: &'static str,
    /// What it was and what was found.
    case: &'a Row,
    /// The diagnosis; `null` where there is none.
    diagnosis: Option<&'a Diagnosis>,
}

/// Runs the case, and writes what is asked for.
pub fn run(
    campaign: &Campaign,
    rig_text: &str,
    case: usize,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> Result<Status, Failure> {
    let replay = campaign.replay(case)?;
    if let Some(folder) = &arguments.output {
        leave(campaign, rig_text, &replay, folder, arguments.overwriting)?;
        terminal::written(folder);
    }
    if let Some(path) = &arguments.report {
        let (Some(record), Some(diagnosed)) = (&replay.record, &replay.diagnosed) else {
            let why = replay.row.failure.clone().unwrap_or_default();
            return Err(Complaint::new(Kind::Computation, format!("the case has no diagnosis to show: {why}")).into());
        };
        let calibrated = campaign.prepared(replay.row.rig).ok().and_then(|prepared| prepared.model.as_ref().ok());
        let rig = calibrated.map_or(&campaign.rig, |model| &model.rig);
        let model = Model::new(diagnosed.rig(rig).clone());
        let findings = findings(&model, record, &diagnosed.diagnosis)?;
        write_page(path, &report::pages::diagnosis::html(rig, record, diagnosed, (&findings, None))?)?;
    }
    let diagnosis = replay.diagnosed.as_ref().map(|diagnosed| &diagnosed.diagnosis);
    match arguments.format {
        Format::Text => {
            out.write_all(report::campaign::case(&replay.row).as_bytes())?;
            if let Some(diagnosis) = diagnosis {
                writeln!(out)?;
                out.write_all(report::diagnosis::write_text(diagnosis).as_bytes())?;
            }
        }
        Format::Json => {
            write_json(out, &Alone { schema: "borescope.campaign-case/1", case: &replay.row, diagnosis })?;
        }
    }
    Ok(Status::Done)
}

/// Writes all that a case is made of: its record, the healthy records of its rig, the rig file that was calibrated on
/// them, and what the rig's parameters really are.
fn leave(
    campaign: &Campaign,
    rig_text: &str,
    replay: &Replay,
    folder: &Path,
    overwriting: Overwriting,
) -> Result<(), Complaint> {
    create(folder)?;
    let number = replay.row.rig;
    let (truth, rig_file) = (folder.join(format!("rig_{number}_truth.csv")), folder.join(format!("rig_{number}.toml")));
    let prepared = campaign.prepared(number).ok();
    let records = prepared.iter().flat_map(|prepared| &prepared.records).chain(&replay.record);
    let names: Vec<PathBuf> = records.clone().map(|record| folder.join(&record.path)).collect();
    overwriting.outputs().writing_all(names.iter().chain([&truth, &rig_file]))?;
    for (record, path) in records.zip(&names) {
        record.write(path)?;
    }
    let Some(prepared) = prepared else { return Ok(()) };
    write_atomically(&truth, |file| prepared.write_truth(&campaign.rig, file))?;
    if prepared.model.is_err() {
        // The row says why there is no calibrated rig.
        return Ok(());
    }
    let options = calibration::CalibrationOptions::default();
    let calibrated = calibration::calibrate(rig_text, &campaign.rig, &prepared.records, &options)?;
    let text = campaign.rig.text_at(&calibrated.text, &rig_file)?;
    write_atomically(&rig_file, |file| file.write_all(text.as_bytes()))
}
