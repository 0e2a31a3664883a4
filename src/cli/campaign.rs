//! `campaign`: how good the diagnosis of a rig is, measured on synthetic faults.

use std::collections::HashSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::{Failure, Format, Overwriting, Status, terminal, write_json, write_page};
use crate::calibration;
use crate::campaign::case::Replay;
use crate::campaign::store::{CASES, Finished, JOURNAL, Journal, REPORT, RESULT, digest};
use crate::campaign::{Campaign, CampaignOptions, HEALTHY, Outcome, Row};
use crate::complaint::{Complaint, Kind};
use crate::context::Context;
use crate::diagnosis::Diagnosis;
use crate::files::{check_folder, read_text, write_atomically};
use crate::report;
use crate::rig::Rig;

/// Measure the diagnosis of a rig on synthetic faults
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  borescope campaign rig.toml --cases 400 -o campaign --report campaign.html\n  borescope campaign rig.toml --cases 400 --case 17 --report case_17.html"
)]
pub struct Arguments {
    /// The rig file; its `[cycle]` is what the cases run
    rig: PathBuf,
    /// How many cases
    #[arg(long, value_name = "N")]
    cases: usize,
    /// Seed of everything that is drawn
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write `cases.csv`, `campaign.json`, `report.txt` and a journal into this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Go on with the journal in the folder
    #[arg(long, requires = "output")]
    resume: bool,
    /// Run only the case with this number, from 0, and print its truth and its diagnosis; with `-o` write its
    /// record, and its rig's healthy records and calibrated rig file
    #[arg(long, value_name = "K", conflicts_with = "resume")]
    case: Option<usize>,
    /// Also write a page with pictures; of one case the page of its diagnosis
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// How the result is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Fraction of healthy cases
    #[arg(long, value_name = "SHARE", default_value_t = HEALTHY)]
    healthy: f64,
    /// Deviation of the simulated rigs from the data sheet; 0 is none
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    disturbance: f64,
    /// How many disturbed rigs share the cases; without it one for every 25 cases
    #[arg(long, value_name = "R")]
    rigs: Option<usize>,
    /// Threads; without it as many as the machine has. Results do not depend on it
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// One case alone.
#[derive(Serialize)]
struct Alone<'a> {
    schema: &'static str,
    case: &'a Row,
    diagnosis: Option<&'a Diagnosis>,
}

/// Declares every file of the run. What a resumed campaign wrote before is its own.
fn declare(arguments: &Arguments) -> Result<(), Complaint> {
    let mut outputs = arguments.overwriting.outputs().reading([&arguments.rig]);
    if let Some(folder) = &arguments.output {
        check_folder(folder)?;
        let whole = folder.is_dir() && arguments.case.is_none();
        // Where a journal stands it refuses to be begun over, with the way to go on.
        let is_own = arguments.resume || folder.join(JOURNAL).exists();
        outputs = if whole { outputs.going_on_with(&folder.join(JOURNAL))? } else { outputs };
        for path in [CASES, RESULT, REPORT].iter().filter(|_| whole).map(|name| folder.join(name)) {
            outputs = if is_own { outputs.going_on_with(&path)? } else { outputs.writing(&path)? };
        }
    }
    outputs.writing_all(&arguments.report)?;
    Ok(())
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let text = read_text(&arguments.rig)?;
    let rig = Rig::parse(&arguments.rig, text.clone())?;
    let plain = CampaignOptions::new(arguments.cases);
    let options = CampaignOptions {
        seed: arguments.seed,
        healthy: arguments.healthy,
        disturbance: arguments.disturbance,
        rigs: arguments.rigs.unwrap_or(plain.rigs),
        ..plain
    };
    // Of many cases it is told how many are done, not how far each is.
    let context = if arguments.case.is_some() { context.clone() } else { context.clone().without_progress() };
    let (context, threads) = match arguments.threads {
        Some(0) => {
            let complaint = Complaint::new(Kind::Bounds, "no threads to work with");
            return Err(complaint.help("give `--threads` a number above 0, or leave it away").into());
        }
        Some(threads) => (context.with_threads(threads)?, threads),
        None => (context, std::thread::available_parallelism().map_or(1, usize::from)),
    };
    let rig = rig.with_context(&context);
    declare(arguments)?;
    let campaign = Campaign::new(rig, options)?;
    if let Some(case) = arguments.case {
        return alone(&campaign, &text, case, arguments, out);
    }
    let (mut journal, mut rows) = match &arguments.output {
        None => (None, Vec::new()),
        Some(folder) => {
            let digest = digest(&campaign.options, &text);
            let (journal, rows) = if arguments.resume {
                Journal::resume(folder, &digest)?
            } else {
                (Journal::begin(folder, &digest)?, Vec::new())
            };
            (Some(journal), rows)
        }
    };
    let finished: HashSet<usize> = rows.iter().map(|row| row.case).collect();
    let todo: Vec<usize> = (0..arguments.cases).filter(|case| !finished.contains(case)).collect();
    let mut progress = Progress::new(&rows, todo.len());
    let ran = campaign.run(&todo, threads, |row| {
        if let Some(journal) = &mut journal {
            journal.add(&row)?;
        }
        progress.show(&row);
        rows.push(row);
        Ok(())
    });
    progress.end();
    ran?;
    let finished = Finished::new(&campaign, rows);
    let report = report::campaign::write_text(&finished);
    if let Some(folder) = &arguments.output {
        finished.write(folder, &report)?;
    }
    if let Some(path) = &arguments.report {
        write_page(path, &report::pages::campaign::html(&finished))?;
    }
    match arguments.format {
        Format::Text => out.write_all(report.as_bytes())?,
        Format::Json => write_json(out, &finished)?,
    }
    Ok(Status::Done)
}

