//! What kind of quantity a unit measures, as exponents of the base units.

use std::fmt;

/// Exponents of metre, kilogram, second, kelvin and ampere: whole ones, and halves, because the conductance of an orifice
/// is a flow per root of a pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Dimension {
    /// Twice the exponents, so that halves stay exact.
    twice: [i16; 5],
}

const SYMBOLS: [&str; 5] = ["m", "kg", "s", "K", "A"];

impl Dimension {
    /// A pure number, a share or a count of revolutions.
    pub const NONE: Self = Self::new(0, 0, 0, 0, 0);
    /// m: a length; also the area gradient of a valve (mm2/mm).
    pub const LENGTH: Self = Self::new(1, 0, 0, 0, 0);
    /// m2.
    pub const AREA: Self = Self::new(2, 0, 0, 0, 0);
    /// m3: a volume; also the displacement of a pump (cm3/rev).
    pub const VOLUME: Self = Self::new(3, 0, 0, 0, 0);
    /// s.
    pub const TIME: Self = Self::new(0, 0, 1, 0, 0);
    /// 1/s: a frequency; also a rotational speed (rev/min).
    pub const FREQUENCY: Self = Self::new(0, 0, -1, 0, 0);
    /// m/s.
    pub const VELOCITY: Self = Self::new(1, 0, -1, 0, 0);
    /// m/s2.
    pub const ACCELERATION: Self = Self::new(1, 0, -2, 0, 0);
    /// kg.
    pub const MASS: Self = Self::new(0, 1, 0, 0, 0);
    /// kg/m3.
    pub const DENSITY: Self = Self::new(-3, 1, 0, 0, 0);
    /// N.
    pub const FORCE: Self = Self::new(1, 1, -2, 0, 0);
    /// Pa.
    pub const PRESSURE: Self = Self::new(-1, 1, -2, 0, 0);
    /// 1/Pa.
    pub const COMPRESSIBILITY: Self = Self::new(1, -1, 2, 0, 0);
    /// m3/s.
    pub const FLOW: Self = Self::new(3, 0, -1, 0, 0);
    /// m3/s/Pa: the slope of a laminar path (L/min/bar).
    pub const FLOW_PER_PRESSURE: Self = Self::new(4, -1, 1, 0, 0);
    /// m3/Pa: the hydraulic capacity of a volume.
    pub const VOLUME_PER_PRESSURE: Self = Self::new(4, -1, 2, 0, 0);
    /// Pa.s.
    pub const DYNAMIC_VISCOSITY: Self = Self::new(-1, 1, -1, 0, 0);
    /// m2/s.
    pub const KINEMATIC_VISCOSITY: Self = Self::new(2, 0, -1, 0, 0);
    /// N/m.
    pub const STIFFNESS: Self = Self::new(0, 1, -2, 0, 0);
    /// N.s/m: viscous friction of something that slides.
    pub const DAMPING: Self = Self::new(0, 1, -1, 0, 0);
    /// J.
    pub const ENERGY: Self = Self::new(2, 1, -2, 0, 0);
    /// W.
    pub const POWER: Self = Self::new(2, 1, -3, 0, 0);
    /// K.
    pub const TEMPERATURE: Self = Self::new(0, 0, 0, 1, 0);
    /// A.
    pub const CURRENT: Self = Self::new(0, 0, 0, 0, 1);
    /// V.
    pub const VOLTAGE: Self = Self::new(2, 1, -3, 0, -1);

    /// The dimension with these exponents of m, kg, s, K and A.
    pub const fn new(m: i8, kg: i8, s: i8, k: i8, a: i8) -> Self {
        Self { twice: [2 * m as i16, 2 * kg as i16, 2 * s as i16, 2 * k as i16, 2 * a as i16] }
    }

    /// The dimension of a product; exponents beyond the range of an `i16` stop at its ends.
    pub const fn times(self, other: Self) -> Self {
        let mut twice = self.twice;
        let mut i = 0;
        while i < twice.len() {
            twice[i] = twice[i].saturating_add(other.twice[i]);
            i += 1;
        }
        Self { twice }
    }

