//! A diagnosis in a few lines: the verdict first, then each finding, the next command last.

use std::path::Path;

use super::addition::VERY_STRONG;
use super::brief::{next_line, wrapped};
use super::caveats::{caveats, detected};
use super::diagnosis_tables::{healthy, interval, percent, sized};
use super::headline::{headline, sizes, tone};
use super::learn::{multiple, times};
use super::style::Style;
use crate::diagnosis::{Diagnosis, FaultReport, RivalEffect, Verdict};
use crate::finding::{Finding, Rival, argument};
use crate::number::{before_unit, rounded, text, with_unit};

/// Digits of the ends of a change.
const CHANGE_DIGITS: usize = 2;
/// Lines of findings: with verdict, notes and next command a screen of 24 lines is not filled.
const LINES: usize = 10;
/// Consequences that are shown of each finding, of few and of many.
const CHANGES: [usize; 2] = [2, 1];
const FEW: usize = 2;
/// Findings of which another explanation is named.
const RIVALS: usize = 2;
/// Faults of a model that explains nothing well that are named.
const ATTEMPTED: usize = 4;

/// What a run of `diagnose` leaves anyway, so that it is not said to be the next step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Left<'a> {
    /// Whether it writes a page.
    pub page: bool,
    /// The store that it adds to.
    pub store: Option<&'a Path>,
}

/// The diagnosis for people, no wider than a terminal.
pub fn brief(diagnosis: &Diagnosis, findings: &[Finding], style: Style, written: Left<'_>) -> String {
    let headline = wrapped(&headline(diagnosis), "  ");
    let mut lines: Vec<String> =
        headline.into_iter().map(|line| style.painted(&line, tone(diagnosis.verdict))).collect();
    lines.push(String::new());
    match (diagnosis.verdict, &diagnosis.missing_effect) {
        (Verdict::Healthy, _) => lines.extend(wrapped(&most_suspect(diagnosis), "  ")),
        (Verdict::Faulty, _) => lines.extend(found(diagnosis, findings)),
        (Verdict::ModelInadequate, Some(missing)) => {
            lines.extend(sizes(missing).iter().flat_map(|sizes| wrapped(sizes, "  ")));
            lines.extend(found(diagnosis, findings));
        }
        (Verdict::ModelInadequate, None) => lines.extend(wrapped(&attempted(diagnosis), "  ")),
    }
    let words: Vec<String> = detected(diagnosis).into_iter().chain([left(diagnosis)]).collect();
    lines.extend(wrapped(&words.join(" "), "  "));
    lines.extend(caveats(diagnosis).iter().flat_map(|caveat| wrapped(caveat, "  ")));
    lines.push("Intervals hold 95 %; `--all` shows every fault, residual and sensor.".to_owned());
    lines.extend(next(diagnosis, findings, written).into_iter().map(|command| next_line(&command)));
    lines.join("\n") + "\n"
}

/// How far the model with what was found is from the record.
pub(super) fn left(diagnosis: &Diagnosis) -> String {
    let worst = diagnosis.channels.iter().max_by(|a, b| a.times_noise.total_cmp(&b.times_noise));
    let worst =
        worst.map_or_else(String::new, |worst| format!(", most in {} ({})", worst.name, multiple(worst.times_noise)));
    format!("Error left: {}{worst}.", times(diagnosis.times_noise))
}

/// The fault that comes nearest to being present.
fn most_suspect(diagnosis: &Diagnosis) -> String {
    let count = diagnosis.faults.len();
    match diagnosis.faults.iter().max_by(|a, b| a.probability.total_cmp(&b.probability)) {
        None => "The rig file has no faults.".to_owned(),
        Some(FaultReport { id, probability, .. }) => {
            let probability = percent(*probability).replace(' ', "\u{a0}");
            format!("No fault is present; the most probable of {count}: {id}, {probability}.")
        }
    }
}

/// What was estimated although no faults explain the record.
fn attempted(diagnosis: &Diagnosis) -> String {
    let present: Vec<String> = diagnosis.present().map(|fault| format!("{} {}", fault.id, sized(fault))).collect();
    match present.as_slice() {
        [] => "The healthy model comes as near as any faults do.".to_owned(),
        some => {
            let more = some.len().saturating_sub(ATTEMPTED);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("Nearest: {}{more}.", some[..some.len().min(ATTEMPTED)].join(", "))
        }
    }
}

/// The findings, as many in full as there are lines for, and what goes for all of them.
fn found(diagnosis: &Diagnosis, findings: &[Finding]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut rest = Vec::new();
    let changes = CHANGES[usize::from(findings.len() > FEW)];
    for (finding, fault) in findings.iter().zip(diagnosis.present()) {
        let block = block(finding, fault, changes);
        if rest.is_empty() && lines.len() + block.len() <= LINES {
            lines.extend(block);
        } else {
            rest.push(format!("{} {}", fault.id, sized(fault)));
        }
    }
    if !rest.is_empty() {
        lines.extend(wrapped(&format!("and {}", rest.join(", ")), "  "));
    }
    let rivals = findings.iter().enumerate().filter_map(|(place, finding)| {
        let rival = finding.rivals.first()?;
        // What a fault cannot be told from, and physics that the rig file lacks, is its own; combinations are the same for all.
        (place == 0 || rival.probability.is_none()).then(|| instead(rival, finding))
    });
    lines.extend(rivals.take(RIVALS).flat_map(|words| wrapped(&words, "  ")));
    lines.extend(
        diagnosis.alike.iter().take(RIVALS).filter_map(|group| alike(group)).flat_map(|words| wrapped(&words, "  ")),
    );
    lines
}

