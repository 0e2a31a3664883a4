//! Detection: which residuals have left zero, since when, and by how much.

use rayon::prelude::*;
use serde::Serialize;

use super::cusum::{self, Alarm, Direction};
use super::ensemble::Ensemble;
use super::form::CLOSED;
use super::frame::{self, Cursor, Prepared};
use super::generator::{Gate, Generator, Series, Variant};
use crate::complaint::Complaint;
use crate::model::InputSignals;
use crate::physics::component::facts;
use crate::physics::component::facts::Residuals;
use crate::record::Record;
use crate::rig::Rig;

/// How careful detection is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Mean time of healthy record between false alarms, over all residuals, phases and both directions together, h.
    pub hours_between_false_alarms: f64,
    /// Length of a window, s. Windows of ten sensor lags or more are independent: the noise is added behind the lag, and
    /// windows do not overlap.
    pub window: f64,
    /// Shift to be found fastest, in standard deviations of one window.
    pub shift: f64,
    /// Standard deviations of tolerance within which a bias is no fault. Tolerance is drawn once for a rig and not averaged
    /// away: at 3, all of ten residuals stay quiet in 97 healthy rigs of 100.
    pub coverage: f64,
}

impl Default for Detection {
    fn default() -> Self {
        Self { hours_between_false_alarms: 1000.0, window: 0.1, shift: 1.0, coverage: 3.0 }
    }
}

impl Detection {
    /// Reference value of the CUSUM, in standard deviations.
    pub(crate) fn reference(&self) -> f64 {
        0.5 * self.shift
    }

    /// Threshold of each side of each CUSUM of `residuals` residuals over windows of `window` s (Bonferroni), in standard
    /// deviations. The clock is that of the record: windows that do not count make it safer.
    pub(crate) fn threshold(&self, residuals: usize, window: f64) -> f64 {
        let windows = self.hours_between_false_alarms * 3600.0 / window;
        cusum::threshold(self.reference(), 2.0 * residuals.max(1) as f64 * windows)
    }
}

/// The mean of a residual over one phase of the record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct PhaseMean {
    /// What the first directional valve does: `P-A`, `P-B` or `closed`; `all` in a rig without one.
    pub phase: &'static str,
    /// In the unit of the report, each window weighed by its variance.
    pub mean: f64,
    /// Standard error of the mean by sensor noise.
    pub sigma: f64,
    /// One standard deviation of the mean by uncertain parameters and rounding, which averaging does not lower.
    pub tolerance: f64,
    /// Windows that count.
    pub windows: usize,
}

/// What one residual says about a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ResidualReport {
    /// Component and law, such as `cylinder.leakage`.
    pub id: String,
    /// Of the law that is checked, such as `(4)`.
    pub equation: &'static str,
    /// Which form of the equation.
    pub(crate) variant: Variant,
    /// Mean over the windows that count, each weighed by its variance, in `unit`: in the phase of the alarm where there is
    /// one, because a leak changes its sign with the stroke, otherwise over the whole record. `None` without such windows.
    pub mean: Option<f64>,
    /// Standard error of the mean by sensor noise, in `unit`.
    pub sigma: Option<f64>,
    /// One standard deviation of the mean by uncertain parameters and rounding, in `unit`.
    pub tolerance: Option<f64>,
    /// How far off the mean may be without an alarm, however long it stays: `coverage` times the tolerance, in `unit`.
    pub allowed: Option<f64>,
    /// Of the residual.
    pub unit: String,
    /// Whether the residual has left zero by more than noise and tolerance explain.
    pub fired: bool,
    /// End of the window of the alarm, s.
    pub alarm_at_s: Option<f64>,
    /// When it began to leave zero, s: the start of the window since which the sum has grown, or of the windows before it that
    /// the change itself has made unsteady.
    pub onset_s: Option<f64>,
    /// Whether the residual is too large or too small.
    #[doc(hidden)]
    pub direction: Option<Direction>,
    /// What the first directional valve did at the alarm: `P-A`, `P-B` or `closed`; `all` in a rig without one.
    pub phase: Option<&'static str>,
    /// Means of the phases that occur, in `unit`.
    #[doc(hidden)]
    pub phases: Vec<PhaseMean>,
    /// Windows that count, of all phases.
    pub windows: usize,
}

