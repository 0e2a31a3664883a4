//! Two-sided CUSUM with a designed time between false alarms.
//!
//! Page (1954); run length by Siegmund, Sequential Analysis (1985), section 2.6: a one-sided CUSUM of independent standard
//! normals with reference value `k` and threshold `h` raises an alarm every
//! `(exp(2 k b) - 2 k b - 1)/(2 k²)` values on average, `b = h + 1.166`.

/// Mean excess of a normal random walk over a threshold, both ends (Siegmund 1985, 2 x 0.583).
const OVERSHOOT: f64 = 1.166;

/// Mean number of values between false alarms of a one-sided CUSUM with reference value `k` > 0 and threshold `h`, both
/// in standard deviations. Worked: `k = 0.5, h = 5` gives 938 (exactly: 931).
pub fn run_length(k: f64, h: f64) -> f64 {
    let b = h + OVERSHOOT;
    ((2.0 * k * b).exp() - 2.0 * k * b - 1.0) / (2.0 * k * k)
}

/// Threshold in standard deviations at which a one-sided CUSUM runs `length` values between false alarms on average.
pub fn threshold(k: f64, length: f64) -> f64 {
    // The run length grows faster than 2 b², so this bound holds for every k.
    let (mut low, mut high) = (0.0, 1.0);
    while run_length(k, high) < length {
        high *= 2.0;
    }
    while high - low > 1e-9 * high {
        let middle = f64::midpoint(low, high);
        if run_length(k, middle) < length { low = middle } else { high = middle }
    }
    high
}

/// The side on which the sum crossed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// The residual is too large.
    High,
    /// The residual is too small.
    Low,
}

/// A crossing of the threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Alarm {
    /// Index of the value at which the sum crossed.
    pub at: usize,
    /// Index of the first value after the sum was last zero: the likeliest onset.
    pub onset: usize,
    pub direction: Direction,
}

/// Both running sums of one residual; `M` marks where a sum left zero.
#[derive(Debug, Clone)]
pub(super) struct Running<M> {
    sides: [(f64, Option<M>); 2],
}

impl<M> Default for Running<M> {
    fn default() -> Self {
        Self { sides: [(0.0, None), (0.0, None)] }
    }
}

impl<M: Copy> Running<M> {
    /// Takes the next value with its allowance and its mark, against the reference value `k` and the threshold `h`, all but the
    /// mark in standard deviations: the side that crosses, and the mark of the first value after it was last zero.
    pub fn step(&mut self, value: f64, allowance: f64, (k, h): (f64, f64), mark: M) -> Option<(Direction, M)> {
        for ((sum, onset), (sign, direction)) in self.sides.iter_mut().zip(SIDES) {
            let next = *sum + sign * value - k - allowance;
            if next <= 0.0 {
                (*sum, *onset) = (0.0, None);
                continue;
            }
            *sum = next;
            let onset = *onset.get_or_insert(mark);
            if next > h {
                return Some((direction, onset));
            }
        }
        None
    }
}

const SIDES: [(f64, Direction); 2] = [(1.0, Direction::High), (-1.0, Direction::Low)];

/// First crossing by either side; `allowances` are added to the reference value `k` value by value.
///
/// `values` are in standard deviations, as are `allowances`: a bias within its allowance only lowers the sum.
pub fn first_alarm(values: &[f64], allowances: &[f64], k: f64, h: f64) -> Option<Alarm> {
    let mut running = Running::default();
    values.iter().zip(allowances).enumerate().find_map(|(at, (&value, &allowance))| {
        let (direction, onset) = running.step(value, allowance, (k, h), at)?;
        Some(Alarm { at, onset, direction })
    })
}

/// The larger of both running sums behind each value; they go on behind an alarm.
#[cfg(feature = "cli")]
pub(super) fn sums(values: &[f64], allowances: &[f64], k: f64) -> Vec<f64> {
    let (mut high, mut low) = (0.0_f64, 0.0_f64);
    let step = |(value, allowance): (&f64, &f64)| {
        high = (high + value - k - allowance).max(0.0);
        low = (low - value - k - allowance).max(0.0);
        high.max(low)
    };
    values.iter().zip(allowances).map(step).collect()
}
