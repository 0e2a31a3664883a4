//! Calibration of rigs that are not what the model says: how far are the calibrated values from the true ones, in the standard
//! errors that they claim?

use std::collections::BTreeMap;

use borescope::Rig;
use borescope::internals::calibration::{CalibrationOptions, calibrate_rig};
use borescope::internals::campaign::disturb::well_known;
use borescope::internals::campaign::random::Stream;
use borescope::internals::campaign::{Campaign, CampaignOptions};
use borescope::internals::rig::Parameter;
use rayon::prelude::*;

use crate::support::plant::Plant;
use crate::support::plant::record::{cycle, record};
use crate::support::study::{may_be, number};

const RIG: &str = "fixtures/telescopic/rig.toml";

/// A plant whose values stray from the data sheet by what calibration expects of a data sheet, with a spool of second order and dead
/// time; and the true values of what strays, by the parameter of the rig file.
fn strayed(rig: &Rig, random: &mut Stream) -> (Plant, Vec<(String, f64)>) {
    let sheet = Plant::default();
    let mut truth = Vec::new();
    let mut draw = |id: &str| {
        let parameter = &rig.parameters[rig.parameter(id).unwrap()];
        let value = parameter.value + parameter.spread.max(parameter.sigma) * random.normal();
        let value = if parameter.value > 0.0 { value.max(0.2 * parameter.value) } else { value };
        truth.push((id.to_owned(), value));
        (value, value / parameter.value)
    };
    let mut plant = Plant {
        bulk_modulus: draw("fluid.bulk_modulus").0,
        viscosity: draw("fluid.viscosity").0,
        pump_flow: sheet.pump_flow * draw("pump.displacement").1,
        set_pressure: draw("relief.set_pressure").0,
        discharge: draw("flow_control.discharge_coefficient").0,
        reducing_discharge: draw("flow_control.reducing_discharge_coefficient").0,
        rated_drop: draw("directional_valve.rated_drop").0,
        viscous: draw("cylinder.viscous_friction").0,
        ..sheet
    };
    for (sensor, reading) in rig.sensors.iter().zip(&mut plant.readings) {
        reading.offset = draw(&format!("sensor.{}.offset", sensor.name)).0;
        reading.gain = draw(&format!("sensor.{}.gain", sensor.name)).0;
    }
    // What no circuit is quite without, as far as calibration expects it.
    let mut size = |of: f64| of * random.normal().abs();
    plant.external_leak = [0.0; 4].map(|_: f64| size(0.0002e-3 / 60.0 / 1e5));
    plant.hole_in_piston = size(0.005e-6);
    plant.coulomb = size(15.0);
    plant.spool_damping = random.uniform(0.6, 1.0);
    plant.spool_lags = [random.uniform(6e-3, 12e-3), 0.0];
    plant.dead_rows = random.uniform(0.0, 3.0) as usize;
    (plant, truth)
}

/// The same errors of so many plants with such spools, each calibrated on two records.
fn errors_of_plants(plants: usize, seed: u64) -> BTreeMap<String, Vec<f64>> {
    let rig = Rig::read(RIG).unwrap();
    let one = |number: usize| {
        let mut random = Stream::numbered(seed, number as u64);
        let (plant, truth) = strayed(&rig, &mut random);
        let mut healthy = || {
            let phases = cycle(&mut random, 1.0);
            record("healthy", &plant, &phases, &mut random)
        };
        let (found, _) = calibrate_rig(&rig, &[healthy(), healthy()], &CalibrationOptions::default()).unwrap();
        let error = |(id, truth): (String, f64)| {
            let found = &found.parameters[found.parameter(&id).unwrap()];
            is_told(&rig, found).then(|| (id, (found.value - truth) / found.sigma))
        };
        truth.into_iter().filter_map(error).collect::<Vec<_>>()
    };
    by_parameter((0..plants).into_par_iter().map(one).collect())
}

