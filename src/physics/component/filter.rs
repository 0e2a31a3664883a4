//! Filter whose element clogs: the component that `docs/how-to/add-a-component.md` adds, compiled for tests alone.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use super::{PortFlows, Law, PortVariables};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;

pub const FACTS: Facts = Facts {
    symbol: Symbol::Box,
    residuals: Residuals::Through,
    balance: Balance::Through,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "filter",
    meaning: "Filter whose element clogs.",
    law: "q = G (1 - c) (p_in - p_out)",
    source: "Darcy's law for the flow through a porous wall",
    validity: "Laminar, no bypass valve, viscosity constant.",
    parameters: &[
        Parameter::required("conductance", "G", "L/min/bar", "flow per pressure drop of the new element"),
        Parameter::required("clogging", "c", "-", "share of the element that is clogged").or(0.0).within(0.0, 1.0),
    ],
    ports: &[Port::hydraulic("in", "dirty side"), Port::hydraulic("out", "clean side")],
    worked: &[Worked {
        text: "10 L/min/bar, half of it clogged, pass 10 L/min at 2 bar",
        parameters: &[("conductance", 10.0), ("clogging", 0.5)],
        at: &[3e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 10e-3 / 60.0,
    }],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct Filter<T> {
    conductance: T,
}

impl<T: Real> Law<T> for Filter<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { conductance: parameters[0] * (T::one() - parameters[1]) }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, ..] = seen.z;
        let flow = self.conductance * (p_in - p_out);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
