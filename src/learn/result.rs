//! The suggestion as programs read it (`borescope.suggestion/1`) and writers print it.

use serde::Serialize;

use super::candidate::Candidate;
use super::comparison::{Comparison, MisfitPlace};
use super::evaluated::{Conclusion, EvaluatedModel};
use super::fitted_model::FittedModel;
use super::run::Run;
use super::separate::Experiment;
use super::suggest::Suggestion;
use super::trial_steps::distance;
use super::verdict::warnings;
use super::warning::Warning;
use crate::complaint::Complaint;
use crate::diagnosis::DynamicsReport;
use crate::estimation::profile::QUANTILE;
use crate::model::Model;
use crate::number::rounded;
use crate::physics::card::{Answer, Card, PortKind};
use crate::physics::effect::{Form, FreeParameter, InitialGuess};
use crate::record::Record;
use crate::rig::{Location, NodeKind, Rig, is_next_to_nothing};

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.suggestion/1";

/// Digits of a reported number.
const DIGITS: usize = 6;

/// A parameter of an effect as it was fitted, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct EffectParameter {
    /// Such as `external-leakage@A.conductance`.
    pub id: String,
    /// Estimate.
    pub value: f64,
    /// In which the effect is written.
    pub unit: String,
    /// Ends of the 95 % interval from the standard error; `None` at an end of the search, below the value at which an effect does
    /// nothing, or where the fit was only a rough one.
    pub ci95: [Option<f64>; 2],
    /// Whether it stands at an end of its search other than that at which it does nothing.
    pub at_bound: bool,
}

/// What the record could show of an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ScoredReport {
    /// Effect and place, such as `external-leakage@A`.
    pub id: String,
    /// What it is, in words: *leakage from a node to the tank through a narrow gap or a seal*.
    pub in_words: String,
    /// The parameter that is its size.
    pub parameter: String,
    /// Smallest size (departure from doing nothing) that this record could show beside everything that is fitted, beyond chance
    /// and the model's tolerance, in `unit`; `None` where it shows none, and of levels.
    pub smallest_detectable: Option<f64>,
    /// The same from each pressure on from which it was tried, the most promising first; empty where it does not begin at one.
    #[doc(hidden)]
    pub onsets: Vec<OnsetReport>,
    /// Of `smallest_detectable`.
    pub unit: String,
    /// The fitted parameter that takes over what the effect does.
    pub absorbed_by: Option<String>,
    /// Whether the record responds to it at all.
    pub excited: bool,
    /// Fall of chi-square that the score test expects of it.
    pub score: f64,
}

/// What the record could show of an effect that begins somewhere.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct OnsetReport {
    /// Where it begins, in `unit`.
    pub from: f64,
    /// Unit of the numbers beside it.
    pub unit: String,
    /// Smallest size that the record could show, in the unit of the size; `null` where it shows none.
    pub smallest_detectable: Option<f64>,
}

/// An effect, or a pair, that was fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct CandidateReport {
    /// `kind@place`; of a pair both, with ` + ` between.
    pub effect: String,
    /// Whether it explains more than chance does, on the check record too.
    pub supported: bool,
    /// Root mean square misfit over the noise of each sensor, over all channels, without and with the effect.
    pub rmse_before: f64,
    /// With the effect.
    pub rmse_after: f64,
    /// The same of the check record, to which nothing is fitted; `None` without one.
    pub check_rmse_before: Option<f64>,
    /// The same with the effect.
    pub check_rmse_after: Option<f64>,
    /// Fall of the information criterion; above 10 is very strong.
    pub delta_bic: f64,
    /// As they were fitted.
    pub parameters: Vec<EffectParameter>,
    /// Others that explain the record alike.
    pub confounded_with: Vec<String>,
    /// What speaks against it.
    #[cfg_attr(feature = "internals", schemars(with = "Vec<String>"))]
    pub warnings: Vec<Warning>,
    /// Each effect with what the record could show of it.
    pub effects: Vec<ScoredReport>,
}

