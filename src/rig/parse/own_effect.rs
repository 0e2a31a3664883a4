//! Effects of the user's own: `[own_effects.NAME]`.

mod sees;

pub(super) use sees::words;
use sees::{Acts, Sees, THROUGH, acts, kind};

use super::Value;
use super::kept::{kept, kept_list};
use crate::complaint::{Complaint, Kind};
use crate::expression::{Expression, Name};
use crate::physics::card::{ANY, Card, Input, Parameter, Port, PortKind};
use crate::physics::effect::{At, Effect, Form, FreeParameter, InitialGuess, Joint, effect};
use crate::physics::formula::MOST_PARAMETERS;
use crate::rig::Rig;
use crate::rig::source::Table;
use crate::units::{Dimension, Unit};

/// A parameter as its line has it.
struct Own {
    name: String,
    unit: Unit,
    first: f64,
    neutral: Option<f64>,
    bounds: (f64, f64),
    meaning: String,
}

/// Reads one effect, and adds it to those that the rig may have.
pub(super) fn read_own_effect(rig: &mut Rig, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let known = effect(name).is_some() || rig.own_effects.iter().any(|other| other.name == name);
    if known || name.contains('@') {
        return Err(Complaint::new(Kind::Duplicate, format!("an effect of one's own cannot be called `{name}`"))
            .at(value.place())
            .help("the library or a component has one of this name, or it holds an `@`: take another"));
    }
    let table = value.table(format!("effect `{name}`"))?;
    let at = table.require("at", "add the node, sensor or component where it acts, such as `at = \"A\"`")?;
    let acts = acts(rig, &at)?;
    let (key, dimension, what) = match acts {
        Acts::Flow(_) => ("flow", Dimension::FLOW, "a node with a volume"),
        Acts::Force(_) => ("force", Dimension::FORCE, "a body"),
        Acts::Reading(sensor) => ("reading", rig.sensors[sensor].dimension, "a sensor"),
        Acts::Drop(_) => ("drop", Dimension::PRESSURE, "a component that throttles"),
    };
    let others = ["flow", "force", "reading", "drop"].into_iter().filter(|other| *other != key);
    if let Some((other, value)) = others.into_iter().find_map(|key| Some((key, table.get(key)?))) {
        return Err(Complaint::new(Kind::Contradiction, format!("no `{other}` acts at `{}`", at.text()?))
            .at(value.place())
            .help(format!("that is {what}: write `{key} = ...`, or another `at`")));
    }
    let formula = table.require(
        key,
        "add the formula: `flow` out of a node with a volume, `force` on a body, `reading` of a sensor, `drop` of pressure ahead of an \
         orifice",
    )?;
    let meaning = table.get("meaning").map(|text| text.text()).transpose()?.unwrap_or("An effect of the rig file.");
    let parameters = table.require(
        "parameters",
        "add its parameters, the size first, such as `parameters.G = { neutral = \"0 L/min/bar\", first = \"0.002 L/min/bar\" \
         }`",
    )?;
    let own = read_parameters(&parameters)?;
    table.finish()?;
    check_names(rig, acts, &own, &formula)?;

    let sees = Sees::of(rig, acts, &own, &formula)?;
    let mut names = sees.names(rig, acts);
    let parameter_names = || own.iter().map(|own| Name::new(own.name.clone(), own.unit.dimension));
    names.extend(parameter_names());
    let text = formula.text()?;
    let expression = Expression::parse_as(text, &names, dimension).map_err(|error| {
        // The help names what it might have seen, not only what it does see.
        let mut all = Sees::everything(rig, acts).names(rig, acts);
        all.extend(parameter_names());
        let error = Expression::parse_as(text, &all, dimension).err().unwrap_or(error);
        Complaint::new(Kind::Syntax, error.to_string()).at(formula.place_in_text(error.offset)).help(error.help.clone())
    })?;
    let ports: Vec<PortKind> = sees.nodes.iter().map(|&node| kind(rig, node)).collect();
    check_neutral(&expression, &own, acts, &names[..names.len() - own.len()], &formula)?;
    if matches!(acts, Acts::Drop(_)) {
        check_rising(&expression, &own, &formula)?;
    }

    let input =
        |&input: &usize| Input { name: kept(&rig.inputs[input].name), unit: "", meaning: "", range: ANY, lag: None };
    let card = Card {
        kind: kept(&format!("own:{name}")),
        meaning: kept(meaning),
        law: kept(&format!("{key} = {text}")),
        source: "the rig file",
        validity: "As its author meant it.",
        parameters: kept_list(own.iter().map(parameter).collect()),
        ports: kept_list(ports.iter().map(|&kind| Port { name: "", kind, meaning: "" }).collect()),
        inputs: kept_list(sees.inputs.iter().map(input).collect()),
        sees_time: sees.time,
        formula: Some(Box::leak(Box::new(expression))),
        ..Card::EMPTY
    };
    let card: &'static Card = Box::leak(Box::new(card));
    let joints = sees.nodes.iter().map(|&node| Joint::Named(kept(&rig.nodes[node].name))).collect();
    let (at, form) = match acts {
        Acts::Flow(node) | Acts::Force(node) => {
            (At::Named(kept(&rig.nodes[node].name)), Form::Shunt { card, joints: kept_list(joints), shared: &[] })
        }
        Acts::Reading(sensor) => (At::NamedSensor(kept(&rig.sensors[sensor].name)), Form::Reading { card }),
        Acts::Drop(component) => {
            (At::NamedComponent(kept(&rig.components[component].name)), Form::PressureLoss { card })
        }
    };
    rig.own_effects.push(Box::leak(Box::new(Effect {
        empirical: false,
        everywhere: false,
        name: kept(name),
        meaning: card.meaning,
        law: card.law,
        source: card.source,
        validity: card.validity,
        at,
        form,
        parameters: kept_list(own.iter().map(free).collect()),
    })));
    Ok(())
}

