//! Measured series: what a logger wrote.
