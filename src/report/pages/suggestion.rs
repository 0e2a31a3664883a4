//! The page of `suggest`.

use super::bars::bars;
use super::channels::{FOUND, Said, Shown, YOURS, by_sensor};
use super::learn::{curves, drawn, most_missed, named};
use super::{misfit, missing, rivals};
use crate::complaint::Complaint;
use crate::finding::Consequence;
use crate::finding::lacking::Lacking;
use crate::learn::evaluated::Conclusion;
use crate::learn::result::{CandidateReport, EffectParameter, SuggestionReport, parameters};
use crate::learn::suggest::Suggestion;
use crate::number::{before_unit, rounded, text};
use crate::record::Record;
use crate::report::caveats::{learnt_with, left_open};
use crate::report::circuit::Marked;
use crate::report::html::{Card, Cell, Column, Mark, Page, Scale, Section, Table};
use crate::report::learn as words;
use crate::report::provenance::Provenance;
use crate::report::suggestion as brief;
use crate::report::unknown::Rise;
use crate::rig::Rig;

/// Parameters of an effect up to which the card has each.
const SIZES: usize = 6;

/// The page of a suggestion: what the model lacks, its picture, the fall of the error, the chart that shows it; the rest is
/// folded.
///
/// # Errors
/// Columns that are missing.
pub fn suggestion(
    rig: &Rig,
    (record, check): (&Record, Option<&Record>),
    found: &Suggestion,
    (report, finding): (&SuggestionReport, Option<&Lacking>),
) -> Result<String, Complaint> {
    let records = if check.is_some() { 2 } else { 1 };
    let mut lead = format!("Record {}", report.record);
    if let Some(check) = &report.check {
        lead.push_str(&format!(", judged on {check}"));
    }
    let mut page = Page::new(format!("What the model of {} lacks", named(rig)), lead);
    page.provenance(Provenance::of(rig, std::iter::once(record).chain(check)));
    let best = found.judged.first();
    let name = best.map(|best| format!("with {}", best.id()));
    // What does not explain the record is no place to look at.
    let supported = best.filter(|_| report.worth_naming().is_some());
    let more = supported.map(|best| (best.id(), &best.trial));
    let picture = match report.conclusion {
        Conclusion::Adequate => None,
        _ => missing::section(&found.base, record, more.as_ref().map(|(id, trial)| (id.as_str(), *trial)))?,
    };
    let rise = Rise::of_suggestion(found);
    page.section(headline(report, rise.as_ref()));
    // A curve says more as a picture than by its values.
    let (first, second) = match (fitted(report, finding, rise.as_ref()), picture) {
        (fitted, Some(picture)) if rise.is_some() => (picture, Some(fitted)),
        (fitted, picture) => (fitted, picture),
    };
    page.section(first);
    if let Some(second) = second {
        page.section(second);
    }
    if let Some(best) = supported {
        let with_sizes = best.effects.iter().map(|effect| (effect.id.as_str(), parameters(&best.trial, &effect.id)));
        let marks: Vec<Marked> =
            with_sizes.filter_map(|(id, sizes)| Marked::effect(&best.trial.rig, id, &sizes)).collect();
        page.section(drawn(&best.trial.rig, &marks, "what your model lacks is framed"));
    }
    let shown = Shown::new(rig, record, "time", records)?;
    let before = &found.base.fit.outputs;
    let after = name.as_deref().zip(best.map(|best| best.trial.fit.outputs.as_slice()));
    page.section(curves(&shown, most_missed(&shown, before), &said(before, after), "Measured against the model"));
    let mut place = Section::new("Where your model misses");
    if let Some(words) = words::missed(report) {
        place.paragraph(words);
    }
    if let Some(spools) = learnt_with(&report.dynamics) {
        place.paragraph(spools);
    }
    match after {
        None => misfit::add(&mut place, &shown, before, "your model"),
        Some((name, after)) => misfit::add_both(&mut place, &shown, (before, after), ("your model", name)),
    }
    page.section(place);
    if let (Some(check), Some(run)) = (check, &found.base_check) {
        let shown = Shown::new(rig, check, "check", records)?;
        let after = name.as_deref().zip(best.and_then(|best| best.check.as_ref()).map(|run| run.outputs.as_slice()));
        let mut section = Section::folded("The check record, to which nothing is fitted");
        shown.charts(&mut section, &said(&run.outputs, after));
        page.section(section);
    }
    if !report.candidates.is_empty() {
        page.section(ranking(report));
    }
    if let Some(section) = rivals::section(&shown, found) {
        page.section(section);
    }
    let mut rest = Section::folded("What the record could have shown");
    let rows = report.scored().into_iter().map(words::scored_row).collect();
    rest.table(Table::of(
        "All candidates, with the smallest size that this record could show",
        &words::SCORED_HEADS,
        rows,
    ));
    page.section(rest);
    let mut whitened = Section::folded("Whitened misfit of your model");
    shown.whitened(&mut whitened, &by_sensor(&found.base.fit.misfit, record));
    page.section(whitened);
    Ok(page.html())
}

