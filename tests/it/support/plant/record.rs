//! The plant run through a cycle, and what a logger wrote of it.

use borescope::Unit;
use borescope::internals::campaign::random::Stream;
use borescope::internals::record::{Channel, Record};
use ode_solvers::dop_shared::System;
use ode_solvers::{Rk4, SVector};

use super::{Acting, Plant, SENSORS, STATES};

const INTERVAL: f64 = 4e-3;
/// Fixed steps in an interval at the bulk modulus of the data sheet, in Pa, with which the stiffest rate of the plant, 4e5 /s, grows.
const STEPS: (f64, f64) = (600.0, 1.4e9);
/// Steps between two looks of the sensors.
const FINE: usize = 10;
/// Names, units, noise (1 sigma) and resolution of the sensors.
const LOGGED: [(&str, &str, f64, f64); SENSORS] = [
    ("p_pump", "bar", 0.25, 0.05),
    ("p_P", "bar", 0.25, 0.05),
    ("p_A", "bar", 0.25, 0.05),
    ("p_B", "bar", 0.25, 0.05),
    ("q_P", "L/min", 0.03, 0.005),
    ("q_A", "L/min", 0.03, 0.005),
    ("q_B", "L/min", 0.03, 0.005),
    ("x", "mm", 0.03, 0.005),
];

/// A command and a load for so many seconds.
pub type Phase = (f64, Acting);

/// One full stroke out and back, and a short one, under loads of their own, so many times the usual.
pub fn cycle(random: &mut Stream, loads: f64) -> Vec<Phase> {
    let mut load = |low: f64, high: f64| loads * random.uniform(low, high);
    let [rest, out, hold, pull, again] =
        [load(1000.0, 2000.0), load(1500.0, 4500.0), load(1500.0, 3000.0), load(-800.0, -200.0), load(2000.0, 5000.0)];
    vec![
        (0.4, [0.0, rest]),
        (1.3, [1.0, rest]),
        (1.3, [1.0, out]),
        (0.4, [0.0, hold]),
        (2.0, [-1.0, pull]),
        (0.4, [0.0, rest]),
        (1.2, [1.0, again]),
        (0.4, [0.0, again]),
        (0.6, [-1.0, pull]),
        (0.4, [0.0, rest]),
    ]
}

struct Running<'a> {
    plant: &'a Plant,
    acting: Acting,
}

impl System<f64, SVector<f64, STATES>> for Running<'_> {
    fn system(&self, _: f64, y: &SVector<f64, STATES>, dy: &mut SVector<f64, STATES>) {
        *dy = self.plant.rates(&(*y).into(), self.acting).0.into();
    }
}

/// What the plant's sensors follow, lags included, `[sensor][row]`, SI, and what acted over the interval before each row.
fn run(plant: &Plant, phases: &[Phase]) -> (Vec<Vec<f64>>, Vec<Acting>) {
    let looks = (STEPS.0 * (plant.bulk_modulus / STEPS.1).max(1.0) / FINE as f64).ceil();
    // A little longer, so that rounding adds no step to the interval.
    let step = INTERVAL / looks / FINE as f64 * (1.0 + 1e-9);
    let keep =
        plant.readings.map(|reading| if reading.lag > 0.0 { (-INTERVAL / looks / reading.lag).exp() } else { 0.0 });
    let seen = |y: &[f64; STATES], acting: Acting| {
        let (_, flows) = plant.rates(y, acting);
        let near = |side: usize| if plant.lines[side].is_some() { y[10 + side] } else { y[2 + side] };
        [y[0], y[1], near(0), near(1), flows[0], flows[1], flows[2], y[4]]
    };
    let mut y = plant.start(phases[0].1[1]);
    let mut followed = seen(&y, phases[0].1);
    let mut rows: Vec<Vec<f64>> = followed.iter().map(|&value| vec![value]).collect();
    let mut acted: Vec<Acting> = Vec::new();
    for &(duration, acting) in phases {
        for _ in 0..(duration / INTERVAL).round() as usize {
            let plant = &plant.warm((acted.len() as f64 + 0.5) * INTERVAL);
            // Until its dead time is over the spool follows the command before.
            let commanded = acted.len().checked_sub(plant.dead_rows).and_then(|row| acted.get(row));
            let command =
                if plant.dead_rows == 0 { acting[0] } else { commanded.map_or(phases[0].1[0], |then| then[0]) };
            let late = [command, acting[1]];
            let mut stepper = Rk4::new(Running { plant, acting: late }, 0.0, y.into(), INTERVAL, step);
            stepper.integrate().expect("fixed steps");
            for state in stepper.y_out().iter().skip(FINE).step_by(FINE) {
                for ((value, now), keep) in followed.iter_mut().zip(seen(&(*state).into(), late)).zip(keep) {
                    *value = now + (*value - now) * keep;
                }
            }
            y = (*stepper.y_out().last().expect("an end")).into();
            for (row, value) in rows.iter_mut().zip(followed) {
                row.push(value);
            }
            acted.push(acting);
        }
    }
    (rows, acted)
}

/// A record as a logger writes it: lags, delays, gains, offsets, limits, noise, rounding.
pub fn record(name: &str, plant: &Plant, phases: &[Phase], random: &mut Stream) -> Record {
    let (raw, acted) = run(plant, phases);
    let rows = acted.len();
    let time: Vec<f64> = (1..=rows).map(|row| row as f64 * INTERVAL).collect();
    let mut channels = Vec::new();
    let column = |name: &str, unit: &str, decimals: usize, values: Vec<f64>| {
        let unit: Unit = unit.parse().expect("a unit");
        let si = values.into_iter().map(|value| unit.to_si(value)).collect();
        Channel::new(name, unit, si).with_decimals(decimals)
    };
    channels.push(column("valve_command", "-", 2, acted.iter().map(|acting| acting[0]).collect()));
    let load = acted.iter().map(|acting| (acting[1] + 15.0 * random.normal()).round()).collect();
    channels.push(column("F_load", "N", 0, load));
    for (sensor, (name, symbol, noise, resolution)) in LOGGED.into_iter().enumerate() {
        let reading = plant.readings[sensor];
        let unit: Unit = symbol.parse().expect("a unit");
        let mut read = Vec::with_capacity(rows);
        for row in 1..=rows {
            // A late sensor shows what was; straight between rows.
            let at = (row as f64 - reading.delay / INTERVAL).max(0.0);
            let (low, share) = (at.floor() as usize, at.fract());
            let now = raw[sensor][low] + share * (raw[sensor][(low + 1).min(rows)] - raw[sensor][low]);
            let seen = (reading.gain * now + reading.offset).min(reading.limit);
            let shown = unit.from_si(seen) + noise * random.normal();
            read.push((shown / resolution).round() * resolution);
        }
        channels.push(column(name, symbol, 3, read));
    }
    if plant.logs_temperature {
        let shown = |t: &f64| ((plant.temperature(*t) + 0.1 * random.normal()) * 10.0).round() / 10.0;
        channels.push(column("T_oil", "degC", 1, time.iter().map(shown).collect()));
    }
    Record::new(name, time, channels)
}