fn read_parameters(value: &Value<'_>) -> Result<Vec<Own>, Complaint> {
    let table = value.table(value.what.clone())?;
    let own = table.entries().into_iter().map(|(name, value)| read_parameter(name, &value));
    let own = own.collect::<Result<Vec<Own>, Complaint>>()?;
    // All entries are parameters.
    own.iter().for_each(|own| drop(table.get(&own.name)));
    table.finish()?;
    if own.is_empty() || own.len() > MOST_PARAMETERS {
        return Err(Complaint::new(Kind::Bounds, format!("{} holds {} parameters", value.what, own.len()))
            .at(value.place())
            .help(format!("write one to {MOST_PARAMETERS}, the size first")));
    }
    Ok(own)
}

/// What of a rig a formula sees by a name, in words.
fn owner(rig: &Rig, name: &str) -> &'static str {
    if rig.inputs.iter().any(|input| input.name == name) {
        "an input"
    } else if rig.node(name).is_some() {
        "a node"
    } else {
        "something"
    }
}

/// Every parameter is used, and none is called as what the formula may see.
fn check_names(rig: &Rig, acts: Acts, own: &[Own], formula: &Value<'_>) -> Result<(), Complaint> {
    let seen = Sees::everything(rig, acts).names(rig, acts);
    for one in own {
        if seen.iter().any(|name| name.name == one.name) {
            return Err(Complaint::new(Kind::Duplicate, format!("a parameter cannot be called `{}`", one.name))
                .at(formula.place())
                .help(format!(
                    "{} of the rig has this name, which the formula may see: take another, such as `{}_extra`",
                    owner(rig, &one.name),
                    one.name
                )));
        }
        if words(formula.text()?).all(|word| word != one.name) {
            return Err(Complaint::new(Kind::Contradiction, format!("the formula does not use `{}`", one.name))
                .at(formula.place())
                .help("use it, or leave the parameter out: no record could say what it is"));
        }
    }
    Ok(())
}

fn read_parameter(name: &str, value: &Value<'_>) -> Result<Own, Complaint> {
    let table: Table<'_> = value.table(format!("parameter `{name}`"))?;
    let first = table.require("first", "add the value that is tried first, such as `first = \"0.002 L/min/bar\"`")?;
    let first = first.any_quantity()?;
    let unit = first.unit.clone();
    let neutral = table.get("neutral").map(|value| value.quantity(unit.dimension)).transpose()?;
    let bounds = match table.get("bounds") {
        None => (f64::NEG_INFINITY, f64::INFINITY),
        Some(value) => {
            let ends = value.list()?;
            let [low, high] = ends.as_slice() else {
                return Err(Complaint::new(Kind::Shape, format!("{} is no pair", value.what))
                    .at(value.place())
                    .help("write the least and the largest value"));
            };
            (low.quantity(unit.dimension)?.value, high.quantity(unit.dimension)?.value)
        }
    };
    let meaning = table.get("meaning").map(|text| text.text()).transpose()?.unwrap_or(name).to_owned();
    table.finish()?;
    let between = |value: f64| (bounds.0..=bounds.1).contains(&value);
    let outside = [("first", Some(first.value)), ("neutral", neutral.as_ref().map(|neutral| neutral.value))];
    let outside = outside.into_iter().find_map(|(key, value)| value.filter(|value| !between(*value)).map(|_| key));
    if let Some(what) = if bounds.0 < bounds.1 { outside } else { Some("bounds") } {
        let said = match what {
            "bounds" => format!("the first of the bounds of `{name}` is not below the second"),
            key => format!("`{key}` of `{name}` is outside its bounds"),
        };
        return Err(Complaint::new(Kind::Bounds, said)
            .at(value.place())
            .help("write the least and the largest value that make sense, and `first` and `neutral` between them"));
    }
    Ok(Own {
        name: name.to_owned(),
        first: first.value,
        neutral: neutral.map(|quantity| quantity.value),
        unit,
        bounds,
        meaning,
    })
}

