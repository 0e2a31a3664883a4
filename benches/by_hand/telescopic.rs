//! The telescopic rig by hand: the same laws, states and numbers as its rig file, without a circuit that is known at run time
//! only.

use std::f64::consts::PI;

use borescope::Rig;
use borescope::internals::model::InputSignals;
use borescope::internals::numeric::{Dual, Options, Real, Rosenbrock, System, jacobian};

/// Pressures of pump line, line between the valves, A and B (gauge); position, speed; overpressure that the relief valve follows,
/// opening of the reducing valve, spool; flows into P, out of A, into B as their sensors follow them.
pub const N: usize = 12;
/// Sizes of the states, SI.
const SIZES: [f64; N] = [1e7, 1e7, 1e7, 1e7, 1e-2, 0.1, 1e5, 1e-3, 1.0, 1e-4, 1e-4, 1e-4];
const STOP_CONTACT: f64 = 2e-5;

/// All constants, SI.
pub struct Telescopic {
    pub command: f64,
    pub load: f64,
    bulk: f64,
    pump: f64,
    relief: [f64; 3],
    throttle: f64,
    reducing: f64,
    most: f64,
    compression: f64,
    area_per_rate: f64,
    lags: [f64; 3],
    transitions: [f64; 2],
    edge: f64,
    check: [f64; 2],
    volumes: [f64; 4],
    areas: [f64; 2],
    stroke: f64,
    mass: f64,
    friction: f64,
    leak: f64,
    drag: f64,
    stop: [f64; 2],
}

#[inline]
fn root<T: Real>(drop: T, transition: f64) -> T {
    drop / (drop * drop + transition * transition).sqrt().sqrt()
}

impl Telescopic {
    pub fn of(rig: &Rig) -> Self {
        let get = |id: &str| rig.parameters[rig.parameter(id).unwrap_or_else(|| panic!("no `{id}`"))].value;
        let (bore, rod) = (get("cylinder.bore"), get("cylinder.rod"));
        let (big, small) = (PI / 4.0 * bore * bore, PI / 4.0 * rod * rod);
        let jet = (2.0 / get("fluid.density")).sqrt();
        let diameter = get("flow_control.orifice_diameter");
        let gap = get("cylinder.clearance") / 2.0;
        let (set, over) = (get("relief.set_pressure"), get("relief.rated_overpressure"));
        Self {
            command: 0.0,
            load: 0.0,
            bulk: get("fluid.bulk_modulus"),
            pump: get("pump.displacement") * get("pump.speed"),
            relief: [set, get("relief.rated_flow") / (over * (set + over).sqrt()), get("relief.lag")],
            throttle: get("flow_control.discharge_coefficient") * PI / 4.0 * diameter * diameter * jet,
            reducing: get("flow_control.reducing_discharge_coefficient") * get("flow_control.area_gradient") * jet,
            most: get("flow_control.max_opening"),
            compression: get("flow_control.spring_compression"),
            area_per_rate: get("flow_control.spool_area") / get("flow_control.spring_rate"),
            lags: [get("flow_control.lag"), get("directional_valve.lag"), rig.sensors[4].lag],
            transitions: [get("flow_control.transition_pressure"), get("directional_valve.transition_pressure")],
            edge: get("directional_valve.opening") * get("directional_valve.rated_flow")
                / get("directional_valve.rated_drop").sqrt(),
            check: [get("suction_A.cracking_pressure"), get("suction_A.gradient")],
            volumes: ["pump_line.volume", "valve_line.volume", "cylinder.dead_volume_A", "cylinder.dead_volume_B"]
                .map(get),
            areas: [big, big - small],
            stroke: get("cylinder.stroke"),
            mass: get("cylinder.mass"),
            friction: get("cylinder.viscous_friction"),
            leak: bore * PI * gap * gap * gap / (get("fluid.viscosity") * get("cylinder.land_length") * 12.0),
            drag: bore * gap * PI / 2.0,
            stop: [get("cylinder.stop_stiffness"), get("cylinder.stop_damping")],
        }
    }

    /// At rest in front of the load, the pump flow going over the relief valve.
    fn start(&self) -> [f64; N] {
        let mut y = [0.0; N];
        (y[0], y[1], y[2]) = (101e5, 101e5, self.load / self.areas[0]);
        (y[6], y[7]) = (101e5 - self.relief[0], self.most);
        y
    }

    /// Flow through throttle and reducing valve, and the opening that the spool wants.
    #[inline]
    fn control<T: Real>(&self, drop: T, opening: T) -> (T, T) {
        let reducing = opening * self.reducing;
        let square = reducing * reducing;
        let both = square + self.throttle * self.throttle;
        let flow = reducing * self.throttle / both.sqrt() * root(drop, self.transitions[0]);
        let wanted = -(drop * square / both) * self.area_per_rate + self.compression;
        (flow, wanted.max(T::zero()).min(T::constant(self.most)))
    }