/// A suggestion to hand on.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct SuggestionReport {
    /// Name and version of the JSON schema: `borescope.suggestion/1`.
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// The record that was fitted, as the user named it.
    pub record: String,
    /// The check record, where there was one.
    pub check: Option<String>,
    /// Whether the model lacks something, and what.
    pub conclusion: Conclusion,
    /// Faults with which the model as given explains the fit record best.
    pub faults: Vec<String>,
    /// How spools follow their commands, where the fit record asks for other than the rig file has; all else is said of the rig
    /// with it.
    pub dynamics: Vec<DynamicsReport>,
    /// Where the model with all faults fitted misses; `None` where it is adequate.
    #[serde(rename = "where")]
    pub place: Option<MisfitPlace>,
    /// Whether that is in the check record: the fit record is explained.
    #[serde(skip)]
    pub misses_check: bool,
    /// Uncertain values that the check record depends on and the fit record does not determine: nothing is concluded from what they may do.
    pub left_open: Vec<String>,
    /// Effects that were fitted, the best first.
    pub candidates: Vec<CandidateReport>,
    /// Every other effect that the rig could have, the most promising first.
    pub not_fitted: Vec<ScoredReport>,
    /// What would tell the best from its first rival; `None` where it has none, or where the rig has no cycle.
    pub experiment: Option<Experiment>,
    /// Caveats of your model where it is fitted: values far from where they were known to be.
    #[serde(skip)]
    pub moved: Vec<Warning>,
    /// Values of the rig file that are still those of a draft.
    #[serde(skip)]
    pub unfilled: usize,
    /// Values that the rig file states without an uncertainty, although parts deviate from data sheets; none of a calibrated rig.
    #[serde(skip)]
    pub taken_as_exact: usize,
    /// Whether the rig was calibrated: what a diagnosis asks of its values then says whether one has changed.
    #[serde(skip)]
    pub calibrated: bool,
}

impl CandidateReport {
    /// Whether the error that is printed is smaller with it, on the check record where there is one.
    pub(crate) fn lowers_the_error(&self) -> bool {
        let error = |fit: f64, check: Option<f64>| rounded(check.unwrap_or(fit), 2);
        error(self.rmse_after, self.check_rmse_after) < error(self.rmse_before, self.check_rmse_before)
    }
}

impl SuggestionReport {
    /// The best candidate, if it is worth a name: where none explains the record, one that lowers no error is no neighbour either.
    pub(crate) fn worth_naming(&self) -> Option<&CandidateReport> {
        let is_unknown = self.conclusion == Conclusion::UnknownEffect;
        self.candidates.first().filter(|best| best.supported && (!is_unknown || best.lowers_the_error()))
    }

    /// What was found on a record, and on a check record if there was one.
    ///
    /// # Errors
    /// Columns that are missing.
    pub fn new(suggestion: &Suggestion, record: &Record, check: Option<&Record>) -> Result<Self, Complaint> {
        let base = &suggestion.base;
        let model = Model::new(base.rig.clone());
        let mut place = Comparison::of(&model, record, &base.fit)?.place;
        let mut misses_check = false;
        if let (None, Some(check), Some(run)) = (&place, check, &suggestion.base_check) {
            place = Comparison::of(&model, check, run)?.place;
            misses_check = place.is_some();
        }
        let best = suggestion.judged.first().filter(|best| best.supported);
        let shown = best.map_or(suggestion.base_check.as_ref(), |best| best.check.as_ref());
        let left_open = shown.map_or(&[][..], |run| &run.left_open);
        let alone = |candidate: &Candidate| {
            suggestion.judged.iter().any(|judged| judged.effects.iter().any(|effect| effect.id == candidate.id))
        };
        // What fits says more of the equation than the sensor where the misfit shows.
        if let (Some(place), Some(best)) = (&mut place, best) {
            let mut equations: Vec<String> =
                best.effects.iter().map(|effect| equation(&best.trial.rig, effect)).collect();
            equations.dedup();
            place.equation = equations.join(" + ");
        }
        Ok(Self {
            schema: SCHEMA,
            moved: warnings(base, base),
            unfilled: base.rig.unfilled.len(),
            taken_as_exact: base.rig.exact_by_sheet().len(),
            calibrated: base.rig.calibration.is_some(),
            rig: base.rig.path.display().to_string(),
            record: record.path.display().to_string(),
            check: check.map(|check| check.path.display().to_string()),
            conclusion: suggestion.conclusion,
            faults: base.set.iter().map(|fault| base.rig.fault_id(fault).to_owned()).collect(),
            dynamics: suggestion.dynamics.clone(),
            place,
            misses_check,
            left_open: left_open.iter().map(|&index| base.rig.parameters[index].id.clone()).collect(),
            candidates: suggestion.judged.iter().map(|judged| candidate(suggestion, judged)).collect(),
            not_fitted: suggestion
                .scored
                .iter()
                .filter(|candidate| !alone(candidate))
                .map(|candidate| scored(base, candidate))
                .collect(),
            experiment: suggestion
                .experiment
                .clone()
                .map(|experiment| Experiment { sigma: rounded(experiment.sigma, DIGITS), ..experiment }),
        })
    }

