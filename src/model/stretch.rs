//! One input between the rows of its record, as a broken line.

use crate::rig::{Hold, Input};

/// One input as a broken line: `value(t)` runs from `from` to `to` within each stretch, and may jump between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub start: f64,
    pub end: f64,
    pub from: f64,
    pub to: f64,
    /// Whether it is a jump where it does not go on from the stretch before.
    pub may_jump: bool,
}

impl Stretch {
    /// Its value at a time, s.
    pub(super) fn at(&self, time: f64) -> f64 {
        self.from + (time - self.start) / (self.end - self.start) * (self.to - self.from)
    }

    /// Whether a later point lies on its line.
    pub(super) fn goes_through(&self, time: f64, value: f64) -> bool {
        let there = self.at(time);
        (there - value).abs() <= STRAIGHT * there.abs().max(self.from.abs()).max(self.to.abs())
    }
}

/// A jump between neighbouring rows is one of more than this many standard deviations of their difference:
/// one false jump in 10^9 rows.
const JUMP: f64 = 6.0;
/// Standard deviation of normal values in medians of their magnitudes.
const DEVIATION: f64 = 1.4826;
/// Largest excursion of the running sum of n misfits, in `sigma sqrt(n)`, that noise makes in 99 % of cases
/// (Kolmogorov distribution).
const EXCURSION: f64 = 1.63;

/// An input between the rows that it has, as its way to hold says.
pub(super) fn broken_line(input: &Input, time: &[f64], values: &[f64], interval: f64) -> Vec<Stretch> {
    // Interval over which each row's value holds.
    let holds = |row: usize| match input.hold {
        Hold::Before => (if row == 0 { time[0] - interval } else { time[row - 1] }, time[row]),
        Hold::After | Hold::Linear => (time[row], time.get(row + 1).copied().unwrap_or(time[row] + interval)),
    };
    if input.noise > 0.0 {
        return smooth(input, time, values, holds);
    }
    if input.hold == Hold::Linear {
        // The last row holds as long as any.
        let end = time.last().zip(values.last()).map(|(time, value)| (time + interval, *value));
        return through(time.iter().copied().zip(values.iter().copied()).chain(end));
    }
    let least = SMALL * values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let mut line: Vec<Stretch> = Vec::new();
    for (row, &value) in values.iter().enumerate() {
        let (start, end) = holds(row);
        match line.last_mut() {
            Some(last) if last.to == value => last.end = end,
            last => {
                let leap = last.map_or(0.0, |last| (value - last.to).abs());
                let may_jump = leap > least && leap > JUMP * DEVIATION * usual_step(values, row);
                line.push(Stretch { start, end, from: value, to: value, may_jump });
            }
        }
    }
    line
}

/// Share of the largest value of a held input that it has to leap by for a jump: by a fiftieth of its command a valve changes what
/// it passes by about as much, and a lag that is off by its quarter then moves no reading by more than a two-hundredth of a full stroke's.
const SMALL: f64 = 0.02;

/// Median step, without its sign, of the rows around one: 0 where an input stands still between its jumps. A controller moves its
/// command from row to row, and only what stands out from its steps there is a jump, as it is from noise.
fn usual_step(values: &[f64], row: usize) -> f64 {
    let mut steps: Vec<f64> = around(values, row).map(|step: f64| step.abs()).collect();
    median(&mut steps)
}

/// The steps to the rows around one.
fn around(values: &[f64], row: usize) -> impl Iterator<Item = f64> {
    let first = row.saturating_sub(AROUND).max(1);
    (first..values.len().min(row + AROUND + 1)).map(|k| values[k] - values[k - 1])
}

/// The middle one of some numbers, 0 of none.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Change of slope, relative to the value, that is rounding.
const STRAIGHT: f64 = 1e-9;

/// The broken line through points, time before value, with corners only where it bends: the solver stops at each.
pub(super) fn through(points: impl Iterator<Item = (f64, f64)>) -> Vec<Stretch> {
    let mut line: Vec<Stretch> = Vec::new();
    let mut before = None;
    for (end, to) in points {
        let Some((start, from)) = before.replace((end, to)) else { continue };
        match line.last_mut() {
            Some(last) if last.goes_through(end, to) => (last.end, last.to) = (end, to),
            _ => line.push(Stretch { start, end, from, to, may_jump: true }),
        }
    }
    line
}

