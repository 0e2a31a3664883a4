//! The structure of a rig, read off its circuit.

use super::Structure;
use super::probe::{Dependence, probe};
use crate::physics::card::PortKind;
use crate::rig::{NodeKind, Quantity, Rig, Target};

/// What a node has in the structure.
#[derive(Clone, Copy)]
enum Place {
    /// Pressure, and its derivative where the node is a volume.
    Pressure {
        value: usize,
        rate: Option<usize>,
    },
    Body {
        position: usize,
        velocity: usize,
        acceleration: usize,
    },
}

/// The structural model of a rig with its sensors.
///
/// Per volume: a balance of the flows into its components with `C p'`. Per body: Newton's law, and the velocity as the
/// derivative of the position. Per port: the law of its flow or force. Per state of a component: the law of its rate.
/// Each derivative is an unknown, tied to what it is the derivative of by an equation of its own. Per sensor: one
/// equation; a known lag adds as many equations as unknowns and changes nothing, so it is left out. Inputs are known. A
/// fault enters every equation whose answer depends on its parameter at some point, a sensor's offset and gain that
/// sensor's equation.
pub fn from_rig(rig: &Rig) -> Structure {
    let mut structure = Structure {
        knowns: rig.inputs.iter().map(|input| input.name.clone()).collect(),
        faults: (0..rig.faults.len()).map(|fault| rig.fault_id(fault).to_owned()).collect(),
        ..Structure::default()
    };
    let faults_of = |parameter: usize| -> Vec<usize> {
        (0..rig.faults.len()).filter(|&fault| rig.faults[fault].parameter == parameter).collect()
    };
    let places: Vec<Place> = rig
        .nodes
        .iter()
        .map(|node| {
            let name = &node.name;
            let derivative = |structure: &mut Structure, what: &str, of: usize, held: usize| {
                let index = structure.equation(format!("{what} of {name} by time"), &[of, held], &[]);
                structure.equations[index].differential = true;
            };
            match node.kind {
                NodeKind::Held { parameter } => {
                    let value = structure.unknown(format!("pressure of {name}"), true);
                    structure.equation(format!("pressure of {name}"), &[value], &faults_of(parameter));
                    Place::Pressure { value, rate: None }
                }
                NodeKind::Volume { .. } => {
                    let value = structure.unknown(format!("pressure of {name}"), true);
                    let rate = structure.unknown(format!("rate of pressure of {name}"), false);
                    derivative(&mut structure, "pressure", value, rate);
                    Place::Pressure { value, rate: Some(rate) }
                }
                NodeKind::Body { .. } => {
                    let position = structure.unknown(format!("position of {name}"), true);
                    let velocity = structure.unknown(format!("velocity of {name}"), true);
                    let acceleration = structure.unknown(format!("acceleration of {name}"), false);
                    derivative(&mut structure, "position", position, velocity);
                    derivative(&mut structure, "velocity", velocity, acceleration);
                    Place::Body { position, velocity, acceleration }
                }
            }
        })
        .collect();
    let asked: Vec<(usize, (f64, f64))> = rig.faults.iter().map(|fault| (fault.parameter, fault.bounds)).collect();
    // Unknowns and faults of each node's balance.
    let mut balances = vec![(Vec::new(), Vec::new()); rig.nodes.len()];
    let mut flows = Vec::new();
    let mut states = Vec::new();
    for (index, component) in rig.parts() {
        let name = &component.name;
        let found = probe(rig, component, &asked);
        let mut variables = Vec::new();
        for &node in &component.ports {
            match places[node] {
                Place::Pressure { value, .. } => variables.push(value),
                Place::Body { position, velocity, .. } => variables.extend([position, velocity]),
            }
        }
        let mut rates = Vec::new();
        let mut own_states = Vec::new();
        for state in component.card.states {
            let value = structure.unknown(format!("{} of {name}", state.name), false);
            own_states.push(value);
            let rate = structure.unknown(format!("rate of {} of {name}", state.name), false);
            let equation = structure.equation(format!("{} of {name} by time", state.name), &[value, rate], &[]);
            structure.equations[equation].differential = true;
            variables.push(value);
            rates.push(rate);
        }
        let held = |dependence: &Dependence| -> Vec<usize> {
            let pairs = variables.iter().zip(dependence.variables);
            pairs.filter(|(_, depends)| *depends).map(|(variable, _)| *variable).collect()
        };
        let law = |structure: &mut Structure, text: String, answer: usize, dependence: &Dependence| {
            let mut unknowns = held(dependence);
            unknowns.push(answer);
            let equation = structure.equation(text, &unknowns, &dependence.parameters);
            let inputs = component.inputs.iter().zip(dependence.inputs).filter(|(_, depends)| *depends);
            structure.equations[equation].knowns.extend(inputs.map(|(input, _)| *input));
        };
        let mut through = Vec::new();
        for (port, (card, &node)) in component.card.ports.iter().zip(&component.ports).enumerate() {
            let (unknowns, faults) = &mut balances[node];
            unknowns.extend(held(&found.capacity[port]));
            faults.extend(&found.capacity[port].parameters);
            let measured = rig.sensors.iter().any(|sensor| sensor.target == Target::Port(index, port));
            // A line volume, say, answers with no flow at all.
            if !found.through[port].present && !measured {
                through.push(None);
                continue;
            }
            let (text, measurable) = match card.kind {
                PortKind::Hydraulic => (format!("flow into {name}.{}", card.name), true),
                PortKind::Mechanical => (format!("force of {name}.{}", card.name), false),
            };
            let answer = structure.unknown(text.clone(), measurable);
            law(&mut structure, text, answer, &found.through[port]);
            balances[node].0.push(answer);
            through.push(Some(answer));
        }
        for (state, &rate) in rates.iter().enumerate() {
            let text = format!("rate of {} of {name}", component.card.states[state].name);
            law(&mut structure, text, rate, &found.rate[state]);
        }
        flows.push(through);
        states.push(own_states);
    }
    for ((node, place), (mut unknowns, faults)) in rig.nodes.iter().zip(&places).zip(balances) {
        let (text, rate) = match *place {
            Place::Pressure { rate: None, .. } => continue,
            Place::Pressure { rate: Some(rate), .. } => (format!("flow balance of {}", node.name), rate),
            Place::Body { acceleration, .. } => (format!("momentum of {}", node.name), acceleration),
        };
        unknowns.push(rate);
        structure.equation(text, &unknowns, &faults);
    }
    for sensor in &rig.sensors {
        let shown: Vec<usize> = match sensor.target {
            Target::Port(component, port) => rig
                .metered(component, port)
                .into_iter()
                .filter_map(|(component, port)| flows[component][port])
                .collect(),
            Target::State(component, state) => states[component].get(state).copied().into_iter().collect(),
            Target::Node(node) => Vec::from(match (places[node], sensor.quantity) {
                (Place::Pressure { value, .. }, _) => [value],
                (Place::Body { velocity, .. }, Quantity::Velocity) => [velocity],
                (Place::Body { position, .. }, _) => [position],
            }),
        };
        let mut faults = faults_of(sensor.first_parameter);
        faults.extend(faults_of(sensor.first_parameter + 1));
        if sensor.quantity == Quantity::Level {
            // The fluid's density, which comes first of all parameters.
            faults.extend(faults_of(0));
        }
        let equation = structure.equation(format!("sensor {}", sensor.name), &shown, &faults);
        structure.equations[equation].knowns.push(structure.knowns.len());
        structure.knowns.push(sensor.name.clone());
    }
    structure
}
