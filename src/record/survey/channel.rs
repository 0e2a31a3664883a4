//! A channel by itself: dropouts, values that stand still, spikes.

use super::{Doubt, Finding, Scatter};
use crate::record::Channel;

/// Fewest rows of one value that are told.
const FEWEST: usize = 10;
/// Chance that noise alone makes a run as long somewhere in the record.
const BY_CHANCE: f64 = 1e-3;
/// Share of neighbours that are alike from which on a run of one value says nothing.
const MOSTLY: f64 = 0.8;
/// Median second difference, in standard deviations of the noise, below which a channel counts as computed rather than
/// measured; noise alone makes it 1.65, and steady motion nothing.
const MEASURED: f64 = 0.5;
/// Height of a spike, in standard deviations of the noise, and in median deviations of the rows around it.
const SPIKE: f64 = 8.0;
/// Rows on either side of a spike that say how restless the channel is there.
const AROUND: usize = 12;
/// Share of its height by which the rows beside a spike may differ.
const BESIDE: f64 = 0.25;

/// A bend of a channel is a second difference of more than so many standard deviations of its noise.
const BEND: f64 = 6.0;
/// Rows behind a bend, and before it, in which leaps of other channels are the circuit's.
const BEHIND: usize = 12;
const BEFORE: usize = 3;

/// A channel, and what others are judged by of it; where nothing is known of its noise it counts as computed, without bends.
pub(super) struct Known<'a> {
    channel: &'a Channel,
    scatter: Option<Scatter>,
    /// Whether it is as restless as its noise makes it.
    pub is_measured: bool,
    /// The rows at which it bends beyond its noise.
    pub bends: Vec<usize>,
}

impl<'a> Known<'a> {
    pub fn new(channel: &'a Channel, scatter: Option<Scatter>) -> Self {
        let is_measured = scatter.is_some_and(|scatter| is_measured(channel, scatter.noise));
        let bends = scatter.map_or_else(Vec::new, |scatter| bends(&channel.values, scatter));
        Self { channel, scatter, is_measured, bends }
    }
}

/// The rows at which values bend beyond their noise and what rounding to steps of the last digit adds, half a step to each.
fn bends(values: &[f64], scatter: Scatter) -> Vec<usize> {
    let least = BEND * 6f64.sqrt() * scatter.noise + 2.0 * scatter.resolution;
    let bent = |three: &[f64]| (three[0] - 2.0 * three[1] + three[2]).abs() > least;
    values.windows(3).enumerate().filter(|(_, three)| bent(three)).map(|(row, _)| row + 1).collect()
}

/// Whether one of the rows, which rise, is near `row`.
pub(super) fn is_near(rows: &[usize], row: usize) -> bool {
    let from = rows.partition_point(|bend| bend + BEHIND < row);
    rows.get(from).is_some_and(|bend| *bend <= row + BEFORE)
}

/// What is doubtful about a channel of a record in which any is measured, or none.
pub(super) fn survey(
    known: &Known<'_>,
    time: &[f64],
    any_measured: bool,
    (restless, switches): (impl Fn(usize) -> bool, impl Fn(f64) -> bool),
) -> Vec<Finding> {
    let channel = known.channel;
    let values = &channel.values;
    let of_rows = |doubt, rows, value| Finding::of_rows(doubt, channel, time, rows, value);
    let mut findings = Vec::new();
    let missing = values.iter().filter(|value| value.is_nan()).count();
    // A channel of a lower rate lacks most rows; each of its intervals is no doubt of its own.
    if 2 * missing > values.len() {
        let mut all = of_rows(Doubt::Dropout, 0..values.len(), None);
        all.rows = missing;
        findings.push(all);
    }
    let mut row = 0;
    for run in values.chunk_by(|a, b| a.is_nan() == b.is_nan()) {
        if 2 * missing <= values.len() && run.first().is_some_and(|value| value.is_nan()) {
            findings.push(of_rows(Doubt::Dropout, row..row + run.len(), None));
        }
        row += run.len();
    }
    let (Some(scatter), Some((least, greatest))) = (known.scatter, channel.range()) else { return findings };
    if least == greatest {
        let there = values.len() - missing;
        let doubt = if any_measured && scatter.moves(there) { Doubt::Dead } else { Doubt::Constant };
        if there >= FEWEST {
            findings.push(Finding { rows: there, ..of_rows(doubt, 0..values.len(), Some(least)) });
        }
        return findings;
    }
    if known.is_measured {
        let length = length_beyond_chance(values, scatter);
        // At rest a coarse sensor may read the same for ever: it sticks where another channel says that the circuit moves meanwhile.
        let is_coarse = at_rest(scatter) > MOSTLY;
        let moves = |rows: std::ops::Range<usize>| rows.into_iter().any(&restless);
        let mut row = 0;
        for run in values.chunk_by(|a, b| a == b) {
            let inside = row + 2 * BEHIND..(row + run.len()).saturating_sub(BEHIND);
            if length.is_some_and(|length| run.len() >= length) && (!is_coarse || moves(inside)) {
                let value = run.first().copied();
                let doubt =
                    if value == Some(least) || value == Some(greatest) { Doubt::Saturated } else { Doubt::Stuck };
                findings.push(of_rows(doubt, row..row + run.len(), value));
            }
            row += run.len();
        }
    }
    let leaps = (1..values.len().saturating_sub(1)).filter(|row| is_spike(values, *row, scatter));
    let leaps: Vec<usize> = leaps.collect();
    let spikes = leaps.iter().copied().filter(|&row| {
        let is_switched = time.get(row).is_some_and(|&time| switches(time));
        !restless(row) && (!is_switched || is_far_beyond(values, row, &leaps))
    });
    findings.extend(spikes.map(|row| of_rows(Doubt::Spike, row..row + 1, values.get(row).copied())));
    findings
}

