//! What faults were before they began, where that is within a record.

use super::{Parameter, Rig};
use crate::physics::card::Role;

impl Rig {
    /// The rig with a parameter more for each fault: its healthy value, which the faulty parameter has until the fault
    /// begins. It is as uncertain as the healthy value and goes together with the same others; where it is uncertain, a
    /// fault that is not present has the same value before and after.
    #[must_use]
    #[doc(hidden)]
    pub fn with_before(&self) -> Self {
        let mut rig = self.clone();
        for fault in &self.faults {
            let own = &self.parameters[fault.parameter];
            rig.before.push((fault.parameter, rig.parameters.len()));
            rig.parameters.push(Parameter {
                id: format!("{} before", own.id),
                value: fault.healthy,
                bounds: fault.bounds,
                // What is another in each switching is in the weights, before a fault as after it.
                sigma: if own.per_event { 0.0 } else { own.sigma },
                per_event: false,
                role: Role::Plain,
                ..own.clone()
            });
        }
        rig
    }

    /// The parameter whose healthy value the parameter with this index holds; itself otherwise.
    pub(crate) fn original(&self, parameter: usize) -> usize {
        self.before.iter().find(|(_, before)| *before == parameter).map_or(parameter, |(original, _)| *original)
    }

    /// The parameter that holds what this one was before, if there is one.
    #[doc(hidden)]
    pub fn before(&self, parameter: usize) -> Option<usize> {
        self.before.iter().find(|(original, _)| *original == parameter).map(|(_, before)| *before)
    }
}
