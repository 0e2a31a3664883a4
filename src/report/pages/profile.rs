//! Profile likelihood of each fault: how fast the fit worsens when the fault is held elsewhere.

use crate::diagnosis::{Diagnosed, FaultReport};
use crate::estimation::Interval;
use crate::estimation::ProfilePoint;
use crate::estimation::profile::RISE;
use crate::report::diagnosis_tables as words;
use crate::report::html::Section;
use crate::report::plot::{Axis, Band, Chart, Live, Rule, Series};
use crate::rig::{Fault, Rig};

/// Levels up to which a profile is shown.
const SHOWN: f64 = 2.0;
/// Pieces of the curve between two values that were tried.
const PIECES: usize = 12;
/// What is left free around the values, of their range.
const RIM: f64 = 0.15;

/// Why an end may stand beyond the crossing of its curve.
const WIDER: &str = "Vertical lines are the ends of the interval. They stand beyond the crossing where the curve does not know all: \
    in a calibrated rig what no record tells is added to both sides, and where another set of faults has 5 % or more, the \
    interval reaches over what that set says too.";

/// A small chart for each fault whose interval was searched.
pub(super) fn section(rig: &Rig, diagnosed: &Diagnosed) -> Option<Section> {
    let faults = rig.faults.iter().zip(&diagnosed.diagnosis.faults).zip(&diagnosed.intervals);
    let mut all: Vec<(&Fault, &FaultReport, &Interval)> = faults
        .filter_map(|((fault, report), interval)| Some((fault, report, interval.as_ref()?)))
        .filter(|(fault, report, interval)| {
            interval.points.len() > 1 && (report.present || !rig.is_of_sensor(fault.parameter))
        })
        .collect();
    if all.is_empty() {
        return None;
    }
    // What was found first.
    all.sort_by_key(|(_, report, _)| !report.present);
    let mut section = Section::folded("Profile likelihood");
    section.paragraph(
        "Each fault held at values around its estimate while everything else is fitted again: by how much chi-square rises. The interval \
         ends where the curve crosses the level of 95 %; a curve that stays below it up to the end of the search leaves the interval \
         open. Misfits of neighbouring samples that go together count as the fewer independent ones that they are worth, so that the \
         level is the same for all. Dots: values that were tried.",
    );
    section.paragraph(WIDER);
    section.paragraph(
        "A curve takes its fault to be there, with nothing known of its value. So the healthy value of a fault that is not there may lie \
         beyond the level: within its shade it is no further off than the rig file says that a healthy part may be. The list under \
         the table of faults has the reason. Offsets and gains of sensors that are not faulty are left out: their curves are parabolas.",
    );
    let charts: Vec<(Chart, Live)> =
        all.into_iter().map(|(fault, report, interval)| chart(rig, fault, report, interval)).collect();
    section.side_by_side(&charts);
    Some(section)
}

fn chart(rig: &Rig, fault: &Fault, report: &FaultReport, interval: &Interval) -> (Chart, Live) {
    let unit = &rig.parameters[fault.parameter].unit;
    let inflation = interval.inflation();
    let shown = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        points.into_iter().map(|(si, rise)| (unit.from_si(si), rise / inflation)).collect()
    };
    let tried = shown(interval.points.iter().map(|point| (point.value, point.rise)).collect());
    let told = report.ci95.into_iter().flatten();
    let (from, to) = span(tried.iter().map(|point| point.0).chain(told.clone()));
    let rim = RIM * (to - from);
    let series = vec![
        Series::line("rise of chi-square", shown(curve(&interval.points, interval.value))).styled(0, 0),
        Series::dots("", tried).styled(0, 0),
    ];
    let x = Axis::new(&report.id, &unit.symbol).over(from - rim, to + rim);
    let mut chart = Chart::new(&report.id, x, Axis::new("", "").over(0.0, SHOWN * RISE), series).high(130.0);
    chart.rules.push(Rule::Horizontal { y: RISE, label: "95 %".to_owned() });
    let vertical = |x: f64, label: &str| Rule::Vertical { x, label: label.to_owned() };
    chart.rules.extend(told.map(|end| vertical(end, "")));
    if (from - rim..=to + rim).contains(&report.healthy) {
        chart.rules.push(vertical(report.healthy, "healthy"));
    }
    let tolerance = report.healthy_tolerance();
    if tolerance > 0.0 && !report.present {
        let [from, to] =
            [report.healthy - tolerance, report.healthy + tolerance].map(|end| end.clamp(from - rim, to + rim));
        chart.bands.push(Band { from, to, label: "tolerance of the healthy value".to_owned() });
    }
    let told = format!(
        "profile likelihood of {}: estimate {}, 95 % interval {}",
        report.id,
        words::sized(report),
        words::interval(report)
    );
    (chart, Live::new("", told))
}

/// The least and the greatest.
fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// The curve through the points of a profile: its signed root is nearly a straight line between them.
fn curve(points: &[ProfilePoint], best: f64) -> Vec<(f64, f64)> {
    let root = |point: &ProfilePoint| if point.value < best { -point.rise.sqrt() } else { point.rise.sqrt() };
    let mut all = Vec::new();
    for pair in points.windows(2) {
        let (from, to) = ((pair[0].value, root(&pair[0])), (pair[1].value, root(&pair[1])));
        all.extend((0..PIECES).map(|piece| {
            let share = piece as f64 / PIECES as f64;
            (from.0 + share * (to.0 - from.0), (from.1 + share * (to.1 - from.1)).powi(2))
        }));
    }
    all.extend(points.last().map(|point| (point.value, point.rise)));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_drawn_as_one_from_three_points() {
        let point = |value: f64| ProfilePoint { value, rise: 4.0 * (value - 1.0) * (value - 1.0) };
        let drawn = curve(&[point(-1.0), point(1.0), point(2.5)], 1.0);
        assert_eq!(drawn.len(), 2 * PIECES + 1);
        for (value, rise) in drawn {
            approx::assert_relative_eq!(rise, point(value).rise, epsilon = 1e-12);
        }
    }
}
