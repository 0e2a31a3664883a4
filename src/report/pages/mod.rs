//! Pages with pictures, one file for each verb that finds something.

pub mod calibration;
pub mod campaign;
pub mod diagnosis;
pub mod effects;
pub mod fleet;
#[cfg(feature = "store")]
pub mod history;
pub mod improvement;
pub mod isolability;
pub mod learn;
pub mod suggestion;

mod bars;
mod channels;
mod misfit;
mod missing;
mod profile;
mod residuals;
mod rivals;
