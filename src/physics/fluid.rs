//! The fluid: density, viscosity and bulk modulus, each a function of pressure so that effects can bend it.

use crate::numeric::Real;
use crate::physics::card::{Card, Parameter};

pub const CARD: Card = Card {
    kind: "fluid",
    meaning: "The one fluid of the rig.",
    law: "rho, mu, beta constant",
    source: "any data sheet; ISO 3448 for the viscosity class",
    validity: "One temperature, no free air; see the effects for what bends these.",
    parameters: &[
        Parameter::required("density", "rho", "kg/m3", "density at working temperature").positive().or(870.0),
        Parameter::required("viscosity", "mu", "mPa.s", "dynamic viscosity at working temperature")
            .positive()
            .or(45.5)
            .calibrated(0.05),
        Parameter::required("bulk_modulus", "beta", "bar", "effective bulk modulus of fluid and walls")
            .positive()
            .or(14_000.0)
            .uncertain(0.05)
            .calibrated(0.2),
    ],
    ..Card::EMPTY
};

/// Fluid properties in SI.
#[derive(Debug, Clone, Copy)]
pub struct Fluid<T> {
    density: T,
    viscosity: T,
    bulk_modulus: T,
}

impl<T: Real> Fluid<T> {
    /// From the parameters in the order of [`CARD`], SI.
    pub fn new(parameters: &[T]) -> Self {
        Self { density: parameters[0], viscosity: parameters[1], bulk_modulus: parameters[2] }
    }

    /// kg/m³.
    pub fn density(&self) -> T {
        self.density
    }

    /// Dynamic viscosity, Pa·s.
    pub fn viscosity(&self) -> T {
        self.viscosity
    }

    /// Effective bulk modulus, Pa, at an absolute pressure in Pa.
    pub fn bulk_modulus(&self, _pressure: T) -> T {
        self.bulk_modulus
    }
}
