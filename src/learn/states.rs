//! The states that a record visits, along the axis of a curve without a formula.

use super::highest::readings;
use crate::model::InputSignals;
use crate::physics::card::PortKind;
use crate::physics::effect::spline::HEIGHTS;
use crate::rig::{EffectInstance, Location, Quantity, Rig, Target};
use crate::units::Unit;

/// Pieces of the axis in which it is counted how long the record stays.
const PIECES: usize = 40;
/// Rows that a piece needs for a curve to be drawn there, as a share of those that it would have if the record spent the same time in each:
/// what is only passed while a valve switches is filled in by the prior of the bend, not by the record.
const STAYS: f64 = 0.1;

/// The axis of the curve that was given last.
pub(super) struct Axis {
    /// In `unit`.
    length: f64,
    both_sides: bool,
    pub unit: Unit,
    pub quantity: Quantity,
}

impl Axis {
    pub fn of(rig: &Rig, quantity: Quantity, both_sides: bool) -> Option<Self> {
        let joined = rig.components.last()?;
        let length = rig.parameters.get(joined.first_parameter + HEIGHTS)?;
        let unit = length.unit.clone();
        Some(Self { length: unit.from_si(length.value), both_sides, unit, quantity })
    }

    /// Where on the axis the state stands at each row; `None` where the model cannot be solved.
    pub fn shares(
        &self,
        rig: &Rig,
        values: &[f64],
        drive: (&InputSignals, &[f64]),
        placed: &EffectInstance,
    ) -> Option<Vec<f64>> {
        let node = match placed.spot {
            Location::Node(node) => node,
            Location::Component(component) => {
                let component = &rig.components[component];
                let mut ports = component.card.ports.iter().zip(&component.ports);
                *ports.find(|(port, _)| port.kind == PortKind::Mechanical)?.1
            }
            _ => return None,
        };
        let share = |si: f64| self.unit.from_si(si) / self.length;
        let share = |si: f64| if self.both_sides { 0.5 * (share(si) + 1.0) } else { share(si) };
        let shown = readings(rig, values, drive, &[(Target::Node(node), self.quantity)])?;
        Some(shown.into_iter().flatten().map(share).collect())
    }

    /// The state at a share of it, in its unit.
    pub fn at(&self, share: f64) -> f64 {
        if self.both_sides { self.length * (2.0 * share - 1.0) } else { self.length * share }
    }
}

/// The piece of the axis that a share of it lies in.
pub(super) fn piece(share: f64) -> usize {
    ((share * PIECES as f64) as usize).min(PIECES - 1)
}

/// In which pieces of the axis a record stays, by the share of the axis at each of its rows.
pub(super) fn stays(shares: &[f64]) -> [bool; PIECES] {
    let mut rows = [0; PIECES];
    let within = shares.iter().filter(|share| (0.0..=1.0).contains(*share));
    within.for_each(|share| rows[piece(*share)] += 1);
    let least = STAYS * shares.len() as f64 / PIECES as f64;
    rows.map(|rows| f64::from(rows) >= least.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_of_two_speeds_stays_at_two_places_and_a_sweep_everywhere() {
        // 20 rows while the valve switches, 490 at either speed.
        let switching = (0..20).map(|row| 0.2 + 0.03 * f64::from(row));
        let two: Vec<f64> = [0.2; 490].into_iter().chain(switching).chain([0.8; 490]).collect();
        let at: Vec<usize> = (0..PIECES).filter(|&piece| stays(&two)[piece]).collect();
        assert_eq!(at, [piece(0.2), piece(0.8)]);
        // Even where the piston rests at the end for most of the time.
        let sweep = (0..200).map(|row| f64::from(row) / 200.0).chain([1.0; 800]);
        assert_eq!(stays(&sweep.collect::<Vec<_>>()), [true; PIECES]);
        // What lies beyond the axis is no state of the picture.
        assert_eq!(stays(&[-0.5, 1.5]), [false; PIECES]);
    }
}
