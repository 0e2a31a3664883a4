//! Which faults a residual feels, and how strongly, at the operating points of a record.

use super::frame;
use super::generator::{Gate, Generator, along, healthy};
use crate::complaint::Complaint;
use crate::model::Drive;
use crate::record::Record;
use crate::rig::Rig;

/// How a residual answers to one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// `component.parameter` or `sensor.NAME.offset`.
    pub parameter: String,
    /// Change of the residual per change of the parameter from its healthy value, SI per SI, other measurements unchanged.
    pub slope: f64,
    /// Change of the residual, SI, when the parameter goes to the end of its range that lies farther from healthy; for a
    /// sensor, an offset of one standard deviation of its noise, or 1 % of gain.
    pub at_limit: f64,
}

impl Generator {
    /// Answers to every fault of the rig and every sensor's offset and gain, in this order.
    ///
    /// The law gives what the healthy component would do at the measured quantities, so a parameter that enters it moves
    /// the residual by minus what it moves the law; a parameter that does not enter has exactly 0. The mean over the
    /// windows of the record that count.
    ///
    /// # Errors
    /// A column that the record lacks or has in another dimension.
    pub fn signature(
        &self,
        rig: &Rig,
        record: &Record,
        drive: &Drive,
        window: f64,
    ) -> Result<Vec<Sensitivity>, Complaint> {
        let frames = frame::blocks(rig, record, drive, &self.sources(), window)?;
        let gates = self.blocks(rig, record, drive, window)?.gate;
        let points: Vec<Vec<f64>> = frames
            .iter()
            .zip(&gates)
            .filter(|(_, gate)| **gate == Gate::Open)
            .map(|(frame, _)| self.shown(frame))
            .collect();
        let nominal = healthy(rig);
        let faults = rig.faults.iter().map(|fault| {
            let (low, high) = (fault.bounds.0 - fault.healthy, fault.bounds.1 - fault.healthy);
            (fault.parameter, if high.abs() >= low.abs() { high } else { low })
        });
        let sensors = rig
            .sensors
            .iter()
            .flat_map(|sensor| [(sensor.first_parameter, sensor.noise), (sensor.first_parameter + 1, 0.01)]);
        let answer = |(parameter, step): (usize, f64)| {
            let dual = along(&nominal, parameter);
            let mut moved = nominal.clone();
            moved[parameter] += step;
            let (mut slope, mut at_limit, mut count) = (0.0, 0.0, 0.0_f64);
            for shown in &points {
                let lifted: Vec<_> = shown.iter().map(|&value| crate::numeric::Dual::<f64, 1>::lift(value)).collect();
                let there = self.residual(rig, &moved, shown);
                if let (Some(here), Some(there)) = (self.residual(rig, &dual, &lifted), there) {
                    slope -= here.eps[0];
                    at_limit -= there - here.re;
                    count += 1.0;
                }
            }
            let count = count.max(1.0);
            let parameter = rig.parameters[parameter].id.clone();
            Sensitivity { parameter, slope: slope / count, at_limit: at_limit / count }
        };
        Ok(faults.chain(sensors).map(answer).collect())
    }
}
