//! A relief valve that weeps before it cracks.

use super::{At, Effect, Form, FreeParameter, InitialGuess, Joint};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::component::facts::Symbol;
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const EFFECT: Effect = Effect {
    name: "relief-weeping",
    meaning: CARD.meaning,
    law: CARD.law,
    source: CARD.source,
    validity: CARD.validity,
    empirical: false,
    everywhere: false,
    at: At::Like { symbol: Symbol::ReliefValve, named: false },
    form: Form::Shunt { card: &CARD, joints: &[Joint::Hydraulic(0), Joint::Hydraulic(1)], shared: &[] },
    parameters: &[
        FreeParameter {
            name: "conductance",
            neutral: Some(0.0),
            first: InitialGuess::Value(0.01),
            plausible: (0.0, 0.5),
        },
        FreeParameter { name: "from", neutral: None, first: InitialGuess::Onset(80.0), plausible: (0.0, 400.0) },
    ],
};

pub const CARD: Card = Card {
    kind: "relief-weeping",
    meaning: "Flow over the relief valve below its cracking pressure.",
    law: "q = G max(p_P - p_T - p_w, 0)",
    source: "a worn seat leaks before it lifts; straight line from the weeping pressure",
    validity: "Meant for the pressures just below cracking; above it the line goes on.",
    parameters: &[
        Parameter::required("conductance", "G", "L/min/bar", "flow per pressure above the weeping pressure").or(0.0),
        Parameter::required("from", "p_w", "bar", "pressure from which on it weeps").or(80.0),
    ],
    ports: &[Port::hydraulic("P", "pressure side"), Port::hydraulic("T", "tank side")],
    worked: &[Worked {
        text: "0.03 L/min/bar from 80 bar on, at 90 bar: 0.3 L/min",
        parameters: &[("conductance", 0.03), ("from", 80.0)],
        at: &[91e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 5e-6,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ReliefWeeping<T> {
    conductance: T,
    from: T,
}

impl<T: Real> Law<T> for ReliefWeeping<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { conductance: p[0], from: p[1] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.conductance * (seen.z[0] - seen.z[1] - self.from).max(T::zero());
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
