//! The residuals as formulas over measured readings, each written once for every number type.

use super::balance::Balance;
use super::known::Parameters;
use super::view::View;
use crate::numeric::Real;
use crate::physics::component::facts::{Spring, Throttle};
use crate::physics::law::orifice_conductance;
use crate::rig::Rig;
use std::f64::consts::PI;

/// Which edge of a directional valve a residual looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Edge {
    /// (16): supply flow minus consumer flow.
    Leakage,
    /// (18): healthy flow of the pressure edge minus the flow out of the consumer port.
    Consumer,
    /// (20): the same minus the flow into P.
    Supply,
    /// (14): healthy flow of the return edge minus the flow that comes back.
    Return,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Form {
    /// Corrected (4), volumes compensated, or as printed.
    CylinderLeakage { view: View, a: Balance, b: Balance, diameters: [usize; 2], printed: bool },
    /// `sign (sum of what the laws let into the ports - what the channels say)`.
    Through { laws: Vec<(View, usize)>, flow: Balance, sign: f64 },
    /// (10) as printed: the flow of a regulating valve, whatever the pressures; `flow` is counted into the outlet.
    ConstantFlow { view: View, flow: Balance, orifice: Throttle, spring: Spring },
    /// Directional valve; `flows` into P, T, A, B where known. As printed it reads opening, rated flow and rated drop.
    Valve { view: View, flows: [Option<Balance>; 4], edge: Edge, printed: Option<[usize; 3]> },
    /// Sum of forces on a body minus mass times acceleration.
    Force { laws: Vec<(View, usize)>, acceleration: usize },
}

/// Ports of the directional valve in the order of its card.
const P: usize = 0;
const T: usize = 1;
const A: usize = 2;
const B: usize = 3;

impl Form {
    /// The residual, SI; `None` where it is not defined, such as an edge of a valve that stands closed.
    pub fn value<N: Real>(&self, rig: &Rig, p: &Parameters<N>, x: &[N]) -> Option<N> {
        Some(match self {
            Form::CylinderLeakage { view, a, b, diameters, printed } => {
                let area = |diameter: N| diameter * diameter * (PI / 4.0);
                let [bore, rod] = diameters.map(|diameter| area(view.parameter(rig, diameter, p)));
                let (area_a, area_b) = (bore, bore - rod);
                if *printed {
                    let (q1, q2) = (a.measured(x), -b.measured(x));
                    return Some((area_a * q2 - area_b * q1) / (area_a + area_b));
                }
                // The balances take off what the chambers store, so that only speed and leakage are left.
                let (q1, q2) = (a.flow(p, x), -b.flow(p, x));
                let leak = (area_a * q2 - area_b * q1) / (area_a - area_b);
                // The healthy leak at the measured pressures and speed belongs to the healthy cylinder.
                let law = view.answers(p, x);
                let speed = view.reading(3).map_or(N::zero(), |reading| x[reading]);
                leak - (law.through[0] - area_a * speed)
            }
            Form::Through { laws, flow, sign } => {
                let law = laws.iter().fold(N::zero(), |sum, (view, port)| sum + view.answers(p, x).through[*port]);
                (law - flow.flow(p, x)) * *sign
            }
            Form::ConstantFlow { view, flow, orifice, spring } => {
                let own = |index: usize| view.parameter(rig, index, p);
                let throttle =
                    orifice_conductance(own(orifice.discharge_coefficient), own(orifice.diameter), p.values[0]);
                let drop = own(spring.rate) * own(spring.compression) / own(spring.spool_area);
                throttle * drop.sqrt() + flow.measured(x)
            }
            Form::Valve { view, flows, edge, printed } => return valve(rig, view, flows, *edge, *printed, p, x),
            Form::Force { laws, acceleration } => laws.iter().fold(N::zero(), |sum, (view, port)| {
                let law = view.answers(p, x);
                sum + law.through[*port] - law.capacity[*port] * x[*acceleration]
            }),
        })
    }

    fn balances(&self) -> Vec<&Balance> {
        match self {
            Form::CylinderLeakage { a, b, .. } => vec![a, b],
            Form::Through { flow, .. } | Form::ConstantFlow { flow, .. } => vec![flow],
            Form::Valve { flows, .. } => flows.iter().flatten().collect(),
            Form::Force { .. } => Vec::new(),
        }
    }

    /// Check valves that the formula takes as shut.
    pub fn shut(&self) -> Vec<&View> {
        self.balances().into_iter().flat_map(|balance| balance.shut.iter()).collect()
    }

    /// Components whose parameters the formula holds.
    pub fn components(&self) -> Vec<usize> {
        let stored = self.balances().into_iter().flat_map(Balance::components);
        self.views().into_iter().map(|view| view.component).chain(stored).collect()
    }

    /// Components whose law the formula evaluates.
    pub fn views(&self) -> Vec<&View> {
        match self {
            Form::CylinderLeakage { view, .. } | Form::ConstantFlow { view, .. } | Form::Valve { view, .. } => {
                vec![view]
            }
            Form::Through { laws, .. } | Form::Force { laws, .. } => laws.iter().map(|(view, _)| view).collect(),
        }
    }
}

/// Opening of the spool below which an edge passes too little to tell anything.
pub(super) const CLOSED: f64 = 0.05;

fn valve<N: Real>(
    rig: &Rig,
    view: &View,
    flows: &[Option<Balance>; 4],
    edge: Edge,
    printed: Option<[usize; 3]>,
    p: &Parameters<N>,
    x: &[N],
) -> Option<N> {
    let command = view.command(x).re();
    if command.abs() < CLOSED {
        return None;
    }
    let (consumer, back) = if command > 0.0 { (A, B) } else { (B, A) };
    let measured = |port: usize| flows[port].as_ref().map(|flow| flow.flow(p, x));
    if let Some(rated) = printed {
        // (13) as printed, the bracket outside the root: a number without physical unit.
        let [opening, rated_flow, rated_drop] = rated.map(|own| view.parameter(rig, own, p));
        let conductance = opening * rated_flow / rated_drop.sqrt();
        let drop = |from: usize, to: usize| view.pressure(from, p, x) - view.pressure(to, p, x);
        return Some(match edge {
            Edge::Leakage => measured(P)? + measured(consumer)?,
            Edge::Consumer => conductance * drop(P, consumer) + measured(consumer)?,
            Edge::Supply => conductance * drop(P, consumer) - measured(P)?,
            Edge::Return => conductance * drop(back, T) - measured(back)?,
        });
    }
    let law = view.answers(p, x).through;
    Some(match edge {
        Edge::Leakage => measured(P)? + measured(consumer)? - law[P] - law[consumer],
        Edge::Consumer => measured(consumer)? - law[consumer],
        Edge::Supply => law[P] - measured(P)?,
        Edge::Return => law[back] - measured(back)?,
    })
}