/// A fault and what no rig file declares and does the same, in a sentence; `None` of nothing.
pub(super) fn alike(group: &[String]) -> Option<String> {
    let (fault, values) = group.split_first()?;
    let (are, does) =
        if values.len() > 1 { ("are no declared faults", "do") } else { ("is no declared fault", "does") };
    Some(format!("{} {are}, and {does} the same to this record as {fault}.", values.join(", ")))
}

/// A finding: its size, its interval, how sure; what it is; its largest consequences.
fn block(finding: &Finding, fault: &FaultReport, changes: usize) -> Vec<String> {
    let size = format!(
        "{} {} ({}), new {}{}, {}",
        fault.id,
        sized(fault),
        interval(fault),
        healthy(fault),
        changed(fault),
        percent(fault.probability).replace(' ', "\u{a0}")
    );
    let changes: Vec<&str> = finding.consequences.iter().take(changes).map(|one| one.text.as_str()).collect();
    let changes = if changes.is_empty() { String::new() } else { format!("; {}", changes.join("; ")) };
    let deviation = format!("  {}: {} {} than new{changes}", finding.part, finding.deviation, finding.direction);
    [wrapped(&size, "  "), wrapped(&deviation, "    ")].concat()
}

/// The change of a fault whose interval holds the healthy value: neither is known as well as the change.
fn changed(fault: &FaultReport) -> String {
    let holds = !fault.interval_misses(fault.healthy, 0.0);
    let [low, high] = match fault.change95.filter(|_| holds) {
        Some(ends) => ends.map(|end| text(rounded(end, CHANGE_DIGITS))),
        None => return String::new(),
    };
    format!(", changed by {low} to {}", before_unit(high, &fault.unit))
}

/// The likeliest explanation without a finding.
fn instead(rival: &Rival, finding: &Finding) -> String {
    let id = &finding.id;
    match (&rival.effect, rival.probability) {
        (Some(effect), _) => format!("Instead of {id}: the effect {}.", in_place(effect)),
        (None, None) => format!("This record cannot isolate {id} from {}.", faults_of(rival)),
        (None, Some(probability)) => format!("Instead of {id}: {}, {}.", faults_of(rival), percent(probability)),
    }
}

/// The faults of a rival in words.
pub(super) fn faults_of(rival: &Rival) -> String {
    if rival.faults.is_empty() { "nothing".to_owned() } else { rival.faults.join(" + ") }
}

/// An effect in place of a fault, with its size and how well it explains the record.
pub(super) fn in_place(rival: &RivalEffect) -> String {
    let (part, size) = (rival.part.replace('_', " "), with_unit(rival.value, &rival.unit));
    let well = if rival.delta_bic > VERY_STRONG { "better" } else { "as well" };
    format!("{} ({part} {size}), which explains the record {well}", rival.effect)
}

/// The command that leads further.
pub(super) fn next(diagnosis: &Diagnosis, findings: &[Finding], written: Left<'_>) -> Option<String> {
    let (rig, record) = (argument(&diagnosis.rig), argument(&diagnosis.record));
    if diagnosis.unfilled > 0 || !diagnosis.at_odds.is_empty() || diagnosis.is_misread() {
        return Some(format!("borescope check {rig} {record}"));
    }
    if let Some(off) = &diagnosis.off_data_sheet {
        if off.beyond_chance().is_some() && diagnosis.verdict == Verdict::Healthy {
            return Some(format!("borescope suggest {rig} {record} --check ANOTHER_RECORD"));
        }
        return Some(format!("borescope calibrate {rig} HEALTHY_RECORD -o calibrated.toml"));
    }
    if diagnosis.is_as_new() {
        return Some(format!("borescope calibrate {rig} HEALTHY_RECORD -o calibrated.toml"));
    }
    match diagnosis.verdict {
        // What lies within the tolerance may be physics all the same.
        _ if diagnosis.is_above_noise() => Some(format!("borescope suggest {rig} {record} --check ANOTHER_RECORD")),
        Verdict::Healthy if diagnosis.is_strained() => {
            Some(format!("borescope suggest {rig} {record} --check ANOTHER_RECORD"))
        }
        Verdict::Healthy => Some(format!("borescope isolability {rig} --input {record}")),
        // Physics that may be missing is asked of a second record first.
        Verdict::Faulty => {
            let by_effect = |finding: &&Finding| finding.rivals.first().is_some_and(|rival| rival.effect.is_some());
            let finding = findings.iter().find(by_effect).or(findings.first())?;
            Some(match (finding.rivals.is_empty() && written.page, written.store) {
                (false, _) => finding.next.command.clone(),
                // With the page written, what is left to know is how the fault grows.
                (true, None) => format!("borescope diagnose {rig} {record} --store runs.db"),
                (true, Some(store)) => format!("borescope history {rig} --store {}", argument(store)),
            })
        }
        Verdict::ModelInadequate => Some(format!("borescope suggest {rig} {record} --check ANOTHER_RECORD")),
    }
}
