//! Times the fit to the benchmark stroke from 64 starts: `cargo bench --bench fit`.

#[path = "../fixtures/bench/fit.rs"]
mod problem;
#[allow(dead_code)]
#[path = "../fixtures/bench/stroke.rs"]
mod stroke;
mod timing;

use borescope::internals::estimation::{Fit, Loss, Options, fit};
use problem::{Measured, STARTS, is_optimum, random_starts};
use timing::{Timed, line, time};

fn found(measured: &Measured, start: &[f64]) -> Fit {
    fit(measured, start, Loss::None, Options::default()).expect("fitted")
}

fn main() {
    let measured = Measured::read();
    for start in STARTS {
        let fitted = found(&measured, &start);
        let timed = time(7, || {
            found(&measured, &start);
        });
        let remark = format!("cost {:.1}, {} iterations", 0.5 * fitted.cost, fitted.iterations);
        line(&format!("fit from {start:?}"), "borescope", timed, &remark);
    }
    let mut times = Vec::new();
    let mut reached = 0;
    for start in random_starts(64) {
        let fitted = found(&measured, &start);
        reached += usize::from(is_optimum(fitted.cost, &fitted.theta));
        times.push(time(3, || {
            found(&measured, &start);
        }));
    }
    times.sort_by(|a, b| a.least.total_cmp(&b.least));
    let remark = format!("{reached} of 64 reach the optimum");
    line("fit, median of 64 starts", "borescope", times[32], &remark);
    line("fit, worst of 64 starts", "borescope", times[63], &remark);
    let mean = |by: fn(&Timed) -> f64| times.iter().map(by).sum::<f64>() / 64.0;
    line(
        "fit, mean of 64 starts",
        "borescope",
        Timed { least: mean(|t| t.least), median: mean(|t| t.median) },
        &remark,
    );
}
