//! Strokes of the telescopic rig with its three faults, and what the paper's estimators make of them.

use std::error::Error;
use std::path::Path;

use borescope::internals::model::{InputSignals, Model};
use borescope::internals::residual::estimator::Healthy;
use borescope::internals::rig::{Cycle, Phase, Profile, Rig};

/// The paper's full load, N.
pub const FULL_LOAD: f64 = 5400.0;
/// The valve opens here, s.
pub const OPENS: f64 = 0.2;
/// Time between samples, s.
pub const INTERVAL: f64 = 0.004;
/// Motion is steady from here to there, s: what switching stirs up is gone, and the fastest stroke is not at its end.
const STEADY: (f64, f64) = (1.2, 1.8);

/// The three faults, in the units of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Faults {
    /// Opening coefficient of the directional valve.
    pub opening: f64,
    /// mm.
    pub orifice: f64,
    /// Diametral, mm.
    pub clearance: f64,
}

pub const HEALTHY: Faults = Faults { opening: 1.0, orifice: 5.0, clearance: 0.0 };

/// Table 2 of the paper.
pub const SERIES: [Faults; 3] = [
    Faults { opening: 0.3, orifice: 2.5, clearance: 0.25 },
    Faults { opening: 0.2, orifice: 3.5, clearance: 0.15 },
    Faults { opening: 0.6, orifice: 1.5, clearance: 0.2 },
];

/// One stroke: samples of s, bar, L/min and mm.
#[derive(Debug, Clone, Default)]
pub struct Stroke {
    pub time: Vec<f64>,
    pub position: Vec<f64>,
    pub flow_p: Vec<f64>,
    pub flow_a: Vec<f64>,
    pub flow_b: Vec<f64>,
    /// What the healthy directional valve would pass from P to A at the stroke's pressures.
    pub healthy_valve: Vec<f64>,
    /// What the healthy flow control valve would pass at the stroke's pressures.
    pub healthy_control: Vec<f64>,
    /// (4) corrected.
    pub leakage: Vec<f64>,
    /// (4) as printed.
    pub leakage_printed: Vec<f64>,
    /// (20).
    pub lost_opening: Vec<f64>,
    /// (10) against the healthy valve at the stroke's pressures.
    pub blockage: Vec<f64>,
}

/// Means over steady motion; flows in L/min, velocity in m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steady {
    pub velocity: f64,
    pub flow_p: f64,
    pub flow_a: f64,
    pub flow_b: f64,
    pub healthy_valve: f64,
    pub healthy_control: f64,
    /// `q_A - A1 v`.
    pub leakage_moving: f64,
    pub leakage: f64,
    pub leakage_printed: f64,
    pub lost_opening: f64,
    pub blockage: f64,
}

/// The rig with its equations and its healthy components.
#[derive(Debug)]
pub struct Bench {
    model: Model,
    healthy: Healthy,
    ids: [usize; 3],
    sensors: [usize; 7],
}

