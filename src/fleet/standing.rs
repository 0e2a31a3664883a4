//! How one rig stands.

use std::cmp::Ordering;

use serde::Serialize;

use crate::history::forecast::State as Towards;
use crate::history::{Axis, By, FaultHistory, Frame, course};
use crate::store::{Moment, StoredRun};

/// Values of a course that are kept for its picture.
const COURSE: usize = 12;

/// What a rig needs, the worst first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// A fault has reached the limit of its part.
    LimitReached,
    /// The last run found a fault.
    Faulty,
    /// The model does not explain the last run.
    ModelInadequate,
    /// A fault is surely on its way to its limit.
    LimitAhead,
    /// None of these.
    Healthy,
}

impl State {
    /// Every state, the worst first.
    pub const ALL: [Self; 5] =
        [Self::LimitReached, Self::Faulty, Self::ModelInadequate, Self::LimitAhead, Self::Healthy];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::LimitReached => "limit reached",
            Self::Faulty => "faulty",
            Self::ModelInadequate => "model inadequate",
            Self::LimitAhead => "limit ahead",
            Self::Healthy => "healthy",
        }
    }
}

/// A fault that the last run found. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Present {
    /// Such as `cylinder.clearance`.
    pub id: String,
    /// Estimate; `None` where there is no finite one.
    pub value: Option<f64>,
    /// As the rig file has it.
    pub unit: String,
    /// Ends of the 95 % interval; `None` where the record does not bound it.
    pub ci95: [Option<f64>; 2],
    /// Of its being present.
    pub probability: Option<f64>,
}

/// A limit that a fault has reached, or surely will.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Next {
    /// Such as `cylinder.clearance`.
    pub fault: String,
    /// From which value on the part no longer serves.
    pub limit: f64,
    /// Of the limit.
    pub unit: String,
    /// Where the fault stands on its way.
    pub state: Towards,
    /// When the trend reaches it; `None` where there is no trend.
    pub reached_at: Option<String>,
    /// First and last moment within the uncertainty of the trend, 95 %.
    pub ci95: [Option<String>; 2],
}

/// How a rig stands.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Standing {
    /// Name of the rig; without one, the path of its file.
    pub rig: String,
    /// What it needs.
    pub state: State,
    /// When its last record was measured.
    #[cfg_attr(feature = "internals", schemars(with = "String"))]
    pub measured_at: Moment,
    /// The last record, as the user named it.
    pub record: String,
    /// What the diagnosis of that said.
    pub verdict: String,
    /// How many runs count.
    pub runs: usize,
    /// Faults that the last run found, the most probable first.
    pub faults: Vec<Present>,
    /// The limit that is reached first; `None` where none surely is.
    pub next: Option<Next>,
    /// The fault whose course is shown: that of `next`, else the first of `faults`; with its last values.
    pub course: Option<Course>,
}

/// The last values of a fault. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Course {
    /// Such as `cylinder.clearance`.
    pub fault: String,
    /// As the rig file has it.
    pub unit: String,
    /// Healthy value.
    pub healthy: f64,
    /// From which value on the part no longer serves.
    pub limit: Option<f64>,
    /// In the order of their times.
    pub values: Vec<f64>,
}

impl Standing {
    /// Which rig a run is of: its name, without one the path of its file.
    pub(super) fn name(run: &StoredRun) -> &str {
        if run.rig_name.is_empty() { &run.rig } else { &run.rig_name }
    }

