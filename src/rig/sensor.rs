//! Sensors and inputs: what of the circuit a record shows, and what drives it.

use std::path::Path;

use super::Scaling;
use crate::complaint::{Complaint, Place};
use crate::record::survey::Scatter;
use crate::record::{Channel, Record};
use crate::units::{Dimension, Unit};

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Gauge pressure of a node.
    Pressure,
    /// Flow through a component's port.
    Flow,
    /// Position of a body.
    Position,
    /// Velocity of a body.
    Velocity,
    /// Level of the fluid over a node, `(p - p_atm)/(rho g)`.
    Level,
    /// Force of a component on the body at its port, in the direction of the position, without the inertia of its own mass: what a load cell
    /// between them reads.
    Force,
    /// State of a component, such as the position of a spool or the speed of a shaft.
    State,
}

impl Quantity {
    /// Every quantity, by the name that the rig file uses.
    pub const NAMED: &[(&str, Quantity)] = &[
        ("pressure", Quantity::Pressure),
        ("flow", Quantity::Flow),
        ("position", Quantity::Position),
        ("velocity", Quantity::Velocity),
        ("level", Quantity::Level),
        ("force", Quantity::Force),
        ("state", Quantity::State),
    ];

    /// That of its values; a state says its own.
    pub fn dimension(self) -> Option<Dimension> {
        match self {
            Quantity::Pressure => Some(Dimension::PRESSURE),
            Quantity::Flow => Some(Dimension::FLOW),
            Quantity::Position | Quantity::Level => Some(Dimension::LENGTH),
            Quantity::Velocity => Some(Dimension::VELOCITY),
            Quantity::Force => Some(Dimension::FORCE),
            Quantity::State => None,
        }
    }
}

/// Where a sensor sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    Node(usize),
    /// Component and port: a flow into a hydraulic one, a force at a mechanical one.
    Port(usize, usize),
    /// Component and state.
    State(usize, usize),
}

/// One measured column of a record.
#[derive(Debug, Clone)]
pub struct Sensor {
    pub name: String,
    pub column: String,
    pub quantity: Quantity,
    /// Of what it reads, before any [`scale`](Self::scale).
    pub dimension: Dimension,
    pub target: Target,
    /// What the column holds in place of the quantity.
    pub scale: Option<Scaling>,
    /// The unit of the column in records that do not name it.
    pub column_unit: Option<Unit>,
    /// +1, or -1 for a flow counted out of the port.
    pub sign: f64,
    /// One standard deviation of the noise of a sample, SI.
    pub noise: f64,
    /// The same as it is stated, SI: what errors are shown in multiples of, whatever a fit weighs by.
    pub stated_noise: f64,
    /// One standard deviation of what the model lacks at this sensor, SI, while it is fitted all the same; 0 elsewhere.
    pub lack_of_fit: f64,
    /// Step of the last digit, SI; 0 where it does not matter.
    pub resolution: f64,
    /// What model and sensor may differ by throughout a phase of the record, one standard deviation, SI.
    pub tolerance: f64,
    /// Whether that is stated in its own right, and not a share of the noise.
    pub tolerance_is_stated: bool,
    /// Time constant of the sensor, s; 0 without.
    pub lag: f64,
    /// Index of the parameter `sensor.NAME.offset`; the gain follows it.
    pub first_parameter: usize,
    pub place: Place,
}

/// Share of a sensor's noise that model and sensor may differ by throughout a phase where the rig file says nothing:
/// neither laws nor calibrations are trusted beyond a tenth of what one sample shows.
pub const TOLERANCE: f64 = 0.1;

/// What calibration starts from for an offset, in standard deviations of a sample's noise: makers trim to what they can see.
pub const OFFSET_SPREAD: f64 = 1.0;
/// What calibration starts from for a gain: class 0.3 of industrial transducers.
pub const GAIN_SPREAD: f64 = 0.003;

impl Sensor {
    /// Variance of one sample by noise, rounding and lack of fit, SI squared.
    pub fn variance(&self) -> f64 {
        self.noise * self.noise + self.resolution * self.resolution / 12.0 + self.lack_of_fit * self.lack_of_fit
    }

    /// Whether a parameter is its offset or its gain.
    pub fn owns(&self, parameter: usize) -> bool {
        (self.first_parameter..self.first_parameter + 2).contains(&parameter)
    }

    /// What moves its readings in a column although what it reads stands still; where the rig file gives no resolution, that
    /// of the column counts.
    pub fn scatter(&self, channel: &Channel) -> Scatter {
        let resolution = if self.resolution > 0.0 { self.resolution } else { channel.last_digit() };
        Scatter { noise: self.noise, resolution }
    }
}

impl super::Rig {
    /// Adds a virtual sensor behind all others: it reads a quantity as it is, and no record has a column of it. Says whether it
    /// could; a rig without any sensor has nothing to make one after.
    pub fn watch(&mut self, target: Target, quantity: Quantity) -> bool {
        let Some(template) = self.sensors.first().cloned() else { return false };
        let first_parameter = self.parameters.len();
        // Offset and gain.
        for value in [0.0, 1.0] {
            let mut parameter = self.parameters[template.first_parameter].clone();
            (parameter.value, parameter.sigma) = (value, 0.0);
            self.parameters.push(parameter);
        }
        let dimension = quantity.dimension().unwrap_or(template.dimension);
        self.sensors.push(Sensor { quantity, dimension, target, lag: 0.0, first_parameter, ..template });
        true
    }

    /// Reads a record of this rig; the columns of scaled sensors and inputs come as what they stand for.
    ///
    /// # Errors
    /// As [`Record::read`].
    pub fn record(&self, path: impl AsRef<Path>) -> Result<Record, Complaint> {
        Ok(self.scaled(self.asked().read(path)?))
    }
}

/// What a row of an input column says about the time around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// The value acted over the interval before the row.
    Before,
    /// The value acts from the row to the next.
    After,
    /// The value runs straight from row to row.
    Linear,
}

impl Hold {
    pub const NAMED: &[(&str, Hold)] = &[("before", Hold::Before), ("after", Hold::After), ("linear", Hold::Linear)];
}

/// Where records tell the temperature of the fluid; one that does not has it at the reference.
#[derive(Debug, Clone)]
pub struct Temperature {
    pub input: Input,
    /// At which the fluid has the viscosity of the rig file, K.
    pub reference: f64,
}

/// A recorded signal that drives components.
#[derive(Debug, Clone)]
pub struct Input {
    pub name: String,
    pub column: String,
    pub unit: Unit,
    /// What the column holds in place of the quantity.
    pub scale: Option<Scaling>,
    pub hold: Hold,
    /// One standard deviation of the noise of a sample, SI; 0 for a command.
    pub noise: f64,
    /// By how much later than its column says it acts, as an index among the parameters; `None` where the rig file says nothing of it.
    pub dead_time: Option<usize>,
    pub place: Place,
}
