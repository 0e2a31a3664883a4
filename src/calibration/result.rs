//! From the last fit to the calibrated rig and what is told of it.

use nalgebra::DMatrix;

use super::Given;
use super::along::along;
use super::clusters;
use super::joint::Joint;
use super::noise::Noise;
use super::principal::{self, Sources};
use super::report::{
    CalibratedDynamics, CalibratedParameter, CalibratedSensor, CalibrationReport, ChannelFit, RecordFit, SCHEMA,
};
use super::rounds::{Rounds, Settled};
use crate::diagnosis::problem::count_there;
use crate::diagnosis::{adequate, tame_squares};
use crate::estimation::{Fit, FitError, LocalModel, Loss, Series};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::{Calibration, NEVER_KNOWN, Rig};

/// Digits of a reported number.
const DIGITS: usize = 7;
/// Share that is taken from all correlations where rounding has spoilt them; the least eigenvalue that counts as none.
const SHRINK: f64 = 1e-6;
const SPOILT: f64 = 1e-8;

/// The nearest matrix with a unit diagonal, eight digits and positive eigenvalues.
fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let size = covariance.diagonal().map(f64::sqrt);
    let mut kept = 1.0;
    loop {
        let one = |i: usize, j: usize| {
            let r = kept * covariance[(i, j)] / (size[i] * size[j]);
            if i == j { 1.0 } else { (r * 1e8).round() / 1e8 }
        };
        let rounded = DMatrix::from_fn(size.len(), size.len(), one);
        let least = DMatrix::symmetric_eigenvalues(&rounded).min();
        if size.is_empty() || least > SPOILT || kept < 0.5 {
            return rounded;
        }
        kept *= 1.0 - SHRINK;
    }
}

/// What was found of how spools follow, of mean lags and of dead times. `sheet` is the rig before.
pub(super) fn dynamics(sheet: &Rig, calibrated: &Rig) -> Vec<CalibratedDynamics> {
    let found = calibrated.calibration.iter().flat_map(|calibration| &calibration.dynamics);
    let one = |&index: &usize| {
        let (known, found) = (&sheet.parameters[index], &calibrated.parameters[index]);
        let value = |si| rounded(known.unit.from_si(si), DIGITS);
        CalibratedDynamics {
            id: known.id.clone(),
            meaning: known.meaning.clone(),
            unit: known.unit.symbol.clone(),
            before: value(known.value),
            after: value(found.value),
        }
    };
    found.map(one).collect()
}

