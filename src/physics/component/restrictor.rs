//! Restrictor given by its rated flow at a rated pressure drop.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use super::orifice::TRANSITION;
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::root;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::Restrictor,
    residuals: Residuals::None,
    balance: Balance::Through,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "restrictor",
    meaning: "Restrictor known by one rated point, turbulent with a smooth laminar start.",
    law: "q = k q_r dp / (dp² + dp_t²)^(1/4) / sqrt(dp_r)",
    source: "orifice law, paper equation (6), through one measured point",
    validity: "Turbulent around the rated point.",
    parameters: &[
        Parameter::required("rated_flow", "q_r", "L/min", "flow at the rated pressure drop"),
        Parameter::required("rated_drop", "dp_r", "bar", "rated pressure drop").positive().calibrated(0.1),
        Parameter::required("opening", "k", "-", "share of the rated area that is open").or(1.0).within(0.0, 2.0),
        TRANSITION,
    ],
    ports: &[Port::hydraulic("in", "inlet"), Port::hydraulic("out", "outlet")],
    worked: &[Worked {
        text: "8 L/min at 18.5 bar make 4 L/min at a quarter of the drop",
        parameters: &[("rated_flow", 8.0), ("rated_drop", 18.5), ("transition_pressure", 1e-4)],
        at: &[5.625e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 4e-3 / 60.0,
    }],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct Restrictor<T> {
    conductance: T,
    transition: T,
}

impl<T: Real> Law<T> for Restrictor<T> {
    fn new(parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { conductance: parameters[2] * parameters[0] / parameters[1].sqrt(), transition: parameters[3] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, ..] = seen.z;
        let flow = self.conductance * root(p_in - p_out, self.transition);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
