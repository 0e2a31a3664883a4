//! One mistake in how a record was taken, instead of several faults: a clock that runs fast, absolute pressures taken for gauge,
//! columns that are swapped, a sensor that counts the other way.
//!
//! Each is a transformation of the record that can be taken back. The corrected record is explained by the same search as any
//! other, so a common cause competes with fault combinations by the same evidence: it counts as one fault. A clock has a
//! rate besides, whose Occam factor is that of its range.

use rayon::prelude::*;

use super::Diagnosed;
use super::case::robust;
use super::estimate::{self, Estimate};
use super::noise::Weights;
use super::problem::away;
use super::result::CommonCause;
use super::weighed;
use super::weighing::prior_odds;
use crate::estimation::Score;
use crate::model::{InputSignals, Model};
use crate::number::{rounded, text};
use crate::record::{Channel, Record};
use crate::rig::{Quantity, Rig};

/// Standard atmosphere, Pa (ISO 2533): what an absolute pressure sensor shows above a gauge one.
const ATMOSPHERE: f64 = 101_325.0;

/// A mistake in how a record was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cause {
    /// The logger's clock runs fast by this share.
    FastClock(f64),
    /// Pressures are absolute where the rig file takes them as gauge.
    AbsolutePressures,
    /// The columns of two sensors stand in each other's place.
    Swapped([usize; 2]),
    /// A sensor counts the other way.
    Turned(usize),
}

impl Cause {
    /// The record as it would have been without the mistake.
    fn corrected(self, rig: &Rig, record: &Record) -> Record {
        let mut corrected = record.clone();
        match self {
            Self::FastClock(rate) => corrected.time.iter_mut().for_each(|time| *time /= 1.0 + rate),
            Self::AbsolutePressures => {
                for sensor in rig.sensors.iter().filter(|sensor| sensor.quantity == Quantity::Pressure) {
                    change(&mut corrected, &sensor.column, |value| value - ATMOSPHERE);
                }
            }
            Self::Turned(sensor) => change(&mut corrected, &rig.sensors[sensor].column, |value| -value),
            Self::Swapped(pair) => {
                let place =
                    |sensor: usize| corrected.channels.iter().position(|c| c.name == rig.sensors[sensor].column);
                if let [Some(a), Some(b)] = pair.map(place) {
                    let of_a = std::mem::take(&mut corrected.channels[a].values);
                    corrected.channels[a].values = std::mem::replace(&mut corrected.channels[b].values, of_a);
                }
            }
        }
        corrected
    }

    fn report(self, rig: &Rig, instead_of: Vec<String>) -> CommonCause {
        let column = |sensor: usize| rig.sensors[sensor].column.clone();
        let (kind, columns, clause) = match self {
            Self::FastClock(rate) => {
                let way = if rate < 0.0 { "slow" } else { "fast" };
                let percent = text(rounded(100.0 * rate.abs(), 3));
                ("fast-clock", vec!["time".to_owned()], format!("the clock of the logger is {percent} % {way}"))
            }
            Self::AbsolutePressures => {
                let pressures = rig.sensors.iter().filter(|sensor| sensor.quantity == Quantity::Pressure);
                let clause = "the pressures are absolute, where the rig file takes them as gauge".to_owned();
                ("absolute-pressures", pressures.map(|sensor| sensor.column.clone()).collect(), clause)
            }
            Self::Swapped([a, b]) => {
                let clause = format!("the columns `{}` and `{}` are swapped", column(a), column(b));
                ("swapped-columns", vec![column(a), column(b)], clause)
            }
            Self::Turned(sensor) => {
                let clause = format!("`{}` counts the other way", column(sensor));
                ("turned-sign", vec![column(sensor)], clause)
            }
        };
        let value = if let Self::FastClock(rate) = self { Some(rounded(rate, 4)) } else { None };
        CommonCause { kind, columns, value, clause, instead_of }
    }

