//! The cycle of a rig, simulated into the record that its logger would write.

use borescope::Quantity;
use borescope::Record;
use borescope::internals::model::{Before, InputSignals, Model, Onset, cycle_times, input_columns, recording};
use borescope::internals::rig::Cycle;

/// The rig's own cycle, all parameters nominal, with the noise of seed 1, until said otherwise.
pub struct Run<'a> {
    model: &'a Model,
    cycle: Cycle,
    times: Option<Vec<f64>>,
    /// Changed parameters by index, SI.
    changed: Vec<(usize, f64)>,
    onset: Option<f64>,
    seed: u64,
}

impl<'a> Run<'a> {
    pub fn of(model: &'a Model) -> Self {
        let cycle = model.rig.cycle.clone().expect("the rig has a cycle");
        Self { model, cycle, times: None, changed: Vec::new(), onset: None, seed: 1 }
    }

    /// Parameters by id with their values, SI.
    pub fn with(mut self, set: &[(&str, f64)]) -> Self {
        let index = |id: &str| self.model.rig.parameter(id).unwrap_or_else(|| panic!("the rig has no {id}"));
        self.changed.extend(set.iter().map(|(id, value)| (index(id), *value)));
        self
    }

    /// Parameters by id with their values as a rig file writes them: `0.2 mm`.
    pub fn with_quantities(self, set: &[(&str, &str)]) -> Self {
        let set: Vec<_> = set.iter().map(|(id, text)| (*id, Quantity::parse(text).unwrap().value)).collect();
        self.with(&set)
    }

    /// The changed parameters are nominal until `time`, s.
    pub fn since(mut self, time: f64) -> Self {
        self.onset = Some(time);
        self
    }

    /// Another cycle than the rig's.
    pub fn through(mut self, cycle: Cycle) -> Self {
        self.cycle = cycle;
        self
    }

    /// Times of the rows, s, instead of those of the cycle's interval.
    pub fn at(mut self, times: Vec<f64>) -> Self {
        self.times = Some(times);
        self
    }

    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Commands and loads of the cycle, without any onset: what a diagnosis may know.
    pub fn drive(&self) -> InputSignals {
        InputSignals::from_cycle(&self.model.rig, &self.cycle)
    }

    /// The record, with the noise of the seed.
    pub fn record(self, name: &str) -> Record {
        let rig = &self.model.rig;
        let nominal = rig.nominal();
        let mut parameters = nominal.clone();
        for &(index, value) in &self.changed {
            parameters[index] = value;
        }
        let drive = self.drive();
        let begins = self.onset.map(|time| {
            let before = self.changed.iter().map(|&(index, _)| (index, Before::Value(nominal[index]))).collect();
            drive.clone().with_onset(Onset { time, before })
        });
        let times = self.times.unwrap_or_else(|| cycle_times(rig, &self.cycle));
        let outputs = self.model.solve(&parameters, begins.as_ref().unwrap_or(&drive), &times).unwrap();
        let inputs = input_columns(rig, &drive, &times);
        recording(rig, name, times, inputs, &outputs, Some(self.seed))
    }
}
