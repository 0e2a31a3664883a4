//! Bounded nonlinear least squares and the uncertainty of what it finds.
//!
//! Everything here minimises `F(theta) = 1/2 sum rho(r_k(theta)^2)` inside a box, where `r` is the *misfit*: model minus
//! measurement, divided by the standard deviation of the sensor, so it has no unit. Nothing here knows what the model is;
//! a [`Problem`] is all it sees.
//!
//! | module | question it answers |
//! |---|---|
//! | [`problem`] | what is to be fitted |
//! | [`loss`] | how much an outlier may pull |
//! | [`levenberg_marquardt`] | where is the optimum from here, and which inequality ended the search |
//! | [`starts`] | is it the best optimum in the box |
//! | [`uncertainty`] | how well is it known, if the misfit is coloured too; why is a figure missing |
//! | [`conditional`] | what if some parameters are held, for instance at their healthy value |
//! | [`profile`] | which interval do the data allow, and is it open at an end |

mod active_set;
mod coloured;
pub mod conditional;
mod error;
mod found;
mod here;
pub mod levenberg_marquardt;
pub mod loss;
pub mod problem;
pub mod profile;
pub mod starts;
mod stopped;
mod triangle;
pub mod uncertainty;

pub use coloured::long_run_variance;
pub use conditional::{Conditional, ConditionalFit};
pub use error::FitError;
pub use found::{Bound, Fit};
pub use levenberg_marquardt::{FitState, LevenbergMarquardt, Tolerances, fit};
pub use loss::Loss;
pub use problem::{Linearised, Problem};
pub use profile::{End, Identifiable, Interval, ProfilePoint, Profiler, profile_cost_at};
pub use starts::{MultiStart, Optimum, Starts, multi_start};
pub use stopped::StoppedBecause;
pub use triangle::Triangle;
pub use uncertainty::{Bandwidth, Missing, Noise, Uncertainty, UncertaintyOptions};
