//! Line volume: the oil in a pipe or hose that makes a node compliant.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::Hidden, residuals: Residuals::None, balance: Balance::Stores, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "line-volume",
    meaning: "Volume of a line: the oil whose compression lets the pressure of its node change.",
    law: "C = V/beta;  C p' = sum of flows",
    source: "mass balance of a compressible volume; paper, equation (1)",
    validity: "One pressure in the whole volume: waves are much faster than the changes looked at.",
    parameters: &[Parameter::required(
        "volume",
        "V",
        "cm3",
        "enclosed volume; with a `+-` one value throughout, which calibration finds",
    )
    .is(Role::Volume)
    .uncertain_per_event(0.05)],
    ports: &[Port::hydraulic("P", "to the node")],
    worked: &[Worked {
        text: "50 cm3 of oil of 14000 bar take up 3.5714e-14 m3 per Pa",
        parameters: &[("volume", 50.0)],
        at: &[1e5],
        inputs: &[],
        answer: Answer::Capacity(0),
        expect: 3.571_428_57e-14,
    }],
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct LineVolume<T> {
    volume: T,
    fluid: Fluid<T>,
}

impl<T: Real> Law<T> for LineVolume<T> {
    fn new(parameters: &[T], fluid: &Fluid<T>) -> Self {
        Self { volume: parameters[0], fluid: *fluid }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        answers.capacity[0] = self.volume / self.fluid.bulk_modulus(seen.z[0]);
    }
}
