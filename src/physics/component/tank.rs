//! Tank: a boundary of constant pressure.

use super::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::numeric::Real;
use crate::physics::card::{Card, Parameter, Port};
use crate::physics::fluid::Fluid;
use crate::physics::ports::{Law, PortFlows, PortVariables};

pub const FACTS: Facts =
    Facts { symbol: Symbol::Hidden, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::AtOnce };

pub const CARD: Card = Card {
    kind: "tank",
    meaning: "Tank of constant pressure, the end of every return line.",
    law: "p = const",
    source: "boundary condition",
    validity: "A tank whose level does not matter; see `reservoir` for one whose level does.",
    parameters: &[Parameter::required("pressure", "p", "bar", "gauge pressure in the tank")
        .or(0.0)
        .within(-1.0, f64::INFINITY)],
    ports: &[Port::hydraulic("T", "to the tank")],
    fixes_pressure: Some(0),
    ..Card::EMPTY
};

/// Has no law of its own: the node it sits on keeps its pressure.
#[derive(Debug, Clone, Copy)]
pub struct Tank<T> {
    nothing: std::marker::PhantomData<T>,
}

impl<T: Real> Law<T> for Tank<T> {
    fn new(_parameters: &[T], _fluid: &Fluid<T>) -> Self {
        Self { nothing: std::marker::PhantomData }
    }
    fn evaluate(&self, _seen: &PortVariables<T>, _answers: &mut PortFlows<T>) {}
}