/// A noisy input as broken lines between its jumps, with no more knots than the noise can tell from fewer. Where it runs straight from
/// row to row, a jump does so too.
fn smooth(input: &Input, time: &[f64], values: &[f64], holds: impl Fn(usize) -> (f64, f64)) -> Vec<Stretch> {
    let is_straight = input.hold == Hold::Linear;
    let mut line: Vec<Stretch> = Vec::new();
    let mut first = 0;
    for row in 1..=values.len() {
        if row < values.len() && !jumps(values, row, input.noise) {
            continue;
        }
        let rows = first..row;
        // A held value stands for the middle of its interval.
        let middle: Vec<f64> = rows
            .clone()
            .map(|row| if is_straight { time[row] } else { f64::midpoint(holds(row).0, holds(row).1) })
            .collect();
        let is_last = row == values.len();
        let (start, end) = (holds(first).0, if is_straight && !is_last { time[row - 1] } else { holds(row - 1).1 });
        let between = if end > start {
            fit_line(&middle, &values[rows], start, end, input.noise)
        } else {
            vec![Stretch { start, end, from: values[first], to: values[first], may_jump: true }]
        };
        if is_straight && let (Some(before), Some(behind)) = (line.last(), between.first()) {
            line.push(Stretch { start: before.end, end: start, from: before.to, to: behind.from, may_jump: true });
        }
        line.extend(between);
        first = row;
    }
    line.retain(|stretch| stretch.end > stretch.start);
    line
}

/// Whether an input that is measured jumps anywhere between its rows.
pub(crate) fn is_measured_to_jump(input: &Input, values: &[f64]) -> bool {
    input.noise > 0.0 && (1..values.len()).any(|row| jumps(values, row, input.noise))
}

/// Whether the value leaves the row before by more than noise and the ramp around it explain.
fn jumps(values: &[f64], row: usize, sigma: f64) -> bool {
    let ramp = median(&mut around(values, row).collect::<Vec<_>>());
    (values[row] - values[row - 1] - ramp).abs() > JUMP * std::f64::consts::SQRT_2 * sigma
}

/// Rows to each side of one whose steps are the usual ones there.
const AROUND: usize = 4;

/// Least-squares broken line through samples, halving intervals until the misfit looks like noise.
pub(super) fn fit_line(time: &[f64], values: &[f64], start: f64, end: f64, sigma: f64) -> Vec<Stretch> {
    let mut knots = vec![start, end];
    loop {
        let heights = fit_heights(time, values, &knots);
        let mut refined = vec![start];
        for (pair, height) in knots.windows(2).zip(heights.windows(2)) {
            let rows = time.partition_point(|&t| t < pair[0])..time.partition_point(|&t| t < pair[1]);
            let (mut sum, mut largest) = (0.0_f64, 0.0_f64);
            for row in rows.clone() {
                let share = (time[row] - pair[0]) / (pair[1] - pair[0]);
                sum += values[row] - height[0] - share * (height[1] - height[0]);
                largest = largest.max(sum.abs());
            }
            if rows.len() >= 4 && largest > EXCURSION * sigma * (rows.len() as f64).sqrt() {
                refined.push(f64::midpoint(pair[0], pair[1]));
            }
            refined.push(pair[1]);
        }
        if refined.len() == knots.len() {
            let pairs = knots.windows(2).zip(heights.windows(2));
            return pairs
                .map(|(t, y)| Stretch { start: t[0], end: t[1], from: y[0], to: y[1], may_jump: true })
                .collect();
        }
        knots = refined;
    }
}

