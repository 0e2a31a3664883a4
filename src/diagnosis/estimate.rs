//! From a record to its explanation: weights, starts, isolation, until nothing moves any more.

use rayon::prelude::*;

use super::case::Case;
use super::events::weights;
use super::hypotheses::{Isolation, Stopped, held, isolate, isolate_from};
use super::instead::instead;
use super::noise::{self, Weights};
use super::preliminary::quick;
use super::problem::{over_sensors, root_mean_square};
use super::search::{self, roughly};
use super::unseen::{in_step, simpler, unseen};
use super::weighed::{case_at, measured, renewed, unsolvable, unweighed};
use super::weighing::Weighed;
use crate::complaint::Complaint;
use crate::estimation::criteria::bic;
use crate::estimation::{FitError, Options};
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::{FaultSet, Rig, Sensor};

/// The explanation of a record.
pub struct Estimate<'a> {
    pub case: Case<'a>,
    pub isolation: Isolation,
}

/// Explains a record by faults of the rig: from a guess of all estimated parameters and the set of faults or else from the
/// healthy rig; where that misses, from the places that few faults at a time explain best.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved at any start.
pub fn estimate<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    guess: Option<(&[f64], FaultSet)>,
) -> Result<Estimate<'a>, Complaint> {
    let mut near = from_start(model, record, drive, guess)?;
    if !near.missed() {
        return Ok(near);
    }
    let places = near.places();
    Ok(near.best_from_places(&places, model.rig.settings().diagnosis.isolation_rounds))
}

/// The same from its start alone, to its end from a guess, in few rounds from the healthy rig; it may miss.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved there.
pub fn from_start<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    guess: Option<(&[f64], FaultSet)>,
) -> Result<Estimate<'a>, Complaint> {
    let settings = &model.rig.settings().diagnosis;
    let rounds = if guess.is_some() { settings.isolation_rounds } else { settings.healthy_rounds };
    near(model, record, drive, guess, rounds)
}

/// Explains a record as that of the healthy rig, weighed by where the healthy model has its events, and isolates from there in so many
/// rounds; `None` where that misses. A record that is nearly healthy is found to be so without a detour over weights that know of no
/// events but those that noise lets see.
fn nearly_healthy<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    rounds: u64,
) -> Result<Option<Estimate<'a>>, Complaint> {
    let mean = unweighed(model, record, drive)?.mean;
    // Where the healthy model cannot be solved there is nothing to begin from.
    let Ok(Estimate { mut case, isolation }) = held_near(model, record, drive, (&mean, FaultSet::EMPTY)) else {
        return Ok(None);
    };
    if missed(&case, &isolation) {
        return Ok(None);
    }
    let isolation = settle(&mut case, &isolation.best.theta, FaultSet::EMPTY, rounds)
        .map_err(|error| unsolvable(model, record, error))?;
    Ok(Some(Estimate { case, isolation }).filter(|estimate| !estimate.missed()))
}

/// Explains a record from a guess or from the healthy rig alone, in so many rounds; it may miss.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved there.
pub fn near<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    guess: Option<(&[f64], FaultSet)>,
    rounds: u64,
) -> Result<Estimate<'a>, Complaint> {
    let mut case = match guess {
        Some((theta, _)) => {
            let mut case = unweighed(model, record, drive)?;
            case.full.weights = weights(&case.full, record, theta).map_err(|error| unsolvable(model, record, error))?;
            case
        }
        None => {
            if let Some(healthy) = nearly_healthy(model, record, drive, rounds)? {
                return Ok(healthy);
            }
            let data = measured(&model.rig, record)?;
            let weights = rough(model, record, drive, &data);
            Case::new(model, record, drive, data, weights)
        }
    };
    let healthy = case.mean.clone();
    let (start, set) = guess.unwrap_or((&healthy[..], FaultSet::EMPTY));
    let isolation = settle(&mut case, start, set, rounds).map_err(|error| unsolvable(model, record, error))?;
    Ok(Estimate { case, isolation })
}

