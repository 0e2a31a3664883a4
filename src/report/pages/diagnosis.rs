//! The page of a diagnosis.

use super::channels::{Said, Shown};
use super::learn::{CURVES, named, prior_scale};
use super::{misfit, profile, residuals};
use crate::complaint::Complaint;
use crate::diagnosis::{Diagnosed, Diagnosis, FaultReport, Hypothesis, UncertainReport, Verdict};
use crate::number::{in_unit, with_unit};
use crate::record::Record;
use crate::report::caveats::{TOLD, caveats, detected, left_out};
use crate::report::circuit;
use crate::report::diagnosis as words;
use crate::report::html::{Cell, Column, Mark, Page, Scale, Section, Table};
use crate::report::residuals as balances;
use crate::residual::Detection;
use crate::rig::Rig;

/// The diagnosis as a page: verdict, faults, why, residuals, measured against model, profiles.
///
/// # Errors
/// Columns that are missing.
pub fn html(rig: &Rig, record: &Record, diagnosed: &Diagnosed) -> Result<String, Complaint> {
    let diagnosis = &diagnosed.diagnosis;
    let fitted = diagnosed.rig(rig);
    let mut page = Page::new(format!("Diagnosis of {}", named(rig)), format!("Record {}", diagnosis.record));
    let mut verdict = Section::new("Verdict");
    verdict.notice(words::tone(diagnosis.verdict), words::headline(diagnosis));
    if let Some(missing) = &diagnosis.missing_effect {
        verdict.paragraph(words::sizes(missing));
    }
    for caveat in caveats(diagnosis) {
        verdict.paragraph(caveat);
    }
    if let Some(detected) = detected(diagnosis) {
        verdict.paragraph(detected);
    }
    if let Some(at) = diagnosis.onset_s {
        verdict.paragraph(format!("Began at {at:.2} s."));
    }
    let left_out = left_out(&diagnosis.left_out, TOLD);
    if !left_out.is_empty() {
        verdict.subheading("Left out of the fit");
        verdict.list(left_out);
    }
    page.section(verdict);
    let present: Vec<&FaultReport> = diagnosis.present().collect();
    let mut drawn = Section::new("Circuit");
    let (framed, what): (&[&FaultReport], &str) = match diagnosis.verdict {
        Verdict::ModelInadequate if diagnosis.missing_effect.is_some() => {
            (&present, "with the effect that the model lacks; what is faulty beside it is framed")
        }
        Verdict::ModelInadequate => (&[], "nothing is framed, since no faults explain the record"),
        Verdict::Healthy | Verdict::Faulty => (&present, "what is faulty is framed"),
    };
    let caption = format!(
        "The circuit as the rig file has it, symbols after ISO 1219; {what}. Sensors stand beside what they measure."
    );
    drawn.drawing("circuit", &circuit::svg(fitted, framed), &caption);
    page.section(drawn);
    let mut faults = Section::new("Faults");
    faults.table(fault_table(rig, diagnosis));
    for (heading, remarks) in
        [(words::UNBLAMED, words::unblamed(diagnosis)), (words::OPEN_INTERVALS, words::open_intervals(diagnosis))]
    {
        if !remarks.is_empty() {
            faults.subheading(heading);
            faults.list(remarks);
        }
    }
    page.section(faults);
    let mut why = Section::new("Fault combinations");
    why.table(hypothesis_table(diagnosis));
    if !diagnosis.ambiguity.is_empty() {
        let groups = diagnosis.ambiguity.iter().map(|group| format!("one of {}", group.join(", ")));
        why.subheading("Ambiguity groups");
        why.list(groups.collect());
    }
    page.section(why);
    let mut shown = Shown::new(rig, record, "time", 1)?;
    shown.detected_at_s = diagnosis.detected_at_s;
    if !diagnosis.residuals.is_empty() {
        page.section(residual_section(&shown, diagnosis)?);
    }
    page.section(fit(&shown, diagnosed));
    page.sections(profile::section(fitted, diagnosed));
    Ok(page.html())
}

/// What each balance says, over time and summed up.
fn residual_section(shown: &Shown<'_>, diagnosis: &Diagnosis) -> Result<Section, Complaint> {
    let mut section = Section::new("Residuals");
    section.paragraph(
        "Each balance of the circuit with healthy parameters: zero but for noise while nothing is wrong with it.",
    );
    section.table(Table::of("Residuals with healthy parameters", &balances::HEADS, balances::rows(diagnosis)));
    section.list(balances::words());
    section.paragraph(
        "Each residual as the mean of windows, with what noise and tolerance allow; an alarm is raised where the running sum of what \
         goes beyond passes its threshold. Each position of the valve has sums of its own. Every other phase is shaded.",
    );
    residuals::add(&mut section, shown, &diagnosis.residuals, &Detection::default())?;
    Ok(section)
}

