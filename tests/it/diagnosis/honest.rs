//! What the diagnosis claims of itself, against what happens: intervals, false alarms and probabilities on rigs that differ
//! from the model, within the bounds that chance leaves (Clopper and Pearson, 99.9 %).

use borescope::Rig;
use borescope::internals::campaign::score::Scores;
use borescope::internals::campaign::statistics::{lower, upper};
use borescope::internals::campaign::{Campaign, CampaignOptions};

use crate::support::page;
use crate::support::study::{TAIL, Table, may_be_equal, number};

fn scores(rig: &str, cases: usize, rigs: usize, seed: u64) -> Scores {
    let options = CampaignOptions { seed, rigs, ..CampaignOptions::new(cases) };
    let campaign = Campaign::new(Rig::read(rig).unwrap(), options).unwrap();
    let numbers: Vec<usize> = (0..cases).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut rows = Vec::new();
    campaign
        .run(&numbers, threads, |row| {
            rows.push(row);
            Ok(())
        })
        .unwrap();
    rows.sort_by_key(|row| row.case);
    Scores::of(&rows)
}

/// Intervals hold the truth as often as they claim, healthy rigs are left alone, probabilities are as often right.
fn check(scores: &Scores, false_alarms: f64, isolated: f64) {
    let all = &scores.all;
    let cases = all.false_alarms.of + all.detected.of;
    for coverage in [&all.coverage_found, &all.coverage_all] {
        // The intervals of one case share its record and its rig: a case counts once, however many intervals it has.
        let each = (coverage.of as f64 / cases as f64).max(1.0);
        let [count, of] = [coverage.count, coverage.of].map(|number| (number as f64 / each).round() as usize);
        let (low, high) = (lower(count, of, TAIL), upper(count, of, TAIL));
        assert!(low <= 0.95 && high >= 0.93, "{} of {} intervals hold the truth", coverage.count, coverage.of);
    }
    let alarms = &all.false_alarms;
    assert!(lower(alarms.count, alarms.of, TAIL) <= false_alarms, "{} of {} false alarms", alarms.count, alarms.of);
    let right = &all.isolated;
    assert!(upper(right.count, right.of, TAIL) >= isolated, "{} of {} isolated", right.count, right.of);
    for bin in &scores.reliability.bins {
        let Some(mean) = bin.mean_probability else { continue };
        let (low, high) = (lower(bin.right.count, bin.right.of, TAIL), upper(bin.right.count, bin.right.of, TAIL));
        // Probabilities are given to a hundredth.
        assert!(low <= mean + 0.01 && mean - 0.01 <= high, "{} of {} with {mean}", bin.right.count, bin.right.of);
    }
}

#[test]
fn claims_on_two_tanks_hold() {
    check(&scores("fixtures/two_tanks/rig.toml", 150, 15, 4), 0.005, 0.97);
}

/// What takes minutes to hours.
mod studies {
    use super::*;

    /// `CASES` of them, 2,000 take hours. `BLESS=1` keeps the scores for the book, without it they may not differ from those.
    #[test]
    #[ignore = "takes a quarter of an hour"]
    fn claims_on_the_telescopic_rig_hold() {
        let cases = number("CASES", 200);
        let scores = scores("fixtures/telescopic/rig.toml", cases, (cases / 25).max(1), number("SEED", 2));
        compare(&scores);
        check(&scores, 0.005, 0.97);
    }

    fn compare(scores: &Scores) {
        let mut table = Table::read("fixtures/studies/campaign.csv");
        let all = &scores.all;
        let clearance = scores.faults.iter().find(|fault| fault.id == "cylinder.clearance").unwrap();
        let identifiable = scores.identifiable.as_ref().unwrap_or(all);
        // Intervals of one case are correlated, so their counts are held to what they claim and not to each other.
        for (name, rate, independent) in [
            ("false alarms", &all.false_alarms, true),
            ("true detection rate", &all.detected, true),
            ("exact isolation where the faults are identifiable at their size", &identifiable.isolated, true),
            ("exact isolation of all", &all.isolated, true),
            ("coverage of found faults", &all.coverage_found, false),
            ("coverage of all faults", &all.coverage_all, false),
            ("clearances found", &clearance.found, true),
        ] {
            if page::blessed() {
                table.set(name, vec![rate.count, rate.of]);
            } else if independent {
                let row = table.row(name).unwrap_or_else(|| panic!("no {name}"));
                may_be_equal(name, (rate.count, rate.of), (row[0], row[1]));
            }
        }
        if page::blessed() {
            table.write();
        }
    }
}
