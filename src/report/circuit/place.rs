//! Where everything of a circuit stands.
//!
//! Nodes are horizontal lines, one level for each component that the fluid has passed since its source; components stand
//! upright between them, what leads to the tank hangs below its node, cylinders lie on top. What a directional valve feeds by
//! port A is kept left, by port B right. Open vessels turn the picture over: there the fluid falls.

use std::collections::{BTreeMap, VecDeque};

use super::symbol::{self, Symbol};
use crate::physics::card::PortKind;
use crate::rig::{NodeKind, Rig};

/// Height of a level and width of a column, px.
const LEVEL: f64 = 120.0;
const COLUMN: f64 = 150.0;
/// Width of a letter of a name, and what stands between a name and the next symbol, px.
const LETTER: f64 = 7.2;
const BESIDE: f64 = 60.0;
/// What stands between a symbol and its name, and between a name and the next symbol, px.
const NAME: f64 = 12.0;
const GAP: f64 = 14.0;
/// Distance of cylinders.
const APART: f64 = 380.0;
/// How far nodes of one level keep apart.
const ASIDE: f64 = 12.0;

/// A component in its place.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub component: usize,
    pub symbol: Symbol,
    pub x: f64,
    pub y: f64,
    /// Upside down: the fluid flows downwards.
    pub turned: bool,
    /// End of each hydraulic port: port, node, x, y.
    pub ends: Vec<(usize, usize, f64, f64)>,
}

/// A circuit laid out.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub placed: Vec<Placed>,
    /// Height of each hydraulic node that is drawn as a line.
    pub lines: BTreeMap<usize, f64>,
}

struct Plan<'a> {
    rig: &'a Rig,
    levels: BTreeMap<usize, usize>,
    sides: BTreeMap<usize, i32>,
    /// Level 1 stands on top.
    falls: bool,
}

/// The hydraulic ports of a component: port and node.
fn hydraulic(rig: &Rig, component: usize) -> Vec<(usize, usize)> {
    let component = &rig.components[component];
    let ports = component.card.ports.iter().zip(&component.ports).enumerate();
    ports.filter(|(_, (port, _))| port.kind == PortKind::Hydraulic).map(|(index, (_, node))| (index, *node)).collect()
}

/// Lays a circuit out; what stands beside each component has so many letters.
pub(super) fn layout(rig: &Rig, letters: &dyn Fn(usize) -> usize) -> Layout {
    let plan = Plan::new(rig);
    let lines = plan.lines();
    let mut placed: Vec<Placed> = Vec::new();
    // Row and side of each component that is drawn.
    let mut rows: BTreeMap<(usize, i32), Vec<usize>> = BTreeMap::new();
    for (component, _) in rig.parts() {
        if let Some(place) = plan.place(component) {
            rows.entry(place).or_default().push(component);
        }
    }
    let numbers: Vec<usize> = rows.keys().map(|(row, _)| *row).collect();
    for row in numbers.into_iter().collect::<std::collections::BTreeSet<_>>() {
        let of = |side: i32| rows.get(&(row, side)).cloned().unwrap_or_default();
        let (spine, right, left) = (of(0), of(1), of(-1));
        let y = plan.row(row);
        let first = spine.first().or(left.first()).map_or(COLUMN, |&first| {
            let component = &rig.components[first];
            let name = LETTER * letters(first) as f64;
            symbol::of(component.card).half_width().max(25.0) + (name + BESIDE).max(COLUMN - 25.0)
        });
        let lying = spine.iter().all(|&one| symbol::of(rig.components[one].card) == Symbol::Cylinder);
        // A name stands to the right of its symbol, so a long one takes more than a column.
        let step = |from: usize, to: usize| {
            let (from_symbol, to_symbol) = (symbol::of(rig.components[from].card), symbol::of(rig.components[to].card));
            let name = LETTER * letters(from) as f64;
            (from_symbol.half_width() + NAME + name + GAP + to_symbol.left()).max(COLUMN)
        };
        let mut x = 0.0;
        for (number, &component) in spine.iter().enumerate() {
            x = match number {
                _ if lying => APART * number as f64,
                0 => 0.0,
                1 => first.max(step(spine[0], component)),
                _ => x + step(spine[number - 1], component),
            };
            placed.push(plan.placed(component, x, y));
        }
        let mut before = spine.last().copied();
        let mut x = if spine.len() > 1 { x } else { 0.0 };
        for (number, &component) in right.iter().enumerate() {
            x = match before {
                _ if number == 0 && lying => first,
                Some(before) if number > 0 || spine.len() > 1 => x + step(before, component),
                Some(before) => first.max(step(before, component)),
                None => first,
            };
            before = Some(component);
            placed.push(plan.placed(component, x, y));
        }
        let mut x = 0.0;
        for (number, &component) in left.iter().enumerate() {
            x = match number {
                0 => -spine.first().map_or(first, |&spine| first.max(step(component, spine))),
                _ => x - step(component, left[number - 1]),
            };
            placed.push(plan.placed(component, x, y));
        }
    }
    let lines = plan.apart(&placed, lines);
    Layout { placed, lines }
}

impl<'a> Plan<'a> {
    fn new(rig: &'a Rig) -> Self {
        let falls = rig.components.iter().any(|one| symbol::of(one.card) == Symbol::Vessel)
            && !rig.components.iter().any(|one| symbol::of(one.card) == Symbol::Cylinder);
        let mut plan = Self { rig, levels: BTreeMap::new(), sides: BTreeMap::new(), falls };
        let mut queue = VecDeque::new();
        for (component, part) in rig.parts() {
            if symbol::of(part.card).is_source() {
                let outlets =
                    hydraulic(rig, component).into_iter().map(|(_, node)| node).filter(|&node| plan.is_line(node));
                queue.extend(outlets.map(|node| (node, 1, 0)));
            }
        }
        plan.spread(queue);
        // What no source feeds.
        for node in 0..rig.nodes.len() {
            if plan.is_line(node) && !plan.levels.contains_key(&node) {
                plan.spread(VecDeque::from([(node, 1, 0)]));
            }
        }
        plan
    }

