//! From an explanation to what is reported of each fault, sensor and uncertain parameter.

use super::DIGITS;
use super::estimate::Estimate;
use super::missed::missed;
use super::problem::root_mean_square;
use super::result::{ChannelReport, FaultReport, UncertainReport};
use crate::estimation::profile::{QUANTILE, RISE};
use crate::estimation::{End, Identifiable, Interval, Side};
use crate::number::{rounded, text, with_unit};
use crate::settings::DiagnosisSettings;

/// What an estimate shows before its intervals are known, in one line.
pub(super) fn first_look(estimate: &Estimate<'_>) -> String {
    let (rig, set) = (estimate.case.rig(), estimate.isolation.set());
    if !estimate.explains() {
        return "no combination of faults explains the record yet".to_owned();
    }
    let one = |fault: usize| {
        let parameter = &rig.parameters[rig.faults[fault].parameter];
        let value = rounded(parameter.unit.from_si(estimate.isolation.best.theta[fault]), FIRST_DIGITS);
        format!("{} {}", parameter.id, with_unit(value, &parameter.unit.symbol))
    };
    let faults: Vec<String> = set.iter().map(one).collect();
    if faults.is_empty() { "healthy".to_owned() } else { format!("faulty, {}", faults.join(", ")) }
}

/// Digits of a value whose interval is not known yet.
const FIRST_DIGITS: usize = 3;

/// How well the model follows each sensor.
pub(super) fn channels(estimate: &Estimate<'_>, outputs: &[Vec<f64>], healthy: &[Vec<f64>]) -> Vec<ChannelReport> {
    let rig = estimate.case.rig();
    let (full, settings) = (&estimate.case.full, estimate.case.settings());
    rig.sensors
        .iter()
        .zip(missed(settings, &full.weights, &estimate.isolation.best.misfit))
        .enumerate()
        .map(|(index, (sensor, missed))| {
            let unit = rig.sensor_unit(sensor);
            let model = outputs.get(index).map_or(&[][..], Vec::as_slice);
            let healthy = healthy.get(index).map_or(&[][..], Vec::as_slice);
            let adequate = missed.is_explained(settings);
            let rms = root_mean_square(model, full.measured[index]).unwrap_or(0.0);
            ChannelReport {
                name: sensor.name.clone(),
                unit: unit.symbol.clone(),
                rmse: rounded(unit.difference_from_si(rms), DIGITS),
                noise_sigma: rounded(unit.difference_from_si(sensor.noise), DIGITS),
                times_noise: rounded(rms / sensor.noise, DIGITS),
                samples: missed.samples,
                chi2_reduced: missed.square,
                events_chi2: missed.events(),
                adequate,
                within_noise: missed.is_within_noise(settings),
                ratio_to_healthy: if adequate {
                    None
                } else {
                    ratio_to_healthy(settings, full.measured[index], healthy)
                },
            }
        })
        .collect()
}

/// What is measured over what the healthy model says, where that is far from 1 or has the other sign.
pub(crate) fn ratio_to_healthy(settings: &DiagnosisSettings, measured: &[f64], healthy: &[f64]) -> Option<f64> {
    let pairs = || measured.iter().zip(healthy).filter(|(y, m)| y.is_finite() && m.is_finite());
    let sum = |product: fn(f64, f64) -> f64| pairs().map(|(y, m)| product(*y, *m)).sum::<f64>();
    let (squares, along) = (sum(|_, m| m * m), sum(|y, m| y * m));
    let (ratio, share) = (along / squares, along * along / (squares * sum(|y, _| y * y)));
    let odd = ratio < 0.0 || !(1.0 / settings.odd_ratio..settings.odd_ratio).contains(&ratio);
    (odd && share > settings.odd_ratio_share).then(|| rounded(ratio, 3))
}

/// What is said and asked of a column with such a ratio.
pub(crate) fn reads_otherwise(name: &str, ratio: f64, unit: &str) -> String {
    let asked = match unit {
        _ if ratio < 0.0 => "does it count the other way".to_owned(),
        "-" => "does it need a `scale`".to_owned(),
        unit => format!("is its column in {unit}"),
    };
    format!("{name} reads {} times what the healthy model says: {asked}?", text(ratio))
}

/// What the record says of each fault.
pub(super) fn faults(
    estimate: &Estimate<'_>,
    intervals: &[Option<Interval>],
    probabilities: &[f64],
    biased: bool,
) -> Vec<FaultReport> {
    let rig = estimate.case.rig();
    rig.faults
        .iter()
        .enumerate()
        .map(|(i, fault)| {
            let parameter = &rig.parameters[fault.parameter];
            let shown = |si: f64| rounded(parameter.unit.from_si(si), DIGITS);
            let interval = intervals[i].as_ref();
            let ends = interval.map_or([None, None], |interval| ends(interval, fault.bounds));
            let change = if parameter.is_uncertain() { change_of(estimate, i) } else { None };
            FaultReport {
                id: parameter.id.clone(),
                meaning: parameter.meaning.clone(),
                value: shown(interval.map_or(estimate.isolation.best.theta[i], |interval| interval.value)),
                unit: parameter.unit.symbol.clone(),
                healthy: shown(fault.healthy),
                healthy_sigma: rounded(parameter.unit.difference_from_si(parameter.sigma), DIGITS),
                bounds: [fault.bounds.0, fault.bounds.1].map(shown),
                limit: fault.limit.map(shown),
                ci95: ends.map(|end| end.map(shown)),
                change95: change.map(|ends| ends.map(|si| rounded(parameter.unit.difference_from_si(si), DIGITS))),
                // What the record does not bound away from its healthy value is not called a fault, however a set scores.
                present: probabilities[i] >= estimate.case.settings().present_probability
                    && change.map_or_else(|| !holds(ends, fault.healthy), |[low, high]| low > 0.0 || high < 0.0),
                probability: probabilities[i],
                identifiable: match ends {
                    [Some(_), Some(_)] => Identifiable::Bounded,
                    [Some(_), None] => Identifiable::LowerBoundOnly,
                    [None, Some(_)] => Identifiable::UpperBoundOnly,
                    [None, None] => Identifiable::Unidentifiable,
                },
                remark: interval.and_then(|interval| remark(interval, ends, fault, shown, &parameter.unit.symbol)),
                biased,
            }
        })
        .collect()
}

