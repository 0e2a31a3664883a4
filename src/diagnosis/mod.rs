//! Detection, isolation and identification: what is wrong, how large, how sure.
//!
//! [`diagnose`] walks the whole way: residuals that fire ([`crate::residual`]), all faults and everything uncertain fitted
//! together ([`estimate`]), an interval for each fault that may be open ([`crate::fit::profile`]), and every set of faults
//! with its probability ([`hypotheses`]).

pub mod estimate;
pub mod hypotheses;
pub mod noise;
pub mod prior;
pub mod problem;
mod result;

use crate::complaint::{Complaint, Kind, Place};
use crate::fit::{End, Fit, FitError, Identifiable, Interval, Missing, Profiler};
use crate::model::{Drive, Model};
use crate::record::Record;
use crate::report::number::rounded;
use crate::residual::{self, Detection};
use estimate::{Estimate, Seed};
pub use hypotheses::Hypothesis;
pub use result::{ChannelReport, Diagnosis, FaultReport, FitReport, SCHEMA, UncertainReport, Verdict};

/// What the user may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Of the sampled starts of the fit.
    pub seed: u64,
    pub detection: Detection,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, detection: Detection::default() }
    }
}

/// A diagnosis with the curves behind it.
#[derive(Debug, Clone)]
pub struct Diagnosed {
    pub diagnosis: Diagnosis,
    /// What the fitted model reads: `[sensor][row]`, SI.
    pub model: Vec<Vec<f64>>,
    /// What the healthy model reads; empty where it cannot be solved.
    pub healthy: Vec<Vec<f64>>,
    /// Weighted misfits of the fit: `[sensor][row]`, 1 is one standard deviation.
    pub misfit: Vec<Vec<f64>>,
}

/// Confidence of the intervals.
const LEVEL: f64 = 0.95;
/// A weighted misfit is counted as no more than this, so that a few wild samples do not condemn a model.
const WILD: f64 = 5.0;
/// Mean square of the weighted misfit of a channel up to which the model is adequate: what is left unexplained is then less
/// than half of what the noise of a single sample is, in variance.
const ADEQUATE: f64 = 1.5;
/// A fault is called present from this probability on.
const PRESENT: f64 = 0.5;
/// Digits of a reported number: more than any interval allows, fewer than rounding spoils.
const DIGITS: usize = 7;
/// How often a better optimum, found on a profile, restarts the fit.
const RESTARTS: usize = 3;

/// Diagnoses one record of a rig.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub fn diagnose(model: &Model, record: &Record, options: &Options) -> Result<Diagnosed, Complaint> {
    let rig = &model.rig;
    if rig.sensors.is_empty() {
        return Err(Complaint::new(Kind::MissingEntry, "the rig has no sensors, so a record shows nothing of it")
            .at(Place::file(&rig.path))
            .help("add `[sensors]`, one line per measured column"));
    }
    let drive = Drive::from_record(rig, record)?;
    let residuals = residual::detect(rig, record, &drive, &options.detection)?;
    let failed = |error: FitError| {
        Complaint::new(Kind::Computation, format!("the uncertainty could not be worked out: {error}"))
            .at(Place::file(&rig.path))
            .at(Place::file(&record.path))
            .help("check values and bounds of the faults with `borescope check`")
    };
    let mut estimate = estimate::estimate(model, record, &drive, &Seed::Sampled(options.seed))?;
    let mut solves = estimate.solves;
    let mut restarts = 0;
    let (intervals, weighed) = loop {
        let (intervals, spent) = intervals(&estimate, restarts < RESTARTS).map_err(failed)?;
        solves += spent;
        let better = intervals.iter().filter_map(|interval| interval.better.as_ref());
        let better = better.min_by(|a, b| a.cost.total_cmp(&b.cost)).map(|better| better.theta.clone());
        match better {
            Some(theta) if restarts < RESTARTS => {
                restarts += 1;
                estimate = estimate::estimate(model, record, &drive, &Seed::Given(theta))?;
                solves += estimate.solves;
            }
            _ => {
                let mut profiler = Profiler::new(&estimate.problem, &estimate.fit).map_err(failed)?;
                let weighed =
                    hypotheses::weigh(&estimate, &intervals, &blind(&estimate, &intervals), profiler.conditional());
                solves += profiler.conditional().misfit_evaluations + profiler.conditional().linearisations;
                break (intervals, weighed);
            }
        }
    };

    let outputs = model
        .simulate(&estimate.problem.parameters(&estimate.fit.theta), &drive, &record.time)
        .map(|outputs| outputs.values)
        .unwrap_or_default();
    let misfit: Vec<Vec<f64>> =
        estimate.problem.series().into_iter().map(|range| estimate.fit.linearised.misfit[range].to_vec()).collect();
    let channels = channels(&estimate, &outputs, &misfit);
    let adequate = channels.iter().all(|channel| channel.adequate);
    let faults = faults(&estimate, &intervals, &weighed.faults, !adequate);
    let verdict = match (adequate, faults.iter().any(|fault| fault.present)) {
        (false, _) => Verdict::ModelInadequate,
        (true, true) => Verdict::Faulty,
        (true, false) => Verdict::Healthy,
    };
    let mut parameters = rig.nominal();
    for fault in &rig.faults {
        parameters[fault.parameter] = fault.healthy;
    }
    let nominal = model.simulate(&parameters, &drive, &record.time);
    let healthy = nominal.map(|outputs| outputs.values).unwrap_or_default();
    let alarms = residuals.iter().filter_map(|residual| residual.alarm_at_s);
    let detected_at_s = match verdict {
        Verdict::Healthy => None,
        _ => alarms.reduce(f64::min).or_else(|| parted_at(&estimate, &healthy, &misfit, &options.detection)),
    };
    let samples = misfit.iter().map(Vec::len).sum::<usize>().saturating_sub(rig.faults.len()).max(1) as f64;
    let diagnosis = Diagnosis {
        schema: SCHEMA,
        rig: rig.path.display().to_string(),
        record: record.path.display().to_string(),
        verdict,
        detected_at_s,
        onset_s: None,
        ambiguity: Vec::new(),
        hypotheses: weighed.hypotheses,
        residuals,
        fit: FitReport {
            chi2_reduced: misfit.iter().map(|channel| tame_squares(channel)).sum::<f64>() / samples,
            iterations: estimate.fit.iterations,
            solves,
            stopped_because: estimate.fit.stopped.to_string(),
        },
        channels,
        uncertain: uncertain(&estimate),
        faults,
    };
    Ok(Diagnosed { diagnosis, model: outputs, healthy, misfit })
}

