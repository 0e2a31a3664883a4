//! Sets of faults weighed in the local quadratic model, the best of them fitted to the record.

use nalgebra::DVector;
use rayon::prelude::*;

use super::candidates::candidates;
use super::case::{Case, robust};
use crate::estimation::{Fit, LocalModel, Options, SchurComplement};
use crate::rig::FaultSet;

/// One set with the logarithm of its evidence, relative to the others only.
#[derive(Debug, Clone)]
pub struct Weighed {
    pub set: FaultSet,
    pub score: f64,
    /// Its fit, where it was fitted to the record.
    pub point: Option<Fit>,
}

/// Probability of each of so many faults before the record.
pub fn prior(expected: f64, faults: usize) -> f64 {
    expected / faults.max(3) as f64
}

/// Logarithm of its odds.
pub(super) fn prior_odds(case: &Case<'_>) -> f64 {
    let each = prior(case.settings().expected_faults, case.faults());
    (each / (1.0 - each)).ln()
}

/// Where candidates are weighed.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub local: &'a LocalModel,
    pub schur: &'a SchurComplement,
    /// The best set so far.
    pub centre: FaultSet,
    /// Damping with which its fit ended.
    pub damping: f64,
    /// Variance inflation of each fault.
    pub inflation: &'a [f64],
}

impl Around<'_> {
    /// What the faults of a set cost before the record is asked: the logarithm of their odds and Occam factor.
    fn priced(&self, case: &Case<'_>, set: FaultSet) -> f64 {
        let inflation = inflation_between(set, FaultSet::EMPTY, self.inflation);
        self.schur.occam(set.iter(), inflation) + prior_odds(case) * set.len() as f64
    }

    /// Score of a set that leaves a cost where that of the centre is a `reference`.
    pub fn score(&self, case: &Case<'_>, set: FaultSet, cost: f64, reference: f64) -> f64 {
        -0.5 * (cost - reference) / inflation_between(set, self.centre, self.inflation) + self.priced(case, set)
    }
}

/// All candidates, weighed, the best first.
pub(super) struct Weighing {
    pub weighed: Vec<Weighed>,
    /// The cost of the centre that they are compared with.
    pub reached: f64,
}

/// Weighs all candidates in the local quadratic model and fits the best of them.
pub(super) fn weigh(case: &Case<'_>, around: Around<'_>) -> Weighing {
    let Around { local, schur, centre, damping, .. } = around;
    let reference = schur.best(centre.iter()).map_or(0.0, |best| best.cost);
    let alone = |set: FaultSet| Some(around.score(case, set, schur.best(set.iter())?.cost, reference));
    let mut weighed: Vec<(Weighed, Vec<f64>)> = candidates(case.settings(), case.faults(), centre, alone)
        .into_iter()
        .filter_map(|set| {
            let best = schur.best(set.iter())?;
            let score = around.score(case, set, best.cost, reference);
            Some((Weighed { set, score, point: None }, best.deviation))
        })
        .collect();
    weighed.sort_by(|a, b| b.0.score.total_cmp(&a.0.score));
    let top = weighed.first().map_or(0.0, |(best, _)| best.score);
    // From afar the form is too rough to tell more than a few sets apart.
    let far =
        local.misfit.len() as f64 * case.settings().far_mean_square < 2.0 * robust(case.rig()).cost(&local.misfit);
    let most = if far { case.settings().isolation_fits_far } else { case.settings().isolation_fits };
    let mut fitted = 0;
    let mut in_question: Vec<(usize, &mut (Weighed, Vec<f64>))> = weighed.iter_mut().enumerate().collect();
    in_question.retain(|(place, (set, _))| {
        let fit = set.set == centre
            || ((*place == 0 || set.score > top - case.settings().isolation_evidence) && fitted < most);
        fitted += usize::from(fit);
        fit
    });
    in_question.into_par_iter().for_each(|(place, (set, deviation))| {
        let stay = set.set == centre;
        let mut start = local.theta.clone();
        // The set at hand goes on from where it is, so that no round ends worse than it began.
        if !stay {
            (0..case.faults()).for_each(|fault| start[fault] = case.as_healthy(fault, start[fault]));
            // Deviations count from what is expected, not from what the set at hand has made of a value that is uncertain.
            for (fault, deviation) in set.set.iter().zip(deviation.iter()) {
                start[fault] = case.mean[fault] + deviation * local.scale[fault];
            }
        }
        let enough = if place == 0 || stay { case.settings().exact_decrease } else { case.settings().rough_decrease };
        set.point = case
            .fit(local, set.set, &start, Options::steps(case.settings().isolation_steps, enough).damped(damping))
            .ok();
        // What cannot be solved where it is promised to be is no explanation.
        if set.point.is_none() && !stay {
            set.score = f64::NEG_INFINITY;
        }
    });
    weighed.retain(|(set, _)| set.score != f64::NEG_INFINITY);
    // Fitted sets are compared by what they reach; the others keep what the form promises, from the same reference.
    let stays = weighed.iter().find(|(set, _)| set.set == centre).and_then(|(set, _)| set.point.as_ref());
    let (reached, promised) = stays.map_or((reference, 0.0), |point| (point.cost, point.promised.max(0.0)));
    let mut weighed: Vec<Weighed> = weighed.into_iter().map(|(set, _)| set).collect();
    for set in &mut weighed {
        if let Some(point) = &set.point {
            // A promise is believed of a set that is no worse than the one at hand already: from afar others promise anything.
            let score = around.score(case, set.set, point.cost, reached);
            let proven = set.set == centre || score >= around.priced(case, centre);
            let hoped = if proven { point.promised.max(0.0) } else { 0.0 };
            let mut left = point.cost - hoped;
            // More faults leave no more: a fit that ends above what it holds went astray.
            if centre.difference(set.set).is_empty() {
                left = left.min(reached - promised);
            }
            set.score = around.score(case, set.set, left, reached - promised);
        }
    }
    weighed.sort_by(|a, b| b.score.total_cmp(&a.score));
    Weighing { weighed, reached: reached - promised }
}

