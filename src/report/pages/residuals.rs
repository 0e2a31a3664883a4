//! Residuals over time with what they may be, and their running sums against the threshold.

use super::channels::Shown;
use crate::complaint::Complaint;
use crate::model::InputSignals;
use crate::report::html::Section;
use crate::report::plot::{Axis, Chart, Envelope, Rule, Series};
use crate::residual::{Detection, Evaluated, Gate, ResidualReport};

/// Standard deviations of a window that are left to noise in the picture.
const NOISE: f64 = 3.0;
/// The running sum is shown up to so many thresholds.
const SHOWN: f64 = 2.0;

/// Adds two charts for each residual.
///
/// # Errors
/// A column that the record lacks.
pub(super) fn add(
    section: &mut Section,
    shown: &Shown<'_>,
    reports: &[ResidualReport],
    detection: &Detection,
) -> Result<(), Complaint> {
    let drive = InputSignals::from_record(shown.rig, shown.record)?;
    let evaluated = Evaluated::of(shown.rig, shown.record, &drive, detection.window)?;
    let threshold = evaluated.threshold(detection);
    let bands = shown.bands();
    for (generator, series) in &evaluated.residuals {
        let open: Vec<usize> = (0..series.gate.len()).filter(|&at| series.gate[at] == Gate::Open).collect();
        if open.is_empty() {
            continue;
        }
        let in_unit = |si: f64| generator.unit.difference_from_si(si);
        let values = open.iter().map(|&at| (series.time[at], in_unit(series.value[at]))).collect();
        let room = |&at: &usize| {
            let half = in_unit(detection.coverage * series.tolerance[at] + NOISE * series.sigma[at]);
            (series.time[at], -half, half)
        };
        let unit = Axis::new(generator.meaning, &generator.unit.symbol);
        let dots = Series::dots("mean of a window", values).styled(0, 0);
        let mut chart = Chart::new(&generator.id, shown.time(), unit, vec![dots]).high(140.0);
        let name = "noise and tolerance".to_owned();
        chart.envelopes.push(Envelope { name, points: open.iter().map(room).collect(), colour: 2 });
        chart.bands.clone_from(&bands);
        let report = reports.iter().find(|report| report.id == generator.id);
        let alarm =
            report.and_then(|report| report.alarm_at_s).map(|x| Rule::Vertical { x, label: "alarm".to_owned() });
        chart.rules.extend(alarm.clone());
        section.chart(&chart, &shown.live(format!("residual {} over time", generator.id)));

        let sums = evaluated.sums(series, detection);
        let top = SHOWN * threshold;
        let beyond = sums.iter().any(|(_, sum)| *sum > top);
        let sums = sums.into_iter().map(|(time, sum)| (time, sum.min(top))).collect();
        let beyond = if beyond { ", up to twice its threshold" } else { "" };
        let title = format!("running sum of {}{beyond}", generator.id);
        let axis = Axis::new("", "standard deviations").over(0.0, top);
        let mut chart = Chart::new(title, shown.time(), axis, vec![Series::line("sum", sums).styled(0, 0)]).high(80.0);
        chart.rules.push(Rule::Horizontal { y: threshold, label: "threshold".to_owned() });
        chart.rules.extend(alarm);
        section.chart(&chart, &shown.live(format!("running sum of residual {} against its threshold", generator.id)));
    }
    Ok(())
}
