//! Look inside a hydraulic circuit through its records.

pub mod complaint;
pub mod diagnosis;
pub mod files;
pub mod fit;
pub mod model;
pub mod numeric;
pub mod physics;
pub mod record;
pub mod residual;
pub mod rig;
pub mod units;
