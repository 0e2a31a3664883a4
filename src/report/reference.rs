//! The parts of the reference that follow from data: component cards, sensor quantities, units; cards of effects.
//!
//! A page marks where a part stands with `<!-- generated: NAME -->` and `<!-- end -->`; [`refresh`] writes what is between
//! the marks. So a new component, parameter or unit reaches the page without anybody copying it there.

use std::fmt::{self, Write};

use crate::physics::card::{Answer, Card, Parameter, PortKind};
use crate::physics::component::CARDS;
use crate::physics::fluid;
use crate::rig::{Hold, Quantity, range};
use crate::units::{Dimension, Unit};

/// What a page asks for and nobody writes, or a mark that does not close.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PageError {
    /// No part has this name.
    Unknown { name: String },
    /// `<!-- end -->` is missing behind the mark of this part.
    Open { name: String },
    /// The page marks no place for this part.
    Unmarked { name: &'static str },
}

impl fmt::Display for PageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { name } => write!(f, "no generated part is called `{name}`"),
            Self::Open { name } => write!(f, "`{END}` is missing behind the mark of `{name}`"),
            Self::Unmarked { name } => write!(f, "the page has no mark `{BEGIN}{name} -->`"),
        }
    }
}

impl std::error::Error for PageError {}

const BEGIN: &str = "<!-- generated: ";
const END: &str = "<!-- end -->";

/// A generated part and what writes it.
pub type Part = (&'static str, fn(&mut String) -> fmt::Result);

/// The generated parts of `rig-file.md`.
pub const RIG_FILE: &[Part] = &[
    ("fluid", fluid_part),
    ("components", components_part),
    ("quantities", quantities_part),
    ("holds", holds_part),
    ("units", units_part),
];

/// The generated parts of `effects.md`.
pub const LIBRARY: &[Part] = &[("effects", super::effects::markdown)];

/// The generated parts of `settings.md`.
pub const SETTINGS: &[Part] = &[("settings", super::settings::markdown)];

/// The page with every one of its generated parts as it is now.
///
/// # Errors
/// A mark that names no part, a mark that does not close, a part without mark.
pub fn refresh(page: &str, parts: &[Part]) -> Result<String, PageError> {
    let mut fresh = String::new();
    let mut rest = page;
    let mut written = Vec::new();
    while let Some((before, behind)) = rest.split_once(BEGIN) {
        let (name, behind) = behind.split_once(" -->").unwrap_or((behind, ""));
        let Some((known, write)) = parts.iter().find(|(known, _)| *known == name) else {
            return Err(PageError::Unknown { name: name.to_owned() });
        };
        let Some((_, behind)) = behind.split_once(END) else {
            return Err(PageError::Open { name: name.to_owned() });
        };
        let mut part = String::new();
        // Writing to a `String` cannot fail.
        let _ = write(&mut part);
        fresh.push_str(&format!("{before}{BEGIN}{name} -->\n\n{}\n\n{END}", part.trim()));
        written.push(*known);
        rest = behind;
    }
    fresh.push_str(rest);
    match parts.iter().find(|(name, _)| !written.contains(name)) {
        Some((name, _)) => Err(PageError::Unmarked { name }),
        None => Ok(fresh),
    }
}

fn fluid_part(out: &mut String) -> fmt::Result {
    parameters(out, fluid::CARD.parameters)
}

fn components_part(out: &mut String) -> fmt::Result {
    for card in CARDS {
        component(out, card)?;
    }
    Ok(())
}

fn component(out: &mut String, card: &Card) -> fmt::Result {
    writeln!(out, "### `{}`\n\n{}\n", card.kind, card.meaning)?;
    writeln!(out, "```text\n{}\n```\n", card.law)?;
    writeln!(out, "*Holds for:* {}\n", card.validity)?;
    writeln!(out, "*Source:* {}.\n", card.source.trim_end_matches('.'))?;
    writeln!(out, "| port | meets | meaning |\n|---|---|---|")?;
    for port in card.ports {
        let meets = match port.kind {
            PortKind::Hydraulic => "hydraulic node",
            PortKind::Mechanical => "body",
        };
        writeln!(out, "| `{}` | {meets} | {} |", port.name, port.meaning)?;
    }
    writeln!(out)?;
    if !card.inputs.is_empty() {
        writeln!(out, "| input | unit | meaning |\n|---|---|---|")?;
        for input in card.inputs {
            writeln!(out, "| `{}` | {} | {} |", input.name, input.unit, input.meaning)?;
        }
        writeln!(out)?;
    }
    if card.parameters.is_empty() {
        writeln!(out, "No parameters.\n")?;
    } else {
        parameters(out, card.parameters)?;
    }
    if !card.states.is_empty() {
        writeln!(out, "| state | unit | meaning |\n|---|---|---|")?;
        for state in card.states {
            writeln!(out, "| `{}` | {} | {} |", state.name, state.unit, state.meaning)?;
        }
        writeln!(out)?;
    }
    for worked in card.worked {
        let (what, unit) = match worked.answer {
            Answer::Through(port) => match card.ports.get(port).map(|port| (port.name, port.kind)) {
                Some((name, PortKind::Mechanical)) => (format!("force at `{name}`"), "N"),
                Some((name, PortKind::Hydraulic)) => (format!("flow into `{name}`"), "m3/s"),
                None => continue,
            },
            Answer::Capacity(port) => match card.ports.get(port) {
                Some(port) => (format!("capacity at `{}`", port.name), "m3/Pa"),
                None => continue,
            },
            Answer::Rate(state) => match card.states.get(state) {
                Some(state) => (format!("rate of `{}`", state.name), "SI per s"),
                None => continue,
            },
        };
        writeln!(out, "*Worked:* {}; {what} {} {unit}.\n", worked.text, number(worked.expect))?;
    }
    Ok(())
}

fn parameters(out: &mut String, parameters: &[Parameter]) -> fmt::Result {
    writeln!(
        out,
        "| parameter | symbol | unit | default | range | uncertainty | calibrated | meaning |\n|---|---|---|---|---|---|---|---|"
    )?;
    for parameter in parameters {
        let default = match (parameter.default_from, parameter.default) {
            (Some(other), _) => format!("`{other}`"),
            (None, Some(default)) => number(default),
            (None, None) => "must be given".to_owned(),
        };
        // Cards are constants whose units a test reads.
        let unit = Unit::parse(parameter.unit).unwrap_or_else(|_| Unit::dimensionless());
        let bounds = (unit.difference_to_si(parameter.bounds.0), unit.difference_to_si(parameter.bounds.1));
        writeln!(
            out,
            "| `{}` | {} | {} | {default} | {} | {} | {} | {} |",
            parameter.name,
            parameter.symbol.replace('_', "\\_"),
            parameter.unit,
            range(bounds, &unit),
            uncertainty(parameter),
            calibrated(parameter),
            parameter.meaning
        )?;
    }
    writeln!(out)
}

fn uncertainty(parameter: &Parameter) -> String {
    let share = crate::units::Quantity { value: parameter.tolerance, unit: percent() };
    match (parameter.tolerance > 0.0, parameter.per_event) {
        (false, _) => "exact".to_owned(),
        (true, false) => share.to_string(),
        (true, true) => format!("{share}, per switching"),
    }
}

/// What calibration starts from, as the table shows it.
fn calibrated(parameter: &Parameter) -> String {
    let share = crate::units::Quantity { value: parameter.spread, unit: percent() };
    if parameter.spread > 0.0 { share.to_string() } else { String::new() }
}

fn percent() -> Unit {
    Unit { symbol: "%".to_owned(), dimension: Dimension::NONE, factor: 1e-2, offset: 0.0 }
}

/// Six digits at most, with an exponent where the number is very large or small.
fn number(value: f64) -> String {
    let value = format!("{value:.5e}").parse().unwrap_or(value);
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-4..1e7).contains(&magnitude) { format!("{value:e}") } else { value.to_string() }
}

