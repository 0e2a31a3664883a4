//! A fault that a diagnosis found, as people read it: which part, how far from new, what follows from it, how sure, what else it
//! could be, what to do next.

mod consequence;
#[cfg(feature = "cli")]
pub mod lacking;
#[cfg(feature = "cli")]
pub mod measured;

use std::path::Path;

use serde::Serialize;

pub use consequence::Consequence;
#[cfg(not(feature = "internals"))]
use consequence::Runs;
#[cfg(feature = "internals")]
pub use consequence::{Measure, Runs};

use crate::complaint::Complaint;
use crate::diagnosis::{Diagnosis, FaultReport, RivalEffect};
use crate::model::{InputSignals, Model, SimulationError};
use crate::number::rounded;
use crate::record::Record;
use crate::rig::{Component, Rig};

/// Probability below which a rival is not named: a report prints it as `< 0.1 %`.
const NAMED: f64 = 0.001;

/// Another explanation of the record, without the fault of the finding.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Rival {
    /// Ids; none is the circuit without faults.
    pub faults: Vec<String>,
    /// An effect that the model lacks, which stands in place of the fault.
    pub effect: Option<RivalEffect>,
    /// `None` where the record cannot isolate the fault from these, and of an effect, which is no fault of the rig file.
    pub probability: Option<f64>,
}

/// What to do next about a finding.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Next {
    /// The sensor and the phase to look at, in words; `None` where no sensor shows the fault.
    pub check: Option<String>,
    /// The command that says more.
    pub command: String,
}

/// A fault that is present. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Finding {
    /// The id of the fault, such as `cylinder.clearance`.
    pub id: String,
    /// The part in words, such as `flow control (flow control valve)`.
    pub part: String,
    /// The parameter in words, as its card has it.
    pub deviation: String,
    /// `larger` or `smaller` than new.
    pub direction: &'static str,
    /// The estimate.
    pub value: f64,
    /// Unit of the parameter; `-` for a pure number.
    pub unit: String,
    /// The value of a new part.
    pub healthy: f64,
    /// Ends of the 95 % interval; `None` where the record does not bound the value.
    pub ci95: [Option<f64>; 2],
    /// How probable it is that the fault is there.
    pub probability: f64,
    /// What the fault changes at the sensors under the inputs of the record, largest first.
    pub consequences: Vec<Consequence>,
    /// What else it could be.
    pub rivals: Vec<Rival>,
    /// What to do next.
    pub next: Next,
}

/// A diagnosis with its findings, as `diagnose --format json` writes it.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct WithFindings<'a> {
    /// The diagnosis.
    #[serde(flatten)]
    pub diagnosis: &'a Diagnosis,
    /// One for each fault that is present.
    pub findings: &'a [Finding],
}

/// The faults that a diagnosis of a record found, each with its consequences: the record's inputs are simulated with all of them,
/// and once more without each. A model that cannot be solved with them leaves the consequences empty.
///
/// # Errors
/// Inputs that the record lacks, and a [context](crate::context) that was cancelled.
pub fn findings(model: &Model, record: &Record, diagnosis: &Diagnosis) -> Result<Vec<Finding>, Complaint> {
    let present: Vec<&FaultReport> = diagnosis.present().collect();
    if present.is_empty() {
        return Ok(Vec::new());
    }
    let drive = InputSignals::from_record(&model.rig, record)?;
    let parameters = diagnosis.found(&model.rig);
    let solve = |with: &[f64]| started_alike(model, record, &drive, (&parameters, with));
    let with_all = solve(&parameters)?;
    let onset = diagnosis.onset_s.unwrap_or(f64::NEG_INFINITY);
    let from = record.time.partition_point(|&time| time < onset);
    let one = |fault: &FaultReport| {
        let place = model.rig.faults.iter().find(|one| model.rig.parameters[one.parameter].id == fault.id);
        let of_sensor = place.is_some_and(|place| model.rig.is_of_sensor(place.parameter));
        let mut without = parameters.clone();
        if let Some(place) = place {
            without[place.parameter] = place.healthy;
        }
        let consequences = match (&with_all, solve(&without)?) {
            (Some(with), Some(without)) => {
                Runs::simulated((&model.rig, record, &drive), from, [with, &without]).consequences(of_sensor)
            }
            _ => Vec::new(),
        };
        Ok(finding(&model.rig, diagnosis, fault, consequences))
    };
    present.into_iter().map(one).collect()
}

