//! Leakage past the piston that depends on the position, without a formula.

use super::spline::{Curve, HEIGHTS, card, free};
use super::{At, Effect, Form, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "empirical-piston-leakage",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: true,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt {
        card: &CARD,
        joints: &[Joint::Hydraulic(0), Joint::Hydraulic(1), Joint::Body],
        shared: &[("stroke", "stroke")],
    },
    parameters: &free(0.002),
};

const MORE: &[Parameter] =
    &[Parameter::required("stroke", "s", "mm", "way over which the curve runs").positive().or(100.0)];

pub const CARD: Card = Card {
    kind: "empirical-piston-leakage",
    meaning: "Leakage from A to B along the stroke as the record shows it.",
    law: "q = f(x) (p_A - p_B), f a curve",
    source: "empirical: uniform cubic B-spline of 20 heights",
    validity: "Not a law: it says what happened on the way that the record covers.",
    parameters: &card::<{ HEIGHTS + 1 }>("L/min/bar", "conductance along the stroke", MORE),
    ports: &[
        Port::hydraulic("A", "cap side"),
        Port::hydraulic("B", "rod side"),
        Port::mechanical("rod", "piston and rod"),
    ],
    worked: &[Worked {
        text: "0.006 L/min/bar all along leak 0.3 L/min under 50 bar",
        parameters: &[
            ("c01", 0.006),
            ("c02", 0.006),
            ("c03", 0.006),
            ("c04", 0.006),
            ("c05", 0.006),
            ("c06", 0.006),
            ("c07", 0.006),
            ("c08", 0.006),
            ("c09", 0.006),
            ("c10", 0.006),
            ("c11", 0.006),
            ("c12", 0.006),
            ("c13", 0.006),
            ("c14", 0.006),
            ("c15", 0.006),
            ("c16", 0.006),
            ("c17", 0.006),
            ("c18", 0.006),
            ("c19", 0.006),
            ("c20", 0.006),
        ],
        at: &[51e5, 1e5, 0.05, 0.0],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 5e-6,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone)]
pub struct EmpiricalPistonLeakage<T> {
    curve: Curve<T>,
    stroke: T,
}

impl<T: Real> Law<T> for EmpiricalPistonLeakage<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { curve: Curve::new(&p[..HEIGHTS]), stroke: p[HEIGHTS] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.curve.at(seen.z[2] / self.stroke) * (seen.z[0] - seen.z[1]);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
