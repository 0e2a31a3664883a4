//! The formulas of a component: read, their dimensions checked, all that they name used.

use super::lines::{Change, StateLine};
use super::names::Names;
use crate::complaint::{Complaint, Kind, Place, help_with_names};
use crate::expression::Expression;
use crate::physics::card::{Port, PortKind};
use crate::physics::own::{Flow, MOST_SIZE, Piston};
use crate::rig::parse::own_effect::words;
use crate::rig::source::{Table, Value};
use crate::units::Dimension;

/// A formula and the place where it is written.
pub(super) type Written = (Expression, Place);

/// A line with a formula: flow, force, piston, volume or mass.
pub(super) struct Line<'a> {
    /// The ports that it names, in the order of its keys.
    ports: Vec<usize>,
    /// What it says, such as `flow A to B`.
    label: String,
    formula: Value<'a>,
}

/// All lines of a component.
pub(super) struct Lines<'a> {
    pub quantities: Vec<(&'a str, Value<'a>)>,
    pub flows: Vec<Line<'a>>,
    pub forces: Vec<Line<'a>>,
    pub pistons: Vec<Line<'a>>,
    pub volumes: Vec<Line<'a>>,
    pub masses: Vec<Line<'a>>,
}

/// What a line of one key looks like.
struct Shape {
    key: &'static str,
    /// The keys of its ports, with what has to meet there.
    ports: &'static [(&'static str, PortKind)],
    /// The key of its formula.
    formula: &'static str,
    example: &'static str,
}

const FLOW: Shape = Shape {
    key: "flow",
    ports: &[("from", PortKind::Hydraulic), ("to", PortKind::Hydraulic)],
    formula: "formula",
    example: "flow = { from = \"A\", to = \"B\", formula = \"G * (A.p - B.p)\" }",
};
const FORCE: Shape = Shape {
    key: "force",
    ports: &[("on", PortKind::Mechanical)],
    formula: "formula",
    example: "force = { on = \"rod\", formula = \"-k * rod.x\" }",
};
const PISTON: Shape = Shape {
    key: "piston",
    ports: &[("at", PortKind::Hydraulic), ("on", PortKind::Mechanical)],
    formula: "area",
    example: "piston = { at = \"A\", on = \"rod\", area = \"area_A\" }",
};
const VOLUME: Shape = Shape {
    key: "volume",
    ports: &[("at", PortKind::Hydraulic)],
    formula: "formula",
    example: "volume = { at = \"A\", formula = \"V_0\" }",
};
const MASS: Shape = Shape {
    key: "mass",
    ports: &[("on", PortKind::Mechanical)],
    formula: "formula",
    example: "mass = { on = \"rod\", formula = \"m\" }",
};

impl<'a> Lines<'a> {
    pub fn read(table: &Table<'a>, ports: &[Port]) -> Result<Self, Complaint> {
        let quantities = match table.get("quantities") {
            None => Vec::new(),
            Some(value) => value.table(format!("`quantities` of {}", table.what))?.named_entries()?,
        };
        let read = |shape| lines(table, ports, shape);
        let lines = Self {
            quantities,
            flows: read(&FLOW)?,
            forces: read(&FORCE)?,
            pistons: read(&PISTON)?,
            volumes: read(&VOLUME)?,
            masses: read(&MASS)?,
        };
        if lines.at_ports().next().is_none() {
            let what = format!("{} does nothing: it has no flow, force, piston, volume or mass", table.what);
            let help = format!("add what passes between its ports, such as `{}`", FLOW.example);
            return Err(Complaint::new(Kind::MissingEntry, what).at(table.place()).help(help));
        }
        Ok(lines)
    }

    fn at_ports(&self) -> impl Iterator<Item = &Line<'a>> {
        let forces = self.flows.iter().chain(&self.forces).chain(&self.pistons);
        forces.chain(&self.volumes).chain(&self.masses)
    }

    /// The texts of all formulas but those of the states.
    pub fn texts(&self) -> impl Iterator<Item = &Value<'a>> {
        self.quantities.iter().map(|(_, value)| value).chain(self.at_ports().map(|line| &line.formula))
    }

    /// The lines as text: `flow A to B: G * (A.p - B.p)`.
    pub fn at_ports_as_text(&self) -> Result<Vec<String>, Complaint> {
        let text = |line: &Line<'_>| Ok(format!("{}: {}", line.label, line.formula.text()?));
        self.at_ports().map(text).collect()
    }

    /// Whether a line names a port.
    pub fn meets(&self, port: usize) -> bool {
        self.at_ports().any(|line| line.ports.contains(&port))
    }
}

fn lines<'a>(table: &Table<'a>, ports: &[Port], shape: &Shape) -> Result<Vec<Line<'a>>, Complaint> {
    let Some(value) = table.get(shape.key) else { return Ok(Vec::new()) };
    value.one_or_more()?.iter().map(|value| line(value, ports, shape)).collect()
}