/// Whether a value is further from all others that do not leap than those are from each other.
fn is_far_beyond(values: &[f64], row: usize, leaps: &[usize]) -> bool {
    let others =
        values.iter().enumerate().filter(|(row, value)| value.is_finite() && leaps.binary_search(row).is_err());
    let (least, greatest) = others.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), (_, value)| {
        (least.min(*value), greatest.max(*value))
    });
    values.get(row).is_some_and(|value| (least - value).max(value - greatest) > greatest - least)
}

/// Whether the channel is as restless as its noise makes it, away from its extremes and from where it holds one value: a sensor
/// that sticks for most of a record has been measured until then.
fn is_measured(channel: &Channel, noise: f64) -> bool {
    let Some((least, greatest)) = channel.range() else { return false };
    let inside = |value: &f64| value.is_finite() && *value != least && *value != greatest;
    let mut moving: Vec<bool> = Vec::with_capacity(channel.values.len());
    for run in channel.values.chunk_by(|a, b| a == b) {
        moving.extend(std::iter::repeat_n(run.len() < FEWEST, run.len()));
    }
    let threes = channel.values.windows(3).zip(moving.windows(3));
    let threes = threes.filter(|(three, moving)| three.iter().all(inside) && moving.iter().all(|moves| *moves));
    let mut bends: Vec<f64> = threes.map(|(three, _)| (three[0] - 2.0 * three[1] + three[2]).abs()).collect();
    bends.sort_by(f64::total_cmp);
    bends.get(bends.len() / 2).is_some_and(|median| *median >= MEASURED * noise)
}

/// Rows of one value from which on it is no chance, as often as neighbours are alike where the channel moves, and as one at rest in the
/// middle of a step of its last digit reads the same again; `None` where they nearly always are alike.
fn length_beyond_chance(values: &[f64], scatter: Scatter) -> Option<usize> {
    let (mut alike, mut pairs) = (0, 0);
    for run in values.chunk_by(|a, b| a == b).filter(|run| run.len() < FEWEST) {
        (alike, pairs) = (alike + run.len() - 1, pairs + run.len());
    }
    let share = alike as f64 / f64::from(pairs.max(1) as u32);
    if share > MOSTLY {
        return None;
    }
    let share = share.max(at_rest(scatter).min(MOSTLY)).max(1e-3);
    let length = 1.0 + (BY_CHANCE / values.len().max(1) as f64).ln() / share.ln();
    Some((length.ceil() as usize).max(FEWEST))
}

/// Share of the readings of a sensor at rest in the middle of a step of its last digit that are the same.
fn at_rest(scatter: Scatter) -> f64 {
    statrs::function::erf::erf(0.5 * scatter.resolution / (scatter.noise * std::f64::consts::SQRT_2))
}

