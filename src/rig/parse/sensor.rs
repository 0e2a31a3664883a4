//! Sensors: quantity, place, noise.

use super::{card_unit, difference, named};
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::physics::card::PortKind;
use crate::physics::card::Role;
use crate::rig::sensor::{GAIN_SPREAD, OFFSET_SPREAD, TOLERANCE};
use crate::rig::source::{Stated, Value};
use crate::rig::{Node, NodeKind, Parameter, Quantity, Rig, Scaling, Sensor, Target, range};
use crate::units::{Dimension, Unit};

pub(super) fn read_sensor(rig: &mut Rig, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let table = value.table(format!("sensor `{name}`"))?;
    let quantity =
        table.require("quantity", &help_with_names("", "quantities", Quantity::NAMED.iter().map(|(name, _)| *name)))?;
    let quantity = named(&quantity, "quantities", Quantity::NAMED)?;
    let at = table.require(
        "at",
        "name the node, the port as `component.port` for a flow or a force, or the state as `component.state`",
    )?;
    let target = target(rig, name, quantity, &at)?;
    let reads = quantity.dimension().unwrap_or_else(|| dimension_of(rig, target));
    let sign = match table.get("direction") {
        None => 1.0,
        Some(value) if quantity != Quantity::Flow => {
            return Err(Complaint::new(
                Kind::Contradiction,
                format!("{} is given, but only flows have one", value.what),
            )
            .at(value.place())
            .help("write a negative scale where the column counts the other way, such as `scale = \"-1 mm/mm\"`"));
        }
        Some(value) => named(&value, "directions", &[("in", 1.0), ("out", -1.0)])?,
    };
    let dimension = reads;
    let scale = match table.get("scale") {
        None => None,
        Some(value) => Some(Scaling::read(&value, dimension, None)?),
    };
    // A scaled sensor is described in what it writes.
    let (dimension, factor) = Scaling::of_column(scale.as_ref(), dimension);
    let noise_value =
        table.require("noise", "add the standard deviation of one sample, such as `noise = \"0.25 bar\"`")?;
    let noise = difference(&noise_value, dimension)? * factor;
    if noise <= 0.0 {
        return Err(Complaint::new(Kind::Bounds, format!("the noise of sensor `{name}` is not positive"))
            .at(noise_value.place())
            .help("give one standard deviation; a sensor that never errs would overrule every other"));
    }
    let unit = match &scale {
        Some(scale) => scale.of_differences(),
        None => noise_value.quantity(dimension)?.unit,
    };
    let optional =
        |key: &str, dimension: Dimension| table.get(key).map(|value| difference(&value, dimension)).transpose();
    let resolution = optional("resolution", dimension)?.unwrap_or(0.0) * factor;
    let stated_tolerance = optional("tolerance", dimension)?.map(|tolerance| tolerance * factor);
    let tolerance = stated_tolerance.unwrap_or(TOLERANCE * noise);
    let lag = optional("lag", Dimension::TIME)?.unwrap_or(0.0);
    let column_unit = table.get("unit").map(|value| column_unit(&value, dimension)).transpose()?;
    let column = table.get("column").map(|column| column.name()).transpose()?.unwrap_or(name).to_owned();
    let place = value.place();
    let first_parameter = rig.parameters.len();
    let own = |key: &str,
               default: f64,
               sigma_unstated: f64,
               of_kind: f64,
               unit: &Unit,
               bounds: (f64, f64),
               meaning: &str|
     -> Result<Parameter, Complaint> {
        let stated = table.get(key).map(|value| stated(&value, unit, scale.as_ref())).transpose()?;
        let (value, sigma) = stated.map_or((default, None), |stated| (stated.value, stated.sigma));
        if value < bounds.0 {
            return Err(Complaint::new(Kind::Bounds, format!("the {key} of sensor `{name}` is negative"))
                .at(place.clone())
                .help(format!("{meaning}: {}", range(bounds, unit))));
        }
        Ok(Parameter {
            id: format!("sensor.{name}.{key}"),
            unit: unit.clone(),
            value,
            bounds,
            sigma: sigma.unwrap_or(sigma_unstated),
            per_event: false,
            role: Role::Plain,
            // A sensor has its class, or its certificate: what the file states of it is what is known of this one.
            spread: sigma.unwrap_or(of_kind),
            meaning: meaning.to_owned(),
            place: place.clone(),
        })
    };
    let offset = own(
        "offset",
        0.0,
        tolerance,
        OFFSET_SPREAD * noise,
        &unit,
        (f64::NEG_INFINITY, f64::INFINITY),
        "what the sensor shows at zero",
    )?;
    let gain = own(
        "gain",
        1.0,
        0.0,
        GAIN_SPREAD,
        &Unit::dimensionless(),
        (0.0, f64::INFINITY),
        "what the sensor shows per true value",
    )?;
    rig.parameters.extend([offset, gain]);
    table.finish()?;
    rig.sensors.push(Sensor {
        name: name.to_owned(),
        column,
        quantity,
        dimension: reads,
        target,
        scale,
        column_unit,
        sign,
        noise,
        stated_noise: noise,
        lack_of_fit: 0.0,
        resolution,
        tolerance,
        tolerance_is_stated: stated_tolerance.is_some(),
        lag,
        first_parameter,
        place,
    });
    Ok(())
}

