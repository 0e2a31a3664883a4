//! One case in a table: what was injected, what was found.

use serde::{Deserialize, Serialize};

use super::disturb::Disturbed;
use super::draw::Injected;
use crate::diagnosis::{Diagnosis, Verdict};
use crate::number::in_unit;

/// How a case ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The diagnosis found the rig healthy.
    Healthy,
    /// The diagnosis found at least one fault.
    Faulty,
    /// The model explained the record with no combination of faults.
    ModelInadequate,
    /// There is no diagnosis; [`Row::failure`] says why.
    Failed,
}

impl From<Verdict> for Outcome {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Healthy => Self::Healthy,
            Verdict::Faulty => Self::Faulty,
            Verdict::ModelInadequate => Self::ModelInadequate,
        }
    }
}

impl Outcome {
    /// As JSON and CSV write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Healthy => "healthy",
            Self::Faulty => "faulty",
            Self::ModelInadequate => "model-inadequate",
            Self::Failed => "failed",
        }
    }
}

/// One fault of the rig in one case. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultRow {
    /// Such as `cylinder.clearance`.
    pub id: String,
    /// As the rig file has it.
    pub unit: String,
    /// Whether the case has it.
    pub injected: bool,
    /// Of the disturbed rig.
    pub healthy: f64,
    /// What the parameter was at the end of the record.
    pub truth: f64,
    /// Leakage in L/min that the fault makes at the case's pressure; only of injected clearances.
    pub flow_l_min: Option<f64>,
    /// Estimate; `None` where the case failed.
    pub value: Option<f64>,
    /// Ends of the 95 % interval; `None` is open.
    pub ci95: [Option<f64>; 2],
    /// Whether the diagnosis called it present.
    pub present: bool,
    /// That it is present; `None` where the case failed.
    pub probability: Option<f64>,
}

impl FaultRow {
    /// How far the injected fault is from the healthy value.
    pub fn size(&self) -> f64 {
        (self.truth - self.healthy).abs()
    }

    /// Whether the interval holds the truth; an open end holds everything on its side.
    pub fn covered(&self) -> bool {
        self.ci95[0].is_none_or(|low| low <= self.truth) && self.ci95[1].is_none_or(|high| self.truth <= high)
    }

    /// Whether both ends of the interval are closed.
    pub fn closed(&self) -> bool {
        self.ci95.iter().all(Option::is_some)
    }
}

/// One case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Row {
    /// From 0.
    pub case: usize,
    /// Disturbed rig, from 0.
    pub rig: usize,
    /// How often the case, and its rig, were drawn anew because a simulation came to no end.
    pub redrawn: usize,
    /// The same of its rig.
    pub rig_redrawn: usize,
    /// Whether the calibrated model explains the healthy records of its rig; `None` where there is none.
    pub rig_adequate: Option<bool>,
    /// How many faults were to be injected.
    pub count: usize,
    /// When the faults began, s; `None` where they are as old as the record.
    pub onset_s: Option<f64>,
    /// When a command first leaves zero, s.
    pub motion_s: f64,
    /// What the diagnosis came to.
    pub outcome: Outcome,
    /// Why there is no diagnosis; `None` where there is one.
    pub failure: Option<String>,
    /// When the faults were detected, s; `None` where they were not.
    pub detected_at_s: Option<f64>,
    /// Whether, by sensitivities at the faults and without noise, every set that lacks one of them would lose; `None` of
    /// healthy cases and where this could not be worked out.
    pub identifiable: Option<bool>,
    /// The set most easily mistaken for the injected one, and the probability that noise makes it so.
    pub rival: Vec<String>,
    /// Probability that noise makes `rival` look like the injected set.
    pub mistaken: Option<f64>,
    /// The most probable set of faults, and its probability.
    pub top: Vec<String>,
    /// Its probability.
    pub top_probability: Option<f64>,
    /// Probability of the set that was injected.
    pub truth_probability: Option<f64>,
    /// How many of the most probable sets are needed to reach `SURE`.
    pub ambiguity: Option<usize>,
    /// Mean square of the weighted misfit of the fit: 1 if the model is right within its tolerance.
    pub chi2_reduced: Option<f64>,
    /// Every fault of the rig, in its order.
    pub faults: Vec<FaultRow>,
    /// Duration of the diagnosis, s. Nothing else in the row depends on the machine.
    pub seconds: f64,
}

/// Probability that the sets counted by the ambiguity reach.
pub const SURE: f64 = 0.95;

