//! `history`: the course of each fault over the runs of a store.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Overwriting, Status, keep, write_json, write_page};
use crate::complaint::{Complaint, Kind, Place, help_with_names};
use crate::context::Context;
use crate::finding::argument;
use crate::history::{By, history};
use crate::report::brief::next_line;
use crate::report::history::write_text;
use crate::report::pages;
use crate::rig::Rig;
use crate::store::{RigIdentity, Store};

/// Show the trend of each fault over the stored diagnoses, and when it reaches its limit
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope history rig.toml --store rig.db --report history.html")]
pub struct Arguments {
    /// The rig file, with `limit` at the faults that have one
    rig: PathBuf,
    /// The store that `diagnose --store` has filled
    #[arg(long, value_name = "FILE")]
    store: PathBuf,
    /// What the trend is plotted versus
    #[arg(long, value_enum, default_value_t = By::Time)]
    by: By,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// How the history is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb; the history goes to `out`.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let outputs = arguments.overwriting.outputs().reading([&arguments.rig]).adding_to(&arguments.store)?;
    outputs.writing_all(&arguments.report)?;
    let rig = Rig::read(&arguments.rig)?.with_context(context);
    let store = Store::open_existing_telling(&arguments.store, keep::waiting)?;
    let runs = store.runs_of(&RigIdentity::new(&rig).key)?;
    if runs.is_empty() {
        let rigs = store.rigs()?;
        let name =
            if rig.name.is_empty() { "this rig file, which has no name".into() } else { format!("`{}`", rig.name) };
        return Err(Complaint::new(Kind::Empty, format!("the store has no runs of {name}"))
            .at(Place::file(&arguments.store))
            .help(help_with_names(&rig.name, "rigs in the store", rigs.iter().map(String::as_str)))
            .into());
    }
    let history = history(&rig, &arguments.store.display().to_string(), &runs, arguments.by);
    if let Some(path) = &arguments.report {
        write_page(path, &pages::history::html(&history))?;
    }
    match arguments.format {
        Format::Json => write_json(out, &history)?,
        Format::Text => {
            out.write_all(write_text(&history).as_bytes())?;
            let [rig, store] = [&arguments.rig, &arguments.store].map(argument);
            writeln!(out, "\n{}", next_line(&format!("borescope diagnose {rig} RECORD --store {store}")))?;
        }
    }
    Ok(Status::Done)
}
