//! Hydraulic accumulator.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::ATMOSPHERE;
use crate::physics::card::{Answer, Card, Parameter, Port, Role, Worked};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts = Facts {
    symbol: Symbol::Accumulator,
    residuals: Residuals::None,
    balance: Balance::Stores,
    settles: Settles::AtOnce,
};

pub const CARD: Card = Card {
    kind: "accumulator",
    meaning: "Gas accumulator with bladder or diaphragm; with a precharge of 0 bar, gas that is trapped in a line.",
    law: "C = s V_0 (p_0/p)^(1/n) / (n p),  s = (1 + (p - p_0)/sqrt((p - p_0)² + (p_0/100)²))/2, pressures absolute",
    source: "polytropic change of state; Merritt (1967), section 1-4 for trapped gas",
    validity: "Ideal gas of one exponent: 1 for slow changes, 1.4 for fast ones of nitrogen; no inertia, no loss at the inlet.",
    parameters: &[
        Parameter::required("volume", "V_0", "L", "gas volume at the precharge")
            .is(Role::Volume)
            .positive()
            .calibrated(0.05),
        Parameter::required("precharge", "p_0", "bar", "gauge pressure of the gas while no oil is in")
            .within(0.0, 1000.0)
            .calibrated(0.1),
        Parameter::required("exponent", "n", "-", "polytropic exponent").or(1.2).within(1.0, 1.67),
    ],
    ports: &[Port::hydraulic("P", "where it is joined")],
    worked: &[Worked {
        text: "1 L at 49 bar precharge (50 bar absolute), isothermal, at 100 bar absolute: 5 cm3 per bar",
        parameters: &[("volume", 1.0), ("precharge", 48.98675), ("exponent", 1.0)],
        at: &[100e5],
        inputs: &[],
        answer: Answer::Capacity(0),
        expect: 5e-11,
    }],
    ..Card::EMPTY
};

/// Share of the precharge over which the gas begins to give way.
const BEGIN: f64 = 0.01;

#[derive(Debug, Clone, Copy)]
pub struct Accumulator<T> {
    volume: T,
    /// Absolute, Pa.
    precharge: T,
    exponent: T,
}

impl<T: Real> Law<T> for Accumulator<T> {
    fn new(p: &[T], _fluid: &Fluid<T>) -> Self {
        Self { volume: p[0], precharge: p[1] + ATMOSPHERE, exponent: p[2] }
    }

    #[inline]
    fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        // Oil in a vacuum does not reach the gas.
        let pressure = seen.z[0].max(T::constant(0.01 * ATMOSPHERE));
        let over = pressure - self.precharge;
        let width = self.precharge * BEGIN;
        let given_way = (over / (over * over + width * width).sqrt() + T::one()) * 0.5;
        let ratio = ((self.precharge / pressure).ln() / self.exponent).exp();
        answers.capacity[0] = given_way * self.volume * ratio / (self.exponent * pressure);
    }
}