    /// The dimension of a quotient.
    pub const fn per(self, other: Self) -> Self {
        self.times(other.power(-1))
    }

    /// The dimension of an integer power.
    pub const fn power(self, exponent: i8) -> Self {
        let mut twice = self.twice;
        let mut i = 0;
        while i < twice.len() {
            twice[i] = twice[i].saturating_mul(exponent as i16);
            i += 1;
        }
        Self { twice }
    }

    /// The dimension of the power `numerator / denominator`; `None` where an exponent would be neither whole nor half, or
    /// beyond 100, and where `denominator` is 0.
    ///
    /// ```
    /// use borescope::internals::units::Dimension;
    /// let root = Dimension::PRESSURE.rational_power(1, 2).unwrap();
    /// assert_eq!(root.to_string(), "m^-0.5.kg^0.5.s-1");
    /// assert_eq!(root.rational_power(1, 2), None);
    /// ```
    pub fn rational_power(self, numerator: i32, denominator: i32) -> Option<Self> {
        let mut twice = [0; 5];
        for (new, old) in twice.iter_mut().zip(self.twice) {
            let product = i32::from(old).checked_mul(numerator)?;
            if product.checked_rem(denominator)? != 0 {
                return None;
            }
            *new = i16::try_from(product / denominator).ok().filter(|exponent| exponent.abs() <= 200)?;
        }
        Some(Self { twice })
    }

    /// The name for messages, such as `pressure`; `None` where the dimension has no everyday name.
    pub fn name(self) -> Option<&'static str> {
        NAMES.iter().find(|(dimension, _)| *dimension == self).map(|(_, name)| *name)
    }

    /// Every dimension with an everyday name, pure numbers first.
    pub fn named() -> impl Iterator<Item = (Self, &'static str)> {
        NAMES.into_iter()
    }

    /// The product of base units, such as `m-1.kg.s-2` or `m^0.5`; `-` for a pure number.
    /// [`Unit::parse`](super::Unit::parse) reads it.
    pub fn base_units(self) -> String {
        let factors: Vec<String> = SYMBOLS
            .iter()
            .zip(self.twice)
            .filter(|(_, twice)| *twice != 0)
            .map(|(symbol, twice)| match twice {
                2 => (*symbol).to_owned(),
                _ if twice % 2 == 0 => format!("{symbol}{}", twice / 2),
                _ => format!("{symbol}^{:.1}", f64::from(twice) / 2.0),
            })
            .collect();
        if factors.is_empty() { "-".to_owned() } else { factors.join(".") }
    }
}

/// Writes the everyday name, or the base units where there is none.
impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.pad(name),
            None => f.pad(&self.base_units()),
        }
    }
}

const NAMES: [(Dimension, &str); 25] = [
    (Dimension::NONE, "pure numbers"),
    (Dimension::LENGTH, "length"),
    (Dimension::AREA, "area"),
    (Dimension::VOLUME, "volume"),
    (Dimension::TIME, "time"),
    (Dimension::FREQUENCY, "frequency"),
    (Dimension::VELOCITY, "velocity"),
    (Dimension::ACCELERATION, "acceleration"),
    (Dimension::MASS, "mass"),
    (Dimension::DENSITY, "density"),
    (Dimension::FORCE, "force"),
    (Dimension::PRESSURE, "pressure"),
    (Dimension::COMPRESSIBILITY, "compressibility"),
    (Dimension::FLOW, "flow"),
    (Dimension::FLOW_PER_PRESSURE, "flow per pressure"),
    (Dimension::VOLUME_PER_PRESSURE, "volume per pressure"),
    (Dimension::DYNAMIC_VISCOSITY, "dynamic viscosity"),
    (Dimension::KINEMATIC_VISCOSITY, "kinematic viscosity"),
    (Dimension::STIFFNESS, "stiffness"),
    (Dimension::DAMPING, "damping"),
    (Dimension::ENERGY, "energy"),
    (Dimension::POWER, "power"),
    (Dimension::TEMPERATURE, "temperature"),
    (Dimension::CURRENT, "current"),
    (Dimension::VOLTAGE, "voltage"),
];
