//! Dual numbers and the stiff integrator.
//!
//! - [`Real`]: the number type that laws are written over; [`f64`] or a dual number.
//! - [`Dual`]: values with derivatives, nestable; [`jacobian`] differentiates one function on the spot.
//! - [`Rosenbrock`]: the stiff integrator Rodas5P over `f64`, or over `Dual<f64, P>` for sensitivities to `P` parameters.
//! - [`dot`]: sums over long series, as least squares and weights need them.
//! - [`Tangents`]: the same sensitivities for many parameters, led along a plain run.
//!
//! Nothing here knows a unit: times are called seconds throughout, states are what the caller makes them.

mod dual;
mod real;
mod rosenbrock;
mod series;
mod wide;

/// Most states that the integrator is compiled for.
pub const MOST_STATES: usize = 100;
/// Largest size of which every number of states up to it has a size of its own nearby: loops run over whole arrays.
pub(crate) const WHOLE: usize = 24;

/// How far loops over arrays of `N` run where so many states are in use: in a small array over all of it, which compiles to wide
/// registers without a remainder.
#[inline(always)]
const fn in_use<const N: usize>(states: usize) -> usize {
    if N > WHOLE { states } else { N }
}

pub use dual::Dual;
#[cfg(feature = "internals")]
pub use dual::jacobian;
pub use real::Real;
pub use rosenbrock::{
    Curved, Elimination, Entry, IntegrationError, Options, Rosenbrock, Scalar, States, Step, System, Tangents,
};
#[cfg(feature = "internals")]
pub use rosenbrock::{Inverse, Stats};
pub(crate) use series::{dot, sum_of_products, take_along};
pub(crate) use wide::wide;
