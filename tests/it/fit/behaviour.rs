//! What the fit promises, on models whose answer is known in closed form.

use crate::support::curve;

use borescope::internals::estimation::*;
use curve::*;

#[test]
fn a_bound_that_is_active_shifts_the_other_parameter_to_its_conditional_optimum() {
    let x = grid(21, 1.0);
    let y: Vec<f64> = x.iter().map(|x| 1.0 + 3.0 * x).collect();
    let problem = curve(line, x, y, vec![OPEN, (0.0, 2.0)]);
    let found = fit(&problem, &[0.0, 0.5], Loss::None, Options::default()).unwrap();
    assert_eq!(found.at_bound, vec![None, Some(Bound::Upper)]);
    approx::assert_relative_eq!(found.theta[0], 1.5, max_relative = 1e-6);
    assert!(found.stopped.converged(), "{}", found.stopped);
    let known = uncertainty(&found, &UncertaintyOptions::default());
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
    let found = fit(&problem, &[0.0, 0.0, 0.0], Loss::None, Options::default()).unwrap();
    approx::assert_relative_eq!(found.theta[1], 3.0, max_relative = 1e-6);
    assert!(found.theta[2] < 1e-3, "{:?}", found.theta);
    let interval = profile(&problem, &found, 2, 1.0).0;
    assert_eq!(interval.identifiable(), Identifiable::UpperBoundOnly);
    assert!(interval.upper.end.unwrap() > 0.3, "{interval:?}");
}

#[test]
fn a_failing_trial_is_a_rejected_step_and_a_failing_start_an_error() {
    let x = grid(31, 3.0);
    let y: Vec<f64> = x.iter().map(|x| 2.0 * (-1.5 * x).exp()).collect();
    let mut problem = curve(|x, t| t[0] * (-t[1] * x).exp(), x, y, vec![OPEN, OPEN]);
    problem.fails = |t| t[1] > 1.6 || t[0] > 2.2;
    let found = fit(&problem, &[0.2, 0.1], Loss::None, Options::default()).unwrap();
    approx::assert_relative_eq!(found.theta[1], 1.5, max_relative = 1e-6);
    assert!(matches!(fit(&problem, &[0.2, 9.0], Loss::None, Options::default()), Err(FitError::Start { .. })));
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
    let plain = fit(&problem, &[0.0, 0.0], Loss::None, Options::default()).unwrap();
    assert!((plain.theta[0] - 1.0).abs() > 0.5);
    for loss in [Loss::Huber { k: 1.5 }, Loss::SoftL1 { k: 1.0 }, Loss::Cauchy { k: 2.0 }] {
        let robust = fit(&problem, &plain.theta, loss, Options::default()).unwrap();
        assert!((robust.theta[0] - 1.0).abs() < 0.1, "{loss:?} {:?}", robust.theta);
        assert!((robust.theta[1] - 2.0).abs() < 0.15, "{loss:?} {:?}", robust.theta);
        assert!(robust.iterations < 40, "{loss:?} {}", robust.iterations);
    }
}

#[test]
fn a_sensitivity_that_is_not_finite_stops_the_fit_with_its_name() {
    let x = grid(21, 1.0);
    let y: Vec<f64> = x.iter().map(|x| 1.0 + 3.0 * x).collect();
    // The root of nothing has no slope.
    struct Rooted(Vec<f64>, Vec<f64>, Vec<(f64, f64)>);
    impl Problem for Rooted {
        type Error = Broken;
        fn bounds(&self) -> &[(f64, f64)] {
            &self.2
        }
        fn misfit(&self, t: &[f64]) -> Result<Vec<f64>, Broken> {
            Ok(self.0.iter().zip(&self.1).map(|(x, y)| t[0] * x + t[1].sqrt() - y).collect())
        }
        fn linearise(&self, t: &[f64]) -> Result<Linearised, Broken> {
            let slope = 0.5 / t[1].sqrt();
            let jacobian = nalgebra::DMatrix::from_fn(self.0.len(), 2, |i, j| if j == 0 { self.0[i] } else { slope });
            Ok(Linearised { misfit: self.misfit(t)?, jacobian })
        }
        fn scale(&self) -> Vec<f64> {
            vec![1.0; 2]
        }
        fn name(&self, parameter: usize) -> String {
            ["slope", "leak.area"][parameter].to_owned()
        }
    }
    let problem = Rooted(x, y, vec![OPEN, (0.0, 5.0)]);
    let error = fit(&problem, &[0.0, 0.0], Loss::None, Options::default()).unwrap_err();
    assert_eq!(error.to_string(), "the sensitivity to leak.area is not finite");
    let found = fit(&problem, &[0.0, 0.5], Loss::None, Options::default()).unwrap();
    approx::assert_relative_eq!(found.theta[1], 1.0, max_relative = 1e-6);
}
