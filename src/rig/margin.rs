//! Margins: physics that every circuit has a little of, and that no data sheet knows.
//!
//! A model without it is never quite right, and puts what is missing upon parameters that can bear it: a trace of leakage makes
//! the pump smaller, ten newtons of friction turn the gain of a pressure sensor. However many healthy records there are, all
//! of them say the same, so that values look far better known than they are (Brynjarsdottir and O'Hagan, Inverse Problems 30
//! (2014) 114007). A calibrated rig therefore holds such effects as uncertain parameters, centred on nothing.

use super::{Component, Fault, ParameterSetting, Rig};
use crate::complaint::{Complaint, Kind, Place, help_with_names};
use crate::physics::effect::EFFECTS;

/// How large they may be, one standard deviation, as a share of the size that would be called an effect.
const SHARE: f64 = 0.1;

/// What records leave open of each parameter, as a share of what the data sheet does, however many they are: what the model
/// leaves out otherwise is the same in all of them, and moves parameters as far as it is large, not as far as noise allows
/// (Kennedy and O'Hagan, Journal of the Royal Statistical Society B 63 (2001) 425). With this share errors of calibrated rigs
/// are as large as they claim (`tests/it/diagnosis/calibration_honest.rs`).
pub const NEVER_KNOWN: f64 = 0.02;

impl Rig {
    /// What no record tells of a fault, one standard deviation, SI; 0 of a rig file that states its healthy value, as the laws are then
    /// taken as right too.
    pub(crate) fn never_known(&self, fault: &Fault) -> f64 {
        let known = self.calibration.is_none() && !self.parts_deviate;
        if known { 0.0 } else { NEVER_KNOWN * self.parameters[fault.parameter].spread }
    }

    /// Parameters with these indices are exact by the rig file, although parts deviate from data sheets and no calibration has said
    /// by how much.
    pub(crate) fn exact_by_sheet(&self) -> Vec<usize> {
        let deviates = |index: &usize| {
            let parameter = &self.parameters[*index];
            parameter.spread > 0.0 && parameter.sigma == 0.0 && !self.is_fault(*index) && !self.is_of_sensor(*index)
        };
        if self.calibration.is_some() { Vec::new() } else { (0..self.parameters.len()).filter(deviates).collect() }
    }

    /// The rig with everything as uncertain as parts deviate from their data sheets, where its file takes it as exact, and with all
    /// margins; `None` where a calibration or the file has said how sure each value is.
    pub(crate) fn as_by_data_sheet(&self) -> Option<Rig> {
        if self.exact_by_sheet().is_empty() {
            return None;
        }
        let mut rig = self.clone();
        for margin in self.margins() {
            rig.give_margin(&margin).ok()?;
        }
        rig.parts_deviate = true;
        for parameter in rig.parameters.iter_mut().filter(|parameter| parameter.sigma == 0.0) {
            parameter.sigma = parameter.spread;
        }
        // What the file leaves unsaid of an offset is its tolerance, which is that of a sensor that was trimmed.
        for sensor in self.sensors.iter().filter(|sensor| !sensor.tolerance_is_stated) {
            let offset = &mut rig.parameters[sensor.first_parameter];
            if offset.sigma == sensor.tolerance {
                offset.sigma = offset.spread.max(offset.sigma);
            }
        }
        Some(rig)
    }

    /// The margins that the rig may still be given: every place of an effect that no circuit is quite without, that it can have
    /// and has not.
    pub(crate) fn margins(&self) -> Vec<String> {
        let ids = self
            .effect_places()
            .into_iter()
            .filter(|placed| placed.effect.everywhere)
            .map(|placed| self.effect_id(&placed));
        let open = ids.filter(|id| self.effects.iter().all(|present| present.id != *id));
        // Without a tank, nothing leaks to it.
        open.filter(|id| self.clone().give_margin(id).is_ok()).collect()
    }

    /// Gives the rig a margin: the component of the effect `id` with its size uncertain around nothing. Its parameters, named
    /// `margin.` and what they are of the effect, come behind all others.
    ///
    /// # Errors
    /// An effect that is no margin, a place where this rig cannot have it, or a margin that it has.
    pub(crate) fn give_margin(&mut self, id: &str) -> Result<(), Complaint> {
        let placed = self.placed(id)?;
        if !placed.effect.everywhere {
            let margins = EFFECTS.iter().filter(|effect| effect.everywhere).map(|effect| effect.name);
            return Err(Complaint::new(Kind::UnknownName, format!("`{id}` is no margin"))
                .at(Place::file(&self.path))
                .help(help_with_names(id, "margins", margins)));
        }
        let Some(size) = placed.effect.parameters.first() else { return Ok(()) };
        let sigma = SHARE * self.first_size(&placed, size).unwrap_or(0.0);
        let nothing = self.effect_unit(&placed, size.name).difference_to_si(size.neutral.unwrap_or(0.0));
        let given = [ParameterSetting { name: size.name.to_owned(), value: nothing, sigma }];
        let known = self.components.len();
        self.attach(&placed, &format!("margin.{id}"), &given)?;
        self.components[known..].iter_mut().for_each(|component| component.margin = true);
        Ok(())
    }

    /// Whether a parameter belongs to a margin.
    pub(crate) fn is_margin(&self, parameter: usize) -> bool {
        self.components.iter().any(|component| component.margin && component.owns(parameter))
    }

    /// The components of the rig file with their indices: margins have no residuals, no symbol and no structure.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, &Component)> {
        self.components.iter().enumerate().filter(|(_, component)| !component.margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_margin_is_told_from_what_a_data_sheet_states() {
        let mut rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let known = rig.parameters.len();
        rig.give_margin("external-leakage@A").unwrap();
        let size = rig.parameter("margin.external-leakage@A.conductance").unwrap();
        assert!(size >= known && rig.is_margin(size));
        assert!((0..known).all(|parameter| !rig.is_margin(parameter)));
    }
}
