//! The tables of a diagnosis, for its text and its page: faults, combinations, sensors, uncertain values, and why faults are not counted.

use super::digits::{Estimate, plus_minus, worth};
use super::table::Head;
use crate::diagnosis::{CLEARLY_ABOVE_NOISE, Diagnosis, FaultReport, UncertainReport};
use crate::number::{before_unit, rounded, text, with_unit};

/// A fault as it is shown, with the digits that its interval is worth.
fn estimate(fault: &FaultReport) -> Estimate {
    Estimate { value: fault.value, ends: fault.ci95 }
}

/// The size of a fault with its unit.
pub(super) fn sized(fault: &FaultReport) -> String {
    before_unit(estimate(fault).value(), &fault.unit)
}

/// Its healthy value with its unit.
#[cfg(feature = "cli")]
pub(super) fn healthy(fault: &FaultReport) -> String {
    before_unit(estimate(fault).beside(fault.healthy), &fault.unit)
}

/// An interval in words.
pub(super) fn interval(fault: &FaultReport) -> String {
    estimate(fault).interval()
}

pub(super) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 99.9 => "> 99.9 %".to_owned(),
        p if p < 0.1 => "< 0.1 %".to_owned(),
        p => format!("{p:.1} %"),
    }
}

pub(super) fn fault_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    diagnosis
        .faults
        .iter()
        .map(|fault| {
            vec![
                fault.id.clone(),
                estimate(fault).value(),
                interval(fault),
                estimate(fault).beside(fault.healthy),
                fault.unit.clone(),
                if fault.present { "yes" } else { "no" }.to_owned(),
                percent(fault.probability),
            ]
        })
        .collect()
}

pub(super) const FAULT_HEADS: [Head; 7] = [
    ("fault", false),
    ("estimate", true),
    ("95 % interval", true),
    ("healthy", true),
    ("unit", false),
    ("present", false),
    ("probability", true),
];

pub(super) const HYPOTHESIS_HEADS: [Head; 2] = [("faults", false), ("probability", true)];

pub(super) fn hypothesis_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let named = |faults: &[String]| if faults.is_empty() { "healthy".to_owned() } else { faults.join(" + ") };
    diagnosis.hypotheses.iter().take(5).map(|h| vec![named(&h.faults), percent(h.probability)]).collect()
}

pub(super) const CHANNEL_HEADS: [Head; 6] = [
    ("sensor", false),
    ("rms misfit", true),
    ("noise", true),
    ("unit", false),
    ("reduced chi-square", true),
    ("explained", false),
];

/// Whether the model explains a sensor of so many samples with so much error over its noise, and whether it would if nothing were asked of
/// events.
pub(super) fn explained(adequate: bool, (samples, times_noise): (usize, f64), within_noise: bool) -> &'static str {
    match (adequate, samples) {
        (_, 0) => "no samples",
        (true, _) if times_noise > CLEARLY_ABOVE_NOISE => "in tolerance",
        (true, _) => "yes",
        (false, _) if within_noise => "NO (events)",
        (false, _) => "NO",
    }
}

/// What only samples tell.
pub(super) fn of_samples(samples: usize, told: String) -> String {
    if samples == 0 { "-".to_owned() } else { told }
}

pub(super) fn channel_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let row = |channel: &crate::diagnosis::ChannelReport| {
        vec![
            channel.name.clone(),
            of_samples(channel.samples, text(rounded(channel.rmse, 3))),
            text(rounded(channel.noise_sigma, 3)),
            channel.unit.clone(),
            of_samples(channel.samples, format!("{:.2}", channel.chi2_reduced)),
            explained(channel.adequate, (channel.samples, channel.times_noise), channel.within_noise).to_owned(),
        ]
    };
    diagnosis.channels.iter().map(row).collect()
}

pub(super) const UNCERTAIN_HEADS: [Head; 5] =
    [("parameter", false), ("estimate", true), ("rig file", true), ("unit", false), ("pull", true)];

/// Parameters that were estimated along; the pull is how far the record draws one from its rig file.
pub(super) fn uncertain_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    // Both with as many decimals as two digits of the uncertainty ask for.
    let with = |value: f64, sigma: Option<f64>| match sigma {
        Some(sigma) if sigma > 0.0 => plus_minus(value, sigma),
        _ => text(rounded(value, 4)),
    };
    let row = |parameter: &UncertainReport| {
        let pull = (parameter.value - parameter.nominal) / parameter.sigma_before;
        vec![
            parameter.id.clone(),
            with(parameter.value, parameter.sigma_after),
            with(parameter.nominal, Some(parameter.sigma_before)),
            parameter.unit.clone(),
            format!("{} sigma", worth(pull, 1.0)),
        ]
    };
    diagnosis.uncertain.iter().map(row).collect()
}

