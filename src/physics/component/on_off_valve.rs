//! Directional valve with two ports and two positions.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use super::orifice::TRANSITION;
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, DEAD_TIME, INERTIA_TIME, Input, Parameter, Port, Role, State, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::root;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::OnOffValve, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::Lag };

pub const CARD: Card = Card {
    kind: "on-off-valve",
    meaning: "2/2 directional valve: open at a command of 1, shut at 0.",
    law: "q = alpha s q_r root(dp)/sqrt(dp_r) + G dp;  T² s'' + tau s' + s = u(t - t_d)",
    source: "orifice law, paper equation (6), through one rated point",
    validity: "The area grows straight with the way of the spool; the same both ways; leakage laminar.",
    parameters: &[
        Parameter::required("rated_flow", "q_r", "L/min", "flow at the rated drop, fully open"),
        Parameter::required("rated_drop", "dp_r", "bar", "rated pressure drop").positive().calibrated(0.1),
        Parameter::required("opening", "alpha", "-", "share of the rated area that opens").or(1.0).within(0.0, 1.5),
        Parameter::required("leakage", "G", "L/min/bar", "flow per pressure when shut").is(Role::Laminar).or(0.0),
        Parameter::required("lag", "tau", "ms", "time constant with which the spool follows the command")
            .is(Role::Lag)
            .positive()
            .or(10.0)
            .uncertain_per_event(0.25),
        TRANSITION,
        INERTIA_TIME,
        DEAD_TIME,
    ],
    ports: &[Port::hydraulic("in", "inlet"), Port::hydraulic("out", "outlet")],
    states: &[State { name: "spool", unit: "-", initial: 0.0, scale: 1.0, meaning: "share of the way that is open" }],
    inputs: &[Input { name: "command", unit: "-", meaning: "1 opens, 0 shuts", range: (0.0, 1.0), lag: Some("lag") }],
    worked: &[
        Worked {
            text: "8 L/min at 20 bar, open: 4 L/min at 5 bar",
            parameters: &[("rated_flow", 8.0), ("rated_drop", 20.0), ("transition_pressure", 1e-4)],
            at: &[6e5, 1e5, 1.0],
            inputs: &[1.0],
            answer: Answer::Through(0),
            expect: 4e-3 / 60.0,
        },
        Worked {
            text: "shut, 0.001 L/min/bar of leakage under 100 bar: 0.1 L/min",
            parameters: &[("rated_flow", 8.0), ("rated_drop", 20.0), ("leakage", 0.001)],
            at: &[101e5, 1e5, 0.0],
            inputs: &[0.0],
            answer: Answer::Through(0),
            expect: 0.1e-3 / 60.0,
        },
    ],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct OnOffValve<T> {
    conductance: T,
    leakage: T,
    lag: T,
    transition: T,
}

impl<T: Real> Law<T> for OnOffValve<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { conductance: p[2] * p[0] / p[1].sqrt(), leakage: p[3], lag: p[4], transition: p[5] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, spool, ..] = seen.z;
        let drop = p_in - p_out;
        let flow = self.conductance * spool.max(T::zero()) * root(drop, self.transition) + self.leakage * drop;
        answers.through[0] = flow;
        answers.through[1] = -flow;
        answers.rate[0] = (seen.u[0] - spool) / self.lag;
    }
}