    /// Every effect that was scored, the fitted ones first.
    pub fn scored(&self) -> Vec<&ScoredReport> {
        let mut all: Vec<&ScoredReport> = Vec::new();
        for scored in self.candidates.iter().flat_map(|candidate| &candidate.effects).chain(&self.not_fitted) {
            if all.iter().all(|other| other.id != scored.id) {
                all.push(scored);
            }
        }
        all
    }
}

fn candidate(suggestion: &Suggestion, judged: &EvaluatedModel) -> CandidateReport {
    let normalised = |run: &Option<Run>| run.as_ref().map(|run| rounded(run.normalised, DIGITS));
    CandidateReport {
        effect: judged.id(),
        supported: judged.supported,
        rmse_before: rounded(suggestion.base.fit.normalised, DIGITS),
        rmse_after: rounded(judged.trial.fit.normalised, DIGITS),
        check_rmse_before: normalised(&suggestion.base_check),
        check_rmse_after: normalised(&judged.check),
        delta_bic: rounded(judged.delta_bic, DIGITS),
        parameters: judged.effects.iter().flat_map(|effect| parameters(&judged.trial, &effect.id)).collect(),
        confounded_with: judged.confounded_with.clone(),
        warnings: judged.warnings.clone(),
        effects: judged.effects.iter().map(|effect| scored(&suggestion.base, effect)).collect(),
    }
}

/// The equation into which an effect enters.
fn equation(rig: &Rig, candidate: &Candidate) -> String {
    let spot = match candidate.placed.spot {
        Location::Fluid => {
            let property = candidate.placed.effect.at.property_of_fluid();
            return format!("{} of the fluid", property.unwrap_or("law"));
        }
        Location::Sensor(sensor) => return format!("reading of {}", rig.sensors[sensor].name),
        Location::Node(node) => &rig.nodes[node].name,
        Location::Component(component) => &rig.components[component].name,
    };
    match candidate.placed.effect.form {
        Form::Shunt { card, .. } => joined(rig, &candidate.id, card).unwrap_or_else(|| format!("balance at {spot}")),
        Form::Series { .. } => format!("pressure drop of the line at {spot}"),
        Form::PressureLoss { .. } => format!("pressure drop over {spot}"),
        Form::ParameterChange | Form::Reading { .. } => format!("law of {spot}"),
    }
}

