//! A telescopic rig by hand, to hide physics in: other states, other smoothing, another integrator (fixed steps of Runge-Kutta
//! 4, `ode_solvers`) and, for most of what it may hide, another form of the law than the library's.

#![allow(dead_code, reason = "each test that uses the plant needs a part of it")]

pub mod hidden;
pub mod record;
pub mod tanks;

use std::f64::consts::PI;

/// Pump line, line between the valves, cylinder chambers.
pub const NODES: usize = 4;
pub const PUMP_LINE: usize = 0;
pub const VALVE_LINE: usize = 1;
pub const A: usize = 2;
pub const B: usize = 3;
/// `p_pump`, `p_P`, `p_A`, `p_B`, `q_P`, `q_A`, `q_B`, `x`.
pub const SENSORS: usize = 8;

const ATMOSPHERE: f64 = 1e5;
const LAMINAR: f64 = 2e4;

/// What a sensor does to what it reads.
#[derive(Debug, Clone, Copy)]
pub struct Reading {
    pub offset: f64,
    pub gain: f64,
    pub lag: f64,
    pub delay: f64,
    pub limit: f64,
}

/// A line between valve and chamber: pressure drop `laminar q + turbulent q^1.75`, with the inertia of its oil.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    pub laminar: f64,
    pub turbulent: f64,
}

/// All numbers of the plant, SI. What it hides does nothing at its default.
#[derive(Debug, Clone)]
pub struct Plant {
    pub viscosity: f64,
    /// Relative loss of viscosity per kelvin at 40 degC, where the rest is Vogel's law, and by how much the oil gets warmer in
    /// the end, K.
    pub thinning: f64,
    pub warming: f64,
    /// s.
    pub warming_up: f64,
    pub logs_temperature: bool,
    pub bulk_modulus: f64,
    pub pump_flow: f64,
    pub set_pressure: f64,
    pub throttle: f64,
    pub discharge: f64,
    pub reducing_discharge: f64,
    pub rated_drop: f64,
    pub clearance: f64,
    pub opening: f64,
    pub spool_lags: [f64; 2],
    /// Damping of a spool with mass, whose `s'` takes the first of the lags; 0 for one that only lags.
    pub spool_damping: f64,
    /// s between the command and the first movement of the spool, in rows of the logger.
    pub dead_rows: usize,
    pub compensator_lag: f64,
    pub external_leak: [f64; NODES],
    pub external_hole: [f64; NODES],
    pub hose: [f64; NODES],
    pub air: f64,
    pub lines: [Option<Line>; 2],
    /// Pressure drop of the line behind port T over the square of its flow, Pa s²/m⁶.
    pub return_line: f64,
    pub load_force: f64,
    pub load_mass: f64,
    pub load_stiffness: f64,
    pub progressive_load: f64,
    pub hole_in_piston: f64,
    pub worn_end: f64,
    pub friction_per_pressure: f64,
    pub viscous: f64,
    pub coulomb: f64,
    pub breakaway: f64,
    pub cushion: f64,
    pub cushion_length: f64,
    pub slip: f64,
    pub droop: f64,
    pub weeping: f64,
    pub weeping_from: f64,
    pub knee: f64,
    pub dead_band: f64,
    /// Leakage of an edge of the valve per pressure in the middle, m3/s/Pa.
    pub null_leak: f64,
    /// Of the land between P and A alone, m³/s/Pa.
    pub scored_land: f64,
    pub flow_force: f64,
    /// Effects that no library has: a dent in the bore (N at 100 mm), and a leak that opens under pressure at A (m³/s/Pa above
    /// 30 bar, with hysteresis left out).
    pub dent: f64,
    pub backlash: f64,
    pub readings: [Reading; SENSORS],
}

