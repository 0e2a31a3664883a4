//! Isolability as text and tables: what can be told apart, which residual answers to which fault at an operating point, and how well
//! each fault could be sized.

use std::fmt::Write;

use super::brief::{WIDTH, wrapped};
use crate::isolability::{Expectation, ExpectedWidth, IsolabilityReport, SignatureRow};
use crate::number::{self, in_unit, rounded};
use crate::report::html::{Cell, Column, Table};
use crate::residual::generators;
use crate::rig::{Fault, Rig};
use crate::simulation;

/// Deviations from which on a field of the page is darkest.
const DARKEST: f64 = 300.0;

/// Faults that the short text gives the size of.
const SIZED: usize = 6;

/// What can be detected, what cannot be told apart and by what it can, and how well each fault of a component could be sized.
pub fn brief(rig: &Rig, report: &IsolabilityReport) -> String {
    let structure = &report.structure;
    let lost = structure.faults.iter().zip(&structure.detectable).filter(|(_, detectable)| !**detectable);
    let lost: Vec<&str> = lost.map(|(fault, _)| fault.as_str()).collect();
    let of = structure.faults.len();
    let mut lines = wrapped(
        &match lost.as_slice() {
            [] => format!("All {of} faults can be detected."),
            lost => format!("{} of {of} faults can be detected; not: {}.", of - lost.len(), lost.join(", ")),
        },
        "  ",
    );
    lines.extend(apart(rig, report).iter().flat_map(|words| wrapped(words, "  ")));
    if let Some(sensors) = structure.sensors.first().filter(|sensors| !sensors.is_empty()) {
        let others = match structure.sensors.len() - 1 {
            0 => String::new(),
            others => format!(", or any of {others} others (`--all`)"),
        };
        lines.extend(wrapped(&format!("A further sensor would help: {}{others}.", sensors.join(" and ")), "  "));
    }
    match &report.expected {
        None => lines.extend(wrapped(signature_text(rig, None).trim(), "  ")),
        Some(numbers) => {
            lines.push(format!("\n95 % interval to expect, with {}:", taken(numbers)));
            let ids: Vec<&str> =
                of_components(rig).iter().map(|fault| rig.parameters[fault.parameter].id.as_str()).collect();
            let (sized, beyond): (Vec<_>, Vec<_>) =
                numbers.widths.iter().partition(|one| ids.contains(&one.id.as_str()));
            let shown = if sized.is_empty() { &beyond } else { &sized };
            lines.extend(widths(shown.iter().take(SIZED).copied()));
            let more = numbers.widths.len() - shown.len().min(SIZED);
            if more > 0 {
                lines.push(format!("  and {more} more (`--all`)"));
            }
            let mistaken =
                format!("Noise makes {} more probable in {} % of records.", rival(numbers), mistaken(numbers));
            lines.extend(wrapped(&mistaken, "  "));
        }
    }
    lines.join("\n") + "\n"
}

/// What the sensors do not tell apart at one instant, and whether a whole record does.
fn apart(rig: &Rig, report: &IsolabilityReport) -> Vec<String> {
    let groups = &report.structure.ambiguity_groups;
    let of_sensor = |group: &&Vec<String>| {
        rig.sensors.iter().any(|sensor| group.iter().all(|id| id.starts_with(&format!("sensor.{}.", sensor.name))))
    };
    let (sensors, parts): (Vec<_>, Vec<_>) = groups.iter().partition(of_sensor);
    let mut named: Vec<String> = parts.iter().map(|group| group.join(" or ")).collect();
    match sensors.as_slice() {
        [] => {}
        [one] => named.push(one.join(" or ")),
        many => named.push(format!("offset or gain of {} sensors", many.len())),
    }
    if named.is_empty() {
        return Vec::new();
    }
    let apart = named.join("; ");
    let mut said = if generators(rig).is_empty() {
        format!("These sensors allow no residual. What one instant would not tell apart: {apart}")
    } else {
        format!("At one instant no residual tells apart: {apart}")
    };
    if let Some(numbers) = &report.expected {
        said += &match numbers.of - numbers.rank {
            0 => ". A fit of the whole record does".to_owned(),
            lost => format!(
                ". A fit of the whole record leaves {lost} combination{} of faults open",
                if lost == 1 { "" } else { "s" }
            ),
        };
    }
    vec![format!("{said}.")]
}

