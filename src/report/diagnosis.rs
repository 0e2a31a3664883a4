//! The diagnosis for people: a page of text to hand on; `pages::diagnosis` has the one with pictures.

use std::fmt;

use super::caveats::{TOLD, caveats, detected, left_out};
use super::digits::{Estimate, plus_minus, worth};
use super::residuals;
use super::style::{Style, Tone};
#[cfg(feature = "cli")]
use super::style::{bars, scale};
use super::table::{Head, aligned, fitted as lines_fitted, within};
use crate::diagnosis::{CLEARLY_ABOVE_NOISE, Diagnosis, FaultReport, MissingEffect, UncertainReport, Verdict};
#[cfg(feature = "cli")]
use crate::diagnosis::{Diagnosed, is_there};
use crate::number::{before_unit, rounded, text, with_unit};
use crate::record::survey::Doubt;
#[cfg(feature = "cli")]
use crate::rig::Rig;

/// Characters of a scale with an interval, and of a course of misfits.
#[cfg(feature = "cli")]
const SCALE: usize = 21;
#[cfg(feature = "cli")]
const COURSE: usize = 24;
/// Size of a weighted misfit that fills a bar, standard deviations; 0.8 is right.
#[cfg(feature = "cli")]
const FULL: f64 = 6.0;

/// The verdict in one line.
pub fn headline(diagnosis: &Diagnosis) -> String {
    let present: Vec<String> = diagnosis.present().map(|fault| format!("{} {}", fault.id, sized(fault))).collect();
    let without = without(diagnosis);
    let condition = diagnosis.common_cause.as_ref().map_or_else(String::new, |cause| format!(", if {}", cause.clause));
    match (diagnosis.verdict, &diagnosis.missing_effect) {
        (Verdict::Healthy, _) => {
            let off = if diagnosis.off_data_sheet.is_some() { ", with parts off their data sheets" } else { "" };
            let only = if diagnosis.is_above_noise() {
                format!(
                    ", but {}x the noise is left, within what switching and tolerance allow",
                    text(rounded(diagnosis.times_noise, 2))
                )
            } else {
                String::new()
            };
            let strained = strained(diagnosis).unwrap_or_default();
            format!("HEALTHY{without}{condition}: the healthy model explains the record{off}{only}{strained}.")
        }
        (Verdict::Faulty, _) => {
            let new = if diagnosis.is_as_new() { ", no further off than new parts are" } else { "" };
            format!("FAULTY{without}{condition}: {}{new}.", present.join(", "))
        }
        (Verdict::ModelInadequate, Some(missing)) => {
            let beside = match present.as_slice() {
                [] => "no fault".to_owned(),
                some => some.join(", "),
            };
            format!(
                "MODEL INADEQUATE{without}{condition}: the model lacks {}{}; beside it {beside}. {}",
                missing.effects.join(" and "),
                or_others(missing),
                left_by(missing, diagnosis)
            )
        }
        (Verdict::ModelInadequate, None) => {
            let worst = diagnosis.channels.iter().max_by(|a, b| a.chi2_reduced.total_cmp(&b.chi2_reduced));
            let worst = worst.map_or(String::new(), |worst| format!(", {} worst", worst.name));
            format!(
                "MODEL INADEQUATE{without}: no faults of this rig explain the record{worst}; physics is missing or a sensor is wrong. \
                 Fault values below may be off by more than their intervals."
            )
        }
    }
}

/// The value of the rig file that a healthy explanation has furthest from stated, where that is further than chance puts one: a fault
/// by another name, or a file that is wrong.
fn strained(diagnosis: &Diagnosis) -> Option<String> {
    let furthest = diagnosis.uncertain.iter().max_by(|a, b| a.deviations().total_cmp(&b.deviations()));
    let furthest = furthest.filter(|_| diagnosis.is_strained())?;
    let deviations = text(rounded(furthest.deviations(), 2));
    Some(format!(", only with {} {deviations} standard deviations from stated", furthest.id))
}

/// Effects that explain the record as well, as an aside.
fn or_others(missing: &MissingEffect) -> String {
    match missing.confounded_with.as_slice() {
        [] => String::new(),
        some => format!(" (or {})", some.join(", ")),
    }
}

/// What a missing effect makes of the error, and whether that is all.
pub(super) fn left_by(missing: &MissingEffect, diagnosis: &Diagnosis) -> String {
    let [with, without] = [diagnosis.times_noise, missing.times_noise_without].map(|error| text(rounded(error, 2)));
    let rest = match missing.explained {
        true => "",
        false => "; something else is missing too, and values below may be off by more than their intervals",
    };
    format!("It brings the error from {without}x to {with}x the sensor noise{rest}.")
}

