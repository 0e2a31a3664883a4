//! The law of an effect that a user has written: a formula over what it sees.

use super::ATMOSPHERE;
use super::card::{Card, PortKind};
use super::ports::{INPUTS, PortFlows, PortVariables, VARIABLES};
use crate::expression::Expression;
use crate::numeric::Real;

/// Most parameters of a formula.
pub const MOST_PARAMETERS: usize = 8;

/// A formula with values for its parameters.
///
/// Its names are the variables of the card's ports, in their order (gauge pressure of a hydraulic port, Pa; position, m, and
/// speed, m/s, of a mechanical one), then the inputs of the card and, where it sees it, the time since the run began, s, then
/// its parameters. The value is the flow out of the node at the first port into the second (m³/s), or the force on the body at
/// the first port (N). Worked: `G * A.p` with 1e-12 m³/s/Pa takes 5e-6 m³/s at 50 bar.
#[derive(Debug, Clone)]
pub struct Formula<T> {
    card: &'static Card,
    expression: &'static Expression,
    parameters: [T; MOST_PARAMETERS],
}

impl<T: Real> Formula<T> {
    /// The law of a card that has a formula; `parameters` in the order of the card, SI.
    pub fn new(card: &'static Card, parameters: &[T]) -> Option<Self> {
        let expression = card.formula?;
        let mut own = [T::zero(); MOST_PARAMETERS];
        own.get_mut(..parameters.len())?.copy_from_slice(parameters);
        Some(Self { card, expression, parameters: own })
    }

    /// What the formula gives where what it sees has these values, SI; at most as many as a component sees.
    pub fn at(&self, seen: &[T]) -> T {
        let mut values = [T::zero(); VARIABLES + INPUTS + MOST_PARAMETERS];
        values[..seen.len()].copy_from_slice(seen);
        values[seen.len()..][..MOST_PARAMETERS].copy_from_slice(&self.parameters);
        self.expression.evaluate(&values)
    }

    #[inline(never)]
    pub fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let mut values = [T::zero(); VARIABLES + INPUTS];
        let mut count = 0;
        for port in self.card.ports {
            for _ in 0..port.kind.variables() {
                let absolute = port.kind == PortKind::Hydraulic;
                values[count] = if absolute { seen.z[count] - ATMOSPHERE } else { seen.z[count] };
                count += 1;
            }
        }
        let inputs = self.card.inputs.len() + usize::from(self.card.sees_time);
        values[count..count + inputs].copy_from_slice(&seen.u[..inputs]);
        let value = self.at(&values[..count + inputs]);
        answers.through[0] = value;
        if self.card.ports.first().is_some_and(|port| port.kind == PortKind::Hydraulic) {
            answers.through[1] = -value;
        }
    }
}

/// What a formula makes of the readings of a sensor, in place: its names are the reading, the time since the run began (at
/// `begun`, s) and the parameters, SI.
pub fn read<T: Real>(expression: &Expression, parameters: &[T], begun: f64, times: &[f64], readings: &mut [T]) {
    let mut values = vec![T::zero(); 2 + parameters.len()];
    values[2..].copy_from_slice(parameters);
    for (reading, t) in readings.iter_mut().zip(times) {
        (values[0], values[1]) = (*reading, T::constant(t - begun));
        *reading = expression.evaluate(&values);
    }
}
