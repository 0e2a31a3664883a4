//! What the formulas of a component may name, and in which order they are given it.

use std::sync::Arc;

use super::lines::StateLine;
use crate::complaint::{Complaint, Kind};
use crate::expression::{Expression, ExpressionError, Name, Sheet};
use crate::physics::card::{Input, Parameter, Port, PortKind};
use crate::physics::own::MOST_VALUES;
use crate::rig::parse::card_unit;
use crate::rig::source::Value;
use crate::units::{Dimension, Unit};

/// How a formula calls the time since the run began.
pub(super) const TIME: &str = "t";
/// The density of the fluid, which parameters and it alone determine.
const DENSITY: &str = "fluid.density";
/// Its viscosity, which its temperature changes.
pub(super) const VISCOSITY: &str = "fluid.viscosity";

/// The names of all values, in their order: see [`Own`](crate::physics::own::Own).
pub(super) struct Names {
    /// Parameters, density, fixed quantities.
    constant: Vec<Name>,
    /// Variables of the ports, states, inputs, time, viscosity, moving quantities.
    changing: Vec<Name>,
    /// The places of variables, states and inputs among those that change.
    pub variables: usize,
    pub states: usize,
    /// Tables that formulas may call.
    sheets: Vec<Arc<Sheet>>,
}

/// The names of the variables of a port.
fn variables(port: &Port) -> Vec<Name> {
    match port.kind {
        PortKind::Hydraulic => vec![Name::new(format!("{}.p", port.name), Dimension::PRESSURE)],
        PortKind::Mechanical => vec![
            Name::new(format!("{}.x", port.name), Dimension::LENGTH),
            Name::new(format!("{}.v", port.name), Dimension::VELOCITY),
        ],
    }
}

impl Names {
    /// How many values there are that may change.
    pub fn changing(&self) -> usize {
        self.changing.len()
    }

    pub fn new(
        parameters: &[Parameter],
        ports: &[Port],
        states: &[StateLine<'_>],
        inputs: &[Input],
        sees_time: bool,
    ) -> Self {
        let named = |name: &str, unit: &str| Name::new(name, card_unit(unit).dimension);
        let mut constant: Vec<Name> = parameters.iter().map(|own| named(own.name, own.unit)).collect();
        let cubic_metre = Dimension::LENGTH.power(3);
        let density = Unit::parse("kg/m3").map_or(cubic_metre, |unit| unit.dimension);
        constant.push(Name::new(DENSITY, density));
        let mut changing: Vec<Name> = ports.iter().flat_map(variables).collect();
        let variables = changing.len();
        changing.extend(states.iter().map(|state| Name::new(state.name, state.unit.dimension)));
        changing.extend(inputs.iter().map(|input| named(input.name, input.unit)));
        changing.extend(sees_time.then(|| Name::new(TIME, Dimension::TIME)));
        let viscosity = Unit::parse("Pa.s").map_or(cubic_metre, |unit| unit.dimension);
        changing.push(Name::new(VISCOSITY, viscosity));
        Self { constant, changing, variables, states: states.len(), sheets: Vec::new() }
    }

    /// The same with tables.
    pub fn with_tables(self, sheets: Vec<Arc<Sheet>>) -> Self {
        Self { sheets, ..self }
    }

    /// A formula of all names and tables.
    pub fn parse(&self, text: &str) -> Result<Expression, ExpressionError> {
        Expression::parse_with(text, &self.all(), &self.sheets)
    }

    /// All names.
    pub fn all(&self) -> Vec<Name> {
        self.constant.iter().chain(&self.changing).cloned().collect()
    }

    /// How many do not change.
    pub fn constants(&self) -> usize {
        self.constant.len()
    }

    /// Whether a name is taken.
    pub fn has(&self, name: &str) -> bool {
        self.constant.iter().chain(&self.changing).any(|one| one.name == name)
    }

    /// A formula of what does not change, where it is one.
    pub fn fixed(&self, text: &str) -> Option<Expression> {
        Expression::parse_with(text, &self.constant, &self.sheets).ok()
    }

    /// One more quantity, which others may build on.
    pub fn add(&mut self, name: &str, dimension: Dimension, fixed: bool, value: &Value<'_>) -> Result<(), Complaint> {
        let list = if fixed { &mut self.constant } else { &mut self.changing };
        list.push(Name::new(name, dimension));
        if self.constant.len() + self.changing.len() > MOST_VALUES {
            let what = format!("more than {MOST_VALUES} parameters, variables and quantities");
            return Err(Complaint::new(Kind::Bounds, what).at(value.place()).help("make two components of it"));
        }
        Ok(())
    }
}

/// The names of lines and quantities, each with the place of its line, have to be words that mean one thing.
pub(super) fn check_words<'a>(words: impl Iterator<Item = (&'a str, &'a Value<'a>)>) -> Result<(), Complaint> {
    let mut known: Vec<&str> = vec![TIME];
    for (word, value) in words {
        let refuse = |kind, why: &str, help: &str| {
            Err(Complaint::new(kind, format!("`{word}` {why}")).at(value.place()).help(help))
        };
        if let Err(error) = Expression::parse("0", &[Name::new(word, Dimension::NONE)]) {
            return refuse(Kind::Syntax, error.message.split_once("` ").map_or("", |(_, why)| why), &error.help);
        }
        if word.contains('.') {
            return refuse(
                Kind::Syntax,
                "has a point, which stands between a port and its pressure",
                "take a name without",
            );
        }
        if known.contains(&word) {
            return refuse(Kind::Duplicate, "names two things in the formulas", "take another name for one of them");
        }
        known.push(word);
    }
    Ok(())
}
