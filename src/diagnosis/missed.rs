//! How a model misses each sensor, by its weighted misfits, and whether that is within noise and tolerance.

use super::DIGITS;
use super::noise::Weights;
use crate::number::rounded;
use crate::settings::DiagnosisSettings;

/// Whether the mean square of the weighted misfits of a channel of so many samples is that of an adequate model.
pub(crate) fn adequate(settings: &DiagnosisSettings, chi2: f64, samples: usize) -> bool {
    let chance = settings.adequate_deviations * (2.0 / samples.max(1) as f64).sqrt();
    chi2 <= settings.adequate_mean_square + chance
}

/// Sum of squares of weighted misfits, wild ones tamed.
pub(crate) fn tame_squares(settings: &DiagnosisSettings, misfit: &[f64]) -> f64 {
    misfit.iter().map(|r| tame(settings, *r)).sum()
}

/// Square of a weighted misfit, that of a wild one cut off.
pub(crate) fn tame(settings: &DiagnosisSettings, misfit: f64) -> f64 {
    misfit.abs().min(settings.outlier_misfit).powi(2)
}

/// Whether the fit has a sample of this weighted misfit: the others weigh nothing.
pub(crate) fn is_there(misfit: f64) -> bool {
    misfit != 0.0
}

/// How a model misses one sensor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Missed {
    /// Mean square of the weighted misfits, wild ones tamed.
    pub square: f64,
    pub samples: usize,
    /// [`Weights::asked_of_events`].
    events: (f64, f64),
}

impl Missed {
    /// Whether the model explains the sensor within noise and tolerance, with events as they may be.
    pub fn is_explained(&self, settings: &DiagnosisSettings) -> bool {
        self.is_within_noise(settings) && self.are_events_plausible(settings)
    }

    /// The same whatever is asked of events.
    pub fn is_within_noise(&self, settings: &DiagnosisSettings) -> bool {
        adequate(settings, self.square, self.samples)
    }

    /// What is allowed for events is no licence: `n` ways to differ have a mean square of 1 where the rig file is right about them, and
    /// chance makes it no larger than its quantile (Wilson and Hilferty, Proceedings of the National Academy of Sciences 17 (1931)).
    fn are_events_plausible(&self, settings: &DiagnosisSettings) -> bool {
        let (square, ways) = self.events;
        let variance = 2.0 / (9.0 * ways);
        ways == 0.0 || square <= (1.0 - variance + settings.adequate_deviations * variance.sqrt()).powi(3)
    }

    /// Mean square of what is asked of events, in what they may differ by; `None` without any.
    pub fn events(&self) -> Option<f64> {
        let (square, ways) = self.events;
        (ways > 0.0).then(|| rounded(square, DIGITS))
    }
}

/// How a model misses each sensor, by its weighted misfits.
pub(crate) fn missed(settings: &DiagnosisSettings, weights: &Weights, misfit: &[f64]) -> Vec<Missed> {
    let sensors = weights.sensors();
    let events = weights.asked_of_events(settings, misfit);
    let one = |(sensor, misfit): (usize, &[f64])| {
        let samples = weights.samples(sensor);
        Missed { square: tame_squares(settings, misfit) / samples.max(1) as f64, samples, events: events[sensor] }
    };
    // Behind the sensors may stand what is known before.
    misfit.chunks(weights.rows().max(1)).take(sensors).enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::Missed;
    use crate::settings::DiagnosisSettings;

    fn is_explained(square: f64, ways: f64) -> bool {
        Missed { square: 1.0, samples: 1000, events: (square, ways) }.is_explained(&DiagnosisSettings::default())
    }

    #[test]
    fn what_is_allowed_for_events_is_no_licence() {
        // (1 - 2/90 + 4 sqrt(2/90))^3 = 3.900, of one alone 18.9: 4.3 standard deviations.
        assert!(is_explained(3.89, 10.0) && !is_explained(3.92, 10.0));
        assert!(is_explained(18.8, 1.0) && !is_explained(19.0, 1.0));
        assert!(is_explained(0.0, 0.0));
    }
}
