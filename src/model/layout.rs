//! Who meets whom: the states of a rig and how components reach them. No numbers of the circuit.

use std::sync::Arc;

use super::slot::{Slot, Variable};
use super::wiring::Wiring;
use crate::numeric::{Elimination, WHOLE};
use crate::physics::ports::{INPUTS, PORTS, VARIABLES};
use crate::rig::{NodeKind, Quantity, Rig, Target};

/// One balance: `rate of state = sign * sum of through / sum of capacity`.
#[derive(Debug, Clone, Copy)]
pub struct Balance {
    pub state: usize,
    pub sign: f64,
}

/// A state that follows a raw measurement with a lag.
#[derive(Debug, Clone, Copy)]
pub struct Filter {
    pub state: usize,
    pub sensor: usize,
    pub lag: f64,
}

/// Where the raw value of a sensor comes from.
#[derive(Debug, Clone, Copy)]
pub enum Raw {
    /// Gauge pressure of this state.
    Pressure(usize),
    HeldPressure(usize),
    /// Level over this state, per pressure by the fluid's density.
    Level(usize),
    State(usize),
    /// What [`Layout::flows`] of the sensor add up to, times this sign.
    Through(f64),
}

#[derive(Debug, Clone)]
pub struct Layout {
    pub states: usize,
    /// Typical magnitude of each state, SI.
    pub scales: Vec<f64>,
    pub names: Vec<String>,
    pub slots: Vec<Slot>,
    pub balances: Vec<Balance>,
    /// Position and velocity of each body.
    pub bodies: Vec<(usize, usize)>,
    /// First state of each node; `None` for a held one.
    pub node_state: Vec<Option<usize>>,
    pub filters: Vec<Filter>,
    pub raw: Vec<Raw>,
    /// Of each sensor of a flow the components and ports whose flows it reads together.
    pub flows: Vec<Vec<(usize, usize)>>,
    /// Index among the inputs of how much warmer the fluid is than its temperature of reference, K, where that is measured.
    pub temperature: Option<usize>,
    /// Index among the inputs of the time since the run began, s: the last.
    pub clock: usize,
    /// State that each sensor reads, where it has a lag.
    pub filtered: Vec<Option<usize>>,
    /// Components of which a sensor without a lag reads a flow.
    pub shown: Vec<usize>,
    pub wiring: Wiring,
    /// Along which pattern the equations of a step are eliminated, where there are enough states for that.
    pub elimination: Option<Arc<Elimination>>,
}

/// Typical magnitudes for the integrator's absolute tolerance: 100 bar, 10 mm, 0.1 m/s.
const PRESSURE: f64 = 1e7;
const POSITION: f64 = 1e-2;
const VELOCITY: f64 = 0.1;
const FLOW: f64 = 1e-4;
const FORCE: f64 = 1e3;

