//! A check as text: what is in the files in a few lines, or every entry.

use std::io::{self, Write};

use super::brief::{few, wrapped};
use super::digits::plus_minus;
use super::table::headless;
use crate::check::{CheckReport, ParameterLine, PhaseInput, PhaseLine, RecordPage, RigPage};
use crate::number::{before_unit, rounded, text, with_unit};

/// Phases and warnings that the text shows; the JSON has all.
const MOST: usize = 20;
/// Warnings, and names in a row, that the short text shows.
const FEW: usize = 5;
/// So many inputs fit a line.
const INPUTS: usize = 4;

/// What is in the rig file and in the record, how much of each, and what is doubtful.
pub fn brief(page: &CheckReport) -> String {
    let rig = &page.rig;
    let counted = |count: usize, one: &str, more: &str| format!("{count} {}", if count == 1 { one } else { more });
    let of_circuit = rig.components.iter().filter(|one| rig.effects.iter().all(|effect| effect.id != one.name));
    let mut holds = vec![
        counted(of_circuit.count(), "component", "components"),
        counted(rig.nodes.len(), "node", "nodes"),
        counted(rig.states.len(), "state", "states"),
        counted(rig.sensors.len(), "sensor", "sensors"),
        counted(rig.inputs.len(), "input", "inputs"),
        counted(rig.faults.len(), "fault", "faults"),
    ];
    if !rig.effects.is_empty() {
        holds.push(counted(rig.effects.len(), "effect", "effects"));
    }
    if let Some(cycle) = &rig.cycle {
        holds.push(format!("a cycle of {} s", text(cycle.duration_s)));
    }
    let name = if rig.name.is_empty() { "a rig without name" } else { &rig.name };
    let mut lines = vec![format!("{}: {name}", rig.file)];
    lines.extend(wrapped(&format!("  {}", holds.join(", ")), "  "));
    let fitted = rig.parameters.iter().filter(|parameter| parameter.fitted).count();
    let exact = rig.parameters.iter().filter(|parameter| !parameter.fitted && parameter.sigma == 0.0).count();
    let by_sheet: Vec<&str> =
        rig.parameters.iter().filter(|one| one.exact_by_sheet).map(|one| one.id.as_str()).collect();
    let mut values =
        format!("  {}, {exact} are taken as exact", counted(fitted, "parameter is fitted", "parameters are fitted"));
    if !by_sheet.is_empty() {
        values += &format!(
            ", {} of them by data sheets without `+-`: {}; state it, or calibrate on healthy records",
            by_sheet.len(),
            few(&by_sheet, FEW)
        );
    }
    lines.extend(wrapped(&format!("{values}."), "  "));
    lines.extend(page.record.iter().flat_map(brief_record));
    if !rig.warnings.is_empty() {
        lines.extend(warned("warnings about the rig file", &rig.warnings));
    }
    lines.join("\n") + "\n"
}

fn brief_record(record: &RecordPage) -> Vec<String> {
    let mut lines = wrapped(&format!("{}.", rows_of(record)), "  ");
    lines.extend(wrapped(&format!("  Read as {}.", record.read_as), "  "));
    let (of_rig, others): (Vec<_>, Vec<_>) = record.channels.iter().partition(|channel| channel.role.is_some());
    let mut columns = format!("  {} of its columns belong to this rig", of_rig.len());
    if !others.is_empty() {
        let names: Vec<&str> = others.iter().map(|channel| channel.name.as_str()).collect();
        columns += &format!(", {} do not: {}", names.len(), few(&names, FEW));
    }
    if record.usable {
        columns += &match record.phases.len() {
            1 => "; no input jumps".to_owned(),
            several => format!("; {several} phases between jumps of the inputs"),
        };
    }
    lines.extend(wrapped(&format!("{columns}."), "  "));
    if !record.mapping.is_empty() {
        lines.push(format!("{MISSING}: {}", record.mapping.len()));
        lines.extend(mapping(record));
    }
    lines.extend(warned("warnings", &record.warnings));
    lines
}

