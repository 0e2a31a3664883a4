//! The history of a rig as text.

use super::digits::{Estimate, worth};
use super::style::bars;
use super::table::{Head, aligned};
use crate::history::forecast::State;
use crate::history::{Axis, FaultHistory, History};
use crate::number::{before_unit, with_unit};

/// Most bars of a picture: of longer courses, the last.
const MOST: usize = 30;

/// The whole page, with a final line break.
pub fn write_text(history: &History) -> String {
    let name = if history.name.is_empty() { String::new() } else { format!(" ({})", history.name) };
    let days = |moment: &str| moment.get(..10).unwrap_or(moment).to_owned();
    let span = match (history.runs.first(), history.runs.last()) {
        (Some(first), Some(last)) => format!(", {} to {}", days(&first.measured_at), days(&last.measured_at)),
        _ => String::new(),
    };
    let mut lines = vec![format!("{}{name}: {} runs in {}{span}", history.rig, history.runs.len(), history.store)];
    lines.push(String::new());
    lines.extend(aligned(&HEADS, &rows(history)));
    for (heading, notes) in [("remarks", remarks(history)), ("warnings", history.warnings.clone())] {
        if !notes.is_empty() {
            lines.extend([String::new(), format!("{heading}:")]);
            lines.extend(notes.iter().map(|note| format!("  {note}")));
        }
    }
    lines.join("\n") + "\n"
}

pub(super) const HEADS: [Head; 8] = [
    ("fault", false),
    ("history", false),
    ("now", true),
    ("95 %", false),
    ("trend", true),
    ("95 %", false),
    ("limit", true),
    ("reaches the limit", false),
];

pub(super) fn rows(history: &History) -> Vec<Vec<String>> {
    history.faults.iter().map(row).collect()
}

pub(super) fn remarks(history: &History) -> Vec<String> {
    let with_remark = |fault: &FaultHistory| Some(format!("{}: {}", fault.id, fault.remark.as_ref()?));
    history.faults.iter().filter_map(with_remark).collect()
}

fn row(fault: &FaultHistory) -> Vec<String> {
    let (mut now, mut sure, mut slope, mut between) = (String::new(), String::new(), String::new(), String::new());
    match (&fault.trend, fault.values.last()) {
        (Some(trend), _) => {
            let half = 0.5 * (trend.now_ci95[1] - trend.now_ci95[0]);
            now = worth(trend.now, half);
            sure = format!("+- {}", before_unit(worth(half, half), &fault.unit));
            let signed = signed(trend.ci95[1] - trend.ci95[0]);
            slope = format!("{}/{}", signed(trend.slope), trend.per);
            between = format!("{} to {}", signed(trend.ci95[0]), signed(trend.ci95[1]));
        }
        (None, Some(last)) => {
            let last = Estimate { value: last.value, ends: last.ci95 };
            (now, sure) = (last.value(), before_unit(last.interval(), &fault.unit));
        }
        (None, None) => {}
    }
    let limit = fault.limit.map_or_else(String::new, |limit| with_unit(limit, &fault.unit));
    vec![fault.id.clone(), course(fault), now, sure, slope, between, limit, passes(fault)]
}

/// Numbers with their sign and the digits that an interval of this width is worth.
fn signed(width: f64) -> impl Fn(f64) -> String {
    move |value| {
        let number = worth(value, width);
        let is_nothing = number.parse() == Ok(0.0);
        if value > 0.0 && !is_nothing { format!("+{number}") } else { number }
    }
}

pub(super) fn passes(fault: &FaultHistory) -> String {
    let Some(forecast) = &fault.forecast else { return String::new() };
    let at = |axis: &Option<Axis>, without: &str| match axis {
        Some(Axis::Time(moment)) => moment.get(..16).unwrap_or(moment).replace('T', " "),
        Some(Axis::Run(run)) => format!("run {:.1}", run),
        None => without.to_owned(),
    };
    let ends = || format!("{} to {}", at(&forecast.ci95[0], "unknown"), at(&forecast.ci95[1], "never"));
    match forecast.state {
        State::Passed => format!("passed {} ({})", at(&forecast.passes_at, "before"), ends()),
        State::AtLimit => format!("at its limit ({})", ends()),
        State::WillPass => format!("{} ({})", at(&forecast.passes_at, "far ahead"), ends()),
        State::MayPass => format!("not before {}, perhaps never", at(&forecast.ci95[0], "long")),
        State::Receding => "moves away from it".to_owned(),
    }
}

/// The values as bars, the healthy value and the limit within the scale.
fn course(fault: &FaultHistory) -> String {
    let values = || fault.values.iter().map(|value| value.value);
    let known = || values().chain([fault.healthy]).chain(fault.limit);
    let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    let skipped = fault.values.len().saturating_sub(MOST);
    let share = |value: f64| if high > low { (value - low) / (high - low) } else { 0.0 };
    bars(values().skip(skipped).map(share))
}