impl Rounds<'_> {
    /// The calibrated rig and the report. `sheet` is the rig as given.
    pub fn finish(
        self,
        (sheet, given): (&Rig, Given),
        records: &[Record],
        Settled { mut fit, weights, rounds, settled }: Settled,
    ) -> Result<(Rig, CalibrationReport), FitError> {
        let loss = Loss::Huber { k: sheet.settings().calibration.huber_width };
        let joint = self.joint(weights, &fit.theta, loss)?;
        let whole = joint.whole(&fit.theta)?;
        let white = joint.covariance(&fit.theta)?;
        let clustered = clusters::covariance(&joint, &whole, loss, &white);
        let local = LocalModel::of(&joint, &fit.theta, whole, loss)?;
        let before = &self.prior.sigma;
        let along = along(&joint, &fit.theta, &white);
        let mut covariance = principal::covariance(&Sources {
            along: &along,
            clustered: &clustered,
            sheet: before,
            local: &local,
            series: &joint,
        });
        for (i, before) in before.iter().enumerate() {
            covariance[(i, i)] += (NEVER_KNOWN * before).powi(2);
        }
        // Oil is as warm as it is: what the records say of its viscosity says little of that in the next one.
        for (i, one) in joint.solutions.estimated[..joint.solutions.shared()].iter().enumerate() {
            if sheet.is_viscosity(one.parameter) {
                covariance[(i, i)] += before[i].powi(2);
            }
        }
        fit.misfit = local.misfit;
        if self.rig.sensors.iter().any(|sensor| sensor.lack_of_fit > 0.0) {
            fit.misfit = self.judged(&fit.theta)?;
        }
        // Nothing takes more from what the records say than all of it.
        let sigma: Vec<f64> =
            before.iter().enumerate().map(|(i, before)| covariance[(i, i)].sqrt().min(*before)).collect();
        let mut rig = sheet.clone();
        let shared = joint.solutions.shared();
        let mut parameters: Vec<usize> = joint.solutions.estimated[..shared].iter().map(|one| one.parameter).collect();
        for (i, &index) in parameters.iter().enumerate() {
            let parameter = &mut rig.parameters[index];
            (parameter.value, parameter.sigma) = (fit.theta[i], sigma[i]);
            if let Some(fault) = rig.faults.iter_mut().find(|fault| fault.parameter == index) {
                fault.healthy = fit.theta[i];
            }
        }
        // What each record has of its own is as uncertain as it was: the next record has its own again.
        for (parameter, mean) in joint.solutions.means_of_records(&fit.theta) {
            // What no record knows of the next one is stated, and the mean of a few says nothing of it.
            if rig.parameters[parameter].role.is_of_record() {
                continue;
            }
            rig.parameters[parameter].value = mean;
            parameters.push(parameter);
        }
        for (sensor, found) in rig.sensors.iter_mut().zip(&self.rig.sensors) {
            (sensor.noise, sensor.stated_noise, sensor.tolerance) = (found.noise, found.noise, found.tolerance);
        }
        let names = records.iter().map(|record| record.path.display().to_string()).collect();
        let Given { margins, dynamics } = given;
        let mut correlation = correlation(&covariance.view((0, 0), (shared, shared)).into_owned());
        correlation = correlation.resize(parameters.len(), parameters.len(), 0.0);
        (shared..parameters.len()).for_each(|own| correlation[(own, own)] = 1.0);
        rig.calibration = Some(Calibration { records: names, margins, dynamics, parameters, correlation });
        let mut report = self.report(sheet, &rig, &fit, &joint);
        (report.rounds, report.settled) = (rounds, settled);
        if !settled {
            let still = format!(
                "noise, tolerance or values still moved after {rounds} rounds: the records may say too little of them"
            );
            report.warnings.push(still);
        }
        Ok((rig, report))
    }

    fn report(&self, sheet: &Rig, rig: &Rig, fit: &Fit, joint: &Joint<'_>) -> CalibrationReport {
        let mut parameters = Vec::new();
        let mut warnings = Vec::new();
        for (i, one) in self.solutions.estimated[..self.solutions.shared()].iter().enumerate() {
            let (known, found) = (&sheet.parameters[one.parameter], &rig.parameters[one.parameter]);
            let unit = &known.unit;
            let (value, spread) =
                (|si| rounded(unit.from_si(si), DIGITS), |si| rounded(unit.difference_from_si(si), DIGITS));
            let (before, sigma_before) = (self.prior.mean[i], self.prior.sigma[i]);
            let away = (found.value - before) / sigma_before;
            if away.abs() > rig.settings().calibration.implausible_deviations {
                let at_end = fit.theta[i] <= one.bounds.0 || fit.theta[i] >= one.bounds.1;
                warnings.push(format!(
                    "`{}` came out at {}, {:.1} standard deviations {}{}",
                    known.id,
                    shown(value(found.value), &unit.symbol),
                    away.abs(),
                    if rig.is_margin(one.parameter) {
                        "of what a healthy circuit has".to_owned()
                    } else {
                        format!("from the data sheet's {}", shown(value(before), &unit.symbol))
                    },
                    if at_end {
                        ", the end of its search: does the model have the physics of the rig?"
                    } else {
                        ": is the rig healthy?"
                    }
                ));
            }
            parameters.push(CalibratedParameter {
                id: known.id.clone(),
                meaning: known.meaning.clone(),
                unit: unit.symbol.clone(),
                before: value(before),
                sigma_before: spread(sigma_before),
                after: value(found.value),
                sigma_after: spread(found.sigma),
                informed: found.sigma < rig.settings().calibration.informed_share * sigma_before,
                fault: sheet.is_fault(one.parameter),
            });
        }
        let (mut sensors, mut loose) = (Vec::new(), Vec::new());
        for (index, (before, after)) in sheet.sensors.iter().zip(&rig.sensors).enumerate() {
            let unit = sheet.sensor_unit(before);
            let spread = |si| rounded(unit.difference_from_si(si), DIGITS);
            if after.tolerance > rig.settings().calibration.coarse_tolerance * before.tolerance
                && after.tolerance > after.noise
            {
                loose.push(format!("`{}` {}", after.name, shown(spread(after.tolerance), &unit.symbol)));
            }
            sensors.push(CalibratedSensor {
                name: before.name.clone(),
                unit: unit.symbol.clone(),
                noise_before: spread(before.noise),
                noise: spread(after.noise),
                noise_correlation: self.noises[index].map(|noise: Noise| rounded(noise.correlation, 3)),
                tolerance_before: spread(before.tolerance),
                tolerance: spread(after.tolerance),
            });
        }
        if !loose.is_empty() {
            warnings.push(format!(
                "throughout a phase the model follows its sensors no better than this, more than the noise of a sample: {}; \
                 something is missing in the model, or the rig is not healthy",
                loose.join(", ")
            ));
        }
        let records = self.records(sheet, fit, joint, &mut warnings);
        let samples = self.solutions.records.iter().map(|one| one.record.time.len() * sensors.len()).sum::<usize>();
        let total: f64 = records.iter().map(|record| record.chi2_reduced * (record.rows * sensors.len()) as f64).sum();
        let (simulations, sensitivities) = self.solutions.effort();
        CalibrationReport {
            schema: SCHEMA,
            rig: sheet.path.display().to_string(),
            adequate: records.iter().all(|record| record.channels.iter().all(|channel| channel.adequate)),
            parameters,
            sensors,
            records,
            warnings,
            chi2_reduced: rounded(total / samples.max(1) as f64, DIGITS),
            dynamics: Vec::new(),
            rounds: 0,
            settled: false,
            solves: simulations + sensitivities,
        }
    }

    fn records(&self, sheet: &Rig, fit: &Fit, joint: &Joint<'_>, warnings: &mut Vec<String>) -> Vec<RecordFit> {
        let plain = self.solutions.errors(&fit.theta).ok();
        let mut series = joint.parts().into_iter().map(|part| part.rows);
        let mut records = Vec::new();
        for (record, one) in self.solutions.records.iter().enumerate() {
            let name = one.record.path.display().to_string();
            let (mut channels, mut missed, mut steep) = (Vec::new(), Vec::new(), Vec::new());
            for (sensor, (known, range)) in sheet.sensors.iter().zip(series.by_ref()).enumerate() {
                let samples = count_there(one.measured[sensor]).max(1);
                let chi2 = tame_squares(&sheet.settings().diagnosis, &fit.misfit[range]) / samples as f64;
                let after = plain.as_ref().map_or(f64::NAN, |errors| errors[record][sensor]);
                let unit = sheet.sensor_unit(known);
                let error = |si| rounded(unit.difference_from_si(si), DIGITS);
                let adequate = adequate(&sheet.settings().diagnosis, chi2, samples);
                let found = &self.rig.sensors[sensor];
                if !adequate {
                    missed.push(format!("`{}` {:.1}", known.name, chi2));
                } else if after > sheet.settings().calibration.plain_error * found.noise.hypot(found.tolerance) {
                    steep.push(format!(
                        "`{}` {}",
                        known.name,
                        shown(rounded(unit.difference_from_si(after), 3), &unit.symbol)
                    ));
                }
                channels.push(ChannelFit {
                    name: known.name.clone(),
                    unit: unit.symbol.clone(),
                    rmse_before: error(self.before[record][sensor]),
                    rmse: error(after),
                    chi2_reduced: rounded(chi2, DIGITS),
                    adequate,
                });
            }
            if !missed.is_empty() {
                warnings.push(format!(
                    "{name}: the calibrated model does not explain {} (mean square of the weighted misfit): is it a record of \
                     the healthy rig?",
                    missed.join(", ")
                ));
            }
            if !steep.is_empty() {
                warnings.push(format!(
                    "{name}: measured minus model is {} (root mean square), where the record is steep and counts for little: dead times, lags \
                     or masses of spools may be other than stated, or the fit ended in a wrong valley; `compare` shows when it is missed",
                    steep.join(", ")
                ));
            }
            let mean = channels.iter().map(|channel| channel.chi2_reduced).sum::<f64>() / channels.len().max(1) as f64;
            records.push(RecordFit {
                record: name,
                rows: one.record.time.len(),
                chi2_reduced: rounded(mean, DIGITS),
                channels,
            });
        }
        records
    }
}

fn shown(value: f64, unit: &str) -> String {
    crate::number::with_unit(value, unit)
}