/// The matrix for a page: each fault of a component in deviations of noise and tolerance, as dark as it is plain.
pub(super) fn signature_table(rig: &Rig, rows: &[SignatureRow]) -> Table {
    let faults = of_components(rig);
    let id = |fault: &&Fault| rig.parameters[fault.parameter].id.clone();
    let row = |row: &SignatureRow| -> Vec<Cell> {
        let cell = |fault: &&Fault| {
            let answer = row.faults.iter().find(|answer| answer.id == id(fault));
            answer.map_or(Cell::Shade(String::new(), 0.0), |answer| {
                let share = (answer.deviations.abs().max(1.0).ln() / DARKEST.ln()).min(1.0);
                Cell::Shade(number::text(rounded(answer.deviations, 2)), share)
            })
        };
        let name = Cell::from(format!("{} {}, {}", row.residual, row.equation, row.phase));
        std::iter::once(name).chain(faults.iter().map(cell)).collect()
    };
    let columns = faults.iter().map(|fault| Column::text(id(fault)));
    let mut table = Table::new(
        "How far each residual moves when a fault goes to the far end of its range, in standard deviations of noise and tolerance",
        std::iter::once(Column::text("residual, phase")).chain(columns).collect(),
        rows.iter().map(row).collect(),
    );
    table.upright = true;
    table
}

/// The faults that are not of sensors: those would be most of the columns; programs find them.
fn of_components(rig: &Rig) -> Vec<&Fault> {
    let of_sensor =
        |fault: &&Fault| rig.sensors.iter().any(|sensor| fault.parameter.wrapping_sub(sensor.first_parameter) < 2);
    rig.faults.iter().filter(|fault| !of_sensor(fault)).collect()
}

/// The matrix as plain text, lines ended by line feeds: a row for each residual and phase, a column for each fault of a
/// component.
pub fn signature_text(rig: &Rig, rows: Option<&[SignatureRow]>) -> String {
    let Some(rows) = rows else {
        let needs = "\nNo signatures: they need an operating point";
        return match simulation::drive(rig, None) {
            Err(complaint) if rig.cycle.is_some() => {
                format!(
                    "{needs}, which the `[cycle]` does not give: {}. State it, or give `--input RECORD`.\n",
                    complaint.what
                )
            }
            _ => format!("{needs}, a `[cycle]` in the rig file or `--input RECORD`.\n"),
        };
    };
    if generators(rig).is_empty() {
        return "\nNo signatures: these sensors allow no residual. One needs the flow through a part, measured or known from its \
                neighbours, and the pressures at its ports.\n"
            .to_owned();
    }
    if rows.is_empty() {
        return "\nNo signatures: no residual of these sensors has windows that count.\n".to_owned();
    }
    let mut text = String::new();
    // Writing to a `String` cannot fail.
    let _ = write(&mut text, rig, rows);
    text
}

fn write(text: &mut String, rig: &Rig, rows: &[SignatureRow]) -> std::fmt::Result {
    writeln!(text, "\nSignatures: change of each residual when a fault goes to the far end of its range.")?;
    let faults = of_components(rig);
    for (index, fault) in faults.iter().enumerate() {
        let parameter = &rig.parameters[fault.parameter];
        let far = |end: f64| (end - fault.healthy).abs();
        let end = if far(fault.bounds.1) >= far(fault.bounds.0) { fault.bounds.1 } else { fault.bounds.0 };
        let [healthy, end] =
            [fault.healthy, end].map(|si| number::with_unit(in_unit(si, &parameter.unit), &parameter.unit.symbol));
        writeln!(text, "{:>4} {} from {healthy} to {end}", index + 1, parameter.id)?;
    }
    let width = rows.iter().map(|row| row.residual.len()).max().unwrap_or(0);
    let places: Vec<usize> = (0..faults.len()).collect();
    // Beside residual, equation and phase; noise, tolerance and unit take a first table where all do not fit.
    let room = WIDTH.saturating_sub(width + 24);
    let (whole, each) = (NOISE + CELL * faults.len() <= room, (room / CELL).max(1));
    let blocks: Vec<(bool, &[usize])> = match whole {
        true => vec![(true, places.as_slice())],
        false => std::iter::once((true, &places[..0])).chain(places.chunks(each).map(|some| (false, some))).collect(),
    };
    for (noise, some) in blocks {
        if !noise {
            writeln!(text)?;
        }
        let numbers: String = some.iter().map(|place| format!("{:>CELL$}", place + 1)).collect();
        let heads = if noise { format!("  {:>8}  {:>9}", "noise", "tolerance") } else { String::new() };
        let unit = if noise { "  unit" } else { "" };
        writeln!(text, "  {:width$}  {:8}  {:6}{heads}{numbers}{unit}", "", "equation", "phase")?;
        for row in rows {
            let cell = |fault: &&Fault| {
                let id = &rig.parameters[fault.parameter].id;
                let answer = row.faults.iter().find(|answer| answer.id == *id);
                match answer.map(|answer| answer.response) {
                    None => format!("{:>CELL$}", "."),
                    // `+0.000` would look like a response.
                    Some(response) if response.abs() < 5e-4 => format!("{:>CELL$}", "0"),
                    Some(response) => format!("{response:>+CELL$.3}"),
                }
            };
            let cells: String = some.iter().map(|&place| cell(&faults[place])).collect();
            let SignatureRow { residual, equation, phase, unit, sigma_of_mean, tolerance, .. } = row;
            let numbers = if noise { format!("  {sigma_of_mean:>8.4}  {tolerance:>9.4}") } else { String::new() };
            let unit = if noise { format!("  {unit}") } else { String::new() };
            writeln!(text, "  {residual:width$}  {equation:8}  {phase:6}{numbers}{cells}{unit}")?;
        }
    }
    writeln!(
        text,
        "noise: one standard deviation of the mean over the phase; tolerance: of what\naveraging does not lower. Offsets and gains of \
         sensors: with `--format json`."
    )?;
    blind(rig, rows).map_or(Ok(()), |words| writeln!(text, "{words}"))
}

