//! Effects of the user's own: `[own_effects.NAME]`.

use super::Value;
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::expression::{Expression, Name};
use crate::physics::card::{Card, Parameter, Port, PortKind};
use crate::physics::component::{PORTS, VARIABLES};
use crate::physics::effect::{At, Effect, First, Form, Free, Joint, effect};
use crate::physics::formula::MOST_PARAMETERS;
use crate::rig::source::Table;
use crate::rig::{NodeKind, Rig};
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
    if effect(name).is_some() || name.contains('@') {
        return Err(Complaint::new(Kind::Duplicate, format!("an effect of one's own cannot be called `{name}`"))
            .at(value.place())
            .help("the library has one of this name, or it holds an `@`: take another"));
    }
    let table = value.table(format!("effect `{name}`"))?;
    let at = table.require("at", "add the node where it acts, such as `at = \"A\"`")?;
    let node = node(rig, &at)?;
    let kind = kind(rig, node);
    let (key, dimension) = match kind {
        PortKind::Hydraulic => ("flow", Dimension::FLOW),
        PortKind::Mechanical => ("force", Dimension::FORCE),
    };
    let formula = table.require(key, "add the formula: `flow` out of a node with a volume, `force` on a body")?;
    let meaning = table.get("meaning").map(|text| text.text()).transpose()?.unwrap_or("An effect of the rig file.");
    let parameters = table.require("parameters", "add its parameters, the size first")?;
    let own = read_parameters(&parameters)?;
    table.finish()?;

    let joints = joints(rig, node, kind, &formula)?;
    let ports: Vec<PortKind> = joints.iter().map(|&node| self::kind(rig, node)).collect();
    let mut names = variables(rig, &joints);
    names.extend(own.iter().map(|own| Name::new(own.name.clone(), own.unit.dimension)));
    let expression = Expression::parse_as(formula.text()?, &names, dimension).map_err(|error| {
        Complaint::new(Kind::Syntax, error.to_string()).at(formula.place()).help(error.help.clone())
    })?;
    check_neutral(&expression, &own, &ports, &formula)?;

    let joints: Vec<Joint> = joints.iter().map(|&node| Joint::Named(kept(&rig.nodes[node].name))).collect();
    let card = Card {
        kind: kept(&format!("own:{name}")),
        meaning: kept(meaning),
        law: kept(&format!("{key} = {}", formula.text()?)),
        source: "the rig file",
        validity: "As its author meant it.",
        parameters: kept_list(own.iter().map(parameter).collect()),
        ports: kept_list(ports.iter().map(|&kind| Port { name: "", kind, meaning: "" }).collect()),
        formula: Some(Box::leak(Box::new(expression))),
        ..Card::EMPTY
    };
    let card: &'static Card = Box::leak(Box::new(card));
    rig.own_effects.push(Box::leak(Box::new(Effect {
        name: kept(name),
        meaning: card.meaning,
        law: card.law,
        source: card.source,
        validity: card.validity,
        at: At::Named(kept(&rig.nodes[node].name)),
        form: Form::Joined { card, joints: kept_list(joints), shared: &[] },
        parameters: kept_list(own.iter().map(free).collect()),
    })));
    Ok(())
}

/// Cards are constants everywhere else; those of a rig file live as long as the program, which reads few of them.
fn kept(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

fn kept_list<T>(list: Vec<T>) -> &'static [T] {
    Box::leak(list.into_boxed_slice())
}

fn node(rig: &Rig, value: &Value<'_>) -> Result<usize, Complaint> {
    let name = value.text()?;
    let acts = rig.node(name).filter(|&node| !matches!(rig.nodes[node].kind, NodeKind::Held { .. }));
    acts.ok_or_else(|| {
        let free = rig.nodes.iter().filter(|node| !matches!(node.kind, NodeKind::Held { .. }));
        Complaint::new(Kind::UnknownName, format!("nothing can act at `{name}`"))
            .at(value.place())
            .help(help_with_names(name, "nodes", free.map(|node| node.name.as_str())))
    })
}

fn kind(rig: &Rig, node: usize) -> PortKind {
    if matches!(rig.nodes[node].kind, NodeKind::Body { .. }) { PortKind::Mechanical } else { PortKind::Hydraulic }
}

/// What the ports see, by name.
fn variables(rig: &Rig, joints: &[usize]) -> Vec<Name> {
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
    joints.iter().flat_map(of).collect()
}

/// The nodes that the effect meets: where it acts, the tank behind a flow, and what else the formula names.
fn joints(rig: &Rig, node: usize, acts: PortKind, formula: &Value<'_>) -> Result<Vec<usize>, Complaint> {
    let mut joints = vec![node];
    if acts == PortKind::Hydraulic {
        let tank = rig.components.iter().find(|component| component.card.fixes_pressure.is_some());
        let Some(tank) = tank else {
            return Err(Complaint::new(Kind::MissingEntry, "a flow needs a tank to go to, and this rig has none")
                .at(formula.place())
                .help("add a component of kind `tank`"));
        };
        joints.push(tank.ports[0]);
    }
    let text = formula.text()?;
    let part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
    for word in text.split(|c: char| !part(c)) {
        let Some((name, _)) = word.rsplit_once('.') else { continue };
        joints.extend(rig.node(name).filter(|node| !joints.contains(node)));
    }
    let variables: usize = joints.iter().map(|&node| kind(rig, node).variables()).sum();
    if joints.len() > PORTS || variables > VARIABLES {
        return Err(Complaint::new(Kind::Bounds, "the formula looks at too many nodes")
            .at(formula.place())
            .help(format!("it may meet {PORTS} nodes with {VARIABLES} variables, the tank among them")));
    }
    Ok(joints)
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
    Ok(Own {
        name: name.to_owned(),
        first: first.value,
        neutral: neutral.map(|quantity| quantity.value),
        unit,
        bounds,
        meaning,
    })
}

/// At its neutral value the size has to switch the effect off.
fn check_neutral(
    expression: &Expression,
    own: &[Own],
    ports: &[PortKind],
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
    // Ordinary states: pressures up to 100 bar, positions and speeds of a cylinder.
    for share in [0.0, 0.1, 0.37, 1.0] {
        let of_port = |kind: &PortKind| match kind {
            PortKind::Hydraulic => vec![1e7 * share],
            PortKind::Mechanical => vec![0.1 * share, 0.2 * share - 0.1],
        };
        let mut values: Vec<f64> = ports.iter().flat_map(of_port).collect();
        values.push(neutral);
        values.extend(own[1..].iter().map(|own| own.first));
        let value = expression.evaluate(&values);
        if value != 0.0 {
            return wrong(
                format!(
                    "with `{}` at its neutral value the effect is not nothing but {value:.3e} in SI units",
                    own[0].name
                ),
                "make the formula vanish there, or state another neutral value",
            );
        }
    }
    Ok(())
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

fn free(own: &Own) -> Free {
    Free {
        name: kept(&own.name),
        neutral: own.neutral.map(|neutral| own.shown(neutral)),
        first: First::Value(own.shown(own.first)),
        plausible: (own.shown(own.bounds.0), own.shown(own.bounds.1)),
    }
}
