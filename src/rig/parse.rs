//! From the text of a rig file to a [`Rig`].

mod calibration;
pub(crate) mod catalogue;
mod component;
mod cycle;
mod effect;
mod fault;
mod input;
mod kept;
mod kinds;
mod node;
mod own_component;
mod own_effect;
mod sensor;
mod version;

use toml::de::DeTable;

use self::kinds::Kinds;
use super::source::{Source, Table, Value};
use super::{Node, NodeKind, Rig};
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::context::Context;
use crate::physics::fluid;
use crate::units::{Dimension, Unit};

pub fn parse(source: Source) -> Result<Rig, Complaint> {
    let document = DeTable::parse(&source.text).map_err(|error| not_toml(&source, &error))?;
    let root = Table::new(&source, "the rig file", 0..0, document.get_ref());
    version::check(root.get("version"))?;
    let name = match root.get("rig") {
        None => String::new(),
        Some(value) => {
            let table = value.table("`[rig]`")?;
            let name = table.get("name").map(|name| name.name().map(str::to_owned)).transpose()?.unwrap_or_default();
            table.finish()?;
            name
        }
    };
    let mut rig = Rig {
        path: source.path.clone(),
        name,
        nodes: Vec::new(),
        components: Vec::new(),
        sensors: Vec::new(),
        inputs: Vec::new(),
        temperature: None,
        parameters: Vec::new(),
        faults: Vec::new(),
        effects: Vec::new(),
        own_effects: Vec::new(),
        readings: Vec::new(),
        cycle: None,
        calibration: None,
        parts_deviate: false,
        before: Vec::new(),
        beside: Vec::new(),
        unfilled: Vec::new(),
        #[cfg(feature = "cli")]
        own_digest: String::new(),
        context: Context::default(),
    };
    let fluid_table =
        root.require("fluid", "add `[fluid]` with density, viscosity and bulk_modulus")?.table("`[fluid]`")?;
    component::read_parameters(&mut rig, "fluid", &fluid::CARD, &fluid_table)?;
    rig.temperature = fluid_table.get("temperature").map(|value| input::read_temperature(&value)).transpose()?;
    fluid_table.finish()?;
    input::read_inputs(&mut rig, root.get("inputs"))?;
    let nodes = root.require("nodes", "add `[nodes]` with one line per node, such as `pump_line = {}`")?;
    let nodes = nodes.table("`[nodes]`")?;
    for (name, value) in nodes.named_entries()? {
        // Ports decide below what a node is.
        rig.nodes.push(Node {
            name: name.to_owned(),
            kind: NodeKind::Held { parameter: usize::MAX },
            place: value.place(),
        });
    }
    let mut kinds = Kinds::of(&source, &root)?;
    rig.beside = std::mem::take(&mut kinds.beside);
    let components = root.require("components", "add `[components.NAME]` with a `kind` and its `ports`")?;
    for (name, value) in components.table("`[components]`")?.named_entries()? {
        component::read_component(&mut rig, &kinds, name, &value)?;
    }
    for (name, value) in nodes.entries() {
        node::resolve_node(&mut rig, name, &value)?;
    }
    if let Some(sensors) = root.get("sensors") {
        for (name, value) in sensors.table("`[sensors]`")?.named_entries()? {
            sensor::read_sensor(&mut rig, name, &value)?;
        }
    }
    if let Some(effects) = root.get("own_effects") {
        for (name, value) in effects.table("`[own_effects]`")?.named_entries()? {
            own_effect::read_own_effect(&mut rig, name, &value)?;
        }
    }
    if let Some(effects) = root.get("effects") {
        for (id, value) in effects.table("`[effects]`")?.named_entries()? {
            effect::read_effect(&mut rig, id, &value)?;
        }
    }
    if let Some(faults) = root.get("faults") {
        for (id, value) in faults.table("`[faults]`")?.named_entries()? {
            fault::read_fault(&mut rig, id, &value)?;
        }
    }
    if let Some(cycle) = root.get("cycle") {
        rig.cycle = Some(cycle::read_cycle(&rig, &cycle)?);
    }
    if let Some(value) = root.get("calibration") {
        calibration::read_calibration(&mut rig, &value)?;
    }
    root.finish()?;
    Ok(rig)
}

/// The complaint about a text that is no TOML.
fn not_toml(source: &Source, error: &toml::de::Error) -> Complaint {
    let span = error.span().unwrap_or_default();
    let place = source.place(span.clone());
    if error.message().contains("duplicate key") {
        return duplicate_key(source, span);
    }
    let help = if error.message().contains("unquoted key") {
        "put a key with a point or an `@` between quotes: `\"external-leakage@A\" = { ... }`"
    } else {
        "the rig file is named before the record; see docs/reference/rig-file.md for one to start from"
    };
    Complaint::new(Kind::Syntax, format!("this is not TOML: {}", error.message().replace('\n', "; ")))
        .at(place)
        .help(help)
}

/// The complaint about a key that appears twice, with both places where the first is found.
fn duplicate_key(source: &Source, span: std::ops::Range<usize>) -> Complaint {
    let key = source.text.get(span.clone()).unwrap_or_default().trim();
    let complaint = Complaint::new(Kind::Duplicate, format!("this is not TOML: the key `{key}` appears twice"))
        .help("give each key of a table once");
    match source.earlier(key, span.start) {
        Some(first) => complaint.at(source.place(first)).at(source.place(span)),
        None => complaint.at(source.place(span)),
    }
}

/// The unit of a card. Cards are constants whose units a test reads, so a miss can only be a dimensionless stand-in.
pub(super) fn card_unit(symbol: &str) -> Unit {
    Unit::parse(symbol).unwrap_or_else(|_| Unit::dimensionless())
}

/// A standard deviation, resolution or lag: 0 or more, without offset.
fn difference(value: &Value<'_>, dimension: Dimension) -> Result<f64, Complaint> {
    let quantity = value.quantity(dimension)?;
    let difference = quantity.unit.difference_to_si(quantity.in_unit());
    if difference < 0.0 {
        return Err(Complaint::new(Kind::Bounds, format!("{} is negative", value.what))
            .at(value.place())
            .help("write 0 or more"));
    }
    Ok(difference)
}

/// One of a few named choices.
fn named<T: Copy>(value: &Value<'_>, what: &str, choices: &[(&str, T)]) -> Result<T, Complaint> {
    let text = value.text()?;
    choices.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice).ok_or_else(|| {
        Complaint::new(Kind::UnknownName, format!("{} is `{text}`", value.what))
            .at(value.place())
            .help(help_with_names(text, what, choices.iter().map(|(name, _)| *name)))
    })
}
