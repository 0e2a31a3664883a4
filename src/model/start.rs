//! The states at the beginning of a record.

use super::assembly::{Assembly, level_per_pressure};
use super::drive::InputSignals;
use super::layout::Layout;
use crate::numeric::Scalar;
use crate::physics::ATMOSPHERE;
use crate::physics::card::PortKind;
use crate::physics::component::facts;
use crate::physics::component::facts::Residuals;
use crate::rig::{InitialPressure, NodeKind, Quantity, Rig, Target};
use crate::units::Unit;

/// Newton steps for a component's own state to come to rest; its rate is piecewise linear or nearly so.
const REST_STEPS: usize = 30;

/// Fills `y` (states beyond the layout's are left) for all parameters of the rig, SI. The drive holds each node's first
/// measured gauge pressure, what sensors show at the start, and what to add to it.
pub fn start<S: Scalar>(
    rig: &Rig,
    layout: &Layout,
    assembly: &mut Assembly<'_, S>,
    parameters: &[S],
    drive: &InputSignals,
    t: f64,
    y: &mut [S],
) {
    for (node, state) in layout.node_state.iter().enumerate() {
        let Some(state) = *state else { continue };
        match rig.nodes[node].kind {
            NodeKind::Body { position, velocity } => {
                y[state] = S::constant(position.unwrap_or(0.0));
                y[state + 1] = S::constant(velocity);
            }
            NodeKind::Volume { initial: InitialPressure::Given(gauge) } => y[state] = S::constant(gauge + ATMOSPHERE),
            NodeKind::Volume { initial: InitialPressure::Uncertain(parameter) } => {
                y[state] = parameters[parameter] + ATMOSPHERE;
            }
            NodeKind::Volume { initial: InitialPressure::Like(other) }
                if let NodeKind::Held { parameter } = rig.nodes[other].kind =>
            {
                y[state] = parameters[parameter] + ATMOSPHERE;
            }
            NodeKind::Volume { .. } => {
                y[state] = drive.readings[node].freed(rig, parameters) + S::constant(ATMOSPHERE);
            }
            NodeKind::Held { .. } => {}
        }
    }
    for (component, own) in rig.components.iter().enumerate() {
        let first = layout.slots[component].first_state;
        for (state, (card, given)) in own.card.states.iter().zip(&own.initial).enumerate() {
            let default = Unit::parse(card.unit).map_or(card.initial, |unit| unit.to_si(card.initial));
            y[first + state] = S::constant(given.unwrap_or(default));
        }
    }
    shown(rig, layout, parameters, drive, y);
    derived(rig, layout, assembly, drive, t, y);
    for (node, state) in layout.node_state.iter().enumerate() {
        if let (Some(state), NodeKind::Volume { .. } | NodeKind::Body { .. }) = (*state, &rig.nodes[node].kind) {
            y[state] += S::constant(drive.nudges[node]);
        }
    }
    for (component, own) in rig.components.iter().enumerate() {
        for state in own.initial.iter().enumerate().filter_map(|(state, given)| given.is_none().then_some(state)) {
            let index = layout.slots[component].first_state + state;
            for _ in 0..REST_STEPS {
                let (rate, slope) = assembly.own_rate(component, state, t, y);
                if slope.re() == 0.0 || rate.re() == 0.0 {
                    break;
                }
                y[index] -= rate / slope;
            }
        }
    }
    assembly.settle_filters(t, y);
}

/// Sets what sensors show, freed of their offset and gain: a sensor that is off must not start the circuit off.
fn shown<S: Scalar>(rig: &Rig, layout: &Layout, parameters: &[S], drive: &InputSignals, y: &mut [S]) {
    for shown in &drive.shown {
        let sensor = &rig.sensors[shown.sensor];
        let (offset, gain) = (parameters[sensor.first_parameter], parameters[sensor.first_parameter + 1]);
        let value = (S::constant(shown.value) - offset) / gain;
        let node = match sensor.target {
            Target::Node(node) => node,
            Target::State(component, state) => {
                y[layout.slots[component].first_state + state] = value;
                continue;
            }
            Target::Port(..) => continue,
        };
        let Some(state) = layout.node_state[node] else { continue };
        match sensor.quantity {
            Quantity::Pressure => y[state] = value + ATMOSPHERE,
            Quantity::Level => y[state] = value / level_per_pressure(parameters[0]) + ATMOSPHERE,
            Quantity::Position => {
                y[state] = between_stops(rig, parameters, node, value);
                y[state + 1] = S::constant(shown.rate) / gain;
            }
            Quantity::Velocity | Quantity::Flow | Quantity::Force | Quantity::State => {}
        }
    }
}

/// A position shown for a body, or the end stop that it shows it beyond: stops give by micrometres, and a tenth of a millimetre of noise
/// inside one would push with tons.
fn between_stops<S: Scalar>(rig: &Rig, parameters: &[S], body: usize, position: S) -> S {
    let strokes = rig.components.iter().filter_map(|component| match facts(component.card).residuals {
        Residuals::Cylinder { stroke, .. } if component.ports.contains(&body) => {
            Some(parameters[component.first_parameter + stroke])
        }
        _ => None,
    });
    strokes.fold(position, |position, stroke| position.max(S::zero()).min(stroke))
}

