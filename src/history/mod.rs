//! The course of each fault over the runs of a store, and when it passes its limit.

pub mod forecast;
pub mod regression;
mod result;
mod values;

use std::collections::HashMap;

use crate::rig::{Fault, Rig};
#[cfg(feature = "cli")]
use crate::store::StoredFault;
use crate::store::{Moment, StoredRun};
use crate::units::Unit;
use forecast::passing;
use regression::{Line, Point, bend};
pub use result::{Axis, By, FaultHistory, Forecast, History, RunLine, RunValue, SCHEMA, Trend};

/// Seconds of a day, the time that slopes are told over.
const DAY: f64 = 86_400.0;
/// A bend of this many standard errors is told.
const BENT: f64 = 3.0;

/// What the runs of a rig say of each of its faults.
///
/// Of several diagnoses of one record, the last counts. Values are weighed by their intervals and by the scatter between
/// runs; those that no record bounds are left out.
pub fn history(rig: &Rig, store: &str, runs: &[StoredRun], by: By) -> History {
    let mut counted = newest(&runs.iter().collect::<Vec<_>>());
    if by == By::Run {
        counted.sort_by_key(|run| run.id);
    }
    let faults = rig.faults.iter().map(|fault| course(Frame::of_rig(rig, fault), &counted, by)).collect();
    History {
        schema: SCHEMA,
        rig: rig.path.display().to_string(),
        name: rig.name.clone(),
        store: store.to_owned(),
        by,
        warnings: warnings(runs.len(), &counted),
        runs: counted
            .iter()
            .map(|run| RunLine {
                run: run.id,
                measured_at: run.measured_at.to_string(),
                dated_by: run.dated_by.clone(),
                record: run.record.clone(),
                verdict: run.verdict.clone(),
                model_version: run.model_version.clone(),
                rig_digest: run.rig_digest.clone(),
            })
            .collect(),
        faults,
    }
}

/// Of several diagnoses of one record, the last.
pub fn newest<'a>(runs: &[&'a StoredRun]) -> Vec<&'a StoredRun> {
    let mut last: HashMap<&str, i64> = HashMap::new();
    for run in runs {
        let id = last.entry(&run.record_digest).or_insert(run.id);
        *id = run.id.max(*id);
    }
    runs.iter().copied().filter(|run| last.get(run.record_digest.as_str()) == Some(&run.id)).collect()
}

/// What the values of a fault are read against, in `unit`.
pub struct Frame {
    id: String,
    meaning: String,
    unit: Unit,
    healthy: f64,
    limit: Option<f64>,
    /// `None` where a run was kept without them.
    bounds: Option<[f64; 2]>,
}

impl Frame {
    /// As the rig file has it.
    fn of_rig(rig: &Rig, fault: &Fault) -> Self {
        let parameter = &rig.parameters[fault.parameter];
        let unit = parameter.unit.clone();
        Self {
            id: parameter.id.clone(),
            meaning: parameter.meaning.clone(),
            healthy: unit.from_si(fault.healthy),
            limit: fault.limit.map(|limit| unit.from_si(limit)),
            bounds: Some([fault.bounds.0, fault.bounds.1].map(|bound| unit.from_si(bound))),
            unit,
        }
    }

    /// As it was kept with a run; `None` without a healthy value, or with a unit that nobody knows.
    #[cfg(feature = "cli")]
    pub fn of_run(fault: &StoredFault) -> Option<Self> {
        Some(Self {
            id: fault.id.clone(),
            meaning: String::new(),
            unit: Unit::parse(&fault.unit).ok()?,
            healthy: fault.healthy?,
            limit: fault.limit,
            bounds: fault.lower_bound.zip(fault.upper_bound).map(|(low, high)| [low, high]),
        })
    }
}

