//! Isolation: which set of faults explains the record, each set with its probability.
//!
//! Around the best explanation so far the cost has a local quadratic model, and with everything uncertain eliminated a set of
//! faults is weighed by solving a system as small as the set. So every set of up to three faults, and every set near the
//! best one, is weighed in that model; the best of them are fitted to the record itself; the model is taken again at the
//! winner; until the winner stays.

use std::fmt;

use serde::Serialize;

use super::case::{Case, EXACT, ROBUST, ROUGH};
use crate::estimation::{Fit, FitError, LocalModel, Options, SchurComplement};
use crate::model::SimulationError;
use crate::rig::FaultSet;

/// Number of faults expected in a record before it is seen.
const EXPECTED: f64 = 0.3;
/// Most faults of a set: what more of them explain is as well explained by a wrong model.
const MOST_OF_ALL: usize = 5;
/// Faults of which all sets of three are weighed: so many have 9,880 of them, which takes as long as one simulation.
const ALL_TRIPLES: usize = 40;
/// Pairs of which sets of three are grown where there are more faults: as many sets again, of 250 faults.
const GROWN: usize = 40;
/// Sets within this logarithm of the best, in the quadratic form, are fitted to the record.
const IN_QUESTION: f64 = 5.0;
/// Most sets that are fitted in each round.
const MOST_FITS: usize = 8;
/// The same where the cost of a sample is still larger than this.
const MOST_FITS_FAR: usize = 3;
const FAR: f64 = 4.0;
/// Most rounds.
pub const MOST_ROUNDS: u64 = 8;
/// Steps of each fit in a round.
const STEPS: u64 = 3;
/// A winner that promises no more than this decrease of the cost stays.
const SETTLED: f64 = 0.1;
/// Share of the cost beyond which autocorrelation of the misfits does not excuse a rise: where much is missed, it is without bound.
const UNEXCUSED: f64 = 0.02;
/// Sets with less probability are left out of the list.
const NEGLIGIBLE: f64 = 1e-6;

/// A set of faults and its probability.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hypothesis {
    /// Ids; empty for the healthy rig.
    pub faults: Vec<String>,
    /// 0 to 1, over all sets.
    pub probability: f64,
}

/// One set with the logarithm of its evidence, relative to the others only.
#[derive(Debug, Clone)]
pub struct Weighed {
    pub set: FaultSet,
    pub score: f64,
    /// Its fit, where it was fitted to the record.
    pub point: Option<Fit>,
}

/// Where the search ended.
pub struct Isolation {
    /// The best first.
    pub weighed: Vec<Weighed>,
    pub best: Fit,
    /// The local model near the best.
    pub local: LocalModel,
    pub schur: SchurComplement,
    /// Of each fault: variance inflation by autocorrelation of the misfits.
    pub inflation: Vec<f64>,
    pub rounds: u64,
    pub stopped: Stopped,
}

/// What ended the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stopped {
    Settled,
    Rounds,
    Unsolvable,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Settled => write!(
                f,
                "no other fault combination is more probable, and no step lowers chi-square by more than {SETTLED}"
            ),
            Self::Rounds => f.write_str(
                "the limit of iterations was reached while fault combinations or values still changed: probabilities and last digits are approximate",
            ),
            Self::Unsolvable => f.write_str("no fault combination can be simulated"),
        }
    }
}

impl Isolation {
    pub fn set(&self) -> FaultSet {
        self.weighed.first().map_or(FaultSet::EMPTY, |best| best.set)
    }

