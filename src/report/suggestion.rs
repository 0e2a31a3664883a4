//! A suggestion in a few lines: the verdict first, the errors with and without the effect, the next command last.

use super::brief::{ErrorRow, errors, next_line, wrapped};
use super::caveats::{learnt_with, left_open, unsure_file};
use super::learn::{conclusion_in_short, estimate, experiment, missed_in_short};
use super::unknown::Rise;
use crate::finding::argument;
use crate::finding::lacking::{Lacking, does};
use crate::learn::evaluated::Conclusion;
use crate::learn::result::{CandidateReport, EffectParameter, SuggestionReport};
use crate::number::before_unit;

/// Candidates that a page shows, the best included, and those of the short text.
pub(super) const SHOWN: usize = 3;
const SHOWN_IN_SHORT: usize = 2;
/// Lines of the sizes of the best candidate.
const SIZES: usize = 3;
/// Parameters from which on an effect is a curve.
pub(super) const CURVE: usize = 12;

/// What is left where the library has no law.
pub(super) const OWN_LAW: &str = "What the library has no law for can be written as a formula, under `[own_effects]`.";

/// The suggestion for people, no wider than a terminal.
pub fn brief(report: &SuggestionReport, finding: Option<&Lacking>, rise: Option<&Rise>) -> String {
    let verdict = match rise {
        None => conclusion_in_short(report),
        Some(rise) => format!("UNKNOWN EFFECT: no effect of the library explains the misfit. {}", rise.sentence()),
    };
    let mut lines = wrapped(&verdict, "  ");
    let best = report.worth_naming();
    lines.extend(best.filter(|_| rise.is_none()).into_iter().flat_map(sizes));
    if let Some(rise) = rise {
        lines.extend(rise.lines(&report.rig));
    }
    let missed = (
        if best.is_some() && report.conclusion != Conclusion::UnknownEffect { "Without it, most" } else { "Most" },
        if report.misses_check { " of the check record" } else { "" },
    );
    // An effect that is found says more than the place that it explains.
    match finding.filter(|_| report.conclusion == Conclusion::EffectFound).and_then(does) {
        Some(does) => lines.extend(wrapped(&does, "  ")),
        None if rise.is_some() => {}
        None => lines
            .extend(report.place.as_ref().into_iter().flat_map(|place| wrapped(&missed_in_short(place, missed), "  "))),
    }
    lines.extend(learnt_with(&report.dynamics).into_iter().flat_map(|words| wrapped(&words, "  ")));
    lines.extend(report.experiment.as_ref().map(experiment).into_iter().flat_map(|words| wrapped(&words, "  ")));
    if let Some(first) = report.candidates.first() {
        lines.push(String::new());
        let shown = if rise.is_some() { 1 } else { SHOWN_IN_SHORT };
        lines.extend(errors(&rows(report, first, shown)));
    }
    // What speaks against the best comes before what may be wrong in any file.
    let caveats = best.map_or(&report.moved, |best| &best.warnings);
    match (caveats.first(), rise) {
        (Some(caveat), _) => lines.extend(wrapped(&format!("Caveat: {caveat}."), "  ")),
        (None, Some(_)) => {}
        (None, None) => lines.extend(of_the_file(report, rise).iter().flat_map(|words| wrapped(words, "  "))),
    }
    lines.extend(left_open(&report.left_open).iter().flat_map(|words| wrapped(words, "  ")));
    if report.conclusion == Conclusion::UnknownEffect && rise.is_none() {
        lines.extend(wrapped(OWN_LAW, "  "));
    }
    lines.push("`--all` shows every candidate, and what this record could have shown.".to_owned());
    lines.push(next_line(&next(report, rise)));
    lines.join("\n") + "\n"
}

/// The values of an effect; those of a curve say nothing one by one.
fn sizes(best: &CandidateReport) -> Vec<String> {
    let count = best.parameters.len();
    let shown = match count {
        curve if curve > CURVE => 0,
        few if few <= SIZES => few,
        _ => SIZES - 1,
    };
    let mut lines: Vec<String> = best.parameters.iter().take(shown).flat_map(size).collect();
    if count > shown {
        lines.push(if shown == 0 {
            format!("  a curve of {count} values")
        } else {
            format!("  and {} more values", count - shown)
        });
    }
    lines
}

