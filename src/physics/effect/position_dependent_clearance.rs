//! Leakage past the piston that changes along the stroke.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "position-dependent-clearance",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::Cylinder, named: true },
    form: Form::Shunt {
        card: &CARD,
        joints: &[Joint::Hydraulic(0), Joint::Hydraulic(1), Joint::Body],
        shared: &[("stroke", "stroke")],
    },
    parameters: &[FreeParameter {
        name: "conductance",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.01),
        plausible: (-0.2, 0.2),
    }],
};

pub const CARD: Card = Card {
    kind: "position-dependent-clearance",
    meaning: "Leakage from A to B that grows along the stroke: a bore that is worn where the piston works most.",
    law: "q = G (x/s) (p_A - p_B)",
    source: "laminar gap, Merritt (1967), eq. 2-53, its conductance straight over the position",
    validity: "Laminar; straight over the stroke; a negative value is wear at the other end on top of a clearance.",
    parameters: &[
        Parameter::required("conductance", "G", "L/min/bar", "flow per pressure at the far end")
            .is(Role::Laminar)
            .or(0.0)
            .within(-1.0, 1.0),
        Parameter::required("stroke", "s", "mm", "way between the end stops").positive().or(100.0),
    ],
    ports: &[
        Port::hydraulic("A", "cap side"),
        Port::hydraulic("B", "rod side"),
        Port::mechanical("rod", "piston and rod"),
    ],
    worked: &[Worked {
        text: "0.01 L/min/bar at the end, half way, 60 bar: 0.3 L/min",
        parameters: &[("conductance", 0.01), ("stroke", 200.0)],
        at: &[61e5, 1e5, 0.1, 0.0],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 5e-6,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct PositionDependentClearance<T> {
    per_position: T,
}

impl<T: Real> Law<T> for PositionDependentClearance<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { per_position: p[0] / p[1] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.per_position * seen.z[2] * (seen.z[0] - seen.z[1]);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
