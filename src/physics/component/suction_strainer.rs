//! Suction strainer whose mesh clogs, with a bypass valve.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::BypassFilter,
    residuals: Residuals::Through,
    balance: Balance::ThroughOrLaw,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "suction-strainer",
    meaning: "Strainer ahead of a pump whose mesh clogs, with a bypass valve that keeps the pump from starving.",
    law: "q = q_r (1 - c) (mu_r/mu) dp/dp_r + G_b max(dp - p_b, 0)",
    source: "Darcy's law for the flow through a mesh, through the point of a data sheet; static line of a data sheet for the bypass",
    validity: "Laminar through the mesh; the bypass neither lags nor leaks; no cavitation behind it.",
    parameters: &[
        Parameter::required("rated_flow", "q_r", "L/min", "flow of the new element at its rated drop"),
        Parameter::required("rated_drop", "dp_r", "bar", "pressure drop of the new element at its rated flow")
            .positive()
            .calibrated(0.1),
        Parameter::required("rated_viscosity", "mu_r", "mPa.s", "viscosity that the data sheet measures the drop with")
            .positive()
            .or(26.0),
        Parameter::required("clogging", "c", "-", "share of the mesh that is clogged").or(0.0).within(0.0, 1.0),
        Parameter::required("bypass_pressure", "p_b", "bar", "pressure drop at which the bypass cracks open")
            .or(0.2)
            .calibrated(0.1),
        Parameter::required("bypass_gradient", "G_b", "L/min/bar", "flow per pressure drop of the open bypass"),
    ],
    ports: &[Port::hydraulic("in", "tank side"), Port::hydraulic("out", "pump side")],
    // Some 0.1 bar of suction: on the scale of a pump line, errors as large would pass.
    pressure_scale: 1e4,
    worked: &[
        Worked {
            text: "60 L/min at 0.06 bar and 26 mPa.s, half of it clogged and 45.5 mPa.s: 0.1 bar pass 60/0.06 * 0.5 * 26/45.5 * 0.1 = 28.571 L/min",
            parameters: &[("rated_flow", 60.0), ("rated_drop", 0.06), ("clogging", 0.5), ("bypass_gradient", 300.0)],
            at: &[1.0e5, 0.9e5],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 28.571_43e-3 / 60.0,
        },
        Worked {
            text: "wholly clogged, 0.3 bar are 0.1 bar above the bypass: 300 L/min/bar pass 30 L/min",
            parameters: &[("rated_flow", 60.0), ("rated_drop", 0.06), ("clogging", 1.0), ("bypass_gradient", 300.0)],
            at: &[1.0e5, 0.7e5],
            inputs: &[],
            answer: Answer::Through(0),
            expect: 30e-3 / 60.0,
        },
    ],
    throttles: true,
    sees_viscosity: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct SuctionStrainer<T> {
    conductance: T,
    bypass_pressure: T,
    bypass_gradient: T,
}

impl<T: Real> Law<T> for SuctionStrainer<T> {
    fn new(parameters: &[T], fluid: &Fluid<T>) -> Self {
        let [rated_flow, rated_drop, rated_viscosity, clogging] =
            [parameters[0], parameters[1], parameters[2], parameters[3]];
        let rated = rated_flow / rated_drop * (rated_viscosity / fluid.viscosity());
        Self {
            conductance: rated * (T::one() - clogging),
            bypass_pressure: parameters[4],
            bypass_gradient: parameters[5],
        }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, ..] = seen.z;
        let drop = p_in - p_out;
        let mesh = self.conductance * seen.fluidity * drop;
        let bypass = self.bypass_gradient * (drop - self.bypass_pressure).max(T::zero());
        let flow = mesh + bypass;
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
