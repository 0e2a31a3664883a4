//! Dual numbers and the stiff integrator.
