//! Open reservoir whose level is its pressure.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::GRAVITY;
use crate::physics::card::{Answer, Card, Parameter, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::Vessel, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "reservoir",
    meaning: "Open reservoir: the pressure at its outlet is that of its level.",
    law: "p = p_atm + rho g h;  C = A/(rho g), so that A h' = sum of flows",
    source: "hydrostatics",
    validity: "Prismatic, slow: no inertia of the fluid; the level may exceed the wall (overflow is an effect).",
    parameters: &[Parameter::required("area", "A", "cm2", "horizontal cross-section").positive()],
    ports: &[Port::hydraulic("P", "at the bottom")],
    // Some 10 cm of level: on the scale of a pump line, errors of centimetres would pass.
    pressure_scale: 1e3,
    worked: &[Worked {
        text: "154 cm2 of oil of 870 kg/m3 take up 1.8050e-6 m3 per Pa",
        parameters: &[("area", 154.0)],
        at: &[1e5],
        inputs: &[],
        answer: Answer::Capacity(0),
        expect: 1.805_00e-6,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct Reservoir<T> {
    capacity: T,
}

impl<T: Real> Law<T> for Reservoir<T> {
    fn new(parameters: &[T], fluid: &Fluid<T>) -> Self {
        Self { capacity: parameters[0] / (fluid.density() * GRAVITY) }
    }

    #[inline]
    fn evaluate(&self, _seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        answers.capacity[0] = self.capacity;
    }
}
