//! Sensitivities: derivatives of the readings by parameters, led along a plain run.

use super::super::assembly::{Assembly, Inputs};
use super::super::drive::{Before, InputSignals};
use super::super::layout::Raw;
use super::super::slopes::{First, LANES, Slopes, seeded};
use super::super::start;
use super::{Model, Outputs, Sensitivities, SimulationError, Watch};
use crate::numeric::{Real, Step, Tangents};
use crate::physics::effect;

/// What goes along with a run to differentiate it.
struct Derivatives<'a, const N: usize> {
    model: &'a Model,
    drive: &'a InputSignals,
    /// Parameters asked for.
    by: &'a [usize],
    slopes: Option<Slopes<'a>>,
    tangents: Tangents<N>,
    /// States that sensors read, and their derivatives at one row, by state.
    read: Vec<usize>,
    states: Vec<Vec<f64>>,
    /// Derivatives of one raw reading.
    raw: Vec<f64>,
    /// `[parameter][sensor][row]`.
    values: Vec<Vec<Vec<f64>>>,
    readings: Vec<Vec<f64>>,
    /// All of the rig's, SI, as they are in force.
    parameters: Vec<f64>,
    /// Which of the parameters asked for each of the rig's is, where it is in force.
    columns: Vec<Option<usize>>,
}

impl Model {
    /// Sensitivities by parameters that share one integration.
    pub(super) fn group<const N: usize>(
        &self,
        parameters: &[f64],
        by: &[usize],
        drive: &InputSignals,
        times: &[f64],
    ) -> Result<Sensitivities, SimulationError> {
        let empty = vec![vec![0.0; times.len()]; self.rig.sensors.len()];
        let mut derivatives = Derivatives::<N> {
            model: self,
            drive,
            by,
            slopes: None,
            tangents: Tangents::new(0, [1.0; N], |_, _| 0.0),
            read: self.read_states(),
            states: vec![vec![0.0; by.len()]; self.layout.states],
            raw: vec![0.0; by.len()],
            values: vec![empty.clone(); by.len()],
            readings: empty,
            parameters: parameters.to_vec(),
            columns: Vec::new(),
        };
        let effort = self.run::<N>(parameters, drive, times, &mut derivatives)?;
        derivatives.read_by_effects(times);
        let Derivatives { values: derivatives, readings: values, .. } = derivatives;
        Ok(Sensitivities { outputs: Outputs { values, effort }, derivatives })
    }

    /// States that any sensor reads.
    fn read_states(&self) -> Vec<usize> {
        let layout = &self.layout;
        let sensors = layout.raw.iter().zip(&layout.filtered).zip(&layout.flows);
        let read = sensors.flat_map(|((raw, filtered), flows)| match (raw, filtered) {
            (_, Some(state)) | (Raw::Pressure(state) | Raw::Level(state) | Raw::State(state), None) => vec![*state],
            (Raw::Through(_), None) => {
                flows.iter().flat_map(|(component, _)| layout.slots[*component].states_seen()).collect()
            }
            (Raw::HeldPressure(_), None) => Vec::new(),
        });
        let mut read: Vec<usize> = read.collect();
        read.sort_unstable();
        read.dedup();
        read
    }
}

