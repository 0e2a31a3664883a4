//! What the tabs share: the rig, its records, and where the sliders stand.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::running::{Judged, Running};
use super::trace::Trace;
use crate::complaint::{Complaint, Kind, Place};
use crate::learn::add::{add, with_effects};
use crate::learn::compare::healthy_values;
use crate::learn::fitted_model::FittedModel;
use crate::learn::opened::neutral;
use crate::learn::result::SuggestionReport;
use crate::learn::revise::revised;
use crate::learn::suggest::Suggestion;
use crate::model::Model;
use crate::record::Record;
use crate::rig::Rig;

/// Most steps that can be undone.
const MOST_UNDONE: usize = 50;

/// A model beside its records, with all that was done to it so far.
#[derive(Debug)]
pub struct Desk {
    pub(super) rig: Rig,
    /// Of the rig file, without what the sliders did since.
    pub(super) text: String,
    model: Model,
    pub(super) sliders: Sliders,
    /// Where they stood when both records were last simulated, where one of them has not been since.
    left: Option<Sliders>,
    pub(super) fit: Trace,
    pub(super) check: Option<Trace>,
    pub(super) staircase: Vec<Step>,
    undo: Vec<Snapshot>,
    /// Grows with every change.
    pub(super) revision: u64,
    pub(super) running: Option<Running>,
    pub(super) found: Option<Found>,
    pub(super) judged: Option<Judged>,
    pub(super) note: Option<Note>,
}

/// Where everything stands that a hand can move.
#[derive(Debug, Clone, Default)]
pub(super) struct Sliders {
    /// All parameters of the rig, SI.
    pub values: Vec<f64>,
    /// The same without any fault: within its uncertainty a fit moves a fault's parameter in a healthy machine too.
    healthy: Vec<f64>,
    /// Effects and faults that are switched off, by id.
    pub off: BTreeSet<String>,
    /// Effects that were moved since the rig file was written.
    pub moved: BTreeSet<String>,
    /// Standard errors of the last fit, SI, by index of the rig's parameters.
    pub sigmas: BTreeMap<usize, f64>,
}

#[derive(Debug, Clone)]
struct Snapshot {
    text: String,
    sliders: Sliders,
    steps: usize,
}

/// A step of the staircase: the errors over both records, times the sensor noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Step {
    pub label: String,
    pub fit: f64,
    pub check: Option<f64>,
}

/// What `suggest` found on the rig as it stood.
#[derive(Debug)]
pub(super) struct Found {
    pub suggestion: Suggestion,
    pub report: SuggestionReport,
}

/// A sentence for the user.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Note {
    pub text: String,
    pub bad: bool,
}

/// What the page asks to be changed at once.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Change {
    /// A parameter of an effect or fault, in its unit.
    Value { id: String, value: f64 },
    /// An effect or a fault.
    Switch { id: String, on: bool },
}

impl Desk {
    /// Opens a rig with its records: uncertain values as `compare` fits them to the first, no fault present.
    ///
    /// # Errors
    /// Columns that are missing, or a model that cannot be solved on a record.
    pub fn new(rig: Rig, text: String, fit: Record, check: Option<Record>) -> Result<Self, Complaint> {
        let values = healthy_values(&rig, &fit)?;
        let trace = |record| Trace::new(&rig, record);
        let (fit, check) = (trace(fit)?, check.map(trace).transpose()?);
        let off = rig.faults.iter().map(|fault| rig.parameters[fault.parameter].id.clone()).collect();
        let sliders = Sliders { healthy: values.clone(), values, off, ..Sliders::default() };
        let model = Model::new(rig.clone());
        let (staircase, undo, left) = (Vec::new(), Vec::new(), None);
        let (running, found, judged, note) = (None, None, None, None);
        let mut desk = Self {
            rig,
            text,
            model,
            sliders,
            left,
            fit,
            check,
            staircase,
            undo,
            revision: 1,
            running,
            found,
            judged,
            note,
        };
        desk.follow()?;
        desk.step("your model")?;
        Ok(desk)
    }

    /// All parameters, SI, with what is switched off doing nothing.
    fn effective(&self) -> Vec<f64> {
        let mut values = self.sliders.values.clone();
        for effect in self.rig.effects.iter().filter(|effect| self.sliders.off.contains(&effect.id)) {
            for (free, &index) in effect.placed.effect.parameters.iter().zip(&effect.parameters) {
                if let Some(neutral) = neutral(&self.rig, &effect.placed, free) {
                    values[index] = neutral;
                }
            }
        }
        for fault in &self.rig.faults {
            if self.sliders.off.contains(&self.rig.parameters[fault.parameter].id) {
                values[fault.parameter] = self.sliders.healthy[fault.parameter];
            }
        }
        values
    }

    fn follow(&mut self) -> Result<(), Complaint> {
        let values = self.effective();
        let Self { fit, check, model, rig, .. } = self;
        let followed = |trace: &mut Trace| trace.follow(model, &values);
        let (fit, check) =
            rig.context().on_threads(|| rayon::join(|| followed(fit), || check.as_mut().map_or(Ok(()), followed)));
        fit.and(check)?;
        self.left = None;
        Ok(())
    }