    /// What has no size and could concern this rig.
    fn discrete(rig: &Rig) -> Vec<Self> {
        let pressures = rig.sensors.iter().filter(|sensor| sensor.quantity == Quantity::Pressure).count();
        let mut causes = Vec::new();
        // One pressure alone is an offset of its sensor.
        causes.extend((pressures > 1).then_some(Self::AbsolutePressures));
        for (a, sensor) in rig.sensors.iter().enumerate() {
            causes.push(Self::Turned(a));
            let alike = |b: &usize| rig.sensors[*b].quantity == sensor.quantity;
            causes.extend((0..a).filter(alike).map(|b| Self::Swapped([b, a])));
        }
        causes
    }
}

fn change(record: &mut Record, column: &str, to: impl Fn(f64) -> f64) {
    let channel = record.channels.iter_mut().find(|channel: &&mut Channel| channel.name == column);
    if let Some(channel) = channel {
        channel.values.iter_mut().for_each(|value| *value = to(*value));
    }
}

/// A corrected record with how well faults explain it.
struct Explained {
    cause: Cause,
    record: Record,
    /// Logarithm of the evidence, up to what is the same for all readings of the record; the cause itself counted.
    evidence: f64,
    /// Those of its explanation, under which the record as it stands is judged too.
    weights: Weights,
    missed: bool,
}

