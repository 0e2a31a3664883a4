//! The diagnosis for people: a page of text to hand on, and a page with pictures.

use std::fmt::Write;

use super::html::{Column, Page, Section, Table, Tone};
use super::number::{rounded, text, with_unit};
use super::plot::{Axis, Chart, Figure, Series};
use crate::diagnosis::{Diagnosed, Diagnosis, FaultReport, Verdict};
use crate::record::Record;
use crate::rig::Rig;

/// The verdict in one line.
pub fn headline(diagnosis: &Diagnosis) -> String {
    let present: Vec<String> = diagnosis
        .present()
        .map(|fault| format!("{} {}", fault.id, with_unit(rounded(fault.value, 4), &fault.unit)))
        .collect();
    match diagnosis.verdict {
        Verdict::Healthy => "HEALTHY: the healthy model explains the record.".to_owned(),
        Verdict::Faulty => format!("FAULTY: {}.", present.join(", ")),
        Verdict::ModelInadequate => {
            let worst = diagnosis.channels.iter().max_by(|a, b| a.chi2_reduced.total_cmp(&b.chi2_reduced));
            let worst = worst.map_or(String::new(), |worst| format!(", {} worst", worst.name));
            format!(
                "MODEL INADEQUATE: no faults of this rig explain the record{worst}; physics is missing or a sensor is wrong. \
                 Fault values below may be off by more than their intervals."
            )
        }
    }
}

/// An interval in words.
fn interval(fault: &FaultReport) -> String {
    match fault.ci95 {
        [Some(low), Some(high)] => format!("{} to {}", text(rounded(low, 4)), text(rounded(high, 4))),
        [Some(low), None] => format!("above {}", text(rounded(low, 4))),
        [None, Some(high)] => format!("below {}", text(rounded(high, 4))),
        [None, None] => "open".to_owned(),
    }
}

fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 99.9 => "> 99.9 %".to_owned(),
        p if p < 0.1 => "< 0.1 %".to_owned(),
        p => format!("{p:.1} %"),
    }
}

fn fault_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    diagnosis
        .faults
        .iter()
        .map(|fault| {
            vec![
                fault.id.clone(),
                text(rounded(fault.value, 4)),
                interval(fault),
                text(fault.healthy),
                fault.unit.clone(),
                if fault.present { "yes" } else { "no" }.to_owned(),
                percent(fault.probability),
            ]
        })
        .collect()
}

const FAULT_HEADS: [&str; 7] = ["fault", "estimate", "95 % interval", "healthy", "unit", "present", "probability"];

fn hypothesis_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let named = |faults: &[String]| if faults.is_empty() { "healthy".to_owned() } else { faults.join(" + ") };
    diagnosis.hypotheses.iter().take(5).map(|h| vec![named(&h.faults), percent(h.probability)]).collect()
}

const RESIDUAL_HEADS: [&str; 7] = ["residual", "equation", "mean", "sigma", "unit", "fired", "since"];

fn residual_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| text(rounded(value, 3)));
    diagnosis
        .residuals
        .iter()
        .map(|residual| {
            vec![
                residual.id.clone(),
                residual.equation.to_owned(),
                number(residual.mean),
                number(residual.sigma),
                residual.unit.clone(),
                if residual.fired { "yes" } else { "no" }.to_owned(),
                residual.onset_s.map_or("-".to_owned(), |onset| format!("{onset:.2} s")),
            ]
        })
        .collect()
}

const CHANNEL_HEADS: [&str; 5] = ["sensor", "rms misfit", "noise", "unit", "chi-square per sample"];

fn channel_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let row = |channel: &crate::diagnosis::ChannelReport| {
        let mark = if channel.adequate { "" } else { "  NOT EXPLAINED" };
        vec![
            channel.name.clone(),
            text(rounded(channel.rmse, 3)),
            text(rounded(channel.noise_sigma, 3)),
            channel.unit.clone(),
            format!("{:.2}{mark}", channel.chi2_reduced),
        ]
    };
    diagnosis.channels.iter().map(row).collect()
}

/// What could not be determined, and why.
fn undetermined(diagnosis: &Diagnosis) -> Vec<String> {
    let open = |fault: &FaultReport| {
        let remark = fault.remark.as_ref()?;
        Some(format!("{} ({}): {remark}", fault.id, fault.identifiable))
    };
    diagnosis.faults.iter().filter_map(open).collect()
}

