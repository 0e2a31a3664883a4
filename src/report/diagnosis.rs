//! The diagnosis for people: a page of text to hand on, and a page with pictures.

use std::fmt::Write;

use super::html::{Column, Page, Section, Table, Tone};
use super::number::{rounded, text, with_unit};
use super::plot::{Axis, Band, Chart, Envelope, Figure, Rule, Series};
use super::table::{Head, aligned};
use crate::diagnosis::{Diagnosed, Diagnosis, FaultReport, Verdict};
use crate::model::Drive;
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

const FAULT_HEADS: [Head; 7] = [
    ("fault", false),
    ("estimate", true),
    ("95 % interval", true),
    ("healthy", true),
    ("unit", false),
    ("present", false),
    ("probability", true),
];

const HYPOTHESIS_HEADS: [Head; 2] = [("faults", false), ("probability", true)];

fn hypothesis_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let named = |faults: &[String]| if faults.is_empty() { "healthy".to_owned() } else { faults.join(" + ") };
    diagnosis.hypotheses.iter().take(5).map(|h| vec![named(&h.faults), percent(h.probability)]).collect()
}

const RESIDUAL_HEADS: [Head; 7] = [
    ("residual", false),
    ("equation", false),
    ("mean", true),
    ("sigma", true),
    ("unit", false),
    ("fired", false),
    ("since", true),
];

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

const CHANNEL_HEADS: [Head; 6] = [
    ("sensor", false),
    ("rms misfit", true),
    ("noise", true),
    ("unit", false),
    ("chi-square per sample", true),
    ("explained", false),
];

fn channel_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let row = |channel: &crate::diagnosis::ChannelReport| {
        vec![
            channel.name.clone(),
            text(rounded(channel.rmse, 3)),
            text(rounded(channel.noise_sigma, 3)),
            channel.unit.clone(),
            format!("{:.2}", channel.chi2_reduced),
            if channel.adequate { "yes" } else { "NO" }.to_owned(),
        ]
    };
    diagnosis.channels.iter().map(row).collect()
}

/// With this many decimals; what rounds to zero has no sign.
fn plain(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.chars().all(|c| matches!(c, '-' | '0' | '.')) { text.trim_start_matches('-').to_owned() } else { text }
}

const UNCERTAIN_HEADS: [Head; 5] =
    [("parameter", false), ("estimate", true), ("data sheet", true), ("unit", false), ("pull", true)];

/// Parameters that were estimated along; the pull is how far the record draws one from its data sheet.
fn uncertain_rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    // Both with as many decimals as two digits of the uncertainty ask for.
    let with = |value: f64, sigma: Option<f64>| match sigma {
        Some(sigma) if sigma > 0.0 => {
            let decimals = (1.0 - sigma.log10().floor()).clamp(0.0, 9.0) as usize;
            format!("{} +- {sigma:.decimals$}", plain(value, decimals))
        }
        _ => text(rounded(value, 4)),
    };
    let row = |parameter: &crate::diagnosis::UncertainReport| {
        let pull = (parameter.value - parameter.nominal) / parameter.sigma_before;
        vec![
            parameter.id.clone(),
            with(parameter.value, parameter.sigma_after),
            with(parameter.nominal, Some(parameter.sigma_before)),
            parameter.unit.clone(),
            format!("{} sigma", plain(pull, 1)),
        ]
    };
    diagnosis.uncertain.iter().map(row).collect()
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
    let mut block = |title: &str, heads: &[Head], rows: &[Vec<String>]| {
        line("");
        line(title);
        for row in aligned(heads, rows) {
            line(&row);
        }
    };
    block("Faults", &FAULT_HEADS, &fault_rows(diagnosis));
    block("Which faults together", &HYPOTHESIS_HEADS, &hypothesis_rows(diagnosis));
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
        "fit: chi-square per sample {:.3}, {}, {} simulations of the record, ended by {}",
        diagnosis.fit.chi2_reduced,
        match diagnosis.fit.iterations {
            1 => "1 iteration".to_owned(),
            several => format!("{several} iterations"),
        },
        diagnosis.fit.solves,
        diagnosis.fit.stopped_because
    ));
    page
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
    why.table(table("Sets of faults", &HYPOTHESIS_HEADS, hypothesis_rows(diagnosis)));
    page.section(why);
    let mut residuals = Section::new("Residuals");
    residuals.paragraph(
        "Each balance of the circuit with healthy parameters: zero but for noise while nothing is wrong with it.",
    );
    residuals.table(table("Residuals with healthy parameters", &RESIDUAL_HEADS, residual_rows(diagnosis)));
    page.section(residuals);
    let mut fit = Section::new("Measured and model");
    fit.table(table(
        "Fit of each sensor; 1 is right within noise and tolerance",
        &CHANNEL_HEADS,
        channel_rows(diagnosis),
    ));
    if !diagnosis.uncertain.is_empty() {
        let caption = "Estimated along: what the rig file gives with an uncertainty";
        fit.table(table(caption, &UNCERTAIN_HEADS, uncertain_rows(diagnosis)));
    }
    fit.paragraph(
        "The pictures show each sensor over the whole record, then around the first switching; phases between switchings are shaded in turn. Under them the misfit in standard deviations of what \
         noise and tolerance allow: the range of all samples, and the mean of each stretch, which stays near zero if the model is right.",
    );
    for figure in figures(rig, record, diagnosed) {
        fit.figure(&figure, figure.description.clone());
    }
    page.section(fit);
    page.html()
}

