//! The whole loop: suggest, add, fit again, until nothing is left to explain or nothing explains the rest.

use super::add::with_effects;
use super::comparison::{Comparison, MisfitPlace};
use super::evaluated::{Conclusion, EvaluatedModel, is_adequate};
use super::fitted_model::FittedModel;
use super::run::Run;
use super::separate::Experiment;
use super::suggest::{Suggestion, suggest, suggest_from};
use super::verdict::{are_part, explained, takes_most};
use super::warning::Warning;
use crate::complaint::Complaint;
use crate::diagnosis::{CLEARLY_ABOVE_NOISE, DynamicsReport, estimate};
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::Rig;
use crate::settings::LearningSettings;

/// One row of the ledger.
#[derive(Debug, Clone)]
pub struct ImprovementStep {
    /// What was added; `None` for the model as given.
    pub added: Option<String>,
    #[doc(hidden)]
    pub fit: Run,
    #[doc(hidden)]
    pub check: Run,
    /// What speaks against it.
    pub warnings: Vec<Warning>,
    /// Extensions that reached as little error or less but have no physical sense, with what speaks against them.
    #[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "the ledger names them"))]
    pub(crate) refused: Vec<(String, Run, Vec<Warning>)>,
}

/// What [`improve`] reached.
#[derive(Debug, Clone)]
pub struct Improvement {
    /// Whether the model lacks something still, and what.
    pub conclusion: Conclusion,
    /// The model as given, then with each addition.
    pub steps: Vec<ImprovementStep>,
    /// The model as given, everything uncertain and all faults fitted.
    #[doc(hidden)]
    pub given: FittedModel,
    /// The model at the end.
    #[doc(hidden)]
    pub trial: FittedModel,
    /// What explains the records best of what was not added although something is missing.
    #[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "the ledger names it"))]
    pub(crate) declined: Option<Declined>,
    /// Where the model at the end still misses; `None` where it is adequate and has taken most of the error beyond noise.
    pub rest: Option<MisfitPlace>,
    /// What explains the records alike, where several do.
    pub alike: Vec<String>,
    /// What would tell the first of these from the second.
    pub experiment: Option<Experiment>,
    /// How spools follow their commands, where the fit record asks for other than the rig file has; all else is said of the rig
    /// with it, and the new rig file has it.
    pub dynamics: Vec<DynamicsReport>,
}

/// An effect that explains a part and was not worth to be added.
#[derive(Debug, Clone)]
#[cfg_attr(not(feature = "cli"), expect(dead_code, reason = "the ledger names it"))]
pub(crate) struct Declined {
    pub id: String,
    pub model: FittedModel,
    pub check: Run,
    /// Shares by which it would have had to lower what is missed of the fit record beyond noise, and the error of the check record.
    pub asked: (f64, f64),
}

impl ImprovementStep {
    /// Root mean square of measured minus model over the noise of the sensors: on the fit record, and on the check record.
    pub fn times_noise(&self) -> [f64; 2] {
        [self.fit.normalised, self.check.normalised]
    }
}

impl Improvement {
    /// The text of a rig file with the effects that were added; `text` is that of the file that `rig` was read from.
    ///
    /// # Errors
    /// A text that is no TOML.
    pub fn rig_file(&self, text: &str, rig: &Rig) -> Result<String, Complaint> {
        with_effects(&rig.path, text, rig, &self.trial)
    }
}

/// Adds effects to a rig one at a time or in pairs, while the fit record asks for them and the check record agrees.
/// `told` is called with each row of the ledger as it comes.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub fn improve(
    rig: &Rig,
    fit: &Record,
    check: &Record,
    told: impl FnMut(&ImprovementStep) + Send,
) -> Result<Improvement, Complaint> {
    rig.context().run(|| add_while_asked(rig, fit, check, told))
}

