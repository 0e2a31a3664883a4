//! The verdict of a diagnosis in one line, and what it says of a missing effect.

use super::diagnosis_tables::{percent, sized};
use super::digits::plus_minus;
use super::style::Tone;
use crate::diagnosis::{Diagnosis, FaultReport, MissingEffect, UncertainReport, Verdict};
use crate::number::{before_unit, rounded, text};
use crate::record::survey::Doubt;

/// The verdict in one line.
pub fn headline(diagnosis: &Diagnosis) -> String {
    let present: Vec<String> = diagnosis.present().map(named).collect();
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

/// A fault with its size, and how probable it is where that leaves a doubt as large as intervals do.
fn named(fault: &FaultReport) -> String {
    let sized = format!("{} {}", fault.id, sized(fault));
    if fault.probability < COVERED { format!("{sized} ({})", percent(fault.probability)) } else { sized }
}

/// Probability with which intervals hold the truth.
const COVERED: f64 = 0.95;

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

/// Sizes of a missing effect that are shown one by one.
const SIZES: usize = 4;

/// How large the effect is that the model lacks; `None` of one that stands in the rig file with a value that is fitted anyway.
pub(super) fn sizes(missing: &MissingEffect) -> Option<String> {
    if missing.parameters.is_empty() {
        return None;
    }
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
    Some(format!("Its size: {}{more} (one standard deviation).", told.join(", ")))
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
