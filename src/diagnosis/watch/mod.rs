//! Long records, window by window: the residuals watch all of it, and what they fire at is diagnosed.

mod begin;
mod episodes;
mod result;

use std::collections::VecDeque;
use std::path::Path;

use super::doubtful::set_aside;
use super::{Diagnosis, DiagnosisOptions, diagnose_from};
use crate::complaint::{Complaint, Kind, Place};
use crate::model::Model;
use crate::number::rounded;
use crate::record::{Record, Stream, Window, Windows};
use crate::residual::{Block, Fired, Monitor};
use episodes::Episodes;
use result::SCHEMA;
pub use result::{Episode, Sample, Watched, WatchedVerdict, WindowReport};

/// Windows of which the rows are kept: that of an alarm, the one behind it, and the one whose end is not yet judged.
const KEPT: usize = 3;

/// How a record is watched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watching {
    /// Length of a window, s.
    pub window: f64,
    /// Most windows that are diagnosed.
    pub fits: usize,
}

impl Model {
    /// Watches a long record, which is read piece by piece from a CSV file, packed or not; `-` is the standard input.
    ///
    /// # Errors
    /// Those of [`Record::read`]; a rig without residuals; columns that are missing; a context that was cancelled.
    pub fn watch(
        &self,
        path: impl AsRef<Path>,
        watching: Watching,
        options: &DiagnosisOptions,
    ) -> Result<Watched, Complaint> {
        let asked = self.rig.asked();
        let stream = Stream::open(path.as_ref(), &asked)?;
        self.rig.context().run(|| watch_windows(self, stream, watching, options))
    }
}

fn watch_windows(
    model: &Model,
    stream: Stream<'_>,
    watching: Watching,
    options: &DiagnosisOptions,
) -> Result<Watched, Complaint> {
    let rig = &model.rig;
    let mut monitor = Monitor::new(rig, options.detection);
    if monitor.residuals() == 0 {
        return Err(Complaint::new(
            Kind::MissingEntry,
            "the sensors of this rig allow no residuals, which watch the windows",
        )
        .at(Place::file(&rig.path))
        .help("diagnose records whole, without `--window`; `borescope isolability` shows which sensors are missing"));
    }
    let mut windows = Windows::new(stream, watching.window);
    let mut watch = Watch::new(model, watching, options);
    let mut next = windows.next_window()?;
    while let Some(window) = next {
        rig.context().check()?;
        let window = Window { record: rig.scaled(window.record), ..window };
        rig.context().stage("windows");
        let piece = window.record.clone();
        let (read, tested) = rayon::join(|| windows.next_window(), || monitor.take(piece, window.last));
        next = read?;
        let (blocks, fired) = tested?;
        watch.take(window, &blocks, fired);
    }
    Ok(watch.result(windows.read_as()?))
}

struct Watch<'a> {
    model: &'a Model,
    watching: Watching,
    options: &'a DiagnosisOptions,
    record: String,
    start: f64,
    end: f64,
    /// Reports of the windows, with their numbers.
    reports: Vec<(usize, WindowReport)>,
    kept: VecDeque<Window>,
    episodes: Episodes,
    /// Windows that were diagnosed.
    diagnosed: Vec<usize>,
}

impl<'a> Watch<'a> {
    fn new(model: &'a Model, watching: Watching, options: &'a DiagnosisOptions) -> Self {
        Self {
            model,
            watching,
            options,
            record: String::new(),
            start: 0.0,
            end: 0.0,
            reports: Vec::new(),
            kept: VecDeque::new(),
            episodes: Episodes::new(watching.window),
            diagnosed: Vec::new(),
        }
    }

    fn take(&mut self, window: Window, blocks: &[Block], fired: Vec<Fired>) {
        let (Some(&first), Some(&last)) = (window.record.time.first(), window.record.time.last()) else { return };
        if self.reports.is_empty() {
            (self.start, self.record) = (first, window.record.path.display().to_string());
        }
        self.end = last;
        let (from_s, to_s, rows) = (rounded(window.from_s, 12), rounded(window.to_s, 12), window.record.time.len());
        self.reports.push((window.number, WindowReport { from_s, to_s, rows, values: 0, alarms: 0 }));
        for block in blocks {
            let number = self.number(block.at_s);
            if let Some(report) = self.report(number) {
                report.values += block.values;
            }
        }
        for fired in fired {
            let (number, onset) = (self.number(fired.at_s), self.number(fired.onset_s));
            if let Some(report) = self.report(number) {
                report.alarms += 1;
            }
            self.episodes.take(fired, number, onset);
        }
        let judged = if window.last { usize::MAX } else { window.number.saturating_sub(1) };
        self.kept.push_back(window);
        if self.kept.len() > KEPT {
            self.kept.pop_front();
        }
        self.settle(judged);
    }

