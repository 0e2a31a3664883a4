//! What a record is weighed by while its model lacks something: the noise that the record shows, and the lack of fit.
//!
//! A model that lacks physics misses by far more than noise. Weighed by noise alone, its misfit overrules all that data sheets
//! say, and parameters run to wherever they mimic a little of what is missing. So the variance of each sensor is raised to
//! what the fitted model leaves there (quasi-likelihood: Wedderburn, Biometrika 61, 1974; McCullagh and Nelder, *Generalized
//! Linear Models*, 1989, section 9.2), and falls again as effects are added. A model that explains its record is weighed by noise.
//!
//! The noise is that of the rig file where the record bears it out. Where the two differ by more than `learn.noise_ratio`, the record is
//! believed: what is named then does not hang on a number that nobody measured.

use super::run::Run;
use crate::diagnosis::adequate;
use crate::record::Record;
use crate::rig::Rig;
use crate::settings::LearningSettings;

/// Median of the absolute second difference of independent normal noise, in its standard deviations: 0.6745 sqrt(6).
const SECOND_DIFFERENCE: f64 = 1.652;

/// The rig with the noise that a record shows where that is not what the rig file states.
pub(super) fn with_shown_noise(rig: &Rig, record: &Record) -> Rig {
    let (mut rig, settings) = (rig.clone(), &rig.settings().learn);
    let columns: Vec<Option<&[f64]>> = rig
        .sensors
        .iter()
        .map(|sensor| rig.sensor_column(record, sensor).ok().map(|channel| channel.values.as_slice()))
        .collect();
    for (sensor, values) in rig.sensors.iter_mut().zip(columns) {
        let Some(shown) = values.and_then(|values| shown(settings, values, sensor.resolution)) else { continue };
        let ratio = shown / sensor.noise;
        if (1.0 / settings.noise_ratio..=settings.noise_ratio).contains(&ratio) {
            continue;
        }
        sensor.noise = shown;
        // What is stated in its own right stays.
        if !sensor.tolerance_is_stated {
            sensor.tolerance *= ratio;
        }
    }
    rig
}

/// Noise of a channel by its second differences, SI: steady motion has none. No less than half a digit; `None` where
/// too few rows show any.
fn shown(settings: &LearningSettings, values: &[f64], resolution: f64) -> Option<f64> {
    let there: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    let mut bends: Vec<f64> = there.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs()).collect();
    if bends.len() < settings.noise_differences {
        return None;
    }
    let middle = bends.len() / 2;
    let median = *bends.select_nth_unstable_by(middle, f64::total_cmp).1;
    // Noise of less than half a digit leaves most rows as they would be without.
    let shown = (median / SECOND_DIFFERENCE).max(0.5 * resolution);
    (shown > 0.0).then_some(shown)
}

/// The rig with the lack of fit that a run of it leaves at each sensor.
pub(super) fn with_lack_of_fit(rig: &Rig, run: &Run) -> Rig {
    let (mut rig, settings) = (rig.clone(), &rig.settings().diagnosis);
    for (index, sensor) in rig.sensors.iter_mut().enumerate() {
        sensor.lack_of_fit = 0.0;
        let chi2 = run.of_sensors[index];
        if !adequate(settings, chi2, run.weights.samples(index)) {
            sensor.lack_of_fit = (sensor.variance() * (chi2 - 1.0)).sqrt();
        }
    }
    rig
}

/// The rig without any lack of fit: what models are judged by.
pub(super) fn without_lack_of_fit(rig: &Rig) -> Rig {
    let mut rig = rig.clone();
    rig.sensors.iter_mut().for_each(|sensor| sensor.lack_of_fit = 0.0);
    rig
}

/// Whether a rig has any lack of fit.
pub(super) fn has_lack_of_fit(rig: &Rig) -> bool {
    rig.sensors.iter().any(|sensor| sensor.lack_of_fit > 0.0)
}

/// Whether two rigs lack as much at each sensor.
pub(super) fn is_alike(a: &Rig, b: &Rig) -> bool {
    let same = a.settings().learn.lack_of_fit_ratio;
    let spread = |a: f64, b: f64| a.max(b) <= same * same * a.min(b);
    a.sensors.iter().zip(&b.sensors).all(|(a, b)| spread(a.variance(), b.variance()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::random::Stream;

    #[test]
    fn noise_shows_beneath_steady_motion_and_steps() {
        let mut random = Stream::numbered(3, 0);
        let values: Vec<f64> = (0..2000)
            .map(|row| 0.01 * f64::from(row) + if row > 700 { 40.0 } else { 0.0 } + 0.25 * random.normal())
            .collect();
        let found = shown(&LearningSettings::default(), &values, 0.0).unwrap();
        // The median of 2,000 correlated values is known to some percent.
        assert!((found / 0.25 - 1.0).abs() < 0.1, "{found}");
    }

    #[test]
    fn a_channel_that_only_shows_its_digits_has_noise_of_half_a_digit_at_most() {
        let values: Vec<f64> = (0..500).map(|row| (0.003 * f64::from(row)).floor()).collect();
        assert_eq!(shown(&LearningSettings::default(), &values, 1.0), Some(0.5));
        assert_eq!(shown(&LearningSettings::default(), &[1.0; 500], 0.0), None);
        assert_eq!(shown(&LearningSettings::default(), &[1.0, 2.0, 1.0], 0.0), None);
    }
}
