//! Components, the fluid, and the laws that they obey, each written once for every number type.
//!
//! Signs: flow into a component's port is positive, a force on the body at a mechanical port acts in the
//! direction of its position. Everything here is SI; pressures are absolute.

pub mod card;
pub mod component;
pub mod drop;
pub mod effect;
pub mod fluid;
pub mod formula;
pub mod law;
pub mod own;
pub mod own_law;
pub mod ports;

/// Standard atmosphere in Pa: what gauge pressures of a rig file and of its sensors are counted from.
pub const ATMOSPHERE: f64 = 101_325.0;
/// Gauge pressure of vacuum, Pa: no liquid falls below it, and no law of this library says what it does there.
pub const VACUUM: f64 = -ATMOSPHERE;

/// Standard gravity in m/s².
pub const GRAVITY: f64 = 9.806_65;
