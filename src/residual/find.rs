//! Finds the residual generators of a rig: every component whose needed quantities are measured.

use std::borrow::Cow;

use super::balance::Balance;
use super::form::{Edge, Form};
use super::generator::{Generator, Variant};
use super::reading::Readings;
use super::view::View;
use crate::physics::card::PortKind;
use crate::physics::component::facts;
use crate::physics::component::facts::{Residuals, Spring, Throttle};
use crate::rig::{Quantity, Rig};
use crate::units::Unit;

/// Every residual generator that the sensors of a rig allow, the corrected form before the printed one.
///
/// A component without the sensors that a residual needs is passed over; so is one whose neighbours hide a flow.
pub fn generators(rig: &Rig) -> Vec<Generator> {
    let mut found = Vec::new();
    for (index, component) in rig.parts() {
        match facts(component.card).residuals {
            Residuals::Cylinder { bore, rod, .. } => cylinder(rig, index, [bore, rod], &mut found),
            Residuals::FlowControl { orifice, spring } => flow_control(rig, index, (orifice, spring), &mut found),
            Residuals::Through => {
                let meaning = "flow of the healthy part at the measured pressures minus the actual flow";
                through(rig, index, Label::new("flow", "-", meaning), &mut found);
            }
            Residuals::EachPort => each_port(rig, index, &mut found),
            Residuals::Directional { opening, rated_flow, rated_drop } => {
                directional(rig, index, [opening, rated_flow, rated_drop], &mut found);
            }
            Residuals::Pump => pump(rig, index, &mut found),
            // The pump that it guards brings its residual.
            Residuals::Relief { .. } | Residuals::None => {}
        }
    }
    found
}

/// What a residual is called and what it says.
struct Label {
    name: Cow<'static, str>,
    equation: &'static str,
    variant: Variant,
    unit: &'static str,
    meaning: &'static str,
}

impl Label {
    const fn new(name: &'static str, equation: &'static str, meaning: &'static str) -> Self {
        Self { name: Cow::Borrowed(name), equation, variant: Variant::Corrected, unit: "L/min", meaning }
    }
    const fn printed(mut self) -> Self {
        self.variant = Variant::Paper;
        self
    }
}

/// Adds a generator if `build` finds what it needs.
fn add(
    rig: &Rig,
    component: usize,
    label: Label,
    found: &mut Vec<Generator>,
    build: impl FnOnce(&mut Readings) -> Option<Form>,
) {
    let mut readings = Readings::default();
    if let Some(form) = build(&mut readings) {
        found.push(Generator {
            id: format!("{}.{}", rig.components[component].name, label.name),
            equation: label.equation,
            variant: label.variant,
            unit: Unit::parse(label.unit).unwrap_or_else(|_| Unit::dimensionless()),
            meaning: label.meaning,
            readings: readings.0,
            form,
        });
    }
}

fn cylinder(rig: &Rig, index: usize, diameters: [usize; 2], found: &mut Vec<Generator>) {
    for printed in [false, true] {
        let label = Label::new("leakage", "(4)", "flow from the cap side past the piston to the rod side");
        add(rig, index, if printed { label.printed() } else { label }, found, |readings| {
            Some(Form::CylinderLeakage {
                view: View::of(rig, index, readings)?,
                a: Balance::into_port(rig, index, 0, readings)?,
                b: Balance::into_port(rig, index, 1, readings)?,
                diameters,
                printed,
            })
        });
    }
    let sides = [
        (0, -1.0, Label::new("flow_A", "(1)", "q1 - A1 v: what enters the cap side and does not move the piston")),
        (1, 1.0, Label::new("flow_B", "(1)", "q2 - A2 v: what leaves the rod side and the piston did not push")),
    ];
    for (port, sign, label) in sides {
        add(rig, index, label, found, |readings| {
            let laws = vec![(View::of(rig, index, readings)?, port)];
            Some(Form::Through { laws, flow: Balance::into_port(rig, index, port, readings)?, sign })
        });
    }
    let label =
        Label { unit: "N", ..Label::new("force", "-", "sum of forces on the piston minus mass times acceleration") };
    add(rig, index, label, found, |readings| {
        let body = rig.components[index].ports[2];
        let mut laws = Vec::new();
        for (other, component) in rig.parts() {
            for (port, _) in component.ports.iter().enumerate().filter(|(_, node)| **node == body) {
                if component.card.ports[port].kind == PortKind::Mechanical {
                    laws.push((View::of(rig, other, readings)?, port));
                }
            }
        }
        Some(Form::Force { laws, acceleration: readings.node(rig, body, Quantity::Position, 2)? })
    });
}

/// What the law of a component with two ports lets through, against what passes.
fn through(rig: &Rig, index: usize, label: Label, found: &mut Vec<Generator>) {
    add(rig, index, label, found, |readings| {
        let view = View::of(rig, index, readings)?;
        // What enters leaves again, so either side will do: a flow that owes nothing to another law is the better witness.
        let mut sides = [(1, -1.0), (0, 1.0)].into_iter().filter_map(|(port, sign)| {
            let mut own = readings.clone();
            Balance::into_port(rig, index, port, &mut own).map(|flow| (port, sign, flow, own))
        });
        let first = sides.next()?;
        let better = if first.2.has_law() { sides.find(|(_, _, flow, _)| !flow.has_law()) } else { None };
        drop(sides);
        let (port, sign, flow, own) = better.unwrap_or(first);
        *readings = own;
        Some(Form::Through { laws: vec![(view, port)], flow, sign })
    });
}

