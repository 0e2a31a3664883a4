//! Calibration of rigs that are not what the model says: how far are the calibrated values from the true ones, in the standard
//! errors that they claim?

use std::collections::BTreeMap;

use borescope::Rig;
use borescope::internals::campaign::{Campaign, CampaignOptions};
use rayon::prelude::*;

use crate::support::study::{may_be, number};

/// Errors of all calibrated parameters of so many disturbed rigs, in standard errors, by the parameter.
fn errors(rigs: usize, seed: u64) -> BTreeMap<String, Vec<f64>> {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
    let options = CampaignOptions { seed, rigs, ..CampaignOptions::new(rigs) };
    let campaign = Campaign::new(rig, options).unwrap();
    let one = |number: usize| {
        let prepared = campaign.prepared(number).unwrap();
        let (found, truth) = (&prepared.model.as_ref().unwrap().rig, &prepared.disturbed.rig);
        let calibrated = found.calibration.as_ref().unwrap().parameters.iter();
        let error = |&index: &usize| {
            let found = &found.parameters[index];
            // Margins have no truth: the disturbed rig has another law.
            let truth = &truth.parameters[truth.parameter(&found.id)?];
            Some((found.id.clone(), (found.value - truth.value) / found.sigma))
        };
        calibrated.filter_map(error).collect::<Vec<_>>()
    };
    let all: Vec<Vec<(String, f64)>> = (0..rigs).into_par_iter().map(one).collect();
    let mut by: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    all.into_iter().flatten().for_each(|(id, error)| by.entry(id).or_default().push(error));
    by
}

/// Errors of one rig are correlated: its 30 or so tell as much as this many independent ones.
const INDEPENDENT: usize = 10;

/// The 50 % and the 95 % intervals of all calibrated parameters hold the truth as often as they say: neither too short nor too
/// wide for chance. The middle of the distribution bites on wide ones, of which 95 % intervals cannot hold too much.
fn check(rigs: usize, seed: u64) {
    let by = errors(rigs, seed);
    for (id, errors) in &by {
        println!("{id:45} {errors:6.2?}");
    }
    let all: Vec<f64> = by.into_values().flatten().collect();
    for (deviations, claimed) in [(0.674, 0.5), (1.96, 0.95)] {
        let within = all.iter().filter(|error| error.abs() <= deviations).count() as f64 / all.len() as f64;
        println!("{} errors, {within:.3} within {deviations}", all.len());
        let of = INDEPENDENT * rigs;
        may_be("intervals that hold the truth", ((within * of as f64).round() as usize, of), claimed);
    }
}

#[test]
fn calibrated_values_are_about_as_sure_as_they_claim() {
    check(4, 11);
}

/// What takes minutes.
mod studies {
    use super::*;

    /// `RIGS` of them.
    #[test]
    #[ignore = "takes a minute"]
    fn calibrated_values_are_as_sure_as_they_claim() {
        check(number("RIGS", 24), 12);
    }
}
