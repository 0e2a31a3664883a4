//! Check valve.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::CheckValve,
    residuals: Residuals::None,
    balance: Balance::OneWay { opens_at: CARD.place("cracking_pressure") },
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "check-valve",
    meaning: "Check valve: free from `in` to `out` above its cracking pressure, shut the other way.",
    law: "q = G max(p_in - p_out - p_c, 0)",
    source: "static line of a data sheet",
    validity: "No poppet dynamics, no leakage when shut.",
    parameters: &[
        Parameter::required("cracking_pressure", "p_c", "bar", "pressure drop at which it opens")
            .or(0.3)
            .calibrated(0.2),
        Parameter::required("gradient", "G", "L/min/bar", "flow per pressure drop above cracking").calibrated(0.2),
    ],
    ports: &[Port::hydraulic("in", "inlet"), Port::hydraulic("out", "outlet")],
    worked: &[Worked {
        text: "0.5 bar over a valve that cracks at 0.3 bar and passes 60 L/min per bar: 12 L/min",
        parameters: &[("cracking_pressure", 0.3), ("gradient", 60.0)],
        at: &[1e5, 0.5e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 12e-3 / 60.0,
    }],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct CheckValve<T> {
    cracking_pressure: T,
    gradient: T,
}

impl<T: Real> Law<T> for CheckValve<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { cracking_pressure: parameters[0], gradient: parameters[1] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, ..] = seen.z;
        let flow = self.gradient * (p_in - p_out - self.cracking_pressure).max(T::zero());
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