/// Isolates the faults of a record from values of all estimated parameters that are near already, with weights of there.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved there.
pub fn isolated<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    (theta, set): (&[f64], FaultSet),
    rounds: u64,
) -> Result<Estimate<'a>, Complaint> {
    let (case, form) = case_at(model, record, drive, theta, None)?;
    let isolation =
        isolate_from(&case, form, (set, Vec::new()), rounds).map_err(|error| unsolvable(model, record, error))?;
    Ok(Estimate { case, isolation })
}

/// The record as the faults of a set explain it best, from values of all estimated parameters, with so many linearisations.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved there.
pub fn held_at<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    (start, set): (&[f64], FaultSet),
    forms: usize,
) -> Result<Estimate<'a>, Complaint> {
    let theta = quick(&roughly(model), record, drive, (start, set), forms, None)?.theta;
    held_near(model, record, drive, (&theta, set))
}

/// The same from values that are near already, with one linearisation.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved there.
pub fn held_near<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    at: (&[f64], FaultSet),
) -> Result<Estimate<'a>, Complaint> {
    held_under(model, record, drive, at, None)
}

/// The same under given weights.
///
/// # Errors
/// As [`held_near`].
pub fn held_under<'a>(
    model: &'a Model,
    record: &'a Record,
    drive: &'a InputSignals,
    (theta, set): (&[f64], FaultSet),
    weights: Option<&Weights>,
) -> Result<Estimate<'a>, Complaint> {
    let (case, form) = case_at(model, record, drive, theta, weights)?;
    let isolation = held(&case, form, set).map_err(|error| unsolvable(model, record, error))?;
    Ok(Estimate { case, isolation })
}

impl<'a> Estimate<'a> {
    /// Places that few faults explain best, the record weighed as before any model has followed it.
    pub fn places(&mut self) -> Vec<search::Place> {
        let case = &mut self.case;
        let rough = by_the_record(case);
        let weights = std::mem::replace(&mut case.full.weights, rough);
        let places = search::places(case, search::Depth::several(case.settings()));
        self.case.full.weights = weights;
        places
    }

    /// Explains the record again from these of its places, each in so many rounds of isolation, if any of them does better.
    #[must_use]
    pub fn best_from_places(mut self, places: &[search::Place], rounds: u64) -> Self {
        let mut explained = self.explains();
        for place in places {
            let (before, evidence) = (self.case.full.weights.clone(), weighed_evidence(&self.case, &self.isolation));
            let theta = place.theta(&self.case);
            // A place from which the model cannot be solved is passed over.
            let known = place.weights.clone().map(Ok);
            let weights = known.unwrap_or_else(|| weights(&self.case.full, self.case.record, &theta));
            let isolation = weights.map_err(FitError::from).and_then(|weights| {
                self.case.full.weights = weights;
                settle(&mut self.case, &theta, place.set(), rounds)
            });
            let Ok(isolation) = isolation else {
                self.case.full.weights = before;
                continue;
            };
            let explains = explains(&self.case, &isolation);
            let is_better = match (missed(&self.case, &isolation), self.missed()) {
                _ if explains != explained => explains,
                (false, true) => true,
                (true, false) => false,
                (true, true) => isolation.best.cost < self.isolation.best.cost,
                (false, false) => weighed_evidence(&self.case, &isolation) > evidence,
            };
            if is_better {
                (self.isolation, explained) = (isolation, explains);
            } else {
                self.case.full.weights = before;
            }
            if explained {
                break;
            }
        }
        self
    }

    /// The explanation and its weights, to come back to.
    pub fn explanation(&self) -> (Weights, Isolation) {
        (self.case.full.weights.clone(), self.isolation.clone())
    }

    /// Takes another explanation of the record, and gives back the one before.
    pub fn explained(&mut self, (weights, isolation): (Weights, Isolation)) -> (Weights, Isolation) {
        let weights = std::mem::replace(&mut self.case.full.weights, weights);
        (weights, std::mem::replace(&mut self.isolation, isolation))
    }