/// At its neutral value the size has to switch the effect off: no flow, no force, a reading as it is. `seen` are the names of what
/// the formula sees.
fn check_neutral(
    expression: &Expression,
    own: &[Own],
    acts: Acts,
    seen: &[Name],
    formula: &Value<'_>,
) -> Result<(), Complaint> {
    let wrong =
        |what: String, help: &str| Err(Complaint::new(Kind::Contradiction, what).at(formula.place()).help(help));
    let Some(neutral) = own[0].neutral else {
        return wrong(
            format!("`{}`, the first parameter, is the size, and has no neutral value", own[0].name),
            "add `neutral`, at which the effect does nothing",
        );
    };
    for share in [0.0, 0.1, 0.37, 1.0] {
        let mut values: Vec<f64> = seen.iter().map(|name| ordinary(name.dimension, share)).collect();
        let (nothing, rounding) = match acts {
            // A reading is put together from terms of its size, and may miss itself by their rounding.
            Acts::Reading(_) => (values[0], 1e-12 * ordinary(seen[0].dimension, 1.0)),
            Acts::Flow(_) | Acts::Force(_) | Acts::Drop(_) => (0.0, 0.0),
        };
        values.push(neutral);
        values.extend(own[1..].iter().map(|own| own.first));
        let value = expression.evaluate(&values);
        if (value - nothing).abs() > rounding {
            return wrong(
                format!(
                    "with `{}` at its neutral value the effect is not nothing but {:.3e} in SI units",
                    own[0].name,
                    value - nothing
                ),
                "make the formula do nothing there, or state another neutral value",
            );
        }
    }
    Ok(())
}

/// Of pressure that is lost over a flow more is lost the more flows, in its direction: one flow solves it then.
fn check_rising(expression: &Expression, own: &[Own], formula: &Value<'_>) -> Result<(), Complaint> {
    let lost = |flow: f64| {
        let mut values = vec![1e7, 0.0, flow];
        values.extend(own.iter().map(|own| own.first));
        expression.evaluate(&values)
    };
    let flows = [-3e-4, -1e-4, -3e-5, -1e-5, 0.0, 1e-5, 3e-5, 1e-4, 3e-4];
    if flows.windows(2).all(|pair| lost(pair[0]) <= lost(pair[1])) {
        return Ok(());
    }
    let what = format!("the drop does not rise with the flow `{THROUGH}` while its parameters are what is tried first");
    Err(Complaint::new(Kind::Contradiction, what)
        .at(formula.place())
        .help(format!("flow may go either way: write `{THROUGH} * abs({THROUGH})` for a square")))
}

/// What something of a dimension may be in a circuit, SI, `share` of the way through: pressures up to 100 bar, positions and
/// speeds of a cylinder, forces up to 1 kN.
fn ordinary(dimension: Dimension, share: f64) -> f64 {
    match dimension {
        Dimension::PRESSURE => 1e7 * share,
        Dimension::LENGTH => 0.1 * share,
        Dimension::VELOCITY => 0.2 * share - 0.1,
        Dimension::FLOW => 1e-4 * share,
        Dimension::FORCE => 1e3 * share,
        _ => share,
    }
}

impl Own {
    /// A value in the unit of the parameter; what is unbounded stays so.
    fn shown(&self, si: f64) -> f64 {
        if si.is_finite() { self.unit.difference_from_si(si) } else { si }
    }
}

fn parameter(own: &Own) -> Parameter {
    let default = Some(own.shown(own.neutral.unwrap_or(own.first)));
    let bounds = (own.shown(own.bounds.0), own.shown(own.bounds.1));
    let (name, unit, meaning) = (kept(&own.name), kept(&own.unit.symbol), kept(&own.meaning));
    Parameter { default, bounds, ..Parameter::required(name, name, unit, meaning) }
}

fn free(own: &Own) -> FreeParameter {
    FreeParameter {
        name: kept(&own.name),
        neutral: own.neutral.map(|neutral| own.shown(neutral)),
        first: InitialGuess::Value(own.shown(own.first)),
        plausible: (own.shown(own.bounds.0), own.shown(own.bounds.1)),
    }
}
