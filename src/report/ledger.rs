//! The ledger of `improve` as programs read it: `borescope.improvement/1`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::digits::plus_minus;
use super::learn::multiple;
use super::unknown::Rise;
use crate::diagnosis::DynamicsReport;
use crate::learn::comparison::MisfitPlace;
use crate::learn::evaluated::Conclusion;
use crate::learn::improve::{Declined, Improvement, ImprovementStep};
use crate::learn::result::{EffectParameter, parameters};
use crate::learn::separate::Experiment;
use crate::learn::warning::Warning;
use crate::number::{before_unit, rounded, text};
use crate::rig::Rig;

/// Digits of an error.
const DIGITS: usize = 5;

/// The whole result. Outer errors are normalised by sensor noise over all channels, those of channels are in `unit`.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Ledger {
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// The fit record, as the user named it.
    pub fit_record: String,
    /// The check record, as the user named it.
    pub check_record: String,
    /// Whether the best one explains both records, or what is missing still.
    pub conclusion: Conclusion,
    /// The models, from yours to the best.
    pub steps: Vec<Row>,
    /// Faults that are fitted in the model of the first row; named beside it, since without them its error is another.
    #[serde(skip)]
    pub first_faults: Vec<String>,
    /// What a curve without a formula says, and the formula for the rig file.
    #[serde(skip)]
    pub rise: Option<Rise>,
    /// How spools follow their commands, where the fit record asks for other than the rig file has; the new rig file has it.
    pub dynamics: Vec<DynamicsReport>,
    /// What was added, as fitted in the end.
    pub effects: Vec<EffectReport>,
    /// Faults with which the model at the end explains the fit record; they are not in the new rig file.
    pub faults: Vec<FaultReport>,
    /// What explains the records alike, where several do, and what would tell the first of these from the second.
    pub alike: Vec<String>,
    /// What would tell rivals apart; `null` where there are none.
    pub experiment: Option<Experiment>,
    /// The best explanation where none was worth to be added.
    pub declined: Option<DeclinedReport>,
    /// What is left where something is.
    pub remaining: Option<MisfitPlace>,
}

/// An effect with its parameters.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct EffectReport {
    /// As rig files and programs know it.
    pub id: String,
    /// As they were fitted in the end.
    pub parameters: Vec<EffectParameter>,
}

/// What would have explained the records best and was not added, with its errors, times the sensor noise.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct DeclinedReport {
    /// Effect and place; of several all, with ` + ` between.
    pub effect: String,
    /// Error on the fit record, times the sensor noise.
    pub fit_rmse: f64,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
    /// Share by which an addition has to lower what is missed of the fit record beyond noise.
    pub asked_of_fit: f64,
    /// Share by which it has to lower the error of the check record.
    pub asked_of_check: f64,
}

impl DeclinedReport {
    fn of(declined: &Declined) -> Self {
        Self {
            effect: declined.id.clone(),
            fit_rmse: rounded(declined.model.fit.normalised, DIGITS),
            check_rmse: rounded(declined.check.normalised, DIGITS),
            asked_of_fit: declined.asked.0,
            asked_of_check: declined.asked.1,
        }
    }

    /// What it would give, and what it would have had to.
    pub fn sentence(&self) -> String {
        let percent = |share: f64| text(rounded(100.0 * share, 3));
        format!(
            "Not added: {}, with which the error is {} on the fit record and {} on the check record; it would have to lower the first by {} % \
             of what is beyond noise and the second by {} %.",
            self.effect,
            multiple(self.fit_rmse),
            multiple(self.check_rmse),
            percent(self.asked_of_fit),
            percent(self.asked_of_check)
        )
    }
}

/// A fault that was also estimated, in `unit`, with one standard deviation.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultReport {
    /// As rig files and programs know it.
    pub id: String,
    /// Estimate, in `unit`.
    pub value: f64,
    /// One standard deviation, in `unit`.
    pub sigma: f64,
    /// Unit of the numbers beside it.
    pub unit: String,
}

impl FaultReport {
    pub(super) fn text(&self) -> String {
        format!("{} {}", self.id, before_unit(plus_minus(self.value, self.sigma), &self.unit))
    }
}

