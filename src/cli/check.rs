//! `check`: reads a rig file, and a record against it, and tells what it found.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::page::write_page;
use super::{Failure, Format, Status, write_json};
use crate::complaint::Complaint;
use crate::model::{Drive, Model};
use crate::record::{Channel, Record};
use crate::report::number::{difference_in_unit, in_unit, rounded};
use crate::rig::{InitialPressure, NodeKind, Quantity, Rig, Sensor, Target};

/// Check a rig file, and a record against it
#[derive(Debug, Args)]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// A record of this rig
    record: Option<PathBuf>,
    /// How the page is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Serialize)]
pub struct Page {
    schema: &'static str,
    pub rig: RigPage,
    pub record: Option<RecordPage>,
}

#[derive(Serialize)]
pub struct RigPage {
    pub file: String,
    pub name: String,
    pub nodes: Vec<NodeLine>,
    pub components: Vec<ComponentLine>,
    pub states: Vec<String>,
    pub parameters: Vec<ParameterLine>,
    pub sensors: Vec<SensorLine>,
    pub inputs: Vec<InputLine>,
    pub faults: Vec<FaultLine>,
    pub cycle: Option<CycleLine>,
}

#[derive(Serialize)]
pub struct NodeLine {
    pub name: String,
    pub kind: &'static str,
    pub start: String,
}

#[derive(Serialize)]
pub struct ComponentLine {
    pub name: String,
    pub kind: &'static str,
    pub ports: Vec<PortLine>,
}

#[derive(Serialize)]
pub struct PortLine {
    pub port: &'static str,
    pub node: String,
}

#[derive(Serialize)]
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

#[derive(Serialize)]
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

#[derive(Serialize)]
pub struct InputLine {
    pub name: String,
    pub column: String,
    pub unit: String,
    pub hold: &'static str,
    pub noise: f64,
}

#[derive(Serialize)]
pub struct FaultLine {
    pub id: String,
    pub healthy: f64,
    pub bounds: [f64; 2],
    pub unit: String,
}

#[derive(Serialize)]
pub struct CycleLine {
    pub phases: usize,
    pub interval_s: f64,
    pub duration_s: f64,
}

#[derive(Serialize)]
pub struct RecordPage {
    pub file: String,
    pub rows: usize,
    pub from_s: f64,
    pub to_s: f64,
    pub interval_s: f64,
    pub duration_s: f64,
    pub channels: Vec<ChannelLine>,
    pub phases: Vec<PhaseLine>,
    pub warnings: Vec<String>,
}

#[derive(Serialize)]
pub struct ChannelLine {
    pub name: String,
    pub unit: String,
    pub least: f64,
    pub greatest: f64,
    /// `sensor`, `input`, or nothing of this rig.
    pub role: Option<&'static str>,
}

/// What stands between two jumps of the inputs.
#[derive(Serialize)]
pub struct PhaseLine {
    pub from_s: f64,
    pub to_s: f64,
    pub inputs: Vec<PhaseInput>,
}

#[derive(Serialize)]
pub struct PhaseInput {
    pub name: String,
    pub from: f64,
    pub to: f64,
    pub unit: String,
}

/// Runs the verb; the page goes to `out`.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    let rig = Rig::read(&arguments.rig)?;
    let record = match &arguments.record {
        None => None,
        Some(path) => Some(record_page(&rig, &rig.record(path)?)?),
    };
    let page = Page { schema: "borescope.check/1", rig: rig_page(rig), record };
    match arguments.format {
        Format::Json => write_json(out, &page)?,
        Format::Text => write_page(out, &page)?,
    }
    Ok(Status::Done)
}

