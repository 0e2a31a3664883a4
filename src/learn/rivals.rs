//! Effects that explain a record as well as one of its faults does.
//!
//! A fault that explains a record within noise and tolerance need not be the only thing that does: slip of a pump that nobody wrote
//! down takes flow as a worn pump does. So the local model of the fit is asked what the record would cost with each effect of the
//! library in place of each fault that is present. Those that promise to cost little more are fitted, and one that ends within
//! `learn.rival_bic` of the fault, by the information criterion, is its rival. What was known before counts: an effect is no rival that
//! needs values to run away from their calibration. A try of an effect is simulated once for all faults; of many effects of a large rig
//! the beginning of the record shows that they take the place of none.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::fitted_model::{FittedModel, Judge};
use super::opened::neutral;
use super::refit::{BasePoint, quick_under, refitted};
use super::scoring::places;
use super::small_tries::small_tries;
use super::trial_steps::{ScoreContext, begins_at_a_level, sign_fits};
use super::verdict::warnings;
use super::warning::Warning;
use crate::complaint::Complaint;
use crate::diagnosis::doubtful::set_aside;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::search::ROUGH;
use crate::diagnosis::{Diagnosed, RivalEffect};
use crate::estimation::{EstimatedAt, Score};
use crate::model::{InputSignals, Model};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::{EffectInstance, FaultSet, Rig};

/// Digits of a size.
const DIGITS: usize = 4;

/// Effects that explain a record as well as a fault of its diagnosis does, for each fault the best first.
///
/// # Errors
/// Columns that are missing, or a [context](crate::Context) that was cancelled.
pub(super) fn rival_effects(rig: &Rig, record: &Record, diagnosed: &Diagnosed) -> Result<Vec<RivalEffect>, Complaint> {
    let Diagnosed { diagnosis, weights, .. } = diagnosed;
    let (cleared, _) = set_aside(rig, record);
    let record = cleared.as_ref().unwrap_or(record);
    let present = |fault: &usize| diagnosis.present().any(|one| one.id == rig.fault_id(*fault));
    let set: FaultSet = (0..rig.faults.len()).filter(present).collect();
    let model = Model::new(rig.clone());
    let drive = InputSignals::from_record(&model.rig, record)?;
    let theta = estimate::picked(rig, &diagnosis.found(rig));
    let estimate = estimate::held_under(&model, record, &drive, (&theta, set), Some(weights))?;
    let base = FittedModel::under(&estimate)?;
    let judge = Judge::of(&base, &base.fit, record)?;
    rig.context().stage("effects in place of faults");
    let promising = promising(&estimate);
    let away = away_from_known(&estimate);
    let one = |((fault, rise), effect)| InPlace { record, base: &base, away, judge: &judge, fault, rise }.of(effect);
    let mut rivals: Vec<RivalEffect> = promising.into_par_iter().filter_map(one).collect();
    let order = |rival: &RivalEffect| diagnosis.present().position(|fault| fault.id == rival.fault);
    rivals.sort_by(|a, b| order(a).cmp(&order(b)).then(b.delta_bic.total_cmp(&a.delta_bic)));
    Ok(rivals)
}

/// How far an explanation is from what was known before, as a square in its standard deviations.
fn away_from_known(estimate: &Estimate<'_>) -> f64 {
    let isolation = &estimate.isolation;
    estimate.case.prior(isolation.set()).misfit(&isolation.best.theta).norm_squared()
}

/// The faults present as the local model has them: how far each is off its healthy value, and how surely.
fn faults_present(estimate: &Estimate<'_>) -> Option<Vec<EstimatedAt>> {
    let (case, isolation) = (&estimate.case, &estimate.isolation);
    let local = &isolation.local;
    let information = case.information(local, isolation.set()).ok()?;
    let one = |fault: usize| {
        let variance = information.direction(fault).map_or(0.0, |direction| direction[fault]);
        let scale = local.scale[fault];
        let healthy = case.rig().parameters[case.rig().faults[fault].parameter].sigma;
        EstimatedAt {
            parameter: fault,
            off: (isolation.best.theta[fault] - case.mean[fault]) / scale,
            variance,
            other_variance: (healthy / scale).powi(2),
        }
    };
    Some(isolation.set().iter().map(one).collect())
}

