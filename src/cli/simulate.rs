//! `simulate`: what the sensors of a rig would read.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::{Failure, Format, Status, read, write_json};
use crate::complaint::{Complaint, Kind, Place};
use crate::context::Context;
use crate::files::check_output;
use crate::model::{self, Drive, Model};
use crate::record::Record;
use crate::report::number;
use crate::rig::{InitialPressure, NodeKind, Rig, range};
use crate::units::Quantity;

/// Write the record that the sensors of a rig would give
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  borescope simulate rig.toml --set cylinder.clearance=0.2mm --seed 1 -o record.csv")]
pub struct Arguments {
    /// The rig file
    rig: PathBuf,
    /// Take commands and loads from this record; without it from the `[cycle]` of the rig file
    #[arg(long, value_name = "RECORD")]
    input: Option<PathBuf>,
    /// Give a parameter another value, such as `cylinder.clearance=0.2mm`; may be repeated
    #[arg(long, value_name = "PARAMETER=VALUE")]
    set: Vec<String>,
    /// Add noise to sensors and inputs and round to the sensors' resolution; the same number gives the same record
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// How the equations are solved
    #[arg(long, value_enum, default_value_t = Method::Implicit)]
    method: Method,
    /// Where the record is written
    #[arg(short, long, value_name = "RECORD.csv")]
    output: PathBuf,
    /// How the summary is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    /// Rodas5P, for every circuit
    Implicit,
    /// Dormand-Prince 5(4), for circuits that are not stiff, such as open reservoirs: an independent check
    Explicit,
}

#[derive(Serialize)]
struct Summary {
    schema: &'static str,
    record: String,
    rows: usize,
    from_s: f64,
    to_s: f64,
    columns: Vec<Column>,
    set: Vec<Set>,
    seed: Option<u64>,
    method: &'static str,
    steps: usize,
    rejected_steps: usize,
}

#[derive(Serialize)]
struct Column {
    name: String,
    unit: String,
}

#[derive(Serialize)]
pub(super) struct Set {
    pub(super) id: String,
    value: f64,
    unit: String,
}

/// Runs the verb; the summary goes to `out`, unless the record itself goes to a device.
pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    check_output(&arguments.output, arguments.input.iter().chain([&arguments.rig]))?;
    let mut rig = Rig::read(&arguments.rig)?.with_context(context);
    let mut set = Vec::new();
    for text in &arguments.set {
        set.push(set_parameter(&mut rig, "--set", text)?);
    }
    check_capacities(&rig, &arguments.set)?;
    let source = arguments.input.as_deref().map(|path| read::record(&rig, path)).transpose()?;
    let (drive, times) = drive(&rig, source.as_ref())?;
    let model = Model::new(rig);
    let parameters = model.rig.nominal();
    context.stage("simulation");
    let solved = match arguments.method {
        Method::Implicit => model.simulate(&parameters, &drive, &times),
        Method::Explicit => model.simulate_explicitly(&parameters, &drive, &times),
    };
    let outputs = solved.map_err(|error| {
        let complaint = Complaint::new(Kind::Computation, format!("the simulation came to no end: {error}"));
        complaint.in_file(&arguments.rig).help(match arguments.method {
            Method::Implicit => "look for values without physical sense; `borescope check` lists them all",
            Method::Explicit => "the circuit may be stiff; leave `--method` away",
        })
    })?;
    let inputs = match &source {
        // Recorded inputs are measured already: copied, they drive the next simulation alike.
        Some(record) if arguments.seed.is_none() => recorded_inputs(&model.rig, record, &drive)?,
        _ => model::input_columns(&model.rig, &drive, &times),
    };
    let mut record = model::recording(&model.rig, &arguments.output, times, inputs, &outputs, arguments.seed);
    record.time_decimals = match (&source, &model.rig.cycle) {
        (Some(source), _) => source.time_decimals,
        (None, Some(cycle)) => model::decimals_of(cycle.interval),
        (None, None) => None,
    };
    context.check()?;
    context.stage("writing the record");
    record.write(&arguments.output)?;
    let summary = Summary {
        schema: "borescope.simulation/1",
        record: arguments.output.display().to_string(),
        rows: record.time.len(),
        from_s: record.time.first().copied().unwrap_or_default(),
        to_s: record.time.last().copied().unwrap_or_default(),
        columns: record
            .channels
            .iter()
            .map(|channel| Column { name: channel.name.clone(), unit: channel.unit.to_string() })
            .collect(),
        set,
        seed: arguments.seed,
        method: match arguments.method {
            Method::Implicit => "implicit",
            Method::Explicit => "explicit",
        },
        steps: outputs.effort.steps,
        rejected_steps: outputs.effort.rejected,
    };
    // With `-o /dev/stdout` the summary would stand in the record.
    if Path::new(&arguments.output).is_file() {
        match arguments.format {
            Format::Json => write_json(out, &summary)?,
            Format::Text => write_text(out, &summary)?,
        }
    }
    Ok(Status::Done)
}