/// The ends of the 95 % interval of a fault's change from its healthy value, SI, by the local model; `None` where that says no more than
/// its range.
fn change_of(estimate: &Estimate<'_>, fault: usize) -> Option<[f64; 2]> {
    let isolation = &estimate.isolation;
    let set = isolation.set().with(fault);
    let best = isolation.schur.best(set.iter())?;
    let change = *best.deviation.get(set.iter().position(|one| one == fault)?)?;
    let sigma = isolation.schur.sigma(set.iter(), fault)? * isolation.inflation[fault].sqrt();
    Some([-QUANTILE, QUANTILE].map(|side| (change + side * sigma) * isolation.local.scale[fault]))
}

/// The ends of an interval, SI; where the search for one did not settle, the standard error stands in for it, since an open
/// end says that the record does not bound the value. Beyond the range that was searched it would say nothing.
fn ends(interval: &Interval, (low, high): (f64, f64)) -> [Option<f64>; 2] {
    let end = |side: &Side, sign: f64| {
        let stand_in = || {
            let end = interval.value + sign * QUANTILE * interval.sigma?;
            (low < end && end < high).then_some(end)
        };
        let unsettled = matches!(side.why, End::GaveUp | End::BetterOptimum | End::ModelFails);
        if unsettled { side.end.or_else(stand_in) } else { side.end }
    };
    [end(&interval.lower, -1.0), end(&interval.upper, 1.0)]
}

/// Whether an interval (SI, open ends unbounded) holds a value.
fn holds(ends: [Option<f64>; 2], value: f64) -> bool {
    ends[0].is_none_or(|low| low <= value) && ends[1].is_none_or(|high| value <= high)
}

/// Rises of chi-square below it read as 0.00.
const NOTHING: f64 = 0.005;

/// Why an end of an interval is open, or stands for what it does; `ends` are those that are told.
fn remark(
    interval: &Interval,
    ends: [Option<f64>; 2],
    fault: &crate::rig::Fault,
    shown: impl Fn(f64) -> f64,
    unit: &str,
) -> Option<String> {
    let told = |end: Option<f64>| if end.is_some() { "it is taken from the standard error" } else { "it stays open" };
    let one = |end: &Side, at: Option<f64>, bound: f64, side: &str| match end.why {
        End::Crossed => None,
        End::BoundReached if interval.value == bound => {
            Some(format!("the {side} end of the search, {} {unit}, fits best", shown(bound)))
        }
        End::BoundReached => {
            let (bound, rise) = (shown(bound), end.rise / interval.inflation());
            Some(if rise < NOTHING {
                format!("at the {side} end of the search, {bound} {unit}, the fit is as good")
            } else {
                format!(
                    "going to the {side} end of the search, {bound} {unit}, worsens the fit by {rise:.2} in chi-square, less than \
                     the {RISE:.2} that would bound it"
                )
            })
        }
        End::ModelFails => Some(format!("the model cannot be solved towards the {side} end; {}", told(at))),
        End::BetterOptimum | End::GaveUp => Some(format!("the search for the {side} end did not settle; {}", told(at))),
    };
    let lower = one(&interval.lower, ends[0], fault.bounds.0, "lower");
    let upper = one(&interval.upper, ends[1], fault.bounds.1, "upper");
    let remarks: Vec<String> = [lower, upper].into_iter().flatten().collect();
    (!remarks.is_empty()).then(|| remarks.join("; "))
}

/// What the record says of parameters that are no faults but were estimated along.
pub(super) fn uncertain(estimate: &Estimate<'_>) -> Vec<UncertainReport> {
    let (case, isolation) = (&estimate.case, &estimate.isolation);
    let rig = case.rig();
    let prior = case.healthy_prior();
    let inverse = case.information(&isolation.local, isolation.set()).map(|known| known.covariance()).ok();
    (case.faults()..case.count())
        .filter(|&index| {
            let own = case.full.estimated[index].parameter;
            rig.original(own) == own
        })
        .filter_map(|index| {
            let parameter = &rig.parameters[case.full.estimated[index].parameter];
            let (mean, sigma) = prior.of(index)?;
            let unit = &parameter.unit;
            let variance = inverse.as_ref().map(|inverse| inverse[(index, index)]);
            let after = variance.map(|variance| variance.sqrt() * isolation.local.scale[index]);
            Some(UncertainReport {
                id: parameter.id.clone(),
                value: rounded(unit.from_si(isolation.best.theta[index]), DIGITS),
                unit: unit.symbol.clone(),
                nominal: rounded(unit.from_si(mean), DIGITS),
                sigma_before: rounded(unit.difference_from_si(sigma), DIGITS),
                sigma_after: after.map(|si| rounded(unit.difference_from_si(si), DIGITS)),
            })
        })
        .collect()
}
