//! Dual numbers and the stiff integrator.
//!
//! - [`Real`]: the number type that laws are written over; [`f64`] or a dual number.
//! - [`Dual`]: values with derivatives, nestable; [`jacobian`] differentiates one function on the spot.
//! - [`Rosenbrock`]: the stiff integrator Rodas5P over `f64`, or over `Dual<f64, P>` for sensitivities to `P` parameters.
//! - [`Tangents`]: the same sensitivities for many parameters, led along a plain run.
//!
//! Nothing here knows a unit: times are called seconds throughout, states are what the caller makes them.

mod dual;
mod real;
mod rosenbrock;
mod wide;

/// Most states that the integrator is compiled for.
pub const MOST_STATES: usize = 24;

pub use dual::{Dual, jacobian};
pub use real::Real;
pub use rosenbrock::{
    Arrival, Curved, Entry, IntegrationError, Inverse, Options, Rosenbrock, Scalar, Stats, Step, System, Tangents,
};
