//! Which faults a residual feels, and how strongly, at the operating points of a record.

use super::detect::{phase, phases, weighted};
use super::find::generators;
use super::frame;
use super::generator::{Gate, Generator, Series, Variant, along};
use super::known::Parameters;
use crate::complaint::Complaint;
use crate::model::InputSignals;
use crate::numeric::Dual;
use crate::record::Record;
use crate::rig::Rig;

/// How a residual answers to one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// `component.parameter` or `sensor.NAME.offset`.
    pub parameter: String,
    /// Index among the rig's parameters.
    pub index: usize,
    /// Change of the residual per change of the parameter from its healthy value, SI per SI, other measurements unchanged.
    pub slope: f64,
    /// Change of the parameter that `at_limit` speaks of, SI.
    pub step: f64,
    /// Change of the residual, SI, when the parameter goes to the end of its range that lies farther from healthy; for a
    /// sensor that is no fault of the rig, an offset of one standard deviation of its noise, or 1 % of gain.
    pub at_limit: f64,
}

/// What one residual feels in one phase of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Signature {
    pub generator: Generator,
    /// What the first directional valve does: `P-A`, `P-B` or `closed`; `all` in a rig without one.
    pub phase: &'static str,
    /// Windows that count.
    pub windows: usize,
    /// Standard deviation of one window by sensor noise, and of the mean over the phase, SI.
    pub sigma: f64,
    pub sigma_of_mean: f64,
    /// One standard deviation by uncertain parameters and rounding, SI, which averaging does not lower.
    pub tolerance: f64,
    /// Every fault of the rig, then offset and gain of every sensor that is none, in this order.
    pub answers: Vec<Sensitivity>,
}

/// The signature matrix: every corrected residual in every phase in which it has windows that count.
///
/// # Errors
/// A column that the record lacks or has in another dimension.
pub fn signatures(rig: &Rig, record: &Record, drive: &InputSignals, window: f64) -> Result<Vec<Signature>, Complaint> {
    let mut matrix = Vec::new();
    for generator in generators(rig).into_iter().filter(|generator| generator.variant == Variant::Corrected) {
        let series = generator.blocks(rig, record, drive, window)?;
        let points = generator.points(rig, record, drive, window)?;
        for &name in phases(rig) {
            let counts = |&at: &usize| series.gate[at] == Gate::Open && phase(rig, drive, series.time[at]) == name;
            let here: Vec<usize> = (0..series.time.len()).filter(counts).collect();
            let Some((_, sigma_of_mean, tolerance)) = weighted(&series, &here) else { continue };
            matrix.push(Signature {
                phase: name,
                windows: here.len(),
                sigma: sigma_of_mean * (here.len() as f64).sqrt(),
                sigma_of_mean,
                tolerance,
                answers: generator.answers(rig, &series, &points, &here),
                generator: generator.clone(),
            });
        }
    }
    Ok(matrix)
}

impl Generator {
    /// Answers to every fault of the rig and every other sensor's offset and gain, in this order.
    ///
    /// The law gives what the healthy component would do at the measured quantities, so a parameter that enters it moves
    /// the residual by minus what it moves the law; a parameter that does not enter has exactly 0. The mean over the
    /// windows of the record that count.
    ///
    /// # Errors
    /// A column that the record lacks or has in another dimension.
    #[cfg(feature = "internals")]
    pub fn signature(
        &self,
        rig: &Rig,
        record: &Record,
        drive: &InputSignals,
        window: f64,
    ) -> Result<Vec<Sensitivity>, Complaint> {
        let series = self.blocks(rig, record, drive, window)?;
        let open: Vec<usize> = (0..series.gate.len()).filter(|&at| series.gate[at] == Gate::Open).collect();
        Ok(self.answers(rig, &series, &self.points(rig, record, drive, window)?, &open))
    }

    /// Readings of every window, SI.
    fn points(
        &self,
        rig: &Rig,
        record: &Record,
        drive: &InputSignals,
        window: f64,
    ) -> Result<Vec<Vec<f64>>, Complaint> {
        let frames = frame::blocks(rig, record, drive, &self.sources(), window)?;
        Ok(frames.iter().map(|frame| self.shown(frame)).collect())
    }

    /// Mean answers over the windows `open`, weighed as the means of the residual are.
    fn answers(&self, rig: &Rig, series: &Series, points: &[Vec<f64>], open: &[usize]) -> Vec<Sensitivity> {
        let nominal = rig.healthy();
        let faults = rig.faults.iter().map(|fault| {
            let (low, high) = (fault.bounds.0 - fault.healthy, fault.bounds.1 - fault.healthy);
            (fault.parameter, if high.abs() >= low.abs() { high } else { low })
        });
        let sensors = rig
            .sensors
            .iter()
            .flat_map(|sensor| [(sensor.first_parameter, sensor.noise), (sensor.first_parameter + 1, 0.01)])
            .filter(|(parameter, _)| !rig.is_fault(*parameter));
        let answer = |(parameter, step): (usize, f64)| {
            let dual = Parameters::new(rig, along(&nominal, parameter));
            let mut moved = nominal.clone();
            moved[parameter] += step;
            let moved = Parameters::new(rig, moved);
            let (mut slope, mut at_limit, mut total) = (0.0, 0.0, 0.0_f64);
            for &at in open {
                let shown = &points[at];
                let lifted: Vec<_> = shown.iter().map(|&value| Dual::<f64, 1>::lift(value)).collect();
                let there = self.residual(rig, &moved, shown);
                if let (Some(here), Some(there)) = (self.residual(rig, &dual, &lifted), there) {
                    let weight = series.sigma[at].powi(-2);
                    slope -= weight * here.eps[0];
                    at_limit -= weight * (there - here.re);
                    total += weight;
                }
            }
            let mean = |sum: f64| if total > 0.0 { sum / total } else { 0.0 };
            let id = rig.parameters[parameter].id.clone();
            Sensitivity { parameter: id, index: parameter, slope: mean(slope), step, at_limit: mean(at_limit) }
        };
        faults.chain(sensors).map(answer).collect()
    }
}