    /// Flow into a chamber through its check valve.
    #[inline]
    fn suction<T: Real>(&self, pressure: T) -> T {
        (-pressure - self.check[0]).max(T::zero()) * self.check[1]
    }

    /// Force of the end stops against the outstroke.
    #[inline]
    fn stops<T: Real>(&self, x: T, v: T) -> T {
        let stop = |depth: T, speed: T| {
            let contact = (depth / STOP_CONTACT).min(T::one());
            depth * self.stop[0] + contact * speed.max(T::zero()) * self.stop[1]
        };
        if x.re() > self.stroke {
            stop(x - self.stroke, v)
        } else if x.re() < 0.0 {
            -stop(-x, -v)
        } else {
            T::zero()
        }
    }

    /// Bulk modulus over the volume of each chamber.
    #[inline]
    fn stiffness(&self, x: f64) -> [f64; 2] {
        let inside = x.clamp(0.0, self.stroke);
        let volumes =
            [self.volumes[2] + self.areas[0] * inside, self.volumes[3] + self.areas[1] * (self.stroke - inside)];
        volumes.map(|volume| self.bulk / volume)
    }
}

/// A flow through an edge and its slopes by pressure drop and spool.
#[derive(Clone, Copy, Default)]
struct Edge {
    flow: f64,
    by_drop: f64,
    by_spool: f64,
}

impl Telescopic {
    /// Flows from P and to the tank, of the side that the spool opens: `(A from P, B to tank, B from P, A to tank)`.
    #[inline]
    fn edges(&self, [pv, pa, pb, s]: [f64; 4]) -> [f64; 4] {
        let way = self.edge * s.abs();
        let flow = |drop: f64| way * root(drop, self.transitions[1]);
        if s > 0.0 { [flow(pv - pa), flow(pb), 0.0, 0.0] } else { [0.0, 0.0, flow(pv - pb), flow(pa)] }
    }

    #[inline]
    fn sloped_edges(&self, [pv, pa, pb, s]: [f64; 4]) -> [Edge; 4] {
        let way = self.edge * s.abs();
        let edge = |drop: f64| {
            let Dual { re, eps: [slope] } = root(Dual::<f64, 1>::variable(drop, 0), self.transitions[1]);
            Edge { flow: way * re, by_drop: way * slope, by_spool: self.edge * s.signum() * re }
        };
        let none = Edge::default();
        if s > 0.0 { [edge(pv - pa), edge(pb), none, none] } else { [none, none, edge(pv - pb), edge(pa)] }
    }
}

impl System<f64, N> for Telescopic {
    #[inline]
    fn derivative(&mut self, _t: f64, y: &[f64; N], f: &mut [f64; N]) {
        let [pp, pv, pa, pb, x, v, r, o, s, ..] = *y;
        let [set, gradient, lag] = self.relief;
        let relief = gradient * r * root(pp, 1e3);
        let (control, wanted) = self.control(pp - pv, o);
        let [p_a, b_t, p_b, a_t] = self.edges([pv, pa, pb, s]);
        let (q_p, q_a, q_b) = (p_a + p_b, p_a - a_t, b_t - p_b);
        let leak = self.leak * (pa - pb) - self.drag * v;
        let [rise_a, rise_b] = self.stiffness(x);
        f[0] = (self.pump - relief - control) * (self.bulk / self.volumes[0]);
        f[1] = (control - q_p) * (self.bulk / self.volumes[1]);
        f[2] = (q_a + self.suction(pa) - self.areas[0] * v - leak) * rise_a;
        f[3] = (-q_b + self.suction(pb) + self.areas[1] * v + leak) * rise_b;
        f[4] = v;
        let force = self.areas[0] * pa - self.areas[1] * pb - self.friction * v - self.load - self.stops(x, v);
        f[5] = force / self.mass;
        f[6] = ((pp - set).max(0.0) - r) / lag;
        f[7] = (wanted - o) / self.lags[0];
        f[8] = (self.command - s) / self.lags[1];
        for (slot, (flow, followed)) in f[9..].iter_mut().zip([q_p, q_a, q_b].into_iter().zip(&y[9..])) {
            *slot = (flow - followed) / self.lags[2];
        }
    }

