//! Flow source: a pump whose flow follows a recorded signal.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{ANY, Answer, Card, Input, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::VariablePump,
    residuals: Residuals::None,
    balance: Balance::Ends,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "flow-source",
    meaning: "Pump driven by a recorded voltage: its flow is proportional to it.",
    law: "q = k max(u - u_0, 0)",
    source: "linear characteristic",
    validity: "No dependence on pressure.",
    parameters: &[
        Parameter::required("gain", "k", "L/min/V", "flow per volt").calibrated(0.1),
        Parameter::required("dead_voltage", "u_0", "V", "voltage below which nothing is delivered").or(0.0),
    ],
    ports: &[Port::hydraulic("P", "outlet"), Port::hydraulic("T", "inlet")],
    inputs: &[Input { name: "voltage", unit: "V", meaning: "drive signal", range: ANY, lag: None }],
    worked: &[Worked {
        text: "2 V at 3 L/min/V deliver 6 L/min out of port P",
        parameters: &[("gain", 3.0)],
        at: &[1e5, 1e5],
        inputs: &[2.0],
        answer: Answer::Through(0),
        expect: -1e-4,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct FlowSource<T> {
    gain: T,
    dead_voltage: T,
}

impl<T: Real> Law<T> for FlowSource<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { gain: parameters[0], dead_voltage: parameters[1] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.gain * (seen.u[0] - self.dead_voltage).max(T::zero());
        answers.through[0] = -flow;
        answers.through[1] = flow;
    }
}
