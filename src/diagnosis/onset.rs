//! Since when: faults that begin within the record.
//!
//! Until a fault begins the healthy rig explains the record better than the faulty one, from then on worse. So the running
//! sum of the logarithm of their likelihood ratio is least where it began (maximum-likelihood change point; Hinkley,
//! Biometrika 57 (1970)). A beginning within the record is believed where it explains the record better than faults as old
//! as the record by more than a moment chosen freely among all rows would by chance.

use rayon::prelude::*;

use super::case::Case;
use super::estimate::{self, Estimate, picked};
use super::hypotheses::Isolation;
use super::missed::{tame, tame_squares};
use super::noise::Weights;
use super::problem::away;
use crate::estimation::Problem;
use crate::model::{Before, InputSignals, Model, Onset};
use crate::record::Record;
use crate::residual::Detection;
use crate::rig::FaultSet;

/// A beginning within the record, and the faults since then.
pub struct Begun {
    pub drive: InputSignals,
    /// s.
    pub time: f64,
    /// All estimated parameters, SI.
    pub theta: Vec<f64>,
    pub set: FaultSet,
}

/// Whether an explanation by faults as old as the record says since when it parts from the healthy rig. Several faults, values far from
/// where they are expected, or what does not explain the record, may all stand in for one that is not there.
pub fn is_believed(first: &Estimate<'_>) -> bool {
    let (case, best) = (&first.case, &first.isolation.best);
    let few = first.isolation.set().len() < case.settings().several_faults;
    !first.missed() && few && !case.is_strained(&best.theta) && first.explains()
}

/// Looks for a beginning of the faults within the record; `first` is an explanation by faults as old as the record, good or
/// bad, and `model` is that of its rig [with what faults were before](crate::rig::Rig::with_before). `None` also where the
/// model cannot be solved with one. Where none was found with other values open, it is looked for only if it frees something.
pub fn find(
    model: &Model,
    record: &Record,
    (plain, is_asked_again): (&InputSignals, bool),
    first: &Estimate<'_>,
) -> Option<Begun> {
    let settings = first.case.settings();
    let worth = settings.onset_evidence + (record.time.len() as f64).ln();
    let shaken = plain.pieces.iter().skip(1).find(|piece| piece.jump).map_or(f64::INFINITY, |piece| piece.start);
    let row = if is_believed(first) { parting(&first.case, &first.isolation, plain, worth) } else { left(&first.case) };
    let old = [record.time.first().copied()?, shaken];
    let row = row.filter(|&row| old.iter().all(|old| (record.time[row] - old).abs() > settings.onset_clearance))?;
    let mut time = record.time[row];
    if is_asked_again && !frees_something((model, record), begun(model, plain, time), first, worth) {
        return None;
    }
    let mut found: Option<(Begun, f64, f64)> = None;
    let is_worth_it = |cost: f64| 0.5 * (first.isolation.best.cost - cost) > worth;
    // The last round is to see whether the moment that it was given is a better one.
    for _ in 0..=settings.onset_rounds {
        let drive = begun(model, plain, time);
        let start = found.as_ref().map(|(known, ..)| (&known.theta[..], known.set));
        let Ok(explained) = estimate::estimate(model, record, &drive, start) else { break };
        let (theta, set) = (explained.isolation.best.theta.clone(), explained.isolation.set());
        let cost = explained.isolation.best.cost;
        if found.as_ref().is_some_and(|(_, known, _)| cost >= *known) {
            break;
        }
        if set.is_empty() {
            return None;
        }
        let (better, [here, there]) = refined(&explained.case, |time| begun(model, plain, time), &theta, time);
        // What creeps, and no other moment helps, is no onset.
        let is_stuck = explained.missed() && there > (1.0 - settings.growth_share) * here;
        if is_stuck && cost > settings.stuck_share * first.isolation.best.cost {
            return None;
        }
        found = Some((Begun { drive, time, theta, set }, cost, here));
        // The moment alone brings this much, and everything that follows it about as much again.
        if is_stuck || better == time || !is_worth_it(cost - 2.0 * (here - there)) {
            break;
        }
        time = better;
    }
    let (begun, cost, by_record) = found.filter(|(_, cost, _)| is_worth_it(*cost))?;
    // Do the same faults, as old as the record, explain it as well?
    let theta = &begun.theta[..first.case.count()];
    let old =
        estimate::near(first.case.full.model, record, plain, Some((theta, begun.set)), settings.onset_rounds_compared);
    let old = old.ok().filter(|old| old.isolation.best.cost < first.isolation.best.cost);
    let Estimate { case, isolation } = old.as_ref().unwrap_or(first);
    let better = 0.5 * (isolation.best.cost - cost);
    // The model's own event at the beginning has a tolerance that a model without it has not: weighed alike it has to be better too.
    let misfit = weighed_by(&estimate::by_the_record(case), case, plain, &isolation.best.theta)?;
    let alike = 0.5 * (tame_squares(settings, &misfit) - by_record);
    (better.min(alike) > worth).then_some(begun)
}

