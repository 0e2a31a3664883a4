//! A record simulated with given parameters, and how far it is missed.

use crate::complaint::Complaint;
use crate::diagnosis::noise::Weights;
use crate::diagnosis::problem::{away, over_sensors, root_mean_square};
use crate::diagnosis::{self, is_there, weighed};
use crate::number::{rounded, text};
use crate::record::Record;
use crate::rig::Rig;
use crate::settings::Settings;

/// A record simulated with given parameters.
#[derive(Debug, Clone)]
pub struct Run {
    /// What the sensors would show, `[sensor][row]`, SI.
    pub outputs: Vec<Vec<f64>>,
    /// Misfits weighted by noise and tolerance, one sensor after the other.
    pub misfit: Vec<f64>,
    pub weights: Weights,
    /// Root mean square of measured minus model per sensor, SI.
    pub rmse: Vec<f64>,
    /// The same over the noise of the sensor, over all of them.
    pub normalised: f64,
    /// Mean square of the weighted misfits, single wild ones tamed: 1 if the model is right within its tolerance.
    pub chi2: f64,
    /// The same of each sensor.
    pub of_sensors: Vec<f64>,
    /// Whether every sensor is explained within noise and tolerance.
    pub is_adequate: bool,
    /// Parameters that may be otherwise, as far as is known of them, and change readings by more than noise then: by index of the rig's, what
    /// changes them most first.
    pub left_open: Vec<usize>,
}

/// Root mean square misfits of the sensors, SI, as one error, times the sensor noise.
pub(super) fn times_noise(rig: &Rig, missed: &[Option<f64>]) -> f64 {
    over_sensors(missed.iter().zip(&rig.sensors).map(|(rms, sensor)| rms.map(|rms| rms / sensor.stated_noise)))
}

/// An error in times the sensor noise, as a first look tells it.
pub(super) fn misses(times_noise: f64) -> String {
    format!("your model misses the record by {} times the sensor noise", text(rounded(times_noise, 2)))
}

/// A run whose outputs are known.
pub(super) fn run_of(rig: &Rig, record: &Record, outputs: Vec<Vec<f64>>, weights: Weights) -> Result<Run, Complaint> {
    let data = weighed::measured(rig, record)?;
    let mut misfit = away(&outputs, &data);
    let missed: Vec<Option<f64>> =
        outputs.iter().zip(&data).map(|(model, measured)| root_mean_square(model, measured)).collect();
    let normalised = times_noise(rig, &missed);
    let rmse = missed.iter().map(|rms| rms.unwrap_or(0.0)).collect();
    weights.apply(&mut misfit);
    let lasting = |misfit: &[f64]| lasting_squares(rig.settings(), misfit);
    let squares: Vec<f64> = misfit.chunks(weights.rows().max(1)).take(rig.sensors.len()).map(lasting).collect();
    let chi2 = squares.iter().sum::<f64>() / weights.all_samples().max(1) as f64;
    let mean = |(sensor, squares): (usize, &f64)| squares / weights.samples(sensor).max(1) as f64;
    let of_sensors = squares.iter().enumerate().map(mean).collect();
    let settings = &rig.settings().diagnosis;
    let is_adequate = diagnosis::missed(settings, &weights, &misfit).iter().all(|one| one.is_explained(settings));
    Ok(Run { outputs, misfit, weights, rmse, normalised, chi2, of_sensors, is_adequate, left_open: Vec::new() })
}

/// Sum of squares of the weighted misfits of a sensor. One that base points out from those around it counts as no more than a wild
/// sample; what lasts counts in full, so that twice the error is four times the sum however large it is.
fn lasting_squares(settings: &Settings, misfit: &[f64]) -> f64 {
    let (lasting, outlier) = (settings.learn.lasting_rows, settings.diagnosis.outlier_misfit);
    let sizes: Vec<f64> = misfit.iter().copied().filter(|misfit| is_there(*misfit)).map(f64::abs).collect();
    let around = |row: usize| {
        let mut near = sizes[row.saturating_sub(lasting)..(row + lasting + 1).min(sizes.len())].to_vec();
        near.sort_by(f64::total_cmp);
        near[near.len() / 2]
    };
    let one = |(row, size): (usize, &f64)| if *size <= outlier { *size } else { size.min(around(row).max(outlier)) };
    sizes.iter().enumerate().map(one).map(|size| size * size).sum()
}
