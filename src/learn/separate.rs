//! The experiment that tells two explanations of a record apart.

use rayon::prelude::*;

use super::fitted_model::FittedModel;
use super::refit::{PreliminaryModel, quick};
use crate::complaint::{Complaint, Kind};
use crate::diagnosis::search::ROUGH;
use crate::model::{self, InputSignals, Model, SimulationError};
use crate::record::Record;
use crate::rig::{Cycle, Rig};

/// Shares of the inputs of the rig's cycle that are tried: of measured loads, or of all inputs where none is measured.
const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 1.0, 1.5];
/// The same of the lengths of its phases.
const LENGTHS: [f64; 2] = [1.0, 0.5];

/// A run of the rig's cycle, changed, that two explanations predict differently.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Experiment {
    /// The two explanations.
    pub between: [String; 2],
    /// Inputs that are scaled.
    pub inputs: Vec<String>,
    /// Share of what the cycle of the rig file has for them.
    pub share: f64,
    /// Share of the lengths of its phases.
    pub length: f64,
    /// How far apart the two are then, in standard deviations: the root of the chi-square that the second leaves of an exact
    /// record of the first, everything uncertain and all faults fitted anew.
    pub sigma: f64,
}

/// The change of the rig's cycle under which the second explanation can follow the first least; `None` for a rig without a
/// cycle, or where none can be run.
pub fn separating(names: [String; 2], first: &FittedModel, second: &FittedModel) -> Option<Experiment> {
    let rig = &first.rig;
    let cycle = rig.cycle.as_ref()?;
    let loads: Vec<bool> = rig.inputs.iter().map(|input| input.noise > 0.0).collect();
    let scaled: Vec<bool> = loads.iter().map(|load| *load || !loads.contains(&true)).collect();
    let menu: Vec<(f64, f64)> = LENGTHS.iter().flat_map(|&length| SHARES.map(|share| (share, length))).collect();
    let apart = |&(share, length): &(f64, f64)| {
        let factors: Vec<f64> = scaled.iter().map(|scaled| if *scaled { share } else { 1.0 }).collect();
        let record = predicted(first, &cycle.scaled(&factors, || length)).ok()?;
        let rival = quick(
            &second.rig,
            &record,
            &second.values,
            (second.set, rig.settings().learn.experiment_first_linearisations),
            Some(ROUGH),
        )?;
        Some(Tried { share, length, record, rival, at_its_end: false })
    };
    let mut tried: Vec<Tried> = menu.par_iter().filter_map(apart).collect();
    // Going on lowers a fit, but for new weights: what is farthest apart at its end is taken as farther than the others will be.
    let Tried { share, length, rival, .. } = loop {
        let most = (0..tried.len()).max_by(|&a, &b| tried[a].rival.cost.total_cmp(&tried[b].rival.cost))?;
        if tried[most].at_its_end {
            break tried.swap_remove(most);
        }
        let one = &mut tried[most];
        let further = quick(
            &second.rig,
            &one.record,
            &one.rival.values,
            (
                second.set,
                rig.settings().learn.experiment_linearisations - rig.settings().learn.experiment_first_linearisations,
            ),
            None,
        );
        if let Some(further) = further.filter(|further| further.cost < one.rival.cost) {
            one.rival = further;
        }
        one.at_its_end = true;
    };
    let sigma = rival.cost.max(0.0).sqrt();
    let inputs = rig.inputs.iter().zip(&scaled).filter(|(_, scaled)| **scaled).map(|(input, _)| input.name.clone());
    Some(Experiment { between: names, inputs: inputs.collect(), share, length, sigma })
}

/// A change of the cycle with the rival fitted to it.
struct Tried {
    share: f64,
    length: f64,
    record: Record,
    rival: PreliminaryModel,
    at_its_end: bool,
}

/// What a fitted model says that a logger would write of a cycle, without noise.
fn predicted(trial: &FittedModel, cycle: &Cycle) -> Result<Record, Complaint> {
    let rig: &Rig = &trial.rig;
    let model = Model::new(rig.clone());
    let times = model::cycle_times(rig, cycle);
    let record = |drive: &InputSignals| -> Result<Record, SimulationError> {
        let outputs = model.solve(&trial.values, drive, &times)?;
        let inputs = model::input_columns(rig, drive, &times);
        Ok(model::recording(rig, "experiment", times.clone(), inputs, &outputs, None))
    };
    let failed = |error: SimulationError| Complaint::new(Kind::Computation, error.to_string());
    let first = record(&InputSignals::from_cycle(rig, cycle)).map_err(failed)?;
    // Once more from its own columns, so that both explanations read the inputs in the same way.
    record(&InputSignals::from_record(rig, &first)?).map_err(failed)
}
