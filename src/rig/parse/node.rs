//! Nodes: what they are, and how they start.

use crate::complaint::{Complaint, Kind};
use crate::physics::card::PortKind;
use crate::physics::card::Role;
use crate::rig::source::{Table, Value};
use crate::rig::{InitialPressure, NodeKind, Parameter, Rig};
use crate::units::Dimension;

/// Decides what a node is from the ports that meet there, and reads how it starts.
pub(super) fn resolve_node(rig: &mut Rig, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let Some(index) = rig.node(name) else { return Ok(()) };
    let mut kinds = Vec::new();
    let mut held = None;
    for component in &rig.components {
        for (port, &node) in component.card.ports.iter().zip(&component.ports) {
            if node == index {
                kinds.push((port.kind, &component.name));
                if let Some(parameter) = component.card.fixes_pressure {
                    if held.is_some() {
                        let what = format!("two components keep the pressure of node `{name}`");
                        return Err(Complaint::new(Kind::Contradiction, what)
                            .at(value.place())
                            .at(component.place.clone())
                            .help(format!("join `{}` to a node of its own", component.name)));
                    }
                    held = Some(component.first_parameter + parameter);
                }
            }
        }
    }
    let Some(&(kind, _)) = kinds.first() else {
        return Err(Complaint::new(Kind::MissingEntry, format!("nothing is joined to node `{name}`"))
            .at(value.place())
            .help("join a component's port to it, or delete the line"));
    };
    if let Some((_, other)) = kinds.iter().find(|(other, _)| *other != kind) {
        return Err(Complaint::new(
            Kind::Contradiction,
            format!("hydraulic and mechanical ports meet at node `{name}`"),
        )
        .at(value.place())
        .help(format!("give `{other}` a node of its own there")));
    }
    let table = value.table(format!("node `{name}`"))?;
    let node_kind = match (kind, held) {
        (PortKind::Hydraulic, Some(parameter)) => NodeKind::Held { parameter },
        (PortKind::Hydraulic, None) => NodeKind::Volume { initial: initial_pressure(rig, name, &table)? },
        (PortKind::Mechanical, _) => {
            let read = |key: &str, dimension| table.get(key).map(|value| value.quantity(dimension)).transpose();
            NodeKind::Body {
                position: match table.get("position") {
                    None => Some(0.0),
                    Some(value) if value.text().is_ok_and(|text| text == "record") => None,
                    Some(value) => Some(value.quantity(Dimension::LENGTH)?.value),
                },
                velocity: read("velocity", Dimension::VELOCITY)?.map_or(0.0, |quantity| quantity.value),
            }
        }
    };
    table.finish()?;
    rig.nodes[index].kind = node_kind;
    Ok(())
}

fn initial_pressure(rig: &mut Rig, name: &str, table: &Table<'_>) -> Result<InitialPressure, Complaint> {
    let Some(value) = table.get("initial") else { return Ok(InitialPressure::Record) };
    match value.text() {
        Ok("balance") => Ok(InitialPressure::Balance),
        Ok("record") => Ok(InitialPressure::Record),
        _ => {
            let stated = value.stated(Dimension::PRESSURE)?;
            let Some(sigma) = stated.sigma.filter(|sigma| *sigma > 0.0) else {
                return Ok(InitialPressure::Given(stated.value));
            };
            rig.parameters.push(Parameter {
                id: format!("node.{name}.initial"),
                unit: stated.unit,
                value: stated.value,
                bounds: (-crate::physics::ATMOSPHERE, f64::INFINITY),
                sigma,
                per_event: false,
                role: Role::Plain,
                spread: 0.0,
                meaning: format!("pressure of node `{name}` at the start"),
                place: value.place(),
            });
            Ok(InitialPressure::Uncertain(rig.parameters.len() - 1))
        }
    }
}