/// Sizes of a missing effect that are told one by one.
const SIZES: usize = 4;

/// How large the effect is that the model lacks.
pub(super) fn sizes(missing: &MissingEffect) -> String {
    let size = |parameter: &UncertainReport| {
        let value = match parameter.sigma_after {
            Some(sigma) if sigma > 0.0 => plus_minus(parameter.value, sigma),
            _ => text(rounded(parameter.value, 4)),
        };
        format!("{} {}", parameter.id, before_unit(value, &parameter.unit))
    };
    let more = missing.parameters.len().saturating_sub(SIZES);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let told: Vec<String> = missing.parameters.iter().take(SIZES).map(size).collect();
    format!("Its size: {}{more} (one standard deviation).", told.join(", "))
}

/// The sensors that a verdict had to do without, throughout or in part, as the end of its first words.
fn without(diagnosis: &Diagnosis) -> String {
    let mut names: Vec<&str> = Vec::new();
    for finding in diagnosis.left_out.iter().filter(|finding| matches!(finding.doubt, Doubt::Dead | Doubt::Stuck)) {
        let name = finding.channel.as_deref().unwrap_or_default();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    match names.as_slice() {
        [] => String::new(),
        [one] => format!(", without {one} where it stands still"),
        several => format!(", without {} where they stand still", several.join(", ")),
    }
}

/// How a verdict is meant.
pub(crate) fn tone(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::Healthy => Tone::Good,
        Verdict::Faulty => Tone::Alert,
        Verdict::ModelInadequate => Tone::Caution,
    }
}

/// What is told of a fault, with the digits that its interval is worth.
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

const PULLED: &str = "Uncertain values that the record draws furthest, +- one standard deviation";

/// How many of them a text shows.
const MOST_PULLED: usize = 6;

/// The rows of those that are drawn by a standard deviation or more, the furthest first.
fn most_pulled(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
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

/// Its id and size, its 95 % interval, what it is when healthy, and how probable it is.
impl fmt::Display for FaultReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (size, healthy) = (sized(self), with_unit(self.healthy, &self.unit));
        let probability = percent(self.probability);
        write!(f, "{} {size} {}, healthy {healthy}, probability {probability}", self.id, interval(self))
    }
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&write_text(self))
    }
}

/// The diagnosis as a page of text.
pub fn write_text(diagnosis: &Diagnosis) -> String {
    page(diagnosis, Style::PLAIN, [Vec::new(), Vec::new()])
}

/// The same as a terminal shows it: in colour, and where it is wide enough with the intervals within their bounds and the misfit
/// of each sensor over time.
#[cfg(feature = "cli")]
pub fn write_styled(diagnosed: &Diagnosed, rig: &Rig, style: Style) -> String {
    page(&diagnosed.diagnosis, style, [scales(&diagnosed.diagnosis, rig), courses(&diagnosed.misfit)])
}

/// The interval of each fault on the range that was searched.
#[cfg(feature = "cli")]
fn scales(diagnosis: &Diagnosis, rig: &Rig) -> Vec<String> {
    let one = |(fault, report): (&crate::rig::Fault, &FaultReport)| {
        let unit = &rig.parameters[fault.parameter].unit;
        let (low, high) = (unit.from_si(fault.bounds.0), unit.from_si(fault.bounds.1));
        let share = |value: f64| (value - low) / (high - low);
        scale(SCALE, report.ci95.map(|end| end.map(share)), share(report.healthy), share(report.value))
    };
    rig.faults.iter().zip(&diagnosis.faults).map(one).collect()
}

/// The size of the misfit of each sensor over the record, with a gap where the fit has no sample.
#[cfg(feature = "cli")]
fn courses(misfit: &[Vec<f64>]) -> Vec<String> {
    let mean = |part: &[f64]| {
        let there: Vec<f64> = part.iter().filter(|r| is_there(**r)).map(|r| r.abs()).collect();
        there.iter().sum::<f64>() / there.len() as f64
    };
    let course = |misfit: &Vec<f64>| {
        let rows = misfit.len().div_ceil(COURSE).max(1);
        bars(misfit.chunks(rows).map(|part| mean(part) / FULL))
    };
    misfit.iter().map(course).collect()
}

