//! Oil that flows otherwise than the rig file says: warmer or colder than its viscosity is of, or another oil.

use super::{Parameter, Rig};
use crate::physics::card::Role;

impl Parameter {
    /// What its value is multiplied by where the oil flows `thinner` times as easily.
    fn share_in_oil(&self, thinner: f64) -> f64 {
        match self.role {
            Role::Viscosity | Role::Viscous => thinner.recip(),
            Role::Laminar => thinner,
            _ => 1.0,
        }
    }
}

impl Rig {
    /// Values of its parameters, SI, had the oil flowed `thinner` times as easily: its viscosity, forces of sheared oil and flows through
    /// gaps.
    pub(crate) fn in_oil(&self, thinner: f64, values: &[f64]) -> Vec<f64> {
        values.iter().zip(&self.parameters).map(|(value, own)| value * own.share_in_oil(thinner)).collect()
    }

    /// The rig in that oil, each value as uncertain as before as a share of it.
    #[must_use]
    pub(crate) fn with_oil(&self, thinner: f64) -> Self {
        let mut rig = self.clone();
        for (index, own) in rig.parameters.iter_mut().enumerate() {
            let share = own.share_in_oil(thinner);
            own.value *= share;
            own.sigma *= share;
            own.spread *= share;
            for fault in rig.faults.iter_mut().filter(|fault| fault.parameter == index) {
                fault.healthy *= share;
                fault.bounds = (fault.bounds.0.min(fault.healthy), fault.bounds.1.max(fault.healthy));
            }
        }
        rig
    }

    /// Parameters that go with the viscosity of its oil.
    pub(crate) fn viscous(&self) -> impl Iterator<Item = usize> + '_ {
        let goes_with_it = |own: &Parameter| matches!(own.role, Role::Viscous | Role::Laminar);
        self.parameters.iter().enumerate().filter(move |(_, own)| goes_with_it(own)).map(|(index, _)| index)
    }

    /// Whether a parameter is the viscosity of its oil.
    pub(crate) fn is_viscosity(&self, parameter: usize) -> bool {
        self.parameters[parameter].role == Role::Viscosity
    }

    /// The viscosity of its oil.
    pub(crate) fn viscosity(&self) -> Option<&Parameter> {
        self.parameters.iter().find(|own| own.role == Role::Viscosity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinner_oil_shears_less_and_leaks_more() {
        let rig = Rig::read("fixtures/clamp_and_feed/rig.toml").unwrap();
        let thin = rig.with_oil(2.0);
        let share = |id: &str| {
            let of = |rig: &Rig| rig.parameters[rig.parameter(id).unwrap()].value;
            of(&thin) / of(&rig)
        };
        let ids = ["fluid.viscosity", "feed_cylinder.viscous_friction", "sequence.drain_conductance", "fluid.density"];
        assert_eq!(ids.map(share), [0.5, 0.5, 2.0, 1.0]);
        assert_eq!(thin.nominal(), rig.in_oil(2.0, &rig.nominal()));
        assert!(
            thin.parameters
                .iter()
                .zip(&rig.parameters)
                .all(|(thin, own)| thin.sigma * own.value == own.sigma * thin.value)
        );
    }
}