fn warned(heading: &str, warnings: &[String]) -> Vec<String> {
    let mut lines = vec![format!("{heading}: {}", warnings.len())];
    lines.extend(sentences(&warnings[..warnings.len().min(FEW)]));
    if warnings.len() > FEW {
        lines.push(format!("  and {} more", warnings.len() - FEW));
    }
    lines
}

/// Writes every entry of the rig file, then of the record.
///
/// # Errors
/// Those of `out`.
pub fn write_page(out: &mut dyn Write, page: &CheckReport) -> io::Result<()> {
    write_rig(out, &page.rig)?;
    if let Some(record) = &page.record {
        write_record(out, record)?;
    }
    if page.rig.warnings.is_empty() {
        return Ok(());
    }
    cut_off(out, "warnings about the rig file", &page.rig.warnings, sentences)
}

/// A heading, its count, and its lines in columns.
fn table(out: &mut dyn Write, heading: &str, rows: &[Vec<String>]) -> io::Result<()> {
    writeln!(out, "\n{heading}: {}", rows.len())?;
    headless(rows).iter().try_for_each(|line| writeln!(out, "{line}"))
}

fn write_rig(out: &mut dyn Write, rig: &RigPage) -> io::Result<()> {
    let name = if rig.name.is_empty() { "a rig without name" } else { &rig.name };
    writeln!(out, "{}: {name}", rig.file)?;
    let rows = rig.nodes.iter().map(|node| vec![node.name.clone(), node.kind.to_owned(), node.start.clone()]);
    table(out, "nodes", &rows.collect::<Vec<_>>())?;
    let of_circuit = |name: &str| rig.effects.iter().all(|effect| effect.id != name);
    let rows = rig.components.iter().filter(|component| of_circuit(&component.name)).map(|component| {
        let ports = component.ports.iter().map(|line| format!("{}={}", line.port, line.node));
        vec![component.name.clone(), component.kind.to_owned(), ports.collect::<Vec<_>>().join(" ")]
    });
    table(out, "components", &rows.collect::<Vec<_>>())?;
    let shown =
        |id: &String| rig.parameters.iter().find(|one| one.id == *id).map(|one| with_unit(one.value, &one.unit));
    let rows = rig.effects.iter().map(|effect| {
        let values = effect
            .parameters
            .iter()
            .filter_map(|id| Some(format!("{} = {}", id.rsplit('.').next().unwrap_or(id), shown(id)?)));
        vec![effect.id.clone(), values.collect::<Vec<_>>().join(", "), effect.law.to_owned()]
    });
    let mut rows: Vec<Vec<String>> = rows.collect();
    rows.extend(rig.own_effects.iter().map(|id| vec![id.clone(), "not in the model, tried by `suggest`".to_owned()]));
    if !rows.is_empty() {
        table(out, "effects", &rows)?;
    }
    table(out, "states", &rig.states.iter().map(|state| vec![state.clone()]).collect::<Vec<_>>())?;
    write_parameters(out, &rig.parameters)?;
    let rows = rig.sensors.iter().map(|sensor| {
        let mut notes = vec![format!("+- {}", with_unit(sensor.noise, &sensor.unit))];
        if sensor.resolution > 0.0 {
            notes.push(format!("in steps of {}", with_unit(sensor.resolution, &sensor.unit)));
        }
        if sensor.lag_s > 0.0 {
            notes.push(format!("lag {} s", text(sensor.lag_s)));
        }
        vec![sensor.column.clone(), sensor.quantity.to_owned(), sensor.at.clone(), notes.join(", ")]
    });
    table(out, "sensors, +- one standard deviation of their noise", &rows.collect::<Vec<_>>())?;
    let rows = rig.inputs.iter().map(|input| {
        let noise =
            if input.noise > 0.0 { format!("+- {}", with_unit(input.noise, &input.unit)) } else { String::new() };
        vec![input.column.clone(), input.unit.clone(), format!("holds {}", input.hold), noise]
    });
    table(out, "inputs, +- one standard deviation of their noise", &rows.collect::<Vec<_>>())?;
    let rows = rig.faults.iter().map(|fault| {
        let range = format!("from {} to {}", text(fault.bounds[0]), with_unit(fault.bounds[1], &fault.unit));
        vec![fault.id.clone(), format!("healthy {}", with_unit(fault.healthy, &fault.unit)), range]
    });
    table(out, "faults", &rows.collect::<Vec<_>>())?;
    if let Some(cycle) = &rig.cycle {
        let (duration, interval) = (text(cycle.duration_s), text(cycle.interval_s));
        writeln!(out, "\ncycle: {} phases, {duration} s, a row every {interval} s", cycle.phases)?;
    }
    Ok(())
}