fn add_while_asked(
    rig: &Rig,
    fit: &Record,
    check: &Record,
    mut told: impl FnMut(&ImprovementStep),
) -> Result<Improvement, Complaint> {
    let mut last = suggest(rig, fit, Some(check))?;
    let (given, dynamics) = (last.base.clone(), std::mem::take(&mut last.dynamics));
    let mut trial = given.clone();
    let step = |added, trial: &FittedModel, warnings, refused| -> Result<ImprovementStep, Complaint> {
        Ok(ImprovementStep { added, fit: trial.fit.clone(), check: trial.check(check)?, warnings, refused })
    };
    let mut steps = vec![step(None, &trial, Vec::new(), Vec::new())?];
    told(&steps[0]);
    let (mut found, mut declined) = (Conclusion::UnknownEffect, None);
    // The last step before a curve without a formula.
    let mut by_laws = 0;
    let (mut rivals, mut experiment) = last.judged.first().map_or_else(Default::default, |best| alike(&last, best));
    while steps.len() <= rig.settings().learn.additions && last.conclusion != Conclusion::Adequate {
        let before = &steps[steps.len() - 1];
        let Some(chosen) = chosen(&last, before) else {
            declined = declined_of(&last);
            break;
        };
        found = last.conclusion;
        (rivals, experiment) = alike(&last, chosen);
        let refused = refused(&last, chosen);
        let mut added = chosen.clone();
        added.finish(fit, None)?;
        trial = added.trial;
        let next = step(Some(chosen.id()), &trial, chosen.warnings.clone(), refused)?;
        told(&next);
        steps.push(next);
        if !has_curve(&trial) {
            by_laws = steps.len() - 1;
        }
        let reached = &steps[steps.len() - 1];
        let is_explained = is_adequate(&reached.fit) && is_adequate(&reached.check);
        if is_explained && reached.times_noise().iter().all(|&times| times <= CLEARLY_ABOVE_NOISE) {
            last.conclusion = Conclusion::Adequate;
            break;
        }
        let model = Model::new(trial.rig.clone());
        let drive = InputSignals::from_record(&model.rig, fit)?;
        let theta = estimate::picked(&model.rig, &trial.values);
        let again =
            estimate::isolated(&model, fit, &drive, (&theta, trial.set), rig.settings().learn.isolation_rounds)?;
        let base_point = FittedModel::of(&again)?;
        let cost = base_point.cost;
        last = suggest_from(&again, base_point, Some(check))?;
        // What both records bear only within what switching and tolerance allow is asked once more, as `suggest` would ask; only what it
        // finds goes on.
        if is_explained && last.conclusion != Conclusion::EffectFound {
            last.conclusion = Conclusion::Adequate;
        }
        // It may have found a better fit of the same model.
        if last.base.cost < cost - model.rig.settings().learn.rival_bic
            && let (Some(reached), Some(on_check)) = (steps.last_mut(), &last.base_check)
        {
            trial = last.base.clone();
            (reached.fit, reached.check) = (trial.fit.clone(), on_check.clone());
        }
    }
    let (first, end) = (&steps[0], &steps[steps.len() - 1]);
    let is_most = takes_most([(&first.fit, &end.fit), (&first.check, &end.check)]);
    let conclusion = match (steps.len(), last.conclusion) {
        // Adequate as given, or nothing to add.
        (1, conclusion) => conclusion,
        (_, Conclusion::Adequate) if found == Conclusion::Confounded => Conclusion::Confounded,
        (_, Conclusion::Adequate) if !has_curve(&trial) && is_most => Conclusion::EffectFound,
        (_, Conclusion::Confounded) if !has_curve(&trial) => Conclusion::Confounded,
        // What a curve takes away is of an unknown effect; laws before it may be a part nevertheless.
        _ if are_part(&rig.settings().learn, explained_by(&steps[0], &steps[by_laws])) => Conclusion::PartlyExplained,
        _ => Conclusion::UnknownEffect,
    };
    let rest = if last.conclusion == Conclusion::Adequate && is_most {
        None
    } else {
        let model = Model::new(trial.rig.clone());
        let of = |record, run| Comparison::of(&model, record, run).map(|comparison| comparison.place);
        match of(fit, &trial.fit)? {
            Some(place) => Some(place),
            None => of(check, &end.check)?,
        }
    };
    if conclusion != Conclusion::Confounded {
        (rivals, experiment) = Default::default();
    }
    Ok(Improvement { conclusion, steps, given, trial, declined, rest, alike: rivals, experiment, dynamics })
}

