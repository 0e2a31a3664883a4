//! Where the model misses a record: which sensors, in which phases, and with which quantity the misfit goes.

use super::comparison::{
    AsStated, ChannelComparison, Comparison, Correlation, FittedParameter, MisfitPlace, MissedPhase, SCHEMA,
};
use super::fitted_model::run_with;
use super::lack_of_fit::{is_alike, with_lack_of_fit};
use super::phase::{Stretch, stretches};
use super::refit;
use super::run::{Run, misses, times_noise};
use super::warning::ends_its_search;
use super::with_faults::{Explained, with_faults};
use crate::complaint::Complaint;
use crate::diagnosis::problem::root_mean_square;
use crate::diagnosis::{FAR_OFF, estimate, missed, weighed};
use crate::model::{InputSignals, Model};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::FaultSet;
use crate::rig::{Quantity, Rig, Sensor, Target};
use crate::settings::LearningSettings;

/// Phases that are named of each sensor.
const WORST: usize = 3;
/// Quantities that are named at most.
const NAMED: usize = 3;
/// Digits of a reported number.
const DIGITS: usize = 6;
/// Digits of an error as people read it.
const SHOWN: usize = 2;

/// A comparison with the curves behind it.
#[derive(Debug, Clone)]
#[cfg_attr(not(any(feature = "cli", feature = "internals")), expect(dead_code, reason = "only pages draw the curves"))]
pub struct Compared {
    pub comparison: Comparison,
    pub run: Run,
    /// What the sensors would show with the faults that were found, `[sensor][row]`, SI.
    pub found: Option<Vec<Vec<f64>>>,
}

/// The healthy model beside a record: faults at their healthy values, uncertain data-sheet values fitted within their
/// uncertainty.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved on the record.
pub fn compare(rig: &Rig, record: &Record) -> Result<Comparison, Complaint> {
    Ok(compared(rig, record)?.comparison)
}

/// The same with the curves behind it.
///
/// # Errors
/// As [`compare`].
pub fn compared(rig: &Rig, record: &Record) -> Result<Compared, Complaint> {
    rig.context().run(|| compared_here(rig, record))
}

fn compared_here(rig: &Rig, record: &Record) -> Result<Compared, Complaint> {
    let commanded = rig.as_commanded([record]);
    let rig = commanded.as_ref().unwrap_or(rig);
    let model = Model::new(rig.clone());
    let drive = InputSignals::from_record(rig, record)?;
    rig.context().stage("fit of the healthy model");
    let (values, run) = followed(rig, record, &drive)?;
    let mut comparison = Comparison::of(&model, record, &run)?;
    comparison.as_stated = as_stated(&model, record, &drive);
    let estimated = estimate::estimated_parameters(rig).into_iter();
    let known = estimated.filter(|&index| rig.parameters[index].is_uncertain());
    comparison.fitted = known.map(fitted(rig, &values)).collect();
    let mut found = None;
    rig.context().first_look(|| misses(comparison.times_noise));
    // Faults with which the error does not fall explain nothing, whatever their weights make of it.
    let shown = |times_noise: f64| rounded(times_noise, SHOWN);
    // The healthy value of a fault that is known to within an uncertainty may have followed the fault.
    let far: Vec<&str> =
        comparison.fitted.iter().filter(|one| one.deviations() > FAR_OFF).map(|one| &*one.id).collect();
    let is_far =
        |id: &str| far.contains(&id) && rig.faults.iter().any(|fault| rig.parameters[fault.parameter].id == id);
    if (!comparison.adequate || far.iter().any(|id| is_far(id)))
        && let Some(Explained { with_faults, outputs }) = with_faults(&model, record)?
        && (with_faults.adequate || shown(with_faults.times_noise) < shown(comparison.times_noise))
        && (!comparison.adequate || with_faults.faults.iter().any(|fault| is_far(&fault.id)))
    {
        comparison.adequate = false;
        comparison.with_faults = Some(with_faults);
        found = Some(outputs);
    }
    Ok(Compared { comparison, run, found })
}