/// What may make a course look other than the machine does.
fn warnings(all: usize, counted: &[&StoredRun]) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut warn = |count: usize, text: &dyn Fn(usize) -> String| {
        if count > 0 {
            warnings.push(text(count));
        }
    };
    let kinds = |of: fn(&StoredRun) -> &str| {
        let mut kinds: Vec<&str> = counted.iter().map(|run| of(run)).collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds.len().saturating_sub(1)
    };
    let count = |wanted: &dyn Fn(&StoredRun) -> bool| counted.iter().filter(|run| wanted(run)).count();
    warn(all - counted.len(), &|n| format!("older diagnoses of records that were diagnosed again, left out: {n}"));
    warn(kinds(|run| &run.rig_digest), &|n| {
        format!("versions of the rig file among the runs: {}; a step between them may come from there", n + 1)
    });
    warn(kinds(|run| &run.model_version), &|n| format!("versions of the program among the runs: {}", n + 1));
    warn(count(&|run| run.verdict == "model-inadequate"), &|n| {
        format!("runs whose model is inadequate, so that values may be off by more than their intervals: {n}")
    });
    warn(count(&|run| run.dated_by == "diagnosis"), &|n| {
        format!("runs with the time of their diagnosis, as their records came through a pipe: {n}")
    });
    warnings
}

/// The course of a fault over runs that count.
pub fn course(frame: Frame, runs: &[&StoredRun], by: By) -> FaultHistory {
    let Frame { id, meaning, unit, healthy, limit, bounds } = frame;
    let mut values: Vec<RunValue> = Vec::new();
    let mut points: Vec<Point> = Vec::new();
    let mut unbounded = 0;
    for (place, run) in runs.iter().enumerate() {
        let Some(stored) = run.faults.iter().find(|stored| stored.id == id) else { continue };
        let x = match by {
            By::Time => run.measured_at.seconds() / DAY,
            By::Run => (place + 1) as f64,
        };
        let Some(value) = values::in_unit(stored, &unit, (run, x)) else { continue };
        match values::sigma(&value, bounds) {
            Some(sigma) => points.push(Point { x, y: value.value, sigma }),
            None => unbounded += 1,
        }
        values.push(value);
    }
    let line = Line::through(&points);
    let last = points.iter().map(|point| point.x).fold(f64::NEG_INFINITY, f64::max);
    let axis = |x: f64| match by {
        By::Time => Moment::of_seconds(x * DAY).map(|moment| Axis::Time(moment.to_string())),
        By::Run => Some(Axis::Run(values::short(x))),
    };
    let forecast = line.as_ref().zip(limit).map(|(line, limit)| {
        let passing = passing(line, limit, limit > healthy, last);
        Forecast {
            state: passing.state,
            passes_at: passing.at.and_then(axis),
            ci95: passing.between.map(|end| end.and_then(axis)),
        }
    });
    let mut remarks = Vec::new();
    if unbounded > 0 {
        remarks.push(format!("{unbounded} of {} runs do not bound it and are left out", values.len()));
    }
    if line.is_none() && !values.is_empty() {
        let at_once = points.len() >= 3;
        remarks.push(if at_once {
            "all runs have one time: date them with `diagnose --at`, or take their order with `--by run`".to_owned()
        } else {
            format!("a trend takes three runs, and there are {}", points.len())
        });
    }
    let bent = line.as_ref().and_then(|line| bend(&points, line)).filter(|ratio| ratio.abs() > BENT);
    if let Some(ratio) = bent {
        let towards = limit.is_some_and(|limit| (limit > healthy) == (ratio > 0.0));
        let how = if ratio > 0.0 { "upwards" } else { "downwards" };
        let when = if limit.is_none() {
            ""
        } else if towards {
            "; a straight line says too late"
        } else {
            "; a straight line says too early"
        };
        remarks.push(format!("the trend bends {how}, by {:.1} standard errors{when}", ratio.abs()));
    }
    FaultHistory {
        id,
        meaning,
        unit: unit.to_string(),
        healthy: values::short(healthy),
        limit: limit.map(values::short),
        values,
        line,
        trend: line.map(|line| Trend {
            slope: values::short(line.slope),
            per: by.step(),
            ci95: line.slope_interval().map(values::short),
            now: values::short(line.value(last)),
            now_ci95: [-1.0, 1.0].map(|side| values::short(line.value(last) + side * line.half_width(last))),
            scatter: values::short(line.scatter),
            runs: points.len(),
        }),
        forecast,
        remark: (!remarks.is_empty()).then(|| remarks.join("; ")),
    }
}
