//! The clock: stamps that repeat, a clock that was set, missing rows, jitter.

use super::{Doubt, Finding};
use crate::record::{Record, Sampling};

/// An interval of so many usual ones misses a row.
const MISSING: f64 = 1.5;

/// What is doubtful about the time.
pub(super) fn survey(record: &Record) -> Vec<Finding> {
    let time = &record.time;
    let mut findings = Vec::new();
    let mut row = 0;
    for run in time.chunk_by(|a, b| a == b) {
        if run.len() > 1 {
            findings.push(Finding::of_clock(Doubt::DuplicateStamp, time[row], time[row], run.len(), None));
        }
        row += run.len();
    }
    let mut intervals: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    intervals.sort_by(f64::total_cmp);
    let Some(&usual) = intervals.get(intervals.len() / 2) else { return findings };
    for pair in time.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if to < from {
            findings.push(Finding::of_clock(Doubt::ClockReset, to, to, 1, Some(from)));
        } else if to - from > MISSING * usual {
            let rows = ((to - from) / usual).round() as usize - 1;
            findings.push(Finding::of_clock(Doubt::MissingRows, from, to, rows.max(1), None));
        }
    }
    findings.extend(jitter(record, usual));
    findings
}

/// How far intervals scatter around the usual one, without repeated stamps and missing rows.
fn jitter(record: &Record, usual: f64) -> Option<Finding> {
    let own = |pair: &&[f64]| (0.0..=MISSING * usual).contains(&(pair[1] - pair[0])) && pair[1] > pair[0];
    let pairs = || record.time.windows(2).filter(own);
    let off = |pair: &[f64]| pair[1] - pair[0] - usual;
    // As times that follow each other, for the judgement that allows for the rounding of the stamps.
    let mut at = 0.0;
    let rising: Vec<f64> = std::iter::once(0.0)
        .chain(pairs().map(|pair| {
            at += pair[1] - pair[0];
            at
        }))
        .collect();
    if Sampling::of(&rising, record.time_decimals).is_none_or(|sampling| sampling.regular) {
        return None;
    }
    let squares: f64 = pairs().map(|pair| off(pair).powi(2)).sum();
    let rms = (squares / pairs().count() as f64).sqrt();
    let worst = pairs().max_by(|a, b| off(a).abs().total_cmp(&off(b).abs()))?;
    Some(Finding::of_clock(Doubt::Jitter, worst[0], worst[1], pairs().count(), Some(rms)))
}
