//! Several healthy records of one rig as one least-squares problem.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::diagnosis::noise::Weights;
use crate::diagnosis::problem::{Estimated, away, root_mean_square};
use crate::estimation::{
    Fit, FitError, Gaussian, Linearised, LocalModel, Loss, Options, Part, Problem, Series, Shared, fit_along,
};
use crate::model::{InputSignals, Model, SimulationError};
use crate::record::Record;

/// A healthy record with what drives it.
pub(super) struct Healthy<'a> {
    pub record: &'a Record,
    pub drive: InputSignals,
    /// `[sensor][row]`, SI.
    pub measured: Vec<&'a [f64]>,
}

/// What the sensors read: `[record][sensor][row]`, SI.
pub(super) type Curves = Vec<Vec<Vec<f64>>>;

/// Derivatives of the curves: `[record][parameter][sensor][row]`, and where they were taken.
struct Slopes {
    at: Vec<f64>,
    by: Vec<Vec<Vec<Vec<f64>>>>,
}

#[derive(Default)]
struct Known {
    curves: Option<(Vec<f64>, Arc<Curves>)>,
    slopes: Option<Arc<Slopes>>,
    simulations: u64,
    sensitivities: u64,
}

/// The model's answers to all records. Noise and tolerance do not enter here, so that one answer serves many weights.
pub(super) struct Solutions<'a> {
    pub model: &'a Model,
    pub records: &'a [Healthy<'a>],
    pub estimated: Vec<Estimated>,
    /// The record that an estimated parameter is of; `None` of those that all records share, which come first.
    of_record: Vec<Option<usize>>,
    /// All parameters of the rig; the estimated ones are replaced.
    base: Vec<f64>,
    /// Of each estimated parameter: the sensor whose offset (false) or gain (true) it is.
    of_sensor: Vec<Option<(usize, bool)>>,
    known: Mutex<Known>,
}

impl<'a> Solutions<'a> {
    /// With what the rig has otherwise in each record as an estimated parameter of that record.
    pub fn new(model: &'a Model, records: &'a [Healthy<'a>], open: Vec<Estimated>) -> Self {
        let rig = &model.rig;
        let (of_one, mut estimated): (Vec<_>, Vec<_>) =
            open.into_iter().partition(|one| rig.is_of_record(one.parameter));
        let mut of_record = vec![None; estimated.len()];
        for record in 0..records.len() {
            estimated.extend(of_one.iter().cloned());
            of_record.resize(estimated.len(), Some(record));
        }
        let of_sensor = |estimated: &Estimated| {
            rig.sensors.iter().enumerate().find_map(|(index, sensor)| {
                let place = estimated.parameter.checked_sub(sensor.first_parameter)?;
                (place < 2).then_some((index, place == 1))
            })
        };
        Self {
            of_sensor: estimated.iter().map(of_sensor).collect(),
            base: rig.nominal(),
            known: Mutex::default(),
            model,
            records,
            estimated,
            of_record,
        }
    }

    /// How many estimated parameters all records share; they come first.
    pub fn shared(&self) -> usize {
        self.of_record.iter().filter(|record| record.is_none()).count()
    }

    /// Estimated parameters that all records share and no sensor has alone.
    pub fn of_machine(&self) -> impl Iterator<Item = usize> {
        (0..self.shared()).filter(|&index| self.of_sensor[index].is_none())
    }

    /// Parameters that each record has of its own, with the mean over the records.
    pub fn means_of_records(&self, theta: &[f64]) -> Vec<(usize, f64)> {
        let (shared, records) = (self.shared(), self.records.len());
        let own = (self.estimated.len() - shared) / records.max(1);
        let mean = |place: usize| {
            let values = theta[shared..].iter().skip(place).step_by(own);
            (self.estimated[shared + place].parameter, values.sum::<f64>() / records as f64)
        };
        (0..own).map(mean).collect()
    }

    /// What is estimated of a record, with its values.
    pub fn of(&self, theta: &[f64], record: usize) -> (Vec<Estimated>, Vec<f64>) {
        self.own(record).map(|index| (self.estimated[index].clone(), theta[index])).unzip()
    }

    /// Which estimated parameters a record has: those that all share, and its own.
    fn own(&self, record: usize) -> impl Iterator<Item = usize> {
        (0..self.estimated.len()).filter(move |&index| self.of_record[index].is_none_or(|of| of == record))
    }

    /// Solutions of the model so far: plain ones, and with derivatives.
    pub fn effort(&self) -> (u64, u64) {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        (known.simulations, known.sensitivities)
    }

    /// All parameters of the rig in a record.
    pub fn parameters(&self, theta: &[f64], record: usize) -> Vec<f64> {
        let mut parameters = self.base.clone();
        for index in self.own(record) {
            parameters[self.estimated[index].parameter] = theta[index];
        }
        parameters
    }

    pub fn curves(&self, theta: &[f64]) -> Result<Arc<Curves>, SimulationError> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((at, curves)) = &known.curves
            && at == theta
        {
            return Ok(curves.clone());
        }
        let curves = Arc::new(self.solved(theta)?);
        known.simulations += self.records.len() as u64;
        known.curves = Some((theta.to_vec(), curves.clone()));
        Ok(curves)
    }