fn quantities_part(out: &mut String) -> fmt::Result {
    writeln!(out, "| quantity | sits at | what it reads | units |\n|---|---|---|---|")?;
    for (name, quantity) in Quantity::NAMED {
        let (at, reads) = match quantity {
            Quantity::Pressure => ("hydraulic node", "gauge pressure"),
            Quantity::Flow => ("`component.port`", "flow into the port, or out of it with `direction = \"out\"`"),
            Quantity::Position => ("body", "position"),
            Quantity::Velocity => ("body", "velocity"),
            Quantity::Level => ("node with a volume", "height of fluid, `(p - p_atm)/(rho g)`"),
            Quantity::Force => (
                "`component.port`",
                "force of the component on the body at the port, in the direction of its position, without the inertia of its own mass: a load cell between them",
            ),
            Quantity::State => ("`component.state`", "state of a component: spool position, speed of a shaft"),
        };
        let units = quantity.dimension().map_or("those of the state".to_owned(), units);
        writeln!(out, "| `{name}` | {at} | {reads} | {units} |")?;
    }
    Ok(())
}

fn holds_part(out: &mut String) -> fmt::Result {
    writeln!(out, "| `hold` | what a row says |\n|---|---|")?;
    for (name, hold) in Hold::NAMED {
        let says = match hold {
            Hold::Before => "the value that acted over the interval before the row",
            Hold::After => "the value that acts from the row to the next; where nothing is said",
            Hold::Linear => "a point of a line that runs straight from row to row",
        };
        writeln!(out, "| `{name}` | {says} |")?;
    }
    Ok(())
}

fn units_part(out: &mut String) -> fmt::Result {
    writeln!(out, "| dimension | units |\n|---|---|")?;
    for (dimension, name) in Dimension::named() {
        writeln!(out, "| {name} | {} |", units(dimension))?;
    }
    let spelling = |(other, symbol): &(&str, &str)| format!("`{other}` for `{symbol}`");
    let spellings: Vec<String> = Unit::spellings().iter().map(spelling).collect();
    writeln!(out, "\nAlso read: {}.", spellings.join(", "))
}

fn units(dimension: Dimension) -> String {
    let known: Vec<String> = Unit::known_for(dimension).iter().map(|unit| format!("`{unit}`")).collect();
    known.join(", ")
}
