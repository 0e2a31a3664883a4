//! The balance of energy: no passive component gives any, and what pump and load bring into a circuit is stored or dissipated
//! in it.

use std::f64::consts::PI;
use std::fs;

use borescope::Rig;
use borescope::Unit;
use borescope::internals::model::{InputSignals, Model, Tolerance, cycle_times};
use borescope::internals::physics::ATMOSPHERE;
use borescope::internals::physics::card::{Card, Parameter, PortKind};
use borescope::internals::physics::component::{AnyLaw, CARDS};
use borescope::internals::physics::fluid::{self, Fluid};
use borescope::internals::physics::ports::{INPUTS, PortFlows, PortVariables};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Components that bring power from elsewhere: from a shaft, a voltage, a load.
const ACTIVE: [&str; 4] = ["pump", "reversible-pump", "flow-source", "external-force"];
const DRAWS: usize = 20_000;

/// Between two numbers.
fn within(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * (random.next_u32() as f64 / u32::MAX as f64)
}

/// A value of a parameter within its bounds, over two decades around its default, SI.
fn drawn(random: &mut ChaCha8Rng, parameter: &Parameter) -> f64 {
    let around = parameter.default.filter(|default| *default != 0.0).unwrap_or(1.0);
    let value = around * 10_f64.powf(within(random, -1.0, 1.0));
    let (low, high) = parameter.bounds;
    Unit::parse(parameter.unit).unwrap().difference_to_si(value.clamp(low, high))
}

/// Index of a parameter of a card.
fn named(card: &Card, name: &str) -> usize {
    card.parameters.iter().position(|parameter| parameter.name == name).unwrap()
}

/// Parameters of a card, SI. The oil in the gap of a piston rubs as `pi mu D L v/h`; `viscous_friction` is at least that.
fn parameters(random: &mut ChaCha8Rng, card: &Card, fluid: &Fluid<f64>) -> Vec<f64> {
    let mut values: Vec<f64> = card.parameters.iter().map(|parameter| drawn(random, parameter)).collect();
    if card.kind == "cylinder" {
        let (bore, rod) = (named(card, "bore"), named(card, "rod"));
        values[rod] = values[rod].min(0.9 * values[bore]);
        let [bore, length, clearance] = ["bore", "land_length", "clearance"].map(|name| values[named(card, name)]);
        values[named(card, "viscous_friction")] += PI * fluid.viscosity() * bore * length / (0.5 * clearance);
    }
    values
}

/// What a component may see: gauge pressures from near vacuum to 200 bar, any motion, positions beyond both ends, states on their
/// side of zero.
fn seen(random: &mut ChaCha8Rng, card: &Card, parameters: &[f64]) -> PortVariables<f64> {
    let mut z = Vec::new();
    for port in card.ports {
        match port.kind {
            PortKind::Hydraulic => z.push(ATMOSPHERE + within(random, -0.9e5, 2e7)),
            PortKind::Mechanical => {
                let stroke =
                    card.parameters.iter().position(|one| one.name == "stroke").map_or(1.0, |at| parameters[at]);
                z.extend([within(random, -1e-3, stroke + 1e-3), within(random, -1.0, 1.0)]);
            }
        }
    }
    for state in card.states {
        let scale = Unit::parse(state.unit).unwrap().difference_to_si(state.scale);
        let value = within(random, -1.2, 1.2) * scale;
        z.push(if state.name == "spool" { value } else { value.abs() });
    }
    let mut seen = PortVariables { u: [within(random, -1.0, 1.0); INPUTS], ..PortVariables::default() };
    seen.z[..z.len()].copy_from_slice(&z);
    seen
}

/// Power that a component takes up at its ports, W, beside the sum of its parts' magnitudes, and the flows into it, m3/s.
fn taken(card: &Card, seen: &PortVariables<f64>, answers: &PortFlows<f64>) -> (f64, f64, Vec<f64>) {
    let (mut power, mut size, mut flows, mut at) = (0.0, 0.0_f64, Vec::new(), 0);
    for (port, through) in card.ports.iter().zip(answers.through) {
        let part = match port.kind {
            PortKind::Hydraulic => {
                flows.push(through);
                (seen.z[at] - ATMOSPHERE) * through
            }
            PortKind::Mechanical => -through * seen.z[at + 1],
        };
        at += port.kind.variables();
        power += part;
        size += part.abs();
    }
    (power, size, flows)
}

/// Power that the end stops of a cylinder store as springs, W.
fn stored_in_stops(card: &Card, parameters: &[f64], seen: &PortVariables<f64>) -> f64 {
    let (stroke, stiffness) = (parameters[named(card, "stroke")], parameters[named(card, "stop_stiffness")]);
    let [_, _, position, speed, ..] = seen.z;
    stiffness * ((position - stroke).max(0.0) + position.min(0.0)) * speed
}

