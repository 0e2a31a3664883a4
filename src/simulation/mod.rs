//! Records from rigs: what the sensors of a rig would give along a record's inputs, or over the cycle of the rig file.

#[cfg(feature = "cli")]
mod report;

use std::path::PathBuf;

use serde::Serialize;

use crate::complaint::{Complaint, Kind, Place};
use crate::model::{self, BelowVacuum, InputSignals, Model, SolverEffort};
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Rig};
#[cfg(feature = "cli")]
pub use report::{SetParameter, SimulationReport};

/// How the equations are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
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
pub struct SimulationOptions {
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
    pub effort: SolverEffort,
    /// Where and when the pressure is lowest, if that is below vacuum; `None` where the model stays valid.
    pub below_vacuum: Option<BelowVacuum>,
}

/// Simulates the record that the sensors of a rig would give: along the inputs of `source`, or over the cycle of the rig file.
///
/// # Errors
/// Neither a record nor a cycle; a cycle where a node starts at its first reading; inputs that the record lacks; a model that
/// cannot be solved; a [context](crate::Context) that was cancelled.
pub fn simulate(model: &Model, source: Option<&Record>, options: &SimulationOptions) -> Result<Simulated, Complaint> {
    let rig = &model.rig;
    let (drive, times) = drive(rig, source)?;
    rig.context().stage("simulation");
    let (model, volumes) = model.showing_volumes();
    let parameters = model.rig.nominal();
    let solved = match options.method {
        Method::Implicit => model.solve(&parameters, &drive, &times),
        Method::Explicit => model.solve_explicitly(&parameters, &drive, &times),
    };
    let mut outputs = solved.map_err(|error| model.unsolved(&error))?;
    let pressures = outputs.values.split_off(rig.sensors.len());
    let below_vacuum = BelowVacuum::of(rig, &volumes, &pressures, &times);
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
    Ok(Simulated { record, effort: outputs.effort, below_vacuum })
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
    let from_record = |kind: &NodeKind| *kind == NodeKind::Volume { initial: InitialPressure::Record };
    let help = "add the pressure that it starts with, such as `initial = \"5 bar\"`, or give `--input RECORD`";
    if let Some(unknown) = rig.starts_unknown(from_record, help) {
        return Err(unknown);
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
