//! A simulation as programs read it (`borescope.simulation/1`).

use std::path::Path;

use serde::Serialize;

use super::{Method, Simulated, SimulationOptions};
use crate::model::BelowVacuum;
use crate::number;
use crate::units::Quantity;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.simulation/1";

/// A simulation as programs read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct SimulationReport {
    /// Name and version of the JSON schema: `borescope.simulation/1`.
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
    pub(crate) columns: Vec<Column>,
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
    /// Where the pressure is lowest, if that is below vacuum; `None` where it is nowhere.
    pub below_vacuum: Option<BelowVacuum>,
}

/// A column of a simulated record.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The unit in which it is written.
    pub unit: String,
}

/// A parameter with the value that it was given.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
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
    pub fn new(simulated: &Simulated, path: &Path, set: Vec<SetParameter>, options: &SimulationOptions) -> Self {
        let Simulated { record, effort, below_vacuum } = simulated;
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
            below_vacuum: below_vacuum.clone(),
        }
    }
}
