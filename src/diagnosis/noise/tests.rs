use nalgebra::DMatrix;

use super::directions::Directions;
use super::*;
use crate::rig::Sensor;
use crate::settings::DiagnosisSettings;

/// A rig of two sensors with the same tolerance.
fn tolerating(tolerance: f64) -> Rig {
    let rig = Rig::parse("rig.toml", include_str!("../../../fixtures/two_tanks/rig.toml").to_owned()).unwrap();
    Rig { sensors: rig.sensors.iter().map(|one| Sensor { tolerance, ..one.clone() }).collect(), ..rig }
}

/// A misfit that is three times what an event may do, on a sensor that it moves; another sensor has no part in it.
#[test]
fn what_is_asked_of_events_counts_in_what_they_may_do() {
    let exact = tolerating(0.0);
    let rows = 1600;
    let (moved, still) = (vec![0.01; rows], vec![0.0; rows]);
    let sensors = exact.sensors.len();
    let change: Vec<Vec<f64>> = (0..sensors).map(|sensor| if sensor == 0 { &moved } else { &still }.clone()).collect();
    let variance = vec![vec![1e-6; rows]; sensors];
    let phases: Vec<_> = (0..8).map(|phase| 200 * phase..200 * (phase + 1)).collect();
    let weights = Weights::new(&exact, &phases, &variance, std::slice::from_ref(&change));
    let mut misfit: Vec<f64> = change.iter().flatten().map(|change| 3.0 * change).collect();
    weights.apply(&mut misfit);
    let asked = weights.asked_of_events(&DiagnosisSettings::default(), &misfit);
    approx::assert_relative_eq!(asked[0].0, 9.0, max_relative = 1e-3);
    approx::assert_relative_eq!(asked[0].1, 1.0, max_relative = 1e-12);
    assert!(asked[1..].iter().all(|&(_, ways)| ways == 0.0));
}

/// What weights do to misfits is a matrix: its columns are what they make of each sample alone.
#[test]
fn the_determinant_is_that_of_what_is_done_to_the_samples() {
    let rig = tolerating(0.02);
    let (rows, sensors) = (8, rig.sensors.len());
    let variance: Vec<Vec<f64>> =
        (0..sensors).map(|sensor| (0..rows).map(|row| 1e-4 * (1 + row + sensor) as f64).collect()).collect();
    let change: Vec<Vec<f64>> =
        (0..sensors).map(|sensor| (0..rows).map(|row| 0.01 * (row as f64 - sensor as f64)).collect()).collect();
    let weights = Weights::new(&rig, &[0..3, 3..rows], &variance, &[change]);
    let samples = rows * sensors;
    let mut done = DMatrix::identity(samples, samples);
    for mut column in done.column_iter_mut() {
        weights.apply(column.as_mut_slice());
    }
    approx::assert_relative_eq!(weights.log_determinant(), done.determinant().ln(), max_relative = 1e-9);
}

