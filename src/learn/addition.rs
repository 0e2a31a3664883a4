//! An effect that was added to a rig file, as programs read it (`borescope.addition/1`).

use std::path::Path;

use serde::Serialize;

use super::add::Added;
use super::spools;
use super::warning::Warning;
use crate::complaint::Complaint;
use crate::diagnosis::DynamicsReport;
use crate::number::rounded;
use crate::rig::Rig;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.addition/1";

/// Digits of a reported number.
const DIGITS: usize = 7;

/// What was added to a rig file.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct AdditionReport {
    /// Name and version of the JSON schema: `borescope.addition/1`.
    pub schema: &'static str,
    /// The new rig file, as it was called.
    pub rig: String,
    /// The effects that the old file does not have.
    pub effects: Vec<AddedEffect>,
    /// Fall of the information criterion on the record with them; `None` without a record.
    pub delta_bic: Option<f64>,
    /// How spools follow their commands, where the record asks for other than the rig file had.
    pub dynamics: Vec<DynamicsReport>,
    /// What speaks against them as fitted.
    #[cfg_attr(feature = "internals", schemars(with = "Vec<String>"))]
    pub warnings: Vec<Warning>,
}

/// An effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct AddedEffect {
    /// Effect and place.
    pub id: String,
    /// In the order of its card.
    pub parameters: Vec<AddedParameter>,
}

/// A parameter of an effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct AddedParameter {
    /// Such as `external-leakage@A.conductance`.
    pub id: String,
    /// In `unit`.
    pub value: f64,
    /// One standard deviation, in `unit`; 0 for a value taken as exact.
    pub sigma: f64,
    /// As it is written in the rig file.
    pub unit: String,
}

impl AdditionReport {
    /// Of an effect that was added to `before` and written to `path`.
    ///
    /// # Errors
    /// A text that is no rig file.
    pub fn new(before: &Rig, added: &Added, path: &Path) -> Result<Self, Complaint> {
        let rig = Rig::parse(path, added.text.clone())?;
        let parameter = |&index: &usize| {
            let parameter = &rig.parameters[index];
            AddedParameter {
                id: parameter.id.clone(),
                value: rounded(parameter.unit.from_si(parameter.value), DIGITS),
                sigma: rounded(parameter.unit.difference_from_si(parameter.sigma), DIGITS),
                unit: parameter.unit.to_string(),
            }
        };
        let new = rig.effects.iter().filter(|effect| before.effects.iter().all(|old| old.id != effect.id));
        let effect = |effect: &crate::rig::InstalledEffect| AddedEffect {
            id: effect.id.clone(),
            parameters: effect.parameters.iter().map(parameter).collect(),
        };
        Ok(Self {
            schema: SCHEMA,
            rig: path.display().to_string(),
            effects: new.map(effect).collect(),
            delta_bic: added.delta_bic.map(|fall| rounded(fall, DIGITS)),
            dynamics: spools::report(before, &rig),
            warnings: added.warnings.clone(),
        })
    }
}
