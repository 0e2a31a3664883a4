//! Records from rigs: what the sensors of a rig would give along a record's inputs, or over the cycle of the rig file.

#[cfg(feature = "cli")]
mod report;

use std::path::PathBuf;

use serde::Serialize;

use crate::complaint::{Complaint, Kind, Place};
use crate::model::{self, InputSignals, Model, SolverEffort};
use crate::number::rounded;
use crate::physics::VACUUM;
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Quantity, Rig};
#[cfg(feature = "cli")]
pub use report::{SetParameter, SimulationReport};

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

/// A pressure below vacuum: oil would boil and tear there, which the model does not know.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BelowVacuum {
    /// The node that falls lowest.
    pub node: String,
    /// When, s.
    pub at_s: f64,
    /// To which gauge pressure, bar.
    pub pressure_bar: f64,
    /// Nodes that fall below vacuum, this one included.
    pub nodes: usize,
}

impl BelowVacuum {
    /// Of gauge pressures of nodes, Pa, at the times of the rows.
    fn of(rig: &Rig, nodes: &[usize], pressures: &[Vec<f64>], times: &[f64]) -> Option<Self> {
        let lowest = |values: &Vec<f64>| values.iter().copied().zip(times).min_by(|a, b| a.0.total_cmp(&b.0));
        let each = nodes.iter().zip(pressures).filter_map(|(&node, values)| Some((node, lowest(values)?)));
        let below: Vec<(usize, (f64, &f64))> = each.filter(|(_, (least, _))| *least < VACUUM).collect();
        let &(node, (least, at)) = below.iter().min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
        Some(Self {
            node: rig.nodes[node].name.clone(),
            at_s: rounded(*at, 6),
            pressure_bar: rounded(least / 1e5, 4),
            nodes: below.len(),
        })
    }
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
    // What no sensor shows may be where the model ends.
    let mut watched = rig.clone();
    let is_volume = |&node: &usize| matches!(rig.nodes[node].kind, NodeKind::Volume { .. });
    let nodes: Vec<usize> =
        (0..rig.nodes.len()).filter(is_volume).filter(|&node| watched.watch(node, Quantity::Pressure)).collect();
    let model = Model::new(watched).with_tolerance(model.tolerance);
    let parameters = model.rig.nominal();
    let solved = match options.method {
        Method::Implicit => model.solve(&parameters, &drive, &times),
        Method::Explicit => model.solve_explicitly(&parameters, &drive, &times),
    };
    let mut outputs = solved.map_err(|error| model.unsolved(&error))?;
    let pressures = outputs.values.split_off(rig.sensors.len());
    let below_vacuum = BelowVacuum::of(rig, &nodes, &pressures, &times);
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
    let help = "add `initial = \"0 bar\"` or the pressure that it starts with, or give `--input RECORD`";
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
