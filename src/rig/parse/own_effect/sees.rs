//! Where a formula of the rig file's own acts, and what it may see there.

use super::{Own, Value};
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::expression::Name;
use crate::physics::card::PortKind;
use crate::physics::ports::{INPUTS, PORTS, VARIABLES};
use crate::rig::{Component, NodeKind, Rig};
use crate::units::Dimension;

/// Where an effect acts, and on what.
#[derive(Debug, Clone, Copy)]
pub(super) enum Acts {
    /// The flow out of this node.
    Flow(usize),
    /// The force on this body.
    Force(usize),
    /// What this sensor shows.
    Reading(usize),
    /// Pressure ahead of this component.
    Drop(usize),
}

/// What a formula sees.
pub(super) struct Sees {
    /// Those that its ports meet: where it acts, the tank behind a flow, and what else it names.
    pub nodes: Vec<usize>,
    pub inputs: Vec<usize>,
    pub time: bool,
}

/// How a formula calls the time since the run began.
const TIME: &str = "t";
/// And what a sensor would show.
const READING: &str = "reading";
/// And the flow into the first port of a component.
pub(super) const THROUGH: &str = "q";

/// The names and numbers of a formula; what stands in brackets are units.
pub(in crate::rig::parse) fn words(formula: &str) -> impl Iterator<Item = &str> {
    let part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
    let outside = |(place, text): (usize, _)| {
        if place == 0 { Some(text) } else { str::split_once(text, ']').map(|(_, rest)| rest) }
    };
    formula.split('[').enumerate().filter_map(outside).flat_map(move |text| text.split(move |c: char| !part(c)))
}

pub(super) fn acts(rig: &Rig, value: &Value<'_>) -> Result<Acts, Complaint> {
    let name = value.text()?;
    match rig.node(name).map(|node| (node, &rig.nodes[node].kind)) {
        Some((node, NodeKind::Volume { .. })) => return Ok(Acts::Flow(node)),
        Some((node, NodeKind::Body { .. })) => return Ok(Acts::Force(node)),
        Some((_, NodeKind::Held { .. })) | None => {}
    }
    let sensor = rig.sensors.iter().position(|sensor| sensor.name == name).map(Acts::Reading);
    let throttles = |component: &&Component| component.card.throttles;
    let throttle = || rig.components.iter().position(|one| throttles(&one) && one.name == name).map(Acts::Drop);
    sensor.or_else(throttle).ok_or_else(|| {
        let free = rig.nodes.iter().filter(|node| !matches!(node.kind, NodeKind::Held { .. }));
        let components = rig.components.iter().filter(throttles).map(|component| &component.name);
        let places = free.map(|node| &node.name).chain(rig.sensors.iter().map(|sensor| &sensor.name)).chain(components);
        Complaint::new(Kind::UnknownName, format!("nothing can act at `{name}`"))
            .at(value.place())
            .help(help_with_names(name, "nodes, sensors and throttles", places.map(String::as_str)))
    })
}

pub(super) fn kind(rig: &Rig, node: usize) -> PortKind {
    if matches!(rig.nodes[node].kind, NodeKind::Body { .. }) { PortKind::Mechanical } else { PortKind::Hydraulic }
}

impl Sees {
    pub fn of(rig: &Rig, acts: Acts, own: &[Own], formula: &Value<'_>) -> Result<Self, Complaint> {
        let mut nodes: Vec<usize> = match acts {
            Acts::Flow(node) => vec![node, tank(rig, formula)?],
            Acts::Force(body) => vec![body],
            // Of a sample nothing else is known when it is read, of a throttle nothing but what passes it.
            Acts::Reading(_) | Acts::Drop(_) => return Ok(Self::alone(rig, acts)),
        };
        let (mut inputs, mut time) = (Vec::new(), false);
        for word in words(formula.text()?) {
            if own.iter().any(|own| own.name == word) {
                continue;
            }
            time |= word == TIME;
            let input = rig.inputs.iter().position(|input| input.name == word);
            inputs.extend(input.filter(|input| !inputs.contains(input)));
            let node = word.rsplit_once('.').and_then(|(name, _)| rig.node(name));
            nodes.extend(node.filter(|node| !nodes.contains(node)));
        }
        let too_many = |what: &str, help: String| {
            Err(Complaint::new(Kind::Bounds, format!("the formula looks at too many {what}"))
                .at(formula.place())
                .help(help))
        };
        let variables: usize = nodes.iter().map(|&node| kind(rig, node).variables()).sum();
        if nodes.len() > PORTS || variables > VARIABLES {
            return too_many(
                "nodes",
                format!("it may meet {PORTS} nodes with {VARIABLES} variables, the tank among them"),
            );
        }
        if inputs.len() + usize::from(time) > INPUTS {
            return too_many("inputs", format!("it may see {INPUTS}, the time `{TIME}` among them"));
        }
        Ok(Self { nodes, inputs, time })
    }

    /// What a formula sees that does not look around: the time at a sensor, the nodes at both ends of a throttle.
    fn alone(rig: &Rig, acts: Acts) -> Self {
        let nodes = if let Acts::Drop(component) = acts { rig.components[component].ports.clone() } else { Vec::new() };
        Self { nodes, inputs: Vec::new(), time: matches!(acts, Acts::Reading(_)) }
    }

    /// All that a formula that acts there might see.
    pub fn everything(rig: &Rig, acts: Acts) -> Self {
        if matches!(acts, Acts::Reading(_) | Acts::Drop(_)) {
            return Self::alone(rig, acts);
        }
        let free = |&node: &usize| !matches!(rig.nodes[node].kind, NodeKind::Held { .. });
        let nodes = (0..rig.nodes.len()).filter(free).collect();
        Self { nodes, inputs: (0..rig.inputs.len()).collect(), time: true }
    }

    /// The names of what it sees, in the order in which a formula is given it.
    pub fn names(&self, rig: &Rig, acts: Acts) -> Vec<Name> {
        let of = |&node: &usize| {
            let name = &rig.nodes[node].name;
            match kind(rig, node) {
                PortKind::Hydraulic => vec![Name::new(format!("{name}.p"), Dimension::PRESSURE)],
                PortKind::Mechanical => vec![
                    Name::new(format!("{name}.x"), Dimension::LENGTH),
                    Name::new(format!("{name}.v"), Dimension::VELOCITY),
                ],
            }
        };
        let mut names: Vec<Name> = self.nodes.iter().flat_map(of).collect();
        if let Acts::Reading(sensor) = acts {
            names.push(Name::new(READING.to_owned(), rig.sensors[sensor].dimension));
        }
        if let Acts::Drop(_) = acts {
            names.push(Name::new(THROUGH.to_owned(), Dimension::FLOW));
        }
        let input = |&input: &usize| Name::new(rig.inputs[input].name.clone(), rig.inputs[input].unit.dimension);
        names.extend(self.inputs.iter().map(input));
        names.extend(self.time.then(|| Name::new(TIME.to_owned(), Dimension::TIME)));
        names
    }
}

/// The node of the tank, behind a flow.
fn tank(rig: &Rig, formula: &Value<'_>) -> Result<usize, Complaint> {
    let tank = rig.components.iter().find(|component| component.card.fixes_pressure.is_some());
    tank.map(|tank| tank.ports[0]).ok_or_else(|| {
        Complaint::new(Kind::MissingEntry, "a flow needs a tank to go to, and this rig has none")
            .at(formula.place())
            .help("add a component of kind `tank`")
    })
}