    /// Counts the components that the fluid passes.
    fn spread(&mut self, mut queue: VecDeque<(usize, usize, i32)>) {
        while let Some((node, level, side)) = queue.pop_front() {
            if self.levels.contains_key(&node) {
                continue;
            }
            self.levels.insert(node, level);
            self.sides.insert(node, side);
            for (index, component) in self.rig.parts() {
                let kind = symbol::of(component.card);
                let ports = hydraulic(self.rig, index);
                if kind == Symbol::Cylinder || !kind.has_place() || ports.iter().all(|(_, other)| *other != node) {
                    continue;
                }
                for &(port, other) in ports.iter().filter(|(_, other)| *other != node && self.is_line(*other)) {
                    let side = match (kind, component.card.ports[port].name) {
                        (Symbol::DirectionalValve, "A") => -1,
                        (Symbol::DirectionalValve, "B") => 1,
                        _ => side,
                    };
                    queue.push_back((other, level + 1, side));
                }
            }
        }
    }

    /// Whether a node is drawn as a line; what leads to a node of constant pressure gets a tank of its own.
    fn is_line(&self, node: usize) -> bool {
        matches!(self.rig.nodes[node].kind, NodeKind::Volume { .. })
    }

    fn most(&self) -> usize {
        self.levels.values().copied().max().unwrap_or(1)
    }

    /// Height of a level.
    fn level(&self, level: usize) -> f64 {
        if self.falls { level as f64 * LEVEL } else { (self.most() as f64 - level as f64) * LEVEL }
    }

    /// Middle of the row behind a level, as the fluid goes.
    fn row(&self, row: usize) -> f64 {
        self.level(row) + if self.falls { 0.5 * LEVEL } else { -0.5 * LEVEL }
    }

    fn lines(&self) -> BTreeMap<usize, f64> {
        let mut lines: BTreeMap<usize, f64> = BTreeMap::new();
        for (&node, &level) in &self.levels {
            let alike = lines
                .keys()
                .filter(|other| self.levels[other] == level && self.sides[other] == self.sides[&node])
                .count();
            lines.insert(node, self.level(level) + ASIDE * alike as f64);
        }
        lines
    }

    /// Heights at which no two lines of a level lie upon another, once it is known how far each reaches.
    fn apart(&self, placed: &[Placed], mut lines: BTreeMap<usize, f64>) -> BTreeMap<usize, f64> {
        let reach = |node: usize| {
            let ends = placed.iter().flat_map(|one| &one.ends).filter(|end| end.1 == node).map(|end| end.2);
            ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let mut taken: Vec<(f64, (f64, f64))> = Vec::new();
        for (&node, height) in &mut lines {
            let own = reach(node);
            let meets = |height: f64, taken: &[(f64, (f64, f64))]| {
                taken.iter().any(|(other, ends)| {
                    (other - height).abs() < 0.5 * ASIDE && ends.0 <= own.1 + 1.0 && own.0 <= ends.1 + 1.0
                })
            };
            while meets(*height, &taken) {
                *height += ASIDE;
            }
            taken.push((*height, own));
        }
        lines
    }

    /// Row and side of a component; `None` of what is not drawn on its own.
    fn place(&self, component: usize) -> Option<(usize, i32)> {
        let symbol = symbol::of(self.rig.components[component].card);
        let ports = hydraulic(self.rig, component);
        let mut at: Vec<(usize, i32)> =
            ports.iter().filter_map(|(_, node)| Some((*self.levels.get(node)?, self.sides[node]))).collect();
        at.sort_unstable_by_key(|(level, _)| *level);
        let (&(low, side), &(high, far)) = (at.first()?, at.last()?);
        match symbol {
            Symbol::Hidden | Symbol::Force => None,
            Symbol::Cylinder => Some((self.most(), 0)),
            Symbol::Vessel => Some((if self.falls { low - 1 } else { low }, 1)),
            Symbol::DirectionalValve => Some((low, 0)),
            _ if symbol.is_source() => Some(if self.falls { (low, -1) } else { (low - 1, 0) }),
            _ if at.len() == 1 => Some((if self.falls { low } else { low - 1 }, side)),
            _ if low == high => Some((low, side)),
            _ => Some((low, if far == 0 { side } else { far })),
        }
    }

    fn placed(&self, component: usize, x: f64, y: f64) -> Placed {
        let symbol = symbol::of(self.rig.components[component].card);
        let ports = hydraulic(self.rig, component);
        let lines = self.lines();
        // Nodes of constant pressure lie below everything.
        let height = |node: usize| lines.get(&node).copied().unwrap_or(f64::INFINITY);
        let places = symbol.ends();
        let turned = match ports.as_slice() {
            [(_, inlet), (_, outlet), ..] if symbol.turns() => height(*inlet) < height(*outlet),
            [(_, only)] if symbol.turns() => height(*only) < y,
            _ => false,
        };
        let sign = if turned { -1.0 } else { 1.0 };
        let end = |(index, &(port, node)): (usize, &(usize, usize))| {
            let (dx, dy) = places.get(index).copied().unwrap_or((0.0, 0.0));
            (port, node, x + sign * dx, y + sign * dy)
        };
        Placed { component, symbol, x, y, turned, ends: ports.iter().enumerate().map(end).collect() }
    }
}
