//! Friction that depends on the position, without a formula.

use super::spline::{Curve, HEIGHTS, card, free};
use super::{At, Effect, Form, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "empirical-friction",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: true,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Body], shared: &[("stroke", "stroke")] },
    parameters: &free(50.0),
};

const MORE: &[Parameter] = &[
    Parameter::required("stroke", "s", "mm", "way over which the curve runs").positive().or(100.0),
    Parameter::required("transition_speed", "v_t", "mm/s", "speed at which 71 % of the friction act")
        .positive()
        .or(1.0),
];

pub const CARD: Card = Card {
    kind: "empirical-friction",
    meaning: "Friction versus position as the record shows it: a dent, a tight spot, a worn seal.",
    law: "F = -f(x) v / sqrt(v^2 + v_t^2), f a curve",
    source: "empirical: uniform cubic B-spline of 20 heights",
    validity: "Not a law: it says what happened on the way that the record covers.",
    parameters: &card::<{ HEIGHTS + 2 }>("N", "friction along the stroke", MORE),
    ports: &[Port::mechanical("body", "what rubs")],
    worked: &[Worked {
        text: "10 N all along hold back a body at 0.75 of the transition speed with 6 N",
        parameters: &[
            ("c01", 10.0),
            ("c02", 10.0),
            ("c03", 10.0),
            ("c04", 10.0),
            ("c05", 10.0),
            ("c06", 10.0),
            ("c07", 10.0),
            ("c08", 10.0),
            ("c09", 10.0),
            ("c10", 10.0),
            ("c11", 10.0),
            ("c12", 10.0),
            ("c13", 10.0),
            ("c14", 10.0),
            ("c15", 10.0),
            ("c16", 10.0),
            ("c17", 10.0),
            ("c18", 10.0),
            ("c19", 10.0),
            ("c20", 10.0),
            ("transition_speed", 1.0),
        ],
        at: &[0.05, 0.75e-3],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -6.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone)]
pub struct EmpiricalFriction<T> {
    curve: Curve<T>,
    stroke: T,
    transition: T,
}

impl<T: Real> Law<T> for EmpiricalFriction<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { curve: Curve::new(&p[..HEIGHTS]), stroke: p[HEIGHTS], transition: p[HEIGHTS + 1] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [x, v, ..] = seen.z;
        answers.through[0] = -(self.curve.at(x / self.stroke) * v) / (v * v + self.transition * self.transition).sqrt();
    }
}
