//! Fixed-displacement pump.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::Pump, residuals: Residuals::Pump, balance: Balance::Ends, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "pump",
    meaning: "Fixed-displacement pump at constant speed.",
    law: "q = D n (1 - loss) (1 - k (p_P - p_T))",
    source: "paper, table 1: 5.5 cc/rev at 1000 rev/min",
    validity: "Below the relief pressure the slip is part of `loss`; no ripple, no cavitation.",
    parameters: &[
        Parameter::required("displacement", "D", "cc/rev", "volume per revolution")
            .usually(0.01, 10_000.0)
            .calibrated(0.02),
        Parameter::required("speed", "n", "rev/min", "shaft speed"),
        Parameter::required("loss", "l", "-", "share of the flow that does not arrive").or(0.0).within(0.0, 1.0),
        Parameter::required("droop", "k", "bar-1", "share of the speed that is lost per pressure")
            .or(0.0)
            .within(0.0, 0.1),
    ],
    ports: &[Port::hydraulic("P", "outlet"), Port::hydraulic("T", "inlet")],
    worked: &[Worked {
        text: "5.5 cc/rev at 1000 rev/min deliver 5.5 L/min out of port P",
        parameters: &[("displacement", 5.5), ("speed", 1000.0)],
        at: &[1e7, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: -5.5e-3 / 60.0,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct Pump<T> {
    flow: T,
    droop: T,
}

impl<T: Real> Law<T> for Pump<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { flow: parameters[0] * parameters[1] * (T::constant(1.0) - parameters[2]), droop: parameters[3] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.flow * (T::one() - self.droop * (seen.z[0] - seen.z[1]));
        answers.through[0] = -flow;
        answers.through[1] = flow;
    }
}