    /// The same, solved again whatever is known.
    pub fn solved(&self, theta: &[f64]) -> Result<Curves, SimulationError> {
        let solve = |(record, one): (usize, &Healthy<'_>)| {
            let parameters = self.parameters(theta, record);
            Ok(self.model.solve(&parameters, &one.drive, &one.record.time)?.values)
        };
        // Records are independent, so threads change nothing but the time.
        self.records.par_iter().enumerate().map(solve).collect()
    }

    /// Root mean square of model minus measurement: `[record][sensor]`, SI.
    pub fn errors(&self, theta: &[f64]) -> Result<Vec<Vec<f64>>, SimulationError> {
        let curves = self.curves(theta)?;
        let error = |(curve, measured): (&Vec<f64>, &&[f64])| root_mean_square(curve, measured).unwrap_or(0.0);
        let of_record =
            |(one, curves): (&Healthy<'_>, &Vec<Vec<f64>>)| curves.iter().zip(&one.measured).map(error).collect();
        Ok(self.records.iter().zip(curves.iter()).map(of_record).collect())
    }

    fn slopes(&self, theta: &[f64]) -> Result<Arc<Slopes>, SimulationError> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(slopes) = &known.slopes {
            let share = self.model.rig.settings().calibration.moved_share;
            let moved = |((a, b), estimated): ((&f64, &f64), &Estimated)| (a - b).abs() > share * estimated.scale;
            if !slopes.at.iter().zip(theta).zip(&self.estimated).any(moved) {
                return Ok(slopes.clone());
            }
        }
        let mut by = Vec::new();
        for (record, one) in self.records.iter().enumerate() {
            let inside: Vec<usize> = self.inside(record).map(|index| self.estimated[index].parameter).collect();
            let parameters = self.parameters(theta, record);
            by.push(self.model.sensitivities(&parameters, &inside, &one.drive, &one.record.time)?.derivatives);
        }
        let slopes = Arc::new(Slopes { at: theta.to_vec(), by });
        known.sensitivities += self.records.len() as u64;
        known.slopes = Some(slopes.clone());
        Ok(slopes)
    }

    /// Estimated parameters of a record that need an integration: offsets and gains of sensors act on the finished reading, but where the
    /// circuit starts as the sensor shows.
    fn inside(&self, record: usize) -> impl Iterator<Item = usize> {
        self.own(record).filter(move |&index| self.by_reading(index, record).is_none())
    }

    /// The sensor whose offset (false) or gain (true) an estimated parameter is, if it does nothing but to the finished reading.
    fn by_reading(&self, index: usize, record: usize) -> Option<(usize, bool)> {
        self.of_sensor[index].filter(|&(sensor, _)| !self.records[record].drive.starts_by(sensor))
    }

    /// Model minus measurement of one record, SI, one sensor after the other.
    pub fn misfit(&self, curves: &Curves, record: usize) -> Vec<f64> {
        away(&curves[record], &self.records[record].measured)
    }

    /// Derivatives of [`Solutions::misfit`], one column per estimated parameter, unweighted.
    pub fn columns(&self, theta: &[f64], record: usize) -> Result<DMatrix<f64>, SimulationError> {
        let curves = self.curves(theta)?;
        let slopes = self.slopes(theta)?;
        let parameters = self.parameters(theta, record);
        let rows = self.records[record].record.time.len();
        let mut columns = DMatrix::zeros(rows * self.model.rig.sensors.len(), theta.len());
        for (index, mut column) in columns.column_iter_mut().enumerate() {
            let Some((sensor, is_gain)) = self.by_reading(index, record) else { continue };
            let first = self.model.rig.sensors[sensor].first_parameter;
            let (offset, gain) = (parameters[first], parameters[first + 1]);
            for (slot, value) in column.iter_mut().skip(sensor * rows).zip(&curves[record][sensor]) {
                *slot = if is_gain { (value - offset) / gain } else { 1.0 };
            }
        }
        for (index, derivative) in self.inside(record).zip(&slopes.by[record]) {
            for (slot, derivative) in columns.column_mut(index).iter_mut().zip(derivative.iter().flatten()) {
                *slot = *derivative;
            }
        }
        Ok(columns)
    }
}