/// The interval of every fault (with `restart` up to the one that showed a better optimum), and the simulations they took.
fn intervals(estimate: &Estimate<'_>, restart: bool) -> Result<(Vec<Interval>, u64), FitError> {
    let mut profiler = Profiler::new(&estimate.problem, &estimate.fit)?;
    let mut intervals = Vec::new();
    for i in 0..estimate.problem.model.rig.faults.len() {
        let interval = profiler.interval(i, LEVEL, estimate.uncertainty.inflation[i])?;
        let better = interval.better.is_some();
        intervals.push(interval);
        if better && restart {
            break;
        }
    }
    let spent = intervals.iter().map(|interval| interval.misfit_evaluations + interval.linearisations).sum();
    Ok((intervals, spent))
}

/// When fitted and healthy model part, s: where the running sum of the log likelihood ratio between them, started anew at
/// every minimum, passes the logarithm of the number of rows between false alarms. For a likelihood ratio that is Lorden's
/// bound (Annals of Mathematical Statistics 42 (1971), theorem 2). Used where the rig has no residual that fires.
fn parted_at(estimate: &Estimate<'_>, healthy: &[Vec<f64>], misfit: &[Vec<f64>], detection: &Detection) -> Option<f64> {
    let problem = &estimate.problem;
    let mut column: Vec<f64> = Vec::new();
    for (model, measured) in healthy.iter().zip(&problem.measured) {
        column.extend(model.iter().zip(*measured).map(|(model, measured)| model - measured));
    }
    problem.weights.apply(&mut column);
    let rows = problem.times.len();
    let span = problem.times.last()? - problem.times.first()?;
    let between = detection.hours_between_false_alarms * 3600.0 * rows as f64 / span;
    let mut sum = 0.0_f64;
    let alarm = (0..rows).find(|&row| {
        let tame = |r: f64| 0.5 * r.abs().min(WILD).powi(2);
        let gain: f64 =
            misfit.iter().enumerate().map(|(k, fitted)| tame(column[k * rows + row]) - tame(fitted[row])).sum();
        sum = (sum + gain).max(0.0);
        sum > between.ln()
    })?;
    problem.times.get(alarm).copied()
}

fn tame_squares(misfit: &[f64]) -> f64 {
    misfit.iter().map(|r| r.abs().min(WILD).powi(2)).sum()
}

fn channels(estimate: &Estimate<'_>, outputs: &[Vec<f64>], misfit: &[Vec<f64>]) -> Vec<ChannelReport> {
    let rig = &estimate.problem.model.rig;
    let measured = &estimate.problem.measured;
    rig.sensors
        .iter()
        .enumerate()
        .map(|(index, sensor)| {
            let unit = rig.sensor_unit(sensor);
            let model = outputs.get(index).map_or(&[][..], Vec::as_slice);
            let rows = measured[index].len().max(1) as f64;
            let square: f64 = measured[index].iter().zip(model).map(|(y, m)| (y - m) * (y - m)).sum();
            let chi2_reduced = tame_squares(&misfit[index]) / rows;
            ChannelReport {
                name: sensor.name.clone(),
                unit: unit.symbol.clone(),
                rmse: rounded(unit.difference_from_si((square / rows).sqrt()), DIGITS),
                noise_sigma: rounded(unit.difference_from_si(sensor.noise), DIGITS),
                chi2_reduced,
                // Four standard deviations of the mean square of so few samples.
                adequate: chi2_reduced <= ADEQUATE + 4.0 * (2.0 / rows).sqrt(),
            }
        })
        .collect()
}

