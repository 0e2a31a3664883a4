//! The page of `improve`.

use super::bars::bars;
use super::channels::Shown;
use super::learn::{curves, drawn, most_missed, named};
use super::suggestion::said;
use super::{misfit, missing};
use crate::complaint::Complaint;
use crate::learn::improve::Improvement;
use crate::learn::warning::joined;
use crate::number::{rounded, text};
use crate::record::Record;
use crate::report::brief::ErrorRow;
use crate::report::circuit::Marked;
use crate::report::html::{Cell, Column, Page, Section, Table};
use crate::report::improvement::left;
use crate::report::learn::{PARAMETER_HEADS, experiment, parameter_row};
use crate::report::ledger::{EffectReport, Ledger, Row};
use crate::report::provenance::Provenance;
use crate::rig::Rig;

/// Rows of parameters up to which they stand under the verdict.
const SIZES: usize = 8;

/// The page of an improvement: what was added, the fall of the error, its picture, the check record before and after; the rest
/// is folded. `new` is the rig file that was written.
///
/// # Errors
/// Columns that are missing.
pub fn improvement(
    rig: &Rig,
    (fit, check): (&Record, &Record),
    found: &Improvement,
    (ledger, new): (&Ledger, &str),
) -> Result<String, Complaint> {
    let lead = format!("Fitted to {}, judged on {}", ledger.fit_record, ledger.check_record);
    let mut page = Page::new(format!("Improvement of {}", named(rig)), lead);
    page.provenance(Provenance::of(rig, [fit, check]));
    page.section(verdict(ledger, new));
    let ids: Vec<String> = ledger.effects.iter().map(|effect| effect.id.clone()).collect();
    let joined = ids.join(" + ");
    let more = (!ids.is_empty()).then_some((joined.as_str(), &found.trial));
    if let Some(section) = missing::section(&found.given, fit, more)? {
        page.section(section);
    }
    if !ledger.effects.is_empty() {
        let mark = |effect: &EffectReport| Marked::effect(&found.trial.rig, &effect.id, &effect.parameters);
        let marks: Vec<Marked> = ledger.effects.iter().filter_map(mark).collect();
        page.section(drawn(&found.trial.rig, &marks, "what was added is framed"));
    }
    if let (Some(first), Some(last)) = (found.steps.first(), found.steps.last()) {
        let name = if ids.len() == 1 { format!("with {joined}") } else { "with the added effects".to_owned() };
        for (record, group, heading, runs) in [
            (check, "check", "The check record, to which nothing is fitted", (&first.check, &last.check)),
            (fit, "time", "The fit record", (&first.fit, &last.fit)),
        ] {
            let (before, after) = (runs.0.outputs.as_slice(), runs.1.outputs.as_slice());
            let shown = Shown::new(rig, record, group, 2)?;
            let after = (found.steps.len() > 1).then_some((name.as_str(), after));
            let models = said(before, after);
            let mut section = match group {
                "check" => curves(&shown, most_missed(&shown, before), &models, heading),
                _ => {
                    let mut section = Section::folded(heading);
                    shown.charts(&mut section, &models);
                    section
                }
            };
            match after {
                None => misfit::add(&mut section, &shown, before, "your model"),
                Some((name, after)) => misfit::add_both(&mut section, &shown, (before, after), ("your model", name)),
            }
            page.section(section);
        }
    }
    page.section(steps(ledger));
    Ok(page.html())
}

/// What was added, with the fall of the error and what is left.
fn verdict(ledger: &Ledger, new: &str) -> Section {
    let mut verdict = Section::new("Verdict");
    verdict.notice(crate::report::learn::tone(ledger.conclusion), ledger.headline());
    if let Some(spools) = crate::report::caveats::learnt_with(&ledger.dynamics) {
        verdict.paragraph(spools);
    }
    let row = |row: &Row| ErrorRow { name: ledger.name(row), fit: row.fit_rmse, check: Some(row.check_rmse) };
    let rows: Vec<ErrorRow> = ledger.steps.iter().map(row).collect();
    verdict.table(bars("Error over all sensors, times the sensor noise", &rows));
    if !ledger.effects.is_empty() {
        let rows = ledger.effects.iter().flat_map(|effect| effect.parameters.iter().map(parameter_row));
        let table = Table::of("What was added, as fitted", &PARAMETER_HEADS, rows.collect());
        if table.rows.len() > SIZES {
            let mut sizes = Section::new("");
            sizes.table(table);
            verdict.fold("The values of what was added", false, sizes);
        } else {
            verdict.table(table);
        }
        for caveat in ledger.caveats() {
            verdict.paragraph(caveat);
        }
        verdict.paragraph(ledger.not_written());
    }
    if let Some(declined) = &ledger.declined {
        verdict.paragraph(declined.sentence());
    }
    if let Some(rise) = &ledger.rise {
        verdict.paragraph(format!(
            "{} As a law, put into the rig file, `suggest` judges it like any other effect:",
            rise.sentence()
        ));
        verdict.preformatted(rise.formula());
    }
    if let Some(apart) = &ledger.experiment {
        verdict.paragraph(experiment(apart));
    }
    if let Some(rest) = &ledger.remaining {
        verdict.paragraph(left(rest));
    }
    verdict.preformatted(format!("Next: {}", ledger.next(new)));
    verdict
}

/// The ledger: table, errors of each channel, warnings, what was refused.
fn steps(ledger: &Ledger) -> Section {
    let mut section = Section::folded("Improvement per effect, in figures");
    let number = |value: f64| Cell::from(text(rounded(value, 4)));
    let row = |(index, step): (usize, &Row)| -> Vec<Cell> {
        vec![
            index.to_string().into(),
            ledger.name(step).into(),
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