    /// Number of the window that a time, s, lies in.
    fn number(&self, time: f64) -> usize {
        crate::record::window_at(self.start, self.watching.window, time)
    }

    fn report(&mut self, number: usize) -> Option<&mut WindowReport> {
        self.reports.iter_mut().rev().find(|(own, _)| *own == number).map(|(_, report)| report)
    }

    /// Diagnoses what can be, now that all alarms up to the end of window `judged` are known.
    fn settle(&mut self, judged: usize) {
        for running in &mut self.episodes.all {
            let Some(number) = running.window(judged) else { continue };
            running.settled = true;
            let outcome = if self.diagnosed.contains(&number) {
                Err("its window was diagnosed with an episode before".to_owned())
            } else if self.diagnosed.len() >= self.watching.fits {
                Err(format!("`--fits {}` allows no more windows to be diagnosed", self.watching.fits))
            } else {
                self.diagnosed.push(number);
                let window = self.kept.iter().find(|window| window.number == number);
                window.map_or_else(
                    || Err("the window has no rows".to_owned()),
                    |window| diagnosed(self.model, window, self.start, self.options),
                )
            };
            match outcome {
                Ok((span, diagnosis)) => {
                    running.episode.diagnosed_s = Some(span);
                    running.episode.diagnosis = Some(diagnosis);
                }
                Err(why) => running.episode.not_diagnosed = Some(why),
            }
        }
    }

    /// The last whole window diagnosed, where nothing fired in any.
    fn sample(&self) -> Option<Sample> {
        if !self.episodes.all.is_empty() || self.watching.fits == 0 {
            return None;
        }
        let length = |window: &&Window| span(&window.record)[1] - span(&window.record)[0];
        let whole = self.kept.iter().rev().reduce(|late, early| {
            // A last window that the record cuts short shows less.
            if length(&late) < 0.9 * length(&early) { early } else { late }
        })?;
        let (diagnosed_s, diagnosis) = diagnosed(self.model, whole, self.start, self.options).ok()?;
        Some(Sample { diagnosed_s, diagnosis })
    }

    fn result(self, read_as: String) -> Watched {
        let sample = self.sample();
        let episodes: Vec<Episode> = self.episodes.all.into_iter().map(|running| running.episode).collect();
        let windows: Vec<WindowReport> = self.reports.into_iter().map(|(_, report)| report).collect();
        Watched {
            schema: SCHEMA,
            rig: self.model.rig.path.display().to_string(),
            record: self.record,
            read_as,
            conclusion: WatchedVerdict::of(&episodes, sample.as_ref()),
            rows: windows.iter().map(|window| window.rows).sum(),
            from_s: self.start,
            to_s: self.end,
            window_s: self.watching.window,
            fits: self.watching.fits,
            episodes,
            sample,
            windows,
        }
    }
}

/// The diagnosis of a window of a record that starts at `start`, s, and the stretch that it is of; or why there is none.
fn diagnosed(
    model: &Model,
    window: &Window,
    start: f64,
    options: &DiagnosisOptions,
) -> Result<([f64; 2], Diagnosis), String> {
    // A dead sensor stands still, and shows nothing of where the circuit is.
    let (cleared, _) = set_aside(&model.rig, &window.record);
    let cleared = cleared.as_ref().unwrap_or(&window.record);
    let begun = if window.number == 0 && !model.rig.begins_within_a_run(cleared) {
        Some((window.record.clone(), Vec::new()))
    } else {
        let begun = begin::begin(&model.rig, cleared, options).map_err(|complaint| complaint.what)?;
        begun.map(|(rows, shown)| {
            let mut record = window.record.clone();
            record.forget(rows);
            (record, shown)
        })
    };
    let Some((record, shown)) = begun else {
        return Err(
            "nothing in the first half of its window is constant or changes linearly, so the model cannot be started"
                .to_owned(),
        );
    };
    let span = span(&record);
    let diagnosed =
        diagnose_from(model, &record, (&shown, Some(start)), options).map_err(|complaint| complaint.what)?;
    Ok((span, diagnosed.diagnosis))
}

fn span(record: &Record) -> [f64; 2] {
    [record.time.first(), record.time.last()].map(|time| time.copied().unwrap_or_default())
}
