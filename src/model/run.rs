//! A model as programs use it: parameters by id and text, runs along a record, readings by the name of their sensor.

use super::{InputSignals, Model, SimulationError, SolverEffort};
use crate::complaint::{Complaint, Kind, Place, help_with_names};
use crate::record::Inputs;
use crate::rig::{NodeKind, Rig};
use crate::units::{Dimension, Unit};

impl Rig {
    /// The equations of this rig, with its parameters as the rig file has them.
    pub fn model(&self) -> Model {
        Model::new(self.clone())
    }

    /// Whether every node that needs a volume or a mass has one, as with parameters that were [set](Rig::set).
    ///
    /// # Errors
    /// The first node that has none.
    pub(crate) fn check_capacities(&self) -> Result<(), Complaint> {
        let held = |kind: &NodeKind| matches!(kind, NodeKind::Held { .. });
        let empty = |(index, node): &(usize, &crate::rig::Node)| !held(&node.kind) && !self.has_capacity(*index);
        match self.nodes.iter().enumerate().find(empty) {
            None => Ok(()),
            Some((_, node)) => {
                let what = format!("node `{}` has neither volume nor mass", node.name);
                Err(Complaint::new(Kind::Bounds, what).at(node.place.clone()).help("set values above 0"))
            }
        }
    }
}

impl Model {
    /// The same with the parameter `id`, such as `cylinder.clearance`, at another value, such as `0.2 mm`.
    ///
    /// # Errors
    /// Those of [`Rig::set`], and a volume or mass of 0 that leaves a node without equation.
    pub fn with(&self, id: &str, value: &str) -> Result<Self, Complaint> {
        let mut rig = self.rig.clone();
        rig.set(id, value)?;
        rig.check_capacities()?;
        Ok(Self::new(rig).with_tolerance(self.tolerance))
    }

    /// Runs the model as a record was driven; its sensors read at the times of the record, without noise.
    ///
    /// # Errors
    /// Inputs that the record lacks or has in another dimension, and a model that cannot be solved.
    pub fn simulate(&self, inputs: &Inputs<'_>) -> Result<Simulation, Complaint> {
        let record = inputs.record;
        let drive = InputSignals::from_record(&self.rig, record)?;
        let outputs = self.solve(&self.rig.nominal(), &drive, &record.time).map_err(|error| self.unsolved(&error))?;
        let sensors = self.rig.sensors.iter().zip(outputs.values).map(|(sensor, values)| Reading {
            sensor: sensor.name.clone(),
            dimension: sensor.dimension,
            values,
        });
        Ok(Simulation { time: record.time.clone(), sensors: sensors.collect(), effort: outputs.effort })
    }

    /// The complaint about a simulation that came to no end.
    pub(crate) fn unsolved(&self, error: &SimulationError) -> Complaint {
        if *error == SimulationError::Interrupted {
            return crate::context::Interrupted.into();
        }
        let help = match error {
            SimulationError::Integration { formula: Some(_), .. } => {
                "make the formula smooth, such as `tanh(x / w)` in place of `sign(x)`"
            }
            SimulationError::Explicit { .. } => "the circuit may be stiff; leave `--method` away",
            _ => {
                "look for values without physical sense in what is joined there; `borescope check` names those that no catalogue has"
            }
        };
        Complaint::new(Kind::Computation, format!("the simulation came to no end: {error}"))
            .at(Place::file(&self.rig.path))
            .help(help)
    }
}

/// What the sensors of a model read over a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// s.
    pub time: Vec<f64>,
    /// Every sensor, in the order of the rig file.
    pub sensors: Vec<Reading>,
    /// What the integrator spent.
    pub effort: SolverEffort,
}

/// What one sensor of a model reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The name of the sensor.
    pub sensor: String,
    /// What it measures.
    pub dimension: Dimension,
    /// SI, pressures gauge; one for each time.
    pub values: Vec<f64>,
}

impl Simulation {
    /// The readings of the sensor of this name.
    ///
    /// # Errors
    /// No such sensor; the near miss, and those that there are.
    pub fn sensor(&self, name: &str) -> Result<&Reading, Complaint> {
        let names = || self.sensors.iter().map(|reading| reading.sensor.as_str());
        self.sensors.iter().find(|reading| reading.sensor == name).ok_or_else(|| {
            Complaint::new(Kind::UnknownName, format!("there is no sensor `{name}`")).help(help_with_names(
                name,
                "sensors",
                names(),
            ))
        })
    }
}

impl Reading {
    /// The readings in a unit.
    ///
    /// # Errors
    /// A unit that is not known or of another dimension.
    pub fn in_unit(&self, unit: &str) -> Result<Vec<f64>, Complaint> {
        let unit = Unit::parse_as(unit, self.dimension).map_err(|error| {
            Complaint::new(Kind::Unit, format!("sensor `{}`: {error}", self.sensor)).help(error.help())
        })?;
        Ok(self.values.iter().map(|&value| unit.from_si(value)).collect())
    }
}
