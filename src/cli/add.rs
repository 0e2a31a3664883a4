//! `add`: an effect written into a new rig file.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::{Failure, Format, Overwriting, Status, read, write_json};
use crate::context::Context;
use crate::files::{is_kept, read_text, write_atomically};
use crate::learn::add::add;
use crate::learn::suggest::RIVAL;
use crate::report::digits::plus_minus;
use crate::report::number::{before_unit, rounded};
use crate::rig::Rig;

/// Digits of a reported number.
const DIGITS: usize = 7;

/// Add an effect to a rig file, fitted to a record if one is given
///
/// Comments and order of the file stay. Without a record the effect is there at its neutral value, uncertain, so that later
/// fits estimate it.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope add rig.toml external-leakage@A --fit record.csv -o new.toml")]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// The effect and its place, such as `external-leakage@A`; `borescope effects` lists them
    #[arg(value_name = "EFFECT[@PLACE]")]
    effect: String,
    /// Fit its parameters to this record, together with everything uncertain and all faults
    #[arg(long, value_name = "RECORD")]
    fit: Option<PathBuf>,
    /// Where the new rig file is written
    #[arg(short, long, value_name = "NEW.toml")]
    output: PathBuf,
    /// How the summary is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    // The rig file may take its own place.
    arguments.overwriting.outputs().reading(&arguments.fit).writing(&arguments.output)?;
    let text = read_text(&arguments.rig)?;
    let rig = Rig::parse(&arguments.rig, text.clone())?.with_context(context);
    let record = arguments.fit.as_ref().map(|path| read::record(&rig, path)).transpose()?;
    let new = add(&text, &rig, &arguments.effect, record.as_ref())?;
    write_atomically(&arguments.output, |file| file.write_all(new.text.as_bytes()))?;
    // With `-o /dev/stdout` more would stand in the rig file.
    if is_kept(&arguments.output) {
        let added = Rig::parse(&arguments.output, new.text)?;
        let summary = Summary::new(arguments, &rig, &added, (new.delta_bic, new.warnings));
        match arguments.format {
            Format::Json => write_json(out, &summary)?,
            Format::Text => write_text(out, &summary)?,
        }
    }
    Ok(Status::Done)
}

/// What was added, as programs read it.
#[derive(Serialize)]
struct Summary {
    schema: &'static str,
    /// The new rig file, as it was called.
    rig: String,
    effects: Vec<Effect>,
    /// Fall of the information criterion on the record with them.
    delta_bic: Option<f64>,
    /// What speaks against them as fitted.
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Effect {
    id: String,
    parameters: Vec<Parameter>,
}

/// Numbers in `unit`; `sigma` is one standard deviation, 0 for a value taken as exact.
#[derive(Serialize)]
struct Parameter {
    id: String,
    value: f64,
    sigma: f64,
    unit: String,
}

impl Summary {
    /// The effects of `added` that `before` does not have.
    fn new(
        arguments: &Arguments,
        before: &Rig,
        added: &Rig,
        (delta_bic, warnings): (Option<f64>, Vec<String>),
    ) -> Self {
        let parameter = |&index: &usize| {
            let parameter = &added.parameters[index];
            Parameter {
                id: parameter.id.clone(),
                value: rounded(parameter.unit.from_si(parameter.value), DIGITS),
                sigma: rounded(parameter.unit.difference_from_si(parameter.sigma), DIGITS),
                unit: parameter.unit.to_string(),
            }
        };
        let new = added.effects.iter().filter(|effect| before.effects.iter().all(|old| old.id != effect.id));
        let effects = new
            .map(|effect| Effect {
                id: effect.id.clone(),
                parameters: effect.parameters.iter().map(parameter).collect(),
            })
            .collect();
        Self {
            schema: "borescope.addition/1",
            rig: arguments.output.display().to_string(),
            effects,
            delta_bic: delta_bic.map(|fall| rounded(fall, DIGITS)),
            warnings,
        }
    }
}

fn write_text(out: &mut dyn Write, summary: &Summary) -> io::Result<()> {
    for effect in &summary.effects {
        writeln!(out, "{}: {} added", summary.rig, effect.id)?;
        for Parameter { id, value, sigma, unit } in &effect.parameters {
            writeln!(out, "  {id} = {} (one standard deviation)", before_unit(plus_minus(*value, *sigma), unit))?;
        }
    }
    for warning in &summary.warnings {
        writeln!(out, "  {warning}")?;
    }
    match summary.delta_bic {
        Some(fall) if fall < 0.0 => writeln!(
            out,
            "  the record does not ask for it: the information criterion rises by {:.1}, and has to fall by {RIVAL:.0}",
            -fall
        )?,
        Some(fall) if fall < RIVAL => writeln!(
            out,
            "  the record does not ask for it: the information criterion falls by {fall:.1}, and has to by {RIVAL:.0}"
        )?,
        Some(fall) => writeln!(out, "  the record asks for it: the information criterion falls by {fall:.1}")?,
        None => {}
    }
    Ok(())
}