pub(super) const PULLED: &str = "Uncertain values that the record draws furthest, +- one standard deviation";

/// How many of them a text shows.
const MOST_PULLED: usize = 6;

/// The rows of those that are drawn by a standard deviation or more, the furthest first.
pub(super) fn most_pulled(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let mut rows: Vec<_> = diagnosis.uncertain.iter().zip(uncertain_rows(diagnosis)).collect();
    rows.retain(|(one, _)| one.deviations() >= 1.0);
    rows.sort_by(|(a, _), (b, _)| b.deviations().total_cmp(&a.deviations()));
    rows.into_iter().take(MOST_PULLED).map(|(_, row)| row).collect()
}

pub(super) const OPEN_INTERVALS: &str = "Intervals that are open, or whose search did not converge";

/// What is known of each fault whose interval is not that of a finished search, and why no more.
pub(super) fn open_intervals(diagnosis: &Diagnosis) -> Vec<String> {
    let open = |fault: &FaultReport| {
        let known = match fault.ci95 {
            [None, None] => "not bounded".to_owned(),
            _ => before_unit(interval(fault), &fault.unit),
        };
        Some(format!("{}: {known}; {}", fault.id, fault.remark.as_ref()?))
    };
    diagnosis.faults.iter().filter_map(open).collect()
}

pub(super) const UNBLAMED: &str = "Not counted as faults, and why";

/// Why faults are not present although their intervals leave the healthy value out.
pub(super) fn unblamed(diagnosis: &Diagnosis) -> Vec<String> {
    diagnosis.faults.iter().filter_map(why_unblamed).collect()
}

const MORE_LIKELY_THAN_NOT: f64 = 0.5;

/// The same of one fault, if it is so: its interval takes it to be there.
fn why_unblamed(fault: &FaultReport) -> Option<String> {
    if fault.present {
        return None;
    }
    let probability = percent(fault.probability);
    if !fault.interval_misses(fault.healthy, 0.0) {
        let probable = fault.probability >= MORE_LIKELY_THAN_NOT;
        let healthy = with_unit(fault.healthy, &fault.unit);
        return probable.then(|| {
            format!("{}: its interval holds its healthy {healthy} (probability of the fault: {probability})", fault.id)
        });
    }
    let tolerance = fault.healthy_tolerance();
    if !fault.interval_misses(fault.healthy, tolerance) {
        let healthy = format!("{} +- {}", text(fault.healthy), worth(tolerance, tolerance));
        let healthy = before_unit(healthy, &fault.unit);
        return Some(format!(
            "{}: its interval reaches the tolerance of its healthy value, {healthy} (95 %)",
            fault.id
        ));
    }
    // Where nothing explains the record well enough, its healthy value does not either.
    let why = if fault.biased {
        "blaming it is not the more probable explanation".to_owned()
    } else {
        format!("its healthy {} explains the record well enough", with_unit(fault.healthy, &fault.unit))
    };
    Some(format!("{}: {why} (probability of the fault: {probability})", fault.id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::Identifiable;

    fn clearance(ci95: [Option<f64>; 2], healthy_sigma: f64) -> FaultReport {
        FaultReport {
            id: "cylinder.clearance".to_owned(),
            meaning: String::new(),
            value: 0.0074,
            unit: "mm".to_owned(),
            healthy: 0.0,
            healthy_sigma,
            bounds: [0.0, 0.4],
            limit: None,
            ci95,
            change95: None,
            present: false,
            probability: 0.012,
            identifiable: Identifiable::Bounded,
            remark: None,
            biased: true,
        }
    }

    #[test]
    fn an_inadequate_model_says_too_why_a_value_off_the_healthy_one_is_no_fault() {
        let off = clearance([Some(0.0068), Some(0.021)], 0.0);
        let said =
            "cylinder.clearance: blaming it is not the more probable explanation (probability of the fault: 1.2 %)";
        assert_eq!(why_unblamed(&off).unwrap(), said);
        let within = FaultReport { healthy_sigma: 0.01, ..off.clone() };
        let said = "cylinder.clearance: its interval reaches the tolerance of its healthy value, 0 +- 0.020 mm (95 %)";
        assert_eq!(why_unblamed(&within).unwrap(), said);
        assert_eq!(why_unblamed(&FaultReport { present: true, ..off }), None);
        assert_eq!(why_unblamed(&clearance([None, Some(0.021)], 0.0)), None);
        let probable = FaultReport { probability: 0.7, ..clearance([None, Some(0.021)], 0.0) };
        let said = "cylinder.clearance: its interval holds its healthy 0 mm (probability of the fault: 70.0 %)";
        assert_eq!(why_unblamed(&probable).unwrap(), said);
    }
}