/// One row: the model with what was added.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Row {
    /// The effect that was added; `null` of the model as it was given.
    pub added: Option<String>,
    /// Error on the fit record, times the sensor noise.
    pub fit_rmse: f64,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
    /// Mean square of the weighted misfits on the fit record: 1 within noise and tolerance.
    pub chi2_reduced: f64,
    /// Mean square of the weighted misfit of the check record.
    pub check_chi2_reduced: f64,
    /// Sensor by sensor.
    pub channels: BTreeMap<String, Channel>,
    /// Caveats, in words.
    #[cfg_attr(feature = "internals", schemars(with = "Vec<String>"))]
    pub warnings: Vec<Warning>,
    /// Extensions that reached less error on the check record but make no physical sense.
    pub refused: Vec<Refused>,
}

#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Channel {
    /// Unit of the numbers beside it.
    pub unit: String,
    /// Error on the fit record, times the sensor noise.
    pub fit_rmse: f64,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
}

#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Refused {
    /// Effect and place; of several all, with ` + ` between.
    pub effect: String,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
    /// Caveats, in words.
    #[cfg_attr(feature = "internals", schemars(with = "Vec<String>"))]
    pub warnings: Vec<Warning>,
}

impl Ledger {
    /// From what `improve` found; `names` are the files as the user gave them: rig, fit record, check record.
    pub fn new(improvement: &Improvement, names: [String; 3]) -> Self {
        let Improvement { given, trial, .. } = improvement;
        let rig = &trial.rig;
        let added = rig.effects.iter().filter(|effect| given.rig.effects.iter().all(|old| old.id != effect.id));
        let fault = |fault: usize| {
            let index = rig.faults[fault].parameter;
            let parameter = &rig.parameters[index];
            let sigma = trial.sigmas.get(&index).copied().unwrap_or(0.0);
            FaultReport {
                id: parameter.id.clone(),
                value: rounded(parameter.unit.from_si(trial.values[index]), DIGITS),
                sigma: rounded(parameter.unit.difference_from_si(sigma), DIGITS),
                unit: parameter.unit.symbol.clone(),
            }
        };
        let first_faults =
            given.set.iter().map(|fault| given.rig.parameters[given.rig.faults[fault].parameter].id.clone());
        let [rig_name, fit_record, check_record] = names;
        Self {
            schema: "borescope.improvement/1",
            rig: rig_name,
            fit_record,
            check_record,
            conclusion: improvement.conclusion,
            first_faults: first_faults.collect(),
            rise: Rise::of(trial).or_else(|| Rise::of(&improvement.declined.as_ref()?.model)),
            steps: improvement.steps.iter().map(|step| row(rig, step)).collect(),
            dynamics: improvement.dynamics.clone(),
            effects: added
                .map(|effect| EffectReport { id: effect.id.clone(), parameters: parameters(trial, &effect.id) })
                .collect(),
            faults: trial.set.iter().map(fault).collect(),
            alike: improvement.alike.clone(),
            experiment: improvement
                .experiment
                .clone()
                .map(|experiment| Experiment { sigma: rounded(experiment.sigma, DIGITS), ..experiment }),
            declined: improvement.declined.as_ref().map(DeclinedReport::of),
            remaining: improvement.rest.clone(),
        }
    }
}

impl Row {
    /// What the model of the row is called.
    pub fn name(&self) -> String {
        self.added.as_ref().map_or("your model".to_owned(), |added| format!("+ {added}"))
    }
}

fn row(rig: &Rig, step: &ImprovementStep) -> Row {
    let channels = rig.sensors.iter().enumerate().map(|(index, sensor)| {
        let unit = rig.sensor_unit(sensor);
        let shown = |si: f64| rounded(unit.difference_from_si(si), DIGITS);
        let channel = Channel {
            unit: unit.symbol.clone(),
            fit_rmse: shown(step.fit.rmse[index]),
            check_rmse: shown(step.check.rmse[index]),
        };
        (sensor.name.clone(), channel)
    });
    let refused = step.refused.iter().map(|(effect, run, warnings)| Refused {
        effect: effect.clone(),
        check_rmse: rounded(run.normalised, DIGITS),
        warnings: warnings.clone(),
    });
    Row {
        added: step.added.clone(),
        fit_rmse: rounded(step.fit.normalised, DIGITS),
        check_rmse: rounded(step.check.normalised, DIGITS),
        chi2_reduced: rounded(step.fit.chi2, DIGITS),
        check_chi2_reduced: rounded(step.check.chi2, DIGITS),
        channels: channels.collect(),
        warnings: step.warnings.clone(),
        refused: refused.collect(),
    }
}
