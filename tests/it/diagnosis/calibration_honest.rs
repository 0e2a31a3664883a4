//! Calibration of rigs that are not what the model says: how far are the calibrated values from the true ones, in the standard
//! errors that they claim?

use std::collections::BTreeMap;

use borescope::campaign::{Campaign, Options};
use borescope::rig::Rig;
use rayon::prelude::*;

/// Errors of all calibrated parameters of so many disturbed rigs, in standard errors, by the parameter.
fn errors(rigs: usize, seed: u64) -> BTreeMap<String, Vec<f64>> {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
    let options = Options { seed, rigs, ..Options::new(rigs) };
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

/// Share of the errors within 1.96 standard errors, of all calibrated parameters.
fn within(rigs: usize, seed: u64) -> f64 {
    let by = errors(rigs, seed);
    for (id, errors) in &by {
        println!("{id:45} {errors:6.2?}");
    }
    let all: Vec<f64> = by.into_values().flatten().collect();
    let within = all.iter().filter(|error| error.abs() <= 1.96).count() as f64 / all.len() as f64;
    println!("{} errors, {within:.3} within 1.96", all.len());
    within
}

#[test]
fn calibrated_values_are_about_as_sure_as_they_claim() {
    let within = within(4, 11);
    // 128 errors, correlated within a rig: as if they were 40 (binomial, 99 %).
    assert!((0.85..=1.0).contains(&within), "{within}");
}

/// `RIGS` of them.
#[test]
#[ignore = "takes a minute"]
fn calibrated_values_are_as_sure_as_they_claim() {
    let rigs = std::env::var("RIGS").map_or(24, |rigs| rigs.parse().unwrap());
    let within = within(rigs, 12);
    assert!((0.92..=0.985).contains(&within), "{within}");
}
