//! External leakage through a laminar path.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "external-leakage",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: true,
    at: At::Node,
    form: Form::Shunt { card: &CARD, joints: &[Joint::Here, Joint::Tank], shared: &[] },
    parameters: &[FreeParameter {
        name: "conductance",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.002),
        plausible: (0.0, 0.2),
    }],
};

pub const CARD: Card = Card {
    kind: "external-leakage",
    meaning: "Leakage from a node to the tank through a narrow gap or a seal.",
    law: "q = G (p - p_T)",
    source: "Merritt (1967), eq. 2-53: laminar flow is proportional to the pressure drop",
    validity: "Laminar; no threshold below which a seal holds.",
    parameters: &[Parameter::required("conductance", "G", "L/min/bar", "flow per pressure").is(Role::Laminar).or(0.0)],
    ports: &[Port::hydraulic("P", "what leaks"), Port::hydraulic("T", "tank")],
    worked: &[Worked {
        text: "0.006 L/min/bar under 50 bar leak 0.3 L/min",
        parameters: &[("conductance", 0.006)],
        at: &[51e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 5e-6,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ExternalLeakage<T> {
    conductance: T,
}

impl<T: Real> Law<T> for ExternalLeakage<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { conductance: p[0] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.conductance * (seen.z[0] - seen.z[1]);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
