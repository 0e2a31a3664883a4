//! The law of a component that a rig file or the catalogue writes as formulas.

use super::ATMOSPHERE;
use super::card::{Card, PortKind};
use super::fluid::Fluid;
use super::own::{Flow, MOST_VALUES, Own, Piston};
use super::ports::{PortFlows, PortVariables};
use crate::numeric::Real;

/// The law of a component of formulas for one number type.
///
/// What leaves one port by a [`Flow`] enters another in the same amount. A [`Piston`] takes up as much power at its port as it
/// gives to its body. Worked: a piston of 1e-3 m² under 50 bar pushes with 5000 N, and takes 1e-4 m³/s at 0.1 m/s.
#[derive(Debug, Clone)]
pub struct OwnLaw<T> {
    card: &'static Card,
    own: &'static Own,
    /// The values that no state changes: parameters, density, fixed quantities.
    constant: Vec<T>,
    fluid: Fluid<T>,
}

impl<T: Real> OwnLaw<T> {
    /// The law of a card that has formulas; `parameters` in the order of the card, SI.
    pub fn new(card: &'static Card, own: &'static Own, parameters: &[T], fluid: &Fluid<T>) -> Self {
        let mut constant: Vec<T> = parameters.iter().copied().chain([fluid.density()]).collect();
        for quantity in &own.fixed {
            let value = quantity.evaluate(&constant);
            constant.push(value);
        }
        Self { card, own, constant, fluid: *fluid }
    }

    /// Answers to what is seen.
    // Most rigs have none: what is rare need not be laid out in every loop.
    #[inline(never)]
    pub fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let count = self.constant.len() + self.card.variables() + self.inputs() + 1 + self.own.moving.len();
        // Clearing 64 dual numbers would cost more than most laws.
        match count {
            0..=16 => self.balance(&self.fill::<16>(seen), seen, answers),
            17..=32 => self.balance(&self.fill::<32>(seen), seen, answers),
            _ => self.balance(&self.fill::<MOST_VALUES>(seen), seen, answers),
        }
    }

    /// The values that the formulas see, in their order; zeros behind them.
    pub fn values(&self, seen: &PortVariables<T>) -> [T; MOST_VALUES] {
        self.fill(seen)
    }

    fn fill<const N: usize>(&self, seen: &PortVariables<T>) -> [T; N] {
        let mut values = [T::zero(); N];
        let mut count = self.constant.len();
        values[..count].copy_from_slice(&self.constant);
        let variables = self.card.variables();
        values[count..count + variables].copy_from_slice(&seen.z[..variables]);
        for port in self.card.ports {
            if port.kind == PortKind::Hydraulic {
                values[count] -= T::constant(ATMOSPHERE);
            }
            count += port.kind.variables();
        }
        count += self.card.states.len();
        let inputs = self.inputs();
        values[count..count + inputs].copy_from_slice(&seen.u[..inputs]);
        count += inputs;
        values[count] = self.fluid.viscosity() / seen.fluidity;
        count += 1;
        for quantity in &self.own.moving {
            values[count] = quantity.evaluate(&values);
            count += 1;
        }
        values
    }

    /// How many inputs its formulas see, the time among them.
    fn inputs(&self) -> usize {
        self.card.inputs.len() + usize::from(self.card.sees_time)
    }

    /// Flows, forces, what is stored and rates, from all values.
    fn balance(&self, values: &[T], seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        *answers = PortFlows::default();
        for Flow { from, to, formula } in &self.own.flows {
            let flow = formula.evaluate(values);
            answers.through[*from] += flow;
            answers.through[*to] -= flow;
        }
        for (port, formula) in &self.own.forces {
            answers.through[*port] += formula.evaluate(values);
        }
        for Piston { port, body, speed, area } in &self.own.pistons {
            let area = area.evaluate(values);
            answers.through[*port] += area * seen.z[*speed];
            answers.through[*body] += area * (seen.z[self.variable(*port)] - ATMOSPHERE);
        }
        for (port, volume) in &self.own.volumes {
            let pressure = seen.z[self.variable(*port)];
            answers.capacity[*port] += volume.evaluate(values) / self.fluid.bulk_modulus(pressure);
        }
        for (port, mass) in &self.own.masses {
            answers.capacity[*port] += mass.evaluate(values);
        }
        for (rate, formula) in answers.rate.iter_mut().zip(&self.own.rates) {
            *rate = formula.evaluate(values);
        }
    }

    /// Index of the first variable of a port.
    fn variable(&self, port: usize) -> usize {
        self.card.ports[..port].iter().map(|port| port.kind.variables()).sum()
    }
}
