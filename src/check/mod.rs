//! What is in a rig file and in a record, as the program understands them, and what is doubtful in the record.

mod record;

use std::path::Path;

use serde::Serialize;

use crate::complaint::Complaint;
use crate::report::number::{difference_in_unit, in_unit, rounded};
use crate::rig::{InitialPressure, NodeKind, Quantity, Rig, Sensor, Target};

pub use record::{ChannelLine, PhaseInput, PhaseLine, RecordPage};

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.check/1";

/// What [`check`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// Rig file and record.
    pub report: CheckReport,
    /// What keeps a diagnosis from using the record.
    pub refused: Option<Complaint>,
}

/// Checks a record against a rig; without record, only says what is in the rig.
///
/// # Errors
/// A record that cannot be read at all, or a [context](crate::context) that was cancelled.
pub fn check(rig: &Rig, record: Option<&Path>) -> Result<Checked, Complaint> {
    let (record, refused) = match record {
        None => (None, None),
        Some(path) => {
            rig.context().stage("reading the record");
            let (page, refused) = record::record_page(rig, path)?;
            rig.context().check()?;
            (Some(page), refused)
        }
    };
    Ok(Checked { report: CheckReport { schema: SCHEMA, rig: rig_page(rig), record }, refused })
}

/// A check as programs read it (`borescope.check/1`).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckReport {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// The rig file.
    pub rig: RigPage,
    /// The record, where one was given.
    pub record: Option<RecordPage>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RigPage {
    pub file: String,
    pub name: String,
    pub nodes: Vec<NodeLine>,
    pub components: Vec<ComponentLine>,
    pub effects: Vec<EffectLine>,
    /// Formulas of the rig file's own that the model does not have.
    pub own_effects: Vec<String>,
    pub states: Vec<String>,
    pub parameters: Vec<ParameterLine>,
    pub sensors: Vec<SensorLine>,
    pub inputs: Vec<InputLine>,
    pub faults: Vec<FaultLine>,
    pub cycle: Option<CycleLine>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NodeLine {
    pub name: String,
    pub kind: &'static str,
    pub start: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComponentLine {
    pub name: String,
    pub kind: &'static str,
    pub ports: Vec<PortLine>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PortLine {
    pub port: &'static str,
    pub node: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectLine {
    pub id: String,
    pub law: &'static str,
    /// Ids of its parameters.
    pub parameters: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterLine {
    pub id: String,
    pub value: f64,
    pub unit: String,
    /// 0 for a value taken as exact.
    pub sigma: f64,
    /// Whether a fit estimates it: a fault, or uncertain.
    pub fitted: bool,
    pub meaning: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorLine {
    pub name: String,
    pub column: String,
    pub quantity: &'static str,
    pub at: String,
    pub unit: String,
    pub noise: f64,
    pub resolution: f64,
    pub lag_s: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InputLine {
    pub name: String,
    pub column: String,
    pub unit: String,
    pub hold: &'static str,
    pub noise: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultLine {
    pub id: String,
    pub healthy: f64,
    pub bounds: [f64; 2],
    pub unit: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CycleLine {
    pub phases: usize,
    pub interval_s: f64,
    pub duration_s: f64,
}

fn rig_page(rig: &Rig) -> RigPage {
    let model = rig.model();
    let node_name = |node: usize| rig.nodes.get(node).map_or_else(String::new, |node| node.name.clone());
    let components = rig.components.iter().map(|component| ComponentLine {
        name: component.name.clone(),
        kind: component.card.kind,
        ports: component
            .card
            .ports
            .iter()
            .zip(&component.ports)
            .map(|(port, &node)| PortLine { port: port.name, node: node_name(node) })
            .collect(),
    });
    let parameters = rig.parameters.iter().enumerate().map(|(index, parameter)| ParameterLine {
        id: parameter.id.clone(),
        value: in_unit(parameter.value, &parameter.unit),
        unit: parameter.unit.to_string(),
        sigma: difference_in_unit(parameter.sigma, &parameter.unit),
        fitted: (parameter.sigma > 0.0 && !parameter.anew) || rig.is_fault(index),
        meaning: parameter.meaning.clone(),
    });
    let faults = rig.faults.iter().filter_map(|fault| {
        let parameter = rig.parameters.get(fault.parameter)?;
        let shown = |si: f64| in_unit(si, &parameter.unit);
        Some(FaultLine {
            id: parameter.id.clone(),
            healthy: shown(fault.healthy),
            bounds: [shown(fault.bounds.0), shown(fault.bounds.1)],
            unit: parameter.unit.to_string(),
        })
    });
    let effects = rig.effects.iter().map(|effect| EffectLine {
        id: effect.id.clone(),
        law: effect.placed.effect.law,
        parameters: effect.parameters.iter().map(|&index| rig.parameters[index].id.clone()).collect(),
    });
    let own = rig
        .effect_places()
        .into_iter()
        .filter(|placed| rig.own_effects.iter().any(|own| own.name == placed.effect.name));
    let own = own.map(|placed| rig.effect_id(&placed)).filter(|id| rig.effects.iter().all(|effect| effect.id != *id));
    let inputs = rig.inputs.iter().map(|input| InputLine {
        name: input.name.clone(),
        column: input.column.clone(),
        unit: input.unit.to_string(),
        hold: crate::rig::Hold::NAMED.iter().find(|(_, hold)| *hold == input.hold).map_or("", |(name, _)| *name),
        noise: difference_in_unit(input.noise, &input.unit),
    });
    RigPage {
        file: rig.path.display().to_string(),
        name: rig.name.clone(),
        nodes: rig.nodes.iter().map(|node| node_line(rig, node)).collect(),
        components: components.collect(),
        effects: effects.collect(),
        own_effects: own.collect(),
        states: model.states().to_vec(),
        parameters: parameters.collect(),
        sensors: rig.sensors.iter().map(|sensor| sensor_line(rig, sensor)).collect(),
        inputs: inputs.collect(),
        faults: faults.collect(),
        cycle: rig.cycle.as_ref().map(|cycle| CycleLine {
            phases: cycle.phases.len(),
            interval_s: cycle.interval,
            duration_s: rounded(cycle.duration(), 12),
        }),
    }
}

fn node_line(rig: &Rig, node: &crate::rig::Node) -> NodeLine {
    let (kind, start) = match &node.kind {
        NodeKind::Held { .. } => ("held pressure", String::new()),
        NodeKind::Volume { initial: InitialPressure::Given(gauge) } => {
            ("volume", format!("at {} bar", rounded(gauge / 1e5, 6)))
        }
        NodeKind::Volume { initial: InitialPressure::Uncertain(parameter) } => {
            let parameter = &rig.parameters[*parameter];
            (
                "volume",
                format!(
                    "at {}, uncertain",
                    crate::units::Quantity { value: parameter.value, unit: parameter.unit.clone() }
                ),
            )
        }
        NodeKind::Volume { initial: InitialPressure::Like(other) } => {
            ("volume", format!("as {}", rig.nodes[*other].name))
        }
        NodeKind::Volume { initial: InitialPressure::Balance } => ("volume", "in balance".to_owned()),
        NodeKind::Volume { initial: InitialPressure::Record } => ("volume", "at its first reading".to_owned()),
        NodeKind::Body { position, velocity } => {
            ("body", format!("at {} mm and {} mm/s", rounded(position * 1e3, 6), rounded(velocity * 1e3, 6)))
        }
    };
    NodeLine { name: node.name.clone(), kind, start }
}

fn sensor_line(rig: &Rig, sensor: &Sensor) -> SensorLine {
    let at = match sensor.target {
        Target::Node(node) => rig.nodes.get(node).map(|node| node.name.clone()),
        Target::Port(component, port) => rig.components.get(component).and_then(|component| {
            let port = component.card.ports.get(port)?;
            let direction = if sensor.sign < 0.0 { ", out" } else { "" };
            Some(format!("{}.{}{direction}", component.name, port.name))
        }),
    };
    let unit = rig.sensor_unit(sensor);
    SensorLine {
        name: sensor.name.clone(),
        column: sensor.column.clone(),
        quantity: Quantity::NAMED
            .iter()
            .find(|(_, quantity)| *quantity == sensor.quantity)
            .map_or("", |(name, _)| *name),
        at: at.unwrap_or_default(),
        noise: difference_in_unit(sensor.noise, &unit),
        resolution: difference_in_unit(sensor.resolution, &unit),
        unit: unit.symbol,
        lag_s: sensor.lag,
    }
}