impl Default for Plant {
    fn default() -> Self {
        let reading = Reading { offset: 0.0, gain: 1.0, lag: 0.0, delay: 0.0, limit: f64::INFINITY };
        let mut readings = [reading; SENSORS];
        for flow in &mut readings[4..7] {
            flow.lag = 2e-3;
        }
        Self {
            viscosity: 45.5e-3,
            thinning: 0.0,
            warming: 0.0,
            warming_up: 6.0,
            logs_temperature: true,
            bulk_modulus: 1.4e9,
            pump_flow: 5.5e-3 / 60.0,
            set_pressure: 100e5,
            throttle: 5e-3,
            discharge: 0.7,
            reducing_discharge: 0.7,
            rated_drop: 18.5e5,
            clearance: 0.0,
            opening: 1.0,
            spool_lags: [8e-3, 0.0],
            spool_damping: 0.0,
            dead_rows: 0,
            compensator_lag: 4e-3,
            external_leak: [0.0; NODES],
            external_hole: [0.0; NODES],
            hose: [0.0; NODES],
            air: 0.0,
            lines: [None; 2],
            return_line: 0.0,
            load_force: 0.0,
            load_mass: 0.0,
            load_stiffness: 0.0,
            progressive_load: 0.0,
            hole_in_piston: 0.0,
            worn_end: 0.0,
            friction_per_pressure: 0.0,
            viscous: 800.0,
            coulomb: 0.0,
            breakaway: 0.0,
            cushion: 0.0,
            cushion_length: 20e-3,
            slip: 0.0,
            droop: 0.0,
            weeping: 0.0,
            weeping_from: 80e5,
            knee: 0.0,
            dead_band: 0.0,
            null_leak: 0.0,
            scored_land: 0.0,
            flow_force: 0.0,
            dent: 0.0,
            backlash: 0.0,
            readings,
        }
    }
}

/// Areas, volumes and masses of the data sheet.
const STROKE: f64 = 0.17;
const DEAD_VOLUME: f64 = 50e-6;
const LINE_VOLUME: [f64; 2] = [50e-6, 20e-6];
const NEAR_VOLUME: f64 = 5e-6;
const INERTIA: f64 = 4e7;
const MASS: f64 = 100.0;
const LAND: f64 = 37.4e-3;
const DENSITY: f64 = 870.0;
pub fn areas() -> (f64, f64) {
    (PI / 4.0 * 0.04f64.powi(2), PI / 4.0 * (0.04f64.powi(2) - 0.02f64.powi(2)))
}

/// Root of a pressure drop with its sign; a cubic through zero below 0.2 bar.
fn root(drop: f64) -> f64 {
    let share = drop.abs() / LAMINAR;
    if share >= 1.0 {
        return drop.signum() * drop.abs().sqrt();
    }
    drop.signum() * LAMINAR.sqrt() * share * (1.25 - 0.25 * share * share)
}

/// States: pressures of pump line, valve line, A and B; position, speed; two spool lags; relief lag, opening of the reducing
/// valve; near pressures and flows of the lines to A and B.
pub const STATES: usize = 14;

/// What acts: command, load.
pub type Acting = [f64; 2];

/// Flows that sensors see: into P, into A, out of B.
pub type Flows = [f64; 3];

impl Plant {
    /// Temperature of the oil so many seconds after the start, degC.
    pub fn temperature(&self, t: f64) -> f64 {
        40.0 + self.warming * (1.0 - (-t / self.warming_up).exp())
    }

    /// The plant with its oil as warm as it is then: Vogel's law, with 95 K below 0 degC as where oil would not flow.
    pub fn warm(&self, t: f64) -> Self {
        let b = self.thinning * 135.0 * 135.0;
        let viscosity = self.viscosity * (b / (95.0 + self.temperature(t)) - b / 135.0).exp();
        Self { viscosity, ..self.clone() }
    }

    /// The state at rest in front of a load, the pump flow going over the relief valve.
    pub fn start(&self, load: f64) -> [f64; STATES] {
        let mut y = [0.0; STATES];
        let p_a = ((load + self.load_force) / areas().0).max(0.0);
        (y[0], y[1], y[2], y[10]) = (101e5, 101e5, p_a, p_a);
        (y[8], y[9]) = (1e5, 1.5e-3);
        y
    }

    fn capacity(&self, volume: f64, pressure: f64, hose: f64) -> f64 {
        let absolute = (pressure + ATMOSPHERE).max(0.02 * ATMOSPHERE);
        // Polytropic air of exponent 1.2.
        let air = self.air * (ATMOSPHERE / absolute).powf(1.0 / 1.2) / (1.2 * absolute);
        volume * (1.0 / self.bulk_modulus + air) + hose / (1.0 + pressure.max(0.0) / 1000e5)
    }

