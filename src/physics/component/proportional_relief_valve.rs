//! Relief valve whose set pressure is commanded.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Input, Parameter, Port, Role, State, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::root;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::ReliefValve, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::Lag };

pub const CARD: Card = Card {
    kind: "proportional-relief-valve",
    meaning: "Relief valve whose set pressure is commanded; as a load, a brake that holds a pressure.",
    law: "tau e' = max(p_P - p_T - p_u - p_0, 0) - e;  q = q_r (e/e_r) sqrt(dp/(p_u + p_0 + e_r))",
    source: "static gradient of a data sheet; Merritt (1967), section 5-6, for the lag",
    validity: "Static line through cracking and rated point at each command; no hysteresis.",
    parameters: &[
        Parameter::required("rated_flow", "q_r", "L/min", "flow at the rated overpressure"),
        Parameter::required("rated_overpressure", "e_r", "bar", "pressure above cracking at the rated flow")
            .positive()
            .calibrated(0.2),
        Parameter::required("shift", "p_0", "bar", "what the cracking pressure differs from the command")
            .or(0.0)
            .within(-100.0, 100.0),
        Parameter::required("lag", "tau", "ms", "time constant of the opening")
            .is(Role::Lag)
            .positive()
            .or(30.0)
            .uncertain_per_event(0.25),
    ],
    ports: &[Port::hydraulic("P", "pressure side"), Port::hydraulic("T", "tank side")],
    states: &[State {
        name: "overpressure",
        unit: "bar",
        initial: 0.0,
        scale: 1.0,
        meaning: "overpressure that the opening has followed",
    }],
    inputs: &[Input {
        name: "set_pressure",
        unit: "bar",
        meaning: "commanded cracking pressure",
        range: (0.0, 4e7),
        lag: None,
    }],
    worked: &[Worked {
        text: "5 bar above a command of 120 bar with the opening settled pass the rated 8 L/min",
        parameters: &[("rated_flow", 8.0), ("rated_overpressure", 5.0)],
        at: &[126e5, 1e5, 5e5],
        inputs: &[120e5],
        answer: Answer::Through(0),
        expect: 8e-3 / 60.0,
    }],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct ProportionalReliefValve<T> {
    rated_flow: T,
    rated_overpressure: T,
    shift: T,
    lag: T,
}

impl<T: Real> Law<T> for ProportionalReliefValve<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { rated_flow: p[0], rated_overpressure: p[1], shift: p[2], lag: p[3] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_p, p_t, followed, ..] = seen.z;
        let drop = p_p - p_t;
        let cracking = (seen.u[0] + self.shift).max(T::zero());
        let gradient = self.rated_flow / (self.rated_overpressure * (cracking + self.rated_overpressure).sqrt());
        // The transition only keeps the root smooth where the valve is shut anyway.
        let flow = gradient * followed * root(drop, T::constant(1e3));
        answers.through[0] = flow;
        answers.through[1] = -flow;
        answers.rate[0] = ((drop - cracking).max(T::zero()) - followed) / self.lag;
    }
}
