//! The page of `compare`, and what the pages of models beside records share.

use super::bars::bars;
use super::channels::{FOUND, Said, Shown, YOURS, by_sensor};
use super::misfit;
use crate::complaint::Complaint;
use crate::finding::Consequence;
use crate::learn::compare::Compared;
use crate::learn::comparison::{ChannelComparison, Comparison, FittedParameter, PresentFault, WithFaults};
use crate::number::{rounded, with_unit};
use crate::record::Record;
use crate::report::brief::ErrorRow;
use crate::report::circuit::{self, Marked};
use crate::report::comparison as brief;
use crate::report::digits::{plus_minus, worth};
use crate::report::html::{Cell, Column, Mark, Page, Scale, Section, Table};
use crate::report::learn as words;
use crate::report::provenance::Provenance;
use crate::report::suggestion::faults;
use crate::rig::Rig;

/// Standard deviations to each side of a nominal value that its scale shows.
const REACH: f64 = 4.0;

pub(super) fn named(rig: &Rig) -> String {
    named_or(&rig.name, &rig.path.display().to_string())
}

/// The name of a rig, or its file where it has none.
pub(super) fn named_or(name: &str, file: &str) -> String {
    if name.is_empty() { file.to_owned() } else { name.to_owned() }
}

/// The page of a comparison: how far off, where, the chart of the sensor that is missed most; the rest is folded.
///
/// # Errors
/// Columns that are missing.
pub fn comparison(
    rig: &Rig,
    record: &Record,
    compared: &Compared,
    events: &[Consequence],
) -> Result<String, Complaint> {
    let comparison = &compared.comparison;
    let shown = Shown::new(rig, record, "time", 1)?;
    let mut page = Page::new(format!("Comparison of {}", named(rig)), format!("Record {}", comparison.record));
    page.provenance(Provenance::of(rig, [record]));
    let mut verdict = Section::new("Verdict");
    verdict.notice(words::comparison_tone(comparison), words::comparison_headline(comparison));
    if let Some(with_faults) = &comparison.with_faults {
        let (heading, faults) = brief::explained_by(with_faults);
        verdict.paragraph(heading);
        verdict.list(faults);
    }
    if let Some(events) = brief::read(events) {
        verdict.paragraph(events);
    }
    verdict.table(bars("Error over all sensors, times the sensor noise", &errors(comparison)));
    if let Some(stated) = brief::stated(comparison) {
        verdict.paragraph(stated);
    }
    if let Some(far) = brief::far(comparison) {
        verdict.paragraph(far);
    }
    let (heads, rows) = brief::table(comparison);
    verdict.table(Table::of(
        "Error of each sensor, times its noise; `explained` is judged within noise and tolerance",
        &heads,
        rows,
    ));
    if let Some(draft) = brief::of_the_file(comparison) {
        verdict.paragraph(draft);
    }
    verdict.preformatted(format!("Next: {}", brief::next(comparison)));
    page.section(verdict);
    let (marks, what) = match &comparison.with_faults {
        Some(with) if !with.faults.is_empty() => {
            let mark = |fault: &PresentFault| Marked::of(&fault.id, &with_unit(rounded(fault.value, 3), &fault.unit));
            (with.faults.iter().map(mark).collect(), "what explains the record best is framed")
        }
        _ => {
            let missed = comparison.channels.iter().filter(|channel| !channel.adequate);
            let mark = |channel: &ChannelComparison| Marked {
                id: channel.name.clone(),
                owner: format!("sensor.{}", channel.name),
                text: words::multiple(channel.times_noise),
            };
            (missed.map(mark).collect::<Vec<_>>(), "behind each sensor that your model misses by how much")
        }
    };
    page.section(drawn(rig, &marks, what));
    let yours = Said { name: "your model", outputs: &compared.run.outputs, style: YOURS };
    let found = compared.found.as_ref().map(|outputs| Said { name: "with the faults", outputs, style: FOUND });
    let mut place = Section::new("Where it misses");
    if let Some(at) = &comparison.place {
        place.paragraph(words::sits(at));
    }
    match &compared.found {
        None => misfit::add(&mut place, &shown, &compared.run.outputs, yours.name),
        Some(found) => {
            let names = ("your model", "with the faults that explain it best");
            misfit::add_both(&mut place, &shown, (&compared.run.outputs, found), names);
        }
    }
    page.section(place);
    let models: Vec<Said<'_>> = std::iter::once(yours).chain(found).collect();
    let worst = comparison.channels.iter().max_by(|a, b| a.times_noise.total_cmp(&b.times_noise));
    let worst = worst.and_then(|worst| rig.sensors.iter().position(|sensor| sensor.name == worst.name)).unwrap_or(0);
    page.section(curves(&shown, worst, &models, "Measured against the model"));
    let worst = words::worst_rows(comparison);
    let mut figures = Section::folded("The fit in figures");
    figures.table(words::channel_table(comparison));
    if !worst.is_empty() {
        figures.table(Table::of("Largest whitened misfits, by sensor", &words::WORST_HEADS, worst));
    }
    if !comparison.fitted.is_empty() {
        figures.table(fitted_table(&comparison.fitted));
    }
    let mut whitened = Section::new("");
    shown.whitened(&mut whitened, &by_sensor(&compared.run.misfit, record));
    figures.fold("Whitened misfit of each sensor", false, whitened);
    page.section(figures);
    Ok(page.html())
}

