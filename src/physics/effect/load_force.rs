//! A constant force that is not measured.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "load-force",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: false },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Load], shared: &[] },
    parameters: &[FreeParameter {
        name: "force",
        neutral: Some(0.0),
        first: InitialGuess::Value(100.0),
        plausible: (-1e5, 1e5),
    }],
};

pub const CARD: Card = Card {
    kind: "load-force",
    meaning: "Constant force on the rod; positive pushes against the outstroke.",
    law: "F = -F_0",
    source: "sign convention of the measured load",
    validity: "Constant over the record.",
    parameters: &[Parameter::required("force", "F_0", "N", "the force").or(0.0).within(-1e6, 1e6)],
    ports: &[Port::mechanical("body", "where it acts")],
    worked: &[Worked {
        text: "200 N push back with 200 N",
        parameters: &[("force", 200.0)],
        at: &[0.0, 0.0],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -200.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct LoadForce<T> {
    force: T,
}

impl<T: Real> Law<T> for LoadForce<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { force: p[0] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let _ = seen;
        answers.through[0] = -self.force;
    }
}
