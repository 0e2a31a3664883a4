//! The lines of a component of formulas: ports, parameters, inputs, states.

use super::effects::{Belongs, belongs};
use crate::complaint::{Complaint, Kind};
use crate::physics::card::{ANY, Input, Parameter, Port, PortKind, Role};
use crate::physics::own::MOST_PARAMETERS;
use crate::physics::ports::{INPUTS, PORTS, STATES, VARIABLES};
use crate::rig::parse::kept::kept;
use crate::rig::parse::{difference, named};
use crate::rig::source::{Stated, Table, Value};
use crate::units::Unit;

/// Keys that a component has whatever its kind.
const OF_EVERY_COMPONENT: [&str; 3] = ["kind", "ports", "initial"];

/// How the state of a component changes.
pub(super) enum Change<'a> {
    /// Its rate.
    Rate(Value<'a>),
    /// What it follows, and the time constant with which it does.
    Follows(Value<'a>, &'static str),
}

/// A state as its line has it.
pub(super) struct StateLine<'a> {
    pub name: &'a str,
    pub unit: Unit,
    pub change: Change<'a>,
    /// In `unit`; `None` where it starts at rest.
    pub initial: Option<f64>,
    /// In `unit`.
    pub scale: f64,
    pub meaning: &'static str,
}

/// The entries of a table, each a line of its own; none where the key is missing.
fn lines<'a>(table: &Table<'a>, key: &str) -> Result<Vec<(&'a str, Value<'a>)>, Complaint> {
    let Some(value) = table.get(key) else { return Ok(Vec::new()) };
    value.table(format!("`{key}` of {}", table.what))?.named_entries()
}

fn too_many(value: &Value<'_>, what: &str, most: usize, help: &str) -> Complaint {
    Complaint::new(Kind::Bounds, format!("more than {most} {what}")).at(value.place()).help(help)
}

/// Its ports; those that meet a body count double among the variables.
pub(super) fn ports(table: &Table<'_>) -> Result<Vec<Port>, Complaint> {
    const KINDS: &[(&str, PortKind)] = &[("hydraulic", PortKind::Hydraulic), ("body", PortKind::Mechanical)];
    let help = "add what meets at each port, such as `ports = { in = \"hydraulic\", rod = \"body\" }`";
    table.require("ports", help)?;
    let mut ports = Vec::new();
    for (name, value) in lines(table, "ports")? {
        let (kind, meaning) = match value.text() {
            Ok(_) => (named(&value, "kinds of ports", KINDS)?, ""),
            Err(_) => {
                let line = value.table(format!("port `{name}`"))?;
                let kind = named(
                    &line.require("meets", "add `meets = \"hydraulic\"` or `\"body\"`")?,
                    "kinds of ports",
                    KINDS,
                )?;
                let meaning = meaning(&line)?;
                line.finish()?;
                (kind, meaning)
            }
        };
        ports.push(Port { name: kept(name), kind, meaning });
        let variables: usize = ports.iter().map(|port| port.kind.variables()).sum();
        if ports.len() > PORTS || variables > VARIABLES {
            let help =
                format!("ports bring {VARIABLES} variables at most: a pressure each, position and speed of a body");
            return Err(too_many(&value, "ports", PORTS, &help));
        }
    }
    if ports.is_empty() {
        return Err(Complaint::new(Kind::Empty, format!("{} has no port", table.what)).at(table.place()).help(help));
    }
    Ok(ports)
}

