//! The law of a component that a rig file or the catalogue writes as formulas.

use super::ATMOSPHERE;
use super::card::{Card, PortKind};
use super::fluid::Fluid;
use super::own::{Flow, Own, Piston};
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
    /// What no variable changes.
    ahead: Vec<T>,
    fluid: Fluid<T>,
}

impl<T: Real> OwnLaw<T> {
    /// The law of a card that has formulas; `parameters` in the order of the card, SI.
    pub fn new(card: &'static Card, own: &'static Own, parameters: &[T], fluid: &Fluid<T>) -> Self {
        let constants: Vec<T> = parameters.iter().copied().chain([fluid.density()]).collect();
        Self { card, own, ahead: own.schedule.ahead(&constants), fluid: *fluid }
    }

    /// Answers to what is seen.
    // Most rigs have none: what is rare need not be laid out in every loop.
    #[inline(never)]
    pub fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let fill = |variables: &mut [T]| variables_of(self.card, &self.fluid, seen, variables);
        self.own.schedule.evaluate(&self.ahead, fill, |values| self.balance(values, seen, answers));
    }

    /// Flows, forces, what is stored and rates, from the values of their formulas.
    fn balance(&self, values: &mut dyn Iterator<Item = T>, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
        let mut next = || values.next().unwrap_or_else(T::zero);
        *answers = PortFlows::default();
        for Flow { from, to, .. } in &self.own.flows {
            let flow = next();
            answers.through[*from] += flow;
            answers.through[*to] -= flow;
        }
        for (port, _) in &self.own.forces {
            answers.through[*port] += next();
        }
        for Piston { port, body, speed, .. } in &self.own.pistons {
            let area = next();
            answers.through[*port] += area * seen.z[*speed];
            answers.through[*body] += area * (seen.z[self.variable(*port)] - ATMOSPHERE);
        }
        for (port, _) in &self.own.volumes {
            let pressure = seen.z[self.variable(*port)];
            answers.capacity[*port] += next() / self.fluid.bulk_modulus(pressure);
        }
        for (port, _) in &self.own.masses {
            answers.capacity[*port] += next();
        }
        for (rate, _) in answers.rate.iter_mut().zip(&self.own.rates) {
            *rate = next();
        }
    }

    /// Index of the first variable of a port.
    fn variable(&self, port: usize) -> usize {
        self.card.ports[..port].iter().map(|port| port.kind.variables()).sum()
    }
}

/// How many variables the formulas of a card see: those of its ports, states, inputs, the time among them, and the viscosity.
pub fn variables(card: &Card) -> usize {
    card.variables() + inputs(card) + 1
}

/// How many inputs the formulas of a card see, the time among them.
fn inputs(card: &Card) -> usize {
    card.inputs.len() + usize::from(card.sees_time)
}

/// Writes what formulas see that may change, pressures as gauge pressures.
fn variables_of<T: Real>(card: &Card, fluid: &Fluid<T>, seen: &PortVariables<T>, variables: &mut [T]) {
    let (at_ports, inputs) = (card.variables(), inputs(card));
    variables[..at_ports].copy_from_slice(&seen.z[..at_ports]);
    let mut first = 0;
    for port in card.ports {
        if port.kind == PortKind::Hydraulic {
            variables[first] -= T::constant(ATMOSPHERE);
        }
        first += port.kind.variables();
    }
    variables[at_ports..at_ports + inputs].copy_from_slice(&seen.u[..inputs]);
    if card.sees_viscosity {
        variables[at_ports + inputs] = fluid.viscosity() / seen.fluidity;
    }
}

/// The values that all formulas see, in their order.
pub fn values(card: &Card, own: &Own, parameters: &[f64], fluid: &Fluid<f64>, seen: &PortVariables<f64>) -> Vec<f64> {
    let mut values: Vec<f64> = parameters.iter().copied().chain([fluid.density()]).collect();
    for quantity in &own.fixed {
        values.push(quantity.evaluate(&values));
    }
    let first = values.len();
    values.resize(first + variables(card), 0.0);
    variables_of(card, fluid, seen, &mut values[first..]);
    for quantity in &own.moving {
        values.push(quantity.evaluate(&values));
    }
    values
}
