//! The page of a history: each fault over the runs, its trend, its limit and when it passes it.

use super::learn::named_or;
use crate::history::forecast::{State, passing};
use crate::history::regression::Line;
use crate::history::{By, FaultHistory, History, RunLine};
use crate::report::history as words;
use crate::report::html::{Column, Page, Section, Table};
use crate::report::plot::{Axis, Chart, Envelope, Live, Rule, Series};
use crate::report::style::Tone;

/// Points of a trend and its band.
const POINTS: usize = 60;
/// How far ahead a trend is shown at most, in lengths of the course.
const AHEAD: f64 = 2.0;
/// What is left free around the course, of its length.
const RIM: f64 = 0.03;
/// The same above and below, of the range of the values and the limit: room for its name.
const ROOM: f64 = 0.12;

/// The page: what passes its limit when, every course with its trend, the runs.
pub fn html(history: &History) -> String {
    let lead = format!("{} runs in {}", history.runs.len(), history.store);
    let mut page = Page::new(format!("History of {}", named_or(&history.name, &history.rig)), lead);
    let mut verdict = Section::new("Limits");
    let (tone, said) = verdict_of(history);
    verdict.notice(tone, said);
    verdict.table(Table::of("Every fault over the runs", &words::HEADS, words::rows(history)));
    for (heading, notes) in [("Remarks", words::remarks(history)), ("Warnings", history.warnings.clone())] {
        if !notes.is_empty() {
            verdict.subheading(heading);
            verdict.list(notes);
        }
    }
    page.section(verdict);
    let mut courses = Section::new("Courses");
    courses.paragraph(
        "Each dot is the estimate of one run with its 95 % interval as a stroke, the band that of the trend. The limit and the healthy value \
         are dotted; the trend goes on to where it passes the limit, as far as that can be shown.",
    );
    for fault in history.faults.iter().filter(|fault| !fault.values.is_empty()) {
        let (chart, live) = course(history, fault);
        courses.chart(&chart, &live);
    }
    page.section(courses);
    let mut runs = Section::new("Runs");
    let row = |run: &RunLine| {
        [run.run.to_string(), run.measured_at.clone(), run.record.clone(), run.verdict.clone()].map(Into::into).to_vec()
    };
    let columns = ["run", "measured", "record", "verdict"].map(Column::text).to_vec();
    runs.table(Table::new("Runs that count", columns, history.runs.iter().map(row).collect()));
    page.section(runs);
    page.html()
}

/// The worst that a forecast says.
fn verdict_of(history: &History) -> (Tone, String) {
    let of = |wanted: &[State]| -> Vec<String> {
        let forecast = |fault: &&FaultHistory| fault.forecast.as_ref().is_some_and(|one| wanted.contains(&one.state));
        history.faults.iter().filter(forecast).map(|fault| format!("{}: {}", fault.id, words::passes(fault))).collect()
    };
    let (beyond, ahead) = (of(&[State::Passed, State::AtLimit]), of(&[State::WillPass]));
    if !beyond.is_empty() {
        (Tone::Alert, format!("At or beyond its limit: {}.", beyond.join("; ")))
    } else if !ahead.is_empty() {
        (Tone::Caution, format!("On its way to its limit: {}.", ahead.join("; ")))
    } else if history.faults.iter().any(|fault| fault.limit.is_some()) {
        (Tone::Good, "No fault is surely on its way to its limit.".to_owned())
    } else {
        (Tone::Caution, "No fault of the rig file has a `limit`, so nothing is forecast.".to_owned())
    }
}

fn course(history: &History, fault: &FaultHistory) -> (Chart, Live) {
    let first = fault.values.iter().map(|value| value.x).fold(f64::INFINITY, f64::min);
    let last = fault.values.iter().map(|value| value.x).fold(f64::NEG_INFINITY, f64::max);
    let (origin, x) = match history.by {
        By::Time => {
            let begun = fault.values.iter().min_by(|a, b| a.x.total_cmp(&b.x)).map_or("", |value| &value.measured_at);
            let begun = begun.get(..16).unwrap_or(begun).replace('T', " ");
            (first, Axis::new(format!("time from {begun} UTC"), "days"))
        }
        By::Run => (0.0, Axis::new("run", "")),
    };
    let at = |x: f64| x - origin;
    let strokes = fault.values.iter().filter_map(|value| match value.ci95 {
        [Some(low), Some(high)] => Some([(at(value.x), low), (at(value.x), high), (f64::NAN, f64::NAN)]),
        _ => None,
    });
    let dots = fault.values.iter().map(|value| (at(value.x), value.value)).collect();
    let mut series =
        vec![Series::line("", strokes.flatten().collect()).styled(5, 0), Series::dots("runs", dots).styled(0, 0)];
    let mut rules = Vec::new();
    let mut envelopes = Vec::new();
    let length = (last - first).max(1e-3);
    let mut until = last;
    if let Some(line) = &fault.line {
        let passing = fault.limit.map(|limit| passing(line, limit, limit > fault.healthy, last));
        let ahead = passing.and_then(|passing| passing.between[1].or(passing.at)).map_or(last, |ahead| ahead.max(last));
        until = ahead.min(last + AHEAD * length);
        let shown = shares(first, until).map(|x| (at(x), line.value(x)));
        series.push(Series::line("trend", shown.collect()).styled(1, 0));
        envelopes.push(band(line, (first, until), &at));
        let passes = passing.and_then(|passing| passing.at).filter(|passes| (first..=until).contains(passes));
        rules.extend(passes.map(|x| Rule::Vertical { x: at(x), label: "reaches the limit".to_owned() }));
    }
    rules.extend(fault.limit.map(|y| Rule::Horizontal { y, label: "limit".to_owned() }));
    rules.push(Rule::Horizontal { y: fault.healthy, label: "healthy".to_owned() });
    let rim = RIM * (until - first).max(1e-3);
    let x = x.over(at(first) - rim, at(until) + rim);
    let (low, high) = heights(fault);
    let y = Axis::new("", &fault.unit).over(low - ROOM * (high - low), high + ROOM * (high - low));
    let mut chart = Chart::new(&fault.id, x, y, series).high(200.0);
    (chart.rules, chart.envelopes) = (rules, envelopes);
    (chart, Live::new("runs", format!("{} over the runs: {}", fault.id, fault.meaning)))
}

/// Least and greatest of what a course shows.
fn heights(fault: &FaultHistory) -> (f64, f64) {
    let values = fault.values.iter().flat_map(|value| [Some(value.value), value.ci95[0], value.ci95[1]]);
    let all = values.chain([Some(fault.healthy), fault.limit]).flatten();
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    if high > low { (low, high) } else { (low - 1.0, high + 1.0) }
}

fn shares(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..=POINTS).map(move |k| from + (to - from) * k as f64 / POINTS as f64)
}

fn band(line: &Line, (from, to): (f64, f64), at: &dyn Fn(f64) -> f64) -> Envelope {
    let half = |x: f64| line.half_width(x);
    let points = shares(from, to).map(|x| (at(x), line.value(x) - half(x), line.value(x) + half(x))).collect();
    Envelope { name: "95 %".to_owned(), points, colour: 1 }
}
