//! The fluid: density, viscosity and bulk modulus, each a function of pressure so that effects can bend it.

use crate::numeric::Real;
use crate::physics::ATMOSPHERE;
use crate::physics::card::{Card, Parameter};

pub const CARD: Card = Card {
    kind: "fluid",
    meaning: "The one fluid of the rig.",
    law: "rho, beta constant;  mu = mu_ref exp(-k (T - T_ref) - r t);  1/beta_eff = 1/beta + alpha p_0/p²",
    source: "any data sheet; ISO 3448 for the viscosity class",
    validity: "One temperature at a time for the whole rig, T within 20 K of T_ref; t from the first row of the record; air isothermal and undissolved.",
    parameters: &[
        Parameter::required("density", "rho", "kg/m3", "density at working temperature")
            .positive()
            .usually(600.0, 2000.0)
            .or(870.0),
        Parameter::required("viscosity", "mu", "mPa.s", "dynamic viscosity at working temperature")
            .positive()
            // Hot water, and the cold oil with which pumps no longer start.
            .usually(0.3, 5000.0)
            .or(45.5)
            .calibrated(0.05),
        Parameter::required("bulk_modulus", "beta", "bar", "effective bulk modulus of fluid and walls")
            .positive()
            .usually(500.0, 40_000.0)
            .or(14_000.0)
            .uncertain(0.05)
            .calibrated(0.2),
        Parameter::required("air_fraction", "alpha", "%", "free air at atmospheric pressure per volume of oil")
            .or(0.0)
            .within(0.0, 50.0),
        Parameter::required("temperature_coefficient", "k", "1/K", "relative loss of viscosity per kelvin")
            .or(0.0)
            .within(-0.2, 0.2),
        Parameter::required(
            "viscosity_drift",
            "r",
            "1/s",
            "relative loss of viscosity per second, where no temperature is measured",
        )
        .or(0.0)
        .within(-1.0, 1.0),
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
    temperature_coefficient: T,
    viscosity_drift: T,
}

impl<T: Real> Fluid<T> {
    /// From the parameters in the order of [`CARD`], SI.
    pub fn new(parameters: &[T]) -> Self {
        Self {
            density: parameters[0],
            viscosity: parameters[1],
            bulk_modulus: parameters[2],
            air: parameters[3] * ATMOSPHERE,
            temperature_coefficient: parameters[4],
            viscosity_drift: parameters[5],
        }
    }

    /// kg/m³.
    pub fn density(&self) -> T {
        self.density
    }

    /// Dynamic viscosity, Pa·s, at the temperature of reference.
    pub fn viscosity(&self) -> T {
        self.viscosity
    }

    /// Viscosity at the temperature of reference over that at a temperature which is `warmer` by so many kelvin, `since` seconds
    /// after the beginning of the record.
    ///
    /// `exp(k (T - T_ref) + r t)`, the exponential law of Reynolds (Merritt, *Hydraulic Control Systems*, 1967, eq. 1-4), good
    /// to a few per cent within 20 K. Worked: 10 K warmer at 0.03 1/K, the oil flows `exp(0.3) = 1.350` times as easily.
    #[inline]
    pub fn fluidity(&self, warmer: T, since: T) -> T {
        if self.temperature_coefficient.is_zero() && self.viscosity_drift.is_zero() {
            return T::one();
        }
        (self.temperature_coefficient * warmer + self.viscosity_drift * since).exp()
    }

    /// Relative slope of the fluidity over time, 1/s, while the temperature rises by `warming` K/s.
    pub fn thinning(&self, warming: f64) -> T {
        self.temperature_coefficient * warming + self.viscosity_drift
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
