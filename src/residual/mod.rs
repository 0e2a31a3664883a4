//! Residuals: what the paper's estimators make of measured flows and pressures.

pub mod estimator;
