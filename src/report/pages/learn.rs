//! Pages of `compare` and `suggest`.

use super::channels::{Said, Shown, by_sensor};
use super::{misfit, missing, rivals};
use crate::complaint::Complaint;
use crate::learn::compare::Compared;
use crate::learn::comparison::FittedParameter;
use crate::learn::evaluated::Conclusion;
use crate::learn::fitted_model::Run;
use crate::learn::result::{CandidateReport, EffectParameter, SuggestionReport};
use crate::learn::suggest::Suggestion;
use crate::number::{before_unit, rounded, text};
use crate::record::Record;
use crate::report::digits::{plus_minus, worth};
use crate::report::html::{Cell, Column, Mark, Page, Scale, Section, Table};
use crate::report::learn as words;
use crate::report::plot::{Axis, Chart, Live, Rule, Series};
use crate::rig::Rig;

/// Colour and dash of the model as given, and of the model with what was added.
const GIVEN: (usize, usize) = (2, 1);
const ADDED: (usize, usize) = (1, 0);
/// Standard deviations to each side of a nominal value that its scale shows.
const REACH: f64 = 4.0;

pub(super) fn named(rig: &Rig) -> String {
    named_or(&rig.name, &rig.path.display().to_string())
}

/// The name of a rig, or its file where it has none.
pub(super) fn named_or(name: &str, file: &str) -> String {
    if name.is_empty() { file.to_owned() } else { name.to_owned() }
}

/// The page of a comparison.
///
/// # Errors
/// Columns that are missing.
pub fn comparison(rig: &Rig, record: &Record, compared: &Compared) -> Result<String, Complaint> {
    let comparison = &compared.comparison;
    let shown = Shown::new(rig, record, "time", 1)?;
    let misfit = by_sensor(&compared.run.misfit, record);
    let mut page = Page::new(format!("Comparison of {}", named(rig)), format!("Record {}", comparison.record));
    let mut verdict = Section::new("Verdict");
    verdict.notice(words::comparison_tone(comparison), words::comparison_headline(comparison));
    verdict.table(words::channel_table(comparison));
    page.section(verdict);
    let mut place = Section::new("Where it misses");
    misfit::add(&mut place, &shown, &misfit);
    let worst = words::worst_rows(comparison);
    if !worst.is_empty() {
        place.table(Table::of("Largest misfits, by sensor", &words::WORST_HEADS, worst));
    }
    page.section(place);
    if !comparison.fitted.is_empty() {
        let mut fitted = Section::new("Nuisance parameters");
        fitted.table(fitted_table(&comparison.fitted));
        page.section(fitted);
    }
    let mut fit = Section::new("Measured and model");
    fit.paragraph(CURVES);
    let healthy = Said { name: "healthy model", outputs: &compared.run.outputs, misfit, style: ADDED };
    shown.charts(&mut fit, &[healthy]);
    page.section(fit);
    Ok(page.html())
}

pub(super) const CURVES: &str = "Drag over a chart to zoom all of them; double click shows all again. Ctrl and wheel zoom too, and with \
    a chart chosen the arrow keys, + and -. Every other phase is shaded. Below each sensor what was measured minus what the model says, in standard deviations \
    of what noise and tolerance allow; dotted lines at 2.";

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

