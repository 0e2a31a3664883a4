//! Numbers worked by hand beside the formulas: what they give is what stands there, or the file is not read.

use crate::complaint::{Complaint, Kind, help_with_names};
use crate::number::rounded;
use crate::physics::ATMOSPHERE;
use crate::physics::card::{Answer, Card, PortKind, Worked};
use crate::physics::component::AnyLaw;
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{PortFlows, PortVariables};
use crate::rig::parse::card_unit;
use crate::rig::parse::kept::{kept, kept_list};
use crate::rig::source::{Table, Value};
use crate::units::{Dimension, Quantity, Unit};

/// By how much the numbers may differ: three digits are what people work out.
const SHARE: f64 = 1e-3;

/// The worked numbers of a card, each of which its formulas give.
pub(super) fn read(card: &'static Card, value: Option<Value<'_>>) -> Result<&'static [Worked], Complaint> {
    let Some(value) = value else { return Ok(&[]) };
    let mut all = Vec::new();
    for value in value.one_or_more()? {
        let worked = one(card, &value.table("a worked number")?)?;
        check(card, &worked, &value)?;
        all.push(worked);
    }
    Ok(kept_list(all))
}

fn entries<'a>(table: &Table<'a>, key: &str) -> Result<Vec<(&'a str, Value<'a>)>, Complaint> {
    let Some(value) = table.get(key) else { return Ok(Vec::new()) };
    value.table(format!("`{key}` of {}", table.what))?.named_entries()
}

fn unknown(name: &str, value: &Value<'_>, known: &[String]) -> Complaint {
    Complaint::new(Kind::UnknownName, format!("there is no `{name}`")).at(value.place()).help(help_with_names(
        name,
        "names",
        known.iter().map(String::as_str),
    ))
}

fn one(card: &'static Card, table: &Table<'_>) -> Result<Worked, Complaint> {
    let text = table.require("text", "say in words what is worked out")?.text()?;
    let mut parameters = Vec::new();
    for (name, value) in entries(table, "with")? {
        let Some(own) = card.parameters.iter().find(|own| own.name == name) else {
            return Err(unknown(
                name,
                &value,
                &card.parameters.iter().map(|own| own.name.to_owned()).collect::<Vec<_>>(),
            ));
        };
        let unit = card_unit(own.unit);
        parameters.push((own.name, unit.difference_from_si(value.quantity(unit.dimension)?.value)));
    }
    let (at, inputs) = point(card, entries(table, "at")?)?;
    let help = "add what is to come out, such as `gives = { A = \"12 L/min\" }`: a port or a state";
    table.require("gives", help)?;
    let gives = entries(table, "gives")?;
    let [(name, value)] = gives.as_slice() else {
        return Err(Complaint::new(Kind::Shape, "a worked number is one number").at(table.place()).help(help));
    };
    table.finish()?;
    let (answer, dimension) = answer(card, name, value)?;
    let expect = value.quantity(dimension)?.value;
    Ok(Worked { text: kept(text), parameters: kept_list(parameters), at, inputs, answer, expect })
}

/// The variables and inputs where it is worked out, SI; what is not named is 0, pressures gauge.
type Point = (&'static [f64], &'static [f64]);

fn point(card: &Card, given: Vec<(&str, Value<'_>)>) -> Result<Point, Complaint> {
    let mut names: Vec<(String, Dimension, f64)> = Vec::new();
    for port in card.ports {
        match port.kind {
            PortKind::Hydraulic => names.push((format!("{}.p", port.name), Dimension::PRESSURE, ATMOSPHERE)),
            PortKind::Mechanical => {
                names.push((format!("{}.x", port.name), Dimension::LENGTH, 0.0));
                names.push((format!("{}.v", port.name), Dimension::VELOCITY, 0.0));
            }
        }
    }
    let of_unit = |name: &str, unit: &str| (name.to_owned(), card_unit(unit).dimension, 0.0);
    names.extend(card.states.iter().map(|state| of_unit(state.name, state.unit)));
    let variables = names.len();
    names.extend(card.inputs.iter().map(|input| of_unit(input.name, input.unit)));
    let mut values: Vec<f64> = names.iter().map(|(_, _, zero)| *zero).collect();
    for (name, value) in given {
        let Some(index) = names.iter().position(|(own, ..)| own == name) else {
            return Err(unknown(name, &value, &names.into_iter().map(|(own, ..)| own).collect::<Vec<_>>()));
        };
        values[index] += value.quantity(names[index].1)?.value;
    }
    let inputs = values.split_off(variables);
    Ok((kept_list(values), kept_list(inputs)))
}

fn answer(card: &Card, name: &str, value: &Value<'_>) -> Result<(Answer, Dimension), Complaint> {
    if let Some(port) = card.ports.iter().position(|port| port.name == name) {
        let hydraulic = card.ports[port].kind == PortKind::Hydraulic;
        return Ok((Answer::Through(port), if hydraulic { Dimension::FLOW } else { Dimension::FORCE }));
    }
    let Some(state) = card.states.iter().position(|state| state.name == name) else {
        let names = card.ports.iter().map(|port| port.name).chain(card.states.iter().map(|state| state.name));
        return Err(unknown(name, value, &names.map(str::to_owned).collect::<Vec<_>>()));
    };
    Ok((Answer::Rate(state), card_unit(card.states[state].unit).dimension.per(Dimension::TIME)))
}

/// That the formulas give the number, in the default fluid.
fn check(card: &'static Card, worked: &Worked, value: &Value<'_>) -> Result<(), Complaint> {
    let mut parameters = Vec::new();
    for own in card.parameters {
        let stated = |name: &str| worked.parameters.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
        let given = own.given(stated);
        let Some(number) = given.or(card.default_of(own)) else {
            return Err(Complaint::new(Kind::MissingEntry, format!("the worked number lacks `{}`", own.name))
                .at(value.place())
                .help("name it under `with`: it has no default"));
        };
        parameters.push(card_unit(own.unit).difference_to_si(number));
    }
    let of_fluid = fluid::CARD.parameters.iter().map(|own| card_unit(own.unit).to_si(own.default.unwrap_or(0.0)));
    let fluid = Fluid::new(&of_fluid.collect::<Vec<f64>>());
    let (mut seen, mut answers) = (PortVariables::default(), PortFlows::default());
    seen.z[..worked.at.len()].copy_from_slice(worked.at);
    seen.u[..worked.inputs.len()].copy_from_slice(worked.inputs);
    if let Some(law) = AnyLaw::new(card, &parameters, &fluid) {
        law.evaluate(&seen, &mut answers);
    }
    let (found, symbol) = match worked.answer {
        Answer::Through(port) => match card.ports[port].kind {
            PortKind::Hydraulic => (answers.through[port], "L/min"),
            PortKind::Mechanical => (answers.through[port], "N"),
        },
        Answer::Capacity(port) => (answers.capacity[port], "m3/Pa"),
        Answer::Rate(state) => (answers.rate[state], "-"),
    };
    if (found - worked.expect).abs() <= SHARE * worked.expect.abs() {
        return Ok(());
    }
    let unit: Unit = card_unit(symbol);
    let shown = |si: f64| Quantity { value: unit.to_si(rounded(unit.from_si(si), 5)), unit: unit.clone() };
    let what = format!("the formulas give {} and not {}: {}", shown(found), shown(worked.expect), worked.text);
    Err(Complaint::new(Kind::Contradiction, what).at(value.place()).help(
        "flows count into the port, forces in the direction of the position; correct the formulas, or the number",
    ))
}
