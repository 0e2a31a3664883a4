//! Lines along which a profile is searched.

use nalgebra::DVector;

/// How everything moves along a profile, in a coordinate of the distance in which the root of the rise is nearly straight: the distance
/// itself, or a power of that from where a law begins (leak through a gap: the third).
#[derive(Clone)]
pub(super) struct Way {
    /// That of the parameter, its own entry in the coordinate.
    pub direction: DVector<f64>,
    /// 1 upwards, -1 downwards.
    pub sign: f64,
    /// 1 away from where the law begins, -1 towards there.
    outward: f64,
    /// From where the law begins to the best value.
    pub origin: f64,
    /// Where a distance from the beginning is equal to its power.
    unit: f64,
    power: f64,
}

impl Way {
    /// Along a local model, in the distance itself.
    pub fn straight(direction: DVector<f64>, sign: f64) -> Self {
        Self { direction, sign, outward: 1.0, origin: 0.0, unit: 1.0, power: 1.0 }
    }

    /// The same in a power of the distance, equal to it at `unit`.
    pub fn in_power(self, power: f64, unit: f64) -> Self {
        Self { unit, power, ..self }
    }

    /// The same line towards its beginning.
    pub fn back(&self) -> Self {
        Self { sign: -self.sign, outward: -self.outward, ..self.clone() }
    }

    /// The power of a distance from the beginning.
    fn raised(&self, distance: f64) -> f64 {
        self.unit * (distance.max(0.0) / self.unit).powf(self.power)
    }

    pub fn coordinate(&self, distance: f64) -> f64 {
        self.outward * (self.raised(self.origin + self.outward * distance) - self.raised(self.origin))
    }

    pub fn distance(&self, coordinate: f64) -> f64 {
        let raised = (self.raised(self.origin) + self.outward * coordinate).max(0.0);
        self.outward * (self.unit * (raised / self.unit).powf(self.power.recip()) - self.origin)
    }

    /// By how much the coordinate grows with the distance, at the best value.
    pub fn steepness(&self) -> f64 {
        self.power * (self.origin / self.unit).powf(self.power - 1.0)
    }
}