#[test]
fn no_passive_component_gives_energy_or_loses_fluid() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut passive = 0;
    for card in CARDS.iter().filter(|card| card.fixes_pressure.is_none() && !ACTIVE.contains(&card.kind)) {
        let mut least = f64::INFINITY;
        for _ in 0..DRAWS {
            let of_fluid: Vec<f64> = fluid::CARD.parameters.iter().map(|own| drawn(&mut random, own)).collect();
            let fluid = Fluid::new(&of_fluid);
            let values = parameters(&mut random, card, &fluid);
            let mut seen = seen(&mut random, card, &values);
            if card.kind == "free-outlet" {
                // What falls arrives with what the fall gives it, which no pressure tells: the outlet itself sees the atmosphere.
                seen.z[1] = ATMOSPHERE;
            }
            let mut answers = PortFlows::default();
            AnyLaw::new(card, &values, &fluid).unwrap().evaluate(&seen, &mut answers);
            let (mut power, size, flows) = taken(card, &seen, &answers);
            if card.kind == "cylinder" {
                power -= stored_in_stops(card, &values, &seen);
            } else {
                let greatest = flows.iter().fold(0.0_f64, |most, flow| most.max(flow.abs()));
                assert!(flows.iter().sum::<f64>().abs() <= 1e-12 * greatest, "{}: {flows:?}", card.kind);
            }
            assert!(power >= -1e-12 * size, "{} gives {} W at {seen:?} with {values:?}", card.kind, -power);
            assert!(answers.capacity.iter().all(|capacity| *capacity >= 0.0), "{}: {answers:?}", card.kind);
            least = least.min(power);
        }
        println!("{}: at least {least:.3e} W", card.kind);
        passive += 1;
    }
    assert!(passive >= 10, "{passive}");
}

const RIG: &str = "fixtures/telescopic/rig.toml";
/// Stays between the end stops.
const CYCLE: &str = r#"
[cycle]
interval = "0.1 ms"
phases = [
    { duration = "0.2 s", valve_command = 0, F_load = "5400 N" },
    { duration = "1.2 s", valve_command = 1, F_load = "5400 N" },
    { duration = "0.3 s", valve_command = 0, F_load = "5400 N" },
    { duration = "0.7 s", valve_command = -1, F_load = "-300 N" },
    { duration = "0.3 s", valve_command = 0, F_load = "0 N" },
]
"#;
const PRESSURES: [&str; 4] = ["pump_line", "valve_line", "A", "B"];
/// Flows into ports.
const FLOWS: [&str; 9] = [
    "pump.P",
    "relief.P",
    "flow_control.in",
    "directional_valve.P",
    "directional_valve.A",
    "directional_valve.B",
    "suction_A.in",
    "suction_B.in",
    "cylinder.A",
];

/// The telescopic circuit with a meter for all that carries power, none of them with a lag.
fn metered() -> Model {
    let text = fs::read_to_string(RIG).unwrap();
    let circuit = text.split("[sensors]").next().unwrap().replace("position = \"0 mm\"", "position = \"20 mm\"");
    let mut sensors = String::from("[sensors]\n");
    for node in PRESSURES {
        sensors += &format!("p_{node} = {{ quantity = \"pressure\", at = \"{node}\", noise = \"1 bar\" }}\n");
    }
    for (number, port) in FLOWS.iter().enumerate() {
        sensors += &format!("q_{number} = {{ quantity = \"flow\", at = \"{port}\", noise = \"1 L/min\" }}\n");
    }
    sensors += "x = { quantity = \"position\", at = \"piston\", noise = \"1 mm\" }\n";
    sensors += "v = { quantity = \"velocity\", at = \"piston\", noise = \"1 mm/s\" }\n";
    let rig = Rig::parse(RIG, format!("{circuit}{sensors}{CYCLE}")).unwrap_or_else(|complaint| panic!("{complaint}"));
    Model::new(rig).with_tolerance(Tolerance { relative: 1e-9, absolute: 1e-9 })
}

/// The circuit at one moment; pressures in Pa above the tank's, flows in m3/s, x in m, v in m/s.
struct Moment {
    p: [f64; 4],
    q: [f64; 9],
    x: f64,
    v: f64,
}

/// What the balance needs of the rig, SI.
struct Sizes {
    areas: [f64; 2],
    stroke: f64,
    dead: [f64; 2],
    lines: [f64; 2],
    bulk_modulus: f64,
    mass: f64,
    friction: f64,
}

impl Sizes {
    fn of(rig: &Rig, values: &[f64]) -> Self {
        let value = |id: &str| values[rig.parameters.iter().position(|parameter| parameter.id == id).unwrap()];
        let area = |diameter: f64| PI / 4.0 * diameter * diameter;
        let (bore, rod) = (area(value("cylinder.bore")), area(value("cylinder.rod")));
        Self {
            areas: [bore, bore - rod],
            stroke: value("cylinder.stroke"),
            dead: [value("cylinder.dead_volume_A"), value("cylinder.dead_volume_B")],
            lines: [value("pump_line.volume"), value("valve_line.volume")],
            bulk_modulus: value("fluid.bulk_modulus"),
            mass: value("cylinder.mass"),
            friction: value("cylinder.viscous_friction"),
        }
    }

