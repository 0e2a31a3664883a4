//! What is in a rig file and in a record, as the program understands them, and what is doubtful in the record.

mod model;
mod record;
mod sense;

use std::path::Path;

use serde::Serialize;

use crate::complaint::Complaint;
use crate::number::{difference_in_unit, in_unit, rounded};
use crate::rig::{InitialPressure, NodeKind, Quantity, Rig, Sensor, Target};

#[cfg(feature = "cli")]
pub(crate) use model::doubts;
pub use record::{ChannelLine, RecordPage};
#[cfg(feature = "cli")]
pub use record::{PhaseInput, PhaseLine};

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
/// A record that cannot be read at all, or a [context](crate::Context) that was cancelled.
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
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CheckReport {
    /// Name and version of the JSON schema: `borescope.check/1`.
    pub schema: &'static str,
    /// The rig file.
    pub rig: RigPage,
    /// The record, where one was given.
    pub record: Option<RecordPage>,
}

/// What is in a rig file.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct RigPage {
    /// As the user named it.
    pub file: String,
    /// The `name` of `[rig]`; empty without.
    pub name: String,
    /// In the order of the file.
    pub(crate) nodes: Vec<NodeLine>,
    /// In the order of the file; those of effects behind them.
    #[doc(hidden)]
    pub components: Vec<ComponentLine>,
    /// Physics beyond that of the components.
    #[doc(hidden)]
    pub effects: Vec<EffectLine>,
    /// Formulas of the rig file's own that the model does not have.
    pub(crate) own_effects: Vec<String>,
    /// Names of the states of the model.
    pub states: Vec<String>,
    /// Every parameter of the model.
    pub parameters: Vec<ParameterLine>,
    /// In the order of the file.
    pub sensors: Vec<SensorLine>,
    /// In the order of the file.
    pub inputs: Vec<InputLine>,
    /// In the order of the file.
    pub faults: Vec<FaultLine>,
    /// What `simulate` runs without a record.
    #[doc(hidden)]
    pub cycle: Option<CycleLine>,
    /// What is doubtful in the file, in words.
    pub warnings: Vec<String>,
}

/// A node.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct NodeLine {
    /// As the rig file has it.
    pub name: String,
    /// Held pressure, volume or body.
    pub kind: &'static str,
    /// What it starts with, in words; empty where its pressure is held.
    pub start: String,
}

/// A component.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ComponentLine {
    /// As the rig file has it.
    pub name: String,
    /// Such as `cylinder`.
    pub kind: &'static str,
    /// In the order of its card.
    pub ports: Vec<PortLine>,
}

/// A port of a component.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct PortLine {
    /// Its name on the card.
    pub port: &'static str,
    /// The node that it meets.
    pub node: String,
}

/// An effect that the model has.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct EffectLine {
    /// Effect and place, such as `external-leakage@A`.
    pub id: String,
    /// Its formula.
    pub law: &'static str,
    /// Ids of its parameters.
    pub parameters: Vec<String>,
}

/// A parameter of the model. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ParameterLine {
    /// Such as `cylinder.clearance`.
    pub id: String,
    /// By the rig file, or the default of its card.
    pub value: f64,
    /// As the rig file has it.
    pub unit: String,
    /// 0 for a value taken as exact.
    pub sigma: f64,
    /// Whether a fit estimates it: a fault, or uncertain.
    pub fitted: bool,
    /// Whether it is exact by the rig file, although parts deviate from data sheets and no calibration has said by how much.
    pub exact_by_sheet: bool,
    /// Whether it is the size of a margin: what no circuit is quite without, as a calibration has it.
    pub margin: bool,
    /// From the card.
    pub meaning: String,
}

/// A sensor. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct SensorLine {
    /// As the rig file has it.
    pub name: String,
    /// The column of a record that it reads.
    pub column: String,
    /// Such as `pressure`.
    pub quantity: &'static str,
    /// The node or port where it sits.
    pub at: String,
    /// Of its readings.
    pub unit: String,
    /// One standard deviation of a reading.
    pub noise: f64,
    /// Step of its readings; 0 where none is stated.
    pub resolution: f64,
    /// Time constant of its lag, s; 0 without.
    pub lag_s: f64,
}

/// An input. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct InputLine {
    /// As the rig file has it.
    pub name: String,
    /// The column of a record that it reads.
    pub column: String,
    /// As the rig file has it.
    pub unit: String,
    /// What a row says of the time around it.
    pub hold: &'static str,
    /// One standard deviation of a value.
    pub noise: f64,
}

/// A fault. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultLine {
    /// The parameter that it changes.
    pub id: String,
    /// Without the fault.
    pub healthy: f64,
    /// Least and greatest value that is searched.
    pub bounds: [f64; 2],
    /// As the rig file has it.
    pub unit: String,
}

/// The cycle of the rig file.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CycleLine {
    /// How many there are.
    pub phases: usize,
    /// Between two rows, s.
    pub interval_s: f64,
    /// Of the whole, s.
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
    let by_sheet = rig.exact_by_sheet();
    let parameters = rig.parameters.iter().enumerate().map(|(index, parameter)| ParameterLine {
        id: parameter.id.clone(),
        value: in_unit(parameter.value, &parameter.unit),
        unit: parameter.unit.to_string(),
        sigma: difference_in_unit(parameter.sigma, &parameter.unit),
        fitted: rig.is_fitted(index),
        exact_by_sheet: by_sheet.contains(&index),
        margin: rig.is_margin(index),
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
        warnings: rig.unfilled_values().into_iter().chain(rig.doubts()).collect(),
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
            let at = position.map_or("its first reading".to_owned(), |at| format!("{} mm", rounded(at * 1e3, 6)));
            ("body", format!("at {at} and {} mm/s", rounded(velocity * 1e3, 6)))
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
        Target::State(component, state) => rig.components.get(component).and_then(|component| {
            let state = component.card.states.get(state)?;
            Some(format!("{}.{}", component.name, state.name))
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