/// A set whose fit still promised to be the best when its steps were spent, and is so with local models of its own. Those that
/// are not keep what they have come to.
pub(super) fn overtaking(
    case: &Case<'_>,
    around: Around<'_>,
    weighed: &mut [Weighed],
    reached: f64,
) -> Option<(FaultSet, Fit)> {
    let best = weighed.first()?.score;
    let hope = |set: FaultSet, point: &Fit| around.score(case, set, point.cost - point.promised.max(0.0), reached);
    let open = weighed.iter_mut().filter_map(|set| {
        let point = set
            .point
            .as_ref()
            .filter(|point| set.set != around.centre && point.promised > case.settings().isolation_decrease)?;
        Some((hope(set.set, point), set)).filter(|(hope, _)| *hope > best)
    });
    let mut open: Vec<(f64, &mut Weighed)> = open.collect();
    open.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, one) in open.into_iter().take(case.settings().overtaking_fits) {
        for _ in 0..case.settings().isolation_steps {
            let Some(point) = one.point.as_ref() else { break };
            let further = case.local_model(&point.theta).and_then(|near| {
                let steps = Options::steps(case.settings().isolation_steps, case.settings().rough_decrease)
                    .damped(point.damping);
                case.fit(&near, one.set, &point.theta, steps)
            });
            let Ok(further) = further else { break };
            one.score = around.score(case, one.set, further.cost, reached);
            let hope = hope(one.set, &further);
            one.point = Some(further.clone());
            if one.score > best {
                return Some((one.set, further));
            }
            if hope <= best {
                break;
            }
        }
    }
    weighed.sort_by(|a, b| b.score.total_cmp(&a.score));
    None
}

/// Variance inflation that counts when two sets are compared: the most of any fault in which they differ; of a set alone, of
/// its own.
pub(super) fn inflation_between(set: FaultSet, centre: FaultSet, inflation: &[f64]) -> f64 {
    set.symmetric_difference(centre).iter().map(|fault| inflation[fault]).fold(1.0, f64::max)
}

/// Variance inflation by autocorrelation of what each fault explains while those of `set` are present, what is known of its
/// healthy value included. The misfits are those that the fault at its best would leave: what it explains is no noise, be it absent
/// or on its way to where a fit will end.
pub(super) fn inflations(case: &Case<'_>, local: &LocalModel, schur: &SchurComplement, set: FaultSet) -> Vec<f64> {
    let (before, known) = (case.prior(set), case.healthy_prior());
    let pulled = before.misfit(&local.theta);
    let scale = DVector::from_column_slice(&local.scale);
    let one = |fault: usize| {
        let along = schur.along(set.iter(), fault, case.count());
        let influence = local.jacobian() * &along.total;
        let step = along.known.component_mul(&scale);
        let own = known.change(&step).norm_squared();
        let pull = local.pull(&influence) + pulled.dot(&before.change(&step));
        let (low, high) = case.rig().faults[fault].bounds;
        let slack = |bound: f64| (bound - local.theta[fault]) / local.scale[fault];
        let share = (-pull).clamp(slack(low), slack(high)) / along.variance;
        let left: Vec<f64> = local.misfit.iter().zip(influence.iter()).map(|(r, by)| r + share * by).collect();
        local.inflation(&influence, &left, own, &case.full)
    };
    (0..case.faults()).into_par_iter().map(one).collect()
}