    /// Of a rig with these runs, in the order of their times; `None` without any.
    pub(super) fn of(runs: &[&StoredRun]) -> Option<Self> {
        let last = runs.last()?;
        let frames = last.faults.iter().filter_map(Frame::of_run);
        let courses: Vec<FaultHistory> = frames.map(|frame| course(frame, runs, By::Time)).collect();
        let next = courses.iter().filter_map(next).min_by(sooner);
        let mut faults: Vec<Present> = last.faults.iter().filter(|fault| fault.present).map(present).collect();
        faults.sort_by(|a, b| b.probability.unwrap_or(0.0).total_cmp(&a.probability.unwrap_or(0.0)));
        let state = match (&next, last.verdict.as_str()) {
            (Some(next), _) if next.is_reached() => State::LimitReached,
            (_, "faulty") => State::Faulty,
            (_, "model-inadequate") => State::ModelInadequate,
            (Some(_), _) => State::LimitAhead,
            (None, _) => State::Healthy,
        };
        let shown = next.as_ref().map(|next| &next.fault).or(faults.first().map(|fault| &fault.id));
        let shown = shown.and_then(|id| courses.iter().find(|course| course.id == *id));
        Some(Self {
            rig: Self::name(last).to_owned(),
            state,
            measured_at: last.measured_at,
            record: last.record.clone(),
            verdict: last.verdict.clone(),
            runs: runs.len(),
            course: shown.map(|course| Course {
                fault: course.id.clone(),
                unit: course.unit.clone(),
                healthy: course.healthy,
                limit: course.limit,
                values: course
                    .values
                    .iter()
                    .skip(course.values.len().saturating_sub(COURSE))
                    .map(|one| one.value)
                    .collect(),
            }),
            faults,
            next,
        })
    }

    /// The worse state first, of one state the limit that is reached sooner, then the more probable fault, then the name.
    pub(super) fn worse_first(&self, other: &Self) -> Ordering {
        let soon = |rig: &Self| rig.next.as_ref().map_or((true, None), |next| (false, next.reached_at.clone()));
        let probability = |rig: &Self| rig.faults.first().and_then(|fault| fault.probability).unwrap_or(0.0);
        let state = self.state.cmp(&other.state).then_with(|| soon(self).cmp(&soon(other)));
        let state = state.then_with(|| probability(other).total_cmp(&probability(self)));
        state.then_with(|| self.rig.cmp(&other.rig))
    }
}

impl Next {
    /// Whether it is behind or at hand rather than ahead.
    pub fn is_reached(&self) -> bool {
        matches!(self.state, Towards::Passed | Towards::AtLimit)
    }
}

fn sooner(a: &Next, b: &Next) -> Ordering {
    b.is_reached()
        .cmp(&a.is_reached())
        .then_with(|| a.reached_at.cmp(&b.reached_at))
        .then_with(|| a.fault.cmp(&b.fault))
}

fn present(fault: &crate::store::StoredFault) -> Present {
    Present {
        id: fault.id.clone(),
        value: fault.value,
        unit: fault.unit.clone(),
        ci95: [fault.low, fault.high],
        probability: fault.probability,
    }
}

/// What is said of the limit of a fault; `None` where it has none, or where nothing is sure.
fn next(course: &FaultHistory) -> Option<Next> {
    let (limit, last) = (course.limit?, course.values.last()?);
    let sign = if limit > course.healthy { 1.0 } else { -1.0 };
    let is_beyond = |value: f64| sign * (value - limit) >= 0.0;
    let next = |state, reached_at: Option<&Axis>, ci95: [Option<&Axis>; 2]| Next {
        fault: course.id.clone(),
        limit,
        unit: course.unit.clone(),
        state,
        reached_at: reached_at.map(moment),
        ci95: ci95.map(|end| end.map(moment)),
    };
    let (Some(forecast), Some(trend)) = (&course.forecast, &course.trend) else {
        // Too few runs for a trend: the last one alone, where it calls the fault present.
        let near_end = if sign > 0.0 { last.ci95[0] } else { last.ci95[1] };
        let state = if near_end.is_some_and(is_beyond) { Towards::Passed } else { Towards::AtLimit };
        return (last.present && is_beyond(last.value)).then(|| next(state, None, [None, None]));
    };
    let is_sure = match forecast.state {
        Towards::Passed | Towards::WillPass => true,
        // The band of a short trend is wide: it counts where the trend itself is there.
        Towards::AtLimit => is_beyond(trend.now),
        Towards::MayPass | Towards::Receding => false,
    };
    is_sure.then(|| next(forecast.state, forecast.passes_at.as_ref(), forecast.ci95.each_ref().map(Option::as_ref)))
}

fn moment(axis: &Axis) -> String {
    match axis {
        Axis::Time(moment) => moment.clone(),
        Axis::Run(run) => run.to_string(),
    }
}
