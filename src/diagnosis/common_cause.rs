//! One mistake in how a record was taken, instead of several faults: a clock that runs fast, absolute pressures taken for gauge,
//! columns that are swapped, a sensor that counts the other way, a command that is recorded after it has acted.
//!
//! Each is a transformation of the record that can be taken back. The corrected record is explained by the same search as any
//! other, so a common cause competes with fault combinations by the same evidence: it counts as one fault. A clock has a
//! rate besides, whose Occam factor is that of its range.

use rayon::prelude::*;

use super::case::robust;
use super::estimate::{self, Estimate};
use super::noise::Weights;
use super::problem::away;
use super::result::CommonCause;
use super::weighed;
use super::weighing::prior_odds;
use super::{Attempt, Diagnosed, DiagnosisOptions, diagnose_again};
use crate::complaint::Complaint;
use crate::estimation::Score;
use crate::estimation::pattern::{Patience, least, pattern_search};
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
    /// Inputs are recorded so many rows after they have acted. That they act after they are recorded is no mistake, but dead time.
    Late(Inputs, usize),
}

/// Inputs that come by the same way into a record.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Inputs {
    One(usize),
    Commands,
    All,
}

impl Inputs {
    /// By their indices.
    fn of(self, rig: &Rig) -> Vec<usize> {
        let takes = |&input: &usize| match self {
            Self::One(one) => input == one,
            Self::Commands => rig.inputs[input].noise == 0.0,
            Self::All => true,
        };
        (0..rig.inputs.len()).filter(takes).collect()
    }

    /// Longest time that a part follows one of them behind, as stated, s.
    fn followed_within(self, rig: &Rig) -> f64 {
        let inputs = self.of(rig);
        let followers = rig.followers().filter(|follower| inputs.contains(&follower.input));
        followers.map(|follower| rig.parameters[follower.lag].value).fold(0.0, f64::max)
    }

    /// Each alone, all commands and all inputs, as far as these are others.
    fn groups(rig: &Rig) -> Vec<Self> {
        let mut groups: Vec<Self> = (0..rig.inputs.len()).map(Self::One).collect();
        let several = [Self::Commands, Self::All].into_iter().filter(|group| group.of(rig).len() > 1);
        for group in several {
            if groups.iter().all(|other| other.of(rig) != group.of(rig)) {
                groups.push(group);
            }
        }
        groups
    }
}

/// How late inputs are recorded at most, s: buffers of a bus and of a logger hold tenths of a second.
const LATEST: f64 = 0.5;

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
            Self::Late(inputs, rows) => {
                for input in inputs.of(rig) {
                    let column = &rig.inputs[input].column;
                    let channel = corrected.channels.iter_mut().find(|channel| &channel.name == column);
                    let Some(values) = channel.map(|channel| &mut channel.values) else { continue };
                    if let Some(&last) = values.last() {
                        values.drain(..rows.min(values.len()));
                        values.resize(record.time.len(), last);
                    }
                }
            }
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

    fn report(self, rig: &Rig, record: &Record, instead_of: Vec<String>) -> CommonCause {
        let late = |rows: usize| record.sampling().map(|sampling| rounded(rows as f64 * sampling.interval, 4));
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
            Self::Late(inputs, rows) => {
                let columns: Vec<String> =
                    inputs.of(rig).into_iter().map(|input| rig.inputs[input].column.clone()).collect();
                let named: Vec<String> = columns.iter().map(|column| format!("`{column}`")).collect();
                let by = text(1e3 * late(rows).unwrap_or(0.0));
                let clause = match named.as_slice() {
                    [one] => format!("{one} is recorded {by} ms after it acts"),
                    several => format!("{} are recorded {by} ms after they act", several.join(" and ")),
                };
                ("late-inputs", columns, clause)
            }
        };
        let value = match self {
            Self::FastClock(rate) => Some(rounded(rate, 4)),
            Self::Late(_, rows) => late(rows),
            Self::AbsolutePressures | Self::Swapped(_) | Self::Turned(_) => None,
        };
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
    (missed || margin > 0.0).then(|| (best.record, best.cause.report(rig, record, all)))
}

