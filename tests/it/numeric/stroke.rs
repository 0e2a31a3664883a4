//! The benchmark stroke: accuracy against its reference, pinned effort, sensitivities.

#[path = "../../../fixtures/bench/derived.rs"]
mod derived;
use crate::support::stroke;

use borescope::internals::numeric::{Dual, Options, Real, Rosenbrock, Scalar, Stats, System};
use derived::tangents;
use stroke::{END, N, POINTS, SIZE, START, SWITCH, Stroke, options, reference, rms_error, run};

fn solve<S: Scalar>(options: Options<N>, q: [S; 6]) -> (Vec<[S; N]>, Stats) {
    let mut integrator = Rosenbrock::new(options);
    let mut solution = vec![[S::zero(); N]; POINTS];
    run(&mut integrator, &mut Stroke::new(q), |i, y| solution[i] = y).expect("integrates");
    (solution, integrator.stats())
}

#[test]
fn stroke_agrees_with_its_reference() {
    for (rtol, allowed) in [(1e-4, 4e-5), (1e-6, 2.5e-7), (1e-8, 1e-8), (1e-11, 2e-11)] {
        let (solution, stats) = solve(Options::uniform(rtol, rtol * 1e-2), [1.0; 6]);
        let error = rms_error(&solution, &reference());
        println!("rtol {rtol:e}: rms error {error:.2e}, {stats:?}");
        assert!(error < allowed, "{error}");
    }
}

#[test]
fn effort_is_pinned() {
    let (_, stats) = solve(options(), [1.0; 6]);
    let pinned = Stats { steps: 699, rejected: 97, derivatives: 6271, jacobians: 699, factorisations: 796 };
    assert_eq!(stats, pinned);
}

/// Ends of all steps of the stroke.
fn steps<S: Scalar>(q: [S; 6]) -> Vec<(f64, [f64; N])> {
    let mut integrator = Rosenbrock::new(options());
    let mut stroke = Stroke::new(q);
    let mut y = START.map(S::constant);
    let mut ends = Vec::new();
    for (u, t0, t1) in [(0.0, 0.0, SWITCH), (1.0, SWITCH, END)] {
        stroke.u = u;
        integrator.restart();
        y = integrator
            .integrate(&mut stroke, t0, &y, t1, |step| ends.push((step.t_end, step.y1.map(Real::re))))
            .expect("integrates");
    }
    ends
}

#[test]
fn dual_run_takes_the_same_steps_to_the_last_bit() {
    let plain = steps([1.0; 6]);
    assert_eq!(plain, steps(std::array::from_fn(|i| Dual::<f64, 3>::variable(1.0, i))));
    assert_eq!(plain, steps(std::array::from_fn(|i| Dual::<f64, 6>::variable(1.0, i))));
}

#[test]
fn sensitivities_are_differences_of_tight_solutions() {
    let q = std::array::from_fn(|i| Dual::<f64, 6>::variable(1.0, i));
    // The circuit has kinks that nobody announces to the integrator; they, not the order, bound what sensitivities reach.
    let runs = [(1e-6, 1e-2), (1e-9, 1e-3)].map(|(rtol, allowed)| {
        let (duals, _) = solve(Options::uniform(rtol, rtol * 1e-2), q);
        (rtol, allowed, duals)
    });
    for p in 0..6 {
        // Small, because the shift of the moment at which the end stop is met must stay within the stop's own time scale.
        let h = 1e-6;
        let shifted = |by: f64| {
            let mut q = [1.0; 6];
            q[p] += by;
            solve(Options::uniform(1e-12, 1e-14), q).0
        };
        let (above, below) = (shifted(h), shifted(-h));
        for (rtol, allowed, duals) in &runs {
            let (mut miss, mut size) = (0.0_f64, 0.0_f64);
            for i in 0..POINTS {
                for s in 0..N {
                    let difference = (above[i][s] - below[i][s]) / (2.0 * h);
                    miss += ((duals[i][s].eps[p] - difference) / SIZE[s]).powi(2);
                    size += (difference / SIZE[s]).powi(2);
                }
            }
            let relative = (miss / size).sqrt();
            println!("parameter {p}, rtol {rtol:e}: sensitivities differ by {relative:.1e} of their size");
            assert!(relative < *allowed, "parameter {p}, rtol {rtol:e}: {relative}");
        }
    }
}

#[test]
fn tangents_are_what_dual_numbers_give() {
    let q = std::array::from_fn(|i| Dual::<f64, 6>::variable(1.0, i));
    // Kinks bound both, as above.
    for (rtol, allowed) in [(1e-6, 1e-2), (1e-9, 1e-3)] {
        let options = Options::uniform(rtol, rtol * 1e-2);
        let (duals, _) = solve(options, q);
        let (mut miss, mut size, mut rows) = ([0.0; 6], [0.0; 6], 0);
        tangents::<6, { N + 6 }>(options, |point, state, slopes| {
            rows += 1;
            for (p, slope) in slopes.iter().enumerate() {
                let dual = duals[point][state].eps[p];
                miss[p] += ((slope - dual) / SIZE[state]).powi(2);
                size[p] += (dual / SIZE[state]).powi(2);
            }
        })
        .expect("integrates");
        assert_eq!(rows, POINTS * N);
        for p in 0..6 {
            let relative = (miss[p] / size[p]).sqrt();
            println!("parameter {p}, rtol {rtol:e}: tangents differ from duals by {relative:.1e} of their size");
            assert!(relative < allowed, "parameter {p}, rtol {rtol:e}: {relative}");
        }
    }
}

#[test]
fn jacobian_over_duals_is_that_of_the_derivative() {
    let q: [Dual<f64, 2>; 6] = std::array::from_fn(|i| Dual::variable(1.0, i));
    let mut stroke = Stroke::new(q);
    let y = [10.3, 0.25, 6.0, 5.5, 0.06, 0.04, 0.4, 0.7].map(Dual::constant);
    let mut j = [[Dual::zero(); N]; N];
    stroke.jacobian(0.0, &y, &mut j, &mut [Dual::zero(); N]);
    for column in 0..N {
        let h = 1e-6 * SIZE[column];
        let mut shifted = |by: f64| {
            let mut y = y;
            y[column].re += by;
            let mut f = [Dual::zero(); N];
            stroke.derivative(0.0, &y, &mut f);
            f
        };
        let (above, below) = (shifted(h), shifted(-h));
        for row in 0..N {
            let difference = (above[row] - below[row]) / (2.0 * h);
            let scale = j[row].iter().map(|e| e.re.abs()).fold(1e-9, f64::max);
            let miss = j[row][column] - difference;
            assert!(
                miss.re.abs() < 1e-6 * scale && miss.eps.iter().all(|e| e.abs() < 1e-5 * scale),
                "{row} {column} {miss:?}"
            );
        }
    }
}
