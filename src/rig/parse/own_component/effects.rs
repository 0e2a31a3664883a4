//! Physics that a component of formulas has, and that a model may be given: `effect = { name, first }` at its parameters.

use crate::complaint::{Complaint, Kind, Place, capitalised};
use crate::physics::card::Card;
use crate::physics::effect::{At, Effect, Form, FreeParameter, InitialGuess};
use crate::rig::parse::kept::{kept, kept_list};
use crate::rig::source::Value;
use crate::units::Unit;

/// A parameter that belongs to an effect.
pub(super) struct Belongs {
    /// Name of the effect.
    effect: String,
    parameter: &'static str,
    meaning: &'static str,
    /// What it is without the effect, in the unit of the card; `None` where it has no default.
    default: Option<f64>,
    /// What is tried first, in the unit of the card.
    first: f64,
    /// In the unit of the card.
    plausible: (f64, f64),
    place: Place,
}

/// Reads the line of `parameter`.
pub(super) fn belongs(
    value: &Value<'_>,
    unit: &Unit,
    parameter: &'static str,
    meaning: &'static str,
    default: Option<f64>,
    bounds: (f64, f64),
) -> Result<Belongs, Complaint> {
    let line = value.table(format!("`effect` of parameter `{parameter}`"))?;
    let name = line.require("name", "add the name of the effect, such as `name = \"spool-hysteresis\"`")?;
    let effect = name.text()?.to_owned();
    if effect.is_empty() || effect.contains('@') {
        return Err(Complaint::new(Kind::Contradiction, format!("an effect cannot be called `{effect}`"))
            .at(name.place())
            .help("take a word without `@`, behind which a rig file writes the component"));
    }
    let first = line.require("first", "add the value that is tried first, such as `first = \"2 %\"`")?;
    let value_si = first.quantity(unit.dimension)?.value;
    let shown = unit.difference_from_si(value_si);
    if !(bounds.0..=bounds.1).contains(&shown) {
        return Err(Complaint::new(Kind::Bounds, format!("`first` of `{parameter}` is outside its bounds"))
            .at(first.place())
            .help("write a value at which the effect shows"));
    }
    let place = value.place();
    line.finish()?;
    Ok(Belongs { effect, parameter, meaning, default, first: shown, plausible: bounds, place })
}

/// The effects that the parameters of a component belong to; the first parameter of each is its size.
pub(super) fn effects(card: &'static Card, parameters: &[Belongs]) -> Result<Vec<&'static Effect>, Complaint> {
    let mut names: Vec<&str> = parameters.iter().map(|own| own.effect.as_str()).collect();
    let mut before = std::collections::BTreeSet::new();
    names.retain(|name| before.insert(*name));
    names
        .into_iter()
        .map(|name| effect(card, name, parameters.iter().filter(|own| own.effect == name).collect()))
        .collect()
}

fn effect(card: &'static Card, name: &str, parameters: Vec<&Belongs>) -> Result<&'static Effect, Complaint> {
    let size = parameters[0];
    if size.default.is_none() {
        return Err(Complaint::new(
            Kind::MissingEntry,
            format!("`{}`, the size of the effect `{name}`, has no default", size.parameter),
        )
        .at(size.place.clone())
        .help("add the default at which the component is as it would be without the effect"));
    }
    if size.default == Some(size.first) {
        return Err(Complaint::new(
            Kind::Bounds,
            format!("`first` of `{}`, the size of an effect, is its default", size.parameter),
        )
        .at(size.place.clone())
        .help("write a value at which the effect shows"));
    }
    let free = |(index, own): (usize, &&Belongs)| FreeParameter {
        name: own.parameter,
        neutral: own.default.filter(|_| index == 0),
        first: InitialGuess::Value(own.first),
        plausible: own.plausible,
    };
    let named: Vec<&str> = parameters.iter().map(|own| own.parameter).collect();
    Ok(Box::leak(Box::new(Effect {
        name: kept(name),
        meaning: kept(&format!("{}.", capitalised(size.meaning))),
        law: kept(&format!("the law of `{}` with its {}", card.kind, named.join(" and "))),
        source: card.source,
        validity: card.validity,
        empirical: false,
        everywhere: false,
        at: At::Component { card, named: true },
        form: Form::ParameterChange,
        parameters: kept_list(parameters.iter().enumerate().map(free).collect()),
    })))
}
