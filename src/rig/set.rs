//! Parameters by id and text.

use super::{Rig, range};
use crate::complaint::{Complaint, Kind, Place};
use crate::units::Quantity;

impl Rig {
    /// Gives the parameter `id`, such as `cylinder.clearance`, the value of a text with its unit, such as `0.2 mm`; returns what
    /// was read. Of an effect that has a single place, that may be written as under `[effects]`: `pump-slip@pump.conductance`.
    ///
    /// # Errors
    /// An id that is no parameter; a text that is no number or has no unit, one that is not known, or one of another dimension;
    /// a value outside the physical bounds.
    pub fn set(&mut self, id: &str, value: &str) -> Result<Quantity, Complaint> {
        let id = &self.with_own_effect(id.trim());
        let Some(index) = self.parameter(id) else {
            return Err(Complaint::new(Kind::UnknownName, format!("the rig has no parameter `{id}`"))
                .at(Place::file(&self.path))
                .help(self.help_with_effect(id).unwrap_or_else(|| self.help_with_parameters(id))));
        };
        let parameter = &mut self.parameters[index];
        let quantity = Quantity::parse_as(value, parameter.unit.dimension)
            .map_err(|error| Complaint::new(Kind::Unit, error.to_string()).help(error.help()))?;
        let (low, high) = parameter.bounds;
        if !(low..=high).contains(&quantity.value) {
            let range = range((low, high), &quantity.unit);
            return Err(Complaint::new(Kind::Bounds, format!("{quantity} is outside the physical bounds"))
                .at(parameter.place.clone())
                .help(format!("{}: {range}", parameter.meaning)));
        }
        parameter.value = quantity.value;
        Ok(quantity)
    }

    /// An id with the effect in it called as parameters are.
    fn with_own_effect(&self, id: &str) -> String {
        let own = || {
            let (effect, parameter) = id.rsplit_once('.').filter(|(effect, _)| effect.contains('@'))?;
            Some(format!("{}.{parameter}", self.effect_id(&self.placed(effect).ok()?)))
        };
        own().unwrap_or_else(|| id.to_owned())
    }

    /// Help for a parameter of an effect that the rig may have and does not.
    fn help_with_effect(&self, id: &str) -> Option<String> {
        let (effect, parameter) = id.rsplit_once('.')?;
        let mut places = self.effect_places().into_iter().filter(|placed| self.effect_id(placed) == effect);
        let placed = places.next()?;
        let has = self.effects.iter().any(|present| present.id == effect);
        let card = placed.effect.form.card().filter(|_| !has)?;
        card.parameters.iter().find(|own| own.name == parameter)?;
        Some(format!(
            "{} is an effect that the rig does not have: `borescope add` writes it into the rig file ({})",
            effect, card.meaning
        ))
    }
}
