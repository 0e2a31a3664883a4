//! Isolation: which set of faults explains the record, each set with its probability.
//!
//! Around the best explanation so far the cost has a local quadratic model, and with everything uncertain eliminated a set of
//! faults is weighed by solving a system as small as the set. So every set of up to three faults, and every set near the
//! best one, is weighed in that model; the best of them are fitted to the record itself; the model is taken again at the
//! winner; until the winner stays.

use std::fmt;

use serde::Serialize;

use super::case::Case;
use super::weighing::{Around, Weighed, Weighing, inflations, overtaking, prior_odds, weigh};
use crate::estimation::{Fit, FitError, LocalModel, Options, SchurComplement};
use crate::model::SimulationError;
use crate::rig::FaultSet;

/// Sets with less probability are left out of the list.
const NEGLIGIBLE: f64 = 1e-6;

/// A set of faults and its probability.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Hypothesis {
    /// Ids; empty for the healthy rig.
    pub faults: Vec<String>,
    /// 0 to 1, over all sets.
    pub probability: f64,
}

/// Where the search ended.
#[derive(Clone)]
pub struct Isolation {
    /// The best first.
    pub weighed: Vec<Weighed>,
    pub best: Fit,
    /// The local model near the best.
    pub local: LocalModel,
    pub schur: SchurComplement,
    /// Of each fault: variance inflation by autocorrelation of the misfits.
    pub inflation: Vec<f64>,
    /// The same as combinations were compared by: no less than is [`held`](Self::held).
    pub compared: Vec<f64>,
    /// What [`Turns`] hold of each fault, where any were taken.
    pub held: Vec<f64>,
    pub rounds: u64,
    pub stopped: Stopped,
}

/// What ended the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stopped {
    /// No step promises a decrease of this or more.
    Settled {
        decrease: f64,
    },
    Rounds,
    Unsolvable,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Settled { decrease } => write!(
                f,
                "no other fault combination is more probable, and no step lowers chi-square by more than {decrease}"
            ),
            Self::Rounds => f.write_str(
                "the limit of iterations was reached while fault combinations or values still changed: probabilities and last digits are approximate",
            ),
            Self::Unsolvable => f.write_str("no fault combination can be simulated"),
        }
    }
}

impl Isolation {
    /// Goes on from values of all estimated parameters and a set, under weights that may be others: what is held against sets that took
    /// turns stays held, so that they do not take them once more.
    ///
    /// # Errors
    /// The model cannot be solved there.
    pub fn again(&self, case: &Case<'_>, guess: &[f64], centre: FaultSet, most_rounds: u64) -> Result<Self, FitError> {
        isolate_from(case, case.local_model(guess)?, (centre, self.held.clone()), most_rounds)
    }

    pub fn set(&self) -> FaultSet {
        self.weighed.first().map_or(FaultSet::EMPTY, |best| best.set)
    }

    /// Logarithm of the evidence of its set, up to what is the same for all sets of the record.
    pub fn evidence(&self, case: &Case<'_>) -> f64 {
        let set = self.set();
        prior_odds(case) * set.len() as f64 + self.schur.occam(set.iter(), 1.0) - 0.5 * self.best.cost
    }

    /// Probability of each set, in the order of `weighed`.
    pub fn probabilities(&self) -> Vec<f64> {
        let best = self.weighed.iter().map(|set| set.score).fold(f64::NEG_INFINITY, f64::max);
        let shares: Vec<f64> = self.weighed.iter().map(|set| (set.score - best).exp()).collect();
        let total: f64 = shares.iter().sum();
        shares.iter().map(|share| share / total).collect()
    }

    /// Probability of each fault of the rig, over all sets.
    pub fn of_faults(&self, count: usize) -> Vec<f64> {
        let mut faults = vec![0.0_f64; count];
        for (set, probability) in self.weighed.iter().zip(self.probabilities()) {
            set.set.iter().for_each(|fault| faults[fault] += probability);
        }
        faults.into_iter().map(|probability| probability.min(1.0)).collect()
    }

    /// Probability of the sets with one fault and without another, of those of all sets in their order.
    pub fn of_instead(&self, probabilities: &[f64], fault: usize, other: usize) -> f64 {
        let sets = self.weighed.iter().zip(probabilities);
        sets.filter(|(one, _)| one.set.contains(fault) && !one.set.contains(other)).map(|(_, probable)| probable).sum()
    }

    /// Sets that are not negligible, with the ids of their faults.
    pub fn hypotheses(&self, case: &Case<'_>) -> Vec<Hypothesis> {
        let rig = case.rig();
        let id = |fault: usize| rig.fault_id(fault).to_owned();
        self.weighed
            .iter()
            .zip(self.probabilities())
            .filter(|(_, probability)| *probability >= NEGLIGIBLE)
            .map(|(set, probability)| Hypothesis { faults: set.set.iter().map(id).collect(), probability })
            .collect()
    }
}

/// Finds the sets of faults that explain the record, from a first guess of all estimated parameters and of the set.
///
/// # Errors
/// The model cannot be solved at the guess.
pub fn isolate(case: &Case<'_>, guess: &[f64], centre: FaultSet, most_rounds: u64) -> Result<Isolation, FitError> {
    isolate_from(case, case.local_model(guess)?, (centre, Vec::new()), most_rounds)
}

