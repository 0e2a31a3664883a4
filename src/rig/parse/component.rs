//! Components: kind, ports, inputs, parameters, initial states.

use super::card_unit;
use super::kinds::{Found, Kinds};
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::physics::card::{Card, Role};
use crate::physics::fluid::{self, Fluid};
use crate::rig::source::{Table, Value};
use crate::rig::{Component, Parameter, Rig, range};
use crate::units::Quantity;

/// Appends the parameters of a card, as the table gives them.
pub(super) fn read_parameters(rig: &mut Rig, owner: &str, card: &Card, table: &Table<'_>) -> Result<(), Complaint> {
    for parameter in card.parameters {
        let unit = card_unit(parameter.unit);
        let id = format!("{owner}.{}", parameter.name);
        let bounds = (unit.difference_to_si(parameter.bounds.0), unit.difference_to_si(parameter.bounds.1));
        let own = table.get(parameter.name);
        let is_own = own.is_some();
        let entry = own.or_else(|| parameter.default_from.and_then(|other| table.get(other)));
        let (value, written, sigma, place) = match (entry, card.default_of(parameter)) {
            (Some(entry), _) => {
                let stated = entry.stated(unit.dimension)?;
                if stated.value < bounds.0 || stated.value > bounds.1 {
                    return Err(Complaint::new(
                        Kind::Bounds,
                        format!(
                            "{} is {}, outside its physical bounds",
                            entry.what,
                            Quantity { value: stated.value, unit: stated.unit }
                        ),
                    )
                    .at(entry.place())
                    .help(format!("{}: {}", parameter.meaning, range(bounds, &unit))));
                }
                (stated.value, stated.unit, stated.sigma.filter(|_| is_own), entry.place())
            }
            (None, Some(default)) => (unit.difference_to_si(default), unit.clone(), None, table.place()),
            (None, None) => {
                let help = format!("add `{} = \"... {unit}\"`: {}", parameter.name, parameter.meaning);
                let asked = card.parameters.iter().map(|other| other.name);
                return Err(table.lacks(parameter.name, asked, &help));
            }
        };
        let is_switched_off = value == 0.0 && parameter.default.is_some_and(|default| default != 0.0);
        let of = if value != 0.0 || is_switched_off { value.abs() } else { unit.factor };
        rig.parameters.push(Parameter {
            id,
            unit: written,
            value,
            bounds,
            sigma: sigma.unwrap_or(parameter.tolerance * of),
            // A volume of which the file says how sure it is: one value throughout, which records may find.
            per_event: parameter.per_event && !(parameter.role == Role::Volume && sigma.is_some()),
            role: parameter.role,
            spread: spread(parameter.spread * of, sigma),
            meaning: parameter.meaning.to_owned(),
            place,
        });
    }
    Ok(())
}

/// How far a part may be from its data sheet: as far as parts of its kind are, or as the file states if that is more. What it states as
/// exact is not calibrated.
fn spread(of_kind: f64, stated: Option<f64>) -> f64 {
    stated.map_or(of_kind, |stated| if stated == 0.0 { 0.0 } else { stated.max(of_kind) })
}