impl Layout {
    /// The layout of a checked rig.
    pub fn of(rig: &Rig) -> Self {
        let mut layout = Layout {
            states: 0,
            scales: Vec::new(),
            names: Vec::new(),
            slots: Vec::new(),
            balances: Vec::new(),
            bodies: Vec::new(),
            node_state: Vec::new(),
            filters: Vec::new(),
            raw: Vec::new(),
            temperature: rig.temperature.as_ref().map(|_| rig.inputs.len()),
            clock: rig.inputs.len() + usize::from(rig.temperature.is_some()),
            filtered: Vec::new(),
            flows: Vec::new(),
            shown: Vec::new(),
            wiring: Wiring::default(),
            elimination: None,
        };
        let mut node_balance = Vec::new();
        for (index, node) in rig.nodes.iter().enumerate() {
            let (state, balance) = match node.kind {
                NodeKind::Held { .. } => (None, None),
                NodeKind::Volume { .. } => {
                    let joined = rig.components.iter().filter(|component| component.ports.contains(&index));
                    let scale = joined.map(|component| component.card.pressure_scale).fold(PRESSURE, f64::min);
                    let state = layout.push(format!("pressure of {}", node.name), scale);
                    layout.balances.push(Balance { state, sign: -1.0 });
                    (Some(state), Some(layout.balances.len() - 1))
                }
                NodeKind::Body { .. } => {
                    let position = layout.push(format!("position of {}", node.name), POSITION);
                    let velocity = layout.push(format!("velocity of {}", node.name), VELOCITY);
                    layout.bodies.push((position, velocity));
                    layout.balances.push(Balance { state: velocity, sign: 1.0 });
                    (Some(position), Some(layout.balances.len() - 1))
                }
            };
            layout.node_state.push(state);
            node_balance.push(balance);
        }
        for component in &rig.components {
            let mut slot = Slot {
                variables: [Variable::Unused; VARIABLES],
                inputs: [None; INPUTS],
                balances: [None; PORTS],
                ports: component.card.ports.len(),
                first_state: layout.states,
                states: component.card.states.len(),
            };
            let mut seen = Vec::new();
            for (index, (port, &node)) in component.card.ports.iter().zip(&component.ports).enumerate() {
                match (layout.node_state[node], &rig.nodes[node].kind) {
                    (Some(state), _) => seen.extend((0..port.kind.variables()).map(|k| Variable::State(state + k))),
                    (None, NodeKind::Held { parameter }) => seen.push(Variable::Held(*parameter)),
                    (None, _) => {}
                }
                slot.balances[index] = node_balance[node];
            }
            for state in component.card.states {
                let scale = crate::units::Unit::parse(state.unit).map_or(1.0, |unit| unit.factor);
                seen.push(Variable::State(
                    layout.push(format!("{} of {}", state.name, component.name), state.scale * scale),
                ));
            }
            slot.variables[..seen.len()].copy_from_slice(&seen);
            let clock = component.card.sees_time.then_some(layout.clock);
            for (own, input) in slot.inputs.iter_mut().zip(component.inputs.iter().copied().chain(clock)) {
                *own = Some(input);
            }
            layout.slots.push(slot);
        }
        for (index, sensor) in rig.sensors.iter().enumerate() {
            let raw = layout.raw_of(rig, sensor);
            layout.raw.push(raw);
            let state = (sensor.lag > 0.0).then(|| {
                let scale = match (sensor.quantity, raw) {
                    (_, Raw::State(state)) => layout.scales[state],
                    (Quantity::Flow, _) => FLOW,
                    (Quantity::Force, _) => FORCE,
                    (Quantity::Position | Quantity::Level, _) => POSITION,
                    _ => PRESSURE,
                };
                let state = layout.push(format!("reading of {}", sensor.name), scale);
                layout.filters.push(Filter { state, sensor: index, lag: sensor.lag });
                state
            });
            let flows = match sensor.target {
                Target::Port(component, port) => rig.metered(component, port),
                _ => Vec::new(),
            };
            if state.is_none() {
                for &(component, _) in &flows {
                    if !layout.shown.contains(&component) {
                        layout.shown.push(component);
                    }
                }
            }
            layout.flows.push(flows);
            layout.filtered.push(state);
        }
        layout.wiring = Wiring::of(&layout.slots, layout.states, layout.clock);
        if layout.states > WHOLE {
            layout.elimination = Some(Arc::new(Elimination::of(layout.states, layout.dependencies())));
        }
        layout
    }

    /// Which state's rate depends on which state.
    fn dependencies(&self) -> Vec<(usize, usize)> {
        let mut found = self.bodies.clone();
        for slot in &self.slots {
            let balances = slot.balances.iter().flatten().map(|&balance| self.balances[balance].state);
            let rows = balances.chain(slot.first_state..slot.first_state + slot.states);
            found.extend(rows.flat_map(|row| slot.states_seen().map(move |column| (row, column))));
        }
        for filter in &self.filters {
            match self.raw[filter.sensor] {
                Raw::Pressure(state) | Raw::Level(state) | Raw::State(state) => found.push((filter.state, state)),
                Raw::Through(_) => {
                    let seen = |&(component, _): &(usize, usize)| self.slots[component].states_seen();
                    found.extend(self.flows[filter.sensor].iter().flat_map(seen).map(|column| (filter.state, column)));
                }
                Raw::HeldPressure(_) => {}
            }
        }
        found
    }

    fn push(&mut self, name: String, scale: f64) -> usize {
        self.names.push(name);
        self.scales.push(scale);
        self.states += 1;
        self.states - 1
    }

    fn raw_of(&self, rig: &Rig, sensor: &crate::rig::Sensor) -> Raw {
        match sensor.target {
            Target::Port(..) => Raw::Through(sensor.sign),
            Target::State(component, state) => Raw::State(self.slots[component].first_state + state),
            Target::Node(node) => match (self.node_state[node], &rig.nodes[node].kind, sensor.quantity) {
                (None, NodeKind::Held { parameter }, _) => Raw::HeldPressure(*parameter),
                (Some(state), _, Quantity::Pressure) => Raw::Pressure(state),
                (Some(state), _, Quantity::Level) => Raw::Level(state),
                (Some(state), _, Quantity::Velocity) => Raw::State(state + 1),
                (state, _, _) => Raw::State(state.unwrap_or(0)),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_counts_the_states_of_its_equations() {
        for name in ["telescopic", "press", "two_tanks", "cascaded_tanks"] {
            let mut rig = Rig::read(format!("fixtures/{name}/rig.toml")).unwrap();
            assert_eq!(Layout::of(&rig).states, rig.states(), "{name}");
            rig.sensors[0].lag = 1e-3;
            assert_eq!(Layout::of(&rig).states, rig.states(), "{name}, with a sensor that lags");
        }
    }
}
