//! A mildly stiff circuit, by the stiff integrator and by an independent explicit one.
//!
//! `ode_solvers` 0.6.2 with dense output can return a wrong last point as good when the last step is shorter than the
//! output interval; its sparse output, used here, is right.

use borescope::internals::numeric::{Dual, Options, Real, Rosenbrock, System, jacobian};
use ode_solvers::dop_shared::{OutputType, System as ExplicitSystem};
use ode_solvers::{Dopri5, SVector};

/// An accumulator-like volume fed by a constant flow, an orifice into a cylinder chamber, and a mass on a spring:
/// state (p1, p2, x, v) in MPa, MPa, m, m/s.
fn circuit<T: Real>([p1, p2, x, v]: [T; 4]) -> [T; 4] {
    let d = p1 - p2;
    let q = d / (d * d + 1e-2).sqrt().sqrt() * 1e-4;
    [
        (-q + 1e-4) * (1400.0 / 1e-3),
        (q - v * 1e-3) * 1400.0 / (x * 1e-3 + 2e-4),
        v,
        (p2 * 1e3 - x * 2e4 - v * 3e3) / 40.0,
    ]
}

struct Circuit;

impl System<f64, 4> for Circuit {
    fn derivative(&mut self, _: f64, y: &[f64; 4], f: &mut [f64; 4]) {
        *f = circuit(*y);
    }
    fn jacobian(&mut self, _: f64, y: &[f64; 4], j: &mut [[f64; 4]; 4], _: &mut [f64; 4]) {
        *j = jacobian::<f64, 4, 4>(y, circuit::<Dual<f64, 4>>).1;
    }
}

impl ExplicitSystem<f64, SVector<f64, 4>> for Circuit {
    fn system(&self, _: f64, y: &SVector<f64, 4>, dy: &mut SVector<f64, 4>) {
        *dy = circuit([y[0], y[1], y[2], y[3]]).into();
    }
}

#[test]
fn agrees_with_dopri5() {
    let start = [2.0, 0.5, 0.0, 0.0];
    let mut integrator = Rosenbrock::new(Options::uniform(1e-10, 1e-12));
    let stiff = integrator.integrate(&mut Circuit, 0.0, &start, 1.0, |_| {}).expect("integrates");

    let mut explicit = Dopri5::new(Circuit, 0.0, 1.0, 0.1, start.into(), 1e-11, 1e-13);
    explicit.set_output(OutputType::Sparse);
    let effort = explicit.integrate().expect("integrates");
    assert_eq!(explicit.x_out().last(), Some(&1.0));
    let other = explicit.y_out().last().expect("an end");
    println!("{:?}; Dopri5: {effort:?}", integrator.stats());
    for (i, value) in stiff.iter().enumerate() {
        println!("state {i}: {value:.12} and {:.12}", other[i]);
        assert!((value - other[i]).abs() < 1e-9 * value.abs().max(1e-2), "state {i}: {value} {}", other[i]);
    }
}
