//! One mistake in how a record was taken, instead of several faults: a clock that runs fast, absolute pressures taken for gauge,
//! columns that are swapped, a sensor that counts the other way, a command that is recorded after it has acted; or oil that is warmer than
//! that of the rig file, which moves everything viscous at once.
//!
//! Each is a transformation of the record, or of the rig, that can be taken back. The corrected record is explained by the same search as any
//! other, so a common cause competes with fault combinations by the same evidence: it counts as one fault. A clock and an oil have a
//! size besides, whose Occam factor is that of its range.

use rayon::prelude::*;

use super::case::robust;
use super::cause::{Cause, Inputs};
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
use crate::record::Record;
use crate::rig::Rig;

/// How late inputs are recorded at most, s: buffers of a bus and of a logger hold tenths of a second.
const LATEST: f64 = 0.5;

/// Share of what a simpler story leaves that a cause has to go below to be asked before everything else.
const CLEARLY_LESS: f64 = 0.5;
/// First steps of the search for another viscosity, as a logarithm; they are halved down to 2 %.
const OIL_STEP: f64 = 0.35;
const OIL_HALVINGS: usize = 4;

/// A record without a mistake in taking it, and the rig, both as they were in truth.
pub(super) struct Corrected {
    pub model: Model,
    pub record: Record,
    pub cause: CommonCause,
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

/// Whether a record looks as if a mistake was made in taking it: no fault explains it, or it takes faults of several sensors.
fn is_by_record(model: &Model, plain: &Diagnosed) -> bool {
    let rig = &model.rig;
    let faults = plain.diagnosis.faults.iter().zip(&rig.faults).filter(|(report, _)| report.present);
    !plain.diagnosis.is_explained() || faults.filter(|(_, fault)| rig.is_of_sensor(fault.parameter)).count() >= 2
}

/// Whether a common cause is asked for: of what such causes look like, and of other oil alone where a record takes several faults of any
/// other kind.
pub(super) fn is_asked(model: &Model, plain: &Diagnosed) -> bool {
    is_by_record(model, plain) || plain.diagnosis.present().count() >= 2
}

/// The corrected record and its common cause, where that explains a record better than the fault combination of `plain` does.
pub(super) fn instead(model: &Model, record: &Record, plain: &Diagnosed) -> Option<Corrected> {
    let (rig, by_record) = (&model.rig, is_by_record(model, plain));
    let mut causes = promising(model, record, by_record);
    if by_record {
        causes.extend(fitted(model, record, Cause::FastClock, 0.0));
    }
    let explained: Vec<Explained> = causes.into_par_iter().filter_map(|cause| explain(model, record, cause)).collect();
    let explains = explained.into_iter().filter(|one| !one.missed);
    let margin = |one: &Explained| one.evidence - plain.evidence_under(&one.weights, rig, record);
    let (margin, best) = explains.map(|one| (margin(&one), one)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (margin > 0.0).then(|| Corrected {
        model: best.cause.model(model),
        record: best.record,
        cause: best.cause.report(rig, record, plain.diagnosis.present().map(|fault| fault.id.clone()).collect()),
    })
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
    let Some(Costs { plain, causes }) = costs(model, record, true) else { return Ok(None) };
    let Some(&(_, cause)) = causes.first().filter(|(cost, _)| *cost < CLEARLY_LESS * plain) else { return Ok(None) };
    let Some(cause) = at_best(model, record, cause) else { return Ok(None) };
    let corrected = Corrected {
        model: cause.model(model),
        record: cause.corrected(rig, record),
        cause: cause.report(rig, record, Vec::new()),
    };
    let is_wanted = |estimate: &Estimate<'_>| estimate.explains() && estimate.isolation.set().len() <= 1;
    let attempt = Attempt { is_wanted: Some(&is_wanted), ..Attempt::default() };
    let found = diagnose_again(&corrected.model, &corrected.record, (&[], None), options, attempt)?;
    Ok(found.filter(|found| found.diagnosis.is_explained()).map(|found| found.of(corrected)))
}

/// A cause at the size at which everything uncertain follows it best; as it is where it has none that can be fitted.
fn at_best(model: &Model, record: &Record, cause: Cause) -> Option<Cause> {
    match cause {
        Cause::OtherOil(share) => fitted(model, record, Cause::OtherOil, share),
        _ => Some(cause),
    }
}

impl Diagnosed {
    /// The same as the diagnosis of the record as it stands.
    pub(super) fn of(mut self, Corrected { model, record, cause }: Corrected) -> Self {
        self.diagnosis.common_cause = Some(cause);
        self.corrected = Some(record);
        self.other_rig.get_or_insert(model.rig);
        self
    }

    /// Logarithm of the evidence, had the record been weighed otherwise: costs compare under common weights only.
    pub(super) fn evidence_under(&self, weights: &Weights, rig: &Rig, record: &Record) -> f64 {
        let Ok(measured) = weighed::measured(rig, record) else { return f64::NEG_INFINITY };
        let mut misfit = away(&self.model, &measured);
        weights.apply(&mut misfit);
        let own: f64 = self.misfit.iter().map(|channel| robust(rig).cost(channel)).sum();
        self.evidence + own - robust(rig).cost(&misfit)
    }
}

/// Causes that leave the healthy model less to explain than the record as it stands does, the best first, as many as are explained: of
/// any kind and `clearly`, or other oil alone.
fn promising(model: &Model, record: &Record, clearly: bool) -> Vec<Cause> {
    let mut causes = costs(model, record, clearly).map_or_else(Vec::new, |costs| costs.causes);
    causes.retain(|(_, cause)| clearly || matches!(cause, Cause::OtherOil(_)));
    let best = causes.into_iter().take(model.rig.settings().diagnosis.causes_explained);
    best.filter_map(|(_, cause)| at_best(model, record, cause)).collect()
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
fn costs(model: &Model, record: &Record, clearly: bool) -> Option<Costs> {
    let rig = &model.rig;
    let healthy = rig.healthy();
    let outputs = |values: &[f64], record: &Record| {
        let drive = InputSignals::from_record(rig, record).ok()?;
        Some(model.solve(values, &drive, &record.time).ok()?.values)
    };
    let cost = |outputs: &[Vec<f64>], record: &Record| -> Option<f64> {
        let mut misfit = away(outputs, &weighed::measured(rig, record).ok()?);
        for (misfit, sensor) in misfit.chunks_mut(record.time.len().max(1)).zip(&rig.sensors) {
            misfit.iter_mut().for_each(|value| *value = if value.is_nan() { 0.0 } else { *value / sensor.noise });
        }
        Some(robust(rig).cost(&misfit))
    };
    let as_it_stands = outputs(&healthy, record)?;
    let plain = cost(&as_it_stands, record)?;
    let discrete = Cause::discrete(rig).into_iter();
    let mut causes: Vec<(f64, Cause)> =
        discrete.filter_map(|cause| Some((cost(&as_it_stands, &cause.corrected(rig, record))?, cause))).collect();
    let of_cause = |cause: Cause| {
        let corrected = cause.corrected(rig, record);
        cost(&outputs(&cause.values(rig, &healthy), &corrected)?, &corrected)
    };
    let interval = record.sampling().map_or(0.0, |sampling| sampling.interval);
    causes.extend(Inputs::groups(rig).into_iter().filter_map(|inputs| {
        let (rows, cost) = late(interval, |rows| of_cause(Cause::Late(inputs, rows)))?;
        // By no more than what follows lags behind, that may be as much faster.
        (rows as f64 * interval >= inputs.followed_within(rig)).then_some((cost, Cause::Late(inputs, rows)))
    }));
    // A temperature that is recorded says what the viscosity is.
    if !rig.viscosity_varies() {
        let (thinner, all) = other_oil(plain, |thinner| of_cause(Cause::OtherOil(thinner.exp() - 1.0)));
        let by_one = |parameter: usize| {
            let values = |thinner: f64| {
                let mut values = healthy.clone();
                values[parameter] = rig.in_oil(thinner.exp(), &healthy)[parameter];
                values
            };
            other_oil(plain, |thinner| cost(&outputs(&values(thinner), record)?, record)).1
        };
        // One value that is another is a fault, and no oil; several are asked by their evidence.
        let is_clear = || {
            let mut viscous = rig.viscous().filter(|&parameter| healthy[parameter] != 0.0);
            all < CLEARLY_LESS * plain && viscous.all(|parameter| all < CLEARLY_LESS * by_one(parameter))
        };
        if !clearly || is_clear() {
            causes.push((all, Cause::OtherOil(thinner.exp() - 1.0)));
        }
    }
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

/// How much more easily the oil flows, as a logarithm, with the least cost; `plain` is that of the oil as stated.
fn other_oil(plain: f64, cost: impl Fn(f64) -> Option<f64> + Sync) -> (f64, f64) {
    let around = |&at: &f64, share: f64| vec![at - share * OIL_STEP, at + share * OIL_STEP];
    pattern_search((0.0, plain), Patience { moves: 4 * OIL_HALVINGS, halvings: OIL_HALVINGS }, around, |&at| cost(at))
}

/// A cause of a size, from a first one, with that at which the model without faults explains the record best; `None` beyond what is searched.
fn fitted(model: &Model, record: &Record, of: fn(f64) -> Cause, mut share: f64) -> Option<Cause> {
    let settings = &model.rig.settings().diagnosis;
    let mut best = (f64::INFINITY, share);
    for _ in 0..settings.cause_improvements {
        let cause = of(share);
        let (with, corrected) = (cause.model(model), cause.corrected(&model.rig, record));
        let drive = InputSignals::from_record(&with.rig, &corrected).ok()?;
        let near = estimate::near(&with, &corrected, &drive, None, 1).ok()?;
        let healthy = near.without_faults(settings.cause_linearisations).ok()?;
        // Where a size is what is wrong, each step leaves less.
        if healthy.isolation.best.cost >= best.0 {
            share = best.1;
            break;
        }
        best = (healthy.isolation.best.cost, share);
        let score = score_of_size(&healthy, of)?;
        // What is left of the first size r by a further one s: (1 + r)(1 + s) - 1.
        share = (1.0 + share).mul_add(1.0 + cause.tried(settings) * score.factor, -1.0);
        // Not a number where oil would have to flow backwards.
        let is_possible = share.ln_1p().abs() <= cause.most(settings);
        if !is_possible {
            return None;
        }
        // Less than a standard error further: the size stands.
        if score.factor * score.factor * score.information < 1.0 {
            break;
        }
    }
    // One that asks for nothing is none.
    (share != 0.0).then(|| of(share))
}

/// What the misfits say of a further size, in units of that which is tried, everything uncertain following.
fn score_of_size(near: &Estimate<'_>, of: fn(f64) -> Cause) -> Option<Score> {
    let (case, isolation) = (&near.case, &near.isolation);
    let (full, best) = (&case.full, &isolation.best);
    let values = full.parameters(&best.theta);
    let cause = of(of(0.0).tried(case.settings()));
    let record = cause.corrected(case.rig(), case.record);
    let drive = InputSignals::from_record(case.rig(), &record).ok()?;
    let plain = full.model.solve(&values, full.drive, full.times).ok()?.values;
    let with = full.model.solve(&cause.values(case.rig(), &values), &drive, &record.time).ok()?.values;
    let test = isolation.local.score_test(&case.problem(isolation.set()), &best.theta, &best.misfit).ok()?;
    Some(test.of(&full.weights.change(&with, &plain)))
}

/// A cause taken back, and the record then explained like any other.
fn explain(model: &Model, record: &Record, cause: Cause) -> Option<Explained> {
    let (with, record) = (cause.model(model), cause.corrected(&model.rig, record));
    let (evidence, weights, missed) = {
        let drive = InputSignals::from_record(&model.rig, &record).ok()?;
        let near = estimate::near(&with, &record, &drive, None, model.rig.settings().diagnosis.healthy_rounds).ok()?;
        let size = match cause {
            Cause::FastClock(_) => occam_of_size(&near, Cause::FastClock).unwrap_or(0.0),
            Cause::OtherOil(_) => occam_of_size(&near, Cause::OtherOil).unwrap_or(0.0),
            Cause::AbsolutePressures | Cause::Swapped(_) | Cause::Turned(_) | Cause::Late(..) => 0.0,
        };
        let evidence = near.isolation.evidence(&near.case) + prior_odds(&near.case) + size;
        (evidence, near.case.full.weights.clone(), near.missed())
    };
    Some(Explained { cause, record, evidence, weights, missed })
}

/// Logarithm of the share of its range that the record leaves the size of a cause (Laplace's approximation).
fn occam_of_size(near: &Estimate<'_>, of: fn(f64) -> Cause) -> Option<f64> {
    let (settings, cause) = (near.case.settings(), of(0.0));
    let sigma = cause.tried(settings) / score_of_size(near, of)?.information.sqrt();
    Some(((2.0 * std::f64::consts::PI).sqrt() * sigma / (2.0 * cause.most(settings))).ln().min(0.0))
}
