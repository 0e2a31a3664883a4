//! `effects`: the library of physical effects.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Failure, Format, Overwriting, Status, write_json, write_page};
use crate::complaint::{Complaint, Kind};
use crate::report::effects::{EffectReport, LibraryReport, card, library, meant, named};
use crate::report::pages;

/// List the physical effects that can be added to a model, or show one of them
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope effects external-leakage")]
pub struct Arguments {
    /// Name of an effect, without its place
    name: Option<String>,
    /// Also write a page with pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// How the library is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    arguments.overwriting.outputs().writing_all(&arguments.report)?;
    let Some(name) = &arguments.name else {
        if let Some(path) = &arguments.report {
            write_page(path, &pages::effects::library())?;
        }
        match arguments.format {
            Format::Text => out.write_all(library().as_bytes())?,
            Format::Json => write_json(out, &LibraryReport::new())?,
        }
        return Ok(Status::Done);
    };
    // `external-leakage@A` is how rig files and suggestions write it.
    let kind = name.split_once('@').map_or(name.as_str(), |(kind, _)| kind);
    let effects = named(kind);
    if effects.is_empty() {
        return Err(Complaint::new(Kind::UnknownName, format!("there is no effect `{kind}`"))
            .help(match meant(kind).as_slice() {
                [] => "`borescope effects` lists all".to_owned(),
                [some @ .., last] => {
                    let some: Vec<String> = some.iter().map(|name| format!("`{name}`")).collect();
                    let or = if some.is_empty() { String::new() } else { format!("{} or ", some.join(", ")) };
                    format!("did you mean {or}`{last}`? `borescope effects` lists all")
                }
            })
            .into());
    }
    if let Some(path) = &arguments.report {
        write_page(path, &pages::effects::cards(&effects))?;
    }
    match (arguments.format, effects.as_slice()) {
        (Format::Text, effects) => {
            let cards: Vec<String> = effects.iter().map(|effect| card(effect)).collect();
            out.write_all(cards.join("\n").as_bytes())?;
            if let Some(first) = effects.first() {
                writeln!(
                    out,
                    "\nNext: borescope add RIG.toml {} --fit RECORD -o NEW.toml",
                    EffectReport::new(first).written
                )?;
            }
        }
        (Format::Json, [effect]) => write_json(out, &EffectReport::new(effect))?,
        (Format::Json, effects) => write_json(out, &LibraryReport::of(effects))?,
    }
    Ok(Status::Done)
}
