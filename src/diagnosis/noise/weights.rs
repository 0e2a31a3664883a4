//! Weights of the misfits, from the variance of each sample and what samples have in common.

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::directions::Directions;
use super::phases;
use crate::estimation::Shared;
use crate::model::InputSignals;
use crate::numeric::dot;
use crate::rig::Rig;
use crate::settings::DiagnosisSettings;

/// Columns that are weighed one after the other, phase by phase: enough that what a phase shares is fetched for many, few enough that
/// threads have their share.
const TOGETHER: usize = 8;

/// Weights of the misfits: what makes them independent and of variance 1 if the model is right within its tolerance.
#[derive(Debug, Clone)]
pub struct Weights {
    rows: usize,
    /// `1/sigma` of each sample, `[sensor][row]`; 0 of those that the record does not have.
    inverse: Vec<Vec<f64>>,
    phases: Vec<Phase>,
    /// What all weighted samples have in common, taken away behind what phases take.
    throughout: Directions,
    /// What the samples of each sensor may have in common.
    pub shared: Vec<Shared>,
    /// Whether what is asked of events can be judged.
    events_are_judged: bool,
}

#[derive(Debug, Clone)]
struct Phase {
    rows: Range<usize>,
    /// Per sensor: what constant and slope do, over the phase's samples.
    levels: Vec<Directions>,
    /// What events do, over the phase's samples of all sensors, one sensor after the other.
    events: Directions,
}

impl Weights {
    /// From the variance of each sample (`[sensor][row]`) and the changes of all readings by one standard deviation of each
    /// time constant (`[constant][sensor][row]`), all SI.
    pub fn new(rig: &Rig, phases: &[Range<usize>], variance: &[Vec<f64>], changes: &[Vec<Vec<f64>>]) -> Self {
        let mut weights = Self {
            rows: variance.first().map_or(0, Vec::len),
            inverse: variance.iter().map(|row| row.iter().map(|variance| 1.0 / variance.sqrt()).collect()).collect(),
            phases: Vec::new(),
            throughout: Directions::default(),
            shared: Vec::new(),
            events_are_judged: true,
        };
        for rows in phases {
            let levels = rig.sensors.iter().zip(&weights.inverse);
            let levels = levels.map(|(sensor, inverse)| level_directions(sensor.tolerance, &inverse[rows.clone()]));
            let levels = levels.collect();
            weights.phases.push(Phase { rows: rows.clone(), levels, events: Directions::default() });
        }
        let weighted: Vec<Vec<f64>> = changes
            .iter()
            .map(|change| {
                let mut column: Vec<f64> = change.iter().flatten().copied().collect();
                weights.scale(&mut column);
                weights.level(&mut column);
                column
            })
            .collect();
        let (rows, sensors) = (weights.rows, weights.inverse.len());
        for phase in &mut weights.phases {
            let pick = |column: &Vec<f64>| -> Vec<f64> {
                (0..sensors).flat_map(|sensor| column[sensor * rows..][phase.rows.clone()].iter().copied()).collect()
            };
            phase.events = Directions::of(&weighted.iter().map(pick).collect::<Vec<_>>());
        }
        weights.shared = weights.shared_by_sensor();
        weights
    }

    /// These, and a direction over the whole record for each thing that is the same throughout: what it changes, off by one standard deviation,
    /// `[what][sensor][row]`, SI.
    #[must_use]
    pub fn with_throughout(mut self, changes: &[Vec<Vec<f64>>]) -> Self {
        let weighted = |change: &Vec<Vec<f64>>| {
            let mut column = change.concat();
            self.apply(&mut column);
            column
        };
        self.throughout = Directions::of(&changes.iter().map(weighted).collect::<Vec<_>>());
        self.shared = self.shared_by_sensor();
        self
    }

    /// Those of so many first rows, up to the end of the phase in which the last of them lies, and how many rows that is.
    pub(crate) fn of_first_phases(&self, rows: usize) -> (usize, Self) {
        let last = self.phases.iter().find(|phase| phase.rows.end >= rows);
        let rows = last.map_or(rows, |phase| phase.rows.end).min(self.rows);
        let mut first = Self {
            rows,
            inverse: self.inverse.iter().map(|inverse| inverse[..rows].to_vec()).collect(),
            phases: self.phases.iter().filter(|phase| phase.rows.end <= rows).cloned().collect(),
            throughout: self.throughout_in(rows),
            shared: Vec::new(),
            events_are_judged: self.events_are_judged,
        };
        first.shared = first.shared_by_sensor();
        (rows, first)
    }