    /// The same explanation with a model that is solved to another tolerance, where its search ends.
    ///
    /// # Errors
    /// The model cannot be solved there.
    pub fn with_model(mut self, model: &'a Model) -> Result<Self, Complaint> {
        let (set, rough) = (self.isolation.set(), self.isolation);
        self.case.full.model = model;
        let record = self.case.record;
        let most_rounds = self.case.settings().isolation_rounds;
        let exact = rough.again(&self.case, &rough.best.theta, set, most_rounds);
        let mut exact = exact.map_err(|error| unsolvable(model, record, error))?;
        // Sets that take turns keep each other from their bottom, and intervals around anything else lead from one start to the next.
        if exact.stopped == Stopped::Rounds
            && let Ok(lowest) = self.case.descended(exact.set(), &exact.best.theta)
            && let Ok(further) = exact.again(&self.case, &lowest.theta, exact.set(), most_rounds)
        {
            exact = Isolation { rounds: exact.rounds + lowest.iterations + further.rounds, ..further };
        }
        Ok(Self { case: self.case, isolation: Isolation { rounds: rough.rounds + exact.rounds, ..exact } })
    }

    /// Walks the last steps, which tell no fault combination from another, along the local model at hand.
    pub fn walk_to_the_bottom(&mut self) {
        let set = self.isolation.set();
        let (case, isolation) = (&self.case, &mut self.isolation);
        let settings = case.settings();
        let steps = Options::steps(settings.isolation_steps, settings.final_decrease);
        let Ok(lowest) = case.fit(&isolation.local, set, &isolation.best.theta, steps) else { return };
        if lowest.cost <= isolation.best.cost {
            isolation.best = lowest.clone();
            isolation.weighed.iter_mut().take(1).for_each(|best| best.point = Some(lowest.clone()));
        }
    }

    /// Weighs what may stand in place of a present fault with the rest. Whether one is the better and stands there now, if it may.
    pub fn ask_instead(&mut self, may_change: bool) -> bool {
        let others = instead(&self.case, &self.isolation);
        let score = self.isolation.weighed.first().map_or(0.0, |best| best.score);
        let best = others.iter().max_by(|a, b| a.score.total_cmp(&b.score)).filter(|other| other.score > score);
        if let Some((set, point)) = best.and_then(|best| Some((best.set, best.point.as_ref()?)))
            && may_change
            && let Ok(isolation) =
                self.isolation.again(&self.case, &point.theta, set, self.case.settings().isolation_rounds)
        {
            self.isolation = isolation;
            return true;
        }
        let weighed = &mut self.isolation.weighed;
        weighed.retain(|one| !others.iter().any(|other| other.set == one.set));
        // The best one stays the best, and first.
        weighed.extend(others.into_iter().map(|other| Weighed { score: other.score.min(score), ..other }));
        weighed.sort_by(|a, b| b.score.total_cmp(&a.score));
        false
    }

    /// Goes on from other values of the estimated parameters, SI, and says by how many nats of evidence that is better; stays where it
    /// is not, or cannot be solved.
    pub fn resume(&mut self, theta: &[f64]) -> Option<f64> {
        let (before, evidence) = (self.case.full.weights.clone(), weighed_evidence(&self.case, &self.isolation));
        let (set, rounds) = (self.isolation.set(), self.case.settings().isolation_rounds);
        let resumed = settle(&mut self.case, theta, set, rounds).ok();
        let gained = |isolation: &Isolation| weighed_evidence(&self.case, isolation) - evidence;
        match resumed.map(|isolation| (gained(&isolation), isolation)) {
            Some((gained, isolation)) if gained > 0.0 => {
                self.isolation = isolation;
                Some(gained)
            }
            _ => {
                self.case.full.weights = before;
                None
            }
        }
    }