/// Effects that promise to keep, in place of a fault, what it explains: each with its fault, with what the record would cost more without
/// that, and with the size that it would have.
fn promising(estimate: &Estimate<'_>) -> Vec<((usize, f64), Candidate)> {
    let rig = estimate.case.rig();
    let settings = &rig.settings().learn;
    let (Some(here), Some(faults)) = (ScoreContext::of(estimate, 0.0), faults_present(estimate)) else {
        return Vec::new();
    };
    let places = left_by_the_beginning(estimate, &here, &faults, places(rig));
    let tries = small_tries(&here, &places).into_par_iter().flatten();
    let scored: Vec<_> = tries.filter(|(tried, _)| tried.excited).collect();
    let of_fault = |estimated: &EstimatedAt| {
        let mut kept: Vec<(f64, Candidate)> = Vec::new();
        for (tried, score) in &scored {
            let Some((rise, factor)) = score.in_place_of(*estimated) else { continue };
            let share = 1.0 - rise / estimated.rise();
            if share < settings.rival_share || !sign_fits(rig, &tried.placed, factor) {
                continue;
            }
            // Of several tries of an effect the one that keeps most.
            let place = kept.iter().position(|(_, other)| other.id == tried.id).unwrap_or(kept.len());
            let one = (share, Candidate { factor, ..tried.clone() });
            match kept.get_mut(place) {
                Some(other) if other.0 < share => *other = one,
                Some(_) => {}
                None => kept.push(one),
            }
        }
        kept.sort_by(|a, b| b.0.total_cmp(&a.0));
        let fault = (estimated.parameter, estimated.rise());
        kept.into_iter().take(settings.rivals_fitted).map(move |(_, effect)| (fault, effect))
    };
    faults.iter().flat_map(of_fault).collect()
}

/// Effects that may still take the place of a fault after the beginning of the record. What a rise of the cost is over the whole record
/// is no less over its first rows, everything else free to follow there: an effect that leaves more there than it may leave altogether
/// need not be simulated to the end. Those that begin at a level have another one in each part and are kept.
fn left_by_the_beginning(
    estimate: &Estimate<'_>,
    here: &ScoreContext<'_, '_>,
    faults: &[EstimatedAt],
    places: Vec<EffectInstance>,
) -> Vec<EffectInstance> {
    let case = &estimate.case;
    let (full, set) = (&case.full, estimate.isolation.set());
    // To the end of a phase: what samples of one share is not to be cut.
    let (rows, weights) = full.weights.of_first_phases(telling_rows(estimate, here, faults));
    if 2 * rows > full.times.len() {
        return places;
    }
    let part = case.record.clone().take_first(rows);
    let Ok(drive) = InputSignals::from_record(case.rig(), &part) else { return places };
    let drive = drive.in_run_of(full.drive);
    let at = (&estimate.isolation.best.theta[..], set);
    let Ok(part) = estimate::held_under(full.model, &part, &drive, at, Some(&weights)) else { return places };
    let (Some(there), Some(in_part)) = (ScoreContext::of(&part, 0.0), faults_present(&part)) else { return places };
    let most = 1.0 - case.rig().settings().learn.rival_share;
    let may_be = |(placed, tries): (EffectInstance, Vec<(Candidate, Score)>)| {
        let keeps = |(_, score): &(Candidate, Score)| {
            faults
                .iter()
                .zip(&in_part)
                .any(|(whole, part)| score.in_place_of(*part).is_some_and(|(rise, _)| rise <= most * whole.rise()))
        };
        (begins_at_a_level(&placed) || tries.iter().any(keeps)).then_some(placed)
    };
    let tries = small_tries(&there, &places);
    places.into_par_iter().zip(tries).filter_map(may_be).collect()
}

/// Rows from the first on that hold, of each fault, half as much again as a rival of it may leave of the whole record: enough to see
/// that what does something else explains nothing of it.
fn telling_rows(estimate: &Estimate<'_>, here: &ScoreContext<'_, '_>, faults: &[EstimatedAt]) -> usize {
    let full = &estimate.case.full;
    let rows = full.times.len();
    let share = 1.5 * (1.0 - estimate.case.rig().settings().learn.rival_share);
    let told = |fault: &EstimatedAt| {
        let mut theta = estimate.isolation.best.theta.clone();
        theta[fault.parameter] = estimate.case.mean[fault.parameter];
        let change = here.change_of(&full.parameters(&theta))?;
        let squares: Vec<f64> = (0..rows)
            .map(|row| full.series().into_iter().map(|range| change[range.start + row].powi(2)).sum())
            .collect();
        let enough = share * squares.iter().sum::<f64>();
        let mut sum = 0.0;
        let last = squares.iter().position(|square| {
            sum += square;
            sum >= enough
        });
        Some(last? + 1)
    };
    faults.par_iter().map(|fault| told(fault).unwrap_or(rows)).max().unwrap_or(rows)
}