/// What a fit estimates, what each switching may have otherwise, and what is taken as exact.
fn write_parameters(out: &mut dyn Write, parameters: &[ParameterLine]) -> io::Result<()> {
    let (estimated, others): (Vec<_>, Vec<_>) = parameters.iter().partition(|parameter| parameter.fitted);
    let (per_switching, exact): (Vec<_>, Vec<_>) = others.into_iter().partition(|parameter| parameter.sigma > 0.0);
    let (margins, of_parts): (Vec<_>, Vec<_>) = estimated.into_iter().partition(|parameter| parameter.margin);
    let rows = |parameters: &[&ParameterLine]| parameters.iter().map(|one| parameter_row(one)).collect::<Vec<_>>();
    table(out, "parameters that a fit estimates, +- one standard deviation", &rows(&of_parts))?;
    if !margins.is_empty() {
        let one = |margin: &&ParameterLine| {
            let size = before_unit(plus_minus(margin.value, margin.sigma), &margin.unit);
            format!("{} {}", margin.id, size.replace(' ', "\u{a0}"))
        };
        let margins = format!("  and margins: {}", margins.iter().map(one).collect::<Vec<_>>().join(", "));
        wrapped(&margins, "    ").iter().try_for_each(|line| writeln!(out, "{line}"))?;
    }
    if !per_switching.is_empty() {
        table(out, "parameters that may be others in each switching", &rows(&per_switching))?;
    }
    writeln!(out, "\nparameters taken as exact: {}", exact.len())?;
    let by_sheet: Vec<&str> =
        exact.iter().filter(|parameter| parameter.exact_by_sheet).map(|parameter| parameter.id.as_str()).collect();
    if by_sheet.is_empty() {
        return Ok(());
    }
    let advice = format!(
        "  Parts deviate from data sheets in these, which are exact until a record cannot be explained so: {}. State `+-`, or calibrate \
         on healthy records.",
        by_sheet.join(", ")
    );
    wrapped(&advice, "  ").iter().try_for_each(|line| writeln!(out, "{line}"))
}

fn parameter_row(parameter: &ParameterLine) -> Vec<String> {
    let value = match parameter.sigma {
        0.0 => format!("{}, fault", with_unit(parameter.value, &parameter.unit)),
        sigma => before_unit(plus_minus(parameter.value, sigma), &parameter.unit),
    };
    // A number and its unit stay in one line.
    vec![parameter.id.clone(), value.replace(' ', "\u{a0}"), parameter.meaning.clone()]
}

fn write_record(out: &mut dyn Write, record: &RecordPage) -> io::Result<()> {
    writeln!(out, "\n{}", rows_of(record))?;
    writeln!(out, "  read as {}", record.read_as)?;
    let rows = record.channels.iter().map(|channel| {
        let range = channel.least.zip(channel.greatest).map_or_else(
            || format!("no value, {}", channel.unit),
            |(least, greatest)| format!("from {} to {}", text(least), with_unit(greatest, &channel.unit)),
        );
        vec![channel.name.clone(), channel.role.unwrap_or("not of this rig").to_owned(), range]
    });
    table(out, "columns", &rows.collect::<Vec<_>>())?;
    if record.usable {
        cut_off(out, "phases between jumps of the inputs", &phases(&record.phases), headless)?;
    }
    if !record.mapping.is_empty() {
        writeln!(out, "\n{MISSING}: {}", record.mapping.len())?;
        mapping(record).iter().try_for_each(|line| writeln!(out, "{line}"))?;
    }
    cut_off(out, "warnings", &record.warnings, sentences)
}

