//! diffsol: BDF and ESDIRK34 with the dense matrices of nalgebra, derivatives by the same dual numbers as ours.

use diffsol::{
    Bdf, DenseMatrix, MatrixCommon, NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, SensitivitiesOdeSolverMethod,
};

use crate::numeric::{Dual, Scalar, System};
use crate::stroke::{N, START, Stroke, reference, rms_error};
use crate::timing::{line, time};
use crate::{ATOL, RTOL, Solution, pieces};

type Matrix = NalgebraMat<f64>;
type Lu = NalgebraLU<f64>;

/// The six parameters are the first of `p`, those not named are nominal.
fn derivative<S: Scalar>(y: [S; N], q: [S; 6], u: f64) -> [S; N] {
    let mut stroke = Stroke::new(q);
    stroke.u = u;
    let mut f = [S::zero(); N];
    stroke.derivative(0.0, &y, &mut f);
    f
}

fn states(y: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| y[i])
}

fn parameters(p: &[f64]) -> [f64; 6] {
    std::array::from_fn(|i| p.get(i).copied().unwrap_or(1.0))
}

/// The change of the derivative along `dy` and `dq`.
fn along(y: &[f64], dy: &[f64], p: &[f64], dq: &[f64], u: f64, out: &mut [f64]) {
    let dual = |value: f64, slope: f64| Dual::<f64, 1> { re: value, eps: [slope] };
    let y = std::array::from_fn(|i| dual(y[i], dy.get(i).copied().unwrap_or(0.0)));
    let q = parameters(p);
    let q = std::array::from_fn(|i| dual(q[i], dq.get(i).copied().unwrap_or(0.0)));
    for (out, f) in out.iter_mut().zip(derivative(y, q, u)) {
        *out = f.eps[0];
    }
}

#[derive(Clone, Copy)]
enum Method {
    Bdf,
    Esdirk34,
}

fn plain(method: Method) -> Solution {
    let mut solution = Solution::new();
    for (u, times) in pieces() {
        let start = solution.pop().unwrap_or(START);
        let problem = OdeBuilder::<Matrix>::new()
            .t0(times[0])
            .rtol(RTOL)
            .atol([ATOL; N])
            .rhs_implicit(
                move |y, p, _, f| f.copy_from_slice(&derivative(states(y), parameters(p), u)),
                move |y, p, _, v, f| along(y, v, p, &[], u, f),
            )
            .init(move |_, _, y| y.copy_from_slice(&start), N)
            .build()
            .expect("a problem");
        let solved = match method {
            Method::Bdf => problem.bdf::<Lu>().expect("a solver").solve_dense(&times),
            Method::Esdirk34 => problem.esdirk34::<Lu>().expect("a solver").solve_dense(&times),
        };
        append(&mut solution, &solved.expect("solved").0);
    }
    solution
}

fn append(solution: &mut Solution, piece: &Matrix) {
    solution.extend((0..piece.ncols()).map(|point| std::array::from_fn(|i| piece.get_index(i, point))));
}

/// Sensitivities by the first `P` parameters, outside the error control as ours are.
fn sensitive<const P: usize>() -> (Solution, Vec<Matrix>) {
    let mut solution = Solution::new();
    let mut slopes: Vec<Matrix> = Vec::new();
    for (u, times) in pieces() {
        let start = solution.pop().unwrap_or(START);
        let slope_at_start: [[f64; N]; P] = std::array::from_fn(|p| {
            std::array::from_fn(|i| slopes.get(p).map_or(0.0, |slope| slope.get_index(i, slope.ncols() - 1)))
        });
        let problem = OdeBuilder::<Matrix>::new()
            .t0(times[0])
            .rtol(RTOL)
            .atol([ATOL; N])
            .p([1.0; P])
            .turn_off_sensitivities_error_control()
            .rhs_sens_implicit(
                move |y, p, _, f| f.copy_from_slice(&derivative(states(y), parameters(p), u)),
                move |y, p, _, v, f| along(y, v, p, &[], u, f),
                move |y, p, _, v, f| along(y, &[], p, v, u, f),
            )
            .init_sens(
                move |_, _, y| y.copy_from_slice(&start),
                move |_, _, v, y| {
                    for (i, y) in y.iter_mut().enumerate() {
                        *y = slope_at_start.iter().zip(v).map(|(slope, v)| slope[i] * v).sum();
                    }
                },
                N,
            )
            .build()
            .expect("a problem");
        let mut solver: Bdf<'_, _, Lu, _, _> = problem.bdf_sens().expect("a solver");
        let (values, slopes_here, _) = solver.solve_dense_sensitivities(&times).expect("solved");
        append(&mut solution, &values);
        slopes = slopes_here;
    }
    (solution, slopes)
}

/// The error of the plain run, and how long it takes; then the runs with sensitivities.
pub fn run() {
    for (who, method) in [("diffsol BDF", Method::Bdf), ("diffsol ESDIRK34", Method::Esdirk34)] {
        let timed = time(51, || {
            plain(method);
        });
        let error = rms_error(&plain(method), &reference());
        line("one stroke", who, timed, &format!("{error:.1e}"));
    }
    let timed = time(31, || {
        sensitive::<3>();
    });
    line("3 sensitivities", "diffsol BDF", timed, &format!("{:.1e}", rms_error(&sensitive::<3>().0, &reference())));
    let timed = time(31, || {
        sensitive::<6>();
    });
    line("6 sensitivities", "diffsol BDF", timed, &format!("{:.1e}", rms_error(&sensitive::<6>().0, &reference())));
}
