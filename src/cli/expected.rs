//! The numerical part of `isolability`: how well each fault could be sized at an operating point, and what it would be
//! mistaken for.

use std::fmt::Write;

use serde::Serialize;

use super::simulate::set_parameter;
use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::expected::{self, Expected};
use crate::model::{Drive, Model};
use crate::record::Record;
use crate::report::html::{Column, Table};
use crate::report::number::{self, rounded};
use crate::rig::Rig;

/// What a record at the operating point would say.
#[derive(Debug, Serialize)]
pub struct Numbers {
    /// The faults that are taken as present.
    pub with: Vec<Present>,
    /// Independent combinations of the faults of which the record would say more than their ranges do.
    pub rank: usize,
    /// Of how many faults.
    pub of: usize,
    /// Every fault of the rig, in its order.
    pub widths: Vec<Width>,
    /// The set most easily mistaken for the one that is present.
    pub rival: Vec<String>,
    /// Probability of that mistake.
    pub mistaken: f64,
}

/// A fault that is taken as present.
#[derive(Debug, Serialize)]
pub struct Present {
    pub id: String,
    pub value: f64,
    pub unit: String,
    /// Whether every set without it would lose.
    pub identifiable: bool,
}

/// How well one fault could be sized, the present ones unknown too.
#[derive(Debug, Serialize)]
pub struct Width {
    pub id: String,
    pub unit: String,
    /// Half the expected 95 % interval; `None` where the record would say nothing.
    pub half_width: Option<f64>,
}

/// The numbers at the operating point of `record` with each `FAULT=VALUE` of `with` present.
///
/// # Errors
/// What is no fault of the rig, a value out of its bounds, an operating point that cannot be simulated.
pub fn numbers(rig: &Rig, drive: &Drive, record: &Record, with: &[String]) -> Result<Numbers, Complaint> {
    let mut set = rig.clone();
    let mut faults = Vec::new();
    for text in with {
        let parameter = set_parameter(&mut set, "--with", text)?.id;
        let fault = rig.faults.iter().position(|fault| rig.parameters[fault.parameter].id == parameter);
        let Some(fault) = fault else {
            return Err(Complaint::new(
                Kind::UnknownName,
                format!("`--with {text}`: `{parameter}` is no fault of the rig"),
            )
            .at(Place::file(&rig.path))
            .help("name a parameter that `[faults]` lists"));
        };
        faults.push((fault, set.parameters[rig.faults[fault].parameter].value));
    }
    let Expected { sigma, rank, identifiable, rival } =
        expected::expected(&Model::new(rig.clone()), record, drive, &faults).map_err(|error| {
            Complaint::new(Kind::Computation, format!("the operating point could not be simulated: {error}"))
                .in_file(&rig.path)
                .help("take smaller faults, or another record")
        })?;
    let parameter = |fault: usize| &rig.parameters[rig.faults[fault].parameter];
    let width = |(fault, sigma): (usize, &Option<f64>)| Width {
        id: parameter(fault).id.clone(),
        unit: parameter(fault).unit.symbol.clone(),
        half_width: sigma.map(|sigma| rounded(parameter(fault).unit.difference_from_si(1.96 * sigma), 3)),
    };
    let present = |(&(fault, value), identifiable): (&(usize, f64), bool)| Present {
        id: parameter(fault).id.clone(),
        value: rounded(parameter(fault).unit.from_si(value), 7),
        unit: parameter(fault).unit.symbol.clone(),
        identifiable,
    };
    Ok(Numbers {
        with: faults.iter().zip(identifiable).map(present).collect(),
        rank,
        of: rig.faults.len(),
        widths: sigma.iter().enumerate().map(width).collect(),
        mistaken: rival.as_ref().map_or(0.0, |rival| rounded(rival.mistaken, 3)),
        rival: rival
            .map_or_else(Vec::new, |rival| rival.faults.iter().map(|&fault| parameter(fault).id.clone()).collect()),
    })
}

/// What would be known, in sentences.
pub fn said(numbers: &Numbers) -> Vec<String> {
    let with: Vec<String> =
        numbers.with.iter().map(|one| format!("{} {}", one.id, number::with_unit(one.value, &one.unit))).collect();
    let mut said = vec![
        format!("With {}.", if with.is_empty() { "the healthy rig".to_owned() } else { with.join(" + ") }),
        format!("Rank {} of {} faults.", numbers.rank, numbers.of),
    ];
    let lost = numbers.with.iter().filter(|one| !one.identifiable);
    said.extend(lost.map(|one| format!("{}: not identifiable at this size.", one.id)));
    let name = if numbers.rival.is_empty() { "healthy".to_owned() } else { numbers.rival.join(" + ") };
    said.push(format!("Most easily mistaken for {name}, {} %.", number::text(rounded(100.0 * numbers.mistaken, 3))));
    said
}

/// Expected widths of the intervals, for a page.
pub fn table(numbers: &Numbers) -> Table {
    let row = |width: &Width| {
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
pub fn render(numbers: &Numbers) -> String {
    let mut text = String::new();
    let with: Vec<String> =
        numbers.with.iter().map(|one| format!("{} {}", one.id, number::with_unit(one.value, &one.unit))).collect();
    let with = if with.is_empty() { "the healthy rig".to_owned() } else { with.join(" + ") };
    let _ = writeln!(text, "\nExpected at the operating point, with {with}");
    let _ = writeln!(text, "  rank {} of {} faults", numbers.rank, numbers.of);
    for one in numbers.with.iter().filter(|one| !one.identifiable) {
        let _ = writeln!(text, "  {}: not identifiable at this size", one.id);
    }
    let name = if numbers.rival.is_empty() { "healthy".to_owned() } else { numbers.rival.join(" + ") };
    let _ =
        writeln!(text, "  most easily mistaken for {name}, {} %", number::text(rounded(100.0 * numbers.mistaken, 3)));
    let longest = numbers.widths.iter().map(|width| width.id.len()).max().unwrap_or(0);
    let _ = writeln!(
        text,
        "  half the 95 % interval that a record there would leave each fault, the present ones unknown too"
    );
    for Width { id, unit, half_width } in &numbers.widths {
        let width = half_width.map_or("unknown".to_owned(), |half| format!("+- {}", number::with_unit(half, unit)));
        let _ = writeln!(text, "  {id:longest$}  {width}");
    }
    text
}
