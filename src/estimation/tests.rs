//! Linear problems whose answers are known in closed form.

use std::convert::Infallible;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::Distribution;

use super::local_model::Evaluated;
use super::*;

/// `A theta - y`, with a share of `theta_0^2` in every sample that bends it.
struct Line {
    a: DMatrix<f64>,
    y: DVector<f64>,
    bend: f64,
    bounds: Vec<(f64, f64)>,
    scale: Vec<f64>,
    prior: Gaussian,
}

const OPEN: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

impl Problem for Line {
    type Error = Infallible;
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }
    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, Infallible> {
        let bent = self.bend * theta[0] * theta[0];
        let straight = &self.a * DVector::from_column_slice(theta) - &self.y;
        Ok(straight.iter().map(|r| r + bent).collect())
    }
    fn linearise(&self, theta: &[f64]) -> Result<Linearised, Infallible> {
        let mut jacobian = self.a.clone();
        jacobian.column_mut(0).add_scalar_mut(2.0 * self.bend * theta[0]);
        Ok(Linearised { misfit: self.misfit(theta)?, jacobian })
    }
    fn scale(&self) -> Vec<f64> {
        self.scale.clone()
    }
    fn prior(&self) -> Option<&Gaussian> {
        Some(&self.prior)
    }
}

/// Sixty samples of three parameters of very different size; the last has a prior of 2 +- 0.3.
fn line() -> Line {
    let columns = |i: usize, j: usize| match j {
        0 => 1.0,
        1 => 1e3 * (0.2 * i as f64).sin(),
        _ => 1e-2 * (0.05 * (i * i) as f64).cos(),
    };
    let a = DMatrix::from_fn(60, 3, columns);
    let y = DVector::from_fn(60, |i, _| 3.0 + (1.7 * i as f64).sin() + 5.0 * (0.2 * i as f64).sin());
    let prior = Gaussian::new(vec![2], vec![2.0], &DMatrix::from_element(1, 1, 0.09));
    Line { a, y, bend: 0.0, bounds: vec![OPEN; 3], scale: vec![1.0, 1e-3, 10.0], prior }
}

/// `2 F` of the best values of the parameters that the bounds leave free, by normal equations in numbers of order one.
fn least(line: &Line) -> f64 {
    least_of(line, 3)
}

fn least_of(line: &Line, parameters: usize) -> f64 {
    fit(line, &vec![0.0; parameters], Loss::None, Options::tight()).unwrap().cost
}

fn information(line: &Line) -> DMatrix<f64> {
    let mut information = line.a.tr_mul(&line.a);
    information[(2, 2)] += 1.0 / 0.09;
    information
}

#[test]
fn covariance_is_that_of_the_normal_equations() {
    let line = line();
    let model = LocalModel::at(&line, &[0.5, 0.1, 1.0], Loss::None).unwrap();
    let covariance = model.information(&line).unwrap().covariance();
    let expected = information(&line).try_inverse().unwrap();
    for i in 0..3 {
        for j in 0..3 {
            let found = covariance[(i, j)] * model.scale[i] * model.scale[j];
            let unit = (expected[(i, i)] * expected[(j, j)]).sqrt();
            approx::assert_relative_eq!(found / unit, expected[(i, j)] / unit, epsilon = 1e-9);
        }
        let direction = model.information(&line).unwrap().direction(i).unwrap();
        approx::assert_relative_eq!(direction, covariance.column(i).into_owned(), max_relative = 1e-9, epsilon = 1e-12);
    }
}

#[test]
fn a_held_parameter_has_no_covariance_and_moves_nothing() {
    let line = line();
    let held = Held::new(&line, 1, 0.4);
    let model = LocalModel::at(&line, &[0.5, 0.4, 1.0], Loss::None).unwrap();
    let known = model.information(&held).unwrap();
    assert!(known.direction(1).is_none());
    assert_eq!(known.covariance().column(1).norm(), 0.0);
}

#[test]
fn a_descent_along_a_model_from_nearby_ends_where_one_that_relinearises_does() {
    let mut line = line();
    line.bend = 0.02;
    let near = LocalModel::at(&line, &[2.5, 0.0, 2.0], Loss::None).unwrap();
    let along = fit_along(&line, &near, &[0.0; 3], Options::steps(40, 1e-12)).unwrap();
    let found = fit(&line, &[0.0; 3], Loss::None, Options::tight()).unwrap();
    approx::assert_relative_eq!(along.cost, found.cost, max_relative = 1e-10);
    assert!(matches!(along.stopped, StoppedBecause::PromiseTolerance { .. }), "{}", along.stopped);
    assert_eq!(along.linearisations, 0);
}