fn rig_page(rig: Rig) -> RigPage {
    let model = Model::new(rig);
    let rig = &model.rig;
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

fn record_page(rig: &Rig, record: &Record) -> Result<RecordPage, Complaint> {
    let mut warnings = Vec::new();
    let drive = Drive::from_record(rig, record)?;
    for sensor in &rig.sensors {
        let channel = record.require(&sensor.column, sensor.quantity.dimension(), sensor.place.clone())?;
        warnings.extend(doubts(sensor, channel, &record.time));
    }
    let (from, to) = (record.time.first().copied().unwrap_or(0.0), record.time.last().copied().unwrap_or(0.0));
    let sampling = record.sampling();
    if let Some(sampling) = sampling.filter(|sampling| !sampling.regular) {
        warnings.insert(
            0,
            format!(
                "the sampling is irregular: intervals from {} s to {} s, mostly {} s",
                rounded(sampling.shortest, 6),
                rounded(sampling.longest, 6),
                rounded(sampling.interval, 6)
            ),
        );
    }
    let role = |channel: &Channel| {
        if rig.sensors.iter().any(|sensor| sensor.column == channel.name) {
            Some("sensor")
        } else {
            rig.inputs.iter().any(|input| input.column == channel.name).then_some("input")
        }
    };
    let channels = record.channels.iter().map(|channel| ChannelLine {
        name: channel.name.clone(),
        unit: channel.unit.to_string(),
        least: in_unit(channel.values.iter().copied().fold(f64::INFINITY, f64::min), &channel.unit),
        greatest: in_unit(channel.values.iter().copied().fold(f64::NEG_INFINITY, f64::max), &channel.unit),
        role: role(channel),
    });
    Ok(RecordPage {
        file: record.path.display().to_string(),
        rows: record.time.len(),
        from_s: rounded(from, 12),
        to_s: rounded(to, 12),
        interval_s: sampling.map_or(0.0, |sampling| rounded(sampling.interval, 9)),
        duration_s: rounded(to - from, 12),
        channels: channels.collect(),
        phases: phases(rig, &drive),
        warnings,
    })
}

/// The pieces of the drive, joined up to the next jump.
fn phases(rig: &Rig, drive: &Drive) -> Vec<PhaseLine> {
    let mut phases: Vec<PhaseLine> = Vec::new();
    for piece in &drive.pieces {
        match phases.last_mut().filter(|_| !piece.jump) {
            Some(phase) => {
                phase.to_s = rounded(piece.end, 12);
                for ((own, to), input) in phase.inputs.iter_mut().zip(&piece.to).zip(&rig.inputs) {
                    own.to = in_unit(*to, &input.unit);
                }
            }
            None => phases.push(PhaseLine {
                from_s: rounded(piece.start, 12),
                to_s: rounded(piece.end, 12),
                inputs: rig
                    .inputs
                    .iter()
                    .zip(piece.from.iter().zip(&piece.to))
                    .map(|(input, (from, to))| PhaseInput {
                        name: input.name.clone(),
                        from: in_unit(*from, &input.unit),
                        to: in_unit(*to, &input.unit),
                        unit: input.unit.to_string(),
                    })
                    .collect(),
            }),
        }
    }
    phases
}

/// Rows in a run at the extreme value from which a noisy channel counts as clipped.
const CLIPPED: usize = 10;
/// Median step from row to row, in standard deviations of the noise, below which a channel counts as computed rather
/// than measured; noise alone makes it 0.95.
const MEASURED: f64 = 0.3;

/// What is doubtful about a sensor's column.
fn doubts(sensor: &Sensor, channel: &Channel, time: &[f64]) -> Option<String> {
    let least = channel.values.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = channel.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let shown = |si: f64| format!("{} {}", in_unit(si, &channel.unit), channel.unit);
    let name = &channel.name;
    if least == greatest {
        return Some(format!("`{name}` stays at {}: is the sensor connected?", shown(least)));
    }
    let mut steps: Vec<f64> = channel
        .values
        .windows(2)
        .filter(|pair| pair.iter().all(|value| *value != least && *value != greatest))
        .map(|pair| (pair[1] - pair[0]).abs())
        .collect();
    steps.sort_by(f64::total_cmp);
    if steps.get(steps.len() / 2).is_none_or(|median| *median < MEASURED * sensor.noise) {
        return None;
    }
    for extreme in [greatest, least] {
        let runs = channel.values.chunk_by(|a, b| a == b);
        let mut row = 0;
        for run in runs {
            if run.len() >= CLIPPED && run.first() == Some(&extreme) {
                let (from, to) = (time.get(row).copied()?, time.get(row + run.len() - 1).copied()?);
                let which = if extreme == greatest { "greatest" } else { "least" };
                return Some(format!(
                    "`{name}` may be saturated: it rests at its {which} value {} from {} s to {} s",
                    shown(extreme),
                    rounded(from, 9),
                    rounded(to, 9)
                ));
            }
            row += run.len();
        }
    }
    None
}