/// The corrected record and its common cause, where that explains a record better than the fault combination of `plain` does.
/// Asked only of what such causes look like: a record that no fault explains, or one that takes faults of several sensors.
pub(super) fn instead(model: &Model, record: &Record, plain: &Diagnosed) -> Option<(Record, CommonCause)> {
    let rig = &model.rig;
    let faults = plain.diagnosis.faults.iter().zip(&rig.faults).filter(|(report, _)| report.present);
    let (of_sensors, all) = faults.fold((0, Vec::new()), |(count, mut all), (report, fault)| {
        all.push(report.id.clone());
        (count + usize::from(rig.is_of_sensor(fault.parameter)), all)
    });
    let missed = !plain.diagnosis.is_explained();
    if !missed && of_sensors < 2 {
        return None;
    }
    let mut causes = promising(model, record);
    causes.extend(clock(model, record));
    let explained: Vec<Explained> = causes.into_par_iter().filter_map(|cause| explain(model, record, cause)).collect();
    let explains = explained.into_iter().filter(|one| !one.missed);
    let margin = |one: &Explained| one.evidence - plain.evidence_under(&one.weights, rig, record);
    let (margin, best) = explains.map(|one| (margin(&one), one)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (missed || margin > 0.0).then(|| (best.record, best.cause.report(rig, all)))
}

impl Diagnosed {
    /// Logarithm of the evidence, had the record been weighed otherwise: costs compare under common weights only.
    pub(super) fn evidence_under(&self, weights: &Weights, rig: &Rig, record: &Record) -> f64 {
        let Ok(measured) = weighed::measured(rig, record) else { return f64::NEG_INFINITY };
        let mut misfit = away(&self.model, &measured);
        weights.apply(&mut misfit);
        let own: f64 = self.misfit.iter().map(|channel| robust(rig).cost(channel)).sum();
        self.evidence + own - robust(rig).cost(&misfit)
    }
}

/// Causes without a size that leave the healthy model less to explain than the record as it stands does, the best first.
fn promising(model: &Model, record: &Record) -> Vec<Cause> {
    let rig = &model.rig;
    let Ok(drive) = InputSignals::from_record(rig, record) else { return Vec::new() };
    let Ok(outputs) = model.solve(&rig.healthy(), &drive, &record.time) else { return Vec::new() };
    // No weights by events: they would have to be made for every cause, and only the order counts.
    let cost = |record: &Record| -> Option<f64> {
        let mut misfit = away(&outputs.values, &weighed::measured(rig, record).ok()?);
        for (misfit, sensor) in misfit.chunks_mut(record.time.len().max(1)).zip(&rig.sensors) {
            misfit.iter_mut().for_each(|value| *value = if value.is_nan() { 0.0 } else { *value / sensor.noise });
        }
        Some(robust(rig).cost(&misfit))
    };
    let Some(plain) = cost(record) else { return Vec::new() };
    let causes = Cause::discrete(rig).into_iter();
    let mut costs: Vec<(f64, Cause)> =
        causes.filter_map(|cause| Some((cost(&cause.corrected(rig, record))?, cause))).collect();
    costs.retain(|(cost, _)| *cost < plain);
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    costs.into_iter().take(model.rig.settings().diagnosis.causes_explained).map(|(_, cause)| cause).collect()
}

/// The clock with the rate at which the model without faults explains the record best.
fn clock(model: &Model, record: &Record) -> Option<Cause> {
    let (mut rate, mut best) = (0.0, (f64::INFINITY, 0.0));
    for _ in 0..model.rig.settings().diagnosis.clock_improvements {
        let corrected = Cause::FastClock(rate).corrected(&model.rig, record);
        let drive = InputSignals::from_record(&model.rig, &corrected).ok()?;
        let near = estimate::near(model, &corrected, &drive, None, 1).ok()?;
        let healthy = near.without_faults(model.rig.settings().diagnosis.clock_linearisations).ok()?;
        // Where a clock is what is wrong, each step leaves less.
        if healthy.isolation.best.cost >= best.0 {
            rate = best.1;
            break;
        }
        best = (healthy.isolation.best.cost, rate);
        let score = score_of_rate(&healthy)?;
        // What is left of the first rate r by a further one s: (1 + r)(1 + s) - 1.
        rate = (1.0 + rate).mul_add(1.0 + model.rig.settings().diagnosis.clock_rate_tried * score.factor, -1.0);
        if rate.abs() > model.rig.settings().diagnosis.clock_rate_most {
            return None;
        }
        // Less than a standard error further: the rate stands.
        if score.factor * score.factor * score.information < 1.0 {
            break;
        }
    }
    Some(Cause::FastClock(rate))
}

/// What the misfits say of the rate of the clock, in units of the rate that is tried first, everything uncertain following.
fn score_of_rate(near: &Estimate<'_>) -> Option<Score> {
    let (case, isolation) = (&near.case, &near.isolation);
    let (full, best) = (&case.full, &isolation.best);
    let values = full.parameters(&best.theta);
    let record = Cause::FastClock(case.settings().clock_rate_tried).corrected(case.rig(), case.record);
    let drive = InputSignals::from_record(case.rig(), &record).ok()?;
    let plain = full.model.solve(&values, full.drive, full.times).ok()?.values;
    let with = full.model.solve(&values, &drive, &record.time).ok()?.values;
    let test = isolation.local.score_test(&case.problem(isolation.set()), &best.theta, &best.misfit).ok()?;
    Some(test.of(&full.weights.change(&with, &plain)))
}

/// A cause taken back, and the record then explained like any other.
fn explain(model: &Model, record: &Record, cause: Cause) -> Option<Explained> {
    let record = cause.corrected(&model.rig, record);
    let (evidence, weights, missed) = {
        let drive = InputSignals::from_record(&model.rig, &record).ok()?;
        let near = estimate::near(model, &record, &drive, None, model.rig.settings().diagnosis.healthy_rounds).ok()?;
        let size = match cause {
            Cause::FastClock(_) => occam_of_rate(&near).unwrap_or(0.0),
            Cause::AbsolutePressures | Cause::Swapped(_) | Cause::Turned(_) => 0.0,
        };
        let evidence = near.isolation.evidence(&near.case) + prior_odds(&near.case) + size;
        (evidence, near.case.full.weights.clone(), near.missed())
    };
    Some(Explained { cause, record, evidence, weights, missed })
}

/// Logarithm of the share of its range that the record leaves the rate of a clock (Laplace's approximation).
fn occam_of_rate(near: &Estimate<'_>) -> Option<f64> {
    let settings = near.case.settings();
    let sigma = settings.clock_rate_tried / score_of_rate(near)?.information.sqrt();
    Some(((2.0 * std::f64::consts::PI).sqrt() * sigma / (2.0 * settings.clock_rate_most)).ln().min(0.0))
}
