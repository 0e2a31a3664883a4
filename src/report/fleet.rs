//! A fleet as text.

use super::digits::Estimate;
use super::style::bars;
use super::table::{Head, aligned};
use crate::fleet::{Fleet, Next, Present, Standing};
use crate::history::forecast::State as Towards;
use crate::number::with_unit;

/// Rigs that are listed unless all are asked for.
const WORST: usize = 20;

/// The whole page, with a final line break.
pub fn write_text(fleet: &Fleet, all: bool) -> String {
    let shown = if all { fleet.rigs.len() } else { fleet.rigs.len().min(WORST) };
    let rows: Vec<Vec<String>> = fleet.rigs[..shown].iter().map(row).collect();
    let mut lines = vec![headline(fleet), counts(fleet), String::new()];
    lines.extend(aligned(&HEADS, &rows));
    if shown < fleet.rigs.len() {
        lines.extend([String::new(), format!("{} more; `--all` shows them", fleet.rigs.len() - shown)]);
    }
    lines.join("\n") + "\n"
}

pub(super) const HEADS: [Head; 7] = [
    ("rig", false),
    ("state", false),
    ("found in the last run", false),
    ("next limit", false),
    ("course", false),
    ("last run", false),
    ("runs", true),
];

/// What there is in all.
pub(super) fn headline(fleet: &Fleet) -> String {
    let plural = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
    format!("{}: {}, {}", fleet.source, plural(fleet.rigs.len(), "rig"), plural(fleet.runs, "run"))
}

/// How many rigs are in each state that has any.
pub(super) fn counts(fleet: &Fleet) -> String {
    let some = fleet.states.iter().filter(|(_, count)| **count > 0);
    some.map(|(state, count)| format!("{count} {}", state.words())).collect::<Vec<_>>().join(", ")
}

pub(super) fn row(rig: &Standing) -> Vec<String> {
    vec![
        rig.rig.clone(),
        rig.state.words().to_owned(),
        rig.faults.iter().map(found).collect::<Vec<_>>().join("; "),
        rig.next.as_ref().map_or_else(String::new, next),
        course(rig),
        rig.measured_at.short().trim_end_matches(" UTC").to_owned(),
        rig.runs.to_string(),
    ]
}

fn found(fault: &Present) -> String {
    let value = fault.value.map_or_else(String::new, |value| {
        let shown = Estimate { value, ends: fault.ci95 }.value();
        format!(" {}", crate::number::before_unit(shown, &fault.unit))
    });
    format!("{}{value}", fault.id)
}

/// Which limit, and when.
pub(super) fn next(next: &Next) -> String {
    let day = |moment: &Option<String>| moment.as_ref().map(|moment| moment.get(..10).unwrap_or(moment).to_owned());
    let limit = format!("{} {}", next.fault, with_unit(next.limit, &next.unit));
    match (next.state, day(&next.reached_at)) {
        (Towards::AtLimit, _) => format!("{limit} at hand"),
        (Towards::Passed, Some(day)) => format!("{limit} passed {day}"),
        (Towards::Passed, None) => format!("{limit} passed"),
        (_, Some(day)) => format!("{limit} {day}"),
        (_, None) => format!("{limit} far ahead"),
    }
}

/// The last values as bars, the healthy value and the limit within the scale.
fn course(rig: &Standing) -> String {
    let Some(course) = rig.course.as_ref().filter(|course| course.values.len() > 1) else { return String::new() };
    let known = || course.values.iter().copied().chain([course.healthy]).chain(course.limit);
    let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    bars(course.values.iter().map(|value| if high > low { (value - low) / (high - low) } else { 0.0 }))
}