/// The conclusion, and of a curve what it says.
fn headline(report: &SuggestionReport, rise: Option<&Rise>) -> Section {
    let mut verdict = Section::new("Verdict");
    verdict.notice(words::tone(report.conclusion), words::conclusion_in_short(report));
    if let Some(rise) = rise {
        verdict.paragraph(rise.sentence());
    }
    verdict
}

/// The effect as a card, the law of a curve, the fall of the error, the next step.
fn fitted(report: &SuggestionReport, finding: Option<&Lacking>, rise: Option<&Rise>) -> Section {
    let best = report.worth_naming();
    let mut fitted = Section::new(if best.is_some() { "What was found" } else { "What was tried" });
    if let Some((best, finding)) = best.zip(finding) {
        fitted.cards(vec![card(report, best, finding)]);
    }
    if let Some(rise) = rise {
        fitted.paragraph("As a law, put into the rig file, `suggest` judges it like any other effect:".to_owned());
        fitted.preformatted(rise.formula());
    }
    if let Some(experiment) = &report.experiment {
        fitted.paragraph(words::experiment(experiment));
    }
    if let Some(first) = report.candidates.first() {
        fitted.table(bars("Error over all sensors, times the sensor noise", &brief::rows(report, first, brief::SHOWN)));
    }
    if let Some(open) = left_open(&report.left_open) {
        fitted.paragraph(open);
    }
    if let Some(draft) = brief::of_the_file(report, rise) {
        fitted.paragraph(draft);
    }
    if best.is_none() {
        fitted.preformatted(format!("Next: {}", brief::next(report, rise)));
    }
    fitted
}

fn card(report: &SuggestionReport, best: &CandidateReport, finding: &Lacking) -> Card {
    let sized = |one: &EffectParameter| before_unit(words::estimate(one).value(), &one.unit);
    let interval = |one: &EffectParameter| match one.ci95 {
        [None, None] => String::new(),
        _ => format!("95 % interval {}", words::estimate(one).interval()),
    };
    let first = best.parameters.first().filter(|_| best.parameters.len() <= SIZES);
    let mut facts: Vec<(String, String)> = Vec::new();
    let others = best.parameters.iter().skip(1).filter(|_| best.parameters.len() <= SIZES);
    // Of one effect the name of the parameter is enough.
    let name = |one: &EffectParameter| match one.id.rsplit_once('.') {
        Some((effect, name)) if best.effect.contains(" + ") => format!("{effect} {}", name.replace('_', " ")),
        Some((_, name)) => name.replace('_', " "),
        None => one.id.clone(),
    };
    let joined = |parts: [String; 2]| parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ");
    facts.extend(others.map(|one| (name(one), joined([sized(one), interval(one)]))));
    let does = |one: &Consequence| (format!("with it, {}", one.sensor), one.text.clone());
    facts.extend(finding.consequences.iter().map(does));
    facts.extend(finding.next.check.iter().map(|check| ("check this".to_owned(), check.clone())));
    if !best.confounded_with.is_empty() {
        facts.push(("could also be".to_owned(), best.confounded_with.join(", ")));
    }
    facts.extend(best.warnings.iter().take(2).map(|one| ("caveat".to_owned(), one.to_string())));
    Card {
        tone: words::tone(report.conclusion),
        title: finding.meaning.clone(),
        id: best.effect.clone(),
        size: first.map_or_else(|| format!("a curve of {} values", best.parameters.len()), sized),
        about: first.map_or_else(String::new, |one| joined([name(one), interval(one)])),
        scale: None,
        facts,
        command: format!("Next: {}", finding.next.command),
    }
}

