//! What standard errors and profiles promise, on models whose answer is known in closed form.

use crate::support::curve;

use borescope::internals::estimation::*;
use curve::*;

#[test]
fn tied_parameters_are_named_with_the_slope_between_them() {
    let x = grid(21, 1.0);
    let y: Vec<f64> = x.iter().map(|x| 2.0 + x).collect();
    let model = |x: f64, t: &[f64]| t[0] + 4.0 * t[2] + t[1] * x;
    let problem = curve(model, x, y, vec![OPEN; 3]);
    let found = fit(&problem, &[0.1, 0.1, 0.1], Loss::None, Options::default()).unwrap();
    let known = uncertainty(&found, &UncertaintyOptions { tie: 1e-6, ..UncertaintyOptions::default() });
    let Err(Missing::TiedTo(others)) = &known.standard_error[0] else { panic!("{:?}", known.standard_error) };
    assert_eq!(others.len(), 1);
    assert_eq!(others[0].0, 2);
    approx::assert_relative_eq!(others[0].1, -0.25, max_relative = 1e-5);
    assert!(known.standard_error[1].is_ok());
    let open = profile(&problem, &found, 0, 1.0).0;
    assert_eq!(open.identifiable(), Identifiable::Unidentifiable, "{open:?}");
}

#[test]
fn the_profile_of_a_line_is_its_normal_interval() {
    let x = grid(40, 1.0);
    let mut random = Random::new(11);
    let y: Vec<f64> = x.iter().map(|x| 1.0 + 2.0 * x + 0.2 * random.normal()).collect();
    let mut problem = curve(line, x, y, vec![OPEN, OPEN]);
    problem.sigma = 0.2;
    let found = fit(&problem, &[0.0, 0.0], Loss::None, Options::default()).unwrap();
    let known = uncertainty(&found, &UncertaintyOptions::default());
    for inflation in [1.0, 4.0] {
        for i in 0..2 {
            let (interval, effort) = profile(&problem, &found, i, inflation);
            let half = 1.959_963_985 * known.standard_error[i].clone().unwrap() * inflation.sqrt();
            approx::assert_relative_eq!(interval.lower.end.unwrap(), found.theta[i] - half, epsilon = 1e-3 * half);
            approx::assert_relative_eq!(interval.upper.end.unwrap(), found.theta[i] + half, epsilon = 1e-3 * half);
            assert_eq!(interval.identifiable().to_string(), "bounded");
            assert!(effort[0] <= 6 && effort[1] <= 2, "{effort:?} {interval:?}");
        }
    }
}

#[test]
fn a_saturated_model_bounds_its_parameter_from_below_only() {
    let x = grid(40, 1.0);
    let y: Vec<f64> = x.iter().map(|x| 3.0 * x).collect();
    // A relief valve that never opened: every set pressure above the highest one seen fits equally well.
    let model = |x: f64, t: &[f64]| t[1] * (t[0] * (t[1] * x / t[0]).tanh()).max(0.0) / t[1];
    let mut problem = curve(model, x, y, vec![(0.1, 1000.0), (0.1, 10.0)]);
    problem.sigma = 0.05;
    let found = fit(&problem, &[10.0, 2.0], Loss::None, Options::default()).unwrap();
    let interval = profile(&problem, &found, 0, 1.0).0;
    assert_eq!(interval.identifiable().to_string(), "lower-bound-only", "{interval:?}");
    assert_eq!(interval.upper.why, End::BoundReached);
    let lower = interval.lower.end.unwrap();
    approx::assert_relative_eq!(rise_at(&problem, &found, 0, lower), interval.threshold, max_relative = 0.01);
}

#[test]
fn a_curved_profile_agrees_with_refitting_at_its_ends() {
    let x = grid(25, 4.0);
    let mut random = Random::new(5);
    let truth = |x: f64, t: &[f64]| t[0] * (1.0 - (-t[1] * x).exp()) + t[2] * x;
    let y: Vec<f64> = x.iter().map(|x| truth(*x, &[2.0, 0.8, 0.3]) + 0.1 * random.normal()).collect();
    let mut problem = curve(truth, x, y, vec![(0.0, 50.0), (0.0, 20.0), (-5.0, 5.0)]);
    problem.sigma = 0.1;
    let found = fit(&problem, &[1.0, 1.0, 0.0], Loss::None, Options::default()).unwrap();
    for i in 0..3 {
        let (interval, [evaluations, linearisations]) = profile(&problem, &found, i, 1.0);
        println!("parameter {i}: {:?} {:?} {evaluations} {linearisations}", interval.lower, interval.upper);
        for end in [interval.lower.end, interval.upper.end].into_iter().flatten() {
            let rise = rise_at(&problem, &found, i, end);
            println!("{rise} of {}", interval.threshold);
            approx::assert_relative_eq!(rise, interval.threshold, max_relative = 0.02);
        }
        assert!(linearisations <= 8, "{interval:?}");
    }
}

