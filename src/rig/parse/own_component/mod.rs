//! Components of formulas: `[own_components.NAME]`, in the rig file, in a file beside it or in the catalogue.

mod domain;
mod effects;
mod facts;
mod formulas;
mod lines;
mod names;
mod tables;
mod worked;

use formulas::{Formulas, Lines};
use lines::{Change, StateLine};
use names::{Names, TIME, VISCOSITY, check_words};

use super::kept::{kept, kept_list};
use super::own_effect::words;
use crate::complaint::{Complaint, Kind, Place};
use crate::expression::Schedule;
use crate::physics::card::{Card, Input, Parameter, Port, State};
use crate::physics::effect::Effect;
use crate::physics::own::Own;
use crate::physics::ports::INPUTS;
use crate::rig::Beside;
use crate::rig::source::{Table, Value};

/// A kind of component that formulas describe.
#[derive(Debug)]
pub(crate) struct OwnKind {
    /// Its `kind` is what a rig file writes.
    pub card: &'static Card,
    own: &'static Own,
    /// Where each formula is written, in the order of [`Own::formulas`].
    places: Vec<Place>,
    /// Where each state starts, SI; `None` at rest.
    pub initial: Vec<Option<f64>>,
    /// Files that its formulas read tables from.
    pub files: Vec<Beside>,
    /// Physics that its parameters hold and that a model may be given.
    pub effects: Vec<&'static Effect>,
    /// Where it begins.
    pub place: Place,
}

/// Reads one; `kind` is what components call it.
pub(super) fn read_own_component(kind: &str, value: &Value<'_>) -> Result<OwnKind, Complaint> {
    let table = value.table(format!("component kind `{kind}`"))?;
    let text = |key: &str| table.get(key).map(|value| value.text()).transpose();
    let meaning = text("meaning")?.unwrap_or("A component of the rig file.");
    let source = text("source")?.unwrap_or("the rig file");
    let validity = text("validity")?.unwrap_or("As its author meant it.");
    let symbol = facts::symbol(&table)?;
    let ports = lines::ports(&table)?;
    let (mut parameters, of_effects) = lines::parameters(&table)?;
    let inputs = lines::inputs(&table)?;
    let (sheets, files) = tables::read(&table)?;
    let states = lines::states(&table, &ports, &mut parameters)?;
    let lines = Lines::read(&table, &ports)?;
    let numbers = table.get("worked");
    table.finish()?;
    check_all_words(&table, &lines)?;

    let all_texts = || lines.texts().chain(states.iter().map(|state| state.change.formula()));
    let texts: Vec<&str> = all_texts().map(Value::text).collect::<Result<_, _>>()?;
    let names_it = |wanted: &str| texts.iter().any(|text| words(text).any(|word| word == wanted));
    let sees_time = names_it(TIME);
    if inputs.len() + usize::from(sees_time) > INPUTS {
        return Err(Complaint::new(Kind::Bounds, format!("{} sees too many inputs", table.what))
            .at(table.place())
            .help(format!("it may see {INPUTS}, the time `{TIME}` among them")));
    }
    let mut names = Names::new(&parameters, &ports, &states, &inputs, sees_time).with_tables(sheets);
    let seen = names.changing();
    let formulas = Formulas::read(&lines, &states, &mut names)?;
    formulas.check_size(&table)?;
    let used = Used { formulas: &formulas, names: &names, lines: &lines, table: &table };
    used.parameters(&parameters)?;
    used.ports(&ports)?;
    used.states(&states)?;
    used.inputs(&inputs)?;
    used.quantities()?;

    let initial = states.iter().map(|state| state.initial.map(|initial| state.unit.to_si(initial))).collect();
    let places = formulas.written().map(|(_, place)| place.clone()).collect();
    let law = law(&lines, &states)?;
    let own: &'static Own = Box::leak(Box::new(assemble(&formulas, &ports, &states, (&parameters, seen), symbol)));
    let card = Card {
        kind: kept(kind),
        meaning: kept(meaning),
        law: kept(&law),
        source: kept(source),
        validity: kept(validity),
        sees_time,
        sees_viscosity: names_it(VISCOSITY),
        own: Some(own),
        states: kept_list(states.iter().map(StateLine::card).collect()),
        parameters: kept_list(parameters),
        ports: kept_list(ports),
        inputs: kept_list(inputs),
        ..Card::EMPTY
    };
    let card: &'static Card = Box::leak(Box::new(card));
    let card = Box::leak(Box::new(Card { worked: worked::read(card, numbers)?, ..*card }));
    let effects = effects::effects(card, &of_effects)?;
    Ok(OwnKind { card, own, places, initial, files, effects, place: value.place() })
}

/// The laws as text, one line each.
fn law(lines: &Lines<'_>, states: &[StateLine<'_>]) -> Result<String, Complaint> {
    let mut law = Vec::new();
    for (name, value) in &lines.quantities {
        law.push(format!("{name} = {}", value.text()?));
    }
    for state in states {
        let text = state.change.formula().text()?;
        law.push(match &state.change {
            Change::Rate(_) => format!("{}' = {text}", state.name),
            Change::Follows(_, lag) => format!("{lag} {0}' = {text} - {0}", state.name),
        });
    }
    law.extend(lines.at_ports_as_text()?);
    Ok(law.join("\n"))
}