fn size(one: &EffectParameter) -> Vec<String> {
    let shown = estimate(one);
    let interval = if one.ci95 == [None, None] { String::new() } else { format!(" ({})", shown.interval()) };
    let bound = if one.at_bound { ", at the bound of its search" } else { "" };
    wrapped(&format!("  {} {}{interval}{bound}", one.id, before_unit(shown.value(), &one.unit)), "    ")
}

/// Whether a value that has changed since calibration may be what no effect explains.
fn may_have_changed(report: &SuggestionReport) -> bool {
    report.calibrated && report.conclusion == Conclusion::UnknownEffect
}

/// What of the rig file may be behind a misfit.
pub(super) fn of_the_file(report: &SuggestionReport, rise: Option<&Rise>) -> Option<String> {
    if may_have_changed(report) && rise.is_none() {
        return Some("A value that has changed since calibration is no effect: `diagnose` looks for it among the calibrated ones.".to_owned());
    }
    unsure_file(report.unfilled, report.taken_as_exact, report.conclusion == Conclusion::Adequate)
}

/// Your model beside the best candidates, no more than so many.
pub(super) fn rows(report: &SuggestionReport, first: &CandidateReport, most: usize) -> Vec<ErrorRow> {
    let with = if report.faults.is_empty() { String::new() } else { format!(", with {}", faults(&report.faults)) };
    let yours = ErrorRow { name: format!("your model{with}"), fit: first.rmse_before, check: first.check_rmse_before };
    // With what is refused, or explains nothing, and reduces nothing there is nothing to compare.
    let explains = report.conclusion != Conclusion::UnknownEffect;
    let is_told = |one: &&CandidateReport| one.supported && explains || one.lowers_the_error();
    let shown = report.candidates.iter().filter(is_told).take(most);
    let each = shown.map(|one| {
        let rejected = if one.supported { "" } else { " (not supported)" };
        let name = format!("+ {}{rejected}", one.effect);
        ErrorRow { name, fit: one.rmse_after, check: one.check_rmse_after }
    });
    std::iter::once(yours).chain(each).collect()
}

/// Faults of a model in a name: one by its id, several by their number.
pub(super) fn faults<T: AsRef<str>>(ids: &[T]) -> String {
    match ids {
        [one] => format!("the fault {}", one.as_ref()),
        several => format!("{} faults", several.len()),
    }
}

/// The command that leads further.
pub fn next(report: &SuggestionReport, rise: Option<&Rise>) -> String {
    let best = report.candidates.first().filter(|best| best.supported);
    let (rig, record) = (argument(&report.rig), argument(&report.record));
    if report.unfilled > 0 {
        return format!("borescope check {rig} {record}");
    }
    if rise.is_some() {
        let check = report.check.as_deref().map_or_else(|| "ANOTHER_RECORD".to_owned(), argument);
        return format!("borescope suggest RIG_WITH_THE_LAW.toml {record} --check {check}");
    }
    if may_have_changed(report) {
        let missed = report.check.as_deref().filter(|_| report.misses_check).map_or(record, argument);
        return format!("borescope diagnose {rig} {missed}");
    }
    let Some(check) = report.check.as_deref().map(argument) else {
        return match report.conclusion {
            Conclusion::Adequate => format!("borescope diagnose {rig} {record}"),
            _ => format!("borescope suggest {rig} {record} --check ANOTHER_RECORD"),
        };
    };
    match (report.conclusion, best) {
        (Conclusion::Adequate, _) => format!("borescope diagnose {rig} {record}"),
        (Conclusion::Confounded, _) => format!("borescope suggest {rig} {record} --check RECORD_OF_THAT_EXPERIMENT"),
        (Conclusion::EffectFound, Some(best)) if !best.effect.contains(" + ") => {
            format!("borescope add {rig} {} --fit {record} -o better.toml", best.effect)
        }
        // What no effect explains may be parts that are not as their data sheets have them.
        (Conclusion::UnknownEffect, _) if report.taken_as_exact > 0 && !report.calibrated => {
            format!("borescope calibrate {rig} HEALTHY_RECORD... -o calibrated.toml")
        }
        _ => format!("borescope improve {rig} --fit {record} --check {check} -o better.toml"),
    }
}
