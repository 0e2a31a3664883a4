//! What happens in a case: how many faults, which, how large, from when on, under what load.

use super::disturb::Disturbed;
use super::random::{Purpose, Stream};
use crate::model::{self, InputSignals, Piece};
use crate::rig::{Cycle, Fault, Rig};

/// Of the faulty cases: how many have one, two and three faults.
const FAULTY: [f64; 3] = [0.38, 0.2, 0.1];
/// Measured loads are scaled by a factor between these.
const LOAD: (f64, f64) = (0.2, 1.0);
/// Phases last longer by a factor between these.
const DURATION: (f64, f64) = (0.85, 1.15);
/// Size of a fault, in shares of the way from the healthy value to a bound.
const SIZE: (f64, f64) = (0.05, 0.75);
/// A side that reaches less far than this share of the other is there for the fit to overshoot into; no fault goes there.
const SIDE: f64 = 1.0 / 3.0;
/// Share of the faulty cases in which the faults begin within the record, and where in it.
const MIDWAY: f64 = 0.2;
const ONSET: (f64, f64) = (0.1, 0.7);

/// How many faults each case has: exact counts in a random order.
pub fn plan(cases: usize, healthy: f64, faults: usize, seed: u64) -> Vec<usize> {
    let healthy = if faults == 0 { cases } else { ((cases as f64 * healthy).round() as usize).min(cases) };
    let faulty = cases - healthy;
    let share = |count: usize| (faulty as f64 * FAULTY[count] / FAULTY.iter().sum::<f64>()).round() as usize;
    let double = share(1).min(faulty);
    let triple = share(2).min(faulty - double);
    let mut counts = vec![0; healthy];
    for (count, of) in [(1, faulty - double - triple), (2, double), (3, triple)] {
        counts.resize(counts.len() + of, count);
    }
    counts.iter_mut().for_each(|count| *count = (*count).min(faults));
    Stream::of(seed, Purpose::Plan).shuffle(&mut counts);
    counts
}

/// Commands and loads of one run.
pub struct Run {
    cycle: Cycle,
    /// As the parts of the rig file follow their inputs.
    pub drive: InputSignals,
    /// Times of the rows, s.
    pub times: Vec<f64>,
    /// s.
    pub interval: f64,
}

impl Run {
    /// The rig's cycle with other loads and durations.
    pub fn draw(rig: &Rig, cycle: &Cycle, random: &mut Stream) -> Self {
        let factors: Vec<f64> = rig
            .inputs
            .iter()
            .map(|input| {
                let factor = random.uniform(LOAD.0, LOAD.1);
                if input.noise > 0.0 { factor } else { 1.0 }
            })
            .collect();
        let cycle = cycle.scaled(&factors, || random.uniform(DURATION.0, DURATION.1));
        Self {
            drive: InputSignals::from_cycle(rig, &cycle),
            times: model::cycle_times(rig, &cycle),
            interval: cycle.interval,
            cycle,
        }
    }

    /// The same as the parts of a rig follow their inputs.
    pub fn drive_of(&self, rig: &Rig) -> InputSignals {
        InputSignals::from_cycle(rig, &self.cycle)
    }

    /// When a command first leaves zero, s; the start where there is none. Before that, most faults cannot show.
    pub fn first_motion(&self, rig: &Rig) -> f64 {
        let commands = |piece: &&Piece| {
            let values = rig.inputs.iter().zip(piece.from.iter().zip(&piece.to));
            values.filter(|(input, _)| input.noise == 0.0).any(|(_, (from, to))| *from != 0.0 || *to != 0.0)
        };
        let first = self.drive.pieces.iter().find(commands).or_else(|| self.drive.pieces.first());
        first.map_or(0.0, |piece| piece.start)
    }
}

/// The faults of one case.
#[derive(Debug, Clone, PartialEq)]
pub struct Injected {
    /// Indices among the rig's faults, rising, with what the parameter has become, SI.
    pub faults: Vec<(usize, f64)>,
    /// When they began, s; `None` where they are as old as the record.
    pub onset: Option<f64>,
}

impl Injected {
    /// `count` faults of a disturbed rig over a run.
    pub fn draw(disturbed: &Disturbed, run: &Run, count: usize, random: &mut Stream) -> Self {
        let mut which: Vec<usize> = (0..disturbed.rig.faults.len()).collect();
        random.shuffle(&mut which);
        which.truncate(count);
        which.sort_unstable();
        let value = |&index: &usize| {
            let (fault, healthy) = (&disturbed.rig.faults[index], disturbed.healthy[index]);
            let (down, up) = sides(fault);
            let side = random.uniform(0.0, 1.0);
            let share = random.uniform(SIZE.0, SIZE.1);
            let reach = if down && (!up || side < 0.5) { fault.bounds.0 } else { fault.bounds.1 } - fault.healthy;
            (index, healthy + share * reach)
        };
        let faults: Vec<(usize, f64)> = which.iter().map(value).collect();
        let (midway, place) = (random.uniform(0.0, 1.0) < MIDWAY, random.uniform(ONSET.0, ONSET.1));
        let (first, last) = (run.times.first().unwrap_or(&0.0), run.times.last().unwrap_or(&0.0));
        let onset = (midway && count > 0).then(|| first + place * (last - first));
        Self { faults, onset }
    }

    /// The parameters of a disturbed rig with the faults, SI.
    pub fn parameters(&self, disturbed: &Disturbed) -> Vec<f64> {
        let mut parameters = disturbed.rig.nominal();
        for &(index, value) in &self.faults {
            parameters[disturbed.rig.faults[index].parameter] = value;
        }
        parameters
    }

    /// The drive of a rig in a run, with the healthy values of its faults (SI) before these began.
    pub fn drive(&self, rig: &Rig, healthy: &[f64], run: &Run) -> InputSignals {
        let Some(time) = self.onset else { return run.drive_of(rig) };
        let before = |&(index, _): &(usize, f64)| (rig.faults[index].parameter, model::Before::Value(healthy[index]));
        run.drive_of(rig).with_onset(model::Onset { time, before: self.faults.iter().map(before).collect() })
    }
}

/// Whether a fault goes down, and up.
fn sides(fault: &Fault) -> (bool, bool) {
    let (down, up) = (fault.healthy - fault.bounds.0, fault.bounds.1 - fault.healthy);
    (down >= SIDE * up, up >= SIDE * down)
}
