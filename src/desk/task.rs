//! The long work of the desk: find, fit, judge. One at a time, in a thread of its own, and it can be stopped.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::running::{Judged, Running, Task};
use super::shared::Shared;
use super::state::{Desk, Found};
use crate::complaint::{Complaint, Kind};
use crate::context::{Context, Progress};
use crate::learn::compare::compare;
use crate::learn::fitted_model::FittedModel;
use crate::learn::result::SuggestionReport;
use crate::learn::revise::refitted;
use crate::learn::suggest::{Suggestion, suggest};
use crate::record::Record;
use crate::rig::Rig;

/// Least time between two words of progress.
const PAUSE: Duration = Duration::from_millis(100);

enum Outcome {
    Found(Box<Suggestion>),
    Fitted(String, Box<FittedModel>),
    Judged(Box<Judged>),
}

/// What a task works on, apart from the desk, whose sliders go on moving.
struct Work {
    task: Task,
    text: String,
    rig: Rig,
    fit: Record,
    check: Option<Record>,
}

/// Begins a task.
///
/// # Errors
/// One is on its way already.
pub fn begin(shared: &Arc<Shared>, task: Task) -> Result<(), Complaint> {
    let mut desk = shared.desk();
    desk.idle()?;
    let context = listened(shared);
    let (text, rig) = desk.current()?;
    let (fit, check) = (desk.fit.record.clone(), desk.check.as_ref().map(|check| check.record.clone()));
    let work = Work { task, text, rig: rig.with_context(&context), fit, check };
    desk.running = Some(Running { task, context, stage: "beginning".to_owned(), done: 0, of: None });
    (desk.note, desk.revision) = (None, desk.revision + 1);
    drop(desk);
    shared.tell();
    let shared = Arc::clone(shared);
    std::thread::spawn(move || {
        let outcome = work.run();
        let mut desk = shared.desk();
        desk.running = None;
        let ended = outcome.and_then(|outcome| desk.take(outcome, &work));
        desk.revision += 1;
        match ended {
            Ok(()) => {}
            Err(complaint) if complaint.kind == Kind::Interrupted => {
                desk.say("stopped; everything is as before".to_owned())
            }
            Err(complaint) => desk.complain(&complaint),
        }
        drop(desk);
        shared.tell();
    });
    Ok(())
}

/// A context whose progress the tabs see.
fn listened(shared: &Arc<Shared>) -> Context {
    let (shared, told) = (Arc::downgrade(shared), Mutex::new(None::<Instant>));
    Context::new().with_progress(move |Progress { stage, done, of }| {
        let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.is_some_and(|told| told.elapsed() < PAUSE) {
            return;
        }
        *told = Some(Instant::now());
        let Some(shared) = shared.upgrade() else { return };
        // Whoever simulates a slider meanwhile goes first.
        let Some(mut desk) = shared.try_desk() else { return };
        if let Some(running) = &mut desk.running {
            (running.stage, running.done, running.of) = (stage.to_owned(), done, of);
            desk.revision += 1;
            drop(desk);
            shared.tell();
        }
    })
}

impl Work {
    fn run(&self) -> Result<Outcome, Complaint> {
        match self.task {
            Task::Find => Ok(Outcome::Found(Box::new(suggest(&self.rig, &self.fit, self.check.as_ref())?))),
            Task::Fit => {
                let (text, fitted) = refitted(&self.text, &self.rig, &self.fit)?;
                Ok(Outcome::Fitted(text, Box::new(fitted)))
            }
            Task::Judge => {
                let check = self.check.as_ref().map(|check| compare(&self.rig, check)).transpose()?;
                Ok(Outcome::Judged(Box::new(Judged { fit: compare(&self.rig, &self.fit)?, check })))
            }
        }
    }
}

impl Desk {
    /// Whether nothing is on its way.
    pub(super) fn idle(&self) -> Result<(), Complaint> {
        match self.running {
            None => Ok(()),
            Some(_) => Err(Complaint::new(Kind::Locked, "the desk is at work").help("wait for it, or press Stop")),
        }
    }

    fn take(&mut self, outcome: Outcome, work: &Work) -> Result<(), Complaint> {
        // What was moved meanwhile is another model than the one that was worked on.
        let same = self.current_text()? == work.text;
        match outcome {
            Outcome::Found(suggestion) => {
                let report = SuggestionReport::new(&suggestion, &work.fit, work.check.as_ref())?;
                self.found = Some(Found { suggestion: *suggestion, report });
            }
            Outcome::Fitted(text, fitted) => {
                self.put(text, Some(&fitted), "fit".to_owned())?;
                self.say("fitted: effects, faults and uncertain values together".to_owned());
            }
            Outcome::Judged(judged) if same => self.judged = Some(*judged),
            Outcome::Judged(_) => {
                self.say("the effects were moved meanwhile: judge again".to_owned());
            }
        }
        Ok(())
    }
}