#[test]
fn a_profile_around_an_unfinished_fit_hands_back_the_better_optimum() {
    let x = grid(30, 1.0);
    let y: Vec<f64> = x.iter().map(|x| 1.0 + 2.0 * x).collect();
    let problem = curve(line, x, y, vec![OPEN, OPEN]);
    let hasty = Options { max_iterations: 0, ..Options::default() };
    let unfinished = fit(&problem, &[0.0, 1.0], Loss::None, hasty).unwrap();
    assert_eq!(unfinished.stopped, StoppedBecause::MaxIterations { iterations: 0 });
    let interval = profile(&problem, &unfinished, 1, 1.0).0;
    assert_eq!(interval.upper.why, End::BetterOptimum, "{interval:?}");
    assert!(interval.better.unwrap().cost < unfinished.cost);
}

#[test]
fn coloured_noise_inflates_the_variance_by_its_known_factor() {
    for (rho, n) in [(0.0, 4000), (0.5, 4000), (0.9, 8000)] {
        let mut mean = 0.0;
        for seed in 0..20 {
            let mut random = Random::new(seed);
            let mut noise = 0.0;
            let y: Vec<f64> = (0..2 * n)
                .map(|t| {
                    let start = t % n == 0; // two series that know nothing of each other
                    let fresh = random.normal();
                    noise = if start { fresh } else { rho * noise + (1.0f64 - rho * rho).sqrt() * fresh };
                    1.0 + noise
                })
                .collect();
            let problem = curve(|_, t| t[0], grid(2 * n, 1.0), y, vec![OPEN]);
            let found = fit(&problem, &[0.0], Loss::None, Options::default()).unwrap();
            let options = UncertaintyOptions { series: vec![0..n, n..2 * n], ..UncertaintyOptions::default() };
            let known = uncertainty(&found, &options);
            mean += known.sandwich[(0, 0)] / known.covariance[(0, 0)] / 20.0;
        }
        let expected = (1.0 + rho) / (1.0 - rho);
        println!("rho {rho}: inflation {mean:.3}, exactly {expected:.3}");
        approx::assert_relative_eq!(mean, expected, max_relative = 0.1);
    }
}

#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    let n = 400;
    let x = grid(n, 4.0);
    let model = |x: f64, t: &[f64]| t[0] * (1.0 - (-t[1] * x).exp());
    let truth = [2.0, 0.7];
    let trials = 300;
    let mut covered = [0; 2];
    let mut naive = [0; 2];
    for seed in 0..trials {
        let mut random = Random::new(1000 + seed);
        let mut noise = 0.0;
        let y: Vec<f64> = x
            .iter()
            .map(|x| {
                noise = 0.6 * noise + 0.8 * random.normal();
                model(*x, &truth) + 0.1 * noise
            })
            .collect();
        let mut problem = curve(model, x.clone(), y, vec![(0.0, 10.0), (0.0, 10.0)]);
        problem.sigma = 0.1;
        let found = fit(&problem, &[1.0, 1.0], Loss::None, Options::default()).unwrap();
        let series: Vec<_> = std::iter::once(0..n).collect();
        let known = uncertainty(&found, &UncertaintyOptions { series, ..UncertaintyOptions::default() });
        for i in 0..2 {
            let inside = |inflation: f64| {
                let (interval, _) = profile(&problem, &found, i, inflation);
                interval.lower.end.unwrap() <= truth[i] && truth[i] <= interval.upper.end.unwrap()
            };
            covered[i] += usize::from(inside(known.inflation[i]));
            naive[i] += usize::from(inside(1.0));
        }
    }
    println!("of {trials}: inflated {covered:?}, white {naive:?}");
    for i in 0..2 {
        let share = covered[i] as f64 / trials as f64;
        assert!((0.91..=0.985).contains(&share), "parameter {i}: {share}");
        assert!((naive[i] as f64) < 0.85 * trials as f64);
    }
}
