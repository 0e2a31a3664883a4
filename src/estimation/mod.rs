//! Estimation: bounded nonlinear least squares, what its result is worth, and which of several models to believe.
//!
//! Everything here minimises `2 F(theta) = sum rho(r_k(theta)^2) + |W (theta - mean)|^2` inside a box. `r` is the *misfit*:
//! model minus measurement, divided by the standard deviation of the sensor, so it has no unit; the second term is what is
//! known before the record. Nothing here knows what the model is: a [`Problem`] is all it sees.
//!
//! | module | question it answers |
//! |---|---|
//! | [`problem`] | what is to be fitted |
//! | [`loss`] | how much an outlier may pull |
//! | [`prior`] | what is known before the record |
//! | [`local_model`] | what the cost looks like around one point, for every subset of parameters at once |
//! | [`descent`] | where is the optimum from here, and which inequality ended the search |
//! | [`schur`] | what is left for some parameters when all others follow them |
//! | [`score`] | what would a change that the model does not have explain |
//! | [`profile`] | which interval do the data allow, and is it open at an end |
//! | `uncertainty` | how well is it known, if misfits resemble their neighbours too; why is a figure missing |
//! | [`pattern`] | where is the optimum of what has no sensitivities |
//! | [`criteria`] | is one more parameter worth what it explains |

mod autocorrelation;
mod bounded_step;
pub mod criteria;
pub mod descent;
mod error;
mod fit;
pub mod local_model;
pub mod loss;
mod options;
mod parabola;
pub mod pattern;
pub mod prior;
pub mod problem;
pub mod profile;
pub mod schur;
pub mod score;
mod stopped;
#[cfg(test)]
mod tests;
mod triangle;
#[cfg(feature = "internals")]
pub mod uncertainty;

pub use autocorrelation::long_run_variance;
pub use descent::{fit, fit_along};
pub use error::{FitError, NotFinite};
pub use fit::{Bound, Fit};
pub use local_model::{LocalModel, Part, Series, Shared};
pub use loss::Loss;
pub use options::Options;
pub use prior::Gaussian;
pub use problem::{Held, Linearised, Problem};
pub use profile::{End, Identifiable, Interval, ProfilePoint, Side, interval, interval_from_bound};
pub use schur::SchurComplement;
pub use score::{EstimatedAt, Score, ScoreTest};
pub use stopped::StoppedBecause;
#[cfg(feature = "internals")]
pub use uncertainty::{Missing, Noise, Uncertainty, UncertaintyOptions};