#[test]
fn the_score_is_the_fall_of_chi_square_that_the_change_brings() {
    let line = line();
    let fitted = fit(&line, &[0.0; 3], Loss::None, Options::tight()).unwrap();
    let change: Vec<f64> = (0..60).map(|i| (1.7 * i as f64 + 0.3).sin()).collect();
    let model = fitted.model.as_ref().unwrap();
    let score = model.score_test(&line, &fitted.theta, &fitted.misfit).unwrap().of(&change);
    // A fourth parameter whose derivative is the change.
    let mut more = Line {
        a: line.a.clone().insert_column(3, 0.0),
        bounds: vec![OPEN; 4],
        scale: vec![1.0, 1e-3, 10.0, 1.0],
        ..line
    };
    more.a.set_column(3, &DVector::from_column_slice(&change));
    let with = fit(&more, &[0.0; 4], Loss::None, Options::tight()).unwrap();
    approx::assert_relative_eq!(score.factor, with.theta[3], max_relative = 1e-8);
    approx::assert_relative_eq!(score.fall_at(score.factor), fitted.cost - with.cost, max_relative = 1e-8);
    let sigma = with.model.unwrap().information(&more).unwrap().covariance()[(3, 3)].sqrt();
    approx::assert_relative_eq!(score.information, sigma.powi(-2), max_relative = 1e-6);
}

#[test]
fn the_schur_complement_knows_the_best_cost_of_every_subset() {
    // The first two may be asked for; the third follows.
    let line = line();
    let (mean, bounds) = ([0.5, 0.001, 2.0], [(-9.5, 10.5), (-0.1, 0.1)]);
    let model = LocalModel::at(&line, &[1.0, 0.002, 1.5], Loss::None).unwrap();
    let schur = SchurComplement::new(&model, &line.prior, &mean, &bounds);
    for set in [vec![], vec![0], vec![1], vec![0, 1]] {
        let mut restricted = self::line();
        for held in [0, 1].into_iter().filter(|held| !set.contains(held)) {
            restricted.bounds[held] = (mean[held], mean[held]);
        }
        let best = schur.best(set.iter().copied()).unwrap();
        // A trace of a prior, a millionth of what the range says, keeps directions without influence unique.
        approx::assert_relative_eq!(best.cost, least(&restricted), max_relative = 1e-6);
    }
    let both = information(&line).try_inverse().unwrap();
    let sigma = schur.sigma([1].into_iter(), 0).unwrap();
    approx::assert_relative_eq!(sigma * model.scale[0], both[(0, 0)].sqrt(), max_relative = 1e-5);
    assert_eq!(schur.rank(), 2);
}

#[test]
fn a_parameter_that_would_have_to_go_the_other_way_has_no_best_value() {
    let line = line();
    let model = LocalModel::at(&line, &[0.0; 3], Loss::None).unwrap();
    // The data ask for about 3; the range begins at 8.
    let schur = SchurComplement::new(&model, &line.prior, &[8.0, 0.0, 2.0], &[(8.0, 20.0)]);
    assert!(schur.best([0].into_iter()).is_none());
    assert!(schur.best([].into_iter()).is_some());
}

#[test]
fn a_local_model_foresees_a_line_and_not_a_bend() {
    let mut line = line();
    let foreseen = |line: &Line, far: f64, share: f64| {
        let (here, there) = ([1.0, 0.0, 2.0], [1.0 + far, 0.01, 2.5]);
        let model = LocalModel::at(line, &here, Loss::None).unwrap();
        let (before, after) = (line.misfit(&here).unwrap(), line.misfit(&there).unwrap());
        let before = Evaluated { theta: &here, misfit: &before };
        model.foresees(before, Evaluated { theta: &there, misfit: &after }, share)
    };
    assert!(foreseen(&line, 1e3, 1e-12));
    line.bend = 1.0;
    // A step of `far` on `theta^2` at 1 moves by `2 far + far^2`, of which `far^2` is not foreseen.
    assert!(foreseen(&line, 0.1, 0.01) && !foreseen(&line, 8.0, 0.1));
}

#[test]
fn the_interval_of_a_line_is_its_normal_interval() {
    let line = line();
    let fitted = fit(&line, &[0.0; 3], Loss::None, Options::tight()).unwrap();
    let near = fitted.model.as_ref().unwrap();
    let known = near.information(&line).unwrap();
    for inflation in [1.0, 2.5] {
        for i in 0..3 {
            let interval = interval(&line, near, &fitted, i, known.direction(i).unwrap(), inflation);
            let sigma = (known.covariance()[(i, i)] * inflation).sqrt() * near.scale[i];
            let half = profile::QUANTILE * sigma;
            approx::assert_relative_eq!(interval.sigma.unwrap(), sigma, max_relative = 1e-12);
            approx::assert_relative_eq!(interval.upper.end.unwrap() - fitted.theta[i], half, max_relative = 1e-5);
            approx::assert_relative_eq!(fitted.theta[i] - interval.lower.end.unwrap(), half, max_relative = 1e-5);
        }
    }
}