/// Whether a beginning frees the first explanation from what speaks against it before: near it, there is one that leaves less by more than
/// `worth` nats, and explains the record or leaves less than what follows any misfit a little. Else others need not be looked for everywhere.
fn frees_something((model, record): (&Model, &Record), drive: InputSignals, first: &Estimate<'_>, worth: f64) -> bool {
    let mut theta = picked(&model.rig, &model.rig.healthy());
    let known = &first.isolation.best.theta;
    theta[..known.len()].copy_from_slice(known);
    let settings = first.case.settings();
    let before = first.isolation.best.cost;
    let near =
        estimate::near(model, record, &drive, Some((&theta, first.isolation.set())), settings.onset_rounds_compared);
    near.is_ok_and(|freed| {
        let after = freed.isolation.best.cost;
        0.5 * (before - after) > worth && (!freed.missed() || after < settings.stuck_share * before)
    })
}

/// The drive with every fault at what it was before until `time`.
fn begun(model: &Model, plain: &InputSignals, time: f64) -> InputSignals {
    let before = model.rig.before.iter().map(|&(fault, before)| (fault, Before::Like(before))).collect();
    plain.clone().with_onset(Onset { time, before })
}

/// The row from which on the healthy rig misses the record, whatever explains it: where the running sum of its squared
/// misfits less a level between noise and their mean is least. `None` where it cannot be simulated, or never follows the record.
fn left(case: &Case<'_>) -> Option<usize> {
    let healthy = by_sample(case, case.full.drive, &case.mean)?;
    let rows = case.full.times.len();
    let series = case.full.series();
    let square = |row: usize| series.iter().map(|range| tame(case.settings(), healthy[range.start + row])).sum::<f64>();
    let squares: Vec<f64> = (0..rows).map(square).collect();
    // Noise alone makes a square of 1 in each channel.
    let between = f64::midpoint(series.len() as f64, squares.iter().sum::<f64>() / rows as f64);
    let (row, _) = least(squares.iter().map(|square| square - between));
    (0 < row && row < rows).then_some(row)
}

/// The row from which on the best explanation with faults explains the record best, if the healthy rig is better for a while
/// by more than `worth` nats; `None` where no faults explain anything or the healthy rig cannot be simulated.
///
/// Faults that begin late may, as old as the record, lose to the healthy rig: they are tried too.
fn parting(case: &Case<'_>, isolation: &Isolation, plain: &InputSignals, worth: f64) -> Option<usize> {
    let (set, faulty) = if isolation.set().is_empty() {
        let fitted = isolation.weighed.iter().filter(|other| !other.set.is_empty());
        fitted.filter_map(|other| Some((other.set, other.point.as_ref()?))).next()?
    } else {
        (isolation.set(), &isolation.best)
    };
    let mut theta = faulty.theta.clone();
    set.iter().for_each(|fault| theta[fault] = case.mean[fault]);
    let rows = case.full.times.len();
    let series = case.full.series();
    let parted = |healthy: &[f64], faulty: &[f64]| {
        let gain = |at: usize| 0.5 * (tame(case.settings(), healthy[at]) - tame(case.settings(), faulty[at]));
        least((0..rows).map(|row| series.iter().map(|range| gain(range.start + row)).sum()))
    };
    let (row, sum) = parted(&case.full.misfit(&theta).ok()?, &faulty.misfit);
    if row == rows || -sum <= worth {
        return None;
    }
    let before: Vec<(usize, Before)> =
        set.iter().map(|fault| (case.full.estimated[fault].parameter, Before::Value(case.mean[fault]))).collect();
    let begun = |time: f64| plain.clone().with_onset(Onset { time, before: before.clone() });
    let (time, _) = refined(case, begun, &faulty.theta, case.full.times[row]);
    Some(case.full.times.partition_point(|&t| t < time).min(rows - 1))
}