/// All records as one problem: the misfits of one record after the other, weighted.
pub(super) struct Joint<'a> {
    pub solutions: &'a Solutions<'a>,
    /// One per record.
    pub weights: Vec<Weights>,
    pub prior: &'a Gaussian,
    pub bounds: Vec<(f64, f64)>,
    /// Factors on the misfits that keep outliers from pulling, as found at the start; empty for ones.
    pub robust: Vec<f64>,
    local: Mutex<Option<Arc<LocalModel>>>,
}

impl<'a> Joint<'a> {
    pub fn new(solutions: &'a Solutions<'a>, weights: Vec<Weights>, prior: &'a Gaussian) -> Self {
        let bounds = solutions.estimated.iter().map(|one| one.bounds).collect();
        Self { solutions, weights, prior, bounds, robust: Vec::new(), local: Mutex::default() }
    }

    /// The same with robust factors: those of a loss at the misfits of `theta`.
    pub fn robust(mut self, theta: &[f64], loss: Loss) -> Result<Self, SimulationError> {
        self.robust = self.weighted(theta)?.iter().map(|&r| loss.weight(r).sqrt()).collect();
        Ok(self)
    }

    /// Keeps the search within so many standard deviations of what was known before.
    pub fn confine(&mut self, reach: f64) {
        for ((bounds, mean), sigma) in self.bounds.iter_mut().zip(&self.prior.mean).zip(&self.prior.sigma) {
            *bounds = (bounds.0.max(mean - reach * sigma), bounds.1.min(mean + reach * sigma));
        }
    }

    /// Misfits of the records, without robust factors.
    fn weighted(&self, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        let curves = self.solutions.curves(theta)?;
        let mut all = Vec::new();
        for (record, weights) in self.weights.iter().enumerate() {
            let mut misfit = self.solutions.misfit(&curves, record);
            weights.apply(&mut misfit);
            all.append(&mut misfit);
        }
        Ok(all)
    }

    /// Misfits of the records and their derivatives, without robust factors.
    fn records(&self, theta: &[f64]) -> Result<Linearised, SimulationError> {
        let misfit = self.weighted(theta)?;
        let mut jacobian = DMatrix::zeros(misfit.len(), theta.len());
        let mut first = 0;
        for (record, weights) in self.weights.iter().enumerate() {
            let mut columns = self.solutions.columns(theta, record)?;
            weights.apply_to_columns(&mut columns);
            jacobian.rows_mut(first, columns.nrows()).copy_from(&columns);
            first += columns.nrows();
        }
        Ok(Linearised { misfit, jacobian })
    }

    /// The same with what the data sheet says as further rows.
    pub fn whole(&self, theta: &[f64]) -> Result<Linearised, SimulationError> {
        let Linearised { mut misfit, jacobian } = self.records(theta)?;
        misfit.extend(self.prior.misfit(theta).iter());
        let known = self.prior.jacobian(theta.len());
        let first = jacobian.nrows();
        let mut jacobian = jacobian.resize_vertically(first + known.nrows(), 0.0);
        jacobian.rows_mut(first, known.nrows()).copy_from(&known);
        Ok(Linearised { misfit, jacobian })
    }

    /// The local model near `theta`, kept for the life of the problem: each round has a new one.
    fn local_model(&self, theta: &[f64]) -> Result<Arc<LocalModel>, FitError> {
        let mut kept = self.local.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(local) = &*kept {
            return Ok(local.clone());
        }
        let local = Arc::new(LocalModel::at(self, theta, Loss::None)?);
        *kept = Some(local.clone());
        Ok(local)
    }

    /// Fits from `start` along the derivatives from there.
    pub fn fit(&self, start: &[f64], options: Options) -> Result<Fit, FitError> {
        let local = self.local_model(start)?;
        fit_along(self, &local, start, options)
    }

    /// Whether no parameter has moved by more than so many standard errors (for white misfits).
    pub fn within(&self, now: &[f64], before: &[f64], errors: f64) -> Result<bool, FitError> {
        let covariance = self.covariance(now)?;
        let moved = now.iter().zip(before).enumerate();
        Ok(moved.into_iter().all(|(i, (now, before))| (now - before).abs() <= errors * covariance[(i, i)].sqrt()))
    }

    /// Covariance of the parameters near `theta` for white misfits, SI: that of the local model, bounds ignored. The prior
    /// bounds every direction.
    pub fn covariance(&self, theta: &[f64]) -> Result<DMatrix<f64>, FitError> {
        let local = self.local_model(theta)?;
        let scaled = local.information(self)?.covariance();
        Ok(DMatrix::from_fn(theta.len(), theta.len(), |i, j| scaled[(i, j)] * local.scale[i] * local.scale[j]))
    }
}