fn meaning(line: &Table<'_>) -> Result<&'static str, Complaint> {
    line.get("meaning").map(|text| text.text().map(kept)).transpose().map(Option::unwrap_or_default)
}

/// The unit of a line, which must be given.
fn unit(line: &Table<'_>) -> Result<Unit, Complaint> {
    let value = line.require("unit", "add its unit, such as `unit = \"bar\"`, or `\"-\"` of a pure number")?;
    Unit::parse(value.text()?)
        .map_err(|error| Complaint::new(Kind::Unit, error.to_string()).at(value.place()).help(error.help()))
}

/// Its parameters, and which of them belong to effects.
pub(super) fn parameters(table: &Table<'_>) -> Result<(Vec<Parameter>, Vec<Belongs>), Complaint> {
    let (mut parameters, mut of_effects) = (Vec::new(), Vec::new());
    let lines = lines(table, "parameters")?;
    let units = |other: &str| {
        let (_, line) = lines.iter().find(|(name, _)| *name == other)?;
        Unit::parse(line.table(other).ok()?.get("unit")?.text().ok()?).ok()
    };
    for (name, value) in &lines {
        if OF_EVERY_COMPONENT.contains(name) {
            return Err(Complaint::new(Kind::Duplicate, format!("a parameter cannot be called `{name}`"))
                .at(value.place())
                .help("every component has an entry of this name: take another"));
        }
        if parameters.len() == MOST_PARAMETERS {
            return Err(too_many(value, "parameters", MOST_PARAMETERS, "make two components of it"));
        }
        let (parameter, of_effect) = parameter(name, value, &units)?;
        parameters.push(parameter);
        of_effects.extend(of_effect);
    }
    Ok((parameters, of_effects))
}

/// A parameter, and the effect of which it is the size. `units` are those of the others by their names: one whose default is the name of
/// another has that one's stated value.
fn parameter(
    name: &str,
    value: &Value<'_>,
    units: &dyn Fn(&str) -> Option<Unit>,
) -> Result<(Parameter, Option<Belongs>), Complaint> {
    const ROLES: &[(&str, Role)] = &[
        ("lag", Role::Lag),
        ("smoothing", Role::Smoothing),
        ("mass", Role::Mass),
        ("volume", Role::Volume),
        ("viscous", Role::Viscous),
        ("laminar", Role::Laminar),
        ("reference", Role::Reference),
        ("record", Role::OfRecord),
    ];
    let line = value.table(format!("parameter `{name}`"))?;
    let unit = unit(&line)?;
    let stated = line.get("default");
    let other = stated.as_ref().and_then(|value| value.text().ok()).filter(|other| *other != name);
    let other = other.and_then(|other| Some((other, units(other)?)));
    if let (Some((other, of_other)), Some(value)) = (&other, &stated)
        && of_other.symbol != unit.symbol
    {
        return Err(Complaint::new(Kind::Unit, format!("`{name}` is by default as `{other}`, which is in {of_other}"))
            .at(value.place())
            .help(format!("write both in one unit, such as `unit = \"{of_other}\"`")));
    }
    let number = stated.filter(|_| other.is_none());
    let default = number.map(|value| value.stated(unit.dimension)).transpose()?;
    let positive = line.get("positive").map(|value| value.flag()).transpose()?.unwrap_or(false);
    let least = if positive { f64::MIN_POSITIVE } else { 0.0 };
    let bounds = match line.get("bounds") {
        None => (least, f64::INFINITY),
        Some(bounds) => pair(&bounds, &unit)?,
    };
    let shown = |si: f64| unit.difference_from_si(si);
    if let Some(stated) = &default
        && !(bounds.0..=bounds.1).contains(&shown(stated.value))
    {
        return Err(Complaint::new(Kind::Bounds, format!("the default of `{name}` is outside its bounds"))
            .at(value.place())
            .help("write `bounds = [LEAST, LARGEST]` around it; without them a parameter is 0 or more"));
    }
    let per_event = line.get("per_switching").map(|value| value.flag()).transpose()?.unwrap_or(false);
    let calibrated =
        line.get("calibrated").map(|value| difference(&value, crate::units::Dimension::NONE)).transpose()?;
    // Of a value that may be zero it is no share, but in the unit of the value.
    if let (Some(value), Some(share)) = (line.get("calibrated"), calibrated)
        && share > 1.0
        && default.as_ref().is_some_and(|stated| stated.value != 0.0)
    {
        let told = format!("`calibrated` of `{name}` is {share} times its value, and a data sheet is not that far off");
        return Err(Complaint::new(Kind::Bounds, told)
            .at(value.place())
            .help("write a share of the value, such as `calibrated = \"5 %\"`"));
    }
    let plain = if other.is_some() { Role::Reference } else { Role::Plain };
    let role = line.get("role").map(|value| named(&value, "roles", ROLES)).transpose()?.unwrap_or(plain);
    let (name, symbol, meaning) = (kept(name), kept(&unit.symbol), meaning(&line)?);
    let neutral = default.as_ref().map(|stated| shown(stated.value));
    let effect = line.get("effect");
    let of_effect = effect.map(|value| belongs(&value, &unit, name, meaning, neutral, bounds)).transpose()?;
    line.finish()?;
    let parameter = Parameter {
        default: neutral,
        default_from: other.map(|(other, _)| kept(other)),
        bounds,
        tolerance: default.as_ref().map_or(0.0, |stated| tolerance(stated, &unit)),
        per_event,
        role,
        spread: calibrated.unwrap_or(0.0),
        ..Parameter::required(name, name, symbol, meaning)
    };
    Ok((parameter, of_effect))
}

/// The uncertainty of a default, as cards have it: relative, or in the unit where the value is 0.
fn tolerance(stated: &Stated, unit: &Unit) -> f64 {
    let sigma = stated.sigma.unwrap_or(0.0);
    if stated.value == 0.0 { unit.difference_from_si(sigma) } else { sigma / stated.value.abs() }
}

/// The least and the largest value, in a unit.
fn pair(value: &Value<'_>, unit: &Unit) -> Result<(f64, f64), Complaint> {
    let ends = value.list()?;
    let wrong = || {
        Complaint::new(Kind::Bounds, format!("{} is no range", value.what))
            .at(value.place())
            .help("write two values, the smaller one first")
    };
    let [low, high] = ends.as_slice() else { return Err(wrong()) };
    let si = |value: &Value<'_>| value.quantity(unit.dimension).map(|quantity| unit.difference_from_si(quantity.value));
    let (low, high) = (si(low)?, si(high)?);
    if low < high { Ok((low, high)) } else { Err(wrong()) }
}

/// Its inputs.
pub(super) fn inputs(table: &Table<'_>) -> Result<Vec<Input>, Complaint> {
    let mut inputs = Vec::new();
    for (name, value) in lines(table, "inputs")? {
        if inputs.len() == INPUTS {
            return Err(too_many(&value, "inputs", INPUTS, "the time `t` counts as one too"));
        }
        let line = value.table(format!("input `{name}`"))?;
        let unit = unit(&line)?;
        let meaning = meaning(&line)?;
        line.finish()?;
        let meaning = if meaning.is_empty() { kept(name) } else { meaning };
        inputs.push(Input { name: kept(name), unit: kept(&unit.symbol), meaning, range: ANY, lag: None });
    }
    Ok(inputs)
}

/// Its states. `parameters` are those of the component; one that is a time constant becomes one by its use.
pub(super) fn states<'a>(
    table: &Table<'a>,
    ports: &[Port],
    parameters: &mut [Parameter],
) -> Result<Vec<StateLine<'a>>, Complaint> {
    let of_ports: usize = ports.iter().map(|port| port.kind.variables()).sum();
    let mut states = Vec::new();
    for (name, value) in lines(table, "states")? {
        if states.len() == STATES {
            return Err(too_many(&value, "states", STATES, "leave out what is fast beside the pressures"));
        }
        if of_ports + states.len() == VARIABLES {
            let help = "a pressure each, position and speed of a body, and the states: make two components of it";
            return Err(too_many(&value, "variables of ports and states", VARIABLES, help));
        }
        let line = value.table(format!("state `{name}`"))?;
        let unit = unit(&line)?;
        let change = change(&line, name, parameters)?;
        let quantity = |key: &str| line.get(key).map(|value| value.quantity(unit.dimension)).transpose();
        let initial = quantity("initial")?.map(|initial| unit.from_si(initial.value));
        let scale = quantity("scale")?.map_or(1.0, |scale| unit.difference_from_si(scale.value));
        if scale <= 0.0 {
            return Err(Complaint::new(Kind::Bounds, format!("the scale of state `{name}` is not positive"))
                .at(value.place())
                .help("write how large it is in a working circuit"));
        }
        let meaning = meaning(&line)?;
        line.finish()?;
        states.push(StateLine { name, unit, change, initial, scale, meaning });
    }
    Ok(states)
}

