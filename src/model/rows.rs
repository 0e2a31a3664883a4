//! The rows of a cycle.

use crate::rig::{Cycle, Hold, Rig};

/// The times of the rows of a cycle, s: one interval apart, up to its end.
///
/// Where an input says what acted before a row, the first row stands one interval after the start; otherwise at it, since
/// a record begins with its first row.
pub fn cycle_times(rig: &Rig, cycle: &Cycle) -> Vec<f64> {
    let first = usize::from(rig.inputs.iter().any(|input| input.hold == Hold::Before));
    let mut times = Vec::new();
    for row in first.. {
        // Twelve digits, so that 3 * 0.004 is 0.012.
        let time = row as f64 * cycle.interval;
        let time = format!("{time:.11e}").parse().unwrap_or(time);
        // Half an interval beyond the end would be a row; a rounding error beyond it is the end.
        if time > cycle.duration() + 1e-6 * cycle.interval {
            return times;
        }
        times.push(time);
    }
    times
}
