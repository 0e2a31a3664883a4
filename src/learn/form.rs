//! Whether the law that explains a record best has the right form: a curve without a formula, free to take any, shows it.
//!
//! A model is adequate within what its rig file allows, and a law of the wrong form may well be: a leak that grows with the square of
//! the pressure, taken for one that grows with the pressure. What such a law leaves, a curve in its place explains.

use super::candidate::{Candidate, empirical};
use super::evaluated::EvaluatedModel;
use super::fitted_model::FittedModel;
use super::free_curve::curves;
use super::run::Run;
use super::screening::Screening;
use super::warning::Warning;
use crate::complaint::Complaint;
use crate::physics::effect::spline::HEIGHTS;
use crate::record::Record;
use crate::settings::LearningSettings;

/// Tries the curve that explains most of what the best explanation leaves above the noise in its place. Where that refutes every law that
/// the records support, it comes first; whether it does.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub(super) fn is_refuted(screening: &Screening<'_>, judged: &mut Vec<EvaluatedModel>) -> Result<bool, Complaint> {
    let settings = &screening.base.rig.settings().learn;
    let Some(best) = judged.first().filter(|best| best.supported && !best.is_empirical()) else { return Ok(false) };
    if best.error() * (1.0 - settings.clear_share) <= 1.0 {
        return Ok(false);
    }
    let Some(curve) = promising(&best.trial, screening.record)? else { return Ok(false) };
    let mut with_curve = judged.clone();
    screening.join(&mut with_curve, vec![vec![curve]])?;
    refute(settings, &mut with_curve);
    let mut laws = with_curve.iter().filter(|one| one.supported && !one.is_empirical());
    let is_outdone = |one: &Warning| matches!(one, Warning::WrongForm { is_refuted: true, .. });
    if laws.clone().all(|law| law.warnings.iter().any(is_outdone)) {
        with_curve.sort_by_key(|one| !one.is_empirical());
        *judged = with_curve;
        return Ok(true);
    }
    // Where the curve explains a part of what is left, the law stands, with a remark.
    let remark = laws.find(|law| law.id() == judged[0].id()).map_or_else(Vec::new, |law| law.warnings.clone());
    judged[0].warnings = remark;
    Ok(false)
}

/// Warns of each law that leaves what the best curve explains.
pub(super) fn refute(settings: &LearningSettings, judged: &mut [EvaluatedModel]) {
    let Some(curve) = judged.iter().find(|one| one.supported && one.is_empirical()).cloned() else { return };
    let laws = judged.iter_mut().filter(|one| !one.is_empirical());
    for law in laws.filter(|law| curve.evidence > law.evidence + settings.rival_bic) {
        let share = explains(&curve, law);
        let is_refuted = share >= settings.explained_share;
        if is_refuted || (share > 0.0 && curve.error() < (1.0 - settings.clear_share) * law.error()) {
            law.warnings.push(Warning::WrongForm { curve: curve.id(), share, is_refuted });
        }
    }
}

/// The share that a curve explains of what a law leaves above the noise, of both records.
fn explains(curve: &EvaluatedModel, law: &EvaluatedModel) -> f64 {
    let above = |run: &Run| (run.normalised.powi(2) - 1.0).max(0.0);
    let share = |with: &Run, without: &Run| if above(without) > 0.0 { 1.0 - above(with) / above(without) } else { 0.0 };
    let on_check = curve.check.as_ref().zip(law.check.as_ref()).map_or(1.0, |(with, without)| share(with, without));
    share(&curve.trial.fit, &law.trial.fit).min(on_check)
}

/// The curve that takes away most beside an explanation, to first order; `None` where none takes away more than its heights cost.
fn promising(best: &FittedModel, record: &Record) -> Result<Option<Candidate>, Complaint> {
    let samples = best.fit.weights.all_samples() as f64;
    let cost = HEIGHTS as f64 * samples.ln();
    let all = curves(best, record, empirical(&best.rig))?.into_iter().filter(|curve| curve.fall > cost);
    Ok(all.max_by(|a, b| a.fall.total_cmp(&b.fall)).map(|curve| curve.candidate))
}