    #[inline]
    fn jacobian(&mut self, _t: f64, y: &[f64; N], j: &mut [[f64; N]; N], _: &mut [f64; N]) {
        let [pp, pv, pa, pb, x, v, r, o, s, ..] = *y;
        let [set, gradient, lag] = self.relief;
        let Dual { re: over, eps: [by_pump] } = root(Dual::<f64, 1>::variable(pp, 0), 1e3);
        let (_, [[control_d, control_o], [wanted_d, wanted_o]]) = jacobian(&[pp - pv, o], |[drop, opening]| {
            let (flow, wanted) = self.control(drop, opening);
            [flow, wanted]
        });
        let [p_a, b_t, p_b, a_t] = self.sloped_edges([pv, pa, pb, s]);
        let stiff = [self.bulk / self.volumes[0], self.bulk / self.volumes[1]];
        j[0][0] = -stiff[0] * (gradient * r * by_pump + control_d);
        j[0][1] = stiff[0] * control_d;
        j[0][6] = -stiff[0] * gradient * over;
        j[0][7] = -stiff[0] * control_o;
        // Slopes of the flows into P, into A and out of B, by P, A, B and the spool.
        let into_p = [p_a.by_drop + p_b.by_drop, -p_a.by_drop, -p_b.by_drop, p_a.by_spool + p_b.by_spool];
        let into_a = [p_a.by_drop, -p_a.by_drop - a_t.by_drop, 0.0, p_a.by_spool - a_t.by_spool];
        let out_of_b = [-p_b.by_drop, 0.0, b_t.by_drop + p_b.by_drop, b_t.by_spool - p_b.by_spool];
        const BY: [usize; 4] = [1, 2, 3, 8];
        j[1][0] = stiff[1] * control_d;
        j[1][7] = stiff[1] * control_o;
        j[1][1] = -stiff[1] * control_d;
        let [rise_a, rise_b] = self.stiffness(x);
        for (slope, column) in
            BY.into_iter().enumerate().map(|(at, column)| ([into_p[at], into_a[at], out_of_b[at]], column))
        {
            j[1][column] -= stiff[1] * slope[0];
            j[2][column] = rise_a * slope[1];
            j[3][column] = -rise_b * slope[2];
            for (row, slope) in slope.into_iter().enumerate() {
                j[9 + row][column] = slope / self.lags[2];
            }
        }
        let suction = |p: f64| if -p > self.check[0] { -self.check[1] } else { 0.0 };
        let leak = self.leak * (pa - pb) - self.drag * v;
        let (q_a, q_b) = (p_a.flow - a_t.flow, b_t.flow - p_b.flow);
        let inside = if x > 0.0 && x < self.stroke { 1.0 } else { 0.0 };
        let (into_a, into_b) =
            (q_a + self.suction(pa) - self.areas[0] * v - leak, -q_b + self.suction(pb) + self.areas[1] * v + leak);
        j[2][2] += rise_a * (suction(pa) - self.leak);
        j[2][3] += rise_a * self.leak;
        j[2][4] = -inside * rise_a * rise_a / self.bulk * self.areas[0] * into_a;
        j[2][5] = -rise_a * (self.areas[0] - self.drag);
        j[3][2] += rise_b * self.leak;
        j[3][3] += rise_b * (suction(pb) - self.leak);
        j[3][4] = inside * rise_b * rise_b / self.bulk * self.areas[1] * into_b;
        j[3][5] = rise_b * (self.areas[1] - self.drag);
        j[4][5] = 1.0;
        let (_, [[stop_x, stop_v]]) = jacobian(&[x, v], |[x, v]| [self.stops(x, v)]);
        j[5][2] = self.areas[0] / self.mass;
        j[5][3] = -self.areas[1] / self.mass;
        j[5][4] = -stop_x / self.mass;
        j[5][5] = -(self.friction + stop_v) / self.mass;
        j[6][0] = if pp > set { 1.0 / lag } else { 0.0 };
        j[6][6] = -1.0 / lag;
        j[7][0] = wanted_d / self.lags[0];
        j[7][1] = -wanted_d / self.lags[0];
        j[7][7] = (wanted_o - 1.0) / self.lags[0];
        j[8][8] = -1.0 / self.lags[1];
        for (row, slots) in j.iter_mut().enumerate().skip(9) {
            slots[row] = -1.0 / self.lags[2];
        }
    }
}

/// What the sensors read over the drive: `[sensor][row]`, and the steps that were taken.
pub fn run(rig: &Rig, drive: &InputSignals, times: &[f64]) -> (Vec<Vec<f64>>, usize) {
    let mut circuit = Telescopic::of(rig);
    circuit.load = drive.pieces[0].from[1];
    let mut y = circuit.start();
    let mut integrator = Rosenbrock::new(Options::new(1e-6, SIZES.map(|size| size * 1e-6)));
    let mut values = vec![vec![0.0; times.len()]; 8];
    let mut row = 0;
    for piece in &drive.pieces {
        (circuit.command, circuit.load) = (piece.from[0], piece.from[1]);
        if piece.jump {
            integrator.restart();
        }
        let solved = integrator.integrate(&mut circuit, piece.start, &y, piece.end, |step| {
            while row < times.len() && times[row] <= step.t_end {
                let y = step.interpolate_all(times[row]);
                let shown = [y[0], y[1], y[2], y[3], y[9], y[10], y[11], y[4]];
                values.iter_mut().zip(shown).for_each(|(values, shown)| values[row] = shown);
                row += 1;
            }
        });
        y = solved.expect("integrates");
    }
    let stats = integrator.stats();
    (values, stats.steps + stats.rejected)
}