    /// The record that is drawn follows the sliders at once, the other one when somebody asks.
    fn follow_drawn(&mut self, check: bool) -> Result<(), Complaint> {
        let values = self.effective();
        let (drawn, other) = match &mut self.check {
            Some(of_check) if check => (of_check, Some(&mut self.fit)),
            of_check => (&mut self.fit, of_check.as_mut()),
        };
        drawn.follow(&self.model, &values)?;
        if let Some(other) = other {
            other.current = false;
        }
        Ok(())
    }

    /// Both records follow the sliders. Where one of them cannot be simulated, the sliders go back to where both could.
    ///
    /// # Errors
    /// That place cannot be simulated either.
    pub(super) fn catch_up(&mut self) -> Result<(), Complaint> {
        let Some(left) = self.left.take() else { return Ok(()) };
        let Err(complaint) = self.follow() else { return Ok(()) };
        self.sliders = left;
        self.follow()?;
        self.complain(&complaint);
        Ok(())
    }

    fn step(&mut self, label: impl Into<String>) -> Result<(), Complaint> {
        let fit = self.fit.gauges(&self.rig)?.all;
        let check = self.check.as_ref().map(|check| check.gauges(&self.rig)).transpose()?.map(|gauges| gauges.all);
        self.staircase.push(Step { label: label.into(), fit, check });
        Ok(())
    }

    /// Moves sliders and switches; `check` says which record is drawn meanwhile.
    ///
    /// # Errors
    /// An id that the rig does not have, a value outside its physical bounds, or a model that cannot be solved there; then
    /// everything stays.
    pub fn change(&mut self, changes: &[Change], check: bool) -> Result<(), Complaint> {
        let before = self.sliders.clone();
        let moved = changes.iter().try_for_each(|change| self.moved(change));
        if let Err(complaint) = moved.and_then(|()| self.follow_drawn(check)) {
            self.sliders = before;
            return Err(complaint);
        }
        if self.check.is_some() {
            self.left.get_or_insert(before);
        }
        if changes.iter().any(|change| self.is_of_effect(change)) {
            self.judged = None;
        }
        self.note = None;
        self.revision += 1;
        Ok(())
    }

    fn is_of_effect(&self, change: &Change) -> bool {
        let (Change::Value { id, .. } | Change::Switch { id, .. }) = change;
        let owns = |index: usize| self.rig.is_of_effect(index);
        self.rig.effects.iter().any(|effect| effect.id == *id) || self.rig.parameter(id).is_some_and(owns)
    }

    fn moved(&mut self, change: &Change) -> Result<(), Complaint> {
        let unknown = |id: &str| Complaint::new(Kind::UnknownName, format!("there is no `{id}` on the desk"));
        match change {
            Change::Switch { id, on } => {
                let fault = self.rig.faults.iter().any(|fault| self.rig.parameters[fault.parameter].id == *id);
                if !fault && self.rig.effects.iter().all(|effect| effect.id != *id) {
                    return Err(unknown(id));
                }
                if *on {
                    self.sliders.off.remove(id);
                } else {
                    self.sliders.off.insert(id.clone());
                }
            }
            Change::Value { id, value } => {
                let index = self.rig.parameter(id).ok_or_else(|| unknown(id))?;
                let parameter = &self.rig.parameters[index];
                let effect = self.rig.effects.iter().find(|effect| effect.parameters.contains(&index));
                if effect.is_none() && !self.rig.is_fault(index) {
                    return Err(unknown(id));
                }
                let si = parameter.unit.to_si(*value);
                if !(parameter.bounds.0..=parameter.bounds.1).contains(&si) {
                    return Err(Complaint::new(Kind::Bounds, format!("`{id}` cannot be {value}"))
                        .help(crate::rig::range(parameter.bounds, &parameter.unit)));
                }
                self.sliders.values[index] = si;
                self.sliders.sigmas.remove(&index);
                match effect {
                    Some(effect) => drop(self.sliders.moved.insert(effect.id.clone())),
                    // Whoever moves the slider of a fault wants to see what it does.
                    None => drop(self.sliders.off.remove(id)),
                }
            }
        }
        Ok(())
    }

    /// The rig file as the sliders and switches of the effects stand; faults are no part of it.
    ///
    /// # Errors
    /// A text that is no TOML.
    pub fn current_text(&self) -> Result<String, Complaint> {
        let sliders = &self.sliders;
        revised(&self.text, &self.rig, &sliders.values, (&sliders.moved, &sliders.off))
    }

    /// The rig of [`Desk::current_text`].
    pub(super) fn current(&self) -> Result<(String, Rig), Complaint> {
        let text = self.current_text()?;
        let rig = Rig::parse(self.rig.path.clone(), text.clone())?.with_context(self.rig.context());
        Ok((text, rig))
    }

