//! Look inside a hydraulic circuit through its records.

pub mod complaint;
pub mod files;
pub mod fit;
pub mod numeric;
pub mod record;
pub mod units;
