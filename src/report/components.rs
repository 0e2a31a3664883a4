//! The component kinds as a table, as cards, and as programs read them (`borescope.components/1`).

use serde::Serialize;

use super::table::{Head, aligned, fitted};
use crate::physics::card::{Card, Parameter, PortKind};
use crate::physics::component::CARDS;
use crate::rig::catalogue;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.components/1";

/// Something with a name, a unit and a meaning: an input, a state.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Named {
    /// As formulas know it.
    pub name: &'static str,
    /// Unit of the numbers beside it.
    pub unit: &'static str,
    /// In words.
    pub meaning: &'static str,
}

/// A port of a component.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct PortReport {
    /// As the rig file has it.
    pub name: &'static str,
    /// `hydraulic` or `body`.
    pub meets: &'static str,
    /// In words.
    pub meaning: &'static str,
}

/// A parameter of a component. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ParameterReport {
    /// As the rig file has it.
    pub name: &'static str,
    /// Unit of the numbers beside it.
    pub unit: &'static str,
    /// `None` where the rig file has to speak, or another parameter stands for it.
    pub default: Option<f64>,
    /// Parameter whose stated value it has where the rig file is silent.
    pub default_from: Option<&'static str>,
    /// Physical limits; an end is `None` where there is none.
    pub bounds: [Option<f64>; 2],
    /// In words.
    pub meaning: &'static str,
}

/// The card of a component kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ComponentReport {
    /// What a rig file writes.
    pub kind: &'static str,
    /// Whether it is a file of the catalogue, which can be copied and changed.
    pub catalogue: bool,
    /// In words.
    pub meaning: &'static str,
    /// Its formula.
    pub law: &'static str,
    /// Where the law is from.
    pub source: &'static str,
    /// Where the law holds.
    pub validity: &'static str,
    /// In the order of the card.
    pub ports: Vec<PortReport>,
    /// In the order of the card.
    pub parameters: Vec<ParameterReport>,
    /// What a record has to give it.
    pub inputs: Vec<Named>,
    /// What it remembers.
    pub states: Vec<Named>,
}

/// All component kinds.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ComponentsReport {
    pub schema: &'static str,
    /// In the order of the library.
    pub components: Vec<ComponentReport>,
}

/// Every card that a rig file may name without describing it: those built in, then the catalogue, if its files read.
pub fn cards() -> impl Iterator<Item = &'static Card> {
    CARDS.iter().copied().chain(catalogue::kinds().into_iter().flatten().map(|kind| kind.card))
}

/// The card of a kind; of the catalogue its name alone will do where nothing built in has it.
pub fn find(kind: &str) -> Option<&'static Card> {
    let of_catalogue = |card: &&Card| card.own.is_some() && card.kind.rsplit(':').next() == Some(kind);
    cards().find(|card| card.kind == kind).or_else(|| cards().find(of_catalogue))
}

impl ComponentsReport {
    /// With every kind.
    pub fn all() -> Self {
        Self { schema: SCHEMA, components: cards().map(ComponentReport::new).collect() }
    }

    /// With one kind alone.
    pub fn of(card: &Card) -> Self {
        Self { schema: SCHEMA, components: vec![ComponentReport::new(card)] }
    }
}

impl ComponentReport {
    fn new(card: &Card) -> Self {
        let port = |port: &crate::physics::card::Port| PortReport {
            name: port.name,
            meets: if port.kind == PortKind::Hydraulic { "hydraulic" } else { "body" },
            meaning: port.meaning,
        };
        let named = |(name, unit, meaning)| Named { name, unit, meaning };
        Self {
            kind: card.kind,
            catalogue: card.own.is_some(),
            meaning: card.meaning,
            law: card.law,
            source: card.source,
            validity: card.validity,
            ports: card.ports.iter().map(port).collect(),
            parameters: card.parameters.iter().map(parameter).collect(),
            inputs: card.inputs.iter().map(|own| named((own.name, own.unit, own.meaning))).collect(),
            states: card.states.iter().map(|own| named((own.name, own.unit, own.meaning))).collect(),
        }
    }
}

fn parameter(own: &Parameter) -> ParameterReport {
    let (low, high) = own.bounds;
    ParameterReport {
        name: own.name,
        unit: own.unit,
        default: own.default,
        default_from: own.default_from,
        bounds: [low, high].map(|end| end.is_finite().then_some(end)),
        meaning: own.meaning,
    }
}

const KIND_HEADS: [Head; 2] = [("kind", false), ("meaning", false)];
const PARAMETER_HEADS: [Head; 4] = [("parameter", false), ("unit", false), ("default", true), ("meaning", false)];
const NAMED_HEADS: [Head; 3] = [("name", false), ("unit or node", false), ("meaning", false)];

/// All kinds as a table.
pub fn library() -> String {
    let row = |card: &'static Card| {
        let ports: Vec<&str> = card.ports.iter().map(|port| port.name).collect();
        vec![card.kind.to_owned(), format!("{} Ports: {}.", card.meaning, ports.join(", "))]
    };
    let mut all: Vec<&'static Card> = cards().collect();
    all.sort_by_key(|card| (card.own.is_some(), card.kind));
    let rows: Vec<Vec<String>> = all.into_iter().map(row).collect();
    aligned(&KIND_HEADS, &rows).join("\n")
        + "\n\nThe card of one: borescope components KIND\nThe file of one of the catalogue, to copy and change: --source\n"
}

/// One card as text.
pub fn card(card: &Card) -> String {
    let report = ComponentReport::new(card);
    let mut lines = vec![report.kind.to_owned(), report.meaning.to_owned(), String::new()];
    lines.push(format!("law       {}", report.law.replace('\n', "\n          ")));
    lines.push(format!("validity  {}", report.validity));
    lines.push(format!("source    {}", report.source));
    lines.push(String::new());
    let ports = report
        .ports
        .iter()
        .map(|port| vec![format!("port {}", port.name), port.meets.to_owned(), port.meaning.to_owned()]);
    let named = |what: &'static str| {
        move |own: &Named| vec![format!("{what} {}", own.name), own.unit.to_owned(), own.meaning.to_owned()]
    };
    let inputs = report.inputs.iter().map(named("input"));
    let states = report.states.iter().map(named("state"));
    lines.extend(aligned(&NAMED_HEADS, &ports.chain(inputs).chain(states).collect::<Vec<_>>()));
    if !report.parameters.is_empty() {
        let row = |own: &ParameterReport| {
            let default = match (own.default_from, own.default) {
                (Some(other), _) => other.to_owned(),
                (None, Some(default)) => crate::number::text(default),
                (None, None) => "must be given".to_owned(),
            };
            vec![own.name.to_owned(), own.unit.to_owned(), default, own.meaning.to_owned()]
        };
        lines.push(String::new());
        lines.extend(aligned(&PARAMETER_HEADS, &report.parameters.iter().map(row).collect::<Vec<_>>()));
    }
    fitted(&(lines.join("\n") + "\n"))
}