    /// Energy in compressed oil and in motion, J.
    fn stored(&self, at: &Moment) -> f64 {
        let chambers = [self.dead[0] + self.areas[0] * at.x, self.dead[1] + self.areas[1] * (self.stroke - at.x)];
        let volumes = [self.lines[0], self.lines[1], chambers[0], chambers[1]];
        let oil: f64 = volumes.iter().zip(at.p).map(|(volume, p)| 0.5 * volume * p * p / self.bulk_modulus).sum();
        oil + 0.5 * self.mass * at.v * at.v
    }

    /// Power by which chambers gain what the oil that fills them already holds, compressed as it is, W.
    fn carried(&self, at: &Moment) -> f64 {
        0.5 * at.v * (self.areas[0] * at.p[2].powi(2) - self.areas[1] * at.p[3].powi(2)) / self.bulk_modulus
    }

    /// Power that each component turns into heat, W.
    fn dissipated(&self, at: &Moment) -> [f64; 6] {
        let ([pump, line, a, b], q) = (at.p, at.q);
        let leak = q[8] - self.areas[0] * at.v;
        [
            pump * q[1],
            (pump - line) * q[2],
            line * q[3] + a * q[4] + b * q[5],
            -a * q[6],
            -b * q[7],
            leak * (a - b) + self.friction * at.v * at.v,
        ]
    }
}

/// Integral over equal steps by the trapezoid rule.
fn integral(step: f64, values: &[f64]) -> f64 {
    values.windows(2).map(|pair| 0.5 * step * (pair[0] + pair[1])).sum()
}

#[test]
fn what_pump_and_load_bring_is_stored_or_dissipated() {
    let model = metered();
    let rig = &model.rig;
    let cycle = rig.cycle.as_ref().unwrap();
    let (times, drive) = (cycle_times(rig, cycle), InputSignals::from_cycle(rig, cycle));
    let load = rig.inputs.iter().position(|input| input.name == "F_load").unwrap();
    let faults: [&[(&str, f64)]; 4] = [
        &[],
        &[("cylinder.clearance", 0.2e-3)],
        &[("flow_control.orifice_diameter", 2e-3), ("directional_valve.opening", 0.3)],
        &[("directional_valve.leak_AT", 1e-12), ("directional_valve.leak_PB", 3e-12), ("relief.set_pressure", 1.1e7)],
    ];
    for faults in faults {
        let mut values = rig.nominal();
        for (id, value) in faults {
            values[rig.parameters.iter().position(|parameter| parameter.id == *id).unwrap()] = *value;
        }
        let outputs = model.solve(&values, &drive, &times).unwrap().values;
        let moments: Vec<Moment> = (0..times.len())
            .map(|row| Moment {
                p: std::array::from_fn(|node| outputs[node][row]),
                q: std::array::from_fn(|port| outputs[PRESSURES.len() + port][row]),
                x: outputs[13][row],
                v: outputs[14][row],
            })
            .collect();
        let sizes = Sizes::of(rig, &values);
        assert!(moments.iter().all(|at| at.x > 0.0 && at.x < sizes.stroke), "{faults:?}: an end stop was met");
        let step = times[1] - times[0];
        let over = |power: &dyn Fn(&Moment) -> f64| integral(step, &moments.iter().map(power).collect::<Vec<_>>());
        let pump = over(&|at| -at.p[0] * at.q[0]);
        // The load jumps between rows, the speed does not.
        let push = |row: usize| drive.value(load, 0.5 * (times[row] + times[row + 1]));
        let by_load: f64 =
            moments.windows(2).enumerate().map(|(row, pair)| -push(row) * 0.5 * step * (pair[0].v + pair[1].v)).sum();
        let heat = over(&|at| sizes.dissipated(at).iter().sum());
        let stored = sizes.stored(moments.last().unwrap()) - sizes.stored(&moments[0]);
        let gap = pump + by_load + over(&|at| sizes.carried(at)) - stored - heat;
        println!(
            "{faults:?}: pump {pump:.3} J, load {by_load:.3} J, heat {heat:.3} J, stored {stored:.3} J, gap {gap:.2e} J"
        );
        assert!(by_load < -100.0, "the load is pushed: {by_load} J");
        assert!(gap.abs() < 1e-6 * pump, "{faults:?}: {gap} J of {pump} J are lost");
        let most = moments.iter().map(|at| at.p[0] * at.q[0].abs()).fold(0.0, f64::max);
        for at in &moments {
            let each = sizes.dissipated(at);
            assert!(each.iter().all(|power| *power >= -1e-9 * most), "{faults:?}: {each:?} W");
        }
    }
}
