//! The diagnosis for people: a page of text to hand on; `pages::diagnosis` has the one with pictures.

use std::fmt;

use super::caveats::{TOLD, caveats, detected, left_out};
use super::diagnosis_tables::{
    CHANNEL_HEADS, FAULT_HEADS, HYPOTHESIS_HEADS, OPEN_INTERVALS, PULLED, UNBLAMED, UNCERTAIN_HEADS, channel_rows,
    fault_rows, hypothesis_rows, interval, most_pulled, open_intervals, percent, sized, unblamed,
};
use super::headline::{headline, sizes, tone};
use super::residuals;
use super::style::{Style, Tone};
#[cfg(feature = "cli")]
use super::style::{bars, scale};
use super::table::{Head, aligned, fitted as lines_fitted, within};
#[cfg(feature = "cli")]
use crate::diagnosis::{Diagnosed, is_there};
use crate::diagnosis::{Diagnosis, FaultReport};
use crate::number::with_unit;
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
    lines.extend(diagnosis.missing_effect.as_ref().and_then(sizes));
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
}