    /// The explanation by faults of components alone, while physics is missing: faults of sensors would stand in for it. The
    /// sets of a search this deep, that found so far and none at all are fitted, and the best kept.
    ///
    /// # Errors
    /// The model cannot be solved at any of them.
    pub fn by_components_alone(&self, depth: search::Depth, forms: usize) -> Result<Self, Complaint> {
        let Case { full, record, mean, .. } = &self.case;
        let roughly = roughly(full.model);
        let of_components = |&fault: &usize| !self.case.is_of_sensor(fault);
        let set: FaultSet = self.isolation.set().iter().filter(of_components).collect();
        let found = self.case.without_others(&self.isolation.best.theta, set);
        let mut starts = vec![(mean.clone(), FaultSet::EMPTY), (found, set)];
        let weights = by_the_record(&self.case);
        let unfollowed = Case::new(full.model, record, full.drive, full.measured.clone(), weights);
        let places = search::places(&unfollowed, depth);
        starts.extend(places.iter().map(|place| (place.theta(&unfollowed), place.set())));
        starts.dedup_by_key(|(_, set)| *set);
        let samples = unfollowed.full.weights.all_samples() as f64;
        let fitted = starts.par_iter().filter_map(|(start, set)| {
            let fit =
                quick(&roughly, record, full.drive, (start, *set), self.case.settings().first_linearisations, None)
                    .ok()?;
            Some((fit.theta, *set, bic(fit.cost, set.len(), samples)))
        });
        let fitted: Vec<_> = fitted.collect();
        let best = fitted.into_iter().min_by(|a, b| a.2.total_cmp(&b.2));
        let (theta, set) = best.map_or_else(|| (mean.clone(), FaultSet::EMPTY), |(theta, set, _)| (theta, set));
        self.held_at((&theta, set), forms)
    }

    /// The record as the rig without faults explains it best, the form renewed so many times.
    ///
    /// # Errors
    /// The model cannot be solved there.
    pub fn without_faults(&self, forms: usize) -> Result<Self, Complaint> {
        self.held_at((&self.case.mean, FaultSet::EMPTY), forms)
    }

    fn held_at(&self, start: (&[f64], FaultSet), forms: usize) -> Result<Self, Complaint> {
        held_at(self.case.full.model, self.case.record, self.case.full.drive, start, forms)
    }

    /// Logarithm of the share of what was open before that the record leaves of all that is uncertain.
    pub(super) fn occam(&self) -> f64 {
        self.isolation.local.occam(&self.case.prior(self.isolation.set()))
    }

    /// Root mean square of what is left of the record, over the noise of each sensor; of a model that cannot be solved there is none.
    pub(super) fn times_noise(&self) -> f64 {
        let full = &self.case.full;
        let Ok(outputs) = full.outputs(&full.parameters(&self.isolation.best.theta), full.drive) else { return 0.0 };
        let of = |((model, measured), sensor): ((&Vec<f64>, &&[f64]), &Sensor)| {
            root_mean_square(model, measured).map(|rms| rms / sensor.noise)
        };
        over_sensors(outputs.iter().zip(&full.measured).zip(&full.model.rig.sensors).map(of))
    }

    /// Whether the model explains every sensor within noise and tolerance.
    pub fn explains(&self) -> bool {
        explains(&self.case, &self.isolation)
    }

    /// Whether it leaves more than noise unexplained.
    pub fn missed(&self) -> bool {
        missed(&self.case, &self.isolation)
    }
}

/// Logarithm of the evidence of an explanation under the weights of a case, up to what is the same for all weights of the record: what
/// weights allow to be missed costs likelihood, as a misfit does.
fn weighed_evidence(case: &Case<'_>, isolation: &Isolation) -> f64 {
    case.full.weights.log_determinant() + isolation.evidence(case)
}

fn explains(case: &Case<'_>, isolation: &Isolation) -> bool {
    let settings = case.settings();
    let missed = super::missed::missed(settings, &case.full.weights, &isolation.best.misfit);
    missed.iter().all(|one| one.is_explained(settings))
}

