//! `campaign`: how good the diagnosis of a rig is, measured on synthetic faults.

pub(super) mod alone;
mod shards;

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;

use super::progress::Progress;
use super::{Failure, Format, Overwriting, Status, terminal, write_json, write_page};
use crate::campaign::store::{CASES, FORM, Finished, REPORT, RESULT, digest};
use crate::campaign::{Campaign, CampaignOptions, HEALTHY, Outcome, Row};
use crate::complaint::{Complaint, Kind};
use crate::context::Context;
use crate::files::{check_folder, read_text};
use crate::report;
use crate::rig::Rig;
use crate::shards::{Hold, JOURNAL, Journal, Share, missing};

/// Measure the diagnosis of a rig on synthetic faults
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  borescope campaign rig.toml --cases 400 -o campaign --report campaign.html\n  borescope campaign rig.toml --cases 400 --case 17 --report case_17.html\n  borescope campaign rig.toml --cases 100000 --shard 3/400 -o shards\n  borescope campaign --merge shards -o campaign"
)]
pub struct Arguments {
    /// The rig file; its `[cycle]` is what the cases run
    #[arg(required_unless_present = "merge")]
    rig: Option<PathBuf>,
    /// How many cases
    #[arg(long, value_name = "N", required_unless_present = "merge")]
    cases: Option<usize>,
    /// Seed of everything that is drawn
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write `cases.csv`, `campaign.json`, `report.txt` and a journal into this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Go on with the journal in the folder
    #[arg(long, requires = "output")]
    resume: bool,
    /// Do only this shard of so many, such as `3/400`, in a folder of its own in DIR; what is there already is gone on with
    #[arg(long, value_name = "I/N", requires = "output", conflicts_with_all = ["case", "report"])]
    shard: Option<Share>,
    /// Put the shards in this folder together
    #[arg(long, value_name = "DIR", requires = "output", conflicts_with_all = ["rig", "cases", "seed", "healthy", "disturbance", "rigs", "resume", "case", "shard"])]
    merge: Option<PathBuf>,
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
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Declares every file of the run. What a resumed campaign wrote before is its own.
fn declare(arguments: &Arguments) -> Result<(), Complaint> {
    let mut outputs = arguments.overwriting.outputs().reading(&arguments.rig);
    if let Some(folder) = &arguments.output {
        check_folder(folder)?;
        let whole = folder.is_dir() && arguments.case.is_none() && arguments.shard.is_none();
        // Where a journal stands it refuses to be begun over, with the way to go on.
        let is_own = arguments.resume || (arguments.merge.is_none() && folder.join(JOURNAL).exists());
        outputs = if whole { outputs.going_on_with(&folder.join(JOURNAL))? } else { outputs };
        for path in [CASES, RESULT, REPORT].iter().filter(|_| whole).map(|name| folder.join(name)) {
            outputs = if is_own { outputs.going_on_with(&path)? } else { outputs.writing(&path)? };
        }
    }
    outputs.writing_all(&arguments.report)?;
    Ok(())
}

/// A campaign that is laid out, and how it runs.
struct Begun<'a> {
    campaign: &'a Campaign,
    digest: String,
    threads: usize,
}

impl Begun<'_> {
    /// Runs those of the cases that `rows` does not have, and adds each to it and to the journal.
    fn run(
        &self,
        cases: Range<usize>,
        rows: &mut Vec<Row>,
        mut journal: Option<&mut Journal>,
    ) -> Result<(), Complaint> {
        let todo = missing(cases, rows);
        let mut progress = Progress::new("cases", rows.len(), todo.len());
        let (mut healthy, mut false_alarms) = (0, 0);
        let mut count = move |row: &Row| {
            if !row.is_faulty() {
                healthy += 1;
                false_alarms += usize::from(row.outcome != Outcome::Healthy);
            }
            (false_alarms, healthy)
        };
        for row in rows.iter() {
            count(row);
        }
        let ran = self.campaign.run(&todo, self.threads, |row| {
            if let Some(journal) = &mut journal {
                journal.add(&row)?;
            }
            let (false_alarms, healthy) = count(&row);
            progress.show(format_args!("{false_alarms} false alarms in {healthy} healthy ones"));
            rows.push(row);
            Ok(())
        });
        progress.end();
        ran
    }
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    if let Some(work) = &arguments.merge {
        declare(arguments)?;
        return shards::put_together(work, arguments, out);
    }
    let (Some(path), Some(cases)) = (&arguments.rig, arguments.cases) else {
        // The command line asks for both wherever nothing is merged.
        return Err(Complaint::new(Kind::MissingEntry, "a campaign needs a rig file and `--cases`").into());
    };
    let text = read_text(path)?;
    let rig = Rig::parse(path, text.clone())?;
    let plain = CampaignOptions::new(cases);
    let options = CampaignOptions {
        seed: arguments.seed,
        healthy: arguments.healthy,
        disturbance: arguments.disturbance,
        rigs: arguments.rigs.unwrap_or(plain.rigs),
        ..plain
    };
    // Of many cases the progress is how many are done, not how far each is.
    let context = if arguments.case.is_some() { context.clone() } else { context.clone().without_progress() };
    let rig = rig.with_context(&context);
    declare(arguments)?;
    let campaign = Campaign::new(rig, options)?;
    if let Some(case) = arguments.case {
        return alone::run(&campaign, &text, case, arguments, out);
    }
    let begun =
        Begun { campaign: &campaign, digest: digest(&campaign.options, &campaign.rig), threads: context.threads() };
    let hold = Hold { context: &context, waiting: super::waiting };
    if let (Some(shard), Some(folder)) = (arguments.shard, &arguments.output) {
        return shards::run(&begun, shard, folder, &hold, arguments, out);
    }
    let (mut journal, mut rows) = match &arguments.output {
        None => (None, Vec::new()),
        Some(folder) => {
            let (journal, rows) = if arguments.resume {
                Journal::resume(folder, &FORM, &begun.digest, &hold)?
            } else {
                (Journal::begin(folder, &FORM, &begun.digest)?, Vec::new())
            };
            (Some(journal), rows)
        }
    };
    begun.run(0..cases, &mut rows, journal.as_mut())?;
    present(&Finished::new(campaign.whole(), rows), arguments, out)
}

/// Writes a finished campaign: into its folder, as a page, and to standard output.
fn present(finished: &Finished, arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    let report = report::campaign::write_text(finished);
    if let Some(folder) = &arguments.output {
        create(folder)?;
        finished.write(folder, &report)?;
        terminal::written(folder);
    }
    if let Some(path) = &arguments.report {
        write_page(path, &report::pages::campaign::html(finished))?;
    }
    match arguments.format {
        Format::Text => {
            out.write_all(report.as_bytes())?;
            writeln!(out, "\n{}", report::brief::next_line(&report::campaign::next(finished)))?;
        }
        Format::Json => write_json(out, finished)?,
    }
    Ok(Status::Done)
}

/// Creates a folder where it is missing.
fn create(folder: &Path) -> Result<(), Complaint> {
    std::fs::create_dir_all(folder).map_err(|error| {
        Complaint::new(Kind::Unwritable, format!("cannot be created: {error}")).in_file(folder).help("name another")
    })
}