/// Whether the records have halved the variance of a calibrated parameter: of what they leave as it was, an interval is as true as what
/// was known before, which is no matter of calibration.
fn is_told(before: &Rig, found: &Parameter) -> bool {
    let before = &before.parameters[before.parameter(&found.id).unwrap()];
    found.sigma < std::f64::consts::FRAC_1_SQRT_2 * before.spread.max(before.sigma)
}

fn by_parameter(all: Vec<Vec<(String, f64)>>) -> BTreeMap<String, Vec<f64>> {
    let mut by: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    all.into_iter().flatten().for_each(|(id, error)| by.entry(id).or_default().push(error));
    by
}

/// Errors of all calibrated parameters of so many disturbed rigs, in standard errors, by the parameter. What is expected of a data sheet
/// is how far these rigs stray from it: a standard error that holds as often as it says can only be asked of a right expectation.
fn errors(rigs: usize, seed: u64) -> BTreeMap<String, Vec<f64>> {
    let rig = Rig::read(RIG).unwrap();
    let sheet = well_known(&rig);
    let options = CampaignOptions { seed, rigs, ..CampaignOptions::new(rigs) };
    let campaign = Campaign::new(rig, options).unwrap();
    let one = |number: usize| {
        let prepared = campaign.prepared(number).unwrap();
        let (found, _) = calibrate_rig(&sheet, &prepared.records, &CalibrationOptions::default()).unwrap();
        let truth = &prepared.disturbed.rig;
        let calibrated = found.calibration.as_ref().unwrap().parameters.iter();
        let error = |&index: &usize| {
            let found = &found.parameters[index];
            // Margins have no truth: the disturbed rig has another law.
            let truth = &truth.parameters[truth.parameter(&found.id)?];
            is_told(&sheet, found).then(|| (found.id.clone(), (found.value - truth.value) / found.sigma))
        };
        calibrated.filter_map(error).collect::<Vec<_>>()
    };
    by_parameter((0..rigs).into_par_iter().map(one).collect())
}

/// Errors of one rig are correlated: its 30 or so tell as much as this many independent ones.
const INDEPENDENT: usize = 10;

/// Half of all, which bites on intervals that are too wide, and 95 % of all: standard errors and the share that they hold.
const HALF: (f64, f64) = (0.674, 0.5);
const MOST: (f64, f64) = (1.96, 0.95);

/// The intervals of calibrated parameters hold the truth as often as they say: neither too short nor too wide for chance.
fn check(by: BTreeMap<String, Vec<f64>>, rigs: usize, claims: &[(f64, f64)]) {
    for (id, errors) in &by {
        println!("{id:45} {errors:6.2?}");
    }
    let all: Vec<f64> = by.into_values().flatten().collect();
    for (deviations, _) in [HALF, MOST] {
        let within = all.iter().filter(|error| error.abs() <= deviations).count() as f64 / all.len() as f64;
        println!("{} errors, {within:.3} within {deviations}", all.len());
    }
    for &(deviations, claimed) in claims {
        let within = all.iter().filter(|error| error.abs() <= deviations).count() as f64 / all.len() as f64;
        let of = INDEPENDENT * rigs;
        may_be("intervals that hold the truth", ((within * of as f64).round() as usize, of), claimed);
    }
}

#[test]
fn calibrated_values_are_about_as_sure_as_they_claim() {
    check(errors(4, 11), 4, &[HALF, MOST]);
}

/// What takes minutes.
mod studies {
    use super::*;

    /// `RIGS` of them.
    #[test]
    #[ignore = "takes a minute"]
    fn calibrated_values_are_as_sure_as_they_claim() {
        let rigs = number("RIGS", 24);
        check(errors(rigs, 12), rigs, &[HALF, MOST]);
    }

    /// `RIGS` of them.
    #[test]
    #[ignore = "takes minutes"]
    fn spools_with_mass_leave_calibrated_values_as_sure_as_they_claim() {
        let rigs = number("RIGS", 40);
        check(errors_of_plants(rigs, 13), rigs, &[MOST]);
    }
}
