//! The fit to the benchmark stroke: how many starts reach the optimum, and what it costs.

#[path = "../../../fixtures/bench/fit.rs"]
mod problem;
use crate::support::stroke;

use borescope::internals::estimation::{Fit, Loss, Options, fit};
use problem::{Measured, STARTS, is_optimum, random_starts};

fn found(measured: &Measured, start: &[f64]) -> Fit {
    fit(measured, start, Loss::None, Options::default()).expect("fitted")
}

#[test]
fn the_fit_from_the_published_starts_takes_its_pinned_effort() {
    let measured = Measured::read();
    let effort = STARTS.map(|start| {
        let fitted = found(&measured, &start);
        assert!(is_optimum(fitted.cost, &fitted.theta), "{start:?}: {} at {:?}", fitted.cost, fitted.theta);
        (fitted.misfit_evaluations, fitted.linearisations)
    });
    assert_eq!(effort, [(41, 32), (45, 34), (6, 6)]);
}

#[test]
fn all_of_64_starts_reach_the_optimum() {
    let measured = Measured::read();
    let fits: Vec<Fit> = random_starts(64).iter().map(|start| found(&measured, start)).collect();
    let reached = fits.iter().filter(|fitted| is_optimum(fitted.cost, &fitted.theta)).count();
    let evaluations: u64 = fits.iter().map(|fitted| fitted.misfit_evaluations).sum();
    let linearisations: u64 = fits.iter().map(|fitted| fitted.linearisations).sum();
    assert_eq!((reached, evaluations, linearisations), (64, 1614, 1251));
}