/// The healthy model with the values of the rig file; `None` where it cannot be solved with them.
fn as_stated(model: &Model, record: &Record, drive: &InputSignals) -> Option<AsStated> {
    let rig = &model.rig;
    let outputs = model.solve(&rig.healthy(), drive, &record.time).ok()?.values;
    let measured = weighed::measured(rig, record).ok()?;
    let missed: Vec<Option<f64>> =
        outputs.iter().zip(measured).map(|(model, measured)| root_mean_square(model, measured)).collect();
    let each = rig.sensors.iter().zip(&missed).filter_map(|(sensor, rms)| {
        Some((sensor.name.clone(), rounded(rig.sensor_unit(sensor).difference_from_si((*rms)?), DIGITS)))
    });
    Some(AsStated { times_noise: rounded(times_noise(rig, &missed), DIGITS), rmse: each.collect() })
}

/// All parameters (SI) of the healthy model as a comparison fits it to a record.
///
/// # Errors
/// As [`compare`].
#[cfg(feature = "cli")]
pub fn healthy_values(rig: &Rig, record: &Record) -> Result<Vec<f64>, Complaint> {
    rig.context().run(|| {
        let commanded = rig.as_commanded([record]);
        let rig = commanded.as_ref().unwrap_or(rig);
        rig.context().stage("fit of the healthy model");
        Ok(followed(rig, record, &InputSignals::from_record(rig, record)?)?.0)
    })
}

/// All parameters (SI) of the healthy model as it follows a record best, and its run, weighed by the lack of fit that it leaves itself.
fn followed(rig: &Rig, record: &Record, drive: &InputSignals) -> Result<(Vec<f64>, Run), Complaint> {
    let known = within_known(rig);
    let (mut weighed, mut values, mut weighings) = (known.clone(), rig.healthy(), 1);
    loop {
        let model = Model::new(weighed.clone());
        (values, _) = refit::fitted(
            &model,
            record,
            drive,
            &values,
            (FaultSet::EMPTY, rig.settings().learn.linearisations),
            None,
        )?;
        let run = run_with(&model, record, drive, &values)?;
        let lacking = with_lack_of_fit(&known, &run);
        // Events stand where the fit has them only once it has been weighed there, as a diagnosis does.
        if weighings > rig.settings().learn.weighings || (weighings > 1 && is_alike(&lacking, &weighed)) {
            return Ok((values, run));
        }
        (weighed, weighings) = (lacking, weighings + 1);
    }
}

/// The rig with its faults searched no farther from healthy than other uncertain values are.
fn within_known(rig: &Rig) -> Rig {
    let mut within = rig.clone();
    for fault in &mut within.faults {
        let known = &rig.parameters[fault.parameter];
        if known.is_uncertain() {
            let reach = rig.settings().diagnosis.search_reach * known.sigma;
            fault.bounds.0 = fault.bounds.0.max(fault.healthy - reach);
            fault.bounds.1 = fault.bounds.1.min(fault.healthy + reach);
        }
    }
    within
}

fn fitted(rig: &Rig, values: &[f64]) -> impl Fn(usize) -> FittedParameter {
    move |index| {
        let parameter = &rig.parameters[index];
        let far = ((values[index] - parameter.value) / parameter.sigma).abs();
        FittedParameter {
            id: parameter.id.clone(),
            value: rounded(parameter.unit.from_si(values[index]), DIGITS),
            unit: parameter.unit.symbol.clone(),
            nominal: rounded(parameter.unit.from_si(parameter.value), DIGITS),
            sigma_before: rounded(parameter.unit.difference_from_si(parameter.sigma), DIGITS),
            is_at_end: ends_its_search(far, rig),
        }
    }
}

