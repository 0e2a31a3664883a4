//! The fluid: density, viscosity and bulk modulus, each a function of pressure so that effects can bend it.

use crate::numeric::Real;
use crate::physics::ATMOSPHERE;
use crate::physics::card::{Card, Parameter};

pub const CARD: Card = Card {
    kind: "fluid",
    meaning: "The one fluid of the rig.",
    law: "rho, mu, beta constant;  1/beta_eff = 1/beta + alpha p_0/p²",
    source: "any data sheet; ISO 3448 for the viscosity class",
    validity: "One temperature; air isothermal and undissolved.",
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
        Parameter::required("air_fraction", "alpha", "%", "free air at atmospheric pressure per volume of oil")
            .or(0.0)
            .within(0.0, 50.0),
    ],
    ..Card::EMPTY
};

/// Fluid properties in SI.
#[derive(Debug, Clone, Copy)]
pub struct Fluid<T> {
    density: T,
    viscosity: T,
    bulk_modulus: T,
    /// Volume of air per volume of oil at atmospheric pressure, times that pressure, Pa.
    air: T,
}

impl<T: Real> Fluid<T> {
    /// From the parameters in the order of [`CARD`], SI.
    pub fn new(parameters: &[T]) -> Self {
        Self {
            density: parameters[0],
            viscosity: parameters[1],
            bulk_modulus: parameters[2],
            air: parameters[3] * ATMOSPHERE,
        }
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
    pub fn bulk_modulus(&self, pressure: T) -> T {
        if self.air.is_zero() {
            return self.bulk_modulus;
        }
        // Oil that is pulled below a tenth of the atmosphere boils instead.
        let pressure = pressure.max(T::constant(0.1 * ATMOSPHERE));
        self.bulk_modulus / (T::one() + self.bulk_modulus * self.air / (pressure * pressure))
    }
}