/// How many rows a record has, and from when to when.
fn rows_of(record: &RecordPage) -> String {
    let [from, to, duration, interval] = [record.from_s, record.to_s, record.duration_s, record.interval_s].map(text);
    format!(
        "{}: {} rows from {from} s to {to} s, {duration} s in all, one every {interval} s",
        record.file, record.rows
    )
}

/// Heading of the columns that are missing.
const MISSING: &str = "columns that are missing, with what the rig file may say";

/// A line for each of them.
fn mapping(record: &RecordPage) -> Vec<String> {
    let rows = record.mapping.iter().map(|proposal| {
        let write = match (&proposal.column, proposal.because) {
            (Some(column), Some("unit")) => format!("column = \"{column}\"  (the only one of its unit)"),
            (Some(column), _) => format!("column = \"{column}\""),
            (None, _) => "no column left that is like it".to_owned(),
        };
        vec![proposal.wanted.clone(), proposal.role.to_owned(), write]
    });
    headless(&rows.collect::<Vec<_>>())
}

/// A heading and no more of its entries than people read, as lines; the JSON has all.
fn cut_off<T>(out: &mut dyn Write, heading: &str, all: &[T], lines: impl Fn(&[T]) -> Vec<String>) -> io::Result<()> {
    writeln!(out, "\n{heading}: {}", all.len())?;
    let shown = &all[..all.len().min(MOST)];
    lines(shown).iter().try_for_each(|line| writeln!(out, "{line}"))?;
    let beyond = all.len() - shown.len();
    if beyond > 0 {
        writeln!(out, "  and {beyond} more")?;
    }
    Ok(())
}

fn sentences(all: &[String]) -> Vec<String> {
    all.iter().flat_map(|one| wrapped(&format!("  {one}"), "    ")).collect()
}

/// A row for each phase, with what each input does; of many inputs those that do something else than in the phase before.
fn phases(phases: &[PhaseLine]) -> Vec<Vec<String>> {
    let few = phases.iter().all(|phase| phase.inputs.len() <= INPUTS);
    let of = |(index, phase): (usize, &PhaseLine)| {
        let before = index.checked_sub(1).map(|index| &phases[index].inputs);
        let is_shown = |input: usize| {
            let courses = |inputs: &Vec<PhaseInput>| course(&inputs[input]);
            few || before.map(courses).is_none_or(|before| before != course(&phase.inputs[input]))
        };
        let all_rest = phase.inputs.iter().all(|input| input.from == 0.0 && input.to == 0.0);
        let shown = (0..phase.inputs.len()).filter(|&input| is_shown(input)).map(|input| course(&phase.inputs[input]));
        let time = format!("{} s to {} s", text(phase.from_s), text(phase.to_s));
        match before {
            _ if few => std::iter::once(time).chain(shown).collect(),
            None if all_rest => vec![time, "all inputs 0".to_owned()],
            _ => vec![time, shown.collect::<Vec<_>>().join("  ")],
        }
    };
    phases.iter().enumerate().map(of).collect()
}

/// How an input runs over a phase; four digits, as its noise leaves no more.
fn course(input: &PhaseInput) -> String {
    let [from, to, least, most] = [input.from, input.to, input.least, input.most].map(|value| rounded(value, 4));
    if least < from.min(to) || most > from.max(to) {
        let between = format!("between {} and {}", text(least), with_unit(most, &input.unit));
        format!("{} = {} to {}, {between}", input.name, text(from), with_unit(to, &input.unit))
    } else if from == to {
        format!("{} = {}", input.name, with_unit(from, &input.unit))
    } else {
        format!("{} = {} to {}", input.name, text(from), with_unit(to, &input.unit))
    }
}
