//! What a residual reads: measured channels, their values and time derivatives, and the sensors behind them.

use crate::numeric::Real;
use crate::rig::{Quantity, Rig, Target};

/// The column behind a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Index of a sensor of the rig.
    Sensor(usize),
    /// Index of an input of the rig.
    Input(usize),
}

/// One number that a residual is computed from: a channel (order 0) or its time derivative (order 1 or 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    pub source: Source,
    /// 0 for the value, 1 for its rate, 2 for its second derivative.
    pub order: usize,
}

impl Reading {
    /// The true quantity behind a reading, in SI: offset and gain of its sensor taken off.
    pub(super) fn corrected<T: Real>(self, rig: &Rig, parameters: &[T], shown: T) -> T {
        let Source::Sensor(sensor) = self.source else { return shown };
        let first = rig.sensors[sensor].first_parameter;
        let unbiased = if self.order == 0 { shown - parameters[first] } else { shown };
        unbiased / parameters[first + 1]
    }

    /// One standard deviation of what rounding may do to every sample alike, SI: resolution/√12; 0 for derivatives.
    pub(super) fn systematic(self, rig: &Rig) -> f64 {
        match self.source {
            Source::Sensor(sensor) if self.order == 0 => rig.sensors[sensor].resolution / 12.0_f64.sqrt(),
            _ => 0.0,
        }
    }
}

impl Source {
    /// Variance of one sample, SI squared.
    pub(super) fn variance(self, rig: &Rig) -> f64 {
        match self {
            Source::Sensor(sensor) => rig.sensors[sensor].variance(),
            Source::Input(input) => rig.inputs[input].noise * rig.inputs[input].noise,
        }
    }

    /// Time constant of the sensor, s.
    pub(super) fn lag(self, rig: &Rig) -> f64 {
        match self {
            Source::Sensor(sensor) => rig.sensors[sensor].lag,
            Source::Input(_) => 0.0,
        }
    }
}

/// Collects readings, each once.
#[derive(Debug, Clone, Default)]
pub(super) struct Readings(pub Vec<Reading>);

impl Readings {
    pub fn take(&mut self, source: Source, order: usize) -> usize {
        let wanted = Reading { source, order };
        self.0.iter().position(|reading| *reading == wanted).unwrap_or_else(|| {
            self.0.push(wanted);
            self.0.len() - 1
        })
    }

    /// Reading of a node's quantity, if a sensor there gives it.
    pub fn node(&mut self, rig: &Rig, node: usize, quantity: Quantity, order: usize) -> Option<usize> {
        let sensor =
            rig.sensors.iter().position(|sensor| sensor.target == Target::Node(node) && sensor.quantity == quantity)?;
        Some(self.take(Source::Sensor(sensor), order))
    }

    /// Reading of a state of a component, if a sensor gives it.
    pub fn state(&mut self, rig: &Rig, component: usize, state: usize) -> Option<usize> {
        let sensor = rig.sensors.iter().position(|sensor| sensor.target == Target::State(component, state))?;
        Some(self.take(Source::Sensor(sensor), 0))
    }

    /// Reading of the flow at a port and the sign that makes it positive into the port.
    pub fn port(&mut self, rig: &Rig, component: usize, port: usize) -> Option<(usize, f64)> {
        let sensor = rig
            .sensors
            .iter()
            .position(|sensor| sensor.target == Target::Port(component, port) && sensor.quantity == Quantity::Flow)?;
        Some((self.take(Source::Sensor(sensor), 0), rig.sensors[sensor].sign))
    }
}
