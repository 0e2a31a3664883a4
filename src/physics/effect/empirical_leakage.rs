//! Leakage of a node over its pressure, without a formula.

use super::spline::{Curve, HEIGHTS, card, free};
use super::{At, Effect, Form, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "empirical-leakage",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: true,
    everywhere: false,
    at: At::Node,
    form: Form::Shunt { card: &CARD, joints: &[Joint::Here, Joint::Tank], shared: &[] },
    parameters: &free(0.05),
};

const MORE: &[Parameter] =
    &[Parameter::required("range", "p_r", "bar", "pressure over which the curve runs").positive().or(120.0)];

pub const CARD: Card = Card {
    kind: "empirical-leakage",
    meaning: "Flow from a node to the tank over the pressure as the record shows it.",
    law: "q = f(p - p_T), f a curve from 0 to range",
    source: "empirical: uniform cubic B-spline of 20 heights",
    validity: "Not a law: it says what happened at the pressures that the record covers.",
    parameters: &card::<{ HEIGHTS + 1 }>("L/min", "flow over the pressure", MORE),
    ports: &[Port::hydraulic("P", "what leaks"), Port::hydraulic("T", "tank")],
    worked: &[Worked {
        text: "0.3 L/min at every pressure",
        parameters: &[
            ("c01", 0.3),
            ("c02", 0.3),
            ("c03", 0.3),
            ("c04", 0.3),
            ("c05", 0.3),
            ("c06", 0.3),
            ("c07", 0.3),
            ("c08", 0.3),
            ("c09", 0.3),
            ("c10", 0.3),
            ("c11", 0.3),
            ("c12", 0.3),
            ("c13", 0.3),
            ("c14", 0.3),
            ("c15", 0.3),
            ("c16", 0.3),
            ("c17", 0.3),
            ("c18", 0.3),
            ("c19", 0.3),
            ("c20", 0.3),
        ],
        at: &[51e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 5e-6,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone)]
pub struct EmpiricalLeakage<T> {
    curve: Curve<T>,
    range: T,
}

impl<T: Real> Law<T> for EmpiricalLeakage<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { curve: Curve::new(&p[..HEIGHTS]), range: p[HEIGHTS] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.curve.at((seen.z[0] - seen.z[1]) / self.range);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
