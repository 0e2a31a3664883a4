//! A spring that is not measured.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "load-stiffness",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: false },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Load], shared: &[] },
    parameters: &[FreeParameter {
        name: "stiffness",
        neutral: Some(0.0),
        first: InitialGuess::Value(1.0),
        plausible: (-100.0, 1000.0),
    }],
};

pub const CARD: Card = Card {
    kind: "load-stiffness",
    meaning: "Force that grows with the position of the rod.",
    law: "F = -k x",
    source: "Hooke",
    validity: "Linear, without preload (see load-force).",
    parameters: &[Parameter::required("stiffness", "k", "N/mm", "force per way").or(0.0).within(-1e4, 1e4)],
    ports: &[Port::mechanical("body", "where it acts")],
    worked: &[Worked {
        text: "2 N/mm at 100 mm push back with 200 N",
        parameters: &[("stiffness", 2.0)],
        at: &[0.1, 0.0],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -200.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct LoadStiffness<T> {
    stiffness: T,
}

impl<T: Real> Law<T> for LoadStiffness<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { stiffness: p[0] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        answers.through[0] = -(self.stiffness * seen.z[0]);
    }
}
