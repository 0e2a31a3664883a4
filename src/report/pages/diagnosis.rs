//! The page of a diagnosis.

use std::path::Path;

use super::channels::{FOUND, Said, Shown, YOURS};
use super::learn::{CURVES, named, prior_scale};
use super::{misfit, profile, residuals};
use crate::complaint::Complaint;
use crate::diagnosis::{Diagnosed, Diagnosis, FaultReport, Hypothesis, UncertainReport, Verdict};
use crate::finding::Finding;
use crate::number::{in_unit, with_unit};
use crate::record::Record;
use crate::report::caveats::{TOLD, caveats, detected, left_out};
use crate::report::circuit::{self, Marked};
use crate::report::diagnosis_tables as words;
use crate::report::findings::{self, Left};
use crate::report::headline::{headline, left_by, sizes, tone};
use crate::report::html::{Card, Cell, Column, Mark, Page, Scale, Section, Table};
use crate::report::provenance::Provenance;
use crate::report::residuals as balances;
use crate::report::style::Tone;
use crate::residual::Detection;
use crate::rig::Rig;

/// The diagnosis as a page: what was found as cards, the circuit, the one chart that shows it; the rest is folded.
///
/// # Errors
/// Columns that are missing.
pub fn html(
    rig: &Rig,
    record: &Record,
    diagnosed: &Diagnosed,
    (findings, store): (&[Finding], Option<&Path>),
) -> Result<String, Complaint> {
    let diagnosis = &diagnosed.diagnosis;
    let fitted = diagnosed.rig(rig);
    let mut page = Page::new(format!("Diagnosis of {}", named(rig)), format!("Record {}", diagnosis.record));
    page.provenance(Provenance::of(rig, [record]));
    let next = findings::next(diagnosis, findings, Left { page: true, store });
    page.section(verdict(rig, diagnosis, findings, next));
    let present: Vec<&FaultReport> = diagnosis.present().collect();
    let mut drawn = Section::new("Circuit");
    let (framed, what): (&[&FaultReport], &str) = match diagnosis.verdict {
        Verdict::ModelInadequate if diagnosis.missing_effect.is_some() => {
            (&present, "with the effect that the model lacks; what is faulty beside it is framed")
        }
        Verdict::ModelInadequate => (&[], "nothing is framed, since no faults explain the record"),
        Verdict::Healthy => (&present, "nothing is faulty"),
        Verdict::Faulty => (&present, "what is faulty is framed"),
    };
    let caption = format!(
        "The circuit as the rig file has it, symbols after ISO 1219; {what}. Sensors stand beside what they measure."
    );
    drawn.drawing("circuit", &circuit::svg(fitted, &Marked::faults(framed)), &caption);
    page.section(drawn);
    let mut shown = Shown::new(rig, record, "time", 1)?;
    shown.detected_at_s = diagnosis.detected_at_s;
    let fitted_name = match (diagnosis.verdict, &diagnosis.missing_effect) {
        (Verdict::Healthy, _) => "fitted model",
        (_, Some(_)) => "with what was found",
        (_, None) => "with the faults",
    };
    let models = [
        Said { name: "healthy model", outputs: &diagnosed.healthy, style: YOURS },
        Said { name: fitted_name, outputs: &diagnosed.model, style: FOUND },
    ];
    let proof = proof(&shown, diagnosed, findings);
    let mut section = Section::new("Measured against the model");
    section.paragraph(CURVES);
    section.paragraph(proof.1);
    shown.chart(&mut section, proof.0, &models);
    let mut rest = Section::new("");
    for index in (0..rig.sensors.len()).filter(|&index| index != proof.0) {
        shown.chart(&mut rest, index, &models);
    }
    section.fold("The other sensors", false, rest);
    page.section(section);
    let mut where_it_misses = Section::folded("Misfit that is left");
    misfit::add(&mut where_it_misses, &shown, &diagnosed.model, fitted_name);
    page.section(where_it_misses);
    let mut faults = Section::folded("All faults");
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
    let mut why = Section::folded("Fault combinations");
    why.table(hypothesis_table(diagnosis));
    if !diagnosis.ambiguity.is_empty() {
        let groups = diagnosis.ambiguity.iter().map(|group| format!("one of {}", group.join(", ")));
        why.subheading("Ambiguity groups");
        why.list(groups.collect());
    }
    let alike: Vec<String> = diagnosis.alike.iter().filter_map(|group| findings::alike(group)).collect();
    if !alike.is_empty() {
        why.subheading("Values that do the same");
        why.list(alike);
    }
    page.section(why);
    if !diagnosis.residuals.is_empty() {
        page.section(residual_section(&shown, diagnosis)?);
    }
    page.section(fit(&shown, diagnosed));
    page.sections(profile::section(fitted, diagnosed));
    Ok(page.html())
}