    /// Adds an effect of the library where it does nothing yet.
    ///
    /// # Errors
    /// As [`add`].
    pub(super) fn add_by_hand(&mut self, id: &str) -> Result<(), Complaint> {
        let (text, rig) = self.current()?;
        let added = add(&text, &rig, id, None)?;
        self.put(added.text, None, format!("+ {id}"))?;
        self.say(format!("{id} is in the model, where it does nothing yet: move its sliders, or press Fit"));
        Ok(())
    }

    /// Adds what a suggestion found, as it was fitted there.
    ///
    /// # Errors
    /// No such candidate.
    pub(super) fn add_found(&mut self, number: usize) -> Result<(), Complaint> {
        let best = self.found.as_ref().and_then(|found| found.suggestion.judged.get(number));
        let Some((id, trial)) = best.map(|best| (best.id(), best.trial.clone())) else {
            return Err(Complaint::new(Kind::UnknownName, "this was found for a model that is no more on the desk")
                .help("look for what is missing again"));
        };
        let (text, rig) = self.current()?;
        let text = with_effects(&self.rig.path, &text, &rig, &trial)?;
        self.put(text, Some(&trial), format!("+ {id}"))?;
        self.say(format!("{id} is in the model as it was fitted, with the faults that the fit found beside it"));
        Ok(())
    }

    /// Lays a rig file on the desk, the sliders as a fit left them; what was there before can be had back.
    pub(super) fn put(&mut self, text: String, fitted: Option<&FittedModel>, label: String) -> Result<(), Complaint> {
        let snapshot = Snapshot { text: self.text.clone(), sliders: self.sliders.clone(), steps: self.staircase.len() };
        let (old, old_sliders) = (self.rig.clone(), self.sliders.clone());
        let rig = Rig::parse(self.rig.path.clone(), text.clone())?.with_context(self.rig.context());
        let by_id = |index: usize| match fitted {
            Some(fitted) => fitted.rig.parameter(&rig.parameters[index].id).map(|at| fitted.values[at]),
            None => old.parameter(&rig.parameters[index].id).map(|at| old_sliders.values[at]),
        };
        let values = (0..rig.parameters.len()).map(|index| by_id(index).unwrap_or(rig.parameters[index].value));
        let values: Vec<f64> = values.collect();
        let mut sliders = Sliders { healthy: values.clone(), values, ..Sliders::default() };
        match fitted {
            Some(fitted) => {
                let present: BTreeSet<&str> = fitted.set.iter().map(|fault| fitted.rig.fault_id(fault)).collect();
                for fault in &rig.faults {
                    let id = &rig.parameters[fault.parameter].id;
                    if present.contains(id.as_str()) {
                        sliders.healthy[fault.parameter] = fault.healthy;
                    } else {
                        sliders.off.insert(id.clone());
                    }
                }
                let here = |(at, sigma): (&usize, &f64)| Some((rig.parameter(&fitted.rig.parameters[*at].id)?, *sigma));
                sliders.sigmas = fitted.sigmas.iter().filter_map(here).collect();
            }
            None => {
                let was = |index: usize| old.parameter(&rig.parameters[index].id).map(|at| old_sliders.healthy[at]);
                for fault in &rig.faults {
                    sliders.healthy[fault.parameter] = was(fault.parameter).unwrap_or(fault.healthy);
                }
                sliders.off = old_sliders.off;
            }
        }
        self.lay(rig, text, sliders)?;
        self.undo.push(snapshot);
        if self.undo.len() > MOST_UNDONE {
            self.undo.remove(0);
        }
        self.step(label)
    }

    fn lay(&mut self, rig: Rig, text: String, sliders: Sliders) -> Result<(), Complaint> {
        self.fit.renew(&rig)?;
        self.check.as_mut().map_or(Ok(()), |check| check.renew(&rig))?;
        self.model = Model::new(rig.clone());
        (self.rig, self.text, self.sliders) = (rig, text, sliders);
        (self.found, self.judged) = (None, None);
        self.revision += 1;
        self.follow()
    }

    /// Takes the last step back.
    ///
    /// # Errors
    /// There is none.
    pub(super) fn undo(&mut self) -> Result<(), Complaint> {
        let Some(before) = self.undo.pop() else {
            return Err(Complaint::new(Kind::Empty, "there is nothing to undo").at(Place::file(&self.rig.path)));
        };
        let rig = Rig::parse(self.rig.path.clone(), before.text.clone())?.with_context(self.rig.context());
        self.lay(rig, before.text, before.sliders)?;
        self.staircase.truncate(before.steps);
        self.say("the last step is undone".to_owned());
        Ok(())
    }

    pub(super) fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    pub(super) fn say(&mut self, text: String) {
        self.note = Some(Note { text, bad: false });
        self.revision += 1;
    }

    pub(super) fn complain(&mut self, complaint: &Complaint) {
        self.note = Some(Note { text: complaint.to_string(), bad: true });
        self.revision += 1;
    }
}
