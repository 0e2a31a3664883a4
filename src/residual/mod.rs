//! Residual generators: what the healthy laws say about measured channels, minus what the channels say themselves.
//!
//! Nothing is simulated and nothing is fitted (analytical redundancy). Each residual is zero on average for the healthy
//! circuit and carries its noise, propagated through the same laws by dual numbers.
//!
//! | id | residual | equation |
//! |---|---|---|
//! | `cylinder.leakage` | `(A1 q2 - A2 q1)/(A1 - A2)`, stored flow taken off; printed: divided by `A1 + A2` | (4) |
//! | `cylinder.flow_A`, `flow_B` | `q1 - A1 v`, `q2 - A2 v`, stored flow taken off | (1) |
//! | `cylinder.force` | sum of forces minus `m a` | - |
//! | `flow_control.flow` | healthy flow at the measured pressures minus actual; printed: constant flow minus actual | (10) |
//! | `directional_valve.leakage` | `q_P - q_A`, or `q_P - q_B` on the way back | (16) |
//! | `directional_valve.consumer`, `supply` | healthy flow of the pressure edge minus consumer or supply flow | (18), (20) |
//! | `directional_valve.return` | healthy flow of the return edge minus the flow that comes back | (14) |
//! | `pump.balance` | pump flow minus relief flow minus what leaves | - |
//! | `relief.state` | the same where the pressure says that the relief valve is shut | - |
//!
//! **Why (4) is divided by `A1 - A2`.** With the leak from the big to the rod side, `q1 = A1 v + ql` and `q2 = A2 v + ql`,
//! so `A1 q2 - A2 q1 = (A1 - A2) ql`. Divided by `A1 + A2` as printed, a cylinder of 40 mm bore and 20 mm rod shows
//! `(1 - 3/4)/(1 + 3/4) = 1/7` of its leakage.
//!
//! **Windows.** Orifice laws bend: at 0.5 bar over a throttle and 0.35 bar of noise a single sample tells little and is
//! biased. So channels are averaged over windows first and the law is evaluated at the means; what curvature is left is
//! corrected to second order. Windows do not overlap, so the values tested are independent (decimation).

mod balance;
mod cusum;
mod detect;
mod ensemble;
#[cfg(feature = "internals")]
pub mod estimator;
mod find;
mod form;
mod frame;
mod generator;
mod known;
mod monitor;
mod reading;
mod signature;
mod view;

pub use cusum::Direction;
#[cfg(feature = "internals")]
pub use cusum::{first_alarm, run_length, threshold};
#[cfg(feature = "cli")]
pub use detect::Evaluated;
pub use detect::{Detection, ResidualReport, detect};
#[cfg(feature = "cli")]
pub use find::generators;
pub(crate) use frame::settling;
pub use frame::{Shows, straight};
#[cfg(feature = "cli")]
pub use generator::Gate;
#[cfg(feature = "internals")]
pub use generator::{Generator, Series, Variant};
pub use monitor::{Block, Fired, Monitor};
#[cfg(feature = "internals")]
pub use reading::{Reading, Source};
pub use signature::{Sensitivity, Signature, signatures};
