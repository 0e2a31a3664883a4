//! The residuals over a record that comes piece by piece: sums, gates and windows go on from one piece to the next, so that
//! an alarm does not depend on where the record is cut.

use rayon::prelude::*;

use super::cusum::{Direction, Running};
use super::detect::{Detection, phase, phases};
use super::ensemble::Ensemble;
use super::frame::{self, Cursor, Frame, Prepared};
use super::generator::{Gate, Generator, PortVariables};
use super::known::Known;
use super::reading::Source;
use crate::complaint::Complaint;
use crate::model::{InputSignals, Late};
use crate::record::Record;
use crate::rig::Rig;

/// Windows that are kept behind the last one that was laid, and before the end of what has come: a jump of a noisy input is
/// recognised by the rows around it.
const AROUND: f64 = 4.0;
/// Rows that are kept at least.
const ROWS: usize = 16;

/// A sum that crossed its threshold; it starts anew behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fired {
    /// Id of the residual.
    pub id: String,
    /// End of the window of the alarm, s.
    pub at_s: f64,
    /// When the residual began to leave zero, s, as in [`super::ResidualReport`].
    pub onset_s: f64,
    pub direction: Direction,
    /// What the first directional valve did; `all` in a rig without one.
    pub phase: &'static str,
}

/// A window that has passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Its end, s.
    pub at_s: f64,
    /// Values of residuals in it that count.
    pub values: usize,
}

/// Tests the residuals of one rig on one record, piece by piece.
pub struct Monitor<'a> {
    rig: &'a Rig,
    detection: Detection,
    sources: Vec<Source>,
    watches: Vec<Watch>,
    /// Rows that may still be needed.
    rows: Option<Record>,
    cursor: Cursor,
    /// Usual interval between rows, s, and threshold, once there are rows.
    clock: Option<(f64, f64)>,
}

/// One residual and where its sums stand.
struct Watch {
    generator: Generator,
    known: Known,
    own: Vec<usize>,
    before: Option<PortVariables>,
    /// Start of the windows just before that do not count because something moved, s, and their phase.
    moved: Option<(f64, &'static str)>,
    sums: Vec<Running<f64>>,
}

impl<'a> Monitor<'a> {
    pub fn new(rig: &'a Rig, detection: Detection) -> Self {
        let ensemble = Ensemble::of(rig);
        let watch = |(generator, own): (Generator, Vec<usize>)| Watch {
            known: generator.known(rig),
            generator,
            own,
            before: None,
            moved: None,
            sums: vec![Running::default(); phases(rig).len()],
        };
        Self {
            rig,
            detection,
            sources: ensemble.sources,
            watches: ensemble.members.into_iter().map(watch).collect(),
            rows: None,
            cursor: Cursor::default(),
            clock: None,
        }
    }

    /// Number of residuals that are tested.
    pub fn residuals(&self) -> usize {
        self.watches.len()
    }

    /// Takes the next rows, `last` if no others follow: the windows that have passed and the alarms in them, by time.
    ///
    /// # Errors
    /// A column that the record lacks or has in another dimension; a record of fewer than two rows.
    pub fn take(&mut self, piece: Record, last: bool) -> Result<(Vec<Block>, Vec<Fired>), Complaint> {
        let rows = match self.rows.take() {
            Some(mut rows) => {
                rows.append(piece);
                rows
            }
            None => piece,
        };
        if rows.time.len() < ROWS && !last {
            self.rows = Some(rows);
            return Ok(Default::default());
        }
        let drive = InputSignals::inputs(self.rig, &rows, Late::default())?;
        let (interval, threshold) = self.clock(&rows);
        let data = frame::channels(self.rig, &rows, &self.sources)?;
        let prepared = Prepared::over(self.rig, &rows, data, &drive, (self.detection.window, interval));
        let margin = frame::settling(self.rig) + AROUND * self.detection.window.max(ROWS as f64 * interval);
        let until = if last { f64::INFINITY } else { rows.time.last().map_or(0.0, |time| time - margin) };
        let frames = prepared.lay(self.rig, &self.sources, &mut self.cursor, until);
        let (rig, detection) = (self.rig, &self.detection);
        let tested = |watch: &mut Watch| watch.test(rig, &drive, &frames, detection, threshold);
        let tested: Vec<(Vec<bool>, Vec<Fired>)> = self.watches.par_iter_mut().map(tested).collect();
        let counted = |at: usize| tested.iter().filter(|(counts, _)| counts[at]).count();
        let blocks = frames.iter().enumerate().map(|(at, frame)| Block { at_s: frame.to, values: counted(at) });
        let blocks = blocks.collect();
        let mut fired: Vec<Fired> = tested.into_iter().flat_map(|(_, fired)| fired).collect();
        fired.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        self.rows = Some(self.kept(rows, margin));
        Ok((blocks, fired))
    }

    /// Interval between rows, s, and threshold: those of the first rows.
    fn clock(&mut self, rows: &Record) -> (f64, f64) {
        *self.clock.get_or_insert_with(|| {
            let interval = frame::interval(rows);
            let window = frame::block_rows(self.detection.window, interval) as f64 * interval;
            (interval, self.detection.threshold(self.watches.len(), window))
        })
    }

    /// The rows from `margin` s before the next window on.
    fn kept(&mut self, mut rows: Record, margin: f64) -> Record {
        let next = self.cursor.row;
        let Some(time) = rows.time.get(next).or(rows.time.last()) else { return rows };
        let from = rows.time.partition_point(|&t| t < time - margin).min(next.saturating_sub(ROWS));
        for input in &self.rig.inputs {
            let Some(channel) = rows.channels.iter_mut().find(|channel| channel.name == input.column) else { continue };
            // What the input last was holds on where the row that is first now says nothing.
            if let Some(held) = channel.values[..=from].iter().rfind(|value| !value.is_nan()) {
                channel.values[from] = *held;
            }
        }
        rows.forget(from);
        self.cursor.row -= from;
        rows
    }
}

impl Watch {
    /// Which windows count, and the alarms in them.
    fn test(
        &mut self,
        rig: &Rig,
        drive: &InputSignals,
        frames: &[Frame],
        detection: &Detection,
        threshold: f64,
    ) -> (Vec<bool>, Vec<Fired>) {
        let series = self.generator.counting(rig, &self.known, frames, &self.own, &mut self.before);
        let mut fired = Vec::new();
        for at in 0..frames.len() {
            let name = phase(rig, drive, series.time[at]);
            let since = self.moved.filter(|(_, phase)| *phase == name).map_or(series.start[at], |(start, _)| start);
            let gate = series.gate[at];
            self.moved = matches!(gate, Gate::Unsteady | Gate::InitialGuess).then_some((since, name));
            let Some(sums) = phases(rig).iter().position(|phase| *phase == name).filter(|_| gate == Gate::Open) else {
                continue;
            };
            let sigma = series.sigma[at];
            let (value, allowance) = (series.value[at] / sigma, detection.coverage * series.tolerance[at] / sigma);
            let limits = (detection.reference(), threshold);
            if let Some((direction, onset_s)) = self.sums[sums].step(value, allowance, limits, since) {
                let (id, at_s) = (self.generator.id.clone(), series.time[at]);
                fired.push(Fired { id, at_s, onset_s, direction, phase: name });
                self.sums[sums] = Running::default();
            }
        }
        (series.gate.iter().map(|gate| *gate == Gate::Open).collect(), fired)
    }
}