    /// What so many first rows have in common of what all have.
    fn throughout_in(&self, rows: usize) -> Directions {
        let part =
            |effect: Vec<f64>| effect.chunks_exact(self.rows.max(1)).flat_map(|part| part[..rows].to_vec()).collect();
        Directions::of(&self.throughout.effects().map(part).collect::<Vec<Vec<f64>>>())
    }

    /// From the variance of each sample alone, with phases between the events that it shows.
    pub fn without_changes(rig: &Rig, drive: &InputSignals, times: &[f64], variance: &[Vec<f64>]) -> Self {
        Self::new(rig, &phases(rig, drive, times, variance), variance, &[])
    }

    /// The same where [`super::are_events_straight`] tells whether what is asked of events can be judged.
    #[must_use]
    pub fn judging_events(self, events_are_judged: bool) -> Self {
        Self { events_are_judged, ..self }
    }

    /// Misfits in SI, or a derivative of them, one sensor after the other, into independent ones of variance 1. Entries
    /// beyond the samples are left.
    pub fn apply(&self, column: &mut [f64]) {
        self.scale(column);
        self.level(column);
        self.take_events(&mut [&mut *column]);
        self.take_throughout(column);
    }

    /// The same to each column of a matrix.
    pub fn apply_to_columns(&self, matrix: &mut DMatrix<f64>) {
        let rows = matrix.nrows().max(1);
        matrix.as_mut_slice().par_chunks_mut(TOGETHER * rows).for_each(|some| {
            let mut columns: Vec<&mut [f64]> = some.chunks_exact_mut(rows).collect();
            for column in &mut columns {
                self.scale(column);
                self.level(column);
            }
            self.take_events(&mut columns);
            columns.iter_mut().for_each(|column| self.take_throughout(column));
        });
    }

    /// Takes what is the same throughout.
    fn take_throughout(&self, column: &mut [f64]) {
        self.throughout.take_from(&mut column[..self.rows * self.sensors()]);
    }

    /// Takes from each phase what events can explain. The directions of a phase stay in the cache for all columns.
    fn take_events(&self, columns: &mut [&mut [f64]]) {
        let mut together = Vec::new();
        for phase in self.phases.iter().filter(|phase| !phase.events.is_empty()) {
            for column in &mut *columns {
                together.clear();
                for part in column.chunks_exact(self.rows).take(self.sensors()) {
                    together.extend_from_slice(&part[phase.rows.clone()]);
                }
                phase.events.take_from(&mut together);
                for (part, own) in column.chunks_exact_mut(self.rows).zip(together.chunks_exact(phase.rows.len())) {
                    part[phase.rows.clone()].copy_from_slice(own);
                }
            }
        }
    }

    /// Of weighted misfits: takes once more what samples of a phase, or of the record, have in common, so that what is left is their own.
    /// With weights `W = S D^(-1/2)`, this is `S'`.
    pub fn leave_own(&self, column: &mut [f64]) {
        self.take_throughout(column);
        self.take_events(&mut [&mut *column]);
        self.level(column);
    }

    fn shared_by_sensor(&self) -> Vec<Shared> {
        let share = |taken: f64| 1.0 - (1.0 - taken).powi(2);
        let mut shared = vec![Shared::default(); self.sensors()];
        for phase in &self.phases {
            for (shared, levels) in shared.iter_mut().zip(&phase.levels) {
                levels.iter().for_each(|(_, taken)| shared.add(share(taken), 1.0));
            }
        }
        let of_phases = self.phases.iter().map(|phase| (phase.rows.len(), &phase.events));
        for (rows, directions) in of_phases.chain([(self.rows, &self.throughout)]) {
            for (direction, taken) in directions.iter() {
                for (shared, part) in shared.iter_mut().zip(direction.chunks_exact(rows.max(1))) {
                    shared.add(share(taken), dot(part, part));
                }
            }
        }
        shared
    }

    /// By how much the weighted misfits differ where the sensors read `with` and not `plain`, `[sensor][row]`, SI.
    pub(crate) fn change(&self, with: &[Vec<f64>], plain: &[Vec<f64>]) -> Vec<f64> {
        let pairs = with.iter().flatten().zip(plain.iter().flatten());
        let mut change: Vec<f64> = pairs.map(|(with, plain)| with - plain).collect();
        self.apply(&mut change);
        change
    }