/// A table with a further column of pictures where the terminal has room for it.
fn pictured(
    style: Style,
    heads: &[Head],
    rows: &[Vec<String>],
    (head, pictures): (&'static str, &[String]),
) -> Vec<String> {
    let plain = aligned(heads, rows);
    if pictures.len() != rows.len() {
        return plain;
    }
    let heads: Vec<Head> = heads.iter().copied().chain([(head, false)]).collect();
    let rows: Vec<Vec<String>> = rows
        .iter()
        .zip(pictures)
        .map(|(row, picture)| [row.as_slice(), std::slice::from_ref(picture)].concat())
        .collect();
    let wide = within(None, &heads, &rows);
    let fits = |line: &String| style.width.is_some_and(|width| line.chars().count() <= width);
    if wide.iter().all(fits) { wide } else { plain }
}

fn page(diagnosis: &Diagnosis, style: Style, [scales, courses]: [Vec<String>; 2]) -> String {
    let mut lines = vec![style.painted(&headline(diagnosis), tone(diagnosis.verdict))];
    lines.extend(diagnosis.missing_effect.as_ref().map(sizes));
    lines.extend(caveats(diagnosis));
    lines.push(String::new());
    lines.extend([format!("rig     {}", diagnosis.rig), format!("record  {}", diagnosis.record)]);
    lines.extend(detected(diagnosis));
    lines.extend([String::new(), "Faults".to_owned()]);
    let faults = pictured(style, &FAULT_HEADS, &fault_rows(diagnosis), ("within bounds", &scales));
    let present = std::iter::once(false).chain(diagnosis.faults.iter().map(|fault| fault.present));
    let painted = |(line, present): (String, bool)| if present { style.painted(&line, Tone::Alert) } else { line };
    lines.extend(faults.into_iter().zip(present).map(painted));
    let mut block = |title: &str, rows: Vec<String>| {
        lines.extend([String::new(), title.to_owned()]);
        lines.extend(rows);
    };
    let indented = |said: Vec<String>| said.into_iter().map(|one| format!("  {one}")).collect::<Vec<_>>();
    let unblamed = unblamed(diagnosis);
    if !unblamed.is_empty() {
        block(UNBLAMED, indented(unblamed));
    }
    block("Fault combinations", aligned(&HYPOTHESIS_HEADS, &hypothesis_rows(diagnosis)));
    if !diagnosis.residuals.is_empty() {
        let table = aligned(&residuals::HEADS, &residuals::rows(diagnosis));
        block("Residuals with healthy parameters", [table, indented(residuals::words())].concat());
    }
    let channels = pictured(style, &CHANNEL_HEADS, &channel_rows(diagnosis), ("misfit over time", &courses));
    block("Misfit of each sensor (reduced chi-square 1 is noise and tolerance)", channels);
    let open = open_intervals(diagnosis);
    if !open.is_empty() {
        block(OPEN_INTERVALS, indented(open));
    }
    let left_out = left_out(&diagnosis.left_out, TOLD);
    if !left_out.is_empty() {
        block("Left out of the fit", indented(left_out));
    }
    let pulled = most_pulled(diagnosis);
    if !pulled.is_empty() {
        block(PULLED, aligned(&UNCERTAIN_HEADS, &pulled));
    }
    lines.extend([String::new(), fitted(diagnosis), String::new()]);
    lines_fitted(&lines.join("\n"))
}

/// How the fit went, in a line.
fn fitted(diagnosis: &Diagnosis) -> String {
    let iterations = match diagnosis.fit.iterations {
        1 => "1 iteration".to_owned(),
        several => format!("{several} iterations"),
    };
    format!(
        "fit: reduced chi-square {:.3}, {iterations}, {} simulations of the record; it ended because {}",
        diagnosis.fit.chi2_reduced, diagnosis.fit.solves, diagnosis.fit.stopped_because
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::Identifiable;

    #[test]
    fn what_was_left_out_is_a_gap() {
        let misfit = [vec![FULL; COURSE], vec![0.0; COURSE], [FULL, 0.0].repeat(COURSE / 2)].concat();
        let shown: Vec<char> = courses(&[misfit])[0].chars().collect();
        let third = COURSE / 3;
        assert!(shown[..third - 1].iter().all(|bar| *bar == '█'), "{shown:?}");
        assert!(shown[third + 1..2 * third - 1].iter().all(|bar| *bar == ' '), "{shown:?}");
        // Every second sample is missing.
        assert!(shown[2 * third + 1..].iter().all(|bar| *bar == '█'), "{shown:?}");
    }

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
