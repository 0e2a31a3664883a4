//! Records from rigs: what the sensors of a rig would give along a record's inputs, or over the cycle of the rig file.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::complaint::{Complaint, Kind, Place};
use crate::model::{self, Effort, InputSignals, Model};
use crate::number;
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Rig};
use crate::units::Quantity;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.simulation/1";

/// How the equations are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Rodas5P, for every circuit.
    #[default]
    Implicit,
    /// Dormand-Prince 5(4), for circuits that are not stiff, such as open reservoirs: an independent check.
    Explicit,
}

/// What the user may choose.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Options {
    /// The name of the new record.
    pub name: PathBuf,
    /// How the equations are solved.
    pub method: Method,
    /// Noise for sensors and inputs, and readings rounded to the resolution of the sensors; the same number gives the same
    /// record. `None` for exact values.
    pub seed: Option<u64>,
}

/// A record that was simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// Its inputs and sensors, each in the unit of the rig file.
    pub record: Record,
    /// What the integrator spent.
    pub effort: Effort,
}

/// Simulates the record that the sensors of a rig would give: along the inputs of `source`, or over the cycle of the rig file.
///
/// # Errors
/// Neither a record nor a cycle; a cycle where a node starts at its first reading; inputs that the record lacks; a model that
/// cannot be solved; a [context](crate::context) that was cancelled.
pub fn simulate(model: &Model, source: Option<&Record>, options: &Options) -> Result<Simulated, Complaint> {
    let rig = &model.rig;
    let (drive, times) = drive(rig, source)?;
    rig.context().stage("simulation");
    let parameters = rig.nominal();
    let solved = match options.method {
        Method::Implicit => model.solve(&parameters, &drive, &times),
        Method::Explicit => model.solve_explicitly(&parameters, &drive, &times),
    };
    let outputs = solved.map_err(|error| model.unsolved(&error))?;
    let inputs = match source {
        // Recorded inputs are measured already: copied, they drive the next simulation alike.
        Some(record) if options.seed.is_none() => recorded_inputs(rig, record, &drive)?,
        _ => model::input_columns(rig, &drive, &times),
    };
    let mut record = model::recording(rig, &options.name, times, inputs, &outputs, options.seed);
    record.time_decimals = match (source, &rig.cycle) {
        (Some(source), _) => source.time_decimals,
        (None, Some(cycle)) => model::decimals_of(cycle.interval),
        (None, None) => None,
    };
    rig.context().check()?;
    Ok(Simulated { record, effort: outputs.effort })
}

/// What drives the circuit, and the times of the rows.
///
/// # Errors
/// As [`simulate`], but for the model.
pub(crate) fn drive(rig: &Rig, source: Option<&Record>) -> Result<(InputSignals, Vec<f64>), Complaint> {
    if let Some(record) = source {
        return Ok((InputSignals::from_record(rig, record)?, record.time.clone()));
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
    Ok((InputSignals::from_cycle(rig, cycle), model::cycle_times(rig, cycle)))
}

/// The input columns of a record; where one has no value, what it does there by its way to hold.
fn recorded_inputs(rig: &Rig, record: &Record, drive: &InputSignals) -> Result<Vec<Vec<f64>>, Complaint> {
    let mut columns = model::input_columns(rig, drive, &record.time);
    for (input, column) in rig.inputs.iter().zip(&mut columns) {
        let channel = rig.input_column(record, input)?;
        for (held, &value) in column.iter_mut().zip(&channel.values).filter(|(_, value)| !value.is_nan()) {
            *held = value;
        }
    }
    Ok(columns)
}

/// A simulation as programs read it (`borescope.simulation/1`).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulationReport {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// The record, as the user named it.
    pub record: String,
    /// Rows of the record.
    pub rows: usize,
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
    /// Every column but the time.
    pub columns: Vec<Column>,
    /// Parameters that had another value than in the rig file.
    pub set: Vec<SetParameter>,
    /// Of the noise; `None` without.
    pub seed: Option<u64>,
    /// How the equations were solved.
    pub method: Method,
    /// Steps of the integrator.
    pub steps: usize,
    /// Steps that it tried and took back.
    pub rejected_steps: usize,
}

/// A column of a simulated record.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The unit in which it is written.
    pub unit: String,
}

/// A parameter with the value that it was given.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetParameter {
    /// Such as `cylinder.clearance`.
    pub id: String,
    /// In `unit`.
    pub value: f64,
    /// As it was given.
    pub unit: String,
}

impl SetParameter {
    /// The parameter `id` at a value.
    pub fn new(id: &str, value: &Quantity) -> Self {
        Self {
            id: id.trim().to_owned(),
            value: number::in_unit(value.value, &value.unit),
            unit: value.unit.symbol.clone(),
        }
    }
}

impl SimulationReport {
    /// Of a record that was written to `path`.
    pub fn new(simulated: &Simulated, path: &Path, set: Vec<SetParameter>, options: &Options) -> Self {
        let Simulated { record, effort } = simulated;
        let column =
            |channel: &crate::record::Channel| Column { name: channel.name.clone(), unit: channel.unit.to_string() };
        Self {
            schema: SCHEMA,
            record: path.display().to_string(),
            rows: record.time.len(),
            from_s: record.time.first().copied().unwrap_or_default(),
            to_s: record.time.last().copied().unwrap_or_default(),
            columns: record.channels.iter().map(column).collect(),
            set,
            seed: options.seed,
            method: options.method,
            steps: effort.steps,
            rejected_steps: effort.rejected,
        }
    }
}