/// Heights at the knots of the continuous broken line nearest to the samples (tridiagonal normal equations).
fn fit_heights(time: &[f64], values: &[f64], knots: &[f64]) -> Vec<f64> {
    let n = knots.len();
    let (mut diagonal, mut beside, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let mut interval = 0;
    for (&t, &value) in time.iter().zip(values) {
        while interval + 2 < n && t > knots[interval + 1] {
            interval += 1;
        }
        let share = (t - knots[interval]) / (knots[interval + 1] - knots[interval]);
        let (low, high) = (1.0 - share, share);
        diagonal[interval] += low * low;
        diagonal[interval + 1] += high * high;
        beside[interval] += low * high;
        right[interval] += low * value;
        right[interval + 1] += high * value;
    }
    // A little pull towards the neighbour keeps a knot without samples, or a stretch of one row, defined.
    let pull = 1e-9 * diagonal.iter().sum::<f64>().max(1.0);
    for k in 0..n - 1 {
        diagonal[k] += pull;
        diagonal[k + 1] += pull;
        beside[k] -= pull;
    }
    for k in 1..n {
        let factor = beside[k - 1] / diagonal[k - 1];
        diagonal[k] -= factor * beside[k - 1];
        right[k] -= factor * right[k - 1];
    }
    let mut heights = vec![0.0; n];
    for k in (0..n).rev() {
        let above = if k + 1 < n { beside[k] * heights[k + 1] } else { 0.0 };
        heights[k] = (right[k] - above) / diagonal[k];
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a held input of rows a second apart jumps.
    fn jumps_of(values: &[f64]) -> Vec<f64> {
        let input = Input {
            hold: Hold::After,
            ..crate::rig::Rig::read("fixtures/telescopic/rig.toml").unwrap().inputs[0].clone()
        };
        let time: Vec<f64> = (0..values.len()).map(|row| row as f64).collect();
        let line = broken_line(&input, &time, values, 1.0);
        line.iter().skip(1).filter(|stretch| stretch.may_jump).map(|stretch| stretch.start).collect()
    }

    /// A load that is measured at 0 s to 5 s and runs straight from row to row: what the model gets of it at each half second.
    fn straight(values: [f64; 6]) -> Vec<f64> {
        let rig = crate::rig::Rig::read("fixtures/regeneration/rig.toml").unwrap();
        let load = rig.inputs.iter().find(|input| input.hold == Hold::Linear && input.noise > 0.0).unwrap();
        let line = broken_line(load, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], &values, 1.0);
        let at = |t: f64| {
            let stretch = line.iter().find(|stretch| t <= stretch.end).unwrap();
            stretch.from + (t - stretch.start) / (stretch.end - stretch.start) * (stretch.to - stretch.from)
        };
        (1..10).map(|half| at(0.5 * f64::from(half))).collect()
    }

    #[test]
    fn a_measured_load_that_runs_straight_jumps_between_its_rows() {
        let near = |found: Vec<f64>, wanted: [f64; 9]| {
            found
                .iter()
                .zip(wanted)
                .for_each(|(found, wanted)| approx::assert_abs_diff_eq!(*found, wanted, epsilon = 1e-3));
        };
        let (a, b, m) = (1000.0, 9000.0, 5000.0);
        near(straight([a, a, a, b, b, b]), [a, a, a, a, m, b, b, b, b]);
        // At the first row, at the last one, and by a single one.
        near(straight([a, b, b, b, b, b]), [m, b, b, b, b, b, b, b, b]);
        near(straight([a, a, a, a, a, b]), [a, a, a, a, a, a, a, a, m]);
        near(straight([a, a, b, a, a, a]), [a, a, m, b, m, a, a, a, a]);
    }

    #[test]
    fn only_what_stands_out_from_the_steps_around_it_is_a_jump() {
        assert_eq!(jumps_of(&[0.0, 0.0, 0.0, 0.2, 0.2, 0.2, 1.0, 1.0, 1.0]), [3.0, 6.0]);
        // A controller that is at rest, moves by a hundredth from row to row, switches, and is at rest again but for a last digit.
        let moved = (0..50).map(|row| f64::from(row) * 0.01);
        let mut controlled: Vec<f64> = std::iter::repeat_n(0.0, 50).chain(moved).collect();
        controlled.extend(std::iter::repeat_n(-0.8, 50));
        controlled.extend((0..50).map(|row| -0.8 + 0.001 * f64::from(row / 10)));
        assert_eq!(jumps_of(&controlled), [100.0]);
    }
}
