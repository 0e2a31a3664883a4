//! What the fit promises, on models whose answer is known in closed form.

use crate::support::curve;

use borescope::fit::*;
use curve::*;

#[test]
fn a_bound_that_is_active_shifts_the_other_parameter_to_its_conditional_optimum() {
    let x = grid(21, 1.0);
    let y: Vec<f64> = x.iter().map(|x| 1.0 + 3.0 * x).collect();
    let problem = curve(line, x, y, vec![OPEN, (0.0, 2.0)]);
    let found = fit(&problem, &[0.0, 0.5], Loss::None, Tolerances::default()).unwrap();
    assert_eq!(found.at_bound, vec![None, Some(Bound::Upper)]);
    approx::assert_relative_eq!(found.theta[0], 1.5, max_relative = 1e-6);
    assert!(found.stopped.converged(), "{}", found.stopped);
    let known = Uncertainty::at(&found, &UncertaintyOptions::default());
    assert_eq!(known.standard_error[1], Err(Missing::AtBound));
    approx::assert_relative_eq!(known.standard_error[0].clone().unwrap(), 1.0 / 21f64.sqrt(), max_relative = 1e-6);
}

#[test]
fn a_parameter_without_influence_does_not_disturb_the_others() {
    let x = grid(21, 1.0);
    let y: Vec<f64> = x.iter().map(|x| 1.0 + 3.0 * x).collect();
    // Leakage grows with the cube of the clearance: at zero it has no slope.
    let model = |x: f64, t: &[f64]| t[0] + t[1] * x + t[2].powi(3).max(0.0) * x * x;
    let mut problem = curve(model, x, y, vec![OPEN, OPEN, (0.0, 1.0)]);
    problem.sigma = 0.1;
    let found = fit(&problem, &[0.0, 0.0, 0.0], Loss::None, Tolerances::default()).unwrap();
    approx::assert_relative_eq!(found.theta[1], 3.0, max_relative = 1e-6);
    assert!(found.theta[2] < 1e-3, "{:?}", found.theta);
    let interval = Profiler::new(&problem, &found).unwrap().interval(2, 0.95, 1.0).unwrap();
    assert_eq!(interval.identifiable, Identifiable::UpperBoundOnly);
    assert!(interval.upper.unwrap() > 0.3, "{interval:?}");
}

#[test]
fn a_failing_trial_is_a_rejected_step_and_a_failing_start_an_error() {
    let x = grid(31, 3.0);
    let y: Vec<f64> = x.iter().map(|x| 2.0 * (-1.5 * x).exp()).collect();
    let mut problem = curve(|x, t| t[0] * (-t[1] * x).exp(), x, y, vec![OPEN, OPEN]);
    problem.fails = |t| t[1] > 1.6 || t[0] > 2.2;
    let found = fit(&problem, &[0.2, 0.1], Loss::None, Tolerances::default()).unwrap();
    approx::assert_relative_eq!(found.theta[1], 1.5, max_relative = 1e-6);
    assert!(matches!(fit(&problem, &[0.2, 9.0], Loss::None, Tolerances::default()), Err(FitError::Start { .. })));
}

#[test]
fn a_robust_loss_ignores_outliers() {
    let x = grid(50, 1.0);
    let mut random = Random::new(3);
    let mut y: Vec<f64> = x.iter().map(|x| 1.0 + 2.0 * x + 0.1 * random.normal()).collect();
    for k in [3, 17, 31, 44] {
        y[k] += 30.0;
    }
    let mut problem = curve(line, x, y, vec![OPEN, OPEN]);
    problem.sigma = 0.1;
    let plain = fit(&problem, &[0.0, 0.0], Loss::None, Tolerances::default()).unwrap();
    assert!((plain.theta[0] - 1.0).abs() > 0.5);
    for loss in [Loss::Huber { k: 1.5 }, Loss::SoftL1 { k: 1.0 }, Loss::Cauchy { k: 2.0 }] {
        let robust = fit(&problem, &plain.theta, loss, Tolerances::default()).unwrap();
        assert!((robust.theta[0] - 1.0).abs() < 0.1, "{loss:?} {:?}", robust.theta);
        assert!((robust.theta[1] - 2.0).abs() < 0.15, "{loss:?} {:?}", robust.theta);
        assert!(robust.iterations < 40, "{loss:?} {}", robust.iterations);
    }
}

#[test]
fn many_starts_find_the_optimum_that_one_misses() {
    let x = grid(60, 6.0);
    let y: Vec<f64> = x.iter().map(|x| (3.0 * x).sin()).collect();
    let mut problem = curve(|x, t| (t[0] * x).sin(), x, y, vec![(0.2, 5.0)]);
    problem.sigma = 0.5;
    let trapped = fit(&problem, &[0.5], Loss::None, Tolerances::default()).unwrap();
    assert!((trapped.theta[0] - 3.0).abs() > 0.3, "{:?}", trapped.theta);
    let all = multi_start(
        &problem,
        &Starts { given: vec![vec![0.5]], sampled: 24, fitted: 4, seed: 1 },
        Loss::None,
        Tolerances::default(),
    )
    .unwrap();
    approx::assert_relative_eq!(all.best.theta[0], 3.0, max_relative = 1e-6);
    assert!(all.reached_best >= 1 && all.optima.len() >= 2, "{:?}", all.optima);
    assert_eq!(all.fitted, 5);
}