/// Columns of a number of a fault, and of noise and tolerance with the unit.
const CELL: usize = 10;
const NOISE: usize = 29;

/// What it means where no residual answers to any fault of a component.
pub(super) fn blind(rig: &Rig, rows: &[SignatureRow]) -> Option<String> {
    let faults = of_components(rig);
    let answers = |row: &SignatureRow| {
        row.faults.iter().any(|answer| faults.iter().any(|fault| rig.parameters[fault.parameter].id == answer.id))
    };
    (!faults.is_empty() && !rows.iter().any(answers)).then(|| {
        "No residual answers to any fault of a component: alarms of `diagnose --window` cannot show them, only a fit can.".to_owned()
    })
}

/// Per cent, for people.
fn mistaken(numbers: &Expectation) -> String {
    let percent = 100.0 * numbers.mistaken;
    if percent < 0.01 { "less than 0.01".to_owned() } else { number::text(rounded(percent, 3)) }
}

/// The faults that are taken as present, with their sizes.
fn taken(numbers: &Expectation) -> String {
    let with: Vec<String> =
        numbers.with.iter().map(|one| format!("{} {}", one.id, number::with_unit(one.value, &one.unit))).collect();
    if with.is_empty() { "the healthy rig".to_owned() } else { with.join(" + ") }
}

/// The fault combination that is most easily mistaken for the one that is present.
fn rival(numbers: &Expectation) -> String {
    if numbers.rival.is_empty() { "healthy".to_owned() } else { numbers.rival.join(" + ") }
}

/// What would be known, in sentences.
pub(super) fn expected_sentences(numbers: &Expectation) -> Vec<String> {
    let mut said =
        vec![format!("With {}.", taken(numbers)), format!("Rank {} of {} faults.", numbers.rank, numbers.of)];
    let lost = numbers.with.iter().filter(|one| !one.identifiable);
    said.extend(lost.map(|one| format!("{}: not identifiable at this size.", one.id)));
    said.push(format!("Most easily mistaken for {}: by noise, in {} % of records.", rival(numbers), mistaken(numbers)));
    said
}

/// Expected widths of the intervals, for a page.
pub(super) fn width_table(numbers: &Expectation) -> Table {
    let row = |width: &ExpectedWidth| {
        let half = width.half_width.map_or("unknown".to_owned(), |half| format!("+- {}", number::text(half)));
        vec![width.id.clone().into(), half.into(), width.unit.clone().into()]
    };
    Table::new(
        "Half the 95 % interval that a record there would leave each fault, the present ones unknown too",
        vec![Column::text("fault"), Column::number("half width", ""), Column::text("unit")],
        numbers.widths.iter().map(row).collect(),
    )
}

/// The numbers as plain text.
pub fn expected_text(numbers: &Expectation) -> String {
    let mut lines = vec![
        String::new(),
        format!("Expected at the operating point, with {}", taken(numbers)),
        format!("  rank {} of {} faults", numbers.rank, numbers.of),
    ];
    let lost = numbers.with.iter().filter(|one| !one.identifiable);
    lines.extend(lost.map(|one| format!("  {}: not identifiable at this size", one.id)));
    lines.push(format!("  noise makes {} more probable in {} % of records", rival(numbers), mistaken(numbers)));
    lines.push(
        "  half width of the 95 % interval to expect for each fault, with the present faults also estimated".to_owned(),
    );
    lines.extend(widths(numbers.widths.iter()));
    lines.join("\n") + "\n"
}

/// A line for the interval of each fault.
fn widths<'a>(all: impl Iterator<Item = &'a ExpectedWidth> + Clone) -> Vec<String> {
    let longest = all.clone().map(|width| width.id.len()).max().unwrap_or(0);
    let line = |ExpectedWidth { id, unit, half_width }: &ExpectedWidth| {
        // At the healthy value a leak through a gap has no slope: it goes with the third power.
        let unknown = || "not by small changes; assume a size, `--with`".to_owned();
        let width = half_width.map_or_else(unknown, |half| format!("+- {}", number::with_unit(half, unit)));
        format!("  {id:longest$}  {width}")
    };
    all.map(line).collect()
}
