//! What an effect adds to a circuit: the flow or the force of its law, at the states of a run.

use super::highest::readings;
use crate::model::InputSignals;
use crate::physics::ATMOSPHERE;
use crate::physics::card::PortKind;
use crate::physics::component::AnyLaw;
use crate::physics::effect::Form;
use crate::physics::fluid::{self, Fluid};
use crate::physics::ports::{PortFlows, PortVariables};
use crate::rig::{InstalledEffect, Location, Quantity, Rig, Target};

/// What an effect adds at the ports of a component.
pub(crate) struct Acting {
    /// The component of the rig that has the law.
    pub component: usize,
    with: AnyLaw<f64>,
    /// The component as it is without the effect; `None` where the effect has joined it to the rig.
    without: Option<AnyLaw<f64>>,
}

impl Acting {
    /// Of an effect of a rig with all of its values, SI; `nominal` are those of the rig without it. `None` of one that is no law of a
    /// component's ports: what sensors do, the fluid, what depends on inputs.
    pub fn of(rig: &Rig, values: &[f64], nominal: &[f64], effect: &InstalledEffect) -> Option<Self> {
        let joined = || rig.components.iter().position(|component| component.name == effect.id);
        let (component, changes) = match (effect.placed.effect.form, effect.placed.spot) {
            (Form::Shunt { .. } | Form::Series { .. }, _) => (joined()?, false),
            (Form::ParameterChange, Location::Component(component)) => (component, true),
            _ => return None,
        };
        let own = &rig.components[component];
        if !own.card.inputs.is_empty() {
            return None;
        }
        let law = |values: &[f64]| own.law(|index| values[index], &fluid_of(values));
        let without = || {
            let mut values = values.to_vec();
            effect.parameters.iter().for_each(|&index| values[index] = nominal[index]);
            law(&values)
        };
        let without = if changes { Some(without()?) } else { None };
        Some(Self { component, with: law(values)?, without })
    }

    /// Flow into a port, m³/s, or force on its body, N, that the effect adds.
    pub fn through(&self, seen: &PortVariables<f64>, port: usize) -> f64 {
        let at = |law: &AnyLaw<f64>| answers(law, seen).through[port];
        at(&self.with) - self.without.as_ref().map_or(0.0, at)
    }
}

/// The fluid of a rig with all of its values, SI.
pub(super) fn fluid_of(values: &[f64]) -> Fluid<f64> {
    Fluid::new(&values[..fluid::CARD.parameters.len()])
}

/// What a law answers.
pub(super) fn answers(law: &AnyLaw<f64>, seen: &PortVariables<f64>) -> PortFlows<f64> {
    let mut answers = PortFlows::default();
    law.evaluate(seen, &mut answers);
    answers
}

/// The ports of a component with the nodes that they meet, and how many states it has.
pub(crate) struct Ports {
    pub nodes: Vec<(PortKind, usize)>,
    component: usize,
    states: usize,
}

impl Ports {
    pub fn of(rig: &Rig, component: usize) -> Self {
        let own = &rig.components[component];
        let nodes = own.card.ports.iter().map(|port| port.kind).zip(own.ports.iter().copied()).collect();
        Self { nodes, component, states: own.card.states.len() }
    }

    /// What each of its variables is, in the order of [`PortVariables::z`], states left out.
    pub fn variables(&self) -> Vec<(usize, Quantity)> {
        let of = |&(kind, node): &(PortKind, usize)| match kind {
            PortKind::Hydraulic => vec![(node, Quantity::Pressure)],
            PortKind::Mechanical => vec![(node, Quantity::Position), (node, Quantity::Velocity)],
        };
        self.nodes.iter().flat_map(of).collect()
    }