    /// What weighted misfits ask of the events at each sensor: the mean square over the ways in which phases may differ by events, in
    /// what each may differ by, and how many independent ones that is. A way counts at a sensor by the share that it has there; those
    /// that no sensor tells from noise are left out. What a part has otherwise than stated, it has so in all phases, so no more are
    /// independent than one phase has. Nothing where events cannot be judged, or are few.
    pub(crate) fn asked_of_events(&self, settings: &DiagnosisSettings, weighted: &[f64]) -> Vec<(f64, f64)> {
        /// `1 - 1/sqrt(1 + size²)` of a way as large as noise.
        const TOLD: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
        let mut asked = vec![(0.0, 0.0); self.inverse.len()];
        if !self.events_are_judged {
            return asked;
        }
        let mut most = 0;
        for phase in &self.phases {
            let length = phase.rows.len().max(1);
            let told = phase.events.iter().filter(|(_, taken)| *taken >= TOLD);
            most = most.max(told.clone().count());
            for (direction, _) in told {
                let of_sensor = |sensor: usize| &weighted[sensor * self.rows..][phase.rows.clone()];
                let parts = || direction.chunks_exact(length).enumerate();
                let along: f64 = parts().map(|(sensor, part)| dot(part, of_sensor(sensor))).sum();
                for (sensor, part) in parts() {
                    let share = dot(part, part);
                    asked[sensor].0 += share * along.abs().min(settings.event_outlier_misfit).powi(2);
                    asked[sensor].1 += share;
                }
            }
        }
        // Shares of whole ways add up to their number but for rounding.
        let are_few = |ways: f64| ways * (1.0 + 1e-9) < settings.event_directions;
        let mean = |(sum, ways): (f64, f64)| {
            if are_few(ways) { (0.0, 0.0) } else { (sum / ways, ways.min(most as f64)) }
        };
        asked.into_iter().map(mean).collect()
    }

    /// Logarithm of the determinant of what [`Self::apply`] does to the samples that are there, SI: what a likelihood under these
    /// weights has beside its cost. The more they allow, the less it is.
    pub(crate) fn log_determinant(&self) -> f64 {
        let samples = self.inverse.iter().flatten().filter(|weight| **weight > 0.0).map(|weight| weight.ln());
        let of_phases = self.phases.iter().flat_map(|phase| phase.levels.iter().chain([&phase.events]));
        let taken = of_phases.chain([&self.throughout]).flat_map(Directions::iter).map(|(_, taken)| taken);
        samples.sum::<f64>() + taken.map(|taken| (-taken).ln_1p()).sum::<f64>()
    }

    /// Mean square of misfits of a sensor, SI, each by the share at which it counts: where a curve is steep, a small shift in time is a large
    /// error, and a sample counts for little. `None` where none counts.
    pub(crate) fn mean_square(&self, sensor: usize, misfit: impl Iterator<Item = f64>) -> Option<f64> {
        let (mut squares, mut all) = (0.0, 0.0);
        for (weight, misfit) in self.inverse.get(sensor)?.iter().zip(misfit).filter(|(weight, _)| **weight > 0.0) {
            squares += (weight * misfit).powi(2);
            all += weight * weight;
        }
        (all > 0.0).then(|| squares / all)
    }

    /// How many samples of a sensor the record has.
    pub fn samples(&self, sensor: usize) -> usize {
        self.inverse.get(sensor).map_or(0, |inverse| inverse.iter().filter(|weight| **weight > 0.0).count())
    }

    /// The rows of each phase.
    pub fn phases(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.phases.iter().map(|phase| phase.rows.clone())
    }

    /// How many rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many sensors.
    pub fn sensors(&self) -> usize {
        self.inverse.len()
    }

    /// How many samples the record has.
    pub fn all_samples(&self) -> usize {
        (0..self.inverse.len()).map(|sensor| self.samples(sensor)).sum()
    }

    /// The same for samples on their own, without what those of a phase have in common: misfits stay in their rows.
    pub fn scale(&self, column: &mut [f64]) {
        for (slot, weight) in column.iter_mut().zip(self.inverse.iter().flatten()) {
            // Of a sample that is not there, no number says anything.
            *slot = if *weight > 0.0 { *slot * weight } else { 0.0 };
        }
    }

    /// Takes from each phase of each sensor what a shared constant and slope can explain.
    fn level(&self, column: &mut [f64]) {
        for phase in &self.phases {
            for (sensor, levels) in phase.levels.iter().enumerate() {
                levels.take_from(&mut column[sensor * self.rows..][phase.rows.clone()]);
            }
        }
    }
}

/// Directions of a constant and of a slope, one standard deviation of each, over weighted samples.
fn level_directions(tolerance: f64, weights: &[f64]) -> Directions {
    if tolerance == 0.0 {
        return Directions::default();
    }
    let last = (weights.len().max(2) - 1) as f64;
    let constant: Vec<f64> = weights.iter().map(|weight| weight * tolerance).collect();
    // Straight from -sqrt(3) to sqrt(3): a mean square of 1 over the phase, as the constant has.
    let slope = constant.iter().enumerate().map(|(row, size)| size * 3.0_f64.sqrt() * (2.0 * row as f64 / last - 1.0));
    let slope: Vec<f64> = slope.collect();
    Directions::of(&[constant, slope])
}