/// Evaluates every corrected residual of the rig on a record and tests each by two-sided CUSUMs, one for each phase: a
/// leak that changes its sign with the stroke adds up from stroke to stroke.
///
/// The sequence tested is one value per window in units of its own noise, so it is white by construction; the reference
/// value of the CUSUM grows by `coverage` times the tolerance.
///
/// # Errors
/// A column that the record lacks or has in another dimension.
pub fn detect(
    rig: &Rig,
    record: &Record,
    drive: &InputSignals,
    detection: &Detection,
) -> Result<Vec<ResidualReport>, Complaint> {
    Ok(Evaluated::of(rig, record, drive, detection.window)?.judge(detection))
}

/// The corrected residuals of a rig on a record, to be tested as carefully as one likes.
#[derive(Debug, Clone)]
pub struct Evaluated<'a> {
    rig: &'a Rig,
    drive: &'a InputSignals,
    /// s.
    window: f64,
    /// Every residual with its values, one per window.
    pub residuals: Vec<(Generator, Series)>,
}

impl<'a> Evaluated<'a> {
    /// Over windows of about `window` s.
    ///
    /// # Errors
    /// A column that the record lacks or has in another dimension.
    pub fn of(rig: &'a Rig, record: &Record, drive: &'a InputSignals, window: f64) -> Result<Self, Complaint> {
        let ensemble = Ensemble::of(rig);
        let prepared = Prepared::new(rig, record, drive, &ensemble.sources, window)?;
        let frames = prepared.lay(rig, &ensemble.sources, &mut Cursor::default(), f64::INFINITY);
        let series = |(generator, own): (Generator, Vec<usize>)| {
            let series = generator.series_of(rig, &frames, &own, &mut None);
            (generator, series)
        };
        let residuals = ensemble.members.into_par_iter().map(series).collect();
        let interval = frame::interval(record);
        Ok(Self { rig, drive, window: frame::block_rows(window, interval) as f64 * interval, residuals })
    }

    /// Threshold of each side of each CUSUM, in standard deviations. The phases share the clock, so that all their windows
    /// together are no more than the record has.
    pub fn threshold(&self, detection: &Detection) -> f64 {
        detection.threshold(self.residuals.len(), self.window)
    }

    /// The running sum that is tested behind each window that counts: its end, s, and the larger side, in standard deviations.
    /// Each phase has a sum of its own.
    #[cfg(feature = "cli")]
    pub fn sums(&self, series: &Series, detection: &Detection) -> Vec<(f64, f64)> {
        let mut sums = Vec::new();
        for &name in phases(self.rig) {
            let counts =
                |&at: &usize| series.gate[at] == Gate::Open && phase(self.rig, self.drive, series.time[at]) == name;
            let here: Vec<usize> = (0..series.gate.len()).filter(counts).collect();
            let whitened: Vec<f64> = here.iter().map(|&at| series.value[at] / series.sigma[at]).collect();
            let allowance = |&at: &usize| detection.coverage * series.tolerance[at] / series.sigma[at];
            let allowances: Vec<f64> = here.iter().map(allowance).collect();
            let values = cusum::sums(&whitened, &allowances, detection.reference());
            sums.extend(here.iter().map(|&at| series.time[at]).zip(values));
        }
        sums.sort_by(|a, b| a.0.total_cmp(&b.0));
        sums
    }

    /// Tests every residual; `detection.window` is that of [`Evaluated::of`].
    pub fn judge(&self, detection: &Detection) -> Vec<ResidualReport> {
        let threshold = self.threshold(detection);
        let all = self.residuals.iter();
        all.map(|(generator, series)| report(self.rig, self.drive, generator, series, detection, threshold)).collect()
    }
}