/// A fault that an effect is to take the place of.
struct InPlace<'a> {
    record: &'a Record,
    /// The model with all faults found.
    base: &'a FittedModel,
    /// How far that is from what was known before, as a square in standard deviations.
    away: f64,
    judge: &'a Judge,
    fault: usize,
    /// What the record would cost more without the fault, by the local model.
    rise: f64,
}

impl InPlace<'_> {
    /// The effect fitted in place of the fault, where it explains the record as well and has sense.
    fn of(&self, effect: Candidate) -> Option<RivalEffect> {
        let Self { record, base, away, judge, fault, rise } = *self;
        let rig = &base.rig;
        let mut values = base.values.clone();
        values[rig.faults[fault].parameter] = rig.faults[fault].healthy;
        let set: FaultSet = base.set.iter().filter(|&other| other != fault).collect();
        let start = [BasePoint { values, set, cost: f64::INFINITY }];
        let effect = Candidate { base_point: Some(0), ..effect };
        // Where the base has its events: what has others there does something else.
        let weights = &base.fit.weights;
        let first = refitted(base, &start, &[], record, std::slice::from_ref(&effect), Some(weights))?;
        let trial = FittedModel::at(&first.rig, record, &first.values, (first.set, first.cost), Some(weights)).ok()?;
        let delta_bic = trial.gain_over(base, record, judge).ok()?;
        let settings = rig.settings();
        // Far beyond where it is straight an effect may leave more than a model without it and without the fault.
        let keeps_nothing = delta_bic < -rise;
        let is_far = delta_bic + settings.diagnosis.predicted_decreases * first.gained < -settings.learn.rival_bic;
        if keeps_nothing || is_far {
            return None;
        }
        let (roughly, further) =
            (Model::new(first.rig.clone()).with_tolerance(ROUGH), (first.set, rig.settings().learn.linearisations));
        let end = quick_under(roughly, record, &first.values, further, Some(weights)).unwrap_or(first);
        // A solution as rough as on the way is off by many standard errors of a large fault.
        let model = Model::new(end.rig.clone());
        let drive = InputSignals::from_record(&model.rig, record).ok()?;
        let theta = estimate::picked(&model.rig, &end.values);
        let estimate = estimate::held_under(&model, record, &drive, (&theta, end.set), Some(weights)).ok()?;
        let trial = FittedModel::under(&estimate).ok()?;
        let delta_bic = trial.gain_over(base, record, judge).ok()? - (away_from_known(&estimate) - away);
        if delta_bic < -rig.settings().learn.rival_bic || warnings(&trial, base).iter().any(Warning::is_senseless) {
            return None;
        }
        let (part, size) = acting(&trial.rig, &trial.values, &effect.id)?;
        let parameter = &trial.rig.parameters[size];
        Some(RivalEffect {
            fault: rig.fault_id(fault).to_owned(),
            effect: effect.id,
            part: part.to_owned(),
            value: rounded(parameter.unit.from_si(trial.values[size]), DIGITS),
            unit: parameter.unit.symbol.clone(),
            delta_bic: rounded(delta_bic, DIGITS),
        })
    }
}

/// The part of an effect that does most, by the size at which it is first tried, with its index; the first one where none does anything.
fn acting(rig: &Rig, values: &[f64], effect: &str) -> Option<(&'static str, usize)> {
    let added = rig.effects.iter().find(|one| one.id == effect)?;
    let parts = added.placed.effect.parameters.iter().zip(&added.parameters).map(|(free, &index)| {
        let moved = neutral(rig, &added.placed, free).zip(rig.first_size(&added.placed, free));
        let tries = moved.map(|(neutral, first)| ((values[index] - neutral) / (first - neutral)).abs());
        (tries.filter(|tries| tries.is_finite()).unwrap_or(0.0), free.name, index)
    });
    let most = parts.reduce(|most, part| if part.0 > most.0 { part } else { most })?;
    Some((most.1, most.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_of_an_effect_that_acts_is_the_one_that_is_told() {
        let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
        for ([coulomb, breakaway], part) in [([0, 200], "breakaway"), ([200, 0], "coulomb"), ([0, 0], "coulomb")] {
            let given = format!("coulomb = \"{coulomb} N\", breakaway = \"{breakaway} N\"");
            let effect = format!("\n[effects]\n\"seal-friction@cylinder\" = {{ {given} }}\n");
            let rig = Rig::parse("rig.toml", text.clone() + &effect).unwrap();
            let values: Vec<f64> = rig.parameters.iter().map(|parameter| parameter.value).collect();
            let (told, index) = acting(&rig, &values, "seal-friction@cylinder").unwrap();
            assert_eq!(
                (told, rig.parameters[index].id.as_str()),
                (part, format!("seal-friction@cylinder.{part}").as_str())
            );
        }
    }
}
