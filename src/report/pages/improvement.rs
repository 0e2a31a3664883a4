//! The page of `improve`.

use super::channels::Shown;
use super::learn::{CURVES, named, run_said, staircase};
use super::{misfit, missing};
use crate::complaint::Complaint;
use crate::learn::improve::Improvement;
use crate::learn::warning::joined;
use crate::number::{rounded, text};
use crate::record::Record;
use crate::report::html::{Cell, Column, Page, Section, Table};
use crate::report::improvement::{Ledger, Row, left};
use crate::report::learn::{PARAMETER_HEADS, experiment, parameter_row};
use crate::rig::Rig;

/// The page of an improvement: what each addition bought, and where what is left sits.
///
/// # Errors
/// Columns that are missing.
pub fn improvement(
    rig: &Rig,
    (fit, check): (&Record, &Record),
    found: &Improvement,
    ledger: &Ledger,
) -> Result<String, Complaint> {
    let lead = format!("Learnt on {}, judged on {}", ledger.fit_record, ledger.check_record);
    let mut page = Page::new(format!("Improvement of {}", named(rig)), lead);
    let mut verdict = Section::new("Verdict");
    verdict.notice(crate::report::learn::tone(ledger.conclusion), ledger.headline());
    let added: Vec<String> = ledger.steps.iter().filter_map(|step| step.added.clone()).collect();
    if !added.is_empty() {
        verdict.paragraph(format!("Added: {}. {}", added.join(", then "), ledger.not_written()));
        let rows = ledger.effects.iter().flat_map(|effect| effect.parameters.iter().map(parameter_row));
        verdict.table(Table::of("As fitted", &PARAMETER_HEADS, rows.collect()));
    }
    if let Some(apart) = &ledger.experiment {
        verdict.paragraph(experiment(apart));
    }
    if let Some(rest) = &ledger.remaining {
        verdict.paragraph(left(rest));
    }
    page.section(verdict);
    page.section(steps(ledger));
    let more = (found.steps.len() > 1).then_some(("at the end", &found.trial.fit));
    if let Some(section) = missing::section(&found.given, fit, more)? {
        page.section(section);
    }
    if let (Some(first), Some(last)) = (found.steps.first(), found.steps.last()) {
        for (record, group, name, check) in
            [(check, "check", "The check record", true), (fit, "time", "The fit record", false)]
        {
            let run = |step: &'_ crate::learn::improve::ImprovementStep| {
                if check { step.check.clone() } else { step.fit.clone() }
            };
            let (before, after) = (run(first), run(last));
            let shown = Shown::new(rig, record, group, 2)?;
            let mut section = Section::new(name);
            section.paragraph(if check {
                "Nothing is fitted to this record. The map is that of the last model; the charts show the first and the last."
            } else {
                CURVES
            });
            let last_model = run_said("last model", &after, record, (1, 0));
            misfit::add(&mut section, &shown, &last_model.misfit);
            let said = if found.steps.len() > 1 {
                vec![run_said("your model", &before, record, (2, 1)), last_model]
            } else {
                vec![last_model]
            };
            shown.charts(&mut section, &said);
            page.section(section);
        }
    }
    Ok(page.html())
}

/// The ledger: staircase, table, errors of each channel, warnings, what was refused.
fn steps(ledger: &Ledger) -> Section {
    let mut section = Section::new("Improvement per effect");
    let errors: Vec<(f64, f64)> = ledger.steps.iter().map(|step| (step.fit_rmse, step.check_rmse)).collect();
    let (chart, live) = staircase(&errors);
    section.chart(&chart, &live);
    let number = |value: f64| Cell::from(text(rounded(value, 4)));
    let row = |(index, step): (usize, &Row)| -> Vec<Cell> {
        vec![
            index.to_string().into(),
            step.name().into(),
            number(step.fit_rmse),
            number(step.check_rmse),
            number(step.chi2_reduced),
            number(step.check_chi2_reduced),
        ]
    };
    section.table(Table::new(
        "Error over all sensors, times the sensor noise; reduced chi-square 1 is noise and tolerance",
        vec![
            Column::text("model"),
            Column::text("added"),
            Column::number("fit", ""),
            Column::number("check", ""),
            Column::number("reduced chi-square, fit", ""),
            Column::number("reduced chi-square, check", ""),
        ],
        ledger.steps.iter().enumerate().map(row).collect(),
    ));
    let mut columns = vec![Column::text("sensor"), Column::text("unit")];
    columns.extend(ledger.steps.iter().map(|step| Column::number(step.name(), "")));
    let channels = ledger.steps.first().into_iter().flat_map(|first| &first.channels);
    let rows = channels.map(|(name, channel)| {
        let errors = ledger
            .steps
            .iter()
            .map(|step| step.channels.get(name).map_or(Cell::from("-"), |one| number(one.check_rmse)));
        [Cell::from(name.clone()), Cell::from(channel.unit.clone())].into_iter().chain(errors).collect()
    });
    section.table(Table::new("Error of each sensor on the check record, model by model", columns, rows.collect()));
    let notes: Vec<String> = ledger
        .steps
        .iter()
        .flat_map(|step| {
            let warnings = step.warnings.iter().map(|warning| format!("{}: {warning}", step.name()));
            let refused = step.refused.iter().map(|refused| {
                format!(
                    "refused, {}: check error {}, but {}",
                    refused.effect,
                    text(rounded(refused.check_rmse, 4)),
                    joined(&refused.warnings)
                )
            });
            warnings.chain(refused).collect::<Vec<_>>()
        })
        .collect();
    if !notes.is_empty() {
        section.subheading("Warnings, and what was refused");
        section.list(notes);
    }
    section
}