fn table(caption: &str, heads: &[Head], rows: Vec<Vec<String>>) -> Table {
    let column = |&(name, numeric): &Head| if numeric { Column::number(name, "") } else { Column::text(name) };
    Table { caption: caption.to_owned(), columns: heads.iter().map(column).collect(), rows }
}

/// Stretches of the record over which the misfit is drawn.
const STRETCHES: usize = 250;
/// What is drawn before and behind the first switching, s.
const BEFORE: f64 = 0.1;
const BEHIND: f64 = 0.5;

/// One picture per sensor: measured, fitted and healthy model over the record and around the first switching, and the
/// misfit.
pub fn figures(rig: &Rig, record: &Record, diagnosed: &Diagnosed) -> Vec<Figure> {
    let (Some(&first), Some(&end)) = (record.time.first(), record.time.last()) else { return Vec::new() };
    // The first row tells of the interval before it.
    let start = first - record.sampling().map_or(0.0, |sampling| sampling.interval);
    let jumps: Vec<f64> = Drive::from_record(rig, record)
        .map(|drive| drive.pieces.iter().filter(|piece| piece.jump).map(|piece| piece.start).collect())
        .unwrap_or_default();
    let bands = shaded(first, &jumps, end);
    let switching = jumps.iter().find(|&&jump| jump > first);
    let time = |from: f64, to: f64| Axis::new("time", "s").over(from, to);
    rig.sensors
        .iter()
        .enumerate()
        .filter_map(|(index, sensor)| {
            let unit = rig.sensor_unit(sensor);
            let measured = &record.channel(&sensor.column)?.values;
            let model = diagnosed.model.get(index)?;
            let healthy = diagnosed.healthy.get(index);
            let series = |from: f64, to: f64| {
                let points = |values: &[f64]| -> Vec<(f64, f64)> {
                    let shown = values.iter().map(|si| unit.from_si(*si));
                    record.time.iter().copied().zip(shown).filter(|(time, _)| (from..=to).contains(time)).collect()
                };
                let mut series = vec![Series::line("measured", points(measured)).styled(5, 0)];
                series.extend(healthy.map(|healthy| Series::line("healthy model", points(healthy)).styled(2, 2)));
                series.push(Series::line("fitted model", points(model)).styled(1, 1));
                series
            };
            let value = || Axis::new(&sensor.name, &unit.symbol);
            let mut whole = Chart::new(&sensor.name, time(start, end), value(), series(start, end)).high(230.0);
            whole.bands.clone_from(&bands);
            if let Some(at) = diagnosed.diagnosis.detected_at_s {
                whole.rules.push(Rule::Vertical { x: at, label: "detected".to_owned() });
            }
            let mut panels = vec![whole];
            if let Some(at) = switching {
                let (from, to) = ((at - BEFORE).max(start), (at + BEHIND).min(end));
                panels.push(
                    Chart::new("Around the first switching", time(from, to), value(), series(from, to)).high(210.0),
                );
            }
            panels.push(misfit(&record.time, diagnosed.misfit.get(index)?, &bands, time(start, end)));
            let mut figure =
                Figure::new(&sensor.name, format!("{}: measured, model and misfit over time", sensor.name), panels);
            figure.width = 940.0;
            Some(figure)
        })
        .collect()
}

/// Every other phase between jumps of the inputs.
fn shaded(first: f64, jumps: &[f64], end: f64) -> Vec<Band> {
    let mut ends: Vec<f64> = jumps.iter().copied().filter(|&jump| jump > first).collect();
    ends.push(end);
    let band = |pair: &[f64]| match pair {
        [from, to] => Some(Band { from: *from, to: *to, label: String::new() }),
        _ => None,
    };
    ends.chunks(2).filter_map(band).collect()
}

/// Range and mean of the misfit over stretches of the record.
fn misfit(times: &[f64], misfit: &[f64], bands: &[Band], time: Axis) -> Chart {
    let rows = misfit.len().div_ceil(STRETCHES).max(1);
    let stretches = || times.chunks(rows).zip(misfit.chunks(rows));
    let middle = |times: &[f64]| times[times.len() / 2];
    let range = stretches().map(|(times, misfit)| {
        let (low, high) =
            misfit.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &m| (low.min(m), high.max(m)));
        (middle(times), low, high)
    });
    let mean = stretches().map(|(times, misfit)| (middle(times), misfit.iter().sum::<f64>() / misfit.len() as f64));
    let line = Series::line("mean", mean.collect()).styled(0, 0);
    let mut chart = Chart::new("Misfit", time, Axis::new("misfit", "sigma"), vec![line]).high(190.0);
    chart.envelopes.push(Envelope { name: "range".to_owned(), points: range.collect(), colour: 0 });
    chart.bands = bands.to_vec();
    chart
}
