//! A record beside the model: gauges, and curves as a page draws them.

use serde::Serialize;

use crate::complaint::Complaint;
use crate::diagnosis::problem::{over_sensors, root_mean_square};
use crate::diagnosis::weighed;
use crate::model::{InputSignals, Model};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::Rig;

/// Digits of a number of a curve.
const DIGITS: usize = 6;
/// Samples for each pixel up to which they are sent as they are.
const DENSE: usize = 2;

/// A record with what the model says of it where the sliders stand.
#[derive(Debug)]
pub struct Trace {
    pub record: Record,
    drive: InputSignals,
    /// `[sensor][row]`, SI.
    outputs: Vec<Vec<f64>>,
    /// Whether the outputs are those of where the sliders stand.
    pub current: bool,
}

/// Root mean square of measured minus model over the noise: over all sensors, and of each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gauges {
    pub all: f64,
    pub sensors: Vec<Option<f64>>,
}

/// The curves of a sensor between two times, in its unit; the misfit is measured minus model over its noise.
///
/// Where there are more samples than pixels, each pixel has the least and then the largest of its samples, at its first and last time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorCurves {
    pub time: Vec<f64>,
    pub measured: Vec<Option<f64>>,
    pub model: Vec<Option<f64>>,
    pub misfit: Vec<Option<f64>>,
}

/// What a page asks to be drawn.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
pub struct Window {
    /// s; the whole record without.
    pub from: Option<f64>,
    pub to: Option<f64>,
    pub pixels: usize,
}

impl Trace {
    /// # Errors
    /// Columns that are missing.
    pub fn new(rig: &Rig, record: Record) -> Result<Self, Complaint> {
        let drive = InputSignals::from_record(rig, &record)?;
        weighed::measured(rig, &record)?;
        Ok(Self { record, drive, outputs: Vec::new(), current: false })
    }

    /// Reads again what drives a rig that has changed.
    ///
    /// # Errors
    /// Columns that are missing.
    pub fn renew(&mut self, rig: &Rig) -> Result<(), Complaint> {
        self.drive = InputSignals::from_record(rig, &self.record)?;
        Ok(())
    }

    /// Simulates the record with these values of all parameters, SI.
    ///
    /// # Errors
    /// A model that cannot be solved there; the outputs are as before.
    pub fn follow(&mut self, model: &Model, values: &[f64]) -> Result<(), Complaint> {
        let solved = model.solve(values, &self.drive, &self.record.time);
        self.outputs = solved.map_err(|error| model.unsolved(&error))?.values;
        self.current = true;
        Ok(())
    }

    /// # Errors
    /// Columns that are missing.
    pub fn gauges(&self, rig: &Rig) -> Result<Gauges, Complaint> {
        let measured = weighed::measured(rig, &self.record)?;
        let missed = self.outputs.iter().zip(measured).map(|(model, measured)| root_mean_square(model, measured));
        let times_noise = missed.zip(&rig.sensors).map(|(rms, sensor)| rms.map(|rms| rms / sensor.stated_noise));
        let sensors: Vec<Option<f64>> = times_noise.collect();
        let all = rounded(over_sensors(sensors.iter().copied()), DIGITS);
        Ok(Gauges { all, sensors: sensors.into_iter().map(|one| one.map(|one| rounded(one, DIGITS))).collect() })
    }

    /// The curves of every sensor.
    ///
    /// # Errors
    /// Columns that are missing.
    pub fn curves(&self, rig: &Rig, window: Window) -> Result<Vec<SensorCurves>, Complaint> {
        let time = &self.record.time;
        let from = window.from.map_or(0, |from| time.partition_point(|t| *t < from).saturating_sub(1));
        let to = window.to.map_or(time.len(), |to| (time.partition_point(|t| *t <= to) + 1).min(time.len()));
        let rows = from.min(to)..to;
        let pixels = window.pixels.clamp(50, 4000);
        let measured = weighed::measured(rig, &self.record)?;
        let each = rig.sensors.iter().zip(measured).zip(&self.outputs).map(|((sensor, measured), model)| {
            let unit = rig.sensor_unit(sensor);
            let bins: Vec<std::ops::Range<usize>> = if rows.len() <= DENSE * pixels {
                rows.clone().map(|row| row..row + 1).collect()
            } else {
                let edge = |bin: usize| rows.start + bin * rows.len() / pixels;
                (0..pixels).map(|bin| edge(bin)..edge(bin + 1)).collect()
            };
            let thin = |value: &dyn Fn(usize) -> f64| thinned(&bins, value);
            SensorCurves {
                time: bins.iter().flat_map(|bin| ends(bin).map(|row| rounded(time[row], 9))).collect(),
                measured: thin(&|row| unit.from_si(measured[row])),
                model: thin(&|row| unit.from_si(model[row])),
                misfit: thin(&|row| (measured[row] - model[row]) / sensor.stated_noise),
            }
        });
        Ok(each.collect())
    }
}

/// First and last row of a bin; of one row only that.
fn ends(bin: &std::ops::Range<usize>) -> impl Iterator<Item = usize> {
    std::iter::once(bin.start).chain((bin.len() > 1).then_some(bin.end - 1))
}

/// The least and the largest value of each bin; `None` where nothing was measured.
fn thinned(bins: &[std::ops::Range<usize>], value: &dyn Fn(usize) -> f64) -> Vec<Option<f64>> {
    let mut thin = Vec::with_capacity(2 * bins.len());
    for bin in bins {
        let there = || bin.clone().map(value).filter(|value| value.is_finite());
        let least = there().reduce(f64::min).map(|value| rounded(value, DIGITS));
        thin.push(least);
        if bin.len() > 1 {
            thin.push(there().reduce(f64::max).map(|value| rounded(value, DIGITS)));
        }
    }
    thin
}