/// Sensor by sensor, record by record.
impl Series for Joint<'_> {
    fn parts(&self) -> Vec<Part> {
        let mut first = 0;
        let one = |(&shared, measured): (&Shared, &&[f64])| {
            let rows = first..first + measured.len();
            first = rows.end;
            Part { rows, shared }
        };
        let of_records = self.weights.iter().zip(self.solutions.records);
        of_records.flat_map(|(weights, one)| weights.shared.iter().zip(&one.measured)).map(one).collect()
    }

    fn leave_own(&self, column: &mut [f64]) {
        let mut rest = column;
        for weights in &self.weights {
            let (of_record, after) = rest.split_at_mut(weights.rows() * weights.sensors());
            weights.leave_own(of_record);
            rest = after;
        }
    }
}

impl Problem for Joint<'_> {
    type Error = SimulationError;

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn misfit(&self, theta: &[f64]) -> Result<Vec<f64>, SimulationError> {
        let mut misfit = self.weighted(theta)?;
        misfit.iter_mut().zip(&self.robust).for_each(|(slot, factor)| *slot *= factor);
        Ok(misfit)
    }

    fn linearise(&self, theta: &[f64]) -> Result<Linearised, SimulationError> {
        let Linearised { mut misfit, mut jacobian } = self.records(theta)?;
        misfit.iter_mut().zip(&self.robust).for_each(|(slot, factor)| *slot *= factor);
        for mut column in jacobian.column_iter_mut() {
            column.iter_mut().zip(&self.robust).for_each(|(slot, factor)| *slot *= factor);
        }
        Ok(Linearised { misfit, jacobian })
    }

    fn scale(&self) -> Vec<f64> {
        self.solutions.estimated.iter().map(|estimated| estimated.scale).collect()
    }

    fn prior(&self) -> Option<&Gaussian> {
        Some(self.prior)
    }

    fn name(&self, parameter: usize) -> String {
        self.solutions.model.rig.parameters[self.solutions.estimated[parameter].parameter].id.clone()
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::calibration::{open, taken};
    use crate::rig::Rig;
    use crate::simulation::{SimulationOptions, simulate};

    #[test]
    fn a_sensor_that_tells_where_the_circuit_starts_moves_the_whole_run() {
        let text = std::fs::read_to_string("fixtures/accumulator/rig.toml").unwrap();
        let given = Model::new(Rig::parse("rig.toml", text.clone()).unwrap());
        let record = simulate(&given, None, &SimulationOptions::default()).unwrap().record;
        let by_record = text.replacen("H = { initial = \"100 bar\" }", "H = {}", 1);
        let model = Model::new(Rig::parse("rig.toml", by_record).unwrap());
        let healthy = taken(&model.rig, [&record]).unwrap();
        let solutions = Solutions::new(&model, &healthy, open(&model.rig));
        let mut theta: Vec<f64> =
            solutions.estimated.iter().map(|one| model.rig.parameters[one.parameter].value).collect();
        let columns = solutions.columns(&theta, 0).unwrap();
        let rows = record.time.len();
        let sensor = |name: &str| model.rig.sensors.iter().position(|sensor| sensor.name == name).unwrap();
        for (id, step) in [("sensor.p_H.gain", 1e-3), ("sensor.p_H.offset", 1e4), ("sensor.p_P.gain", 1e-3)] {
            let index =
                solutions.estimated.iter().position(|one| model.rig.parameters[one.parameter].id == id).unwrap();
            let at = theta[index];
            let mut run = |value: f64| {
                theta[index] = value;
                solutions.solved(&theta).unwrap().remove(0)
            };
            let [more, less] = [run(at + step), run(at - step)];
            theta[index] = at;
            for (name, row) in [("p_H", 50), ("p_H", 150), ("q_1", 150), ("p_P", 90)] {
                let by_difference = (more[sensor(name)][row] - less[sensor(name)][row]) / (2.0 * step);
                let unit = if name.starts_with('p') { 1e5 } else { 1e-4 };
                let exact = columns[(sensor(name) * rows + row, index)];
                let scale = step / unit;
                assert_relative_eq!(exact * scale, by_difference * scale, epsilon = 3e-4, max_relative = 0.02);
            }
        }
        // Half a per cent more of the gain is half a bar less in the accumulator, and less flow from it.
        let gain =
            solutions.estimated.iter().position(|one| model.rig.parameters[one.parameter].id == "sensor.p_H.gain");
        assert!(columns[(sensor("q_1") * rows + 150, gain.unwrap())] < 0.0);
    }
}