/// Whether a value stands off from both its neighbours to the same side, and they are alike.
fn is_spike(values: &[f64], row: usize, scatter: Scatter) -> bool {
    let [before, here, after] = [values[row - 1], values[row], values[row + 1]];
    let (up, down) = (here - before, here - after);
    let height = up.abs().min(down.abs());
    // What lies at the edge of two steps of the last digit reads one or the other.
    let least = SPIKE * scatter.noise + scatter.resolution;
    if !(up * down > 0.0 && height > least && (after - before).abs() < BESIDE * height) {
        return false;
    }
    let around = values.get(row.saturating_sub(AROUND)..(row + AROUND + 1).min(values.len())).unwrap_or_default();
    let mut steps: Vec<f64> =
        around.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|s| s.is_finite()).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).is_some_and(|median| height > SPIKE * median)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Unit;

    #[test]
    fn one_value_of_a_coarse_sensor_at_rest_is_no_doubt() {
        // At rest in the middle of a step of 1.6 standard deviations noise leaves it in four rows of ten.
        let scatter = |resolution| Scatter { noise: 0.15, resolution };
        let moving: Vec<f64> = (0..2000).map(f64::from).collect();
        assert_eq!(length_beyond_chance(&moving, scatter(0.0)), Some(FEWEST));
        // 0.584 to the power of 27 is one in two millions.
        assert_eq!(length_beyond_chance(&moving, scatter(0.244)), Some(28));
        // A coarser one still sticks: after a run that one in 1.25 neighbours would make by chance.
        assert_eq!(length_beyond_chance(&moving, scatter(0.5)), Some(67));
    }

    #[test]
    fn a_coarse_sensor_sticks_only_while_the_circuit_moves() {
        // An encoder of 1 mm that reads the same for 200 rows between two travels.
        let travel = |from: f64| (0..200).map(move |row| (from + 1.3 * f64::from(row)).round());
        let values: Vec<f64> = travel(0.0).chain(std::iter::repeat_n(259.0, 200)).chain(travel(259.0)).collect();
        let time: Vec<f64> = (0..values.len()).map(|row| row as f64).collect();
        let channel = Channel::new("x", Unit::dimensionless(), values);
        let known = Known::new(&channel, Some(Scatter { noise: 0.12, resolution: 1.0 }));
        let told = |moves: &dyn Fn(usize) -> bool| {
            let found = survey(&known, &time, true, (moves, |_| false));
            found.iter().filter(|one| matches!(one.doubt, Doubt::Stuck | Doubt::Saturated)).count()
        };
        // Where it stops and where it starts again pressures bend; in between only if the circuit moves.
        assert_eq!(told(&|row| (198..212).contains(&row) || (395..410).contains(&row)), 0);
        assert_eq!(told(&|row| (300..315).contains(&row)), 1);
    }

    #[test]
    fn a_coarse_sensor_at_the_edge_of_two_steps_leaps_not() {
        // An encoder of 1 mm on a parked car, with noise of 0.12 mm: it flips once in a while, back with the next row.
        let mut values = vec![3798.0; 60];
        values[20] = 3799.0;
        let coarse = Scatter { noise: 0.12, resolution: 1.0 };
        assert!(!is_spike(&values, 20, coarse) && bends(&values, coarse).is_empty());
        // Three steps are a leap.
        values[40] = 3801.0;
        assert!(is_spike(&values, 40, coarse) && bends(&values, coarse).contains(&40));
    }

    /// Noise of standard deviation 1 that no chance repeats, rounded to a fifth of it.
    fn noisy(rows: usize) -> Vec<f64> {
        let uniform = |k: usize| ((k as f64 * 12.9898).sin() * 43_758.545_3).fract().abs();
        let normal = |k: usize| {
            (-2.0 * uniform(2 * k + 1).max(1e-12).ln()).sqrt() * (std::f64::consts::TAU * uniform(2 * k + 2)).cos()
        };
        (0..rows).map(|k| (normal(k) * 5.0).round() / 5.0).collect()
    }

    fn doubts(values: Vec<f64>) -> Vec<(Doubt, std::ops::Range<usize>)> {
        let time: Vec<f64> = (0..values.len()).map(|row| row as f64).collect();
        let channel = Channel::new("p", Unit::dimensionless(), values);
        let known = Known::new(&channel, Some(Scatter { noise: 1.0, resolution: 0.2 }));
        survey(&known, &time, true, (|_| false, |_| false))
            .into_iter()
            .map(|finding| (finding.doubt, finding.span))
            .collect()
    }

    #[test]
    fn a_sensor_that_sticks_for_most_of_a_record_is_seen() {
        for from in [60, 150, 400] {
            let mut values = noisy(500);
            let held = values[from];
            values[from..].fill(held);
            let found = doubts(values);
            assert_eq!(found.len(), 1, "{from}: {found:?}");
            let (doubt, span) = &found[0];
            // The row before may have shown the same by chance.
            assert!(
                matches!(doubt, Doubt::Stuck | Doubt::Saturated) && span.end == 500 && span.start + 1 >= from,
                "{found:?}"
            );
        }
        assert_eq!(doubts(noisy(500)), vec![]);
    }

    #[test]
    fn what_is_computed_may_stand_still() {
        let stairs: Vec<f64> = (0..500).map(|row: i32| f64::from(row / 100)).collect();
        assert_eq!(doubts(stairs), vec![]);
    }
}
