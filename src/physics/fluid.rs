//! The fluid: density, viscosity and bulk modulus, each a function of pressure so that effects can bend it.

use crate::numeric::Real;
use crate::physics::ATMOSPHERE;
use crate::physics::card::{Card, Parameter, Role};

pub const CARD: Card = Card {
    kind: "fluid",
    meaning: "The one fluid of the rig.",
    law: "rho, beta constant;  mu = mu_ref exp(-k (T - T_ref) - r t);  1/beta_eff = 1/beta + alpha/n (p_0/p)^(1/n) / p",
    source: "any data sheet; ISO 3448 for the viscosity class",
    validity: "One temperature at a time for the whole rig, T within 20 K of T_ref; t from the first row of the record; air undissolved; n is 1 where the oil keeps the bubbles at its temperature, 1.4 where they are too large or the change too quick for that.",
    parameters: &[
        Parameter::required("density", "rho", "kg/m3", "density at working temperature")
            .positive()
            .usually(600.0, 2000.0)
            .or(870.0),
        Parameter::required("viscosity", "mu", "mPa.s", "dynamic viscosity at working temperature")
            .is(Role::Viscosity)
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
        Parameter::required("air_exponent", "n", "-", "polytropic exponent of the free air")
            .is(Role::GasLaw)
            .or(1.0)
            .within(1.0, 1.67),
    ],
    ..Card::EMPTY
};

/// Fluid properties in SI.
#[derive(Debug, Clone, Copy)]
pub struct Fluid<T> {
    density: T,
    viscosity: T,
    bulk_modulus: T,
    /// Volume of air per volume of oil at atmospheric pressure, over the polytropic exponent.
    air: T,
    /// One over the polytropic exponent.
    root: T,
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
            air: parameters[3] / parameters[6],
            root: T::one() / parameters[6],
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
    ///
    /// The air follows `p V^n` constant: `1/beta_eff = 1/beta + alpha/n (p_0/p)^(1/n) / p` (Merritt, 1967, section 1-4, with n = 1).
    /// Worked: 1 % of air in oil of 14 000 bar, at 20 bar absolute: 10 335 bar isothermal, 8 783 bar adiabatic (n = 1.4).
    pub fn bulk_modulus(&self, pressure: T) -> T {
        if self.air.is_zero() {
            return self.bulk_modulus;
        }
        // Oil that is pulled below a tenth of the atmosphere boils instead.
        let pressure = pressure.max(T::constant(0.1 * ATMOSPHERE));
        let expanded = T::constant(ATMOSPHERE) / pressure;
        let isothermal = (self.root - T::one()).is_zero();
        let volume = self.air * if isothermal { expanded } else { (self.root * expanded.ln()).exp() };
        self.bulk_modulus / (T::one() + self.bulk_modulus * volume / pressure)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const BAR: f64 = 1e5;

    fn with_air(exponent: f64) -> Fluid<f64> {
        Fluid::new(&[870.0, 0.0455, 14_000.0 * BAR, 0.01, 0.0, 0.0, exponent])
    }

    #[test]
    fn air_that_keeps_its_heat_is_stiffer_at_its_own_volume_and_larger_at_pressure() {
        for (exponent, expect) in [(1.0, 10_334.868), (1.4, 8_783.240)] {
            assert_relative_eq!(with_air(exponent).bulk_modulus(20.0 * BAR) / BAR, expect, max_relative = 1e-6);
        }
        // At the pressure at which its volume is stated, adiabatic air is the stiffer by its exponent.
        let soft = |exponent: f64| 1.0 / with_air(exponent).bulk_modulus(ATMOSPHERE) - 1.0 / (14_000.0 * BAR);
        assert_relative_eq!(soft(1.0) / soft(1.4), 1.4, max_relative = 1e-12);
    }
}