/// The diagnosis of a record without the one mistake that leaves the healthy model less than half; `None` where that does not explain it
/// with one fault at most.
///
/// # Errors
/// As [`super::diagnose`].
pub(super) fn at_once(
    model: &Model,
    record: &Record,
    options: &DiagnosisOptions,
) -> Result<Option<Diagnosed>, Complaint> {
    let rig = &model.rig;
    let Some(Costs { plain, causes }) = costs(model, record) else { return Ok(None) };
    let Some(&(_, cause)) = causes.first().filter(|(cost, _)| *cost < 0.5 * plain) else { return Ok(None) };
    let corrected = cause.corrected(rig, record);
    let is_wanted = |estimate: &Estimate<'_>| estimate.explains() && estimate.isolation.set().len() <= 1;
    let attempt = Attempt { is_wanted: Some(&is_wanted), ..Attempt::default() };
    let found = diagnose_again(model, &corrected, (&[], None), options, attempt)?;
    Ok(found.filter(|found| found.diagnosis.is_explained()).map(|mut found| {
        found.diagnosis.common_cause = Some(cause.report(rig, record, Vec::new()));
        found.corrected = Some(corrected);
        found
    }))
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

/// Causes that leave the healthy model less to explain than the record as it stands does, the best first, as many as are explained.
fn promising(model: &Model, record: &Record) -> Vec<Cause> {
    let causes = costs(model, record).map_or_else(Vec::new, |costs| costs.causes);
    causes.into_iter().take(model.rig.settings().diagnosis.causes_explained).map(|(_, cause)| cause).collect()
}

/// What the healthy model leaves of a record.
struct Costs {
    /// As it stands.
    plain: f64,
    /// Without the causes that leave less, the best first.
    causes: Vec<(f64, Cause)>,
}

/// No weights by events: they would have to be made for every cause, and only the order counts. `None` where the healthy model cannot be
/// solved.
fn costs(model: &Model, record: &Record) -> Option<Costs> {
    let rig = &model.rig;
    let outputs = |record: &Record| {
        let drive = InputSignals::from_record(rig, record).ok()?;
        Some(model.solve(&rig.healthy(), &drive, &record.time).ok()?.values)
    };
    let cost = |outputs: &[Vec<f64>], record: &Record| -> Option<f64> {
        let mut misfit = away(outputs, &weighed::measured(rig, record).ok()?);
        for (misfit, sensor) in misfit.chunks_mut(record.time.len().max(1)).zip(&rig.sensors) {
            misfit.iter_mut().for_each(|value| *value = if value.is_nan() { 0.0 } else { *value / sensor.noise });
        }
        Some(robust(rig).cost(&misfit))
    };
    let as_it_stands = outputs(record)?;
    let plain = cost(&as_it_stands, record)?;
    let discrete = Cause::discrete(rig).into_iter();
    let mut causes: Vec<(f64, Cause)> =
        discrete.filter_map(|cause| Some((cost(&as_it_stands, &cause.corrected(rig, record))?, cause))).collect();
    let of_cause = |cause: Cause| {
        let corrected = cause.corrected(rig, record);
        cost(&outputs(&corrected)?, &corrected)
    };
    let interval = record.sampling().map_or(0.0, |sampling| sampling.interval);
    causes.extend(Inputs::groups(rig).into_iter().filter_map(|inputs| {
        let (rows, cost) = late(interval, |rows| of_cause(Cause::Late(inputs, rows)))?;
        // By no more than what follows lags behind, that may be as much faster.
        (rows as f64 * interval >= inputs.followed_within(rig)).then_some((cost, Cause::Late(inputs, rows)))
    }));
    causes.retain(|(cost, _)| *cost < plain);
    causes.sort_by(|a, b| a.0.total_cmp(&b.0));
    Some(Costs { plain, causes })
}

/// Rows by which inputs are recorded late, with the least cost: the best of doubled ones, and from there by halved steps.
fn late(interval: f64, cost: impl Fn(usize) -> Option<f64> + Sync) -> Option<(usize, f64)> {
    let most = if interval > 0.0 { (LATEST / interval) as usize } else { 0 };
    let doubled = std::iter::successors(Some(1_usize), |rows| rows.checked_mul(2)).take_while(|&rows| rows <= most);
    let cost = |&rows: &usize| cost(rows);
    let first = least(doubled.collect(), &cost)?;
    let halvings = first.0.ilog2() as usize;
    let around = |&rows: &usize, share: f64| {
        let step = ((0.5 * share * first.0 as f64) as usize).max(1);
        [rows.checked_sub(step), Some(rows + step)].into_iter().flatten().filter(|&rows| rows > 0).collect()
    };
    Some(pattern_search(first, Patience { moves: 2 * halvings + 2, halvings }, around, cost))
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
            Cause::AbsolutePressures | Cause::Swapped(_) | Cause::Turned(_) | Cause::Late(..) => 0.0,
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