/// What the rig file states of a sensor in its quantity, or in what its column shows.
fn stated(value: &Value<'_>, unit: &Unit, scale: Option<&Scaling>) -> Result<Stated, Complaint> {
    let of_quantity = value.stated(unit.dimension);
    let (dimension, factor) = Scaling::of_column(scale, unit.dimension);
    if of_quantity.is_ok() || unit.dimension == Dimension::NONE || dimension == unit.dimension {
        return of_quantity;
    }
    let Ok(of_column) = value.stated(dimension) else { return of_quantity };
    Ok(Stated { value: factor * of_column.value, sigma: of_column.sigma.map(|sigma| factor * sigma), ..of_column })
}

/// The unit of a column in records that do not name it.
fn column_unit(value: &Value<'_>, dimension: Dimension) -> Result<Unit, Complaint> {
    Unit::parse_as(value.text()?, dimension)
        .map_err(|error| Complaint::new(Kind::Unit, error.to_string()).at(value.place()).help(error.help()))
}

/// The dimension of a state.
fn dimension_of(rig: &Rig, target: Target) -> Dimension {
    match target {
        Target::State(component, state) => card_unit(rig.components[component].card.states[state].unit).dimension,
        Target::Node(_) | Target::Port(..) => Dimension::NONE,
    }
}

/// The state of a component that a sensor reads.
fn state_target(rig: &Rig, name: &str, at: &Value<'_>) -> Result<Target, Complaint> {
    let wanted = at.text()?;
    let mut states = Vec::new();
    for (index, component) in rig.components.iter().enumerate() {
        for (state, card) in component.card.states.iter().enumerate() {
            let id = format!("{}.{}", component.name, card.name);
            if id == wanted {
                return Ok(Target::State(index, state));
            }
            states.push(id);
        }
    }
    let what = format!("sensor `{name}` reads `{wanted}`, which is no state of a component");
    Err(Complaint::new(Kind::UnknownName, what).at(at.place()).help(help_with_names(
        wanted,
        "states",
        states.iter().map(String::as_str),
    )))
}

/// The port of a kind at which a sensor of this name reads a flow or a force.
fn port_target(
    rig: &Rig,
    (name, quantity): (&str, &str),
    (kind, of_kind): (PortKind, &str),
    at: &Value<'_>,
) -> Result<Target, Complaint> {
    let wanted = at.text()?;
    let mut all = Vec::new();
    for (index, component) in rig.components.iter().enumerate() {
        let ports = component.card.ports.iter().enumerate().filter(|(_, port)| port.kind == kind);
        all.extend(ports.map(|(port, card)| (format!("{}.{}", component.name, card.name), Target::Port(index, port))));
    }
    if let Some((_, target)) = all.iter().find(|(port, _)| port == wanted) {
        return Ok(*target);
    }
    let what = format!("sensor `{name}` measures the {quantity} at `{wanted}`, which is no {of_kind} port");
    let ports = all.iter().map(|(port, _)| port.as_str());
    Err(Complaint::new(Kind::UnknownName, what).at(at.place()).help(help_with_names(wanted, "ports", ports)))
}

/// What a sensor reads: a node, a port or a state.
fn target(rig: &Rig, name: &str, quantity: Quantity, at: &Value<'_>) -> Result<Target, Complaint> {
    let wanted = at.text()?;
    match quantity {
        Quantity::State => return state_target(rig, name, at),
        Quantity::Flow => return port_target(rig, (name, "flow"), (PortKind::Hydraulic, "hydraulic"), at),
        Quantity::Force => return port_target(rig, (name, "force"), (PortKind::Mechanical, "mechanical"), at),
        _ => {}
    }
    let mechanical = matches!(quantity, Quantity::Position | Quantity::Velocity);
    let fits = |node: &Node| match node.kind {
        NodeKind::Body { .. } => mechanical,
        NodeKind::Volume { .. } => !mechanical,
        // What keeps its pressure has no level.
        NodeKind::Held { .. } => quantity == Quantity::Pressure,
    };
    let found = rig.nodes.iter().position(|node| node.name == wanted && fits(node));
    found.map(Target::Node).ok_or_else(|| {
        let names = rig.nodes.iter().filter(|node| fits(node)).map(|node| node.name.as_str());
        let what = match quantity {
            Quantity::Position | Quantity::Velocity => "bodies",
            Quantity::Level => "nodes with a volume",
            Quantity::Pressure | Quantity::Flow | Quantity::Force | Quantity::State => "hydraulic nodes",
        };
        Complaint::new(Kind::UnknownName, format!("sensor `{name}` sits at `{wanted}`, which is none of the {what}"))
            .at(at.place())
            .help(help_with_names(wanted, what, names))
    })
}
