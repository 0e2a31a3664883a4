//! Compliance of a hose.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "hose-compliance",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Node,
    form: Form::Shunt { card: &CARD, joints: &[Joint::Here], shared: &[] },
    parameters: &[FreeParameter {
        name: "capacity",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.002),
        plausible: (0.0, 1.0),
    }],
};

pub const CARD: Card = Card {
    kind: "hose-compliance",
    meaning: "A hose that widens under pressure: more capacity at its node.",
    law: "C = C_h",
    source: "elastic pipe; VDI 3833 style capacity per pressure",
    validity: "Linear: no stiffening, no damping of the wall.",
    parameters: &[Parameter::required("capacity", "C_h", "cm3/bar", "volume taken up per pressure").or(0.0)],
    ports: &[Port::hydraulic("P", "node with the hose")],
    worked: &[Worked {
        text: "0.01 cm3/bar are 1e-13 m3/Pa",
        parameters: &[("capacity", 0.01)],
        at: &[1e5],
        inputs: &[],
        answer: Answer::Capacity(0),
        expect: 1e-13,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct HoseCompliance<T> {
    capacity: T,
}

impl<T: Real> Law<T> for HoseCompliance<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { capacity: p[0] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let _ = seen;
        answers.capacity[0] = self.capacity;
    }
}