fn assemble(
    formulas: &Formulas,
    ports: &[Port],
    states: &[StateLine<'_>],
    (parameters, seen): (&[Parameter], usize),
    symbol: crate::physics::component::facts::Symbol,
) -> Own {
    let plain = |list: &[formulas::Written]| list.iter().map(|(expression, _)| expression.clone()).collect();
    let at = |list: &[(usize, formulas::Written)]| {
        list.iter().map(|(port, (expression, _))| (*port, expression.clone())).collect()
    };
    let settles = states.iter().all(|state| matches!(state.change, Change::Follows(..)));
    let mut own = Own {
        facts: facts::of(formulas, ports, parameters, symbol, settles),
        settles,
        fixed: plain(&formulas.fixed),
        moving: plain(&formulas.moving),
        flows: formulas.flows(),
        forces: at(&formulas.forces),
        pistons: formulas.pistons(ports),
        volumes: at(&formulas.volumes),
        masses: at(&formulas.masses),
        rates: plain(&formulas.rates),
        schedule: Schedule::default(),
    };
    own.schedule = own.scheduled(parameters.len(), seen);
    own
}

/// Every name of a line is a word, and none names two things.
fn check_all_words(table: &Table<'_>, lines: &Lines<'_>) -> Result<(), Complaint> {
    let mut words = Vec::new();
    for key in ["ports", "parameters", "states", "inputs", "tables"] {
        if let Some(value) = table.get(key) {
            words.extend(value.table(key)?.entries());
        }
    }
    let words = words.iter().chain(&lines.quantities);
    check_words(words.map(|(name, value)| (*name, value)))
}

/// Whether all that is declared is used: what no formula names, no record could determine.
struct Used<'a> {
    formulas: &'a Formulas,
    names: &'a Names,
    lines: &'a Lines<'a>,
    table: &'a Table<'a>,
}

impl Used<'_> {
    fn unused(&self, key: &str, name: &str, help: &str) -> Result<(), Complaint> {
        let line = self.table.get(key).and_then(|value| value.table(key).ok()?.get(name));
        let place = line.map_or_else(|| self.table.place(), |line| line.place());
        Err(Complaint::new(Kind::Contradiction, format!("no formula of {} uses `{name}`", self.table.what))
            .at(place)
            .help(help))
    }

    fn parameters(&self, parameters: &[Parameter]) -> Result<(), Complaint> {
        let unused = parameters.iter().enumerate().find(|(index, _)| !self.formulas.uses(*index, None));
        unused.map_or(Ok(()), |(_, own)| {
            self.unused("parameters", own.name, "use it, or leave it out: no record could say what it is")
        })
    }

    fn ports(&self, ports: &[Port]) -> Result<(), Complaint> {
        let mut first = self.names.constants();
        for (index, port) in ports.iter().enumerate() {
            let mut variables = first..first + port.kind.variables();
            first = variables.end;
            if !self.lines.meets(index) && !variables.any(|variable| self.formulas.uses(variable, None)) {
                return self.unused(
                    "ports",
                    port.name,
                    "let oil pass there, let a formula see its pressure, or leave it out",
                );
            }
        }
        Ok(())
    }

    fn states(&self, states: &[StateLine<'_>]) -> Result<(), Complaint> {
        let first = self.names.constants() + self.names.variables;
        let unused = states.iter().enumerate().find(|(index, _)| !self.formulas.uses(first + index, Some(*index)));
        unused.map_or(Ok(()), |(_, state)| {
            self.unused("states", state.name, "let a flow, a force or another formula depend on it, or leave it out")
        })
    }

    fn inputs(&self, inputs: &[Input]) -> Result<(), Complaint> {
        let first = self.names.constants() + self.names.variables + self.names.states;
        let unused = inputs.iter().enumerate().find(|(index, _)| !self.formulas.uses(first + index, None));
        unused.map_or(Ok(()), |(_, input)| self.unused("inputs", input.name, "use it, or leave it out"))
    }

    fn quantities(&self) -> Result<(), Complaint> {
        let all = self.names.all();
        let used = |name: &str| {
            let index = all.iter().position(|one| one.name == name);
            index.is_some_and(|index| self.formulas.uses(index, None))
        };
        let unused = self.lines.quantities.iter().find(|(name, _)| !used(name));
        unused.map_or(Ok(()), |(name, _)| self.unused("quantities", name, "use it, or leave it out"))
    }
}

impl<'a> Change<'a> {
    /// What is written.
    fn formula(&self) -> &Value<'a> {
        match self {
            Self::Rate(value) | Self::Follows(value, _) => value,
        }
    }
}

impl StateLine<'_> {
    fn card(&self) -> State {
        State {
            name: kept(self.name),
            unit: kept(&self.unit.symbol),
            initial: self.initial.unwrap_or(0.0),
            scale: self.scale,
            meaning: self.meaning,
        }
    }
}
