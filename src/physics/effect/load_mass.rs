//! A mass that moves along.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "load-mass",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: false },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Load], shared: &[] },
    parameters: &[FreeParameter {
        name: "mass",
        neutral: Some(0.0),
        first: InitialGuess::Value(20.0),
        plausible: (-50.0, 10000.0),
    }],
};

pub const CARD: Card = Card {
    kind: "load-mass",
    meaning: "Mass coupled to the rod beyond that of the data sheet.",
    law: "m = m_0",
    source: "Newton",
    validity: "Rigid coupling.",
    parameters: &[Parameter::required("mass", "m_0", "kg", "further moving mass")
        .is(Role::Mass)
        .or(0.0)
        .within(-1e4, 1e6)],
    ports: &[Port::mechanical("body", "where it acts")],
    worked: &[Worked {
        text: "20 kg add 20 kg",
        parameters: &[("mass", 20.0)],
        at: &[0.0, 0.0],
        inputs: &[],
        answer: Answer::Capacity(0),
        expect: 20.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct LoadMass<T> {
    mass: T,
}

impl<T: Real> Law<T> for LoadMass<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { mass: p[0] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let _ = seen;
        answers.capacity[0] = self.mass;
    }
}