    /// Derivatives of the states, and the flows that sensors see.
    pub fn rates(&self, y: &[f64; STATES], [command, load]: Acting) -> ([f64; STATES], Flows) {
        let [p_pump, p_valve, p_a, p_b, x, v, first, second, relief, opening, near_a, near_b, ..] = *y;
        let (area_a, area_b) = areas();
        let mut f = [0.0; STATES];
        // Pump and relief valve.
        let pump = self.pump_flow * (1.0 - self.droop * p_pump) - self.slip * p_pump;
        let gradient = 5.5e-3 / 60.0 / (2e5 * 102e5f64.sqrt());
        let over = p_pump - self.set_pressure;
        // A knee as a soft maximum.
        let wanted = if self.knee > 0.0 {
            let width = self.knee / 1.386;
            width * ((-(over / width).abs()).exp().ln_1p() + (over / width).max(0.0))
        } else {
            over.max(0.0)
        };
        f[8] = (wanted - relief) / 3e-3;
        let over_relief =
            gradient * relief * root(p_pump.max(0.0)) + self.weeping * (p_pump - self.weeping_from).max(0.0);
        // Flow control valve: two edges in a row as one.
        let reducing = self.reducing_discharge * 1e-2 * opening * (2.0 / DENSITY).sqrt();
        let throttle = self.discharge * PI / 4.0 * self.throttle.powi(2) * (2.0 / DENSITY).sqrt();
        let drop = p_pump - p_valve;
        let series = reducing * throttle / (reducing * reducing + throttle * throttle).sqrt();
        let control = series * root(drop);
        let over_throttle = drop * reducing * reducing / (reducing * reducing + throttle * throttle);
        // The flow force with the jet angle of 69 degrees closing a little as the edge opens.
        let jet = 2.0 * self.flow_force * self.reducing_discharge * 1e-2 * opening * (drop - over_throttle);
        let balance = (15e-3 * 5000.0 - 101.35e-6 * over_throttle - jet * (1.0 + 20.0 * opening)) / 5000.0;
        f[9] = (balance.clamp(0.0, 1.5e-3) - opening) / self.compensator_lag;
        // Directional control valve.
        let spool = if self.spool_lags[1] > 0.0 { second } else { first };
        f[6] = (command - first) / self.spool_lags[0];
        f[7] = if self.spool_lags[1] > 0.0 { (first - second) / self.spool_lags[1] } else { 0.0 };
        if self.spool_damping > 0.0 {
            // Position and speed of a spool with mass and damping.
            let omega = 2.0 * self.spool_damping / self.spool_lags[0];
            (f[6], f[7]) = (second, omega * omega * (command - first) - 2.0 * self.spool_damping * omega * second);
        }
        // Overlap with a chamfer: the edge begins softly, and is shut in the middle.
        let beyond = |s: f64| {
            if self.dead_band == 0.0 {
                return s.max(0.0);
            }
            let soft = 0.01;
            let open = |s: f64| 0.5 * (s - self.dead_band + ((s - self.dead_band).powi(2) + soft * soft).sqrt());
            (open(s.max(0.0)) - open(0.0)) / (open(1.0) - open(0.0))
        };
        let edge = 8e-3 / 60.0 / self.rated_drop.sqrt() * self.opening;
        let (at_a, at_b) =
            (if self.lines[0].is_some() { near_a } else { p_a }, if self.lines[1].is_some() { near_b } else { p_b });
        let (out, back) = (edge * beyond(spool), edge * beyond(-spool));
        // Edge and return line, both turbulent, as one.
        let drained = |edge: f64| edge / (1.0 + self.return_line * edge * edge).sqrt();
        let (q_pa, q_bt) = (out * root(p_valve - at_a), drained(out) * root(at_b));
        let (q_pb, q_at) = (back * root(p_valve - at_b), drained(back) * root(at_a));
        // Lands overlap ever more behind worn edges.
        let land = |closed: f64| self.null_leak * (-(closed.max(0.0) / 0.1)).exp();
        let (q_pa, q_bt) = (q_pa + land(-spool) * (p_valve - at_a), q_bt + land(-spool) * at_b);
        let (q_pb, q_at) = (q_pb + land(spool) * (p_valve - at_b), q_at + land(spool) * at_a);
        let q_pa = q_pa + self.scored_land * (p_valve - at_a);
        let (q_p, q_a, q_b) = (q_pa + q_pb, q_pa - q_at, q_bt - q_pb);
        // Nodes.
        let leak = |node: usize, p: f64| {
            let hole = 0.7 * self.external_hole[node] * (2.0 / DENSITY).sqrt() * root(p);
            // The seal is pressed against its seat a little.
            self.external_leak[node] * p * (1.0 - p / 3000e5) + hole
        };
        let suction = |p: f64| (60e-3 / 60.0 / 1e5) * (-p - 0.3e5).max(0.0);
        let of_line = |volume: f64, p: f64, node: usize| self.capacity(volume, p, self.hose[node]);
        f[0] = (pump - over_relief - control - leak(PUMP_LINE, p_pump)) / of_line(LINE_VOLUME[0], p_pump, PUMP_LINE);
        f[1] = (control - q_p - leak(VALVE_LINE, p_valve)) / of_line(LINE_VOLUME[1], p_valve, VALVE_LINE);
        // Cylinder.
        let inside = x.clamp(0.0, STROKE);
        let gap = self.clearance / 2.0;
        let gap_leak =
            PI * 0.04 * gap.powi(3) / (12.0 * self.viscosity * LAND) * (p_a - p_b) - PI * 0.04 * gap * v / 2.0;
        let share = inside / STROKE;
        let worn = self.worn_end * share * (0.9 + 0.1 * share) * (p_a - p_b);
        let hole = 0.7 * self.hole_in_piston * (2.0 / DENSITY).sqrt() * root(p_a - p_b);
        let across = gap_leak + worn + hole;
        let (volume_a, volume_b) = (DEAD_VOLUME + area_a * inside, DEAD_VOLUME + area_b * (STROKE - inside));
        let chambers = [(volume_a, p_a, near_a, A, q_a), (volume_b, p_b, near_b, B, -q_b)];
        let mut into = [0.0; 2];
        for (side, (volume, p, near, node, valve)) in chambers.into_iter().enumerate() {
            into[side] = match self.lines[side] {
                Some(line) => {
                    let q = y[12 + side];
                    let drag = line.laminar * q + line.turbulent * q.signum() * q.abs().powf(1.75);
                    let near_capacity = self.capacity(NEAR_VOLUME, near, self.hose[node]);
                    f[10 + side] = (valve - q - leak(node, near) + suction(near)) / near_capacity;
                    f[12 + side] = (near - p - drag) / INERTIA;
                    q
                }
                None => valve - leak(node, p) + suction(p),
            };
            let hose = if self.lines[side].is_some() { 0.0 } else { self.hose[node] };
            let moved = if side == 0 { -area_a * v - across } else { area_b * v + across };
            f[2 + side] = (into[side] + moved) / self.capacity(volume, p, hose);
        }
        f[4] = v;
        f[5] = (area_a * p_a - area_b * p_b - self.resisting(y) - load) / (MASS + self.load_mass);
        (f, [q_p, q_a, q_b])
    }

