//! ode_solvers: Dormand and Prince, explicit, so that it must follow the fastest eigenvalue.

use nalgebra::SVector;
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dopri5, System as Explicit};

use crate::numeric::System;
use crate::stroke::{N, POINTS, START, Stroke, reference, rms_error};
use crate::timing::{line, time};
use crate::{ATOL, RTOL, Solution, pieces};

struct Piece(f64);

impl Explicit<f64, SVector<f64, N>> for Piece {
    fn system(&self, t: f64, y: &SVector<f64, N>, f: &mut SVector<f64, N>) {
        let mut stroke = Stroke::new([1.0; 6]);
        stroke.u = self.0;
        let mut out = [0.0; N];
        stroke.derivative(t, &(*y).into(), &mut out);
        *f = out.into();
    }
}

/// The states on points 1 ms apart; its own test for stiffness, which would give up here, is put off for ever.
fn integrate(u: f64, from: f64, to: f64, start: [f64; N], output: OutputType) -> Solution {
    let (safety, beta, least, most, first) = (0.9, 0.04, 0.2, 10.0, 0.0);
    let mut solver = Dopri5::from_param(
        Piece(u),
        from,
        to,
        1e-3,
        start.into(),
        RTOL,
        ATOL,
        safety,
        beta,
        least,
        most,
        to - from,
        first,
        u32::MAX,
        u32::MAX,
        output,
    );
    solver.integrate().expect("solved");
    solver.y_out().iter().map(|y| (*y).into()).collect()
}

fn solve() -> Solution {
    let mut solution = Solution::new();
    for (u, times) in pieces() {
        let start = solution.pop().unwrap_or(START);
        let (from, before, to) = (times[0], times[times.len() - 2], times[times.len() - 1]);
        let dense = integrate(u, from, to, start, OutputType::Dense);
        // Its last dense point can be wrong, so the last millisecond is taken again without.
        solution.extend(&dense[..times.len() - 1]);
        let last = integrate(u, before, to, dense[times.len() - 2], OutputType::Sparse);
        solution.extend(last.last());
    }
    assert_eq!(solution.len(), POINTS, "every output point is there");
    solution
}

pub fn run() {
    let timed = time(5, || {
        solve();
    });
    line("one stroke", "ode_solvers Dopri5", timed, &format!("{:.1e}", rms_error(&solve(), &reference())));
}
