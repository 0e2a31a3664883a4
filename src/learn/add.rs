//! Writing an effect into a rig file; everything else, comments and order included, stays.

use std::path::Path;

use toml_edit::{InlineTable, Item, Table};

use super::departure::{nothing, size};
use super::evaluated::is_adequate;
use super::fitted_model::{FittedModel, Judge};
use super::opened::opened;
use super::refit::range_deviation;
use super::scoring::candidate;
use super::spools::{with_dynamics, with_spools};
use super::suggest::{refitted_alone, restarted, rough_base};
use super::verdict::warnings;
use super::warning::Warning;
use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::estimate::Estimate;
use crate::number::written;
use crate::record::Record;
use crate::rig::{EffectInstance, InstalledEffect, Rig, document};
use crate::units::Unit;

/// Digits of a value and of its standard error.
const DIGITS: (usize, usize) = (7, 3);
/// Share of its standard deviation below which a value is written as zero: its own digits show less.
const NOTHING: f64 = 1e-7;

/// A parameter as it is written: name, value and standard error, both in SI, and the unit.
pub(super) struct Written {
    pub name: &'static str,
    pub value: f64,
    pub sigma: f64,
    pub unit: Unit,
}

/// A rig file with one effect more.
pub struct Added {
    /// Of the new rig file.
    pub text: String,
    /// Fall of the information criterion on the record with it; `None` without a record.
    pub delta_bic: Option<f64>,
    /// What speaks against it as fitted.
    pub warnings: Vec<Warning>,
}

/// A rig file with one effect more: fitted to a record if there is one, jointly with the effects that the file states with an
/// uncertainty, else at its neutral value with an uncertainty that lets later fits estimate it.
///
/// # Errors
/// An effect that the rig cannot have or has already; without a record, an effect that is nothing at no value; columns that
/// are missing, or a model that cannot be solved.
pub fn add(text: &str, rig: &Rig, id: &str, record: Option<&Record>) -> Result<Added, Complaint> {
    let placed = rig.placed(id)?;
    let id = rig.effect_id(&placed);
    if rig.effects.iter().any(|present| present.id == id) {
        return Err(Complaint::new(Kind::Duplicate, format!("the rig has the effect `{id}` already"))
            .at(Place::file(&rig.path))
            .help("delete it from `[effects]` first"));
    }
    if let Some(record) = record {
        let fitted = |rig: &Rig, near: Option<&FittedModel>| {
            let enough = |(trial, ..): &Fitted| is_adequate(&trial.fit);
            rough_base((rig, near), record, enough, |estimate, base| fitted_with(estimate, &base, &placed))
        };
        let (trial, gained, warnings) =
            rig.context().run(|| with_spools(&opened(rig), record, fitted, |(trial, ..): &Fitted| trial))?;
        let text = with_effects(&rig.path, text, rig, &trial)?;
        return Ok(Added { text, delta_bic: Some(gained), warnings });
    }
    let mut parameters = Vec::new();
    for free in placed.effect.parameters {
        let unit = rig.effect_unit(&placed, free.name);
        let Some(first) = rig.first_size(&placed, free) else {
            return Err(Complaint::new(Kind::MissingEntry, format!("it is not known yet where `{id}` begins"))
                .at(Place::file(&rig.path))
                .help("give a record with `--fit`"));
        };
        let size = size(rig, &placed, free);
        let sigma = if size > 0.0 { rig.settings().learn.unfitted_sigma * size } else { range_deviation(&unit, free) };
        parameters.push(Written { name: free.name, value: nothing(rig, &placed, free).unwrap_or(first), sigma, unit });
    }
    Ok(Added { text: insert(rig, text, &id, &parameters)?, delta_bic: None, warnings: Vec::new() })
}

/// The model with one effect more, what the information criterion gains by it over the model alone, and what speaks against it.
type Fitted = (FittedModel, f64, Vec<Warning>);

fn fitted_with(estimate: &Estimate<'_>, base: &FittedModel, placed: &EffectInstance) -> Result<Fitted, Complaint> {
    let record = estimate.case.record;
    let (trial, screened) = refitted_alone(base, record, candidate(estimate, base, placed)?)?;
    let gained = trial.gain_over(base, record, &Judge::of(&trial, &trial.fit, record)?)?;
    match restarted(estimate, base, (&trial, screened), gained)? {
        Some(better) => fitted_with(&better, &FittedModel::of(&better)?, placed),
        None => {
            let warnings = warnings(&trial, base);
            Ok((trial, gained, warnings))
        }
    }
}