/// The diagnosis as a page of text.
pub fn write_text(diagnosis: &Diagnosis) -> String {
    let mut page = String::new();
    // Writing to a String cannot fail.
    let mut line = |text: &str| {
        let _ = writeln!(page, "{text}");
    };
    line(&headline(diagnosis));
    line("");
    line(&format!("rig     {}", diagnosis.rig));
    line(&format!("record  {}", diagnosis.record));
    if let Some(at) = diagnosis.detected_at_s {
        line(&format!("detected at {at:.2} s"));
    }
    let mut block = |title: &str, heads: &[&str], rows: &[Vec<String>]| {
        line("");
        line(title);
        for row in aligned(heads, rows) {
            line(&row);
        }
    };
    block("Faults", &FAULT_HEADS, &fault_rows(diagnosis));
    block("Which faults together", &["faults", "probability"], &hypothesis_rows(diagnosis));
    block("Residuals with healthy parameters", &RESIDUAL_HEADS, &residual_rows(diagnosis));
    block("Fit of each sensor (1 is right within noise and tolerance)", &CHANNEL_HEADS, &channel_rows(diagnosis));
    let open = undetermined(diagnosis);
    if !open.is_empty() {
        line("");
        line("What could not be determined");
        for remark in open {
            line(&format!("  {remark}"));
        }
    }
    line("");
    line(&format!(
        "fit: chi-square per sample {:.3}, {} iterations, {} simulations of the record, ended by {}",
        diagnosis.fit.chi2_reduced, diagnosis.fit.iterations, diagnosis.fit.solves, diagnosis.fit.stopped_because
    ));
    page
}

/// Rows under their heads, each column as wide as its widest entry.
fn aligned(heads: &[&str], rows: &[Vec<String>]) -> Vec<String> {
    let head: Vec<String> = heads.iter().map(|head| (*head).to_owned()).collect();
    let all: Vec<&Vec<String>> = std::iter::once(&head).chain(rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..heads.len()).map(width).collect();
    let print = |row: &&Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:<width$}"));
        format!("  {}", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    all.iter().map(print).collect()
}

/// The diagnosis as a page with pictures: measured against model, and the misfit over time.
pub fn html(rig: &Rig, record: &Record, diagnosed: &Diagnosed) -> String {
    let diagnosis = &diagnosed.diagnosis;
    let name = if rig.name.is_empty() { diagnosis.rig.clone() } else { rig.name.clone() };
    let mut page = Page::new(format!("Diagnosis of {name}"), format!("Record {}", diagnosis.record));
    let mut verdict = Section::new("Verdict");
    let tone = match diagnosis.verdict {
        Verdict::Healthy => Tone::Good,
        Verdict::Faulty => Tone::Alert,
        Verdict::ModelInadequate => Tone::Caution,
    };
    verdict.notice(tone, headline(diagnosis));
    if let Some(at) = diagnosis.detected_at_s {
        verdict.paragraph(format!("Detected at {at:.2} s."));
    }
    verdict.table(table("Faults", &FAULT_HEADS, fault_rows(diagnosis)));
    let open = undetermined(diagnosis);
    if !open.is_empty() {
        verdict.paragraph("What could not be determined:");
        verdict.list(open);
    }
    page.section(verdict);
    let mut why = Section::new("Which faults together");
    why.table(table("Sets of faults", &["faults", "probability"], hypothesis_rows(diagnosis)));
    why.table(table("Residuals with healthy parameters", &RESIDUAL_HEADS, residual_rows(diagnosis)));
    page.section(why);
    let mut fit = Section::new("Measured and model");
    fit.table(table("Fit of each sensor", &CHANNEL_HEADS, channel_rows(diagnosis)));
    for figure in figures(rig, record, diagnosed) {
        fit.figure(&figure, "Measured, fitted model and healthy model; below, the misfit in standard deviations");
    }
    page.section(fit);
    page.html()
}

fn table(caption: &str, heads: &[&str], rows: Vec<Vec<String>>) -> Table {
    Table { caption: caption.to_owned(), columns: heads.iter().map(|head| Column::text(*head)).collect(), rows }
}

/// One picture per sensor: measured, fitted and healthy model, and the misfit below.
pub fn figures(rig: &Rig, record: &Record, diagnosed: &Diagnosed) -> Vec<Figure> {
    let points =
        |values: &[f64]| -> Vec<(f64, f64)> { record.time.iter().copied().zip(values.iter().copied()).collect() };
    rig.sensors
        .iter()
        .enumerate()
        .filter_map(|(index, sensor)| {
            let unit = rig.sensor_unit(sensor);
            let shown = |values: &[f64]| values.iter().map(|si| unit.from_si(*si)).collect::<Vec<f64>>();
            let measured = shown(&record.channel(&sensor.column)?.values);
            let model = shown(diagnosed.model.get(index)?);
            let mut series =
                vec![Series::line("measured", points(&measured)), Series::line("fitted model", points(&model))];
            if let Some(healthy) = diagnosed.healthy.get(index) {
                series.push(Series::line("healthy model", points(&shown(healthy))));
            }
            let time = || Axis::new("time", "s");
            let above = Chart::new(&sensor.name, time(), Axis::new(&sensor.name, &unit.symbol), series);
            let misfit = points(diagnosed.misfit.get(index)?);
            let below = Chart::new(
                "misfit",
                time(),
                Axis::new("misfit", "sigma"),
                vec![Series::line("model less measured", misfit)],
            );
            Some(Figure::new(
                &sensor.name,
                format!("{}: measured and model over time", sensor.name),
                vec![above, below],
            ))
        })
        .collect()
}
