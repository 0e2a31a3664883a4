//! Structural analysis of public examples, whose answers are known.

use std::time::Instant;

use borescope::internals::structure::isolability::{isolation, isolation_by_tests, signatures};
use borescope::internals::structure::mso::{count_mso, mso_sets};
use borescope::internals::structure::mtes::{mtes_sets, smallest_test};
use borescope::internals::structure::placement::{Extent, place};
use borescope::internals::structure::selection::select;
use borescope::internals::structure::{Structure, matching};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

#[derive(serde::Deserialize)]
struct Lists {
    unknowns: Vec<String>,
    faults: Vec<String>,
    knowns: Vec<String>,
    relations: Vec<Vec<String>>,
    derivatives: Vec<Vec<String>>,
}

fn read(name: &str) -> Structure {
    let path = format!("{}/fixtures/structure/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let lists: Lists = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    Structure::from_lists(&lists.unknowns, &lists.faults, &lists.knowns, &lists.relations, &lists.derivatives).unwrap()
}

/// Counts of both searches, timed; the sets checked one by one; and what the tests isolate compared with what is
/// possible.
fn searches(name: &str) -> (Structure, Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let structure = read(name);
    let start = Instant::now();
    let mso = mso_sets(&structure, usize::MAX);
    let between = Instant::now();
    let mtes = mtes_sets(&structure, usize::MAX);
    println!(
        "{name}: {} MSO in {:.3} ms, {} MTES in {:.3} ms",
        mso.sets.len(),
        (between - start).as_secs_f64() * 1e3,
        mtes.sets.len(),
        between.elapsed().as_secs_f64() * 1e3
    );
    assert!(mso.complete && mtes.complete);
    assert_eq!(count_mso(&structure, usize::MAX), (mso.sets.len(), true));
    for sets in [&mso.sets, &mtes.sets] {
        let mut distinct = sets.clone();
        distinct.sort();
        distinct.dedup();
        assert_eq!(distinct.len(), sets.len(), "{name}: a set was found twice");
    }
    let rows = structure.rows();
    for set in &mso.sets {
        let parts = matching::decompose(&rows, set, structure.unknowns.len());
        assert_eq!(parts.over.equations, *set);
        assert_eq!(parts.over.equations.len(), parts.over.unknowns.len() + 1);
    }
    let possible = isolation(&structure);
    for sets in [&mso.sets, &mtes.sets] {
        let tests = signatures(&structure, sets);
        assert_eq!(isolation_by_tests(&tests, structure.faults.len()), possible, "{name}");
        let start = Instant::now();
        let chosen = select(&tests);
        println!("{name}: {} tests chosen in {:.3} ms", chosen.len(), start.elapsed().as_secs_f64() * 1e3);
        let few: Vec<Vec<bool>> = chosen.iter().map(|&test| tests[test].clone()).collect();
        assert_eq!(isolation_by_tests(&few, structure.faults.len()), possible, "{name}");
    }
    (structure, mso.sets, mtes.sets)
}

#[test]
fn three_tank() {
    let (_, mso, mtes) = searches("three_tank");
    assert_eq!((mso.len(), mtes.len()), (6, 4));
}

#[test]
fn water_tank() {
    let (structure, mso, mtes) = searches("water_tank");
    assert_eq!((mso.len(), mtes.len()), (17, 10));
    assert_eq!(isolation(&structure).groups().len(), 6);
}

#[test]
fn electric_motor() {
    let (_, mso, _) = searches("electric_motor");
    let mut sizes: Vec<usize> = mso.iter().map(Vec::len).collect();
    sizes.sort();
    assert_eq!(sizes, [4, 4, 6]);
}

#[test]
fn induction_motor() {
    let (structure, ..) = searches("induction_motor");
    assert_eq!((structure.equations.len(), structure.unknowns.len()), (15, 13));
}

#[test]
fn engine() {
    let (structure, mso, mtes) = searches("vep4");
    assert_eq!((structure.equations.len(), structure.unknowns.len()), (94, 90));
    assert_eq!((mso.len(), mtes.len()), (4496, 144));
    let isolation = isolation(&structure);
    assert!(isolation.detectable.iter().all(|&detectable| detectable));
    assert_eq!(isolation.groups().len(), 11);
    assert!(select(&signatures(&structure, &mtes)).len() <= 9);
}

/// Minimal sets by trying every subset of the equations, for structures of up to 12, compared with the searches.
fn agrees_with_trying_everything(structure: &Structure, name: &str) {
    let rows = structure.rows();
    let count = rows.len();
    let mut proper: Vec<Vec<usize>> = Vec::new();
    for chosen in 1u32..1 << count {
        let set: Vec<usize> = (0..count).filter(|row| chosen >> row & 1 == 1).collect();
        if matching::decompose(&rows, &set, structure.unknowns.len()).over.equations == set {
            proper.push(set);
        }
    }
    let within = |small: &[usize], large: &[usize]| small.iter().all(|row| large.contains(row));
    let faults = |set: &[usize]| -> Vec<usize> {
        let mut all: Vec<usize> = set.iter().flat_map(|&row| structure.equations[row].faults.clone()).collect();
        all.sort();
        all
    };
    let minimal = |sets: &[Vec<usize>]| -> Vec<Vec<usize>> {
        let other_within = |set: &Vec<usize>| sets.iter().any(|other| other != set && within(other, set));
        let mut kept: Vec<Vec<usize>> = sets.iter().filter(|set| !other_within(set)).cloned().collect();
        kept.sort();
        kept
    };
    let larger = |set: &Vec<usize>| {
        proper.iter().any(|other| other != set && within(set, other) && faults(set) == faults(other))
    };
    let supports: Vec<Vec<usize>> =
        proper.iter().filter(|set| !faults(set).is_empty() && !larger(set)).cloned().collect();
    let sorted = |mut sets: Vec<Vec<usize>>| {
        sets.sort();
        sets
    };
    assert_eq!(sorted(mso_sets(structure, usize::MAX).sets), minimal(&proper), "{name}");
    let mtes = sorted(mtes_sets(structure, usize::MAX).sets);
    assert_eq!(mtes, minimal(&supports), "{name}");
    for set in &mtes {
        let test = smallest_test(structure, set, usize::MAX).unwrap();
        assert!(minimal(&proper).contains(&test) && faults(&test) == faults(set), "{name}");
    }
    let tests = signatures(structure, &mtes);
    assert_eq!(isolation_by_tests(&tests, structure.faults.len()), isolation(structure), "{name}");
}

#[test]
fn small_structures_agree_with_trying_everything() {
    for name in ["three_tank", "water_tank", "electric_motor", "small_example"] {
        agrees_with_trying_everything(&read(name), name);
    }
}

#[test]
fn random_structures_agree_with_trying_everything() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut below = |end: u64| random.next_u64() % end;
    let mut redundant = 0;
    for case in 0..200 {
        let (equations, unknowns, faults) = (5 + below(4), 2 + below(5), 1 + below(4));
        let mut structure = Structure::default();
        for unknown in 0..unknowns {
            structure.unknown(format!("x{unknown}"), true);
        }
        structure.faults = (0..faults).map(|fault| format!("f{fault}")).collect();
        let places: Vec<u64> = (0..faults).map(|_| below(equations)).collect();
        for equation in 0..equations {
            let held: Vec<usize> = (0..unknowns as usize).filter(|_| below(3) == 0).collect();
            let broken: Vec<usize> = (0..faults as usize).filter(|&fault| places[fault] == equation).collect();
            structure.equation(format!("e{equation}"), &held, &broken);
        }
        redundant += usize::from(mtes_sets(&structure, usize::MAX).sets.len() > 1);
        agrees_with_trying_everything(&structure, &format!("case {case}"));
    }
    assert!(redundant > 50, "only {redundant} of the cases have several supports");
}

