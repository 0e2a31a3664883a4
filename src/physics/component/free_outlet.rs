//! Outlet from which the fluid falls freely into the next vessel.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use super::orifice::{HOLE, Orifice};
use crate::numeric::Real;
use crate::physics::ATMOSPHERE;
use crate::physics::card::{Answer, Card, Port, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::FreeOutlet, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "free-outlet",
    meaning: "Outlet of an open vessel whose jet falls freely: what it falls into does not hold it back.",
    law: "q = Cd (pi d²/4) sqrt(2/rho) dp / (dp² + dp_t²)^(1/4),  dp = max(p_in - p_atm, 0)",
    source: "Torricelli; the orifice law, paper equation (6), against the atmosphere",
    validity: "The outlet stands above the level that it falls into; the time of the fall is left out.",
    parameters: HOLE,
    ports: &[Port::hydraulic("in", "vessel that drains"), Port::hydraulic("out", "vessel that it falls into")],
    worked: &[Worked {
        text: "8 mm, Cd 0.7, 870 kg/m3 and 10 kPa of level pass 1.687e-4 m3/s into a vessel under any pressure",
        parameters: &[("diameter", 8.0), ("transition_pressure", 1e-4)],
        at: &[ATMOSPHERE + 1e4, ATMOSPHERE + 5e4],
        inputs: &[],
        answer: Answer::Through(0),
        expect: 1.687_03e-4,
    }],
    throttles: true,
    ..Card::EMPTY
};

#[derive(Debug, Clone, Copy)]
pub struct FreeOutlet<T>(Orifice<T>);

impl<T: Real> Law<T> for FreeOutlet<T> {
    fn new(parameters: &[T], fluid: &Fluid<T>) -> Self {
        Self(Orifice::new(parameters, fluid))
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let flow = self.0.flow((seen.z[0] - ATMOSPHERE).max(T::zero()));
        answers.through[0] = flow;
        answers.through[1] = -flow;
    }
}
