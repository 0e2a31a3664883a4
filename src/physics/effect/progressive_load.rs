//! A load that grows with the square of the position.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "progressive-load",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: false },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Load], shared: &[] },
    parameters: &[FreeParameter {
        name: "rate",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.01),
        plausible: (-10.0, 10.0),
    }],
};

pub const CARD: Card = Card {
    kind: "progressive-load",
    meaning: "Force that depends on the position and bends: a wall that closes in, a linkage.",
    law: "F = -k x^2",
    source: "first curved term of any law of the position",
    validity: "Meant for one stroke; the sign may be either.",
    parameters: &[Parameter::required("rate", "k", "N/mm2", "force per square of the way").or(0.0).within(-1e3, 1e3)],
    ports: &[Port::mechanical("body", "where it acts")],
    worked: &[Worked {
        text: "0.02 N/mm2 at 100 mm push back with 200 N",
        parameters: &[("rate", 0.02)],
        at: &[0.1, 0.0],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -200.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ProgressiveLoad<T> {
    rate: T,
}

impl<T: Real> Law<T> for ProgressiveLoad<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { rate: p[0] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        answers.through[0] = -(self.rate * seen.z[0] * seen.z[0]);
    }
}