pub(super) fn read_component(rig: &mut Rig, kinds: &Kinds, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let table = value.table(format!("component `{name}`"))?;
    if matches!(name, "fluid" | "sensor") {
        return Err(Complaint::new(Kind::Contradiction, format!("`{name}` cannot be the name of a component"))
            .at(value.place())
            .help("the name stands for other parameters; choose another"));
    }
    // The names of all kinds have the catalogue read, so only a message asks for them.
    let missing = || table.require("kind", &help_with_names("", "component kinds", kinds.names()));
    let found = kinds.find(&table.get("kind").map_or_else(missing, Ok)?)?;
    let card = found.card();
    let ports = read_ports(rig, name, card, &table)?;
    let inputs = read_component_inputs(rig, name, card, &table)?;
    let first_parameter = rig.parameters.len();
    read_parameters(rig, name, card, &table)?;
    if inputs.iter().all(|&input| rig.inputs[input].noise == 0.0) {
        let own = rig.parameters[first_parameter..].iter_mut();
        own.filter(|own| own.role == Role::Instrument).for_each(|own| own.spread = 0.0);
    }
    let mut initial = vec![None; card.states.len()];
    if let Found::Own(own) = found {
        let nominal = rig.nominal();
        let fluid = Fluid::new(&nominal[..fluid::CARD.parameters.len()]);
        own.check_domain(&nominal[first_parameter..], &fluid, &value.place())?;
        initial.clone_from(&own.initial);
        if rig.components.iter().all(|other| other.card.kind != card.kind) {
            rig.own_effects.extend(&own.effects);
        }
    }
    let mut usual_start: Vec<bool> = initial.iter().map(Option::is_some).collect();
    if let Some(value) = table.get("initial") {
        let states = value.table(format!("`initial` of component `{name}`"))?;
        for ((slot, usual), state) in initial.iter_mut().zip(&mut usual_start).zip(card.states) {
            if let Some(value) = states.get(state.name) {
                (*slot, *usual) = (Some(value.quantity(card_unit(state.unit).dimension)?.value), false);
            }
        }
        states.finish()?;
    }
    table.finish()?;
    rig.components.push(Component {
        name: name.to_owned(),
        card,
        ports,
        inputs,
        first_parameter,
        initial,
        usual_start,
        margin: false,
        drop: None,
        place: value.place(),
    });
    Ok(())
}

/// The node of each port, in the order of the card.
fn read_ports(rig: &Rig, name: &str, card: &Card, table: &Table<'_>) -> Result<Vec<usize>, Complaint> {
    let port_list: Vec<&str> = card.ports.iter().map(|port| port.name).collect();
    let help = format!(
        "`{}` needs `ports = {{ {} }}`",
        card.kind,
        port_list.iter().map(|port| format!("{port} = \"node\"")).collect::<Vec<_>>().join(", ")
    );
    let ports_value = table.require("ports", &help)?;
    let ports_table = ports_value.table(format!("`ports` of component `{name}`"))?;
    let mut ports = Vec::new();
    for port in card.ports {
        let entry = ports_table.require(port.name, &help)?;
        let node = entry.text()?;
        let Some(node) = rig.node(node) else {
            return Err(Complaint::new(
                Kind::UnknownName,
                format!("port `{}` of `{name}` is joined to `{node}`, which is no node", port.name),
            )
            .at(entry.place())
            .help(help_with_names(node, "nodes", rig.nodes.iter().map(|node| node.name.as_str()))));
        };
        ports.push(node);
    }
    ports_table.finish()?;
    Ok(ports)
}

/// The input of each of the card's inputs.
fn read_component_inputs(rig: &Rig, name: &str, card: &Card, table: &Table<'_>) -> Result<Vec<usize>, Complaint> {
    let mut inputs = Vec::new();
    for input in card.inputs {
        let entry = table
            .require(input.name, &format!("name the input that is the {} of this `{}`", input.meaning, card.kind))?;
        let wanted = entry.text()?;
        let Some(index) = rig.inputs.iter().position(|input| input.name == wanted) else {
            return Err(Complaint::new(
                Kind::UnknownName,
                format!("`{}` of `{name}` is `{wanted}`, which is no input", input.name),
            )
            .at(entry.place())
            .help(help_with_names(wanted, "inputs", rig.inputs.iter().map(|input| input.name.as_str()))));
        };
        let unit = card_unit(input.unit);
        if rig.inputs[index].unit.dimension != unit.dimension {
            return Err(Complaint::new(
                Kind::Dimension,
                format!(
                    "`{}` of `{name}` must be a {}, but input `{wanted}` is a {}",
                    input.name, unit.dimension, rig.inputs[index].unit.dimension
                ),
            )
            .at(entry.place())
            .at(rig.inputs[index].place.clone())
            .help(format!("use an input in {}", input.unit)));
        }
        inputs.push(index);
    }
    Ok(inputs)
}