    /// Forces against the outstroke but for the measured load, N.
    fn resisting(&self, y: &[f64; STATES]) -> f64 {
        let [_, _, p_a, p_b, x, v, ..] = *y;
        let direction = (v / 0.6e-3).tanh();
        let dry = self.coulomb
            + self.breakaway * (-(v.abs() / 8e-3)).exp()
            + self.friction_per_pressure * (p_a + 1.1 * p_b).max(0.0)
            + self.dent * (-((x - 0.1) / 0.012).powi(2)).exp();
        let into_end = if v > 0.0 { x - STROKE + self.cushion_length } else { self.cushion_length - x };
        let depth = (into_end / self.cushion_length).clamp(0.0, 1.0);
        // A conical spear: the annulus narrows with the depth, a little faster than straight.
        let cushion = self.cushion * v * v.abs() * depth * (0.85 + 0.15 * depth);
        let stop = |depth: f64, speed: f64| {
            if depth <= 0.0 {
                return 0.0;
            }
            5e7 * depth + 8e4 * (depth / 5e-6).min(1.0) * speed.max(0.0)
        };
        let load = self.load_force + self.load_stiffness * x + self.progressive_load * x * x;
        // Play of the load: it acts only beyond the middle of the stroke.
        let play = self.backlash * ((x - 0.085) / 2e-3).tanh();
        self.viscous * v + direction * dry + cushion + load + play + stop(x - STROKE, v) - stop(-x, -v)
    }
}