/// Your model, and the one with more where there is one.
pub(super) fn said<'a>(before: &'a [Vec<f64>], after: Option<(&'a str, &'a [Vec<f64>])>) -> Vec<Said<'a>> {
    let yours = Said { name: "your model", outputs: before, style: YOURS };
    std::iter::once(yours).chain(after.map(|(name, outputs)| Said { name, outputs, style: FOUND })).collect()
}

/// The candidates with their evidence, rivals and what speaks against them.
fn ranking(report: &SuggestionReport) -> Section {
    let mut section = Section::folded("Ranking of the candidates");
    let all = &report.candidates;
    let most_bic = all.iter().map(|one| one.delta_bic).fold(1.0, f64::max);
    let error = |one: &CandidateReport| one.check_rmse_after.unwrap_or(one.rmse_after);
    let before = all.iter().map(|one| one.check_rmse_before.unwrap_or(one.rmse_before)).fold(1.0, f64::max);
    let most = all.iter().map(error).fold(before, f64::max);
    let row = |one: &CandidateReport| -> Vec<Cell> {
        let bic = Scale {
            from: 0.0,
            to: most_bic,
            marks: vec![Mark::Length(one.delta_bic)],
            text: format!("fall of BIC {:.1}", one.delta_bic),
        };
        let errors = Scale {
            from: 0.0,
            to: most,
            marks: vec![
                Mark::Length(error(one)),
                Mark::Stroke(1.0),
                Mark::Point(one.check_rmse_before.unwrap_or(one.rmse_before)),
            ],
            text: format!("error {}, noise at 1", text(rounded(error(one), 3))),
        };
        let alike = if one.confounded_with.is_empty() { "-".to_owned() } else { one.confounded_with.join(", ") };
        vec![
            one.effect.clone().into(),
            if one.supported { "yes" } else { "no" }.into(),
            format!("{:.1}", one.delta_bic).into(),
            Cell::Scale(bic),
            words::before_after(Some(one.rmse_before), Some(one.rmse_after)).into(),
            words::before_after(one.check_rmse_before, one.check_rmse_after).into(),
            Cell::Scale(errors),
            alike.into(),
        ]
    };
    section.table(Table::new(
        "Fitted effects, the best first. Errors, times the sensor noise, without -> with the effect; in the last scale bar with, point \
         without the effect, tick at the noise",
        vec![
            Column::text("effect"),
            Column::text("supported"),
            Column::number("fall of BIC", ""),
            Column::text("evidence"),
            Column::number("misfit", ""),
            Column::number("on the check record", ""),
            Column::text(if report.check.is_some() { "check error" } else { "error" }),
            Column::text("confounded with"),
        ],
        all.iter().map(row).collect(),
    ));
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for one in all {
        for parameter in &one.parameters {
            let mut row: Vec<Cell> = vec![one.effect.clone().into()];
            row.extend(words::parameter_row(parameter).into_iter().map(Cell::from));
            row.push(match parameter.ci95 {
                [Some(low), Some(high)] => Cell::Scale(interval(parameter, (low, high))),
                _ => Cell::from(""),
            });
            rows.push(row);
        }
    }
    let columns = vec![
        Column::text("effect"),
        Column::text("parameter"),
        Column::number("estimate", ""),
        Column::number("95 % interval", ""),
        Column::text("unit"),
        Column::text("interval from zero"),
    ];
    section.table(Table::new("Fitted sizes", columns, rows));
    let warned: Vec<String> =
        all.iter().flat_map(|one| one.warnings.iter().map(|warning| format!("{}: {warning}", one.effect))).collect();
    if !warned.is_empty() {
        section.subheading("Caveats");
        section.list(warned);
    }
    section
}

/// An interval on a scale that begins, or ends, at zero.
fn interval(one: &EffectParameter, (low, high): (f64, f64)) -> Scale {
    let (from, to) = (low.min(0.0), high.max(0.0));
    let rim = 0.1 * (to - from);
    Scale {
        from: from - rim,
        to: to + rim,
        marks: vec![Mark::Bar(Some(low), Some(high)), Mark::Stroke(0.0), Mark::Point(one.value)],
        text: before_unit(words::estimate(one).interval(), &one.unit),
    }
}