#[test]
fn sensors_of_commault() {
    let structure = read("commault");
    let explained = isolation(&structure).explained_by;
    let known = [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 1, 1], [0, 0, 1, 1]];
    assert_eq!(explained, known.map(|row| row.map(|one| one == 1).to_vec()).to_vec());
    let placement = place(&structure, &[], Extent::All, 7);
    assert!(placement.complete);
    assert_eq!(placement.sensors, [[4, 5], [5, 6]]);
    let with = placement.sensors[0].iter().fold(structure, |with, &sensor| with.with_sensor(sensor, false));
    assert_eq!(isolation(&with).groups().len(), 4);
}

#[test]
fn sensors_of_linear_model() {
    let mut structure = read("sensor_choice");
    structure.unknowns.iter_mut().for_each(|unknown| unknown.measurable = unknown.name.starts_with('x'));
    let sure = place(&structure, &[], Extent::All, 10);
    println!("{:?}", sure.sensors);
    assert_eq!((sure.sensors.len(), sure.complete), (5, true));
    let faulty = place(&structure, &[0, 1, 2, 3, 4], Extent::All, 10);
    println!("{:?}", faulty.sensors);
    assert_eq!((faulty.sensors.len(), faulty.complete), (9, true));
}

/// Sets of sensors by trying every one, for models with as many equations as unknowns.
#[test]
fn random_placements_agree_with_trying_everything() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut below = |end: u64| random.next_u64() % end;
    let mut several = 0;
    for case in 0..200 {
        let size = 3 + below(4) as usize;
        let mut structure = Structure::default();
        for unknown in 0..size {
            structure.unknown(format!("x{unknown}"), below(4) > 0);
        }
        structure.faults = vec!["f0".into(), "f1".into(), "f2".into()];
        let places = [0, 1, below(size as u64) as usize];
        for equation in 0..size {
            let held: Vec<usize> = (0..size).filter(|&unknown| unknown == equation || below(4) == 0).collect();
            let broken: Vec<usize> = (0..3).filter(|&fault| places[fault] == equation).collect();
            structure.equation(format!("e{equation}"), &held, &broken);
        }
        let measurable: Vec<usize> = (0..size).filter(|&unknown| structure.unknowns[unknown].measurable).collect();
        let with = |sensors: &[usize]| {
            isolation(&sensors.iter().fold(structure.clone(), |with, &sensor| with.with_sensor(sensor, false)))
        };
        let best = with(&measurable);
        let mut minimal: Vec<Vec<usize>> = Vec::new();
        let mut choices: Vec<Vec<usize>> = (0u32..1 << measurable.len())
            .map(|chosen| (0..measurable.len()).filter(|i| chosen >> i & 1 == 1).map(|i| measurable[i]).collect())
            .collect();
        choices.sort_by_key(Vec::len);
        for sensors in choices {
            let known = minimal.iter().any(|small| small.iter().all(|sensor| sensors.contains(sensor)));
            if !known && with(&sensors) == best {
                minimal.push(sensors);
            }
        }
        minimal.sort_by_key(|sensors| (sensors.len(), sensors.clone()));
        several += usize::from(minimal.len() > 1);
        let placement = place(&structure, &[], Extent::All, size);
        assert_eq!((placement.sensors, placement.complete), (minimal, true), "case {case}: {structure:?}");
    }
    assert!(several > 50, "only {several} of the cases have alternatives");
}

#[test]
fn searches_stop_at_their_limit() {
    let structure = read("vep4");
    let found = mso_sets(&structure, 100);
    assert_eq!((found.sets.len(), found.complete), (100, false));
    assert_eq!(count_mso(&structure, 4496), (4496, true));
    assert!(!mtes_sets(&structure, 143).complete);
}

#[test]
fn decomposition_in_parts() {
    // One unknown too many, a loop of two, and two equations for one unknown.
    let names = ["a", "b", "c", "d", "e"];
    let relations: [&[&str]; 5] = [&["a", "b", "c"], &["c", "d"], &["c", "d", "e"], &["e"], &["e"]];
    let structure = Structure::from_lists(&names[..], &[], &[], &relations[..], &[]).unwrap();
    let parts = matching::decompose(&structure.rows(), &[0, 1, 2, 3, 4], 5);
    assert_eq!(parts.under.equations, [0]);
    assert_eq!(parts.under.unknowns, [0, 1]);
    assert_eq!(parts.just.len(), 1);
    assert_eq!(parts.just[0].equations, [1, 2]);
    assert_eq!(parts.just[0].unknowns, [2, 3]);
    assert_eq!(parts.over.equations, [3, 4]);
}