fn report(
    rig: &Rig,
    drive: &InputSignals,
    generator: &Generator,
    series: &Series,
    detection: &Detection,
    threshold: f64,
) -> ResidualReport {
    let open: Vec<usize> = (0..series.gate.len()).filter(|&at| series.gate[at] == Gate::Open).collect();
    let shown = |si: f64| generator.unit.difference_from_si(si);
    let mut means = Vec::new();
    let mut first: Option<(Alarm, &'static str, Vec<usize>)> = None;
    for &name in phases(rig) {
        let here: Vec<usize> = open.iter().copied().filter(|&at| phase(rig, drive, series.time[at]) == name).collect();
        let Some((mean, sigma, tolerance)) = weighted(series, &here) else { continue };
        let (mean, sigma, tolerance) = (shown(mean), shown(sigma), shown(tolerance));
        means.push(PhaseMean { phase: name, mean, sigma, tolerance, windows: here.len() });
        let whitened: Vec<f64> = here.iter().map(|&at| series.value[at] / series.sigma[at]).collect();
        let allowance = |&at: &usize| detection.coverage * series.tolerance[at] / series.sigma[at];
        let allowances: Vec<f64> = here.iter().map(allowance).collect();
        let Some(alarm) = cusum::first_alarm(&whitened, &allowances, detection.reference(), threshold) else {
            continue;
        };
        if first.as_ref().is_none_or(|(before, _, rows)| series.time[here[alarm.at]] < series.time[rows[before.at]]) {
            first = Some((alarm, name, here));
        }
    }
    let mean = weighted(series, first.as_ref().map_or(&open, |(_, _, here)| here));
    ResidualReport {
        id: generator.id.clone(),
        equation: generator.equation,
        variant: generator.variant,
        mean: mean.map(|(mean, _, _)| shown(mean)),
        sigma: mean.map(|(_, sigma, _)| shown(sigma)),
        tolerance: mean.map(|(_, _, tolerance)| shown(tolerance)),
        allowed: mean.map(|(_, _, tolerance)| detection.coverage * shown(tolerance)),
        unit: generator.unit.symbol.clone(),
        fired: first.is_some(),
        alarm_at_s: first.as_ref().map(|(alarm, _, here)| series.time[here[alarm.at]]),
        onset_s: first.as_ref().map(|(alarm, name, here)| {
            onset(series, here[alarm.onset], |at| phase(rig, drive, series.time[at]) == *name)
        }),
        direction: first.as_ref().map(|(alarm, _, _)| alarm.direction),
        phase: first.as_ref().map(|(_, name, _)| *name),
        phases: means,
        windows: open.len(),
    }
}

/// Start of a window, or of the first of those before it in the same phase that do not count because something moved: what
/// begins within a stroke shakes the window that it begins in, and takes the noise from the next.
fn onset(series: &Series, mut at: usize, same_phase: impl Fn(usize) -> bool) -> f64 {
    let moved = |at: usize| matches!(series.gate[at], Gate::Unsteady | Gate::InitialGuess) && same_phase(at);
    while at > 0 && moved(at - 1) {
        at -= 1;
    }
    series.start[at]
}

/// Weighted mean of the values at `open`, its standard error, and its tolerance, which averaging does not lower.
pub(super) fn weighted(series: &Series, open: &[usize]) -> Option<(f64, f64, f64)> {
    let weight = |at: usize| 1.0 / (series.sigma[at] * series.sigma[at]);
    let total: f64 = open.iter().map(|&at| weight(at)).sum();
    let mean = |values: &[f64]| open.iter().map(|&at| weight(at) * values[at]).sum::<f64>() / total;
    (total > 0.0 && total.is_finite()).then(|| (mean(&series.value), total.sqrt().recip(), mean(&series.tolerance)))
}

/// Phases that a record of the rig may have.
pub(super) fn phases(rig: &Rig) -> &'static [&'static str] {
    if command(rig).is_some() { &["P-A", "P-B", "closed"] } else { &["all"] }
}

/// Input that commands the first directional valve.
fn command(rig: &Rig) -> Option<usize> {
    let is_valve = |residuals| matches!(residuals, Residuals::Directional { .. });
    let valve = rig.components.iter().find(|component| is_valve(facts(component.card).residuals))?;
    valve.inputs.first().copied()
}

/// The phase of a record at a time (s).
pub(super) fn phase(rig: &Rig, drive: &InputSignals, time: f64) -> &'static str {
    let Some(input) = command(rig) else { return "all" };
    let command = drive.value(input, time);
    if command.abs() < CLOSED {
        "closed"
    } else if command > 0.0 {
        "P-A"
    } else {
        "P-B"
    }
}