impl Comparison {
    /// A run of a model beside the record that it is of.
    ///
    /// # Errors
    /// Columns that are missing.
    pub(crate) fn of(model: &Model, record: &Record, run: &Run) -> Result<Self, Complaint> {
        let rig = &model.rig;
        let measured = weighed::measured(&model.rig, record)?;
        let drive = InputSignals::from_record(rig, record)?;
        let phases = stretches(rig, record, &drive, &measured);
        let signals = signals(rig, record, &drive, run);
        let rows = record.time.len().max(1);
        let channels: Vec<ChannelComparison> = missed(&rig.settings().diagnosis, &run.weights, &run.misfit)
            .into_iter()
            .enumerate()
            .map(|(index, missed)| {
                let sensor = &rig.sensors[index];
                let unit = rig.sensor_unit(sensor);
                let misfit: Vec<f64> = run.misfit[index * rows..(index + 1) * rows].iter().map(|r| -r).collect();
                let there: Vec<bool> = measured[index].iter().map(|y| !y.is_nan()).collect();
                ChannelComparison {
                    name: sensor.name.clone(),
                    rmse: rounded(unit.difference_from_si(run.rmse[index]), DIGITS),
                    noise_sigma: rounded(unit.difference_from_si(sensor.stated_noise), DIGITS),
                    times_noise: rounded(run.rmse[index] / sensor.stated_noise, DIGITS),
                    fit_percent: fit_percent(measured[index], &run.outputs[index]),
                    samples: missed.samples,
                    chi2_reduced: missed.square,
                    events_chi2: missed.events(),
                    adequate: missed.is_explained(&rig.settings().diagnosis),
                    within_noise: missed.is_within_noise(&rig.settings().diagnosis),
                    autocorrelation: autocorrelation(&misfit),
                    goes_with: goes_with(&rig.settings().learn, &misfit, &there, &signals),
                    worst: worst(record, &phases, (measured[index], &run.outputs[index]), &misfit)
                        .into_iter()
                        .map(|miss| MissedPhase { rmse: rounded(unit.difference_from_si(miss.rmse), DIGITS), ..miss })
                        .collect(),
                    unit: unit.symbol,
                }
            })
            .collect();
        let all = channels.iter().all(|channel| channel.adequate);
        Ok(Self {
            schema: SCHEMA,
            rig: rig.path.display().to_string(),
            record: record.path.display().to_string(),
            adequate: all,
            times_noise: rounded(run.normalised, DIGITS),
            chi2_reduced: run.chi2,
            as_stated: None,
            place: if all { None } else { place(rig, &channels) },
            channels,
            fitted: Vec::new(),
            with_faults: None,
            unfilled: rig.unfilled.len(),
            taken_as_exact: rig.exact_by_sheet().len(),
            before: None,
        })
    }
}

/// The worst sensor, in the one number for people, of those that are not explained; its worst phase, and what its misfit goes with.
fn place(rig: &Rig, channels: &[ChannelComparison]) -> Option<MisfitPlace> {
    let worst = |(_, a): &(&Sensor, &ChannelComparison), (_, b): &(&Sensor, &ChannelComparison)| {
        a.times_noise.total_cmp(&b.times_noise)
    };
    let missed = rig.sensors.iter().zip(channels).filter(|(_, channel)| !channel.adequate);
    let (sensor, channel) = missed.max_by(worst)?;
    let miss = channel.worst.first()?;
    Some(MisfitPlace {
        equation: equation(rig, sensor),
        channel: channel.name.clone(),
        phase: miss.phase.clone(),
        from_s: miss.from_s,
        to_s: miss.to_s,
        depends_on: channel.goes_with.iter().map(|goes| goes.signal.clone()).collect(),
    })
}

/// The balance that determines what a sensor shows.
fn equation(rig: &Rig, sensor: &Sensor) -> String {
    let at = match sensor.target {
        Target::Node(node) => rig.nodes[node].name.clone(),
        Target::Port(component, port) => {
            let component = &rig.components[component];
            format!("{}.{}", component.name, component.card.ports[port].name)
        }
        Target::State(component, state) => {
            let component = &rig.components[component];
            format!("{} of {}", component.card.states[state].name, component.name)
        }
    };
    match sensor.quantity {
        Quantity::Pressure => format!("pressure balance of {at}"),
        Quantity::Flow => format!("flow at {at}"),
        Quantity::Force => format!("force at {at}"),
        Quantity::Position | Quantity::Velocity => format!("force balance of {at}"),
        Quantity::Level => format!("volume balance of {at}"),
        Quantity::State => at,
    }
}

fn fit_percent(measured: &[f64], model: &[f64]) -> Option<f64> {
    let pairs = || measured.iter().zip(model).filter(|(y, _)| !y.is_nan());
    let mean = pairs().map(|(y, _)| y).sum::<f64>() / pairs().count().max(1) as f64;
    let norm = |deviations: &mut dyn Iterator<Item = f64>| deviations.map(|d| d * d).sum::<f64>().sqrt();
    let missed = norm(&mut pairs().map(|(y, m)| y - m));
    let moved = norm(&mut pairs().map(|(y, _)| y - mean));
    (moved > 0.0).then(|| rounded(100.0 * (1.0 - missed / moved), DIGITS))
}