/// The errors of a comparison, of an older rig file first.
fn errors(comparison: &Comparison) -> Vec<ErrorRow> {
    let row = |name: String, fit: f64| ErrorRow { name, fit, check: None };
    let faults = |with: &WithFaults| match with.faults.as_slice() {
        [] => "parts off their data sheets".to_owned(),
        present => faults(&present.iter().map(|fault| fault.id.as_str()).collect::<Vec<_>>()),
    };
    let mut rows = Vec::new();
    if let Some(before) = &comparison.before {
        rows.push(row(format!("before: {}", before.rig), before.times_noise));
        rows.extend(
            before.with_faults.as_ref().map(|with| row(format!("before, with {}", faults(with)), with.times_noise)),
        );
    }
    rows.push(row("your model".to_owned(), comparison.times_noise));
    let with = comparison.with_faults.as_ref();
    rows.extend(with.map(|with| row(format!("your model, with {}", faults(with)), with.times_noise)));
    rows
}

/// The circuit with what is marked.
pub(super) fn drawn(rig: &Rig, marks: &[Marked], what: &str) -> Section {
    let mut section = Section::new("Circuit");
    let caption = format!("The circuit, symbols after ISO 1219; {what}. Sensors stand beside what they measure.");
    section.drawing("circuit", &circuit::svg(rig, marks), &caption);
    section
}

/// The charts of one sensor, and those of the others on demand.
pub(super) fn curves(shown: &Shown<'_>, first: usize, models: &[Said<'_>], heading: &str) -> Section {
    let mut section = Section::new(heading);
    section.paragraph(CURVES);
    shown.chart(&mut section, first, models);
    let mut rest = Section::new("");
    for index in (0..shown.rig.sensors.len()).filter(|&index| index != first) {
        shown.chart(&mut rest, index, models);
    }
    if !rest.is_empty() {
        section.fold("The other sensors", false, rest);
    }
    section
}

/// The sensor that a model misses most.
pub(super) fn most_missed(shown: &Shown<'_>, outputs: &[Vec<f64>]) -> usize {
    let size = |misfit: &[f64]| misfit.iter().filter(|one| one.is_finite()).map(|one| one * one).sum::<f64>();
    let all = shown.misfits(outputs);
    (0..all.len()).max_by(|&a, &b| size(&all[a]).total_cmp(&size(&all[b]))).unwrap_or(0)
}

pub(super) const CURVES: &str = "Drag over a chart to zoom all of them; double click shows all again. Ctrl and wheel zoom too, and with \
    a chart chosen the arrow keys, + and -. Every other phase is shaded. Below the sensor its misfit: measured minus model, times the sensor \
    noise; dotted lines at 2.";

/// A value on the scale of what was known before (value, standard deviation): two standard deviations as a bar.
pub(super) fn prior_scale(value: f64, (nominal, sigma): (f64, f64), source: &str) -> Scale {
    Scale {
        from: nominal - REACH * sigma,
        to: nominal + REACH * sigma,
        marks: vec![
            Mark::Bar(Some(nominal - 2.0 * sigma), Some(nominal + 2.0 * sigma)),
            Mark::Stroke(nominal),
            Mark::Point(value),
        ],
        text: format!("{:.1} standard deviations from the {source}", (value - nominal) / sigma),
    }
}

/// What the rig file gives with an uncertainty, as it was fitted.
fn fitted_table(fitted: &[FittedParameter]) -> Table {
    let row = |one: &FittedParameter| -> Vec<Cell> {
        let pull = (one.value - one.nominal) / one.sigma_before;
        let scale = prior_scale(one.value, (one.nominal, one.sigma_before), "rig file");
        vec![
            one.id.clone().into(),
            worth(one.value, one.sigma_before).into(),
            plus_minus(one.nominal, one.sigma_before).into(),
            one.unit.clone().into(),
            format!("{pull:+.1} sigma").into(),
            Cell::Scale(scale),
        ]
    };
    Table::new(
        "Values that the rig file states with an uncertainty, +- one standard deviation. Bar: two standard deviations; point: fitted value",
        vec![
            Column::text("parameter"),
            Column::number("fitted", ""),
            Column::number("rig file", ""),
            Column::text("unit"),
            Column::number("pull", ""),
            Column::text("fitted against rig file"),
        ],
        fitted.iter().map(row).collect(),
    )
}