/// Sets the pressures that follow from others where no sensor shows them.
fn derived<S: Scalar>(
    rig: &Rig,
    layout: &Layout,
    assembly: &mut Assembly<'_, S>,
    drive: &InputSignals,
    t: f64,
    y: &mut [S],
) {
    alike(rig, layout, drive, y);
    for node in 0..rig.nodes.len() {
        if let (Some(state), NodeKind::Volume { initial: InitialPressure::Balance }, None) =
            (layout.node_state[node], &rig.nodes[node].kind, drive.shown_at(rig, node))
        {
            balance(rig, layout, assembly, node, state, t, y);
        }
    }
    // Once more: some are like what has only now been balanced.
    alike(rig, layout, drive, y);
}

/// Copies the pressures of nodes that start like another.
fn alike<S: Scalar>(rig: &Rig, layout: &Layout, drive: &InputSignals, y: &mut [S]) {
    for node in 0..rig.nodes.len() {
        if let (Some(state), NodeKind::Volume { initial: InitialPressure::Like(other) }, None) =
            (layout.node_state[node], &rig.nodes[node].kind, drive.shown_at(rig, node))
            && let Some(other) = layout.node_state[*other]
        {
            y[state] = y[other];
        }
    }
}

/// Sets a pressure so that the body it acts on stays at rest: forces are linear in pressures, so one secant is exact.
fn balance<S: Scalar>(
    rig: &Rig,
    layout: &Layout,
    assembly: &mut Assembly<'_, S>,
    node: usize,
    state: usize,
    t: f64,
    y: &mut [S],
) {
    let bodies = rig.components.iter().filter(|component| component.ports.contains(&node)).flat_map(|component| {
        component
            .card
            .ports
            .iter()
            .zip(&component.ports)
            .filter(|(port, _)| port.kind == PortKind::Mechanical)
            .map(|(_, &body)| body)
    });
    for body in bodies {
        let Some(position) = layout.node_state[body] else { continue };
        const PROBE: f64 = 1e5;
        y[state] = S::constant(ATMOSPHERE);
        let at_zero = assembly.force(position + 1, t, y);
        y[state] = S::constant(ATMOSPHERE + PROBE);
        let slope = (assembly.force(position + 1, t, y) - at_zero) / PROBE;
        y[state] = if slope.re() == 0.0 {
            S::constant(ATMOSPHERE)
        } else {
            // A chamber cannot pull: a load that would need it rests on the end stop instead.
            (S::constant(ATMOSPHERE) - at_zero / slope).max(S::constant(ATMOSPHERE))
        };
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::model::Shown;
    use crate::model::assembly::Inputs;

    const RIG: &str = "fixtures/telescopic/rig.toml";
    const LINE: &str = "[effects]\n\"line-resistance@B\" = { turbulent = \"0.04 bar.min2/L2\" }\n";
    const SHOWN: [(&str, f64); 2] = [("p_B", 7e5), ("x", 0.1)];

    /// The telescopic rig with a line to the rod side, before anything moves: its states where sensors show `SHOWN`, the state of
    /// a node, and the force on its piston.
    fn started(node: &str) -> (Vec<f64>, usize, f64) {
        started_where(node, SHOWN)
    }

    fn started_where(node: &str, shown: [(&str, f64); 2]) -> (Vec<f64>, usize, f64) {
        let rig = Rig::parse(RIG, fs::read_to_string(RIG).unwrap() + LINE).unwrap();
        let layout = Layout::of(&rig);
        let parameters = rig.nominal();
        let mut assembly = Assembly::new(&rig, &layout, &parameters);
        let inputs = vec![0.0; layout.clock + 1];
        assembly.inputs = Inputs { from: inputs.clone(), slope: inputs, start: 0.0 };
        let mut drive = InputSignals::from_cycle(&rig, rig.cycle.as_ref().unwrap());
        let sensor = |name: &str| rig.sensors.iter().position(|sensor| sensor.name == name).unwrap();
        drive.shown = shown.map(|(name, value)| Shown { sensor: sensor(name), value, sigma: 0.0, rate: 0.0 }).to_vec();
        let mut y = vec![0.0; layout.states];
        start(&rig, &layout, &mut assembly, &parameters, &drive, 0.0, &mut y);
        let state =
            |name: &str| layout.node_state[rig.nodes.iter().position(|node| node.name == name).unwrap()].unwrap();
        let force = assembly.force(state("piston") + 1, 0.0, &y);
        (y, state(node), force)
    }

    #[test]
    fn a_chamber_in_balance_holds_against_what_the_sensors_show() {
        let (y, chamber, force) = started("A");
        assert!(y[chamber] > ATMOSPHERE + 1e5, "{}", y[chamber]);
        // Of 7 bar on the rod side, some 500 N.
        assert!(force.abs() < 1e-6, "{force} N");
    }

    #[test]
    fn a_body_shown_inside_an_end_stop_by_noise_starts_at_it() {
        // 0.2 mm inside, a stop of 50 N/um pushes with 10 kN: five hundred bar of a chamber in balance.
        let (y, piston, force) = started_where("piston", [("p_B", 7e5), ("x", -2e-4)]);
        assert_eq!(y[piston], 0.0);
        let (free, ..) = started("A");
        let (at_stop, chamber, _) = started_where("A", [("p_B", 7e5), ("x", -2e-4)]);
        approx::assert_relative_eq!(at_stop[chamber], free[chamber], max_relative = 1e-3);
        assert!(force.abs() < 1e-6, "{force} N");
    }

    #[test]
    fn a_pressure_like_another_is_like_what_the_sensor_of_that_shows() {
        let (y, beyond, _) = started("B beyond line-resistance@B");
        assert_eq!(y[beyond], ATMOSPHERE + SHOWN[0].1);
    }
}