/// What is one and the same in all phases is an effect over all samples: with `W` the matrix of the weights, `W' W` is the inverse of the
/// covariance of the samples, that of the phases with the square of the effect added. So it is of the first phases alone.
#[test]
fn what_is_the_same_throughout_adds_its_square_to_the_covariance() {
    let rig = tolerating(0.02);
    let (rows, sensors) = (8, rig.sensors.len());
    let of = |size: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..sensors).map(|sensor| (0..rows).map(|row| size(row, sensor)).collect()).collect()
    };
    let variance = of(&|row, sensor| 1e-4 * (1 + row + sensor) as f64);
    let in_phases = of(&|row, sensor| 0.01 * (row as f64 - sensor as f64));
    let throughout = of(&|row, sensor| 0.03 * ((3 * row + sensor) as f64).sin());
    let matrix = |weights: &Weights| {
        let samples = weights.rows() * sensors;
        let mut done = DMatrix::identity(samples, samples);
        done.column_iter_mut().for_each(|mut column| weights.apply(column.as_mut_slice()));
        done
    };
    let phases = [0..3, 3..rows];
    let of_phases = Weights::new(&rig, &phases, &variance, &[in_phases]);
    let weights = of_phases.clone().with_throughout(std::slice::from_ref(&throughout));
    let (before, done) = (matrix(&of_phases), matrix(&weights));
    let effect = DMatrix::from_iterator(rows * sensors, 1, throughout.iter().flatten().copied());
    let covariance = (before.transpose() * &before).try_inverse().unwrap() + &effect * effect.transpose();
    let identity = DMatrix::identity(rows * sensors, rows * sensors);
    approx::assert_relative_eq!(done.transpose() * &done * covariance, identity, epsilon = 1e-9);
    approx::assert_relative_eq!(weights.log_determinant(), done.determinant().ln(), max_relative = 1e-9);
    // Columns of a matrix are weighed like one alone.
    let mut together = DMatrix::identity(rows * sensors, rows * sensors);
    weights.apply_to_columns(&mut together);
    approx::assert_relative_eq!(together, done, epsilon = 1e-12);
    // What neighbours share is put back: with weights `S D^(-1/2)`, `S'` of them is `S' S D^(-1/2)`.
    let scaled = DMatrix::from_diagonal(&nalgebra::DVector::from_iterator(
        rows * sensors,
        variance.iter().flatten().map(|variance| variance.powf(-0.5)),
    ));
    let mut own = done.clone();
    own.column_iter_mut().for_each(|mut column| weights.leave_own(column.as_mut_slice()));
    approx::assert_relative_eq!(own, scaled.try_inverse().unwrap() * done.transpose() * &done, epsilon = 1e-9);
    let first = weights.of_first_phases(3).1;
    let cut: Vec<Vec<f64>> = throughout.iter().map(|curve| curve[..3].to_vec()).collect();
    let alone = of_phases.of_first_phases(3).1.with_throughout(&[cut]);
    approx::assert_relative_eq!(matrix(&first), matrix(&alone), epsilon = 1e-9);
}

/// Parts that do next to nothing in a phase, as most of a large rig, leave what the others do as it is.
#[test]
fn effects_that_are_all_but_nothing_change_no_direction() {
    let rows = 40;
    // As good as random: no two are alike.
    let effect =
        |one: u64, size: f64| -> Vec<f64> { (0..rows).map(|row| size * ((one * row + one) as f64).sin()).collect() };
    let seen = [effect(1, 3.0), effect(2, 0.2)];
    let unseen = (0..80).map(|one| effect(10 + one, 10_f64.powi(-5 * (one as i32 % 40) - 5)));
    let all: Vec<Vec<f64>> = unseen.clone().chain(seen.clone()).chain(unseen).collect();
    let taken = |effects: &[Vec<f64>]| Directions::of(effects).iter().map(|(_, taken)| taken).collect::<Vec<f64>>();
    let (mut found, mut few) = (taken(&all), taken(&seen));
    found.sort_by(f64::total_cmp);
    few.sort_by(f64::total_cmp);
    assert_eq!(found.len(), few.len());
    for (found, few) in found.iter().zip(few) {
        approx::assert_relative_eq!(*found, few, max_relative = 1e-9);
    }
}

/// Cut at the end of a phase, weights do to the first rows what they did before.
#[test]
fn weights_of_the_first_phases_are_those_of_all() {
    let rig = tolerating(0.02);
    let (rows, sensors) = (12, rig.sensors.len());
    let of = |size: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..sensors).map(|sensor| (0..rows).map(|row| size(row, sensor)).collect()).collect()
    };
    let (variance, change) = (of(&|row, sensor| 1e-4 * (1 + row + sensor) as f64), of(&|row, _| 0.01 * row as f64));
    let weights = Weights::new(&rig, &[0..3, 3..8, 8..rows], &variance, &[change]);
    let misfit = of(&|row, sensor| (row * 7 + sensor).rem_euclid(5) as f64 - 2.0);
    let (last, first) = weights.of_first_phases(5);
    assert_eq!((last, first.rows(), first.shared.len()), (8, 8, sensors));
    let mut whole: Vec<f64> = misfit.iter().flatten().copied().collect();
    let mut part: Vec<f64> = misfit.iter().flat_map(|of_sensor| of_sensor[..last].to_vec()).collect();
    weights.apply(&mut whole);
    first.apply(&mut part);
    for (whole, part) in whole.chunks(rows).zip(part.chunks(last)) {
        assert_eq!(whole[..last], *part);
    }
}