fn faults(estimate: &Estimate<'_>, intervals: &[Interval], probabilities: &[f64], biased: bool) -> Vec<FaultReport> {
    let rig = &estimate.problem.model.rig;
    rig.faults
        .iter()
        .enumerate()
        .map(|(i, fault)| {
            let parameter = &rig.parameters[fault.parameter];
            let shown = |si: f64| rounded(parameter.unit.from_si(si), DIGITS);
            let interval = intervals.get(i);
            let ends =
                interval.map_or([None, None], |interval| settled(interval, &estimate.uncertainty.standard_error[i]));
            FaultReport {
                id: parameter.id.clone(),
                meaning: parameter.meaning.clone(),
                value: shown(estimate.fit.theta[i]),
                unit: parameter.unit.symbol.clone(),
                healthy: shown(fault.healthy),
                ci95: ends.map(|end| end.map(shown)),
                // What the record does not bound away from its healthy value is not called a fault, however a set scores.
                present: probabilities[i] >= PRESENT && !holds(ends, fault.healthy),
                probability: probabilities[i],
                identifiable: match ends {
                    [Some(_), Some(_)] => Identifiable::Bounded,
                    [Some(_), None] => Identifiable::LowerBoundOnly,
                    [None, Some(_)] => Identifiable::UpperBoundOnly,
                    [None, None] => Identifiable::Unidentifiable,
                },
                remark: interval
                    .and_then(|interval| remark(&estimate.fit, interval, fault, shown, &parameter.unit.symbol)),
                biased,
            }
        })
        .collect()
}

/// The ends of an interval; where the search for one did not settle, the standard error stands in for it, since an open end
/// says that the record does not bound the value.
fn settled(interval: &Interval, error: &Result<f64, Missing>) -> [Option<f64>; 2] {
    let quantile = 1.96;
    let stand_in = |end: Option<f64>, why: End, sign: f64| match (end, why, error) {
        (None, End::GaveUp | End::BetterOptimum | End::ModelFails, Ok(sigma)) => {
            Some(interval.value + sign * quantile * sigma)
        }
        _ => end,
    };
    [stand_in(interval.lower, interval.lower_end, -1.0), stand_in(interval.upper, interval.upper_end, 1.0)]
}

/// Which faults the record says nothing about: both ends of their intervals are open.
fn blind(estimate: &Estimate<'_>, intervals: &[Interval]) -> Vec<bool> {
    let errors = &estimate.uncertainty.standard_error;
    intervals.iter().zip(errors).map(|(interval, error)| settled(interval, error) == [None, None]).collect()
}

/// Whether an interval (SI, open ends unbounded) holds a value.
fn holds(ends: [Option<f64>; 2], value: f64) -> bool {
    ends[0].is_none_or(|low| low <= value) && ends[1].is_none_or(|high| value <= high)
}

/// Why an end of an interval is open.
fn remark(
    fit: &Fit,
    interval: &Interval,
    fault: &crate::rig::Fault,
    shown: impl Fn(f64) -> f64,
    unit: &str,
) -> Option<String> {
    let one = |end: End, bound: f64, side: &str| match end {
        End::Crossed => None,
        End::BoundReached if fit.theta[interval.parameter] == bound => {
            Some(format!("the {side} end of the search, {} {unit}, fits best", shown(bound)))
        }
        End::BoundReached => {
            let rise = interval.points.iter().find(|point| point.value == bound).map_or(0.0, |point| point.rise);
            Some(format!(
                "going to the {side} end of the search, {} {unit}, worsens the fit by {rise:.1} in chi-square, less than the \
                 {:.1} that would bound it",
                shown(bound),
                interval.threshold
            ))
        }
        End::ModelFails => {
            Some(format!("the model cannot be solved towards the {side} end; it is taken from the standard error"))
        }
        End::BetterOptimum | End::GaveUp => {
            Some(format!("the search for the {side} end did not settle; it is taken from the standard error"))
        }
    };
    let remarks: Vec<String> =
        [one(interval.lower_end, fault.bounds.0, "lower"), one(interval.upper_end, fault.bounds.1, "upper")]
            .into_iter()
            .flatten()
            .collect();
    (!remarks.is_empty()).then(|| remarks.join("; "))
}

fn uncertain(estimate: &Estimate<'_>) -> Vec<UncertainReport> {
    let rig = &estimate.problem.model.rig;
    let along = estimate.problem.estimated.iter().enumerate().skip(rig.faults.len());
    along
        .filter_map(|(i, estimated)| {
            let parameter = &rig.parameters[estimated.parameter];
            let (mean, sigma) = estimate.problem.prior.of(i)?;
            let unit = &parameter.unit;
            Some(UncertainReport {
                id: parameter.id.clone(),
                value: rounded(unit.from_si(estimate.fit.theta[i]), DIGITS),
                unit: unit.symbol.clone(),
                nominal: rounded(unit.from_si(mean), DIGITS),
                sigma_before: rounded(unit.difference_from_si(sigma), DIGITS),
                sigma_after: estimate.uncertainty.standard_error[i]
                    .as_ref()
                    .ok()
                    .map(|si| rounded(unit.difference_from_si(*si), DIGITS)),
            })
        })
        .collect()
}
