//! A rig file whose effects are set, taken out, or refitted by hand.

use std::collections::BTreeSet;

use super::add::{Written, insert, with_effects};
use super::evaluated::is_adequate;
use super::fitted_model::FittedModel;
use super::opened::opened;
use super::suggest::rough_base;
use crate::complaint::Complaint;
use crate::record::Record;
use crate::rig::{Rig, document};

/// The text of a rig file with the effects of `moved` at these values (all parameters of the rig, SI), without those of `off`.
///
/// # Errors
/// A text that is no TOML.
pub fn revised(
    text: &str,
    rig: &Rig,
    values: &[f64],
    (moved, off): (&BTreeSet<String>, &BTreeSet<String>),
) -> Result<String, Complaint> {
    let mut text = text.to_owned();
    for effect in rig.effects.iter().filter(|effect| moved.contains(&effect.id) && !off.contains(&effect.id)) {
        let written = effect.placed.effect.parameters.iter().zip(&effect.parameters).map(|(free, &index)| {
            let unit = rig.effect_unit(&effect.placed, free.name);
            Written { name: free.name, value: values[index], sigma: rig.parameters[index].sigma, unit }
        });
        text = insert(rig, &text, &effect.id, &written.collect::<Vec<_>>())?;
    }
    if rig.effects.iter().any(|effect| off.contains(&effect.id)) {
        let mut document = document(&rig.path, &text)?;
        if let Some(table) = document.get_mut("effects").and_then(|effects| effects.as_table_like_mut()) {
            for id in off {
                let name = rig.effect_among(table.iter().map(|(name, _)| name), id).to_owned();
                table.remove(&name);
            }
        }
        text = document.to_string();
    }
    Ok(text)
}

/// The effects of a rig that it states with an uncertainty refitted, with the faults that the record shows beside them: the text
/// of the rig file with them, and the fit.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved on the record.
pub fn refitted(text: &str, rig: &Rig, record: &Record) -> Result<(String, FittedModel), Complaint> {
    let enough = |base: &FittedModel| is_adequate(&base.fit);
    let fitted = rig.context().run(|| rough_base((&opened(rig), None), record, enough, |_, base| Ok(base)))?;
    Ok((with_effects(&rig.path, text, rig, &fitted)?, fitted))
}
