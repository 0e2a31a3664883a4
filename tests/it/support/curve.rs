//! Curves with noise, for the tests of the fit.

use std::sync::atomic::{AtomicU64, Ordering};

use borescope::internals::estimation::*;
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub const OPEN: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

#[derive(Debug)]
pub struct Broken;
impl std::fmt::Display for Broken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the integration broke down")
    }
}
impl std::error::Error for Broken {}

/// `y_t = model(x_t, theta)`, derivatives by central differences, with a region in which the model fails.
pub struct Curve<F: Fn(f64, &[f64]) -> f64 + Sync> {
    pub model: F,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub sigma: f64,
    pub bounds: Vec<(f64, f64)>,
    pub fails: fn(&[f64]) -> bool,
    pub evaluations: AtomicU64,
    pub linearisations: AtomicU64,
}

pub fn curve<F: Fn(f64, &[f64]) -> f64 + Sync>(
    model: F,
    x: Vec<f64>,
    y: Vec<f64>,
    bounds: Vec<(f64, f64)>,
) -> Curve<F> {
    Curve {
        model,
        x,
        y,
        sigma: 1.0,
        bounds,
        fails: |_| false,
        evaluations: AtomicU64::new(0),
        linearisations: AtomicU64::new(0),
    }
}

impl<F: Fn(f64, &[f64]) -> f64 + Sync> Problem for Curve<F> {
    type Error = Broken;
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }
    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, Broken> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        if (self.fails)(theta) {
            return Err(Broken);
        }
        Ok(self.x.iter().zip(&self.y).map(|(x, y)| ((self.model)(*x, theta) - y) / self.sigma).collect())
    }
    fn linearise(&self, theta: &[f64]) -> Result<Linearised, Broken> {
        self.linearisations.fetch_add(1, Ordering::Relaxed);
        let misfit = self.misfit(theta)?;
        let mut jacobian = DMatrix::zeros(misfit.len(), theta.len());
        for j in 0..theta.len() {
            let h = 1e-5 * theta[j].abs().max(1e-2);
            let mut moved = theta.to_vec();
            moved[j] = theta[j] + h;
            let above: Vec<f64> = self.x.iter().map(|x| (self.model)(*x, &moved)).collect();
            moved[j] = theta[j] - h;
            for (i, x) in self.x.iter().enumerate() {
                jacobian[(i, j)] = (above[i] - (self.model)(*x, &moved)) / (2.0 * h * self.sigma);
            }
        }
        Ok(Linearised { misfit, jacobian })
    }
    fn scale(&self) -> Vec<f64> {
        vec![1.0; self.bounds.len()]
    }
}

/// The interval of parameter `i` around a fit, and how many calls of misfits (those of linearisations included) and of
/// linearisations it took.
#[allow(dead_code)]
pub fn profile<F: Fn(f64, &[f64]) -> f64 + Sync>(
    problem: &Curve<F>,
    fit: &Fit,
    i: usize,
    inflation: f64,
) -> (Interval, [u64; 2]) {
    let near = fit.model.as_ref().unwrap();
    let direction = near.information(problem).unwrap().direction(i).unwrap();
    let effort = || [&problem.evaluations, &problem.linearisations].map(|count| count.load(Ordering::Relaxed));
    let before = effort();
    let interval = interval(problem, near, fit, i, direction, inflation);
    let after = effort();
    (interval, [after[0] - before[0], after[1] - before[1]])
}

/// Rise of the cost where parameter `i` is held at a value and all others are fitted anew to the end.
#[allow(dead_code)]
pub fn rise_at<P: Problem>(problem: &P, fit: &Fit, i: usize, value: f64) -> f64 {
    let held = borescope::internals::estimation::fit(
        &Held::new(problem, i, value),
        &fit.theta,
        Loss::None,
        Options::default(),
    );
    held.unwrap().cost - fit.cost
}

#[allow(dead_code)]
pub fn uncertainty(fit: &Fit, options: &UncertaintyOptions) -> Uncertainty {
    Uncertainty::at(fit.model.as_ref().unwrap(), &fit.at_bound, options)
}

pub struct Random(ChaCha8Rng);
impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }
    fn unit(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.unit().ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }
}

pub fn grid(n: usize, to: f64) -> Vec<f64> {
    (0..n).map(|i| to * i as f64 / (n - 1) as f64).collect()
}

pub fn line(x: f64, t: &[f64]) -> f64 {
    t[0] + t[1] * x
}
