//! From the text of a rig file to a [`Rig`].

use toml::de::DeTable;

use super::sensor::TOLERANCE;
use super::source::{Source, Table, Value};
use super::{
    Component, Cycle, Fault, Hold, InitialPressure, Input, Node, NodeKind, Parameter, Phase, Profile, Quantity, Rig,
    Sensor, Target,
};
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::physics::card::{Card, PortKind};
use crate::physics::{component, fluid};
use crate::units::{Dimension, Unit};

pub fn parse(source: Source) -> Result<Rig, Complaint> {
    let document = DeTable::parse(&source.text).map_err(|error| {
        let place = source.place(error.span().map_or(0, |span| span.start));
        Complaint::new(Kind::Syntax, format!("this is not TOML: {}", error.message().replace('\n', "; ")))
            .at(place)
            .help("see docs/reference/rig-file.md for a rig file to start from")
    })?;
    let root = Table::new(&source, "the rig file", 0, document.get_ref());
    let name = match root.get("rig") {
        None => String::new(),
        Some(value) => {
            let table = value.table("`[rig]`")?;
            let name = table.get("name").map(|name| name.text().map(str::to_owned)).transpose()?.unwrap_or_default();
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
        parameters: Vec::new(),
        faults: Vec::new(),
        cycle: None,
    };
    let fluid_table =
        root.require("fluid", "add `[fluid]` with density, viscosity and bulk_modulus")?.table("`[fluid]`")?;
    read_parameters(&mut rig, "fluid", &fluid::CARD, &fluid_table)?;
    fluid_table.finish()?;
    read_inputs(&mut rig, root.get("inputs"))?;
    let nodes = root.require("nodes", "add `[nodes]` with one line per node, such as `pump_line = {}`")?;
    let nodes = nodes.table("`[nodes]`")?;
    for (name, value) in nodes.entries() {
        // Ports decide below what a node is.
        rig.nodes.push(Node {
            name: name.to_owned(),
            kind: NodeKind::Held { parameter: usize::MAX },
            place: value.place(),
        });
    }
    let components = root.require("components", "add `[components.NAME]` with a `kind` and its `ports`")?;
    for (name, value) in components.table("`[components]`")?.entries() {
        read_component(&mut rig, name, &value)?;
    }
    for (name, value) in nodes.entries() {
        resolve_node(&mut rig, name, &value)?;
    }
    if let Some(sensors) = root.get("sensors") {
        for (name, value) in sensors.table("`[sensors]`")?.entries() {
            read_sensor(&mut rig, name, &value)?;
        }
    }
    if let Some(faults) = root.get("faults") {
        for (id, value) in faults.table("`[faults]`")?.entries() {
            read_fault(&mut rig, id, &value)?;
        }
    }
    if let Some(cycle) = root.get("cycle") {
        rig.cycle = Some(read_cycle(&rig, &cycle)?);
    }
    root.finish()?;
    Ok(rig)
}

/// Appends the parameters of a card, as the table gives them.
fn read_parameters(rig: &mut Rig, owner: &str, card: &Card, table: &Table<'_>) -> Result<(), Complaint> {
    for parameter in card.parameters {
        let unit = card_unit(parameter.unit);
        let id = format!("{owner}.{}", parameter.name);
        let bounds = (unit.difference_to_si(parameter.bounds.0), unit.difference_to_si(parameter.bounds.1));
        let (value, written, sigma, place) = match (table.get(parameter.name), parameter.default) {
            (Some(entry), _) => {
                let stated = entry.stated(unit.dimension)?;
                if stated.value < bounds.0 || stated.value > bounds.1 {
                    return Err(Complaint::new(
                        Kind::Bounds,
                        format!(
                            "{} is {} {}, outside its bounds",
                            entry.what,
                            stated.unit.from_si(stated.value),
                            stated.unit
                        ),
                    )
                    .at(entry.place())
                    .help(format!(
                        "{}: between {} and {} {unit}",
                        parameter.meaning, parameter.bounds.0, parameter.bounds.1
                    )));
                }
                (stated.value, stated.unit, stated.sigma, entry.place())
            }
            (None, Some(default)) => (unit.difference_to_si(default), unit.clone(), None, table.place()),
            (None, None) => {
                return Err(Complaint::new(Kind::MissingEntry, format!("{} has no `{}`", table.what, parameter.name))
                    .at(table.place())
                    .help(format!("add `{} = \"... {unit}\"`: {}", parameter.name, parameter.meaning)));
            }
        };
        rig.parameters.push(Parameter {
            id,
            unit: written,
            value,
            bounds,
            sigma: sigma.unwrap_or(parameter.tolerance * value.abs()),
            meaning: parameter.meaning.to_owned(),
            place,
        });
    }
    Ok(())
}

/// The unit of a card. Cards are constants whose units a test reads, so a miss can only be a dimensionless stand-in.
fn card_unit(symbol: &str) -> Unit {
    Unit::parse(symbol).unwrap_or_else(|_| Unit::dimensionless())
}

fn read_inputs(rig: &mut Rig, inputs: Option<Value<'_>>) -> Result<(), Complaint> {
    let Some(inputs) = inputs else { return Ok(()) };
    for (name, value) in inputs.table("`[inputs]`")?.entries() {
        let table = value.table(format!("input `{name}`"))?;
        let unit = table.require("unit", "add the unit of the column, such as `unit = \"N\"`")?;
        let place = unit.place();
        let unit = Unit::parse(unit.text()?)
            .map_err(|error| Complaint::new(Kind::Unit, error.to_string()).at(place).help(error.help()))?;
        let hold = match table.get("hold") {
            None => Hold::After,
            Some(value) => named(&value, "ways to hold", Hold::NAMED)?,
        };
        let noise = match table.get("noise") {
            None => 0.0,
            Some(value) => difference(&value, unit.dimension)?,
        };
        let column = table.get("column").map(|column| column.text()).transpose()?.unwrap_or(name).to_owned();
        table.finish()?;
        rig.inputs.push(Input { name: name.to_owned(), column, unit, hold, noise, place: value.place() });
    }
    Ok(())
}

fn read_component(rig: &mut Rig, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let table = value.table(format!("component `{name}`"))?;
    if matches!(name, "fluid" | "sensor") {
        return Err(Complaint::new(Kind::Contradiction, format!("`{name}` cannot be the name of a component"))
            .at(value.place())
            .help("the name stands for other parameters; choose another"));
    }
    let kinds = component::CARDS.iter().map(|card| card.kind);
    let kind = table.require("kind", &help_with_names("", "component kinds", kinds.clone()))?;
    let Some(card) = component::card(kind.text()?) else {
        return Err(Complaint::new(Kind::UnknownName, format!("unknown component kind `{}`", kind.text()?))
            .at(kind.place())
            .help(help_with_names(kind.text()?, "component kinds", kinds)));
    };
    let port_list: Vec<&str> = card.ports.iter().map(|port| port.name).collect();
    let help = format!(
        "a {} needs `ports = {{ {} }}`",
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
    let mut inputs = Vec::new();
    for input in card.inputs {
        let entry = table
            .require(input.name, &format!("name the input that is the {} of this {}", input.meaning, card.kind))?;
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
    let first_parameter = rig.parameters.len();
    read_parameters(rig, name, card, &table)?;
    let mut initial = vec![None; card.states.len()];
    if let Some(value) = table.get("initial") {
        let states = value.table(format!("`initial` of component `{name}`"))?;
        for (slot, state) in initial.iter_mut().zip(card.states) {
            if let Some(value) = states.get(state.name) {
                *slot = Some(value.quantity(card_unit(state.unit).dimension)?.value);
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
        place: value.place(),
    });
    Ok(())
}

/// Decides what a node is from the ports that meet there, and reads how it starts.
fn resolve_node(rig: &mut Rig, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let Some(index) = rig.node(name) else { return Ok(()) };
    let mut kinds = Vec::new();
    let mut held = None;
    for component in &rig.components {
        for (port, &node) in component.card.ports.iter().zip(&component.ports) {
            if node == index {
                kinds.push((port.kind, &component.name));
                if let Some(parameter) = component.card.fixes_pressure {
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
        (PortKind::Hydraulic, None) => NodeKind::Volume { initial: initial_pressure(&table)? },
        (PortKind::Mechanical, _) => {
            let read = |key: &str, dimension| table.get(key).map(|value| value.quantity(dimension)).transpose();
            NodeKind::Body {
                position: read("position", Dimension::LENGTH)?.map_or(0.0, |quantity| quantity.value),
                velocity: read("velocity", Dimension::VELOCITY)?.map_or(0.0, |quantity| quantity.value),
            }
        }
    };
    table.finish()?;
    rig.nodes[index].kind = node_kind;
    Ok(())
}

fn initial_pressure(table: &Table<'_>) -> Result<InitialPressure, Complaint> {
    let Some(value) = table.get("initial") else { return Ok(InitialPressure::Record) };
    match value.text() {
        Ok("balance") => Ok(InitialPressure::Balance),
        Ok("record") => Ok(InitialPressure::Record),
        _ => Ok(InitialPressure::Given(value.quantity(Dimension::PRESSURE)?.value)),
    }
}

fn read_sensor(rig: &mut Rig, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let table = value.table(format!("sensor `{name}`"))?;
    let quantity =
        table.require("quantity", &help_with_names("", "quantities", Quantity::NAMED.iter().map(|(name, _)| *name)))?;
    let quantity = named(&quantity, "quantities", Quantity::NAMED)?;
    let at = table.require("at", "name the node, or the port as `component.port` for a flow")?;
    let wanted = at.text()?;
    let target = if quantity == Quantity::Flow {
        let found = wanted.split_once('.').and_then(|(component, port)| {
            let index = rig.components.iter().position(|candidate| candidate.name == component)?;
            let port = rig.components[index]
                .card
                .ports
                .iter()
                .position(|candidate| candidate.name == port && candidate.kind == PortKind::Hydraulic)?;
            Some(Target::Port(index, port))
        });
        let ports: Vec<String> = rig
            .components
            .iter()
            .flat_map(|component| {
                component.card.ports.iter().map(move |port| format!("{}.{}", component.name, port.name))
            })
            .collect();
        found.ok_or_else(|| {
            Complaint::new(
                Kind::UnknownName,
                format!("sensor `{name}` measures the flow at `{wanted}`, which is no hydraulic port"),
            )
            .at(at.place())
            .help(help_with_names(wanted, "ports", ports.iter().map(String::as_str)))
        })?
    } else {
        let mechanical = matches!(quantity, Quantity::Position | Quantity::Velocity);
        let fits = |node: &Node| matches!(node.kind, NodeKind::Body { .. }) == mechanical;
        let found = rig.nodes.iter().position(|node| node.name == wanted && fits(node));
        found.map(Target::Node).ok_or_else(|| {
            let names = rig.nodes.iter().filter(|node| fits(node)).map(|node| node.name.as_str());
            let what = if mechanical { "bodies" } else { "hydraulic nodes" };
            Complaint::new(
                Kind::UnknownName,
                format!("sensor `{name}` sits at `{wanted}`, which is none of the {what}"),
            )
            .at(at.place())
            .help(help_with_names(wanted, what, names))
        })?
    };
    let sign = match table.get("direction") {
        None => 1.0,
        Some(value) => named(&value, "directions", &[("in", 1.0), ("out", -1.0)])?,
    };
    let dimension = quantity.dimension();
    let noise_value =
        table.require("noise", "add the standard deviation of one sample, such as `noise = \"0.25 bar\"`")?;
    let noise = difference(&noise_value, dimension)?;
    if noise <= 0.0 {
        return Err(Complaint::new(Kind::Bounds, format!("the noise of sensor `{name}` is not positive"))
            .at(noise_value.place())
            .help("give one standard deviation; a sensor that never errs would overrule every other"));
    }
    let unit = noise_value.quantity(dimension)?.unit;
    let optional =
        |key: &str, dimension: Dimension| table.get(key).map(|value| difference(&value, dimension)).transpose();
    let resolution = optional("resolution", dimension)?.unwrap_or(0.0);
    let tolerance = optional("tolerance", dimension)?.unwrap_or(TOLERANCE * noise);
    let lag = optional("lag", Dimension::TIME)?.unwrap_or(0.0);
    let column = table.get("column").map(|column| column.text()).transpose()?.unwrap_or(name).to_owned();
    let place = value.place();
    let first_parameter = rig.parameters.len();
    let own =
        |key: &str, default: f64, unit: &Unit, bounds: (f64, f64), meaning: &str| -> Result<Parameter, Complaint> {
            let stated = table.get(key).map(|value| value.stated(unit.dimension)).transpose()?;
            let (value, sigma) = stated.map_or((default, None), |stated| (stated.value, stated.sigma));
            Ok(Parameter {
                id: format!("sensor.{name}.{key}"),
                unit: unit.clone(),
                value,
                bounds,
                sigma: sigma.unwrap_or(0.0),
                meaning: meaning.to_owned(),
                place: place.clone(),
            })
        };
    let offset = own("offset", 0.0, &unit, (f64::NEG_INFINITY, f64::INFINITY), "what the sensor shows at zero")?;
    let gain = own("gain", 1.0, &Unit::dimensionless(), (0.0, f64::INFINITY), "what the sensor shows per true value")?;
    rig.parameters.extend([offset, gain]);
    table.finish()?;
    rig.sensors.push(Sensor {
        name: name.to_owned(),
        column,
        quantity,
        target,
        sign,
        noise,
        resolution,
        tolerance,
        lag,
        first_parameter,
        place,
    });
    Ok(())
}

fn read_fault(rig: &mut Rig, id: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let Some(parameter) = rig.parameter(id) else {
        return Err(Complaint::new(Kind::UnknownName, format!("fault on `{id}`, which is no parameter of this rig"))
            .at(value.place())
            .help(help_with_names(id, "parameters", rig.parameters.iter().map(|parameter| parameter.id.as_str()))));
    };
    let (dimension, limits) = (rig.parameters[parameter].unit.dimension, rig.parameters[parameter].bounds);
    let table = value.table(format!("fault `{id}`"))?;
    let healthy = match table.get("healthy") {
        None => rig.parameters[parameter].value,
        Some(value) => {
            let stated = value.quantity(dimension)?;
            rig.parameters[parameter].unit = stated.unit;
            stated.value
        }
    };
    let bounds_value = table.require("bounds", "add the range to search, such as `bounds = [\"0 mm\", \"0.4 mm\"]`")?;
    let list = bounds_value.list()?;
    let [low, high] = list.as_slice() else {
        return Err(Complaint::new(Kind::Shape, format!("`bounds` of fault `{id}` has {} entries", list.len()))
            .at(bounds_value.place())
            .help("write two: the lowest and the highest value to search"));
    };
    let (low, high) = (low.quantity(dimension)?.value, high.quantity(dimension)?.value);
    if !(low < high && low >= limits.0 && high <= limits.1 && (low..=high).contains(&healthy)) {
        let unit = &rig.parameters[parameter].unit;
        return Err(Complaint::new(
            Kind::Bounds,
            format!(
                "`bounds` of fault `{id}` do not fit: {} to {} {unit}, healthy {} {unit}",
                unit.from_si(low),
                unit.from_si(high),
                unit.from_si(healthy)
            ),
        )
        .at(bounds_value.place())
        .help(format!(
            "the lower one first, the healthy value between them, both within {} to {} {unit}",
            unit.from_si(limits.0),
            unit.from_si(limits.1)
        )));
    }
    table.finish()?;
    rig.faults.push(Fault { parameter, healthy, bounds: (low, high), place: value.place() });
    Ok(())
}

fn read_cycle(rig: &Rig, value: &Value<'_>) -> Result<Cycle, Complaint> {
    let table = value.table("`[cycle]`")?;
    let interval_value = table.require("interval", "add the time between samples, such as `interval = \"4 ms\"`")?;
    let interval = interval_value.quantity(Dimension::TIME)?.value;
    let phases_value = table.require("phases", "add `phases = [ { duration = \"1 s\", ... } ]`")?;
    let mut phases = Vec::new();
    for (number, value) in phases_value.list()?.iter().enumerate() {
        let table = value.table(format!("phase {} of `[cycle]`", number + 1))?;
        let duration = table.require("duration", "add `duration = \"1 s\"`")?;
        let duration = (duration.quantity(Dimension::TIME)?.value, duration.place());
        if duration.0 <= 0.0 {
            return Err(Complaint::new(Kind::Bounds, "a phase of no duration")
                .at(duration.1)
                .help("write a time above 0 s"));
        }
        let mut inputs = Vec::new();
        for input in &rig.inputs {
            let value = table.require(&input.name, &format!("give `{}` in this phase", input.name))?;
            let quantity = |value: &Value<'_>| value.quantity(input.unit.dimension).map(|quantity| quantity.value);
            inputs.push(if value.is_list() {
                match value.list()?.as_slice() {
                    [from, to] => Profile { from: quantity(from)?, to: quantity(to)? },
                    _ => {
                        return Err(Complaint::new(
                            Kind::Shape,
                            format!("{} needs two entries, start and end", value.what),
                        )
                        .at(value.place()));
                    }
                }
            } else {
                let constant = quantity(&value)?;
                Profile { from: constant, to: constant }
            });
        }
        table.finish()?;
        phases.push(Phase { duration: duration.0, inputs });
    }
    table.finish()?;
    if phases.is_empty() || interval <= 0.0 {
        return Err(Complaint::new(Kind::Bounds, "the cycle has no phases, or its interval is not positive")
            .at(interval_value.place())
            .help("give an interval above 0 and at least one phase"));
    }
    Ok(Cycle { interval, phases })
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
