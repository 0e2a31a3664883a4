//! What an effect does that the model lacks: the model that was found with it, and the same without.

use serde::Serialize;

use super::consequence::{Consequence, Runs};
use super::{Next, in_words, look_at, started_alike};
use crate::complaint::Complaint;
use crate::learn::evaluated::{Conclusion, EvaluatedModel};
use crate::learn::opened::neutral;
use crate::learn::result::{EffectParameter, SuggestionReport, parameters};
use crate::learn::suggest::Suggestion;
use crate::model::{InputSignals, Model};
use crate::record::Record;
use crate::rig::Rig;

/// An effect that the model lacks, as people read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Lacking {
    /// Effect and place, such as `external-leakage@A`; of several all, with ` + ` between.
    pub id: String,
    /// The place in words.
    pub part: String,
    /// What it is.
    pub meaning: String,
    /// Its size, with intervals.
    pub parameters: Vec<EffectParameter>,
    /// What it changes at the sensors under the inputs of the fit record, largest first; empty where the model cannot be solved without it.
    pub consequences: Vec<Consequence>,
    /// Whether the records say that it is this one.
    pub certainty: Conclusion,
    /// Effects that explain the record alike.
    pub rivals: Vec<String>,
    /// What to do next.
    pub next: Next,
}

/// A suggestion with its finding, as `suggest --format json` writes it.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct WithFinding<'a> {
    /// The suggestion.
    #[serde(flatten)]
    pub suggestion: &'a SuggestionReport,
    /// The best effect, where it explains more than chance does.
    pub finding: Option<&'a Lacking>,
}

/// The best effect of a suggestion for a record, with what it does there; `command` leads further. `None` where none explains anything.
///
/// # Errors
/// Inputs that the record lacks, and a [context](crate::context) that was cancelled.
pub fn lacking(
    suggestion: &Suggestion,
    (record, shown): (&Record, &SuggestionReport),
    command: String,
) -> Result<Option<Lacking>, Complaint> {
    let Some(best) = suggestion.judged.first().filter(|best| best.supported) else { return Ok(None) };
    let consequences = without(best, record)?;
    let check = look_at(&consequences);
    let rig = &best.trial.rig;
    let place =
        |id: &str| id.split_once('@').map_or_else(|| "the circuit".to_owned(), |(_, at)| place_in_words(rig, at));
    let ids = best.effects.iter().map(|effect| effect.id.as_str());
    Ok(Some(Lacking {
        id: best.id(),
        part: ids.clone().map(place).collect::<Vec<_>>().join(" and "),
        meaning: best.effects.iter().map(|effect| effect.placed.effect.meaning).collect::<Vec<_>>().join(" "),
        parameters: ids.flat_map(|id| parameters(&best.trial, id)).collect(),
        consequences,
        certainty: shown.conclusion,
        rivals: best.confounded_with.clone(),
        next: Next { check, command },
    }))
}

/// A node, component or sensor in words.
fn place_in_words(rig: &Rig, at: &str) -> String {
    match rig.components.iter().find(|component| component.name == at) {
        Some(component) => in_words(component),
        None if rig.nodes.iter().any(|node| node.name == at) => format!("node {at}"),
        None => format!("sensor {at}"),
    }
}

/// What a model with effects reads, beside the same with these at nothing.
fn without(best: &EvaluatedModel, record: &Record) -> Result<Vec<Consequence>, Complaint> {
    let (rig, found) = (&best.trial.rig, &best.trial.values);
    let mut values = found.clone();
    for present in rig.effects.iter().filter(|present| best.effects.iter().any(|one| one.id == present.id)) {
        for (free, &index) in present.placed.effect.parameters.iter().zip(&present.parameters) {
            values[index] = neutral(rig, &present.placed, free).unwrap_or(values[index]);
        }
    }
    let model = Model::new(rig.clone());
    let drive = InputSignals::from_record(rig, record)?;
    let Some(without) = started_alike(&model, record, &drive, (found, &values))? else { return Ok(Vec::new()) };
    let both = [&best.trial.fit.outputs[..], &without[..]];
    let runs = Runs { other: "without it", ..Runs::simulated((rig, record, &drive), 0, both) };
    Ok(runs.consequences(false))
}

/// What it does, in a sentence; `None` where nothing is known of that.
pub fn does(finding: &Lacking) -> Option<String> {
    let texts: Vec<&str> = finding.consequences.iter().map(|one| one.text.as_str()).collect();
    (!texts.is_empty()).then(|| format!("With it, {}.", texts.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_named_as_people_name_it() {
        let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let shown = ["A", "flow_control", "cylinder"].map(|at| place_in_words(&rig, at));
        assert_eq!(shown, ["node A", "flow control (flow control valve)", "cylinder"]);
    }
}
