//! Times the benchmark stroke of `fixtures/bench`, alone and with sensitivities: `cargo bench --bench stroke`.

#[path = "../fixtures/bench/stroke.rs"]
mod stroke;

use std::hint::black_box;
use std::time::Instant;

use borescope::numeric::{Dual, Options, Real, Rosenbrock, System};
use stroke::{N, POINTS, START, Stroke, options, reference, rms_error, run};

/// Median and minimum time of `runs` runs (ms).
fn time(runs: usize, mut f: impl FnMut()) -> (f64, f64) {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let start = Instant::now();
            f();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[runs / 2], times[0])
}

fn plain(options: Options<N>, runs: usize) {
    let mut solution = vec![[0.0; N]; POINTS];
    let mut stats = Rosenbrock::new(options).stats();
    let (median, minimum) = time(runs, || {
        let mut integrator = Rosenbrock::new(options);
        let mut stroke = Stroke::new(black_box([1.0; 6]));
        run(&mut integrator, &mut stroke, |i, y| solution[i] = y).expect("integrates");
        stats = integrator.stats();
    });
    let error = rms_error(&solution, &reference());
    println!(
        "rtol {:.0e}: median {median:.3} ms, minimum {minimum:.3} ms, rms error {error:.2e}, {} + {} steps",
        options.rtol, stats.steps, stats.rejected
    );
}

fn sensitivities<const P: usize>(runs: usize) {
    let mut solution = [[Dual::<f64, P>::zero(); N]; POINTS].to_vec();
    let (median, minimum) = time(runs, || {
        let mut integrator = Rosenbrock::new(options());
        let q = std::array::from_fn(|i| Dual::variable(black_box(1.0), i));
        run(&mut integrator, &mut Stroke::new(q), |i, y| solution[i] = y).expect("integrates");
    });
    println!("{P} sensitivities: median {median:.3} ms, minimum {minimum:.3} ms");
}

fn pieces() {
    let mut stroke = Stroke::new(black_box([1.0; 6]));
    let mut y = START;
    (y[4], y[7]) = (0.05, 0.9);
    let mut f = [0.0; N];
    let mut j = [[0.0; N]; N];
    let rounds = 100_000;
    let (derivative, _) = time(11, || {
        for _ in 0..rounds {
            stroke.derivative(0.0, black_box(&y), &mut f);
            black_box(&f);
        }
    });
    let (jacobian, _) = time(11, || {
        for _ in 0..rounds {
            stroke.jacobian(0.0, black_box(&y), &mut j, &mut f);
            black_box(&j);
        }
    });
    let ns = 1e6 / f64::from(rounds);
    println!("derivative {:.0} ns, Jacobian {:.0} ns", derivative * ns, jacobian * ns);
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
}