impl<const N: usize> Derivatives<'_, N> {
    /// From here on these are the parameters, those of `changed` as they were.
    fn set(&mut self, parameters: &[f64], changed: &[(usize, Before)]) {
        self.parameters = parameters.to_vec();
        self.columns = vec![None; parameters.len()];
        for (column, &parameter) in self.by.iter().enumerate() {
            self.columns[parameter] = Some(column);
        }
        for &(parameter, was) in changed {
            self.columns[parameter] = match was {
                Before::Value(_) => None,
                Before::Like(other) => self.columns[other],
            };
        }
        let (rig, layout) = (&self.model.rig, &self.model.layout);
        self.slopes = Some(Slopes::new(rig, layout, parameters, self.columns.clone()));
    }

    /// Derivatives of what the sensors read, from those of the states they read.
    fn read(&mut self, row: usize, t: f64, y: &[f64; N]) {
        let Some(slopes) = &mut self.slopes else { return };
        for (sensor, own) in self.model.rig.sensors.iter().enumerate() {
            self.raw.fill(0.0);
            slopes.raw(sensor, t, y, &self.states, &mut self.raw);
            let gain = self.parameters[own.first_parameter + 1];
            for (values, raw) in self.values.iter_mut().zip(&self.raw) {
                values[sensor][row] = raw * gain;
            }
        }
    }

    /// What effects do to the readings, and to their derivatives.
    fn read_by_effects(&mut self, times: &[f64]) {
        for does in &self.model.rig.readings {
            let (first, count) = (does.first_parameter, does.card.parameters.len());
            let plain = self.readings[does.sensor].clone();
            for (chunk, lanes) in self.values.chunks_mut(LANES).zip(self.by.chunks(LANES)) {
                let own = seeded(&self.parameters, lanes)[first..][..count].to_vec();
                let mut readings: Vec<First> = plain.iter().map(|&value| First::constant(value)).collect();
                for (lane, values) in chunk.iter().enumerate() {
                    for (reading, slope) in readings.iter_mut().zip(&values[does.sensor]) {
                        reading.eps[lane] = *slope;
                    }
                }
                effect::read(does.card, &own, self.drive.begun, times, &mut readings);
                for (lane, values) in chunk.iter_mut().enumerate() {
                    for (slope, reading) in values[does.sensor].iter_mut().zip(&readings) {
                        *slope = reading.eps[lane];
                    }
                }
            }
            let own = &self.parameters[first..][..count];
            effect::read(does.card, own, self.drive.begun, times, &mut self.readings[does.sensor]);
        }
    }
}

impl<const N: usize> Watch<N> for Derivatives<'_, N> {
    fn start(&mut self, parameters: &[f64], changed: &[(usize, Before)], inputs: &Inputs, t: f64) {
        self.set(parameters, changed);
        let model = self.model;
        let mut first = vec![vec![0.0; self.by.len()]; N];
        for (place, lanes) in self.by.chunks(LANES).enumerate() {
            let mut seeds = seeded(parameters, lanes);
            for &(parameter, was) in changed {
                seeds[parameter] = match was {
                    Before::Value(value) => First::constant(value),
                    Before::Like(other) => seeds[other],
                };
            }
            let mut assembly = Assembly::new(&model.rig, &model.layout, &seeds);
            assembly.inputs = inputs.clone();
            let mut y = [First::zero(); N];
            start::start(&model.rig, &model.layout, &mut assembly, &seeds, self.drive, t, &mut y);
            for (state, y) in first.iter_mut().zip(&y) {
                for (lane, slope) in state[place * LANES..].iter_mut().take(lanes.len()).enumerate() {
                    *slope = y.eps[lane];
                }
            }
        }
        let mut scale = [1.0; N];
        scale[..model.layout.states].copy_from_slice(&model.layout.scales);
        self.tangents = Tangents::new(self.by.len(), scale, |state, column| first[state][column]);
    }

    fn change(&mut self, parameters: &[f64]) {
        self.set(parameters, &[]);
    }

    fn piece(&mut self, inputs: &Inputs) {
        if let Some(slopes) = &mut self.slopes {
            slopes.inputs = inputs.clone();
        }
    }

    fn step(&mut self, step: &Step<'_, f64, N>) {
        if let Some(slopes) = &mut self.slopes {
            self.tangents.advance(slopes, step);
        }
    }

    fn at_rest(&mut self, row: usize, t: f64, y: &[f64; N]) {
        for &state in &self.read {
            for (slot, slope) in self.states[state].iter_mut().zip(self.tangents.state(state)) {
                *slot = slope;
            }
        }
        self.read(row, t, y);
    }

    fn sample(&mut self, step: &Step<'_, f64, N>, row: usize, t: f64, y: &[f64; N]) {
        self.tangents.interpolate(step, t, &self.read, &mut self.states);
        self.read(row, t, y);
    }

    fn reading(&mut self, row: usize, sensor: usize, raw: f64, shown: f64) {
        self.readings[sensor][row] = shown;
        let first = self.model.rig.sensors[sensor].first_parameter;
        for (parameter, slope) in [(first, 1.0), (first + 1, raw)] {
            if let Some(column) = self.columns[parameter] {
                self.values[column][sensor][row] += slope;
            }
        }
    }
}
