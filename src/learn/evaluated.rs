//! A model with an effect, or a pair, fitted and judged on both records.

use super::candidate::Candidate;
use super::fitted_model::FittedModel;
use super::run::Run;
use super::warning::Warning;
use crate::complaint::Complaint;
use crate::record::Record;
use crate::rig::Location;

/// One word on what the record says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Conclusion {
    /// The model explains the record within its tolerance.
    Adequate,
    /// One effect, or a pair, explains what the model misses down to the floor of both records, and nothing else does.
    EffectFound,
    /// Several explain it alike.
    Confounded,
    /// An effect, or a pair, explains much of it, and something is left that nothing explains.
    PartlyExplained,
    /// Nothing in the library explains it.
    UnknownEffect,
}

/// An effect, or a pair, with what the records say of it.
#[derive(Debug, Clone)]
pub struct EvaluatedModel {
    pub effects: Vec<Candidate>,
    /// The joint refit.
    pub trial: FittedModel,
    /// What its preliminary fit cost under the weights of the base.
    pub preliminary: f64,
    /// The same with faults and effects penalised.
    pub screened: f64,
    /// Its free run on the check record.
    pub check: Option<Run>,
    /// Fall of the information criterion against the model as given; the noise scaled up to what the best leaves.
    pub delta_bic: f64,
    /// The same with the fall of chi-square on the check record, to which nothing is fitted: the two together approximate the
    /// logarithm of the evidence of both records, `ln p(fit) + ln p(check | fit)`, times two.
    pub evidence: f64,
    /// Whether it explains more than chance does, on the check record too.
    pub supported: bool,
    /// Whether its fit has been led to its end: candidates are compared by a few rounds each.
    pub finished: bool,
    /// Whether its faults were isolated anew with it.
    pub isolated: bool,
    /// Others that explain the record alike.
    pub confounded_with: Vec<String>,
    pub warnings: Vec<Warning>,
}

impl EvaluatedModel {
    pub fn id(&self) -> String {
        joined(&self.effects)
    }

    /// Leads its fit to its end, so that whoever tells of it tells of the same model.
    ///
    /// # Errors
    /// Columns that are missing, or a model that cannot be solved.
    pub(super) fn finish(&mut self, fit: &Record, check: Option<&Record>) -> Result<(), Complaint> {
        if self.finished {
            return Ok(());
        }
        let FittedModel { rig, values, set, .. } = &self.trial;
        self.trial = FittedModel::fitted(rig, fit, values, *set, rig.settings().diagnosis.isolation_rounds)?;
        self.check = check.map(|record| self.trial.check(record)).transpose()?;
        self.finished = true;
        Ok(())
    }

    /// Whether one of its effects is of a sensor, and not physics of the circuit.
    pub(super) fn is_of_sensor(&self) -> bool {
        self.effects.iter().any(|effect| matches!(effect.placed.spot, Location::Sensor(_)))
    }

    /// Whether one of its effects is a curve without a formula.
    pub(super) fn is_empirical(&self) -> bool {
        self.effects.iter().any(|effect| effect.placed.effect.empirical)
    }

    /// Root mean square of measured minus model over the noise: on the check record where there is one, else on the fit record.
    pub(super) fn error(&self) -> f64 {
        self.check.as_ref().unwrap_or(&self.trial.fit).normalised
    }

    /// Whether it makes no physical sense as fitted.
    pub fn senseless(&self) -> bool {
        self.warnings.iter().any(Warning::is_senseless)
    }
}

/// What effects together are called.
pub(super) fn joined(effects: &[Candidate]) -> String {
    effects.iter().map(|effect| effect.id.as_str()).collect::<Vec<_>>().join(" + ")
}

/// Whether a run is within noise and tolerance in every channel.
pub fn is_adequate(run: &Run) -> bool {
    run.is_adequate
}