/// What the sensors would show with parameters, SI, of a machine that starts where it does with those that were `found`, whatever its
/// sensors show; `None` of a model that cannot be solved with them.
///
/// # Errors
/// A [context](crate::context) that was cancelled.
fn started_alike(
    model: &Model,
    record: &Record,
    drive: &InputSignals,
    (found, with): (&[f64], &[f64]),
) -> Result<Option<Vec<Vec<f64>>>, Complaint> {
    match model.solve(with, &drive.started_alike(&model.rig, found, with), &record.time) {
        Ok(outputs) => Ok(Some(outputs.values)),
        Err(error @ SimulationError::Interrupted) => Err(model.unsolved(&error)),
        Err(_) => Ok(None),
    }
}

/// The sensor and the phase in which the first consequence shows, in words.
fn look_at(consequences: &[Consequence]) -> Option<String> {
    let first = consequences.first()?;
    Some(format!("look at {} from {} s to {} s", first.sensor, rounded(first.from_s, 4), rounded(first.to_s, 4)))
}

fn finding(rig: &Rig, diagnosis: &Diagnosis, fault: &FaultReport, consequences: Vec<Consequence>) -> Finding {
    let rivals = rivals(diagnosis, &fault.id);
    let check = look_at(&consequences);
    let (rig_file, record) = (argument(&diagnosis.rig), argument(&diagnosis.record));
    let command = match rivals.first() {
        None => format!("borescope diagnose {rig_file} {record} --report diagnosis.html"),
        Some(Rival { effect: Some(_), .. }) => format!("borescope suggest {rig_file} {record} --check ANOTHER_RECORD"),
        Some(_) => format!("borescope isolability {rig_file} --input {record}"),
    };
    Finding {
        id: fault.id.clone(),
        part: part(rig, &fault.id),
        deviation: fault.meaning.clone(),
        direction: if fault.value < fault.healthy { "smaller" } else { "larger" },
        value: fault.value,
        unit: fault.unit.clone(),
        healthy: fault.healthy,
        ci95: fault.ci95,
        probability: fault.probability,
        consequences,
        rivals,
        next: Next { check, command },
    }
}

/// What may stand in place of a fault: first other faults that the record cannot isolate from it, then effects, then fault
/// combinations that are less probable.
fn rivals(diagnosis: &Diagnosis, id: &str) -> Vec<Rival> {
    let groups = diagnosis.ambiguity.iter().filter(|group| group.iter().any(|one| one == id));
    let group = |group: &Vec<String>| Rival {
        faults: group.iter().filter(|one| *one != id).cloned().collect(),
        effect: None,
        probability: None,
    };
    let beside = || diagnosis.present().map(|fault| fault.id.clone()).filter(|one| one != id).collect();
    let effects = diagnosis.rival_effects.iter().filter(|one| one.fault == id);
    let effects = effects.map(|one| Rival { faults: beside(), effect: Some(one.clone()), probability: None });
    let lacking =
        |one: &&crate::diagnosis::Hypothesis| one.probability >= NAMED && !one.faults.iter().any(|fault| fault == id);
    let other = diagnosis.hypotheses.iter().filter(lacking);
    let other = other.map(|one| Rival { faults: one.faults.clone(), effect: None, probability: Some(one.probability) });
    groups.map(group).chain(effects).chain(other).collect()
}

/// The part that a parameter belongs to, in words: its name, and what kind of component it is where the name does not say so.
fn part(rig: &Rig, id: &str) -> String {
    let owner = id.rsplit_once('.').map_or(id, |(owner, _)| owner);
    let owner = owner.strip_prefix("sensor.").map_or_else(|| owner.to_owned(), |name| format!("sensor {name}"));
    let component = rig.parameter(id).and_then(|index| rig.components.iter().find(|one| one.owns(index)));
    component.map_or(owner, in_words)
}

/// The name of a component, and what kind it is where the name does not say so.
fn in_words(component: &Component) -> String {
    let name = component.name.replace(['_', '-'], " ");
    // `own:` and `catalogue:` say where it is described.
    let kind = component.card.kind.rsplit(':').next().unwrap_or_default().replace(['_', '-'], " ");
    if kind.is_empty() || name.contains(&kind) { name } else { format!("{name} ({kind})") }
}

/// A path as an argument of a shell.
pub(crate) fn argument(path: impl AsRef<Path>) -> String {
    let path = path.as_ref().display().to_string();
    let plain = |character: char| character.is_alphanumeric() || "/._-+:@".contains(character);
    if path.chars().all(plain) { path } else { format!("'{}'", path.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_with_a_blank_is_one_argument() {
        assert_eq!(argument("fixtures/rig.toml"), "fixtures/rig.toml");
        assert_eq!(argument("my rig's.toml"), "'my rig'\\''s.toml'");
    }
}