fn change<'a>(line: &Table<'a>, name: &str, parameters: &mut [Parameter]) -> Result<Change<'a>, Complaint> {
    let Some(follows) = line.get("follows") else {
        let help = format!(
            "add `rate = \"...\"`, its change per second, or `follows = \"...\"` and `lag = \"PARAMETER\"` of what `{name}` comes to \
             with a time constant"
        );
        return line.require("rate", &help).map(Change::Rate);
    };
    if let Some(rate) = line.get("rate") {
        return Err(Complaint::new(Kind::Contradiction, format!("state `{name}` has both `follows` and `rate`"))
            .at(rate.place())
            .help("write one of them"));
    }
    let lag = line.require("lag", "add the parameter that is its time constant, such as `lag = \"tau\"`")?;
    let wanted = lag.text()?;
    let time = |own: &&mut Parameter| {
        own.name == wanted && Unit::parse(own.unit).is_ok_and(|unit| unit.dimension == crate::units::Dimension::TIME)
    };
    let Some(own) = parameters.iter_mut().find(time) else {
        return Err(Complaint::new(Kind::UnknownName, format!("`{wanted}` is no parameter that is a time"))
            .at(lag.place())
            .help(format!(
                "add `{wanted} = {{ unit = \"ms\", positive = true, default = \"5 ms\" }}` to the parameters"
            )));
    };
    if own.bounds.0 <= 0.0 {
        return Err(Complaint::new(Kind::Bounds, format!("the time constant `{wanted}` may be 0"))
            .at(lag.place())
            .help(format!("write `positive = true` at the parameter `{wanted}`")));
    }
    own.role = Role::Lag;
    Ok(Change::Follows(follows, own.name))
}