    /// What it sees at each row of a run of a rig with all of its values, SI, the fluid at its temperature of reference; `None` where
    /// the model cannot be solved.
    pub fn seen(&self, rig: &Rig, values: &[f64], drive: (&InputSignals, &[f64])) -> Option<Vec<PortVariables<f64>>> {
        let own = (0..self.states).map(|state| (Target::State(self.component, state), Quantity::State));
        let nodes = self.variables().into_iter().map(|(node, quantity)| (Target::Node(node), quantity));
        let watched: Vec<(Target, Quantity)> = nodes.chain(own).collect();
        let columns = readings(rig, values, drive, &watched)?;
        let row = |row: usize| {
            let mut seen = PortVariables::default();
            for ((slot, column), (_, quantity)) in seen.z.iter_mut().zip(&columns).zip(&watched) {
                *slot = column[row] + if *quantity == Quantity::Pressure { ATMOSPHERE } else { 0.0 };
            }
            seen
        };
        Some((0..drive.1.len()).map(row).collect())
    }
}

/// Share of the sum of squares of values that a state determines, by how far neighbours along it differ (von Neumann, Annals of
/// Mathematical Statistics 12 (1941) 367): 1 where they depend on it alone, or are one value; 0 of a state that stands still.
pub(crate) fn determined(state: &[f64], values: &[f64]) -> f64 {
    let mut pairs: Vec<(f64, f64)> =
        state.iter().copied().zip(values.iter().copied()).filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    // By value where states are equal: in the order of time neighbours would be alike whatever they depend on.
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let all: f64 = pairs.iter().map(|pair| pair.1 * pair.1).sum();
    let (mut apart, mut states) = (0.0, 0);
    for same in pairs.chunk_by(|a, b| a.0 == b.0) {
        let mean = same.iter().map(|pair| pair.1).sum::<f64>() / same.len() as f64;
        apart += same.iter().map(|pair| (pair.1 - mean).powi(2)).sum::<f64>();
        states += 1;
    }
    apart +=
        pairs.windows(2).filter(|two| two[0].0 < two[1].0).map(|two| 0.5 * (two[1].1 - two[0].1).powi(2)).sum::<f64>();
    if all > 0.0 && states > 1 { (1.0 - apart / all).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_adds_the_force_of_its_law_and_a_changed_parameter_the_difference() {
        let mut rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let nominal = rig.nominal();
        for id in ["seal-friction@cylinder", "viscous-friction@cylinder"] {
            let placed = rig.placed(id).unwrap();
            rig.give_effect(&placed, &[]).unwrap();
        }
        let mut values = rig.nominal();
        values[rig.parameter("seal-friction@cylinder.coulomb").unwrap()] = 420.0;
        values[rig.parameter("cylinder.viscous_friction").unwrap()] += 1000.0;
        let seen = |ports: &Ports| {
            let at = |quantity| ports.variables().iter().position(|variable| variable.1 == quantity).unwrap();
            let mut seen = PortVariables::default();
            seen.z[at(Quantity::Velocity)] = 0.1;
            seen
        };
        for (effect, newton) in rig.effects.iter().zip([-420.0, -100.0]) {
            let acting = Acting::of(&rig, &values, &nominal, effect).unwrap();
            let ports = Ports::of(&rig, acting.component);
            let body = ports.nodes.iter().position(|port| port.0 == PortKind::Mechanical).unwrap();
            // The transition of dry friction takes 0.005 % of it at this speed.
            approx::assert_relative_eq!(acting.through(&seen(&ports), body), newton, max_relative = 1e-3);
        }
    }

    #[test]
    fn a_state_determines_what_depends_on_it_alone() {
        let state: Vec<f64> = (0..4000).map(f64::from).collect();
        let noise = |row: usize| if row.is_multiple_of(2) { 1.0 } else { -1.0 };
        let step: Vec<f64> = state.iter().map(|x| (x - 2000.0).signum()).collect();
        let other: Vec<f64> = (0..4000).map(noise).collect();
        assert!(determined(&state, &step) > 0.99);
        assert!(determined(&state, &other) < 0.01);
        approx::assert_relative_eq!(determined(&state, &[3.0; 4000]), 1.0, max_relative = 1e-12);
        // What stands still determines nothing.
        let wave: Vec<f64> = state.iter().map(|x| (x * std::f64::consts::TAU / 1000.0).sin()).collect();
        assert_eq!(determined(&[0.0; 4000], &wave), 0.0);
        let two: Vec<f64> = state.iter().map(|x| x % 2.0).collect();
        assert!(determined(&two, &wave) < 0.01);
    }
}
