//! Whether formulas have a value wherever a circuit may go.

use super::OwnKind;
use crate::complaint::{Complaint, Kind, Place};
use crate::physics::ATMOSPHERE;
use crate::physics::card::PortKind;
use crate::physics::fluid::Fluid;
use crate::physics::own_law;
use crate::physics::ports::PortVariables;
use crate::rig::parse::card_unit;

/// Gauge pressures, Pa, positions, m, and speeds, m/s, that a circuit may well come to.
const PRESSURES: [f64; 2] = [0.0, 1e7];
const POSITIONS: [f64; 2] = [0.0, 0.1];
const SPEEDS: [f64; 2] = [-0.1, 0.1];

impl OwnKind {
    /// Complains about a formula that has no value where any of the ports has more pressure than the others, or a body moves
    /// either way; `parameters` and those of the fluid, SI, are those of the component at `place`. States are where they start,
    /// inputs at one of their unit.
    pub fn check_domain(&self, parameters: &[f64], fluid: &Fluid<f64>, place: &Place) -> Result<(), Complaint> {
        let variables: usize = self.card.ports.iter().map(|port| port.kind.variables()).sum();
        for choice in 0..1_usize << variables {
            let seen = self.point(choice);
            let values = own_law::values(self.card, self.own, parameters, fluid, &seen);
            let formulas = self.own.formulas().zip(&self.places);
            for (formula, written) in formulas {
                if !formula.evaluate(&values).is_finite() {
                    return Err(self.without_value(&seen, written, place));
                }
            }
        }
        Ok(())
    }

    /// A corner of the box of variables.
    fn point(&self, choice: usize) -> PortVariables<f64> {
        let mut seen = PortVariables::default();
        let mut next = 0;
        let mut take = |pair: [f64; 2]| {
            seen.z[next] = pair[choice >> next & 1];
            next += 1;
        };
        for port in self.card.ports {
            match port.kind {
                PortKind::Hydraulic => take(PRESSURES.map(|gauge| gauge + ATMOSPHERE)),
                PortKind::Mechanical => {
                    take(POSITIONS);
                    take(SPEEDS);
                }
            }
        }
        for state in self.card.states {
            seen.z[next] = card_unit(state.unit).to_si(state.initial);
            next += 1;
        }
        for (value, input) in seen.u.iter_mut().zip(self.card.inputs) {
            *value = card_unit(input.unit).to_si(1.0);
        }
        seen
    }

    fn without_value(&self, seen: &PortVariables<f64>, written: &Place, place: &Place) -> Complaint {
        let mut at = Vec::new();
        let mut next = 0;
        for port in self.card.ports {
            match port.kind {
                PortKind::Hydraulic => at.push(format!("{}.p = {} bar", port.name, (seen.z[next] - ATMOSPHERE) / 1e5)),
                PortKind::Mechanical => {
                    at.push(format!("{0}.x = {1} m, {0}.v = {2} m/s", port.name, seen.z[next], seen.z[next + 1]))
                }
            }
            next += port.kind.variables();
        }
        Complaint::new(Kind::Computation, format!("the formula has no value at {}", at.join(", ")))
            .at(written.clone())
            .at(place.clone())
            .help("a flow may go either way: write `root(A.p - B.p, [0.1 bar])` for a square root, keep divisors from 0 with `max`")
    }
}
