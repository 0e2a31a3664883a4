//! What a record would say about faults before it is taken: expected widths, rank, and the set most easily mistaken for the
//! true one.
//!
//! The local quadratic model of a record without noise, taken at the faults themselves, weighs every other set of faults as
//! [`super::hypotheses`] does. Under noise the logarithm of the ratio of two likelihoods is normal with the variance of
//! twice its mean, so what a set is expected to win by tells how often it wins.

use super::candidates::candidates;
use super::case::Case;
use super::events::weights;
use super::noise::Weights;
use super::weighing::prior_odds;
use crate::estimation::{FitError, SchurComplement};
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::FaultSet;

/// What a record would say at one operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Standard error of each fault of the rig with the given ones present too, SI; `None` where the record would say nothing.
    pub sigma: Vec<Option<f64>>,
    /// Independent combinations of faults of which the record would say more than their ranges do.
    pub rank: usize,
    /// Of each given fault, in the order given: whether every set without it would lose.
    pub identifiable: Vec<bool>,
    /// The set most easily mistaken for the given one (indices of faults); `None` where there is no other.
    pub rival: Option<Rival>,
}

/// A set of faults that may be mistaken for the true one.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    /// Indices among the rig's faults.
    pub faults: Vec<usize>,
    /// By how much the true set is expected to win, natural logarithm of the ratio of probabilities.
    pub nats: f64,
    /// Probability that noise turns the order, one-sided normal.
    pub mistaken: f64,
}

/// What a record driven by `drive` at the rows of `record` would say if each `(fault, value)` (index among the rig's
/// faults, SI) were present. Of `record` only times and inputs are used.
///
/// # Errors
/// The model cannot be solved with these faults.
pub fn expected(
    model: &Model,
    record: &Record,
    drive: &InputSignals,
    faults: &[(usize, f64)],
) -> Result<Expected, FitError> {
    let rig = &model.rig;
    let mut parameters = rig.healthy();
    for &(fault, value) in faults {
        parameters[rig.faults[fault].parameter] = value;
    }
    let outputs = model.solve(&parameters, drive, &record.time)?.values;
    let data: Vec<&[f64]> = outputs.iter().map(Vec::as_slice).collect();
    let mut case = Case::new(model, record, drive, data, Weights::new(rig, &[], &[], &[]));
    let mut theta = case.mean.clone();
    for &(fault, value) in faults {
        theta[fault] = value;
    }
    case.full.weights = weights(&case.full, record, &theta)?;
    let local = case.local_model(&theta)?;
    let schur = case.schur_complement(&local);
    let truth: FaultSet = faults.iter().map(|&(fault, _)| fault).collect();
    let rivals = rivals(&case, &schur, truth);
    let identifiable = faults.iter().map(|&(fault, _)| {
        rivals
            .iter()
            .filter(|(set, _)| !set.contains(fault))
            .all(|(_, rival)| rival.mistaken * rig.settings().diagnosis.identifiable_records <= 1.0)
    });
    let identifiable = identifiable.collect();
    let sigma = |fault: usize| Some(schur.sigma(truth.iter(), fault)? * local.scale[fault]);
    Ok(Expected {
        sigma: (0..case.faults()).map(sigma).collect(),
        rank: schur.rank(),
        identifiable,
        rival: rivals.into_iter().map(|(_, rival)| rival).max_by(|a, b| a.mistaken.total_cmp(&b.mistaken)),
    })
}

/// Every other set that might be taken for `truth`.
fn rivals(case: &Case<'_>, schur: &SchurComplement, truth: FaultSet) -> Vec<(FaultSet, Rival)> {
    let odds = prior_odds(case);
    let priced = |set: FaultSet| schur.occam(set.iter(), 1.0) + odds * set.len() as f64;
    let Some(best) = schur.best(truth.iter()) else { return Vec::new() };
    let own = priced(truth);
    let alone = |set: FaultSet| Some(priced(set) - 0.5 * schur.best(set.iter())?.cost);
    candidates(case.settings(), case.faults(), truth, alone)
        .into_iter()
        .filter(|&set| set != truth)
        .filter_map(|set| {
            let rise = (schur.best(set.iter())?.cost - best.cost).max(0.0);
            let nats = own - priced(set) + 0.5 * rise;
            // With one fault more than the truth the likelihood gains half a chi-square; 1 stands for its spread.
            let spread = rise.max(1.0).sqrt();
            let mistaken = 0.5 * statrs::function::erf::erfc(nats / spread / std::f64::consts::SQRT_2);
            Some((set, Rival { faults: set.iter().collect(), nats, mistaken }))
        })
        .collect()
}