fn alone(
    campaign: &Campaign,
    rig_text: &str,
    case: usize,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> Result<Status, Failure> {
    let replay = campaign.replay(case)?;
    if let Some(folder) = &arguments.output {
        leave(campaign, rig_text, &replay, folder, arguments.overwriting)?;
    }
    if let Some(path) = &arguments.report {
        let (Some(record), Some(diagnosed)) = (&replay.record, &replay.diagnosed) else {
            let why = replay.row.failure.clone().unwrap_or_default();
            return Err(Complaint::new(Kind::Computation, format!("the case has no diagnosis to show: {why}")).into());
        };
        let calibrated = campaign.prepared(replay.row.rig).ok().and_then(|prepared| prepared.model.as_ref().ok());
        let rig = calibrated.map_or(&campaign.rig, |model| &model.rig);
        write_page(path, &report::pages::diagnosis::html(rig, record, diagnosed)?)?;
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
    std::fs::create_dir_all(folder).map_err(|error| {
        Complaint::new(Kind::Unwritable, format!("cannot be created: {error}")).in_file(folder).help("name another")
    })?;
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
    let text = calibrated.text.as_bytes();
    write_atomically(&rig_file, |file| file.write_all(text))
}

/// One line on a terminal, written over again.
struct Progress {
    shown: bool,
    begin: Instant,
    done: usize,
    before: usize,
    all: usize,
    healthy: usize,
    false_alarms: usize,
}

impl Progress {
    fn new(before: &[Row], todo: usize) -> Self {
        let mut progress = Self {
            shown: terminal::shows_progress(),
            begin: Instant::now(),
            done: 0,
            before: before.len(),
            all: before.len() + todo,
            healthy: 0,
            false_alarms: 0,
        };
        before.iter().for_each(|row| progress.count(row));
        progress
    }

    fn count(&mut self, row: &Row) {
        if !row.is_faulty() {
            self.healthy += 1;
            self.false_alarms += usize::from(row.outcome != Outcome::Healthy);
        }
    }

    fn show(&mut self, row: &Row) {
        self.done += 1;
        self.count(row);
        if !self.shown {
            return;
        }
        let finished = self.before + self.done;
        let left = self.begin.elapsed().as_secs_f64() / self.done as f64 * (self.all - finished) as f64;
        let Self { all, healthy, false_alarms, .. } = self;
        // Nobody misses a line that could not be shown.
        let _ = write!(
            io::stderr(),
            "\r{finished} of {all} cases, {false_alarms} false alarms in {healthy} healthy ones, {left:.0} s left \x1b[K"
        );
    }

    fn end(&self) {
        if self.shown && self.done > 0 {
            let _ = writeln!(io::stderr());
        }
    }
}