impl Bench {
    /// From a rig file that has the telescopic rig's names.
    pub fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let rig = Rig::read(path)?;
        let parameter = |id: &str| rig.parameter(id).ok_or_else(|| format!("the rig has no {id}"));
        let ids = [
            parameter("directional_valve.opening")?,
            parameter("flow_control.orifice_diameter")?,
            parameter("cylinder.clearance")?,
        ];
        let mut sensors = [0; 7];
        for (index, name) in sensors.iter_mut().zip(["p_pump", "p_P", "p_A", "q_P", "q_A", "q_B", "x"]) {
            let found = rig.sensors.iter().position(|sensor| sensor.name == name);
            *index = found.ok_or_else(|| format!("the rig has no sensor {name}"))?;
        }
        let healthy = Healthy::of(&rig, &rig.nominal()).ok_or("the rig lacks a component that the paper diagnoses")?;
        Ok(Self { model: Model::new(rig), healthy, ids, sensors })
    }

    /// An outstroke of `duration` seconds against `load` newtons.
    pub fn stroke(&self, faults: Faults, load: f64, duration: f64) -> Result<Stroke, Box<dyn Error>> {
        let rig = &self.model.rig;
        let mut parameters = rig.nominal();
        for (id, value) in self.ids.into_iter().zip([faults.opening, faults.orifice * 1e-3, faults.clearance * 1e-3]) {
            parameters[id] = value;
        }
        let still = |value: f64| Profile { from: value, to: value };
        let phase = |duration: f64, command: f64| Phase {
            duration,
            inputs: rig.inputs.iter().map(|input| still(if input.name == "F_load" { load } else { command })).collect(),
        };
        let cycle = Cycle { interval: INTERVAL, phases: vec![phase(OPENS, 0.0), phase(duration - OPENS, 1.0)] };
        let time: Vec<f64> = (0..=(duration / INTERVAL).round() as usize).map(|row| row as f64 * INTERVAL).collect();
        let outputs = self.model.solve(&parameters, &InputSignals::from_cycle(rig, &cycle), &time)?;
        let mut stroke = Stroke::default();
        for row in 0..time.len() {
            let [p_pump, p_p, p_a, q_p, q_a, q_b, x] = self.sensors.map(|sensor| outputs.values[sensor][row]);
            let (healthy, litres) = (&self.healthy, 6e4);
            stroke.position.push(x * 1e3);
            stroke.flow_p.push(q_p * litres);
            stroke.flow_a.push(q_a * litres);
            stroke.flow_b.push(q_b * litres);
            stroke.healthy_valve.push(healthy.directional.path_pa(p_p, p_a) * litres);
            stroke.healthy_control.push(healthy.flow_control.steady_flow(p_pump, p_p) * litres);
            stroke.leakage.push(healthy.areas.leakage(q_a, q_b) * litres);
            stroke.leakage_printed.push(healthy.areas.leakage_printed(q_a, q_b) * litres);
            stroke.lost_opening.push(healthy.valve_at_p(p_p, p_a, q_p) * litres);
            stroke.blockage.push(healthy.blockage(p_pump, p_p, q_p) * litres);
        }
        stroke.time = time;
        Ok(stroke)
    }

    /// Means over the steady part of an outstroke against `load` newtons.
    pub fn steady(&self, faults: Faults, load: f64) -> Result<Steady, Box<dyn Error>> {
        let stroke = self.stroke(faults, load, STEADY.1)?;
        let rows = stroke.time.partition_point(|&t| t < STEADY.0 - INTERVAL / 2.0)..stroke.time.len();
        let mean = |values: &[f64]| values[rows.clone()].iter().sum::<f64>() / rows.len() as f64;
        let ends = (stroke.position[rows.start], stroke.position[rows.end - 1]);
        let velocity = (ends.1 - ends.0) * 1e-3 / (stroke.time[rows.end - 1] - stroke.time[rows.start]);
        Ok(Steady {
            velocity,
            flow_p: mean(&stroke.flow_p),
            flow_a: mean(&stroke.flow_a),
            flow_b: mean(&stroke.flow_b),
            healthy_valve: mean(&stroke.healthy_valve),
            healthy_control: mean(&stroke.healthy_control),
            leakage_moving: self.healthy.areas.leakage_moving(mean(&stroke.flow_a), velocity * 6e4),
            leakage: mean(&stroke.leakage),
            leakage_printed: mean(&stroke.leakage_printed),
            lost_opening: mean(&stroke.lost_opening),
            blockage: mean(&stroke.blockage),
        })
    }
}

/// From `from` to `to` in `steps` equal steps.
pub fn sweep(from: f64, to: f64, steps: usize) -> Vec<f64> {
    (0..=steps).map(|step| from + (to - from) * step as f64 / steps as f64).collect()
}

/// Where a rising curve has come within 1 % of its last value for good, between the points of the sweep by straight line.
pub fn saturates_at(x: &[f64], y: &[f64]) -> f64 {
    let wall = 0.99 * y[y.len() - 1];
    let below = (0..y.len()).rev().find(|&row| y[row] < wall);
    below.map_or(x[0], |row| x[row] + (x[row + 1] - x[row]) * (wall - y[row]) / (y[row + 1] - y[row]))
}