/// Measured against model, and what was estimated along.
fn fit(shown: &Shown<'_>, diagnosed: &Diagnosed) -> Section {
    let diagnosis = &diagnosed.diagnosis;
    let mut section = Section::new("Measured and model");
    section.table(Table::of(
        "Misfit of each sensor; reduced chi-square 1 is noise and tolerance",
        &words::CHANNEL_HEADS,
        words::channel_rows(diagnosis),
    ));
    if !diagnosis.uncertain.is_empty() {
        let scales = diagnosis.uncertain.iter().map(uncertain_scale).collect();
        let caption = "Nuisance parameters: values that the rig file states with an uncertainty, +- one standard deviation before and with the \
                       record. Bar: two standard deviations before it; point: with it";
        let table = Table::of(caption, &words::UNCERTAIN_HEADS, words::uncertain_rows(diagnosis));
        section.table(table.with(4, Column::text("against the rig file"), scales));
    }
    let misfit: Vec<&[f64]> = diagnosed.misfit.iter().map(Vec::as_slice).collect();
    misfit::add(&mut section, shown, &misfit);
    section.paragraph(CURVES);
    let healthy = Said { name: "healthy model", outputs: &diagnosed.healthy, misfit: Vec::new(), style: (2, 1) };
    let fitted = Said { name: "fitted model", outputs: &diagnosed.model, misfit, style: (1, 0) };
    shown.charts(&mut section, &[healthy, fitted]);
    section
}

/// The faults, each with its interval on the range that was searched.
fn fault_table(rig: &Rig, diagnosis: &Diagnosis) -> Table {
    let scale = |fault: &FaultReport| {
        let searched = rig.faults.iter().find(|one| rig.parameters[one.parameter].id == fault.id);
        let Some(searched) = searched else { return Cell::from("") };
        let unit = &rig.parameters[searched.parameter].unit;
        let (from, to) = (unit.from_si(searched.bounds.0), unit.from_si(searched.bounds.1));
        let limit = searched.limit.map(|limit| in_unit(limit, unit));
        Cell::Scale(Scale {
            from,
            to,
            marks: std::iter::once(Mark::Bar(fault.ci95[0], fault.ci95[1]))
                .chain(limit.map(Mark::Limit))
                .chain([Mark::Stroke(fault.healthy), Mark::Point(fault.value)])
                .collect(),
            text: format!(
                "{} within {} to {}, healthy {}{}",
                words::interval(fault),
                with_unit(from, &fault.unit),
                with_unit(to, &fault.unit),
                with_unit(fault.healthy, &fault.unit),
                limit.map_or(String::new(), |limit| format!(", limit {}", with_unit(limit, &fault.unit)))
            ),
        })
    };
    let scales = diagnosis.faults.iter().map(scale).collect();
    let limits = if rig.faults.iter().any(|fault| fault.limit.is_some()) {
        ", dashed tick the limit of the rig file"
    } else {
        ""
    };
    let caption = format!(
        "Every fault of the rig. On each scale, from end to end of what was searched: bar the 95 % interval (dashed where it is open), \
         point the estimate, tick the healthy value{limits}"
    );
    Table::of(&caption, &words::FAULT_HEADS, words::fault_rows(diagnosis)).with(
        2,
        Column::text("interval within bounds"),
        scales,
    )
}

fn hypothesis_table(diagnosis: &Diagnosis) -> Table {
    let scale = |one: &Hypothesis| {
        Cell::Scale(Scale {
            from: 0.0,
            to: 1.0,
            marks: vec![Mark::Length(one.probability)],
            text: format!("probability {}", words::percent(one.probability)),
        })
    };
    let rows = words::hypothesis_rows(diagnosis);
    let scales = diagnosis.hypotheses.iter().take(rows.len()).map(scale).collect();
    Table::of("Fault combinations", &words::HYPOTHESIS_HEADS, rows).with(1, Column::text("0 to 100 %"), scales)
}

fn uncertain_scale(one: &UncertainReport) -> Cell {
    Cell::Scale(prior_scale(one.value, (one.nominal, one.sigma_before), "rig file"))
}