/// The text of a rig file with the effects of a trial as fitted, but for those that it states as exact, and with spools that follow as
/// in the trial.
///
/// # Errors
/// A text that is no TOML.
pub(crate) fn with_effects(path: &Path, text: &str, rig: &Rig, trial: &FittedModel) -> Result<String, Complaint> {
    let mut text = text.to_owned();
    let is_exact = |old: &InstalledEffect| old.parameters.iter().all(|&index| rig.parameters[index].sigma == 0.0);
    let stays = |present: &InstalledEffect| rig.effects.iter().any(|old| old.id == present.id && is_exact(old));
    for present in trial.rig.effects.iter().filter(|present| !stays(present)) {
        let written = present.placed.effect.parameters.iter().zip(&present.parameters).map(|(free, &index)| {
            let unit = trial.rig.effect_unit(&present.placed, free.name);
            let sigma = trial.sigmas.get(&index).copied().unwrap_or(0.0);
            Written { name: free.name, value: trial.values[index], sigma, unit }
        });
        text = insert(&trial.rig, &text, &present.id, &written.collect::<Vec<_>>())?;
    }
    with_dynamics(path, &text, rig, &trial.rig)
}

/// The text of a rig's file with this effect, in the place of what it said of it before, under whatever name.
///
/// # Errors
/// A text that is no TOML, or whose `effects` is no table.
pub(super) fn insert(rig: &Rig, text: &str, id: &str, parameters: &[Written]) -> Result<String, Complaint> {
    let mut document = document(&rig.path, text)?;
    let mut values = InlineTable::new();
    for parameter in parameters {
        let shown = |value: f64, digits: usize| written(value, digits, &parameter.unit);
        let sigma = parameter.unit.difference_from_si(parameter.sigma);
        let value = parameter.unit.from_si(parameter.value);
        // What a fit leaves of a height that it does not move is zero with its last digits wrong.
        let value = shown(if value.abs() < NOTHING * sigma { 0.0 } else { value }, DIGITS.0);
        let stated = if sigma > 0.0 { format!("{value} +- {}", shown(sigma, DIGITS.1)) } else { value };
        values.insert(parameter.name, stated.into());
    }
    let effects = document.entry("effects").or_insert_with(|| {
        let mut table = Table::new();
        table.decor_mut().set_prefix("\n# Physics beyond that of the components.\n");
        Item::Table(table)
    });
    let Some(table) = effects.as_table_like_mut() else {
        return Err(Complaint::new(Kind::Shape, "`effects` is no table")
            .at(Place::file(&rig.path))
            .help("write `[effects]`"));
    };
    let name = rig.effect_among(table.iter().map(|(name, _)| name), id).to_owned();
    table.insert(&name, toml_edit::value(values));
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds every effect that a rig can have, without a record, and reads what is written; how many those are.
    fn added(path: &str) -> usize {
        let (rig, text) = (Rig::read(path).unwrap(), std::fs::read_to_string(path).unwrap());
        let ids = rig.effect_places().into_iter().map(|placed| rig.effect_id(&placed));
        let texts: Vec<(String, String)> =
            ids.filter_map(|id| Some((add(&text, &rig, &id, None).ok()?.text, id))).collect();
        for (text, id) in &texts {
            Rig::parse(Path::new(path), text.clone()).unwrap_or_else(|error| panic!("{id}: {error}"));
        }
        texts.len()
    }

    #[test]
    fn an_effect_with_a_place_that_need_not_be_said_is_not_written_twice() {
        let path = "fixtures/telescopic/rig.toml";
        let text = std::fs::read_to_string(path).unwrap()
            + "\n[effects]\n\"pump-slip@pump\" = { conductance = \"0.001 L/min/bar +- 0.0005 L/min/bar\" }\n";
        let rig = Rig::parse(Path::new(path), text.clone()).unwrap();
        let written =
            Written { name: "conductance", value: 5e-14, sigma: 0.0, unit: Unit::parse("L/min/bar").unwrap() };
        let text = insert(&rig, &text, "pump-slip", &[written]).unwrap();
        assert!(text.contains("\"pump-slip@pump\" = { conductance = \"0.0003 L/min/bar\" }"), "{text}");
        assert_eq!(Rig::parse(Path::new(path), text).unwrap().effects.len(), 1);
    }

    #[test]
    fn what_is_added_without_a_record_can_be_read() {
        assert!(added("fixtures/telescopic/rig.toml") > 20);
        // An effect of an own component whose second parameter may be of any size.
        assert!(added("fixtures/hydrostatic_drive/rig.toml") > 20);
    }
}