/// The balances of the nodes on which a joined component acts: ports of the kind that its worked number is about.
fn joined(rig: &Rig, id: &str, card: &Card) -> Option<String> {
    let component = rig.components.iter().find(|component| component.name == id)?;
    let kind = match card.worked.first()?.answer {
        Answer::Through(port) | Answer::Capacity(port) => card.ports.get(port)?.kind,
        Answer::Rate(_) => return None,
    };
    let acted = card.ports.iter().zip(&component.ports).filter(|(port, _)| port.kind == kind);
    let nodes = acted.map(|(_, node)| &rig.nodes[*node]).filter(|node| !matches!(node.kind, NodeKind::Held { .. }));
    let names: Vec<&str> = nodes.map(|node| node.name.as_str()).collect();
    let balance = if kind == PortKind::Mechanical { "force balance" } else { "pressure balance" };
    (!names.is_empty()).then(|| format!("{balance} of {}", names.join(" and ")))
}

/// The parameters of one effect of a fitted model.
pub(crate) fn parameters(trial: &FittedModel, id: &str) -> Vec<EffectParameter> {
    let Some(present) = trial.rig.effects.iter().find(|present| present.id == id) else { return Vec::new() };
    let one = |(free, &index): (&FreeParameter, &usize)| {
        let parameter = &trial.rig.parameters[index];
        let shown = |si: f64| rounded(parameter.unit.from_si(si), DIGITS);
        let (low, high) = parameter.bounds;
        let value = trial.values[index];
        let unit = trial.rig.effect_unit(&present.placed, free.name);
        let ended = trial.at_bound.contains(&index);
        // Where it does nothing, one side of it is open by nature.
        let at_neutral = ended && free.neutral.is_some_and(|neutral| value == unit.difference_to_si(neutral));
        let end = |sign: f64| {
            let beyond = if sign < 0.0 { value <= low } else { value >= high };
            let sigma = trial.sigmas.get(&index).filter(|_| !ended || (at_neutral && !beyond))?;
            // What is positive may be as good as nothing.
            let low = if is_next_to_nothing(low) { 0.0 } else { low };
            Some(shown((value + sign * QUANTILE * sigma).clamp(low, high)))
        };
        EffectParameter {
            id: parameter.id.clone(),
            value: shown(value),
            unit: parameter.unit.symbol.clone(),
            ci95: [end(-1.0), end(1.0)],
            at_bound: ended && !at_neutral,
        }
    };
    present.placed.effect.parameters.iter().zip(&present.parameters).map(one).collect()
}

/// The smallest size of a candidate that the record could show, in the unit of its size.
fn smallest_detectable(base: &FittedModel, candidate: &Candidate) -> Option<f64> {
    let free = candidate.placed.effect.parameters.first()?;
    let size = candidate.smallest * distance(&base.rig, candidate)?;
    let unit = base.rig.effect_unit(&candidate.placed, free.name);
    (candidate.excited && size.is_finite()).then(|| rounded(unit.difference_from_si(size), DIGITS))
}

fn onset(base: &FittedModel, candidate: &Candidate) -> Option<OnsetReport> {
    let mut tried = candidate.placed.effect.parameters.iter().zip(&candidate.tried);
    let (free, from) = tried.find(|(free, _)| matches!(free.first, InitialGuess::Onset(_)))?;
    let unit = base.rig.effect_unit(&candidate.placed, free.name);
    let from = rounded(unit.from_si(from.value), DIGITS);
    Some(OnsetReport { from, unit: unit.symbol, smallest_detectable: smallest_detectable(base, candidate) })
}

fn scored(base: &FittedModel, candidate: &Candidate) -> ScoredReport {
    let placed = &candidate.placed;
    let free = placed.effect.parameters.first();
    let unit = free.map(|free| base.rig.effect_unit(placed, free.name));
    ScoredReport {
        id: candidate.id.clone(),
        in_words: placed.effect.in_words(),
        parameter: free.map_or("", |free| free.name).to_owned(),
        smallest_detectable: smallest_detectable(base, candidate),
        onsets: std::iter::once(candidate).chain(&candidate.others).filter_map(|one| onset(base, one)).collect(),
        unit: unit.map_or("-".to_owned(), |unit| unit.symbol),
        absorbed_by: candidate.absorbed_by.clone(),
        excited: candidate.excited,
        score: rounded(candidate.score, DIGITS),
    }
}
