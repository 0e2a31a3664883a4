//! What a record and its rig file say differently, although every column is there: a start elsewhere, another unit.

use super::{NodeKind, Rig, Sensor, Target};
use crate::record::Record;
use crate::report::number::{in_unit, rounded, text, with_unit};

/// Readings whose mean is where a body starts.
const ROWS: usize = 3;
/// Standard deviations of the noise beyond which a body starts elsewhere.
const ELSEWHERE: f64 = 6.0;
/// Share of its range by which an input may leave it: an amplifier may overdrive its valve.
const BEYOND: f64 = 0.5;
/// Share by which a ratio of intervals may miss a power of a thousand.
const NEAR: f64 = 0.05;

impl Rig {
    /// What a record and the rig file say differently, each in words with what would bring them together.
    pub fn at_odds(&self, record: &Record) -> Vec<String> {
        let starts = self.sensors.iter().filter_map(|sensor| self.starts_elsewhere(record, sensor));
        let starts = starts.map(|(node, column, shown, given)| {
            format!(
                "`{column}` begins at {shown}, where the rig file starts `{node}` at {given}: write `position = \"{shown}\"` into the \
                 line of `{node}`, best for a record that begins at rest"
            )
        });
        starts.chain(self.commands(record)).chain(self.another_clock(record)).collect()
    }

    /// Whether a body begins away from where the rig file starts it.
    pub fn begins_within_a_run(&self, record: &Record) -> bool {
        self.sensors.iter().any(|sensor| self.starts_elsewhere(record, sensor).is_some())
    }

    /// Node and column of a body that begins elsewhere than the rig file says, by more than noise and an offset of its sensor
    /// explain; where, and where the rig file has it.
    fn starts_elsewhere(&self, record: &Record, sensor: &Sensor) -> Option<(String, String, String, String)> {
        let Target::Node(node) = sensor.target else { return None };
        let NodeKind::Body { position, .. } = self.nodes[node].kind else { return None };
        let dimension = sensor.quantity.dimension();
        let channel = record.channel(&sensor.column).filter(|channel| channel.unit.dimension == dimension)?;
        if sensor.quantity != super::Quantity::Position {
            return None;
        }
        let first: Vec<f64> = channel.values.iter().copied().filter(|value| value.is_finite()).take(ROWS).collect();
        let shown = first.iter().sum::<f64>() / first.len() as f64;
        let offset = self.faults.iter().find(|fault| fault.parameter == sensor.first_parameter);
        let offset = offset.map_or(0.0, |fault| fault.bounds.0.abs().max(fault.bounds.1.abs()));
        if first.is_empty() || (shown - position).abs() <= offset + ELSEWHERE * sensor.noise {
            return None;
        }
        let said = |si: f64| with_unit(rounded(in_unit(si, &channel.unit), 4), &channel.unit.to_string());
        Some((self.nodes[node].name.clone(), channel.name.clone(), said(shown), said(position)))
    }

    /// Inputs that run far beyond what their component works with.
    fn commands(&self, record: &Record) -> impl Iterator<Item = String> {
        let used = self.components.iter().flat_map(|component| component.inputs.iter().zip(component.card.inputs));
        let mut told: Vec<String> = Vec::new();
        for (&input, card) in used {
            let (low, high) = card.range;
            let Some(channel) = record.channel(&self.inputs[input].column) else { continue };
            let room = BEYOND * (high - low);
            let beyond = |value: &f64| *value < low - room || *value > high + room;
            if channel.unit.dimension == self.inputs[input].unit.dimension && channel.values.iter().any(beyond) {
                let finite = || channel.values.iter().copied().filter(|value| value.is_finite());
                let (least, greatest) =
                    (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
                told.push(format!(
                    "`{}` runs from {} to {}, a {} from {} to {}: give its line in the rig file a `scale`",
                    channel.name,
                    text(rounded(least, 4)),
                    text(rounded(greatest, 4)),
                    card.name,
                    text(low),
                    text(high)
                ));
            }
        }
        told.into_iter()
    }

    /// A record whose rows are a thousand times as far apart as those of the rig's own cycle, or as near.
    fn another_clock(&self, record: &Record) -> Option<String> {
        let ratio = record.sampling()?.interval / self.cycle.as_ref()?.interval;
        let power = (ratio.log10() / 3.0).round();
        let near = (ratio / 1000_f64.powf(power) - 1.0).abs() < NEAR;
        (power != 0.0 && near).then(|| {
            format!(
                "one row every {} s, {} times the interval of the rig file's cycle: is the time in another unit?",
                text(rounded(record.sampling().map_or(0.0, |sampling| sampling.interval), 6)),
                text(rounded(ratio, 3))
            )
        })
    }
}
