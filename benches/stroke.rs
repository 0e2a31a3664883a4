//! Times the benchmark stroke of `fixtures/bench`, alone and with sensitivities: `cargo bench --bench stroke`.

#[path = "../fixtures/bench/derived.rs"]
mod derived;
#[path = "../fixtures/bench/stroke.rs"]
mod stroke;
mod timing;

use std::hint::black_box;

use borescope::internals::numeric::{Dual, Options, Real, Rosenbrock, System};
use derived::tangents;
use stroke::{N, POINTS, START, Stroke, options, reference, rms_error, run};
use timing::{Timed, line, time};

fn plain(options: Options<N>, runs: usize) {
    let mut solution = vec![[0.0; N]; POINTS];
    let mut stats = Rosenbrock::new(options).stats();
    let timed = time(runs, || {
        let mut integrator = Rosenbrock::new(options);
        let mut stroke = Stroke::new(black_box([1.0; 6]));
        run(&mut integrator, &mut stroke, |i, y| solution[i] = y).expect("integrates");
        stats = integrator.stats();
    });
    let error = rms_error(&solution, &reference());
    let what = match options.rtol {
        1e-6 => "one stroke".to_owned(),
        rtol => format!("one stroke at rtol {rtol:.0e}"),
    };
    line(&what, "borescope", timed, &format!("{error:.1e}, {} + {} steps", stats.steps, stats.rejected));
}

fn sensitivities<const P: usize>(runs: usize) {
    let mut solution = [[Dual::<f64, P>::zero(); N]; POINTS];
    let timed = time(runs, || {
        let mut integrator = Rosenbrock::new(options());
        let q = std::array::from_fn(|i| Dual::variable(black_box(1.0), i));
        run(&mut integrator, &mut Stroke::new(q), |i, y| solution[i] = y).expect("integrates");
    });
    let values: Vec<[f64; N]> = solution.iter().map(|y| y.map(Real::re)).collect();
    line(&format!("{P} sensitivities"), "borescope", timed, &format!("{:.1e}", rms_error(&values, &reference())));
}

fn led<const P: usize, const V: usize>(runs: usize) {
    let mut solution = [[[0.0; P]; N]; POINTS];
    let timed = time(runs, || {
        tangents::<P, V>(options(), |point, state, slopes| solution[point][state].copy_from_slice(slopes))
            .expect("integrates");
    });
    line(&format!("{P} sensitivities, led along"), "borescope", timed, "");
}

fn pieces() {
    let mut stroke = Stroke::new(black_box([1.0; 6]));
    let mut y = START;
    (y[4], y[7]) = (0.05, 0.9);
    let mut f = [0.0; N];
    let mut j = [[0.0; N]; N];
    let rounds = 100_000;
    let derivative = time(11, || {
        for _ in 0..rounds {
            stroke.derivative(0.0, black_box(&y), &mut f);
            black_box(&f);
        }
    });
    let jacobian = time(11, || {
        for _ in 0..rounds {
            stroke.jacobian(0.0, black_box(&y), &mut j, &mut f);
            black_box(&j);
        }
    });
    let each =
        |timed: Timed| Timed { least: timed.least / f64::from(rounds), median: timed.median / f64::from(rounds) };
    line("right-hand side", "borescope", each(derivative), "");
    line("Jacobian", "borescope", each(jacobian), "");
}

fn main() {
    pieces();
    plain(options(), 301);
    for rtol in [1e-4, 1e-5, 1e-7, 1e-8] {
        plain(Options::uniform(rtol, rtol * 1e-2), 31);
    }
    sensitivities::<1>(101);
    sensitivities::<3>(101);
    sensitivities::<6>(101);
    led::<3, { N + 3 }>(101);
    led::<6, { N + 6 }>(101);
}