/// Misfits of all samples, each on its own: what those of a phase have in common would smear a beginning over all of it.
/// `None` where the model cannot be solved.
pub(super) fn by_sample(case: &Case<'_>, drive: &InputSignals, theta: &[f64]) -> Option<Vec<f64>> {
    weighed_by(&case.full.weights, case, drive, theta)
}

/// The same with other weights.
fn weighed_by(weights: &Weights, case: &Case<'_>, drive: &InputSignals, theta: &[f64]) -> Option<Vec<f64>> {
    let full = &case.full;
    let outputs = full.model.solve(&full.parameters(theta), drive, full.times).ok()?;
    let mut misfit = away(&outputs.values, &full.measured);
    weights.scale(&mut misfit);
    Some(misfit)
}

/// Where the running sum is least, as the number of values summed, and the sum there.
fn least(values: impl Iterator<Item = f64>) -> (usize, f64) {
    let (mut sum, mut least) = (0.0, (0, 0.0));
    for (row, value) in values.enumerate() {
        sum += value;
        if sum < least.1 {
            least = (row + 1, sum);
        }
    }
    least
}

/// The moment at which a beginning explains the record best, s, with the faults as they are: from the best of `from` and
/// moments all over the record, since where several faults begin at once each of them shows at its own time; and the costs at `from`
/// and there, weighed by the record.
fn refined(case: &Case<'_>, begun: impl Fn(f64) -> InputSignals + Sync, theta: &[f64], from: f64) -> (f64, [f64; 2]) {
    let (times, settings) = (case.full.times, case.settings());
    // Weights that a model has given its events would hide an event that it has at the wrong moment.
    let weights = estimate::by_the_record(case);
    let cost = |time: f64| {
        let misfit = weighed_by(&weights, case, &begun(time), theta);
        misfit.map_or(f64::INFINITY, |misfit| tame_squares(settings, &misfit))
    };
    let (first, last) = (times[0], times[times.len() - 1]);
    let mut step = (last - first) / settings.onset_moments as f64;
    let moments = (1..settings.onset_moments).map(|k| first + k as f64 * step);
    let tried: Vec<(f64, f64)> = moments.collect::<Vec<_>>().into_par_iter().map(|time| (time, cost(time))).collect();
    let start = (from, cost(from));
    let mut best = tried.into_iter().fold(start, |best, other| if other.1 < best.1 { other } else { best });
    for _ in 0..settings.onset_refinements {
        // Uphill on both sides before the step becomes smaller.
        loop {
            let sides = [best.0 - step, best.0 + step].map(|time| time.clamp(first, last));
            let tried = sides.map(|time| (time, cost(time)));
            let better = if tried[0].1 < tried[1].1 { tried[0] } else { tried[1] };
            if better.1 >= best.1 {
                break;
            }
            best = better;
        }
        step /= 3.0;
    }
    (best.0, [start.1, best.1])
}

/// When the record begins to show the faults found, s: where the running sum of the log likelihood ratio between the fitted model with
/// and without them, started again at every minimum, passes the logarithm of the number of rows between false alarms. For a likelihood
/// ratio that is Lorden's bound (Annals of Mathematical Statistics 42 (1971), theorem 2). Used where the rig has no residual that fires.
pub fn parted_at(estimate: &Estimate<'_>, detection: &Detection) -> Option<f64> {
    let Estimate { case, isolation } = estimate;
    let problem = &case.full;
    // Everything uncertain as fitted: what it differs by from what was known before is there from the first row on.
    let (set, mut theta) = (isolation.set(), isolation.best.theta.clone());
    if set.is_empty() {
        theta.clone_from(&case.mean);
    }
    set.iter().for_each(|fault| theta[fault] = case.mean[fault]);
    let [without, with] = [&theta, &isolation.best.theta].map(|theta| by_sample(case, problem.drive, theta));
    let (without, with) = (without?, with?);
    let rows = problem.times.len();
    let span = problem.times.last()? - problem.times.first()?;
    let between = detection.hours_between_false_alarms * 3600.0 * rows as f64 / span;
    let tame = |misfit: f64| tame(case.settings(), misfit);
    let mut sum = 0.0_f64;
    let alarm = (0..rows).find(|&row| {
        let samples = problem.series().into_iter().map(|range| range.start + row);
        let gain: f64 = samples.map(|at| 0.5 * (tame(without[at]) - tame(with[at]))).sum();
        sum = (sum + gain).max(0.0);
        sum > between.ln()
    })?;
    problem.times.get(alarm).copied()
}
