//! How often the learning loop names what a plant hides: a plant by hand, another integrator, other forms of the laws.

use crate::support::study::{self, Table, may_be_equal};
use crate::support::{page, plant};

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

use borescope::Record;
use borescope::Rig;
use borescope::internals::campaign::random::Stream;
use borescope::internals::learn::evaluated::Conclusion;
use borescope::internals::learn::result::{ScoredReport, SuggestionReport};
use borescope::internals::learn::suggest::{Suggestion, suggest};
use plant::hidden::{HIDDEN, Hidden, Sheet, begins, healthy, rig, size};
use plant::record::{cycle, record};
use plant::tanks::{Tanks, voltage};
use plant::{A, Plant};

/// What became of a case, by what `suggest` itself says that the record could show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// Named alone.
    Named,
    /// Named with others that explain the records alike.
    InClass,
    /// Faults of the rig explain the records.
    Fault,
    /// Nothing found, and the record to which the model is fitted could not have shown it.
    Invisible,
    /// Nothing found where it could.
    Missed,
    /// Seen, but not named.
    Unknown,
    /// Another one named.
    Wrong,
}

fn pair(sheet: Sheet, plant: &Plant, random: &mut Stream) -> [Record; 2] {
    ["fit", "check"].map(|name| {
        let phases = cycle(random, sheet.loads());
        record(name, plant, &phases, random)
    })
}

/// A plant that hides an effect of a drawn size, and two records of it.
fn case(hidden: &Hidden, seed: u64) -> (f64, [Record; 2]) {
    let place = HIDDEN.iter().position(|other| hidden.id == other.id).expect("one of them");
    let mut random = Stream::numbered(seed, place as u64 + 1);
    let mut plant = healthy(hidden.sheet, &mut random);
    let size = size(hidden, &mut random);
    (hidden.put)(&mut plant, size);
    (size, pair(hidden.sheet, &plant, &mut random))
}

/// A plant that something is done to, and two records of it.
fn other(seed: u64, stream: u64, put: impl FnOnce(&mut Plant)) -> [Record; 2] {
    let mut random = Stream::numbered(seed, stream);
    let mut plant = healthy(Sheet::Plain, &mut random);
    put(&mut plant);
    pair(Sheet::Plain, &plant, &mut random)
}

fn suggestion(sheet: Sheet, [fit, check]: &[Record; 2]) -> Suggestion {
    suggest(&rig(sheet), fit, Some(check)).unwrap()
}

/// Names that the best explanation goes by.
fn class(suggestion: &Suggestion) -> Vec<String> {
    let Some(best) = suggestion.judged.first() else { return Vec::new() };
    [vec![best.id()], best.confounded_with.clone()].concat()
}

fn outcome((id, alike): (&str, &[&str]), size: f64, suggestion: &Suggestion, [fit, check]: &[Record; 2]) -> Outcome {
    let is_it = |named: &String| named == id || alike.contains(&named.as_str());
    match suggestion.conclusion {
        Conclusion::EffectFound if is_it(&class(suggestion)[0]) => Outcome::Named,
        Conclusion::Confounded if class(suggestion).iter().any(is_it) => Outcome::InClass,
        Conclusion::EffectFound | Conclusion::Confounded => Outcome::Wrong,
        Conclusion::Adequate if !suggestion.base.set.is_empty() => Outcome::Fault,
        conclusion => {
            let report = SuggestionReport::new(suggestion, fit, Some(check)).unwrap();
            let scored = report.scored().into_iter().find(|scored| scored.id == id).cloned();
            let departure = scored.as_ref().map(|scored| (size - neutral(suggestion, scored)).abs());
            let smallest = scored.as_ref().and_then(|scored| smallest(scored, begins(id, size)));
            println!("    {departure:?} of {smallest:?}");
            // Of a level nobody says how small it may be.
            let seen = departure.zip(smallest).is_none_or(|(departure, smallest)| departure > smallest);
            match conclusion {
                _ if !seen => Outcome::Invisible,
                Conclusion::UnknownEffect => Outcome::Unknown,
                _ => Outcome::Missed,
            }
        }
    }
}