/// Whether a curve without a formula has been added.
fn has_curve(trial: &FittedModel) -> bool {
    trial.rig.effects.iter().any(|effect| effect.placed.effect.empirical)
}

/// The best explanation of a suggestion of which nothing was worth to be added.
fn declined_of(last: &Suggestion) -> Option<Declined> {
    let best = last.judged.iter().find(|one| one.supported && !one.senseless())?;
    let settings = &last.base.rig.settings().learn;
    Some(Declined {
        id: best.id(),
        model: best.trial.clone(),
        check: best.check.clone()?,
        asked: asked_of(settings, best.is_empirical()),
    })
}

/// Shares by which an addition has to lower what is missed of the fit record beyond noise, and the error of the check record.
fn asked_of(settings: &LearningSettings, is_curve: bool) -> (f64, f64) {
    if is_curve {
        (settings.curve_share_fit, settings.curve_share_check)
    } else {
        (settings.addition_share_fit, settings.addition_share_check)
    }
}

/// Shares of what the model missed that the steps from one to another explain, on the fit record and on the check record.
fn explained_by(before: &ImprovementStep, after: &ImprovementStep) -> (f64, f64) {
    (explained(&before.fit, &after.fit), explained(&before.check, &after.check))
}

/// An explanation with those that do as well, and what would tell them apart.
fn alike(last: &Suggestion, one: &EvaluatedModel) -> (Vec<String>, Option<Experiment>) {
    let ids = std::iter::once(one.id()).chain(one.confounded_with.iter().cloned());
    (ids.collect(), last.experiment.clone())
}

/// The best addition that is worth it: a law with physical sense if there is one, else a curve.
fn chosen<'a>(last: &'a Suggestion, before: &ImprovementStep) -> Option<&'a EvaluatedModel> {
    let settings = &last.base.rig.settings().learn;
    let worth = |judged: &&EvaluatedModel, (on_fit, on_check): (f64, f64)| {
        let missed = |run: &Run| (run.chi2 - 1.0).max(0.0);
        let Some(check) = &judged.check else { return false };
        judged.supported
            && missed(&judged.trial.fit) <= (1.0 - on_fit) * missed(&before.fit)
            && check.normalised <= (1.0 - on_check) * before.check.normalised
    };
    let [worth_of_law, worth_of_curve] = [false, true].map(|is_curve| asked_of(settings, is_curve));
    let laws =
        || last.judged.iter().filter(|judged| !judged.is_empirical()).filter(|judged| worth(judged, worth_of_law));
    let best = |is_one: &dyn Fn(&EvaluatedModel) -> bool| {
        let sensible = || laws().filter(|judged| !judged.senseless() && is_one(judged));
        let single = sensible().find(|judged| judged.effects.len() == 1);
        let pair = sensible().find(|judged| judged.effects.len() > 1);
        single
            .filter(|single| pair.is_none_or(|pair| pair.error() > (1.0 - settings.pair_share) * single.error()))
            .or(pair)
    };
    let (physics, any) = (best(&|judged| !judged.is_of_sensor()), best(&|_| true));
    let clearly = |any: &&EvaluatedModel| {
        physics.is_none_or(|physics| any.error() < (1.0 - settings.clear_share) * physics.error())
    };
    any.filter(clearly)
        .or(physics)
        .or_else(|| last.judged.iter().filter(|one| one.is_empirical()).find(|judged| worth(judged, worth_of_curve)))
        .or_else(|| laws().next())
}

/// Extensions that promise more than the chosen one but make no sense.
fn refused(last: &Suggestion, chosen: &EvaluatedModel) -> Vec<(String, Run, Vec<Warning>)> {
    let better = |one: &&EvaluatedModel| {
        one.check.as_ref().zip(chosen.check.as_ref()).is_some_and(|(a, b)| a.normalised < b.normalised)
    };
    let flagged = last.judged.iter().filter(better).filter(|one| one.senseless());
    flagged.filter_map(|one| Some((one.id(), one.check.clone()?, one.warnings.clone()))).collect()
}
