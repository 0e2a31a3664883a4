//! How often the learning loop names what a plant hides: a plant by hand, another integrator, other forms of the laws.

mod plant;

use std::time::Instant;

use borescope::campaign::random::Stream;
use borescope::learn::suggest::{Suggestion, suggest};
use borescope::record::Record;
use borescope::rig::Rig;
use plant::hidden::{HIDDEN, Hidden, healthy, size};
use plant::record::{cycle, record};

fn telescopic() -> Rig {
    Rig::read("fixtures/telescopic/rig.toml").unwrap()
}

fn records(hidden: Option<&Hidden>, seed: u64) -> (f64, [Record; 2]) {
    let place = HIDDEN.iter().position(|other| hidden.is_some_and(|hidden| hidden.id == other.id));
    let mut random = Stream::numbered(seed, place.map_or(0, |place| place as u64 + 1));
    let mut plant = healthy(&mut random);
    let size = hidden.map_or(0.0, |hidden| size(hidden, &mut random));
    if let Some(hidden) = hidden {
        (hidden.put)(&mut plant, size);
    }
    let pair = ["fit", "check"].map(|name| {
        let phases = cycle(&mut random);
        record(name, &plant, &phases, &mut random)
    });
    (size, pair)
}

fn suggestion(pair: &[Record; 2]) -> Suggestion {
    suggest(&telescopic(), &pair[0], Some(&pair[1])).unwrap()
}

#[test]
#[ignore = "a study"]
fn study() {
    let seeds: u64 = std::env::var("SEEDS").map_or(1, |seeds| seeds.parse().unwrap());
    let only = std::env::var("ONLY").unwrap_or_default();
    for hidden in HIDDEN.iter().map(Some).chain([None]) {
        let id = hidden.map_or("nothing", |hidden| hidden.id);
        if !id.contains(&only) {
            continue;
        }
        for seed in 1..=seeds {
            let clock = Instant::now();
            let (size, pair) = records(hidden, seed);
            if let Ok(folder) = std::env::var("RECORDS") {
                for record in &pair {
                    record.write(format!("{folder}/{id}_{seed}_{}.csv", record.path.display())).unwrap();
                }
                continue;
            }
            let suggestion = suggestion(&pair);
            let scored = suggestion.scored.iter().find(|scored| scored.id == id);
            let place = suggestion.judged.iter().position(|judged| judged.id() == id);
            println!(
                "{id} {size:.4} {seed}: {:?}, base chi2 {:.2} check {:.2}, set {:b}, score {:.0} smallest {:.3}, place {place:?}, {:.1} s",
                suggestion.conclusion,
                suggestion.base.fit.chi2,
                suggestion.base_check.as_ref().unwrap().chi2,
                suggestion.base.set,
                scored.map_or(f64::NAN, |scored| scored.score),
                scored.map_or(f64::NAN, |scored| scored.smallest),
                clock.elapsed().as_secs_f64(),
            );
            for scored in suggestion.scored.iter().take(4) {
                println!("    {} score {:.0} left {:.0} stand {:?} x {:.2} of {:?}", scored.id, scored.score, scored.left, scored.stand, scored.factor, scored.tried[0].value);
            }
            for judged in suggestion.judged.iter().take(4) {
                println!(
                    "    {} {} dbic {:.0} chi2 {:.2} check {:.2} {:?}",
                    judged.id(),
                    judged.supported,
                    judged.delta_bic,
                    judged.trial.fit.chi2,
                    judged.check.as_ref().map_or(f64::NAN, |check| check.chi2),
                    judged.warnings
                );
            }
        }
    }
}

#[test]
#[ignore = "scratch"]
fn scratch_write() {
    let mut random = Stream::numbered(1, 0);
    let plant = healthy(&mut random);
    let phases = cycle(&mut random);
    let clock = Instant::now();
    record("fit", &plant, &phases, &mut random).write("/tmp/plant_healthy.csv").unwrap();
    println!("{:?}", clock.elapsed());
}