    /// Logarithm of the evidence of its set, up to what is the same for all sets of the record.
    pub fn evidence(&self, case: &Case<'_>) -> f64 {
        let set = self.set();
        prior_odds(case.faults()) * set.len() as f64 + self.schur.occam(set.iter(), 1.0) - 0.5 * self.best.cost
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

/// Probability of each of so many faults before the record.
pub fn prior(faults: usize) -> f64 {
    EXPECTED / faults.max(3) as f64
}

/// Logarithm of its odds.
pub(super) fn prior_odds(faults: usize) -> f64 {
    let each = prior(faults);
    (each / (1.0 - each)).ln()
}

/// Finds the sets of faults that explain the record, from a first guess of all estimated parameters and of the set.
///
/// # Errors
/// The model cannot be solved at the guess.
pub fn isolate(case: &Case<'_>, guess: &[f64], centre: FaultSet, most_rounds: u64) -> Result<Isolation, FitError> {
    isolate_from(case, case.local_model(guess)?, centre, most_rounds)
}

/// The same from the local model at the guess.
///
/// # Errors
/// The model cannot be solved.
pub(super) fn isolate_from(
    case: &Case<'_>,
    mut local: LocalModel,
    mut centre: FaultSet,
    most_rounds: u64,
) -> Result<Isolation, FitError> {
    let (mut rounds, mut damping) = (0, 0.0);
    loop {
        case.rig().context().check()?;
        rounds += 1;
        let schur = case.schur_complement(&local);
        let inflation = inflations(case, &local, centre)?;
        let weighed = weigh(case, Around { local: &local, schur: &schur, centre, damping, inflation: &inflation });
        let Some((set, best)) = weighed.iter().find_map(|set| Some((set.set, set.point.clone()?))) else {
            // Nothing could be solved: the guess is all there is.
            let unsolvable = || {
                FitError::from(SimulationError::Explicit {
                    t: 0.0,
                    reason: "no fault combination can be simulated".to_owned(),
                })
            };
            let best = case.fit(&local, centre, &local.theta, Options::steps(0, ROUGH)).map_err(|_| unsolvable())?;
            let stopped = Stopped::Unsolvable;
            return Ok(Isolation { weighed, best, local, schur, inflation, rounds, stopped });
        };
        let gained = case.cost(set, &local.misfit, &local.theta) - best.cost;
        let stays = set == centre && gained < SETTLED;
        if stays || rounds >= most_rounds {
            let stopped = if stays { Stopped::Settled } else { Stopped::Rounds };
            return Ok(Isolation { weighed, best, local, schur, inflation, rounds, stopped });
        }
        damping = best.damping;
        local = case.local_model(&best.theta)?;
        centre = set;
    }
}

/// The fit of one set of faults as if it were isolated, from the local model at values of all estimated parameters.
///
/// # Errors
/// The model cannot be solved there.
pub(super) fn held(case: &Case<'_>, local: LocalModel, set: FaultSet) -> Result<Isolation, FitError> {
    let schur = case.schur_complement(&local);
    let inflation = vec![1.0; case.faults()];
    let best = case.fit(&local, set, &local.theta, Options::steps(STEPS, ROUGH))?;
    let weighed = vec![Weighed { set, score: 0.0, point: Some(best.clone()) }];
    Ok(Isolation { weighed, best, local, schur, inflation, rounds: 1, stopped: Stopped::Settled })
}

/// Where candidates are weighed.
#[derive(Clone, Copy)]
struct Around<'a> {
    local: &'a LocalModel,
    schur: &'a SchurComplement,
    /// The best set so far.
    centre: FaultSet,
    /// Damping with which its fit ended.
    damping: f64,
    /// Variance inflation of each fault.
    inflation: &'a [f64],
}

/// Weighs all candidates in the local quadratic model and fits the best of them.
fn weigh(case: &Case<'_>, around: Around<'_>) -> Vec<Weighed> {
    let Around { local, schur, centre, damping, inflation } = around;
    let odds = prior_odds(case.faults());
    let priced = |set: FaultSet| {
        schur.occam(set.iter(), inflation_between(set, FaultSet::EMPTY, inflation)) + odds * set.len() as f64
    };
    let reference = schur.best(centre.iter()).map_or(0.0, |best| best.cost);
    let score = |set: FaultSet, cost: f64, reference: f64| {
        let rise = cost - reference;
        let excused = if rise > UNEXCUSED * reference.abs() { 1.0 } else { inflation_between(set, centre, inflation) };
        -0.5 * rise / excused + priced(set)
    };
    let alone = |set: FaultSet| Some(score(set, schur.best(set.iter())?.cost, reference));
    let mut weighed: Vec<(Weighed, Vec<f64>)> = candidates(case.faults(), centre, alone)
        .into_iter()
        .filter_map(|set| {
            let best = schur.best(set.iter())?;
            Some((Weighed { set, score: score(set, best.cost, reference), point: None }, best.deviation))
        })
        .collect();
    weighed.sort_by(|a, b| b.0.score.total_cmp(&a.0.score));
    let top = weighed.first().map_or(0.0, |(best, _)| best.score);
    // From afar the form is too rough to tell more than a few sets apart.
    let far = local.misfit.len() as f64 * FAR < 2.0 * ROBUST.cost(&local.misfit);
    let most = if far { MOST_FITS_FAR } else { MOST_FITS };
    let mut fitted = 0;
    for (place, (set, deviation)) in weighed.iter_mut().enumerate() {
        let questioned = place == 0 || set.score > top - IN_QUESTION;
        let stay = set.set == centre;
        if !stay && (!questioned || fitted >= most) {
            continue;
        }
        fitted += 1;
        let mut start = local.theta.clone();
        // The set at hand goes on from where it is, so that no round ends worse than it began.
        if !stay {
            start[..case.faults()].copy_from_slice(&case.mean[..case.faults()]);
            for (fault, deviation) in set.set.iter().zip(deviation.iter()) {
                start[fault] += deviation * local.scale[fault];
            }
        }
        let enough = if place == 0 || stay { EXACT } else { ROUGH };
        set.point = case.fit(local, set.set, &start, Options::steps(STEPS, enough).damped(damping)).ok();
    }
    // Fitted sets are compared by what they reach; the others keep what the form promises, from the same reference.
    let stays = weighed.iter().find(|(set, _)| set.set == centre).and_then(|(set, _)| set.point.as_ref());
    let (reached, promised) = stays.map_or((reference, 0.0), |point| (point.cost, point.promised.max(0.0)));
    let mut weighed: Vec<Weighed> = weighed.into_iter().map(|(set, _)| set).collect();
    for set in &mut weighed {
        if let Some(point) = &set.point {
            // A promise is believed of a set that is no worse than the one at hand already: from afar others promise anything.
            let proven = set.set == centre || score(set.set, point.cost, reached) >= priced(centre);
            let hoped = if proven { point.promised.max(0.0) } else { 0.0 };
            set.score = score(set.set, point.cost - hoped, reached - promised);
        }
    }
    weighed.sort_by(|a, b| b.score.total_cmp(&a.score));
    weighed
}

/// Variance inflation that counts when two sets are compared: the most of any fault in which they differ; of a set alone, of
/// its own.
pub(super) fn inflation_between(set: FaultSet, centre: FaultSet, inflation: &[f64]) -> f64 {
    set.symmetric_difference(centre).iter().map(|fault| inflation[fault]).fold(1.0, f64::max)
}

/// Variance inflation by autocorrelation of each fault while those of `set` are present.
fn inflations(case: &Case<'_>, local: &LocalModel, set: FaultSet) -> Result<Vec<f64>, FitError> {
    let series = case.full.series();
    let one = |fault: usize| {
        let direction = case.information(local, set.with(fault))?.direction(fault);
        Ok(direction.map_or(1.0, |direction| local.inflation(&direction, &series)))
    };
    (0..case.faults()).map(one).collect()
}

/// Sets to be weighed: those of up to three faults, and those within two exchanges of the best one. Of a rig with many faults
/// sets of three are grown from the pairs that `score` puts first.
pub(super) fn candidates(faults: usize, centre: FaultSet, score: impl Fn(FaultSet) -> Option<f64>) -> Vec<FaultSet> {
    let mut sets = vec![FaultSet::EMPTY, centre];
    let mut pairs = Vec::new();
    for a in 0..faults {
        for b in 0..=a {
            pairs.push(FaultSet::of(a).with(b));
            let exchanged = centre.toggled(a);
            sets.extend([exchanged, if a == b { centre } else { exchanged.toggled(b) }]);
        }
    }
    sets.extend(&pairs);
    if faults > ALL_TRIPLES {
        let mut scored: Vec<(f64, FaultSet)> = pairs.iter().filter_map(|&pair| Some((score(pair)?, pair))).collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        pairs = scored.into_iter().take(GROWN).map(|(_, pair)| pair).collect();
    }
    sets.extend(pairs.iter().flat_map(|pair| (0..faults).map(|fault| pair.with(fault))));
    sets.retain(|set| set.len() <= MOST_OF_ALL);
    sets.sort_unstable();
    sets.dedup();
    sets
}

/// Groups of faults of which one is there and which one stays open: each pair that takes the other's place in sets of
/// some probability.
pub fn ambiguity(isolation: &Isolation, faults: usize) -> Vec<Vec<usize>> {
    const OPEN: f64 = 0.05;
    let probabilities = isolation.probabilities();
    let instead = |a: usize, b: usize| -> f64 {
        let pairs = isolation.weighed.iter().zip(&probabilities);
        pairs.filter(|(set, _)| set.set.contains(a) && !set.set.contains(b)).map(|(_, probability)| probability).sum()
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for a in 0..faults {
        for b in 0..a {
            if instead(a, b) < OPEN || instead(b, a) < OPEN {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_sets_of_up_to_three_faults_are_weighed_where_they_are_few() {
        let sets = candidates(5, FaultSet::EMPTY, |_| None);
        assert_eq!(sets.len(), 1 + 5 + 10 + 10);
        let near = candidates(5, (0..5).collect(), |_| None);
        // Beside them: all five, each four of them; no set within two exchanges is smaller than three.
        assert_eq!(near.len(), 1 + 5 + 10 + 10 + 5 + 1);
    }

    #[test]
    fn sets_of_three_are_grown_from_promising_pairs_where_faults_are_many() {
        let truth: FaultSet = [3, 90, 210].into_iter().collect();
        let score = |pair: FaultSet| Some(-(truth.symmetric_difference(pair).len() as f64));
        let sets = candidates(250, FaultSet::EMPTY, score);
        assert!(sets.binary_search(&truth).is_ok());
        assert!(sets.len() < 60_000, "{}", sets.len());
        assert!((0..250).all(|fault| sets.binary_search(&FaultSet::of(fault)).is_ok()));
    }
}
