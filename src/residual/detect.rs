//! Detection: which residuals have left zero, since when, and by how much.

use serde::Serialize;

use super::cusum::{self, Direction};
use super::find::generators;
use super::form::CLOSED;
use super::generator::{Gate, Generator, Series, Variant};
use crate::complaint::Complaint;
use crate::model::Drive;
use crate::record::Record;
use crate::rig::Rig;

/// How careful detection is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Mean time of healthy record between false alarms, over all residuals and both directions together, h.
    pub hours_between_false_alarms: f64,
    /// Length of a window, s. Windows of ten sensor lags or more are independent: the noise is added behind the lag, and
    /// windows do not overlap.
    pub window: f64,
    /// Shift to be found fastest, in standard deviations of one window.
    pub shift: f64,
    /// Standard deviations of tolerance within which a bias is no fault.
    pub coverage: f64,
}

impl Default for Detection {
    fn default() -> Self {
        Self { hours_between_false_alarms: 1000.0, window: 0.1, shift: 1.0, coverage: 3.0 }
    }
}

impl Detection {
    /// Reference value of the CUSUM, in standard deviations.
    pub fn reference(&self) -> f64 {
        0.5 * self.shift
    }

    /// Threshold of each side of each of `residuals` CUSUMs over windows of `window` s (Bonferroni), in standard
    /// deviations. The clock is that of the record: windows that do not count make it safer.
    pub fn threshold(&self, residuals: usize, window: f64) -> f64 {
        let windows = self.hours_between_false_alarms * 3600.0 / window;
        cusum::threshold(self.reference(), 2.0 * residuals.max(1) as f64 * windows)
    }
}

/// What one residual says about a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualReport {
    pub id: String,
    pub equation: &'static str,
    pub variant: Variant,
    /// Mean over the windows that count, each weighed by its variance; in `unit`, `None` without such windows.
    pub mean: Option<f64>,
    /// Standard error of the mean by sensor noise, in `unit`.
    pub sigma: Option<f64>,
    /// One standard deviation of the mean by uncertain parameters and rounding, in `unit`.
    pub tolerance: Option<f64>,
    pub unit: String,
    /// Whether the residual has left zero by more than noise and tolerance explain.
    pub fired: bool,
    /// End of the window of the alarm, s.
    pub alarm_at_s: Option<f64>,
    /// Start of the window since which the sum has grown, s.
    pub onset_s: Option<f64>,
    pub direction: Option<Direction>,
    /// What the first directional valve did at the alarm: `P-A`, `P-B` or `closed`.
    pub phase: Option<&'static str>,
    /// Windows that count.
    pub windows: usize,
}

/// Evaluates every corrected residual of the rig on a record and tests each by a two-sided CUSUM.
///
/// The sequence tested is one value per window in units of its own noise, so it is white by construction; the reference
/// value of the CUSUM grows by `coverage` times the tolerance.
///
/// # Errors
/// A column that the record lacks or has in another dimension.
pub fn detect(
    rig: &Rig,
    record: &Record,
    drive: &Drive,
    detection: &Detection,
) -> Result<Vec<ResidualReport>, Complaint> {
    let found: Vec<Generator> =
        generators(rig).into_iter().filter(|generator| generator.variant == Variant::Corrected).collect();
    let interval = record.sampling().map_or(0.0, |sampling| sampling.interval);
    let window = super::frame::block_rows(detection.window, interval) as f64 * interval;
    let threshold = detection.threshold(found.len(), window);
    found
        .iter()
        .map(|generator| {
            let series = generator.blocks(rig, record, drive, detection.window)?;
            Ok(report(rig, drive, generator, &series, detection, threshold))
        })
        .collect()
}

fn report(
    rig: &Rig,
    drive: &Drive,
    generator: &Generator,
    series: &Series,
    detection: &Detection,
    threshold: f64,
) -> ResidualReport {
    let open: Vec<usize> = (0..series.gate.len()).filter(|&at| series.gate[at] == Gate::Open).collect();
    let whitened: Vec<f64> = open.iter().map(|&at| series.value[at] / series.sigma[at]).collect();
    let allowances: Vec<f64> =
        open.iter().map(|&at| detection.coverage * series.tolerance[at] / series.sigma[at]).collect();
    let alarm = cusum::first_alarm(&whitened, &allowances, detection.reference(), threshold);
    let mean = weighted(series, &open);
    let shown = |si: f64| generator.unit.difference_from_si(si);
    ResidualReport {
        id: generator.id.clone(),
        equation: generator.equation,
        variant: generator.variant,
        mean: mean.map(|(mean, _, _)| shown(mean)),
        sigma: mean.map(|(_, sigma, _)| shown(sigma)),
        tolerance: mean.map(|(_, _, tolerance)| shown(tolerance)),
        unit: generator.unit.symbol.clone(),
        fired: alarm.is_some(),
        alarm_at_s: alarm.map(|alarm| series.time[open[alarm.at]]),
        onset_s: alarm.map(|alarm| series.start[open[alarm.onset]]),
        direction: alarm.map(|alarm| alarm.direction),
        phase: alarm.and_then(|alarm| phase(rig, drive, series.time[open[alarm.at]])),
        windows: open.len(),
    }
}

/// Weighted mean of the values at `open`, its standard error, and its tolerance, which averaging does not lower.
pub(super) fn weighted(series: &Series, open: &[usize]) -> Option<(f64, f64, f64)> {
    let weight = |at: usize| 1.0 / (series.sigma[at] * series.sigma[at]);
    let total: f64 = open.iter().map(|&at| weight(at)).sum();
    let mean = |values: &[f64]| open.iter().map(|&at| weight(at) * values[at]).sum::<f64>() / total;
    (total > 0.0 && total.is_finite()).then(|| (mean(&series.value), total.sqrt().recip(), mean(&series.tolerance)))
}

fn phase(rig: &Rig, drive: &Drive, time: f64) -> Option<&'static str> {
    let valve = rig.components.iter().find(|component| component.card.kind == "directional-valve")?;
    let command = drive.value(*valve.inputs.first()?, time);
    Some(if command.abs() < CLOSED {
        "closed"
    } else if command > 0.0 {
        "P-A"
    } else {
        "P-B"
    })
}
