//! The page of `isolability`.

use super::learn::named;
use crate::isolability::IsolabilityReport;
use crate::report::circuit;
use crate::report::html::{Cell, Column, Page, Section, Table};
use crate::report::isolability::{blind, expected_sentences, signature_table, width_table};
use crate::report::style::Tone;
use crate::rig::Rig;
use crate::structure::{FaultPair, Isolability};

/// The structure, and what an operating point adds to it.
pub fn html(rig: &Rig, report: &IsolabilityReport) -> String {
    let structure = &report.structure;
    let detected = structure.detectable.iter().filter(|&&one| one).count();
    let mut page = Page::new(
        format!("Isolability of {}", named(rig)),
        format!(
            "{} equations in {} unknowns, redundancy {}",
            structure.equations, structure.unknowns, structure.redundancy
        ),
    );
    let mut verdict = Section::new("Verdict");
    let all = detected == structure.faults.len() && structure.ambiguity_groups.is_empty();
    verdict.notice(
        if all { Tone::Good } else { Tone::Caution },
        format!(
            "{detected} of {} faults can be detected; {}.",
            structure.faults.len(),
            match structure.ambiguity_groups.len() {
                0 => "all of these are isolable by structure".to_owned(),
                1 => "one ambiguity group".to_owned(),
                several => format!("{several} ambiguity groups"),
            }
        ),
    );
    let groups = structure
        .ambiguity_groups
        .iter()
        .map(|group| format!("Not isolable from each other (ambiguity group): {}.", group.join(", ")));
    let pairs = structure.inseparable.iter().filter_map(|pair| {
        let back = |other: &FaultPair| other.fault == pair.explained_by && other.explained_by == pair.fault;
        match structure.inseparable.iter().any(back) {
            false => Some(format!("Whatever is measured, {} explains {}.", pair.explained_by, pair.fault)),
            true if pair.fault < pair.explained_by => {
                Some(format!("Whatever is measured, {} and {} explain each other.", pair.fault, pair.explained_by))
            }
            true => None,
        }
    });
    page.section(verdict);
    let mut drawn = Section::new("Circuit");
    drawn.drawing(
        "circuit",
        &circuit::svg(rig, &[]),
        "The circuit as the rig file has it; sensors beside what they measure.",
    );
    page.section(drawn);
    let mut matrix = Section::new("Which fault is confused with which");
    matrix.table(isolation_table(structure));
    let points: Vec<String> = groups.chain(pairs).collect();
    if !points.is_empty() {
        matrix.list(points);
    }
    page.section(matrix);
    page.section(tests(structure));
    if let (Some(rows), Some(numbers)) = (&report.signatures, &report.expected) {
        let mut signatures = Section::new("Signatures at the operating point");
        match blind(rig, rows) {
            Some(words) => signatures.paragraph(words),
            None => signatures.table(signature_table(rig, rows)),
        };
        page.section(signatures);
        let mut expected = Section::new("What a record there would say");
        expected.list(expected_sentences(numbers)).table(width_table(numbers));
        page.section(expected);
    } else {
        let mut none = Section::new("Operating point");
        none.paragraph("None: signatures and expected intervals need a [cycle] in the rig file, or --input RECORD.");
        page.section(none);
    }
    page.html()
}

fn isolation_table(structure: &Isolability) -> Table {
    let columns = structure.faults.iter().map(|fault| Column::text(fault.clone()));
    let row = |(index, (fault, explained)): (usize, (&String, &Vec<bool>))| {
        let note = if structure.detectable[index] { String::new() } else { " (cannot be detected)".to_owned() };
        let cell = |(other, &hides): (usize, &bool)| match (hides, other == index) {
            (true, true) => Cell::Shade("\u{b7}".to_owned(), 0.15),
            (true, false) => Cell::Shade("x".to_owned(), 0.9),
            (false, _) => Cell::Shade(String::new(), 0.0),
        };
        let name = Cell::from(format!("{fault}{note}"));
        std::iter::once(name).chain(explained.iter().enumerate().map(cell)).collect()
    };
    let mut table = Table::new(
        "x: the fault of the column explains whatever the fault of the row does; \u{b7}: the fault itself",
        std::iter::once(Column::text("fault")).chain(columns).collect(),
        structure.faults.iter().zip(&structure.explained_by).enumerate().map(row).collect(),
    );
    table.upright = true;
    table
}

fn tests(structure: &Isolability) -> Section {
    let mut section = Section::new("Tests and sensors");
    let row = |test: &crate::structure::StructuralTest| {
        vec![test.faults.join(", ").into(), test.signals.join(", ").into(), test.equations.len().to_string().into()]
    };
    section.table(Table::new(
        "Tests that are sufficient to isolate what can be isolated",
        vec![Column::text("answers to"), Column::text("uses"), Column::number("equations", "")],
        structure.tests.iter().map(row).collect(),
    ));
    match structure.sensors.first() {
        None => section.paragraph("No few further sensors would isolate every fault."),
        Some(none) if none.is_empty() => section.paragraph("No further sensor would isolate more faults."),
        Some(_) => {
            section.paragraph("Further sensors that would help, any one line of these:");
            section.list(structure.sensors.iter().map(|sensors| sensors.join(" and ")).collect())
        }
    };
    section
}
