//! Bounded nonlinear least squares and the uncertainty of what it finds.
