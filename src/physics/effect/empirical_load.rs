//! A force that depends on the position, without a formula.

use super::spline::{Curve, HEIGHTS, card, free};
use super::{At, Effect, Form, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "empirical-load",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: true,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Load], shared: &[("stroke", "stroke")] },
    parameters: &free(50.0),
};

const MORE: &[Parameter] =
    &[Parameter::required("stroke", "s", "mm", "way over which the curve runs").positive().or(100.0)];

pub const CARD: Card = Card {
    kind: "empirical-load",
    meaning: "Force along the stroke as the record shows it.",
    law: "F = -f(x), f a curve",
    source: "empirical: uniform cubic B-spline of 20 heights",
    validity: "Not a law: it says what happened on the way that the record covers.",
    parameters: &card::<{ HEIGHTS + 1 }>("N", "force along the stroke", MORE),
    ports: &[Port::mechanical("body", "what rubs")],
    worked: &[Worked {
        text: "200 N all along push back with 200 N",
        parameters: &[
            ("c01", 200.0),
            ("c02", 200.0),
            ("c03", 200.0),
            ("c04", 200.0),
            ("c05", 200.0),
            ("c06", 200.0),
            ("c07", 200.0),
            ("c08", 200.0),
            ("c09", 200.0),
            ("c10", 200.0),
            ("c11", 200.0),
            ("c12", 200.0),
            ("c13", 200.0),
            ("c14", 200.0),
            ("c15", 200.0),
            ("c16", 200.0),
            ("c17", 200.0),
            ("c18", 200.0),
            ("c19", 200.0),
            ("c20", 200.0),
        ],
        at: &[0.05, 0.0],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -200.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone)]
pub struct EmpiricalLoad<T> {
    curve: Curve<T>,
    stroke: T,
}

impl<T: Real> Law<T> for EmpiricalLoad<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { curve: Curve::new(&p[..HEIGHTS]), stroke: p[HEIGHTS] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        answers.through[0] = -self.curve.at(seen.z[0] / self.stroke);
    }
}