fn missed(case: &Case<'_>, isolation: &Isolation) -> bool {
    let samples = case.full.weights.all_samples() as f64;
    isolation.best.cost > 2.0 * case.settings().missed_cost * samples
}

/// Weights from the record alone: events are where its curves bend.
fn rough(model: &Model, record: &Record, drive: &InputSignals, data: &[&[f64]]) -> Weights {
    let rig = &model.rig;
    Weights::without_changes(rig, drive, &record.time, &noise::variances(rig, record, data, true))
}

/// Weights of a case before any model has followed its record.
pub(super) fn by_the_record(case: &Case<'_>) -> Weights {
    rough(case.full.model, case.record, case.full.drive, &case.full.measured)
}

/// Explains the record from a guess. Where that does, weights are renewed where the explanation puts the events, and the
/// explanation with them, until no fault moves.
///
/// While weights stay a fit may leave their events: a curve without any, through samples that are allowed to miss, costs less than one
/// whose events come a little late. Its own weights allow no such thing. So weights that have less evidence than those before them are
/// taken back; the first ones may be of the record alone, and compare with none.
fn settle(case: &mut Case<'_>, guess: &[f64], set: FaultSet, most_rounds: u64) -> Result<Isolation, FitError> {
    let settings = &case.full.model.rig.settings().diagnosis;
    let mut isolation = isolate(case, guess, set, most_rounds)?;
    for renewal in 0..settings.weight_renewals {
        if most_rounds < settings.isolation_rounds && missed(case, &isolation) {
            break;
        }
        let (weights, evidence) = (case.full.weights.clone(), weighed_evidence(case, &isolation));
        let form = renewed(case, &isolation.best.theta)?;
        let mut before = isolation;
        isolation = isolate_from(case, form, (before.set(), before.held.clone()), most_rounds)?;
        let is_taken_back = renewal > 0 && weighed_evidence(case, &isolation) < evidence;
        if is_taken_back {
            case.full.weights = weights;
            std::mem::swap(&mut isolation, &mut before);
        }
        let is_stuck = missed(case, &isolation) && isolation.best.cost > settings.stuck_share * before.best.cost;
        let still = |fault: usize| {
            let sigma = isolation.schur.sigma(isolation.set().iter(), fault);
            let sigma = sigma.map_or(case.range(fault), |sigma| sigma * isolation.local.scale[fault]);
            (isolation.best.theta[fault] - before.best.theta[fault]).abs() <= settings.settled_deviation * sigma
        };
        let is_settled = is_taken_back || isolation.set() == before.set() && isolation.set().iter().all(still);
        if !is_stuck && !is_settled {
            continue;
        }
        // What the form cannot see from here may explain the record better.
        let better = if is_stuck {
            unseen(case, &isolation)
        } else {
            in_step(case, &isolation).or_else(|| unseen(case, &isolation)).or_else(|| simpler(case, &isolation))
        };
        let Some((set, point)) = better else { break };
        isolation = isolation.again(case, &point.theta, set, most_rounds)?;
    }
    // Few rounds are for looking whether a start leads anywhere; one that does is walked to its end.
    if isolation.stopped == Stopped::Rounds && most_rounds < settings.isolation_rounds && !missed(case, &isolation) {
        let (theta, set) = (isolation.best.theta.clone(), isolation.set());
        isolation = isolation.again(case, &theta, set, settings.isolation_rounds)?;
    }
    Ok(isolation)
}

/// The rig's parameters that are estimated, by index, in their order.
pub(crate) fn estimated_parameters(rig: &Rig) -> Vec<usize> {
    super::case::estimated(rig).into_iter().map(|estimated| estimated.parameter).collect()
}

/// Of all parameters of a rig those that are estimated, in their order.
pub(crate) fn picked(rig: &Rig, values: &[f64]) -> Vec<f64> {
    estimated_parameters(rig).into_iter().map(|parameter| values[parameter]).collect()
}