fn deviations(misfit: &[f64]) -> f64 {
    rounded(misfit.iter().map(|r| r.abs()).sum::<f64>() / misfit.len().max(1) as f64, DIGITS)
}

fn autocorrelation(misfit: &[f64]) -> f64 {
    let square: f64 = misfit.iter().map(|r| r * r).sum();
    let neighbours: f64 = misfit.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if square > 0.0 { rounded(neighbours / square, DIGITS) } else { 0.0 }
}

/// The phases in which a sensor is missed most, in standard deviations; `rmse` in SI.
fn worst(record: &Record, phases: &[Stretch], (measured, model): (&[f64], &[f64]), misfit: &[f64]) -> Vec<MissedPhase> {
    let mut all: Vec<MissedPhase> = phases
        .iter()
        .filter_map(|phase| {
            let rows = phase.rows.clone();
            let there: Vec<usize> = rows.clone().filter(|&row| !measured[row].is_nan()).collect();
            let count = there.len() as f64;
            let square: f64 = there.iter().map(|&row| (measured[row] - model[row]).powi(2)).sum();
            let misfit: Vec<f64> = there.iter().map(|&row| misfit[row]).collect();
            (!there.is_empty()).then(|| MissedPhase {
                from_s: record.time[rows.start],
                to_s: record.time[rows.end - 1],
                phase: phase.name.clone(),
                rmse: (square / count).sqrt(),
                deviations: deviations(&misfit),
            })
        })
        .collect();
    all.sort_by(|a, b| b.deviations.total_cmp(&a.deviations));
    all.truncate(WORST);
    all
}

/// What a misfit may go with: inputs, what the model says of each sensor, and how bodies move.
fn signals(rig: &Rig, record: &Record, drive: &InputSignals, run: &Run) -> Vec<(String, Vec<f64>)> {
    let inputs = rig.inputs.iter().enumerate().map(|(input, named)| {
        (named.name.clone(), record.time.iter().map(|&time| drive.value(input, time)).collect::<Vec<f64>>())
    });
    let mut signals: Vec<(String, Vec<f64>)> = inputs.collect();
    for (sensor, output) in rig.sensors.iter().zip(&run.outputs) {
        signals.push((sensor.name.clone(), output.clone()));
        if sensor.quantity == Quantity::Position {
            let velocity = slopes(&record.time, output);
            // What creeps has no direction.
            let least = 1e-3 * velocity.iter().fold(0.0_f64, |greatest, v| greatest.max(v.abs()));
            let direction = velocity.iter().map(|v| if v.abs() > least { v.signum() } else { 0.0 }).collect();
            signals.push((format!("direction of {}", sensor.name), direction));
            signals.push((format!("velocity of {}", sensor.name), velocity));
        }
    }
    signals
}

fn slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let last = times.len().saturating_sub(1);
    let slope = |row: usize| {
        let (before, behind) = (row.saturating_sub(1), (row + 1).min(last));
        let step = times[behind] - times[before];
        if step > 0.0 { (values[behind] - values[before]) / step } else { 0.0 }
    };
    (0..times.len()).map(slope).collect()
}

/// The signals that a misfit goes with, closest first.
fn goes_with(
    settings: &LearningSettings,
    misfit: &[f64],
    there: &[bool],
    signals: &[(String, Vec<f64>)],
) -> Vec<Correlation> {
    let only = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(there).filter(|(_, there)| **there).map(|(value, _)| *value).collect()
    };
    let misfit = only(misfit);
    let mut all: Vec<Correlation> = signals
        .iter()
        .map(|(name, values)| Correlation {
            signal: name.clone(),
            coefficient: rounded(correlation(&misfit, &only(values)), 4),
        })
        .filter(|goes| goes.coefficient.abs() >= settings.named_correlation)
        .collect();
    all.sort_by(|a, b| b.coefficient.abs().total_cmp(&a.coefficient.abs()));
    let least = all.first().map_or(0.0, |first| settings.named_share * first.coefficient.abs());
    all.retain(|goes| goes.coefficient.abs() >= least);
    all.truncate(NAMED);
    all
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        (aa, bb, ab) = (aa + a * a, bb + b * b, ab + a * b);
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}
