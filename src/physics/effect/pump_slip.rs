//! Slip of a pump.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::component::pump;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "pump-slip",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Component { card: &pump::CARD, named: false },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Hydraulic(0), Joint::Hydraulic(1)], shared: &[] },
    parameters: &[FreeParameter {
        name: "conductance",
        neutral: Some(0.0),
        first: InitialGuess::Value(0.002),
        plausible: (0.0, 0.05),
    }],
};

pub const CARD: Card = Card {
    kind: "pump-slip",
    meaning: "Flow back through the gaps of the pump.",
    law: "q = G (p_P - p_T)",
    source: "Wilson (1948); laminar slip of a displacement pump",
    validity: "Laminar; speed and viscosity constant.",
    parameters: &[Parameter::required("conductance", "G", "L/min/bar", "flow per pressure").is(Role::Laminar).or(0.0)],
    ports: &[Port::hydraulic("P", "outlet"), Port::hydraulic("T", "inlet")],
    worked: &[Worked {
        text: "0.003 L/min/bar under 100 bar slip 0.3 L/min",
        parameters: &[("conductance", 0.003)],
        at: &[101e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 5e-6,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct PumpSlip<T> {
    conductance: T,
}

impl<T: Real> Law<T> for PumpSlip<T> {
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
