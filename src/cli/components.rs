//! `components`: the component kinds, built in and of the catalogue.

use std::io::Write;

use clap::Args;

use super::{Failure, Format, Status, write_json};
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::report::components::{ComponentsReport, card, cards, find, library};
use crate::rig::catalogue;

/// List the component kinds that a rig file may name, or show one of them
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  borescope components catalogue:counterbalance-valve --source \\\n    > counterbalance.toml"
)]
pub struct Arguments {
    /// The kind as a rig file writes it
    kind: Option<String>,
    /// Write the file of a kind of the catalogue, to copy and change
    #[arg(long, requires = "kind")]
    source: bool,
    /// How the kinds are written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    // Lists below would be without what does not read.
    catalogue::kinds()?;
    let Some(kind) = &arguments.kind else {
        match arguments.format {
            Format::Text => out.write_all(library().as_bytes())?,
            Format::Json => write_json(out, &ComponentsReport::all())?,
        }
        return Ok(Status::Done);
    };
    let Some(found) = find(kind) else {
        return Err(Complaint::new(Kind::UnknownName, format!("there is no component kind `{kind}`"))
            .help(help_with_names(kind, "component kinds", cards().map(|card| card.kind)))
            .into());
    };
    if arguments.source {
        let Some(text) = catalogue::source(found.kind) else {
            return Err(Complaint::new(Kind::Missing, format!("`{kind}` is built in and has no file of formulas"))
                .help("those that begin with `catalogue:` have one; see `borescope components`")
                .into());
        };
        out.write_all(text.as_bytes())?;
        return Ok(Status::Done);
    }
    match arguments.format {
        Format::Text => out.write_all(card(found).as_bytes())?,
        Format::Json => write_json(out, &ComponentsReport::of(found))?,
    }
    Ok(Status::Done)
}