/// The page of a suggestion.
///
/// # Errors
/// Columns that are missing.
pub fn suggestion(
    rig: &Rig,
    (record, check): (&Record, Option<&Record>),
    found: &Suggestion,
    report: &SuggestionReport,
) -> Result<String, Complaint> {
    let records = if check.is_some() { 2 } else { 1 };
    let mut lead = format!("Record {}", report.record);
    if let Some(check) = &report.check {
        lead.push_str(&format!(", judged on {check}"));
    }
    let mut page = Page::new(format!("What the model of {} lacks", named(rig)), lead);
    let mut verdict = Section::new("Verdict");
    verdict.notice(words::tone(report.conclusion), words::conclusion(report));
    if let Some(place) = &report.place {
        verdict.paragraph(words::sits(place));
    }
    if let Some(experiment) = &report.experiment {
        verdict.paragraph(words::experiment(experiment));
    }
    page.section(verdict);
    let shown = Shown::new(rig, record, "time", records)?;
    let mut place = Section::new("Where your model misses");
    place.paragraph("Your model, with all uncertain values and all faults fitted.");
    misfit::add(&mut place, &shown, &by_sensor(&found.base.fit.misfit, record));
    page.section(place);
    let best = found.judged.first();
    let name = best.map(|best| format!("with {}", best.id()));
    let more = name.as_deref().zip(best.map(|best| &best.trial.fit));
    if report.conclusion != Conclusion::Adequate
        && let Some(section) = missing::section(&found.base, record, more)?
    {
        page.section(section);
    }
    if !report.candidates.is_empty() {
        page.section(ranking(report));
    }
    if let Some(section) = rivals::section(&shown, found) {
        page.section(section);
    }
    let before_after = |shown: &Shown<'_>, section: &mut Section, before: &Run, after: Option<(&str, &Run)>| {
        let mut said = vec![run_said("your model", before, shown.record, GIVEN)];
        said.extend(after.map(|(name, run)| run_said(name, run, shown.record, ADDED)));
        shown.charts(section, &said);
    };
    let mut fit = Section::new("Measured and model, before and after");
    fit.paragraph(CURVES);
    before_after(&shown, &mut fit, &found.base.fit, name.as_deref().zip(best.map(|best| &best.trial.fit)));
    page.section(fit);
    if let (Some(check), Some(before)) = (check, &found.base_check) {
        let shown = Shown::new(rig, check, "check", records)?;
        let mut section = Section::new("The check record, to which nothing is fitted");
        before_after(&shown, &mut section, before, name.as_deref().zip(best.and_then(|best| best.check.as_ref())));
        page.section(section);
    }
    let mut rest = Section::new("What the record could have shown");
    let rows = report.scored().into_iter().map(words::scored_row).collect();
    rest.table(Table::of(
        "All candidates, with the smallest size that this record could show",
        &words::SCORED_HEADS,
        rows,
    ));
    page.section(rest);
    Ok(page.html())
}

pub(super) fn run_said<'a>(name: &'a str, run: &'a Run, record: &Record, style: (usize, usize)) -> Said<'a> {
    Said { name, outputs: &run.outputs, misfit: by_sensor(&run.misfit, record), style }
}

/// The candidates with their evidence, rivals and what speaks against them.
fn ranking(report: &SuggestionReport) -> Section {
    let mut section = Section::new("Ranking of the candidates");
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
            text: format!("delta BIC {:.1}", one.delta_bic),
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
            Column::number("delta BIC", ""),
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

/// Errors of model after model as a staircase, down to the noise.
pub(super) fn staircase(errors: &[(f64, f64)]) -> (Chart, Live) {
    let steps = |error: &dyn Fn(&(f64, f64)) -> f64| -> Vec<(f64, f64)> {
        let each = errors.iter().enumerate();
        each.flat_map(|(at, errors)| [(at as f64 - 0.5, error(errors)), (at as f64 + 0.5, error(errors))]).collect()
    };
    let mut x = Axis::new("model", "");
    x.names = (0..errors.len()).map(|number| number.to_string()).collect();
    let mut y = Axis::new("times the sensor noise", "");
    y.logarithmic = true;
    let series = vec![
        Series::line("fit record", steps(&|errors| errors.0)).styled(0, 0),
        Series::line("check record", steps(&|errors| errors.1)).styled(1, 1),
    ];
    let mut chart = Chart::new("Staircase of errors", x, y, series).high(220.0);
    chart.rules.push(Rule::Horizontal { y: 1.0, label: "noise of the sensors".to_owned() });
    (chart, Live::new("", "error on both records after each addition, down to the noise of the sensors"))
}
