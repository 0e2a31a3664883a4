//! Whether calibration has made a model worse: its error before and after, as root mean square in the unit of each sensor.
//!
//! The fit minimises weighted and robust misfits, with noise and tolerance that it estimates itself. Where the model lacks something,
//! these weights can prefer a model that runs away from the record: a drift over each phase becomes tolerance. The plain error
//! of the sensors has no such freedom.

use super::CalibrationReport;
use crate::complaint::{Complaint, Kind, Place};
use crate::number::{rounded, with_unit};
use crate::rig::Rig;

/// Root mean square errors of one sensor over all records, in its unit.
#[derive(Debug, Clone, PartialEq)]
struct Error {
    name: String,
    unit: String,
    before: f64,
    after: f64,
    /// What the rig file allows: noise of a sample and tolerance of the model as stated.
    allowed: f64,
}

impl Error {
    /// Whether the error has risen by more than stated noise and tolerance; independent errors add by their squares.
    fn rose(&self) -> bool {
        self.after.powi(2) - self.before.powi(2) > self.allowed.powi(2)
    }

    /// Twice the change of the log-likelihood per sample with the size of the error estimated; what is stated is its floor.
    fn change(&self) -> f64 {
        let floor = self.allowed.powi(2);
        let (before, after) = (self.before.powi(2) + floor, self.after.powi(2) + floor);
        // A sensor without noise that the model follows exactly, before and after.
        if before == after { 0.0 } else { (after / before).ln() }
    }
}

/// Refuses a calibration that has made the model worse: an error has risen above what noise and tolerance allow, and the
/// sensors together have lost by it. A sensor may lose where others gain more.
///
/// # Errors
/// Names the sensor that has lost most, with its error before and after.
pub(super) fn refuse(sheet: &Rig, report: &CalibrationReport) -> Result<(), Complaint> {
    let errors = pooled(report);
    let total: f64 = errors.iter().map(Error::change).sum();
    let Some(worst) = errors.iter().filter(|error| error.rose()).max_by(|a, b| a.change().total_cmp(&b.change()))
    else {
        return Ok(());
    };
    if total <= 0.0 {
        return Ok(());
    }
    let shown = |value: f64| with_unit(rounded(value, 3), &worst.unit);
    let mut complaint = Complaint::new(
        Kind::Computation,
        format!(
            "calibration would make the model worse: the error of `{}` rises from {} to {}, so nothing is written",
            worst.name,
            shown(worst.before),
            shown(worst.after)
        ),
    )
    .at(Place::file(&sheet.path));
    complaint.places.extend(report.records.iter().map(|record| Place::file(&record.record)));
    Err(complaint
        .help("the model lacks something that these records show: find it with `borescope suggest`, then calibrate"))
}

/// Errors of each sensor over all records; each record counts by its rows.
fn pooled(report: &CalibrationReport) -> Vec<Error> {
    let rows: usize = report.records.iter().map(|record| record.rows).sum();
    let pool = |sensor: usize, of: fn(&super::ChannelFit) -> f64| {
        let square = |record: &super::RecordFit| record.rows as f64 * of(&record.channels[sensor]).powi(2);
        (report.records.iter().map(square).sum::<f64>() / rows.max(1) as f64).sqrt()
    };
    let errors = report.sensors.iter().enumerate().map(|(index, sensor)| Error {
        name: sensor.name.clone(),
        unit: sensor.unit.clone(),
        before: pool(index, |channel| channel.rmse_before),
        after: pool(index, |channel| channel.rmse),
        allowed: sensor.noise_before.hypot(sensor.tolerance_before),
    });
    errors.collect()
}

#[cfg(test)]
mod tests {
    use super::Error;

    fn error(before: f64, after: f64, allowed: f64) -> Error {
        Error { name: "x".to_owned(), unit: "mm".to_owned(), before, after, allowed }
    }

    #[test]
    fn an_error_rises_only_by_more_than_noise_and_tolerance() {
        assert!(error(2.1, 85.0, 0.03).rose());
        assert!(!error(3.0, 5.0, 4.0).rose(), "5 squared is 3 squared and 4 squared: just what is allowed");
        assert!(error(3.0, 5.01, 4.0).rose());
        assert!(!error(6.6, 1.7, 0.03).rose());
    }

    #[test]
    fn the_change_is_the_logarithm_of_the_variance_ratio_above_the_floor() {
        assert!((error(1.0, 2.0, 0.0).change() - 4.0_f64.ln()).abs() < 1e-12);
        assert!((error(3.0, 0.0, 4.0).change() - (16.0_f64 / 25.0).ln()).abs() < 1e-12);
        assert_eq!(error(0.0, 0.0, 0.0).change(), 0.0);
    }
}
