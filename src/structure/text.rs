//! The structural analysis in words.

use std::fmt;

use super::{Count, FaultPair, Isolability};

/// How many alternatives of further sensors the text names.
const ALTERNATIVES: usize = 5;

impl fmt::Display for Isolability {
    /// Lines ended by line feeds.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write(f, self)
    }
}

/// Columns of a terminal.
const COLUMNS: usize = 80;

fn write(text: &mut fmt::Formatter<'_>, result: &Isolability) -> fmt::Result {
    let detected = result.detectable.iter().filter(|&&detectable| detectable).count();
    writeln!(
        text,
        "{} equations in {} unknowns, redundancy {}; {} minimal redundant sets, {} fault supports.",
        result.equations,
        result.unknowns,
        result.redundancy,
        count(result.mso_sets),
        count(result.mtes_sets),
    )?;
    writeln!(text, "{detected} of {} faults can be detected.\n", result.faults.len())?;
    let width = result.faults.iter().map(String::len).max().unwrap_or(0);
    let fits = 5 + width + 4 * result.faults.len() <= COLUMNS;
    if fits {
        let numbers: String = (1..=result.faults.len()).map(|number| format!("{number:>4}")).collect();
        writeln!(text, "     {:width$}{numbers}", "")?;
    }
    for (index, (fault, row)) in result.faults.iter().zip(&result.explained_by).enumerate() {
        let note = if result.detectable[index] { "" } else { "   cannot be detected" };
        if fits {
            let marks: String = row.iter().map(|&explains| if explains { "   x" } else { "   ." }).collect();
            writeln!(text, "{:>4} {fault:width$}{marks}{note}", index + 1)?;
        } else {
            let others = row.iter().enumerate().filter(|(other, explains)| **explains && *other != index);
            let others: Vec<String> = others.map(|(other, _)| (other + 1).to_string()).collect();
            let others = if others.is_empty() { "-".to_owned() } else { others.join(" ") };
            writeln!(text, "{:>4} {fault:width$}  {others}{note}", index + 1)?;
        }
    }
    match fits {
        true => writeln!(text, "x: the fault of the column explains whatever the fault of the row does.\n")?,
        false => writeln!(text, "Behind each fault the others that explain whatever it does, by their numbers.\n")?,
    }
    for group in &result.ambiguity_groups {
        writeln!(text, "Not isolable from each other (ambiguity group): {}.", group.join(", "))?;
    }
    if !result.tests.is_empty() {
        writeln!(text, "Sufficient tests: {}.", result.tests.len())?;
        for test in &result.tests {
            writeln!(text, "  sensitive to {}; uses {}", test.faults.join(", "), test.signals.join(", "))?;
        }
    }
    match result.sensors.first() {
        None => writeln!(text, "No few further sensors would isolate every fault.")?,
        Some(none) if none.is_empty() => writeln!(text, "No further sensor would isolate more faults.")?,
        Some(_) => {
            writeln!(text, "Further sensors that would help, any one line of {}:", result.sensors.len())?;
            for sensors in result.sensors.iter().take(ALTERNATIVES) {
                writeln!(text, "  {}", sensors.join(" and "))?;
            }
        }
    }
    for pair in &result.inseparable {
        let mutual = |other: &&FaultPair| other.fault == pair.explained_by && other.explained_by == pair.fault;
        match result.inseparable.iter().find(mutual) {
            None => writeln!(text, "Whatever is measured, {} explains {}.", pair.explained_by, pair.fault)?,
            Some(_) if pair.fault < pair.explained_by => {
                writeln!(text, "Whatever is measured, {} and {} explain each other.", pair.fault, pair.explained_by)?;
            }
            Some(_) => {}
        }
    }
    Ok(())
}

fn count(count: Count) -> String {
    if count.complete { count.count.to_string() } else { format!("more than {}", count.count) }
}