fn line<'a>(value: &Value<'a>, ports: &[Port], shape: &Shape) -> Result<Line<'a>, Complaint> {
    let table = value.table(format!("a `{}`", shape.key))?;
    let formula = table.require(shape.formula, &format!("write `{}`", shape.example))?;
    let mut found = Vec::new();
    for &(key, kind) in shape.ports {
        let help = match (shape.key, key) {
            ("flow", _) => {
                "what leaves one port enters another, so that no oil is made or lost: write `from` and `to`; of a leak to the outside, \
                 add a port that meets the tank; of oil that follows a body, write a `piston`"
            }
            _ => &format!("write `{}`", shape.example),
        };
        found.push(port(&table.require(key, help)?, ports, kind)?);
    }
    if let [from, to] = found.as_slice()
        && from == to
    {
        let what = format!("a `{}` from port `{}` to itself", shape.key, ports[*from].name);
        return Err(Complaint::new(Kind::Contradiction, what)
            .at(value.place())
            .help("name the two ports between which it passes"));
    }
    table.finish()?;
    let label = match found.as_slice() {
        [from, to] => format!("{} {} to {}", shape.key, ports[*from].name, ports[*to].name),
        others => others.iter().map(|&at| format!("{} at {}", shape.key, ports[at].name)).collect(),
    };
    Ok(Line { ports: found, label, formula })
}

/// The port that a line names.
fn port(value: &Value<'_>, ports: &[Port], kind: PortKind) -> Result<usize, Complaint> {
    let name = value.text()?;
    let fitting = || ports.iter().filter(|port| port.kind == kind).map(|port| port.name);
    let Some(index) = ports.iter().position(|port| port.name == name) else {
        return Err(Complaint::new(Kind::UnknownName, format!("{} is `{name}`, which is no port", value.what))
            .at(value.place())
            .help(help_with_names(name, "ports for it", fitting())));
    };
    if ports[index].kind != kind {
        let (found, wanted) = match kind {
            PortKind::Hydraulic => ("a body", "oil passes: take a hydraulic port"),
            PortKind::Mechanical => ("oil", "a body is pushed: take a port where one meets"),
        };
        return Err(Complaint::new(Kind::Contradiction, format!("at port `{name}` meets {found}"))
            .at(value.place())
            .help(format!("here {wanted}")));
    }
    Ok(index)
}

/// The formulas of a component.
pub(super) struct Formulas {
    pub fixed: Vec<Written>,
    pub moving: Vec<Written>,
    pub flows: Vec<(usize, usize, Written)>,
    pub forces: Vec<(usize, Written)>,
    pub pistons: Vec<(usize, usize, Written)>,
    pub volumes: Vec<(usize, Written)>,
    pub masses: Vec<(usize, Written)>,
    pub rates: Vec<Written>,
}