fn write_text(out: &mut dyn Write, summary: &Summary) -> std::io::Result<()> {
    let Summary { record, rows, from_s, to_s, columns, steps, .. } = summary;
    writeln!(
        out,
        "{record}: {rows} rows of {} columns from {} s to {} s, solved in {steps} steps",
        columns.len(),
        number::text(*from_s),
        number::text(*to_s)
    )?;
    for Set { id, value, unit } in &summary.set {
        writeln!(out, "  {id} = {}", number::with_unit(*value, unit))?;
    }
    Ok(())
}

/// Gives the parameter of `component.parameter=value` its value.
pub(super) fn set_parameter(rig: &mut Rig, option: &str, text: &str) -> Result<Set, Complaint> {
    let complain = |kind, what: String| Complaint::new(kind, format!("`{option} {text}`: {what}"));
    let Some((id, value)) = text.split_once('=') else {
        return Err(complain(Kind::Syntax, "there is no `=`".to_owned())
            .help(format!("write PARAMETER=VALUE, such as `{option} cylinder.clearance=0.2mm`")));
    };
    let id = id.trim();
    let Some(index) = rig.parameter(id) else {
        return Err(complain(Kind::UnknownName, format!("the rig has no parameter `{id}`"))
            .at(Place::file(&rig.path))
            .help(rig.help_with_parameters(id)));
    };
    let parameter = &mut rig.parameters[index];
    let quantity = Quantity::parse_as(value, parameter.unit.dimension)
        .map_err(|error| complain(Kind::Unit, error.to_string()).help(error.help()))?;
    let (low, high) = parameter.bounds;
    if !(low..=high).contains(&quantity.value) {
        let shown = |si: f64| number::with_unit(number::in_unit(si, &quantity.unit), &quantity.unit.symbol);
        let range = range((low, high), &quantity.unit);
        return Err(complain(Kind::Bounds, format!("{} is outside the physical bounds", shown(quantity.value)))
            .at(parameter.place.clone())
            .help(format!("{}: {range}", parameter.meaning)));
    }
    parameter.value = quantity.value;
    let value = number::in_unit(quantity.value, &quantity.unit);
    Ok(Set { id: id.to_owned(), value, unit: quantity.unit.symbol })
}

/// A volume or mass set to zero leaves a node without equation.
fn check_capacities(rig: &Rig, set: &[String]) -> Result<(), Complaint> {
    if set.is_empty() {
        return Ok(());
    }
    for (index, node) in rig.nodes.iter().enumerate() {
        if !matches!(node.kind, NodeKind::Held { .. }) && !model::has_capacity(rig, index) {
            let what = format!("with `--set {}` node `{}` has neither volume nor mass", set.join(" --set "), node.name);
            return Err(Complaint::new(Kind::Bounds, what).at(node.place.clone()).help("set values above 0"));
        }
    }
    Ok(())
}

/// What drives the circuit, and the times of the rows.
pub(super) fn drive(rig: &Rig, source: Option<&Record>) -> Result<(Drive, Vec<f64>), Complaint> {
    if let Some(record) = source {
        return Ok((Drive::from_record(rig, record)?, record.time.clone()));
    }
    let Some(cycle) = &rig.cycle else {
        return Err(Complaint::new(Kind::MissingEntry, "the rig file has no `[cycle]` to simulate")
            .at(Place::file(&rig.path))
            .help("add `[cycle]` with `interval` and `phases`, or give commands and loads with `--input RECORD`"));
    };
    if let Some(node) = rig.nodes.iter().find(|node| node.kind == NodeKind::Volume { initial: InitialPressure::Record })
    {
        let what = format!("node `{}` starts at what its sensor shows first, but there is no record", node.name);
        return Err(Complaint::new(Kind::MissingEntry, what)
            .at(node.place.clone())
            .help("add `initial = \"0 bar\"` or the pressure that it starts with, or give `--input RECORD`"));
    }
    Ok((Drive::from_cycle(rig, cycle), model::cycle_times(rig, cycle)))
}

/// The input columns of a record; where one has no value, what it does there by its way to hold.
fn recorded_inputs(rig: &Rig, record: &Record, drive: &Drive) -> Result<Vec<Vec<f64>>, Complaint> {
    let mut columns = model::input_columns(rig, drive, &record.time);
    for (input, column) in rig.inputs.iter().zip(&mut columns) {
        let channel = rig.input_column(record, input)?;
        for (held, &value) in column.iter_mut().zip(&channel.values).filter(|(_, value)| !value.is_nan()) {
            *held = value;
        }
    }
    Ok(columns)
}