/// What the law of a component lets into each of its ports, against what enters there.
fn each_port(rig: &Rig, index: usize, found: &mut Vec<Generator>) {
    let card = rig.components[index].card;
    for (port, name) in card.ports.iter().enumerate().map(|(port, card)| (port, card.name)) {
        if card.ports[port].kind != PortKind::Hydraulic || card.own.is_some_and(|own| !own.passes(port)) {
            continue;
        }
        let meaning = "flow of the healthy part into the port at the measured pressures minus the actual flow";
        let label = Label { name: Cow::Owned(format!("flow_{name}")), ..Label::new("flow", "-", meaning) };
        add(rig, index, label, found, |readings| {
            let view = View::of(rig, index, readings)?;
            let flow = Balance::into_port(rig, index, port, readings)?;
            Some(Form::Through { laws: vec![(view, port)], flow, sign: 1.0 })
        });
    }
}

fn flow_control(rig: &Rig, index: usize, (orifice, spring): (Throttle, Spring), found: &mut Vec<Generator>) {
    let meaning = "flow of the healthy valve at the measured pressures minus the actual flow";
    through(rig, index, Label::new("flow", "(10)", meaning), found);
    let meaning = "flow of the regulating valve, whatever the pressures, minus the actual flow";
    add(rig, index, Label::new("flow", "(10)", meaning).printed(), found, |readings| {
        let view = View::of(rig, index, readings)?;
        let flow = Balance::into_port(rig, index, 1, readings)?;
        Some(Form::ConstantFlow { view, flow, orifice, spring })
    });
}

fn directional(rig: &Rig, index: usize, rated: [usize; 3], found: &mut Vec<Generator>) {
    const EDGES: [(Edge, &str, &str, &str); 4] = [
        (Edge::Leakage, "leakage", "(16)", "flow into P that does not come out of the consumer port"),
        (Edge::Consumer, "consumer", "(18)", "healthy flow of the pressure edge minus the flow to the consumer"),
        (Edge::Supply, "supply", "(20)", "healthy flow of the pressure edge minus the flow into P"),
        (Edge::Return, "return", "(14)", "healthy flow of the return edge minus the flow that comes back"),
    ];
    for (edge, name, equation, meaning) in EDGES {
        for printed in [false, true] {
            let label = Label::new(name, equation, meaning);
            add(rig, index, if printed { label.printed() } else { label }, found, |readings| {
                let view = View::of(rig, index, readings)?;
                let supply = matches!(edge, Edge::Leakage | Edge::Supply);
                let consumer = edge != Edge::Supply;
                let mut flow =
                    |port, wanted| if wanted { Balance::into_port(rig, index, port, readings) } else { None };
                let flows = [flow(0, supply), None, flow(2, consumer), flow(3, consumer)];
                let known = (!supply || flows[0].is_some()) && (!consumer || flows[2].is_some() || flows[3].is_some());
                known.then_some(Form::Valve { view, flows, edge, printed: printed.then_some(rated) })
            });
        }
    }
}

fn pump(rig: &Rig, index: usize, found: &mut Vec<Generator>) {
    let node = rig.components[index].ports[0];
    let of_kind = |is_one: fn(Residuals) -> bool| {
        let all = rig.parts();
        all.filter(move |(_, component)| is_one(facts(component.card).residuals) && component.ports[0] == node)
            .map(|(other, _)| other)
            .collect::<Vec<usize>>()
    };
    let pumps = of_kind(|residuals| residuals == Residuals::Pump);
    let reliefs = of_kind(|residuals| matches!(residuals, Residuals::Relief { .. }));
    let balance = |readings: &mut Readings, shut: bool| {
        let known: Vec<(usize, usize)> = pumps.iter().chain(&reliefs).map(|&other| (other, 0)).collect();
        let mut flow = Balance::of_node(rig, &known, readings)?;
        let mut view = |(other, port): &(usize, usize)| Some((View::of(rig, *other, readings)?, *port));
        let laws = known.iter().map(&mut view).collect::<Option<Vec<_>>>()?;
        if shut {
            let views = laws.iter().map(|(view, _)| view).filter(|view| reliefs.contains(&view.component));
            flow.shut.extend(views.cloned());
        }
        Some(Form::Through { laws, flow, sign: -1.0 })
    };
    let meaning = "pump flow minus relief flow at the measured pressure minus what leaves the pump line";
    add(rig, index, Label::new("balance", "-", meaning), found, |readings| balance(readings, false));
    // Above the set pressure a lost displacement and a shifted set pressure look alike; below it only the first is left, and
    // a relief valve that passes oil there is not in the state that its pressure says.
    if let Some(&relief) = reliefs.first() {
        let meaning =
            "pump flow that leaves neither the pump line nor a relief valve that should be shut at its pressure";
        add(rig, relief, Label::new("state", "-", meaning), found, |readings| balance(readings, true));
    }
}