/// The smallest size that the record could show, of what begins somewhere that from the next higher place that was tried.
fn smallest(scored: &ScoredReport, from: Option<f64>) -> Option<f64> {
    let Some(from) = from else { return scored.smallest_detectable };
    let beyond = scored.onsets.iter().filter(|onset| onset.from >= from);
    beyond.min_by(|a, b| a.from.total_cmp(&b.from)).and_then(|onset| onset.smallest_detectable)
}

/// The value at which an effect does nothing, in the unit of its size.
fn neutral(suggestion: &Suggestion, scored: &ScoredReport) -> f64 {
    let rig = &suggestion.base.rig;
    let placed = rig.placed(&scored.id).unwrap();
    let free = &placed.effect.parameters[0];
    let own = || rig.bent(&placed, free.name).map(|index| rig.parameters[index].value);
    free.neutral.or_else(|| Some(rig.effect_unit(&placed, free.name).difference_from_si(own()?))).unwrap_or(0.0)
}

fn tell(id: &str, size: f64, seed: u64, suggestion: &Suggestion, seconds: f64) {
    println!(
        "{id} {size:.4} {seed}: {:?}, {:?}, base {:.2} check {:.2} faults {:?}, {seconds:.1} s",
        suggestion.conclusion,
        class(suggestion),
        suggestion.base.fit.chi2,
        suggestion.base_check.as_ref().map_or(f64::NAN, |check| check.chi2),
        suggestion.base.set,
    );
    if std::env::var("VERBOSE").is_err() {
        return;
    }
    for scored in suggestion.scored.iter().take(4) {
        println!("    {} score {:.0} x {:.2} of {:e}", scored.id, scored.score, scored.factor, scored.tried[0].value);
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

/// As many seeds as `SEEDS` says, from `FIRST` on.
fn seeds(number: u64) -> Range<u64> {
    let first = study::number("FIRST", 1);
    first..first + study::number("SEEDS", number)
}

/// What takes minutes to hours.
mod studies {
    use super::*;

    const RATES: &str = "fixtures/studies/rates.csv";

    /// The columns of the table behind the number of cases.
    const OUTCOMES: [Outcome; 7] = [
        Outcome::Named,
        Outcome::InClass,
        Outcome::Missed,
        Outcome::Wrong,
        Outcome::Unknown,
        Outcome::Fault,
        Outcome::Invisible,
    ];

    /// Keeps the outcomes of an effect for the book with `BLESS=1`; without it the effect may not be found more or less often
    /// than when the table was written.
    fn keep(table: &mut Table, id: &str, outcomes: &BTreeMap<Outcome, usize>) {
        // With `RECORDS` nothing was asked.
        if outcomes.is_empty() {
            return;
        }
        let counts = OUTCOMES.map(|outcome| outcomes.get(&outcome).copied().unwrap_or(0));
        let counts = [vec![counts.iter().sum()], counts.to_vec()].concat();
        println!("{id}: {outcomes:?}");
        if page::blessed() {
            table.set(id, counts);
            table.write();
            return;
        }
        let found = |counts: &[usize]| (counts[1] + counts[2], counts[0] - counts[7]);
        let known = table.row(id).unwrap_or_else(|| panic!("{RATES} has no {id}; BLESS=1 writes it"));
        may_be_equal(id, found(&counts), found(known));
    }

    /// The table of rates; `SEEDS` says how many of each, `FIRST` from which on, `ONLY` which effects. With `RECORDS` it writes the records into that folder instead.
    #[test]
    #[ignore = "hours"]
    fn rates() {
        let mut table = Table::read(RATES);
        let only = std::env::var("ONLY").unwrap_or_default();
        for hidden in HIDDEN.iter().filter(|hidden| hidden.id.contains(&only)) {
            let mut outcomes: BTreeMap<Outcome, usize> = BTreeMap::new();
            for seed in seeds(20) {
                let clock = Instant::now();
                let (size, records) = case(hidden, seed);
                if let Ok(folder) = std::env::var("RECORDS") {
                    for record in &records {
                        record.write(format!("{folder}/{}_{seed}_{}.csv", hidden.id, record.path.display())).unwrap();
                    }
                    continue;
                }
                let suggestion = suggestion(hidden.sheet, &records);
                tell(hidden.id, size, seed, &suggestion, clock.elapsed().as_secs_f64());
                *outcomes.entry(outcome((hidden.id, hidden.alike), size, &suggestion, &records)).or_default() += 1;
            }
            keep(&mut table, hidden.id, &outcomes);
        }
    }

    /// The same for the two tanks: a dead voltage, and rims at a share of the level that they would reach.
    #[test]
    #[ignore = "minutes"]
    fn rates_of_the_tanks() {
        let mut table = Table::read(RATES);
        let rig = Rig::read("fixtures/cascaded_tanks/rig.toml").unwrap();
        for (stream, id) in
            ["dead-voltage", "reservoir-overflow@upper", "reservoir-overflow@lower"].into_iter().enumerate()
        {
            let mut outcomes: BTreeMap<Outcome, usize> = BTreeMap::new();
            for seed in seeds(20) {
                let mut random = Stream::numbered(seed, 200 + stream as u64);
                let mut tanks = Tanks::healthy(&mut random);
                let voltages = [voltage(&mut random), voltage(&mut random)];
                let share = random.uniform(0.6, 0.85);
                if stream == 0 {
                    tanks.dead_voltage = random.uniform(0.4, 1.2);
                } else {
                    let levels = tanks.run(&voltages[0]);
                    let highest = levels.iter().map(|levels| levels[stream - 1]).fold(0.0, f64::max);
                    tanks.rims[stream - 1] = share * highest;
                    tanks.share = random.uniform(0.2, 0.8);
                }
                let records = voltages.map(|voltage| tanks.record("tanks", voltage, &mut random));
                let suggestion = suggest(&rig, &records[0], Some(&records[1])).unwrap();
                let size = if stream == 0 { tanks.dead_voltage } else { share };
                tell(id, size, seed, &suggestion, f64::NAN);
                *outcomes.entry(outcome((id, &[]), size, &suggestion, &records)).or_default() += 1;
            }
            keep(&mut table, id, &outcomes);
        }
    }

    #[test]
    #[ignore = "half a minute"]
    fn a_leak_is_named() {
        let hidden = &HIDDEN[0];
        let (size, records) = case(hidden, 1);
        let suggestion = suggestion(hidden.sheet, &records);
        tell(hidden.id, size, 1, &suggestion, f64::NAN);
        assert_eq!(outcome((hidden.id, hidden.alike), size, &suggestion, &records), Outcome::Named);
        let best = &suggestion.judged[0];
        let index = best.trial.rig.parameter("external-leakage@A.conductance").unwrap();
        let found = best.trial.rig.parameters[index].unit.from_si(best.trial.values[index]);
        // The plant's seal gives a little less at high pressure.
        assert!((found / size - 1.0).abs() < 0.05, "{found} {size}");
    }

    #[test]
    #[ignore = "half a minute"]
    fn what_the_record_does_not_show_is_not_found() {
        // With the throttle wide open the reducing valve stands still.
        let suggestion = suggestion(Sheet::Plain, &other(1, 101, |plant| plant.compensator_lag = 20e-3));
        tell("compensator-lag", 20.0, 1, &suggestion, f64::NAN);
        assert_eq!(suggestion.conclusion, Conclusion::Adequate);
        let scored = suggestion.scored.iter().find(|scored| scored.id == "compensator-lag").unwrap();
        assert!(!scored.excited);
    }

    #[test]
    #[ignore = "half a minute"]
    fn a_valve_that_weeps_from_some_pressure_on_is_named() {
        let hidden = HIDDEN.iter().find(|hidden| hidden.id == "relief-weeping").unwrap();
        let (size, records) = case(hidden, 2);
        let suggestion = suggestion(hidden.sheet, &records);
        tell(hidden.id, size, 2, &suggestion, f64::NAN);
        assert_eq!(outcome((hidden.id, hidden.alike), size, &suggestion, &records), Outcome::Named);
    }

    #[test]
    #[ignore = "half a minute"]
    fn slip_and_droop_of_the_pump_are_confounded() {
        let slip = HIDDEN.iter().find(|hidden| hidden.id == "pump-slip").unwrap();
        let suggestion = suggestion(Sheet::Plain, &case(slip, 1).1);
        tell("pump-slip", 0.0, 1, &suggestion, f64::NAN);
        assert_eq!(suggestion.conclusion, Conclusion::Confounded);
        let class = class(&suggestion);
        for id in ["pump-slip", "pump-droop"] {
            assert!(class.iter().any(|other| other == id), "{class:?}");
        }
        println!("{:?}", suggestion.experiment);
    }

    #[test]
    #[ignore = "half a minute"]
    fn a_law_of_the_users_own_is_named() {
        let own = r#"
            [own_effects.tight-spot]
            at = "piston"
            force = "-F * exp(-((piston.x - x0) / w)^2) * tanh(piston.v / [1 mm/s])"
            parameters.F = { neutral = "0 N", first = "200 N" }
            parameters.x0 = { first = "90 mm", bounds = ["0 mm", "170 mm"] }
            parameters.w = { first = "20 mm", bounds = ["1 mm", "100 mm"] }
        "#;
        let path = "fixtures/telescopic/rig.toml";
        let rig = Rig::parse(path, std::fs::read_to_string(path).unwrap() + own).unwrap();
        let [fit, check] = other(1, 102, |plant| plant.dent = 600.0);
        let suggestion = suggest(&rig, &fit, Some(&check)).unwrap();
        tell("dent", 600.0, 1, &suggestion, f64::NAN);
        assert_eq!(
            (suggestion.conclusion, class(&suggestion)),
            (Conclusion::EffectFound, vec!["tight-spot@piston".to_owned()])
        );
        let trial = &suggestion.judged[0].trial;
        for (name, truth) in [("F", 600.0), ("x0", 0.1), ("w", 0.012)] {
            let found = trial.values[trial.rig.parameter(&format!("tight-spot@piston.{name}")).unwrap()];
            assert!((found / truth - 1.0).abs() < 0.1, "{name}: {found} {truth}");
        }
    }

    /// Records that hide nothing.
    #[test]
    #[ignore = "half an hour"]
    fn nothing_is_found_where_nothing_is_hidden() {
        let (seeds, mut found) = (seeds(100), 0);
        let number = seeds.end - seeds.start;
        for seed in seeds {
            let clock = Instant::now();
            let suggestion = suggestion(Sheet::Plain, &other(seed, 0, |_| {}));
            tell("nothing", 0.0, seed, &suggestion, clock.elapsed().as_secs_f64());
            found += usize::from(suggestion.conclusion != Conclusion::Adequate);
        }
        println!("{found} of {number} records that hide nothing are given an effect");
        assert!(found * 100 <= 3 * number as usize);
    }

    /// A tight spot in the bore and play of the load: no effect of the library, and both in the force balance.
    #[test]
    #[ignore = "a minute"]
    fn what_no_law_explains_is_unknown() {
        let dent = other(1, 102, |plant| plant.dent = 600.0);
        let play = other(1, 103, |plant| plant.backlash = 300.0);
        for (name, records) in [("dent", dent), ("play", play)] {
            let suggestion = suggestion(Sheet::Plain, &records);
            tell(name, 0.0, 1, &suggestion, f64::NAN);
            assert_eq!(suggestion.conclusion, Conclusion::UnknownEffect, "{name}");
            let report = SuggestionReport::new(&suggestion, &records[0], Some(&records[1])).unwrap();
            println!("{:?}", report.place);
        }
    }

    #[test]
    #[ignore = "a minute"]
    fn pairs_are_found() {
        let records = other(1, 104, |plant| {
            plant.external_leak[A] = 1e-12;
            plant.load_stiffness = 4e3;
        });
        let suggestion = suggestion(Sheet::Plain, &records);
        tell("external-leakage@A + load-stiffness", 0.0, 1, &suggestion, f64::NAN);
        assert_eq!(suggestion.conclusion, Conclusion::EffectFound);
        let mut pair: Vec<String> = suggestion.judged[0].effects.iter().map(|effect| effect.id.clone()).collect();
        pair.sort_unstable();
        assert_eq!(pair, ["external-leakage@A", "load-stiffness"]);
    }
}
