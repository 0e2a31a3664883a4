//! `compare`: the model beside a record, and where it misses.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Status, read, terminal, write_json, write_page};
use crate::files::check_output;
use crate::learn::compare::compared;
use crate::report;
use crate::rig::Rig;

/// Compare the healthy model with a record: which sensors it misses, in which phases
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope compare rig.toml record.csv --report misfit.html")]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// A record of this rig
    record: PathBuf,
    /// How the comparison is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Exit with 1 if the model misses the record
    #[arg(long)]
    exit_code: bool,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    let rig = Rig::read(&arguments.rig)?;
    let record = read::record(&rig, &arguments.record)?;
    if let Some(report) = &arguments.report {
        check_output(report, [&arguments.rig, &arguments.record])?;
    }
    let compared = compared(&rig, &record)?;
    if let Some(path) = &arguments.report {
        write_page(path, &report::pages::learn::comparison(&rig, &record, &compared)?)?;
    }
    let comparison = &compared.comparison;
    match arguments.format {
        Format::Text => {
            let page = report::learn::comparison(comparison);
            out.write_all(terminal::verdict(&page, report::learn::comparison_tone(comparison)).as_bytes())?;
        }
        Format::Json => write_json(out, comparison)?,
    }
    Ok(if arguments.exit_code && !comparison.adequate { Status::Found } else { Status::Done })
}