/// The verdict, a card for each finding, and what one has to know with them.
fn verdict(rig: &Rig, diagnosis: &Diagnosis, findings: &[Finding], next: Option<String>) -> Section {
    let mut verdict = Section::new("Verdict");
    verdict.notice(tone(diagnosis.verdict), headline(diagnosis));
    let mut cards: Vec<Card> = Vec::new();
    if let Some(missing) = &diagnosis.missing_effect {
        let effects = missing.effects.join(" + ");
        cards.push(Card {
            tone: Tone::Caution,
            title: "An effect that the model lacks".to_owned(),
            id: effects,
            size: String::new(),
            about: sizes(missing).unwrap_or_default(),
            scale: None,
            facts: vec![("what it explains".to_owned(), left_by(missing, diagnosis))],
            command: String::new(),
        });
    }
    if diagnosis.verdict == Verdict::Faulty || diagnosis.missing_effect.is_some() {
        cards.extend(findings.iter().zip(diagnosis.present()).map(|(finding, fault)| card(rig, finding, fault)));
    }
    if !cards.is_empty() {
        verdict.cards(cards);
    }
    let told: Vec<String> = detected(diagnosis).into_iter().chain([findings::left(diagnosis)]).collect();
    verdict.paragraph(told.join(" "));
    for caveat in caveats(diagnosis) {
        verdict.paragraph(caveat);
    }
    let left_out = left_out(&diagnosis.left_out, TOLD);
    if !left_out.is_empty() {
        verdict.subheading("Left out of the fit");
        verdict.list(left_out);
    }
    if let Some(next) = next {
        verdict.preformatted(format!("Next: {next}"));
    }
    verdict
}

/// A finding as a card.
fn card(rig: &Rig, finding: &Finding, fault: &FaultReport) -> Card {
    let mut part = finding.part.clone();
    if let Some(first) = part.get(..1).map(str::to_uppercase) {
        part.replace_range(..1, &first);
    }
    let mut facts: Vec<(String, String)> = Vec::new();
    if !finding.consequences.is_empty() {
        let texts: Vec<&str> = finding.consequences.iter().map(|one| one.text.as_str()).collect();
        facts.push(("consequence".to_owned(), texts.join("; ")));
    }
    let rivals = finding.rivals.iter().take(2).map(|rival| match (&rival.effect, rival.probability) {
        (Some(effect), _) => format!("the effect {}", findings::in_place(effect)),
        (None, None) => format!("{}, which this record cannot isolate from it", findings::faults_of(rival)),
        (None, Some(probability)) => format!("{}, {}", findings::faults_of(rival), words::percent(probability)),
    });
    let rivals: Vec<String> = rivals.collect();
    if !rivals.is_empty() {
        facts.push(("could also be".to_owned(), rivals.join("; ")));
    }
    facts.extend(finding.next.check.clone().map(|check| ("check".to_owned(), check)));
    // The command of a finding without rivals wrote this page.
    let command = if finding.next.command.contains("--report") { String::new() } else { finding.next.command.clone() };
    Card {
        tone: Tone::Alert,
        title: format!("{part}: {} {} than new", finding.deviation, finding.direction),
        id: finding.id.clone(),
        size: words::sized(fault),
        about: format!(
            "new {}; 95 % interval {}; probability {}",
            words::healthy(fault),
            words::interval(fault),
            words::percent(fault.probability)
        ),
        scale: scale_of(rig, fault),
        facts,
        command,
    }
}

/// The sensor whose chart shows best what was found, with why it was chosen.
fn proof(shown: &Shown<'_>, diagnosed: &Diagnosed, found: &[Finding]) -> (usize, String) {
    let of_name = |name: &str| shown.rig.sensors.iter().position(|sensor| sensor.name == name);
    let first = found.first().and_then(|first| first.consequences.first().map(|consequence| (first, consequence)));
    if let Some((finding, consequence)) = first
        && let Some(index) = of_name(&consequence.sensor)
    {
        let why = format!("{} shows {} most clearly: {}.", consequence.sensor, finding.id, consequence.text);
        return (index, why);
    }
    let size = |misfit: &[f64]| misfit.iter().filter(|one| one.is_finite()).map(|one| one * one).sum::<f64>();
    let healthy = shown.misfits(&diagnosed.healthy);
    let index = (0..healthy.len()).max_by(|&a, &b| size(&healthy[a]).total_cmp(&size(&healthy[b]))).unwrap_or(0);
    let name = shown.rig.sensors.get(index).map_or("", |sensor| sensor.name.as_str());
    (index, format!("{name} is the sensor that the healthy model misses most."))
}

/// What each balance says, over time and summed up.
fn residual_section(shown: &Shown<'_>, diagnosis: &Diagnosis) -> Result<Section, Complaint> {
    let alarms = diagnosis.residuals.iter().filter(|residual| residual.fired).count();
    let mut section = Section::folded(match alarms {
        0 => "Residuals: no alarm".to_owned(),
        1 => "Residuals: 1 alarm".to_owned(),
        several => format!("Residuals: {several} alarms"),
    });
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

/// What the verdict rests on: reduced chi-square, nuisance parameters, whitened misfits.
fn fit(shown: &Shown<'_>, diagnosed: &Diagnosed) -> Section {
    let diagnosis = &diagnosed.diagnosis;
    let mut section = Section::folded("The fit in figures");
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
    let mut whitened = Section::new("");
    shown.whitened(&mut whitened, &misfit);
    section.fold("Whitened misfit of each sensor", false, whitened);
    section
}

/// A fault on the range that was searched for it.
fn scale_of(rig: &Rig, fault: &FaultReport) -> Option<Scale> {
    let searched = rig.faults.iter().find(|one| rig.parameters[one.parameter].id == fault.id)?;
    let unit = &rig.parameters[searched.parameter].unit;
    let (from, to) = (unit.from_si(searched.bounds.0), unit.from_si(searched.bounds.1));
    let limit = searched.limit.map(|limit| in_unit(limit, unit));
    Some(Scale {
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
}

/// The faults, each with its interval on the range that was searched.
fn fault_table(rig: &Rig, diagnosis: &Diagnosis) -> Table {
    let scales =
        diagnosis.faults.iter().map(|fault| scale_of(rig, fault).map_or(Cell::from(""), Cell::Scale)).collect();
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
