//! Two tanks in a row by hand: Torricelli's law, weirs as rims, Runge-Kutta 4 with fixed steps.

use std::f64::consts::TAU;

use borescope::Unit;
use borescope::internals::campaign::random::Stream;
use borescope::internals::record::{Channel, Record};

const INTERVAL: f64 = 4.0;
const ROWS: usize = 700;
const STEPS: usize = 40;
/// Both tanks, m²; pump, m³/s per V; outlets, m³/s per root of a metre.
const AREA: f64 = 0.01;
const GAIN: f64 = 0.07e-3 / 60.0;
const OUTLETS: [f64; 2] = [1.9e-5, 1.9e-5];
/// A weir of 20 cm: m³/s per m^1.5.
const WEIR: f64 = 0.36;
/// Noise of the level, m.
const NOISE: f64 = 2e-4;

/// What the tanks may hide; at the defaults nothing.
#[derive(Debug, Clone)]
pub struct Tanks {
    pub dead_voltage: f64,
    /// Height, m, of the rim of each tank, and the share of what overflows from the upper one that the lower one gets.
    pub rims: [f64; 2],
    pub share: f64,
    pub outlets: [f64; 2],
}

impl Tanks {
    /// Tanks a few per cent off those of the rig file.
    pub fn healthy(random: &mut Stream) -> Self {
        let outlets = OUTLETS.map(|outlet| outlet * (1.0 + 0.05 * random.normal().clamp(-2.0, 2.0)));
        Self { dead_voltage: 0.0, rims: [f64::INFINITY; 2], share: 0.0, outlets }
    }

    fn rates(&self, [upper, lower]: [f64; 2], voltage: f64) -> [f64; 2] {
        let weir = |level: f64, rim: f64| WEIR * (level - rim).max(0.0).powf(1.5);
        let [first, second] = [upper, lower].map(|level| level.max(0.0).sqrt());
        let over = weir(upper, self.rims[0]);
        let through = self.outlets[0] * first;
        [
            (GAIN * (voltage - self.dead_voltage).max(0.0) - through - over) / AREA,
            (through + self.share * over - self.outlets[1] * second - weir(lower, self.rims[1])) / AREA,
        ]
    }

    /// Levels in m at the rows of a voltage that holds over each interval.
    pub fn run(&self, voltage: &[f64]) -> Vec<[f64; 2]> {
        let h = INTERVAL / STEPS as f64;
        let mut y = [0.05, 0.052];
        let mut levels = vec![y];
        for &u in &voltage[..voltage.len() - 1] {
            for _ in 0..STEPS {
                let along = |k: [f64; 2], s: f64| [y[0] + s * h * k[0], y[1] + s * h * k[1]];
                let a = self.rates(y, u);
                let b = self.rates(along(a, 0.5), u);
                let c = self.rates(along(b, 0.5), u);
                let d = self.rates(along(c, 1.0), u);
                for i in 0..2 {
                    y[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
                }
            }
            levels.push(y);
        }
        levels
    }

    pub fn record(&self, name: &str, voltage: Vec<f64>, random: &mut Stream) -> Record {
        let time = (0..voltage.len()).map(|row| row as f64 * INTERVAL).collect();
        let shown = self.run(&voltage).iter().map(|levels| levels[1] + NOISE * random.normal()).collect();
        let unit = |symbol: &str| symbol.parse::<Unit>().expect("a unit");
        // What the sensor of the rig file makes of its volts.
        let level = Channel::new("level_2", unit("cm"), shown);
        let channels = vec![Channel::new("pump_voltage", unit("V"), voltage), level];
        Record::new(name, time, channels)
    }
}

/// Slow waves of three periods between 0.5 and 5.5 V.
pub fn voltage(random: &mut Stream) -> Vec<f64> {
    let waves: Vec<(f64, f64)> =
        [700.0, 310.0, 140.0].map(|period| (period * random.uniform(0.8, 1.2), random.uniform(0.0, TAU))).to_vec();
    (0..ROWS)
        .map(|row| {
            let t = row as f64 * INTERVAL;
            let sum: f64 = waves.iter().map(|(period, phase)| (TAU * t / period + phase).sin()).sum();
            (3.0 + 1.1 * sum).clamp(0.5, 5.8)
        })
        .collect()
}
