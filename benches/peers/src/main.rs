//! Times other solvers of Rust on the benchmark stroke, beside the one of borescope: `benches/run`.

// The equations of the fixture name borescope, of which only the numbers are needed here.
extern crate self as borescope;

#[allow(dead_code, unused_imports)]
#[path = "../../../src/numeric/mod.rs"]
pub mod numeric;
mod internals {
    pub use crate::numeric;
}
#[allow(dead_code)]
#[path = "../../../fixtures/bench/stroke.rs"]
mod stroke;
#[path = "../../timing.rs"]
mod timing;

mod explicit;
mod implicit;

use stroke::{N, POINTS};

/// The solution on all output points.
type Solution = Vec<[f64; N]>;

const RTOL: f64 = 1e-6;
const ATOL: f64 = 1e-8;

/// The command and the output points of both pieces of the stroke; the point at the switch belongs to the first.
fn pieces() -> [(f64, Vec<f64>); 2] {
    let at = |i: usize| i as f64 * 1e-3;
    let switch = (stroke::SWITCH * 1e3).round() as usize;
    [(0.0, (0..=switch).map(at).collect()), (1.0, (switch..POINTS).map(at).collect())]
}

fn main() {
    implicit::run();
    explicit::run();
}
