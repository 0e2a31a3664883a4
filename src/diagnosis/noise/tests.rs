use nalgebra::DMatrix;

use super::*;
use crate::rig::Sensor;

/// A misfit that is three times what an event may do, on a sensor that it moves; another sensor has no part in it.
#[test]
fn what_is_asked_of_events_counts_in_what_they_may_do() {
    let rig = Rig::parse("rig.toml", include_str!("../../../fixtures/two_tanks/rig.toml").to_owned()).unwrap();
    let rows = 1600;
    let (moved, still) = (vec![0.01; rows], vec![0.0; rows]);
    let sensors = rig.sensors.len();
    let change: Vec<Vec<f64>> = (0..sensors).map(|sensor| if sensor == 0 { &moved } else { &still }.clone()).collect();
    let exact =
        Rig { sensors: rig.sensors.iter().map(|one| Sensor { tolerance: 0.0, ..one.clone() }).collect(), ..rig };
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
    let rig = Rig::parse("rig.toml", include_str!("../../../fixtures/two_tanks/rig.toml").to_owned()).unwrap();
    let (rows, sensors) = (8, rig.sensors.len());
    let rig = Rig { sensors: rig.sensors.iter().map(|one| Sensor { tolerance: 0.02, ..one.clone() }).collect(), ..rig };
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
    let (mut found, mut few) = (random_directions(&all).1, random_directions(&seen).1);
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
    let rig = Rig::parse("rig.toml", include_str!("../../../fixtures/two_tanks/rig.toml").to_owned()).unwrap();
    let (rows, sensors) = (12, rig.sensors.len());
    let rig = Rig { sensors: rig.sensors.iter().map(|one| Sensor { tolerance: 0.02, ..one.clone() }).collect(), ..rig };
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
