//! Sharp-edged orifice.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::law::{orifice_conductance, root};
use crate::physics::ports::{Law, PortFlows, PortVariables};

/// Pressure drop at which an orifice of a few millimetres passes from laminar to turbulent flow, in bar; its size
/// follows from a transition Reynolds number between 100 and 1000 and is rarely known better than to a factor.
pub const TRANSITION: Parameter =
    Parameter::required("transition_pressure", "dp_t", "bar", "pressure drop below which the flow is laminar")
        .is(Role::Smoothing)
        .or(0.05)
        .within(1e-4, 10.0)
        .uncertain(2.0);

/// Parameters of a hole, in the order that [`Orifice`] takes them.
pub const HOLE: &[Parameter] = &[
    Parameter::required("diameter", "d", "mm", "diameter of the hole"),
    Parameter::required("discharge_coefficient", "Cd", "-", "discharge coefficient")
        .or(0.7)
        .within(0.1, 1.0)
        .calibrated(0.05),
    TRANSITION,
];

pub const FACTS: Facts =
    Facts { symbol: Symbol::Orifice, residuals: Residuals::None, balance: Balance::Through, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "orifice",
    meaning: "Sharp-edged orifice, turbulent with a smooth laminar start.",
    law: "q = Cd (pi d²/4) sqrt(2/rho) dp / (dp² + dp_t²)^(1/4)",
    source: "paper, equation (6)",
    validity: "Incompressible, no cavitation, discharge coefficient independent of the flow.",
    parameters: HOLE,
    ports: &[Port::hydraulic("in", "inlet"), Port::hydraulic("out", "outlet")],
    worked: &[Worked {
        text: "2 mm, Cd 0.7, 870 kg/m3 and 0.74 MPa pass 5.44 L/min",
        parameters: &[("diameter", 2.0), ("transition_pressure", 1e-4)],
        at: &[8.4e5, 1e5],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 9.0702e-5,
    }],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct Orifice<T> {
    conductance: T,
    transition: T,
}

impl<T: Real> Law<T> for Orifice<T> {
    fn new(parameters: &[T], fluid: &Fluid<T>) -> Self {
        Self {
            conductance: orifice_conductance(parameters[1], parameters[0], fluid.density()),
            transition: parameters[2],
        }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let [p_in, p_out, ..] = seen.z;
        let flow = self.flow(p_in - p_out);
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}

impl<T: Real> Orifice<T> {
    /// Flow in m³/s at a pressure drop in Pa.
    #[inline]
    pub fn flow(&self, drop: T) -> T {
        self.conductance * root(drop, self.transition)
    }
}
