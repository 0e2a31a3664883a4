//! What can be wrong with a rig whose every line is right.

use super::{Component, FaultSet, InitialPressure, NodeKind, Parameter, Quantity, Rig, Sensor, Target};
use crate::complaint::{Complaint, Kind};
use crate::numeric::MOST_STATES;
use crate::physics::card::Role;
use crate::units::Quantity as Amount;

pub fn validate(rig: &Rig) -> Result<(), Complaint> {
    sizes(rig)?;
    for (index, node) in rig.nodes.iter().enumerate() {
        if !matches!(node.kind, NodeKind::Held { .. }) && !rig.has_capacity(index) {
            // A mass beyond the data sheet may be less than nothing, but what moves may not.
            let joined = rig.components.iter().filter(|component| component.ports.contains(&index));
            let mut own = joined.flat_map(|component| component.parameters()).map(|own| &rig.parameters[own]);
            if let Some(light) = own.find(|own| own.role == Role::Mass && own.value < 0.0) {
                let what = format!("`{}` leaves node `{}` no mass", light.id, node.name);
                return Err(Complaint::new(Kind::Bounds, what)
                    .at(light.place.clone())
                    .help("take away less than the mass of what it is joined to"));
            }
            let (what, help) = match node.kind {
                NodeKind::Body { .. } => ("mass", "join a component with a mass, such as a cylinder"),
                _ => ("volume", "join a `line-volume` to it: without one its pressure has no equation"),
            };
            return Err(Complaint::new(Kind::MissingEntry, format!("node `{}` has no {what}", node.name))
                .at(node.place.clone())
                .help(help));
        }
        if node.kind == (NodeKind::Volume { initial: InitialPressure::Record }) && !measured(rig, index) {
            return Err(Complaint::new(
                Kind::MissingEntry,
                format!("node `{}` has no `initial` pressure and no pressure sensor to take it from", node.name),
            )
            .at(node.place.clone())
            .help("add the pressure that it starts with, such as `initial = \"5 bar\"`"));
        }
        let follows = |sensor: &Sensor| sensor.target == Target::Node(index) && sensor.quantity == Quantity::Position;
        if matches!(node.kind, NodeKind::Body { position: None, .. }) && !rig.sensors.iter().any(follows) {
            return Err(Complaint::new(
                Kind::MissingEntry,
                format!("node `{}` begins where a sensor shows it, but no sensor reads its position", node.name),
            )
            .at(node.place.clone())
            .help("write the position that it begins at, such as `position = \"0 mm\"`"));
        }
        if node.kind == (NodeKind::Volume { initial: InitialPressure::Balance }) && !moves_a_body(rig, index) {
            return Err(Complaint::new(
                Kind::Contradiction,
                format!("node `{}` cannot start in balance: no body is moved by its pressure", node.name),
            )
            .at(node.place.clone())
            .help("write the pressure that it starts with, such as `initial = \"0 bar\"`, or join it to a cylinder"));
        }
    }
    let states = rig.states();
    if states > MOST_STATES {
        return Err(Complaint::new(Kind::Bounds, format!("the rig has {states} states, more than {MOST_STATES}"))
            .at(crate::complaint::Place::file(&rig.path))
            .help("join nodes whose pressures are alike, or leave out sensor lags that do not matter"));
    }
    if let Some(fault) = rig.faults.get(FaultSet::CAPACITY) {
        return Err(Complaint::new(Kind::Bounds, format!("more than {} faults", FaultSet::CAPACITY))
            .at(fault.place.clone())
            .help("no record can isolate so many; keep those that can happen"));
    }
    for follower in rig.followers().filter(|follower| !rig.is_alone(follower)) {
        let own = [follower.inertia_time, follower.dead_time].into_iter().flatten().map(|own| &rig.parameters[own]);
        if let Some(stated) = own.into_iter().find(|own| own.value > 0.0 || own.sigma > 0.0) {
            let input = &rig.inputs[follower.input];
            let what = format!("`{}` on an input that other parts have too, `{}`", stated.id, input.name);
            return Err(Complaint::new(Kind::Contradiction, what)
                .at(stated.place.clone())
                .at(input.place.clone())
                .help("leave it out: mass and dead time are those of a part that has its command alone"));
        }
    }
    columns(rig)
}

/// Parameters that may not exceed another one of their component.
fn sizes(rig: &Rig) -> Result<(), Complaint> {
    for component in &rig.components {
        let own = || component.card.parameters.iter().zip(component.parameters().map(|own| &rig.parameters[own]));
        for (card, inner) in own() {
            let Some(limit) = card.within_other else { continue };
            let Some((_, outer)) = own().find(|(card, _)| card.name == limit) else { continue };
            if inner.value > outer.value {
                let shown = |of: &Parameter| Amount { value: of.value, unit: of.unit.clone() };
                let what = format!("`{}` is {}, more than `{}`, {}", inner.id, shown(inner), outer.id, shown(outer));
                return Err(Complaint::new(Kind::Bounds, what)
                    .at(inner.place.clone())
                    .at(outer.place.clone())
                    .help(format!("the {} is at most the {}: check both units", card.meaning, limit)));
            }
        }
    }
    Ok(())
}

/// One column belongs to one sensor or input, or to the temperature of the fluid.
fn columns(rig: &Rig) -> Result<(), Complaint> {
    let sensors = rig.sensors.iter().map(|sensor| (&sensor.column, &sensor.place));
    let inputs = rig.inputs.iter().map(|input| (&input.column, &input.place));
    let temperature = rig.temperature.iter().map(|temperature| (&temperature.input.column, &temperature.input.place));
    let all: Vec<_> = inputs.chain(sensors).chain(temperature).collect();
    for (index, (column, place)) in all.iter().enumerate() {
        if *column == "time" {
            return Err(Complaint::new(Kind::Contradiction, "the column `time` is the time of the record")
                .at((*place).clone())
                .help("name the column that it is read from with `column = \"...\"`"));
        }
        if let Some((_, earlier)) = all.iter().take(index).find(|(other, _)| other == column) {
            return Err(Complaint::new(Kind::Duplicate, format!("the column `{column}` is read twice"))
                .at((*earlier).clone())
                .at((*place).clone())
                .help("give each sensor and input a column of its own with `column = \"...\"`"));
        }
    }
    Ok(())
}

fn measured(rig: &Rig, node: usize) -> bool {
    rig.sensors.iter().any(|sensor| {
        sensor.target == Target::Node(node) && matches!(sensor.quantity, Quantity::Pressure | Quantity::Level)
    })
}

/// Whether a component joins the node to a body, so that forces on the body set its pressure at rest.
fn moves_a_body(rig: &Rig, node: usize) -> bool {
    let mut joined = rig.components.iter().filter(|component| component.ports.contains(&node));
    joined.any(Component::moves_a_body)
}