impl Formulas {
    /// Reads every formula; `names` get the quantities.
    pub fn read(lines: &Lines<'_>, states: &[StateLine<'_>], names: &mut Names) -> Result<Self, Complaint> {
        let (fixed, moving) = quantities(&lines.quantities, names)?;
        let all = &*names;
        let one = |line: &Line<'_>, dimension| parse(&line.formula, all, dimension).map(|read| (line.ports[0], read));
        let two = |line: &Line<'_>, dimension| {
            parse(&line.formula, all, dimension).map(|read| (line.ports[0], line.ports[1], read))
        };
        let area = Dimension::LENGTH.power(2);
        let volume = Dimension::LENGTH.power(3);

        let each_two = |lines: &[Line<'_>], dimension| -> Result<Vec<_>, Complaint> {
            lines.iter().map(|line| two(line, dimension)).collect()
        };
        let each_one = |lines: &[Line<'_>], dimension| -> Result<Vec<_>, Complaint> {
            lines.iter().map(|line| one(line, dimension)).collect()
        };
        Ok(Self {
            fixed,
            moving,
            flows: each_two(&lines.flows, Dimension::FLOW)?,
            forces: each_one(&lines.forces, Dimension::FORCE)?,
            pistons: each_two(&lines.pistons, area)?,
            volumes: each_one(&lines.volumes, volume)?,
            masses: each_one(&lines.masses, Dimension::MASS)?,
            rates: states.iter().map(|state| rate(state, all)).collect::<Result<_, Complaint>>()?,
        })
    }

    /// Every formula, in the order of [`Own::formulas`](crate::physics::own::Own::formulas).
    pub fn written(&self) -> impl Iterator<Item = &Written> {
        fn of_two((_, _, written): &(usize, usize, Written)) -> &Written {
            written
        }
        fn of_one((_, written): &(usize, Written)) -> &Written {
            written
        }
        let flows = self.flows.iter().map(of_two).chain(self.forces.iter().map(of_one));
        let stored = self.pistons.iter().map(of_two).chain(self.volumes.iter().chain(&self.masses).map(of_one));
        self.fixed.iter().chain(&self.moving).chain(flows).chain(stored).chain(&self.rates)
    }

    /// Whether any formula, but for the rate of state `beside`, uses the value with this index.
    pub fn uses(&self, index: usize, beside: Option<usize>) -> bool {
        let own = beside.and_then(|state| self.rates.get(state)).map(|(expression, _)| expression);
        let others = self.written().map(|(expression, _)| expression);
        let mut others = others.filter(|one| own.is_none_or(|own| !std::ptr::eq(*one, own)));
        others.any(|one| index < one.names().len() && one.uses(index))
    }

    /// That one evaluation costs no more than it may.
    pub fn check_size(&self, table: &Table<'_>) -> Result<(), Complaint> {
        let size: usize = self.written().map(|(expression, _)| expression.size()).sum();
        if size <= MOST_SIZE {
            return Ok(());
        }
        let what = format!("the formulas of {} have {size} numbers, names and operators together", table.what);
        Err(Complaint::new(Kind::Bounds, what)
            .at(table.place())
            .help(format!("no more than {MOST_SIZE}: write what is used twice as a quantity")))
    }

    pub fn flows(&self) -> Vec<Flow> {
        let flow = |(from, to, (formula, _)): &(usize, usize, Written)| Flow {
            from: *from,
            to: *to,
            formula: formula.clone(),
        };
        self.flows.iter().map(flow).collect()
    }

    pub fn pistons(&self, ports: &[Port]) -> Vec<Piston> {
        let before = |port: usize| ports[..port].iter().map(|port| port.kind.variables()).sum::<usize>();
        let piston = |(port, body, (area, _)): &(usize, usize, Written)| Piston {
            port: *port,
            body: *body,
            // Behind the position.
            speed: before(*body) + 1,
            area: area.clone(),
        };
        self.pistons.iter().map(piston).collect()
    }
}

/// The quantities that formulas share: those that do not change, and those that do.
fn quantities(lines: &[(&str, Value<'_>)], names: &mut Names) -> Result<(Vec<Written>, Vec<Written>), Complaint> {
    let (mut fixed, mut moving, mut later) = (Vec::new(), Vec::new(), Vec::new());
    for (name, value) in lines {
        match names.fixed(value.text()?) {
            None => later.push((name, value)),
            Some(expression) => {
                names.add(name, expression.dimension(), true, value)?;
                fixed.push((expression, value.place()));
            }
        }
    }
    for (name, value) in later {
        let text = value.text()?;
        let ahead = |word: &str| !names.has(word) && lines.iter().any(|(other, _)| *other == word);
        if let Some(word) = words(text).find(|word| ahead(word)) {
            let what = format!("`{name}` builds on `{word}`, which is not known there");
            let help = if word == *name {
                "a quantity cannot build on itself: write a state"
            } else {
                "write the other one before"
            };
            return Err(Complaint::new(Kind::Order, what).at(value.place()).help(help));
        }
        let expression = names.parse(text).map_err(|error| wrong(value, &error))?;
        names.add(name, expression.dimension(), false, value)?;
        moving.push((expression, value.place()));
    }
    Ok((fixed, moving))
}

/// The rate of a state.
fn rate(state: &StateLine<'_>, names: &Names) -> Result<Written, Complaint> {
    let dimension = state.unit.dimension;
    match &state.change {
        Change::Rate(value) => parse(value, names, dimension.per(Dimension::TIME)),
        Change::Follows(value, lag) => {
            let text = value.text()?;
            if words(text).any(|word| word == state.name) {
                let what = format!("`{}` cannot follow itself", state.name);
                return Err(Complaint::new(Kind::Contradiction, what)
                    .at(value.place())
                    .help("write the whole law as `rate = \"...\"`"));
            }
            parse(value, names, dimension)?;
            let whole = format!("(({text}) - {}) / {lag}", state.name);
            let expression = names.parse(&whole).map_err(|error| wrong(value, &error))?;
            Ok((expression, value.place()))
        }
    }
}

fn parse(value: &Value<'_>, names: &Names, dimension: Dimension) -> Result<Written, Complaint> {
    let text = value.text()?;
    let read = names.parse(text).and_then(|expression| expression.check(text, dimension));
    let expression = read.map_err(|error| wrong(value, &error))?;
    Ok((expression, value.place()))
}

fn wrong(value: &Value<'_>, error: &crate::expression::ExpressionError) -> Complaint {
    Complaint::new(Kind::Syntax, format!("{}: {error}", value.what))
        .at(value.place_in_text(error.offset))
        .help(error.help.clone())
}