/// The same from the local model at the guess, with what is [`held`](Isolation::held) from before.
///
/// # Errors
/// The model cannot be solved.
pub(super) fn isolate_from(
    case: &Case<'_>,
    mut local: LocalModel,
    (mut centre, held): (FaultSet, Vec<f64>),
    most_rounds: u64,
) -> Result<Isolation, FitError> {
    let (mut rounds, mut damping) = (0, 0.0);
    let mut turns = Turns { before: Vec::new(), held };
    loop {
        case.rig().context().check()?;
        rounds += 1;
        let schur = case.schur_complement(&local);
        let inflation = inflations(case, &local, &schur, centre);
        let compared = turns.no_less(inflation.clone());
        let around = Around { local: &local, schur: &schur, centre, damping, inflation: &compared };
        let Weighing { mut weighed, reached } = weigh(case, around);
        let Some((set, best)) = weighed.iter().find_map(|set| Some((set.set, set.point.clone()?))) else {
            // Nothing could be solved: the guess is all there is.
            let unsolvable = || {
                FitError::from(SimulationError::Explicit {
                    t: 0.0,
                    reason: "no fault combination can be simulated".to_owned(),
                })
            };
            let best = case
                .fit(&local, centre, &local.theta, Options::steps(0, case.settings().rough_decrease))
                .map_err(|_| unsolvable())?;
            let (stopped, held) = (Stopped::Unsolvable, turns.held);
            return Ok(Isolation { weighed, best, local, schur, inflation, compared, held, rounds, stopped });
        };
        let gained = case.cost(set, &local.misfit, &local.theta) - best.cost;
        let stays = set == centre && gained < case.settings().isolation_decrease;
        let cost = case.cost(centre, &local.misfit, &local.theta);
        let round = Round { set: centre, cost, inflation: compared.clone() };
        turns.take(round, (set, best.cost + case.settings().isolation_decrease));
        let further = match stays {
            _ if rounds >= most_rounds => None,
            true => overtaking(case, around, &mut weighed, reached),
            false => Some((set, best.clone())),
        };
        let Some((set, point)) = further else {
            let stopped =
                if stays { Stopped::Settled { decrease: case.settings().isolation_decrease } } else { Stopped::Rounds };
            let held = turns.held;
            return Ok(Isolation { weighed, best, local, schur, inflation, compared, held, rounds, stopped });
        };
        damping = point.damping;
        local = case.local_model(&point.theta)?;
        centre = set;
    }
}

/// Sets that were the best in turn, and what is held against the faults in which they differ.
///
/// Two sets are compared by the variance inflation of the faults in which they differ, the most of any. So one set may win beside a second
/// one, that beside a third, and the third beside the first, none of them any better than before. From then on the faults in which these
/// differ share the most that any of them had, by which all of them compare.
struct Turns {
    before: Vec<Round>,
    held: Vec<f64>,
}

/// The set that a round began with, what that cost, and the variance inflation of each fault.
struct Round {
    set: FaultSet,
    cost: f64,
    inflation: Vec<f64>,
}

impl Turns {
    /// Variance inflations that are no less than what is held.
    fn no_less(&self, mut inflation: Vec<f64>) -> Vec<f64> {
        inflation.iter_mut().zip(&self.held).for_each(|(own, held)| *own = own.max(*held));
        inflation
    }

    /// A round with its winner and what that has to have cost before to be better now.
    fn take(&mut self, round: Round, (set, cost): (FaultSet, f64)) {
        let stays = round.set == set;
        self.before.push(round);
        let is_no_better = |before: &Round| before.set == set && before.cost < cost;
        let Some(first) = self.before.iter().position(is_no_better).filter(|_| !stays) else { return };
        let turns = self.before.split_off(first);
        let differ = |all: FaultSet, round: &Round| all.union(round.set.symmetric_difference(set));
        let differing = turns.iter().fold(FaultSet::EMPTY, differ);
        let of_round = |round: &Round| differing.iter().map(|fault| round.inflation[fault]).fold(1.0, f64::max);
        let most = turns.iter().map(of_round).fold(1.0, f64::max);
        self.held.resize(turns[0].inflation.len(), 1.0);
        differing.iter().for_each(|fault| self.held[fault] = self.held[fault].max(most));
    }
}

/// The fit of one set of faults as if it were isolated, from the local model at values of all estimated parameters.
///
/// # Errors
/// The model cannot be solved there.
pub(super) fn held(case: &Case<'_>, local: LocalModel, set: FaultSet) -> Result<Isolation, FitError> {
    let schur = case.schur_complement(&local);
    let inflation = vec![1.0; case.faults()];
    let best = case.fit(
        &local,
        set,
        &local.theta,
        Options::steps(case.settings().isolation_steps, case.settings().rough_decrease),
    )?;
    let weighed = vec![Weighed { set, score: 0.0, point: Some(best.clone()) }];
    Ok(Isolation {
        weighed,
        best,
        local,
        schur,
        compared: inflation.clone(),
        held: Vec::new(),
        inflation,
        rounds: 1,
        stopped: Stopped::Settled { decrease: case.settings().isolation_decrease },
    })
}

/// Groups of faults of which one is there and which one stays open: each pair that takes the other's place in sets of
/// some probability.
pub fn ambiguity(isolation: &Isolation, case: &Case<'_>) -> Vec<Vec<usize>> {
    let probabilities = isolation.probabilities();
    let instead = |a: usize, b: usize| isolation.of_instead(&probabilities, a, b);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for a in 0..case.faults() {
        for b in 0..a {
            if instead(a, b).min(instead(b, a)) < case.settings().ambiguity_probability {
                continue;
            }
            match groups.iter_mut().find(|group| group.contains(&a) || group.contains(&b)) {
                Some(group) => [a, b].into_iter().for_each(|fault| {
                    if !group.contains(&fault) {
                        group.push(fault);
                    }
                }),
                None => groups.push(vec![b, a]),
            }
        }
    }
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups
}