impl Row {
    /// The row of a case that has not been diagnosed.
    pub(super) fn new(case: usize, rig: usize, count: usize, disturbed: &Disturbed, injected: &Injected) -> Self {
        let faults = disturbed.rig.faults.iter().enumerate().map(|(index, fault)| {
            let parameter = &disturbed.rig.parameters[fault.parameter];
            let (healthy, unit) = (disturbed.healthy[index], &parameter.unit);
            let truth = injected.faults.iter().find(|(other, _)| *other == index).map(|(_, value)| *value);
            FaultRow {
                id: parameter.id.clone(),
                unit: unit.symbol.clone(),
                injected: truth.is_some(),
                healthy: in_unit(healthy, unit),
                truth: in_unit(truth.unwrap_or(healthy), unit),
                flow_l_min: None,
                value: None,
                ci95: [None, None],
                present: false,
                probability: None,
            }
        });
        Self {
            case,
            rig,
            redrawn: 0,
            rig_redrawn: 0,
            rig_adequate: None,
            count,
            onset_s: injected.onset,
            motion_s: 0.0,
            outcome: Outcome::Failed,
            failure: None,
            detected_at_s: None,
            identifiable: None,
            rival: Vec::new(),
            mistaken: None,
            top: Vec::new(),
            top_probability: None,
            truth_probability: None,
            ambiguity: None,
            chi2_reduced: None,
            faults: faults.collect(),
            seconds: 0.0,
        }
    }

    /// Enters what was found.
    pub(super) fn take(&mut self, diagnosis: &Diagnosis) {
        self.outcome = diagnosis.verdict.into();
        self.failure = None;
        self.detected_at_s = diagnosis.detected_at_s;
        self.chi2_reduced = Some(diagnosis.fit.chi2_reduced);
        for (row, found) in self.faults.iter_mut().zip(&diagnosis.faults) {
            row.value = Some(found.value);
            row.ci95 = found.ci95;
            row.present = found.present;
            row.probability = Some(found.probability);
        }
        let injected = self.injected();
        let is_injected = |set: &[String]| {
            set.len() == injected.len() && injected.iter().all(|id| set.iter().any(|other| other == id))
        };
        let found = diagnosis.hypotheses.iter().find(|hypothesis| is_injected(&hypothesis.faults));
        let truth_probability = found.map_or(0.0, |hypothesis| hypothesis.probability);
        if let Some(top) = diagnosis.hypotheses.first() {
            self.top.clone_from(&top.faults);
            self.top_probability = Some(top.probability);
            self.truth_probability = Some(truth_probability);
            let mut sum = 0.0;
            let needed = diagnosis.hypotheses.iter().position(|hypothesis| {
                sum += hypothesis.probability;
                sum >= SURE
            });
            self.ambiguity = Some(needed.map_or(diagnosis.hypotheses.len(), |last| last + 1));
        }
    }

    /// Ids of the injected faults, in the order of the rig.
    pub(crate) fn injected(&self) -> Vec<&str> {
        self.faults.iter().filter(|fault| fault.injected).map(|fault| fault.id.as_str()).collect()
    }

    /// Ids of the faults called present, in the order of the rig.
    #[cfg(feature = "cli")]
    pub(crate) fn found(&self) -> Vec<&str> {
        self.faults.iter().filter(|fault| fault.present).map(|fault| fault.id.as_str()).collect()
    }

    /// Whether anything was injected, or was to be where the case failed.
    pub(crate) fn is_faulty(&self) -> bool {
        self.count > 0
    }

    /// Whether something was reported: a verdict other than healthy.
    pub(crate) fn alarmed(&self) -> bool {
        matches!(self.outcome, Outcome::Faulty | Outcome::ModelInadequate)
    }

    /// Whether the faults called present are those injected, under a verdict that stands by them.
    pub(crate) fn isolated(&self) -> bool {
        let stands = matches!(self.outcome, Outcome::Faulty | Outcome::Healthy);
        stands && self.faults.iter().all(|fault| fault.injected == fault.present)
    }

    /// Whether the most probable set is the injected one.
    pub(crate) fn top_is_right(&self) -> bool {
        let injected = self.injected();
        self.top_probability.is_some()
            && self.top.len() == injected.len()
            && injected.iter().all(|id| self.top.iter().any(|other| other == id))
    }

    /// From when on the faults could have shown, s: their onset, or the first motion.
    pub(crate) fn begin_s(&self) -> f64 {
        self.onset_s.unwrap_or(self.motion_s)
    }
}
