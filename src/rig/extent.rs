//! What the equations of a rig will have: their number, and whether each can be solved for its derivative.

use super::{NodeKind, Rig};
use crate::physics::card::PortKind;
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{PortFlows, PortVariables};

impl Rig {
    /// Number of states: pressures of volumes, position and velocity of bodies, those of components, readings that lag.
    pub(crate) fn states(&self) -> usize {
        let of_node = |kind: &NodeKind| match kind {
            NodeKind::Held { .. } => 0,
            NodeKind::Volume { .. } => PortKind::Hydraulic.variables(),
            NodeKind::Body { .. } => PortKind::Mechanical.variables(),
        };
        let nodes: usize = self.nodes.iter().map(|node| of_node(&node.kind)).sum();
        let components: usize = self.components.iter().map(|component| component.card.states.len()).sum();
        nodes + components + self.sensors.iter().filter(|sensor| sensor.lag > 0.0).count()
    }

    /// Whether any component gives the node capacity: a volume, or a mass.
    pub(crate) fn has_capacity(&self, node: usize) -> bool {
        let nominal = self.nominal();
        let fluid = Fluid::new(&nominal[..fluid::CARD.parameters.len()]);
        let mut capacity = 0.0;
        for component in &self.components {
            let Some(law) = component.law(|index| nominal[index], &fluid) else { continue };
            // At rest under atmospheric pressure; capacities are positive everywhere or nowhere.
            let mut seen = PortVariables::default();
            let mut next = 0;
            for port in component.card.ports {
                if port.kind == PortKind::Hydraulic {
                    seen.z[next] = crate::physics::ATMOSPHERE;
                }
                next += port.kind.variables();
            }
            let mut answers = PortFlows::default();
            law.evaluate(&seen, &mut answers);
            for (port, _) in component.ports.iter().enumerate().filter(|(_, at)| **at == node) {
                capacity += answers.capacity[port];
            }
        }
        capacity > 0.0
    }
}