/// `a` and `10 atan(b - 20 a^2)`: whatever `a` is, some `b` leaves nothing of the second, so that the profile of `a` is `a^2`. Far from
/// there the second is all but flat, and no step along its slope comes back.
struct Parabola;

impl Problem for Parabola {
    type Error = Infallible;
    fn bounds(&self) -> &[(f64, f64)] {
        &[(-10.0, 10.0), (-1e9, 1e9)]
    }
    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, Infallible> {
        Ok(vec![theta[0], 10.0 * (theta[1] - 20.0 * theta[0] * theta[0]).atan()])
    }
    fn linearise(&self, theta: &[f64]) -> Result<Linearised, Infallible> {
        let away = theta[1] - 20.0 * theta[0] * theta[0];
        let slope = 10.0 / (1.0 + away * away);
        let jacobian = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, -40.0 * theta[0] * slope, slope]);
        Ok(Linearised { misfit: self.misfit(theta)?, jacobian })
    }
    fn scale(&self) -> Vec<f64> {
        vec![1.0; 2]
    }
}

#[test]
fn an_interval_is_found_in_shorter_strides_where_a_long_one_leaves_the_basin() {
    let fitted = fit(&Parabola, &[0.0; 2], Loss::None, Options::tight()).unwrap();
    let near = fitted.model.as_ref().unwrap();
    let direction = near.information(&Parabola).unwrap().direction(0).unwrap();
    let interval = interval(&Parabola, near, &fitted, 0, direction, 1.0);
    for (side, end) in [(interval.lower, -profile::QUANTILE), (interval.upper, profile::QUANTILE)] {
        assert_eq!(side.why, profile::End::Crossed);
        approx::assert_relative_eq!(side.end.unwrap(), end, max_relative = 0.01);
    }
}

/// `(A (gap^3, other) - y) / 0.1`: a leak through a gap, whose slope is nothing where there is none. Counts what it is asked for.
struct Gap {
    a: DMatrix<f64>,
    y: DVector<f64>,
    evaluations: AtomicUsize,
}

impl Problem for Gap {
    type Error = Infallible;
    fn bounds(&self) -> &[(f64, f64)] {
        &[(0.0, 100.0), OPEN]
    }
    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, Infallible> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let leak = DVector::from_column_slice(&[theta[0].powi(3), theta[1]]);
        Ok(((&self.a * leak - &self.y) / 0.1).as_slice().to_vec())
    }
    fn linearise(&self, theta: &[f64]) -> Result<Linearised, Infallible> {
        let mut jacobian = &self.a / 0.1;
        jacobian.column_mut(0).scale_mut(3.0 * theta[0] * theta[0]);
        Ok(Linearised { misfit: self.misfit(theta)?, jacobian })
    }
    fn scale(&self) -> Vec<f64> {
        vec![1.0; 2]
    }
}

/// In the cube of the gap the profile is a parabola, whose ends linear least squares know.
#[test]
fn the_interval_of_a_gap_that_is_best_without_or_with_a_leak_is_that_of_its_cube() {
    let a = DMatrix::from_fn(40, 2, |i, j| if j == 0 { 1.0 + (0.3 * i as f64).sin() } else { 1.0 });
    let covariance = (a.tr_mul(&a) / 0.01).try_inverse().unwrap();
    let sigma = covariance[(0, 0)].sqrt();
    // Of the cube, in standard errors.
    for best in [-1.5, -0.1, 0.4, 1.2, 1.9] {
        let y = &a * DVector::from_column_slice(&[best * sigma, 2.0]);
        let gap = Gap { a: a.clone(), y, evaluations: AtomicUsize::new(0) };
        let without = fit(&Held::new(&gap, 0, 0.0), &[0.0; 2], Loss::None, Options::tight()).unwrap();
        let near = LocalModel::at(&gap, &without.theta, Loss::None).unwrap();
        let direction = near.information(&gap).unwrap().direction(0).unwrap();
        gap.evaluations.store(0, Ordering::Relaxed);
        let interval = interval_from_bound(&gap, &near, &without, 0, direction, 1.0).unwrap();
        let cubed = |value: f64| value.powi(3) / sigma;
        let end = best + (profile::RISE + best.min(0.0).powi(2)).sqrt();
        approx::assert_relative_eq!(cubed(interval.value), best.max(0.0), epsilon = 0.02);
        approx::assert_relative_eq!(cubed(interval.upper.end.unwrap()), end, max_relative = 0.03);
        assert_eq!(interval.lower.why, profile::End::BoundReached);
        approx::assert_relative_eq!(interval.lower.rise, best.max(0.0).powi(2), epsilon = 0.02);
        // Of where the law is straight: slope of the cube.
        if let Some(own) = interval.sigma {
            approx::assert_relative_eq!(own, sigma / (3.0 * interval.value.powi(2)), max_relative = 0.05);
        }
        let evaluations = gap.evaluations.load(Ordering::Relaxed);
        assert!(evaluations <= 14, "{evaluations}");
    }
}

/// So many samples that share nothing.
struct White(usize);

impl Series for White {
    fn parts(&self) -> Vec<Part> {
        vec![Part { rows: 0..self.0, shared: Shared::default() }]
    }

    fn leave_own(&self, _: &mut [f64]) {}
}

#[test]
fn inflation_of_a_series_of_first_order_is_its_closed_form() {
    // The variance of the mean of an AR(1) series is (1 + rho) / (1 - rho) times that of white noise.
    let (rho, n): (f64, usize) = (0.6, 20_000);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut uniform = || ((random.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
    let mut noise = 0.0;
    let y = DVector::from_fn(n, |_, _| {
        let fresh = (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
        noise = rho * noise + (1.0 - rho * rho).sqrt() * fresh;
        noise
    });
    let a = DMatrix::from_element(n, 1, 1.0);
    let mean = Line { a, y, bend: 0.0, bounds: vec![OPEN], scale: vec![1.0], prior: Gaussian::none() };
    let fitted = fit(&mean, &[0.0], Loss::None, Options::default()).unwrap();
    let near = fitted.model.unwrap();
    let direction = near.information(&mean).unwrap().direction(0).unwrap();
    let found = near.inflation_along(&mean, &direction, &near.misfit, &White(n));
    // The long-run variance of so many samples is known to about a tenth.
    approx::assert_relative_eq!(found, (1.0 + rho) / (1.0 - rho), max_relative = 0.1);
}

/// Series of phases of `rows` samples that share a level of `tolerance` standard deviations of a sample.
struct Levelled {
    rows: usize,
    phases: usize,
    tolerance: f64,
}

impl Series for Levelled {
    fn parts(&self) -> Vec<Part> {
        let mut shared = Shared::default();
        shared.add(1.0 - (1.0 - self.taken()).powi(2), self.phases as f64);
        vec![Part { rows: 0..self.rows * self.phases, shared }]
    }

    fn leave_own(&self, column: &mut [f64]) {
        for phase in column.chunks_exact_mut(self.rows) {
            let level = self.taken() * phase.iter().sum::<f64>() / self.rows as f64;
            phase.iter_mut().for_each(|value| *value -= level);
        }
    }
}

impl Levelled {
    fn taken(&self) -> f64 {
        1.0 - (1.0 + self.rows as f64 * self.tolerance.powi(2)).sqrt().recip()
    }
}

#[test]
fn what_weights_allow_samples_to_share_is_not_inflated() {
    let (rho, rows, phases, tolerance): (f64, usize, usize, f64) = (0.5, 100, 200, 0.15);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut normal = || -> f64 { rand_distr::StandardNormal.sample(&mut random) };
    let (mut noise, mut level) = (0.0, 0.0);
    let n = rows * phases;
    let mut errors = Vec::with_capacity(n);
    for row in 0..n {
        noise = rho * noise + (1.0 - rho * rho).sqrt() * normal();
        if row % rows == 0 {
            level = tolerance * normal();
        }
        errors.push(noise + level);
    }
    // The mean of all samples, weighed with (1 + t² 11')^(-1/2) in each phase, which is what `leave_own` does to a column.
    let series = Levelled { rows, phases, tolerance };
    let mut influence = vec![1.0; n];
    series.leave_own(&mut influence);
    series.leave_own(&mut errors);
    let a = DMatrix::from_column_slice(n, 1, &influence);
    let mean =
        Line { a, y: DVector::zeros(n), bend: 0.0, bounds: vec![OPEN], scale: vec![1.0], prior: Gaussian::none() };
    let near = LocalModel::at(&mean, &[0.0], Loss::None).unwrap();
    let influence = DVector::from_vec(influence);
    // A phase's mean has the variance t² + v/rows instead of t² + 1/rows.
    let v = (1.0 + rho) / (1.0 - rho);
    let of = |v: f64| tolerance.powi(2) + v / rows as f64;
    let found = near.inflation(&influence, &errors, 0.0, &series);
    approx::assert_relative_eq!(found, of(v) / of(1.0), max_relative = 0.1);
    // Taken for samples on their own, they would be as uncertain as if none shared anything.
    assert!(near.inflation(&influence, &errors, 0.0, &White(n)) > 1.3 * found);
}

#[test]
fn what_is_known_before_is_not_inflated() {
    // A mean of n samples under coloured noise, known before to p: what departs from there has the variance v/n + p².
    let (n, p) = (400, 0.1_f64);
    let prior = Gaussian::new(vec![0], vec![0.0], &DMatrix::from_element(1, 1, p * p));
    let a = DMatrix::from_element(n, 1, 1.0);
    let y = DVector::from_fn(n, |i, _| (0.05 * i as f64).sin());
    let mean = Line { a, y, bend: 0.0, bounds: vec![OPEN], scale: vec![2.0], prior };
    let near = LocalModel::at(&mean, &[0.0], Loss::None).unwrap();
    let along = SchurComplement::new(&near, &mean.prior, &[0.0], &[(-100.0, 100.0)]).along([].into_iter(), 0, 1);
    approx::assert_relative_eq!(along.variance * 4.0, 1.0 / n as f64 + p * p, max_relative = 1e-6);
    let influence = near.jacobian() * &along.total;
    let own = mean.prior.change(&(along.known * 2.0)).norm_squared();
    let series = &White(n);
    let of_record = near.inflation(&influence, &near.misfit, 0.0, series);
    assert!(of_record > 5.0, "{of_record}");
    let expected = (of_record / n as f64 + p * p) / (1.0 / n as f64 + p * p);
    let found = near.inflation(&influence, &near.misfit, own, series);
    approx::assert_relative_eq!(found, expected, max_relative = 1e-6);
}

#[test]
fn the_misfit_of_a_prior_is_white() {
    let covariance = DMatrix::from_row_slice(2, 2, &[4.0, 3.0, 3.0, 9.0]);
    let prior = Gaussian::new(vec![0, 2], vec![1.0, -1.0], &covariance);
    let theta = [2.0, 77.0, 3.0];
    let away = DVector::from_column_slice(&[1.0, 4.0]);
    let expected = away.dot(&(covariance.try_inverse().unwrap() * &away));
    approx::assert_relative_eq!(prior.misfit(&theta).norm_squared(), expected, max_relative = 1e-12);
    let slope = prior.jacobian(3);
    assert_eq!(slope.column(1).norm(), 0.0);
    approx::assert_relative_eq!(slope.tr_mul(&slope)[(0, 0)], prior.precision()[(0, 0)], max_relative = 1e-12);
}

#[test]
fn several_changes_bring_what_as_many_parameters_more_would() {
    let line = line();
    let best = fit(&line, &[0.5, 0.1, 1.0], Loss::None, Options::tight()).unwrap();
    let model = LocalModel::at(&line, &best.theta, Loss::None).unwrap();
    let test = model.score_test(&line, &best.theta, &best.misfit).unwrap();
    // The second does nearly what the first does; a third that nothing tells from the first brings nothing.
    let one: Vec<f64> = (0..60).map(|i| (1.7 * i as f64 + 0.3).sin()).collect();
    let other: Vec<f64> = (0..60).map(|i| (1.7 * i as f64 + 0.4).sin()).collect();
    let twice = one.iter().map(|by| 2.0 * by).collect();
    let a = DMatrix::from_fn(60, 5, |i, j| match j {
        3 => one[i],
        4 => other[i],
        of_line => line.a[(i, of_line)],
    });
    let mut scale = line.scale.clone();
    scale.extend([1.0, 1.0]);
    let prior = Gaussian::new(vec![2], vec![2.0], &DMatrix::from_element(1, 1, 0.09));
    let more = Line { a, y: line.y.clone(), bend: 0.0, bounds: vec![OPEN; 5], scale, prior };
    let fall = best.cost - least_of(&more, 5);
    assert!(fall > 20.0, "nearly all of the waves: {fall}");
    approx::assert_relative_eq!(test.most(&[one.clone(), other.clone()]), fall, max_relative = 1e-6);
    approx::assert_relative_eq!(test.most(&[one.clone(), other, twice]), fall, max_relative = 1e-6);
    let alone = test.of(&one);
    approx::assert_relative_eq!(test.most(&[one]), alone.fall_at(alone.factor), max_relative = 1e-9);
}
