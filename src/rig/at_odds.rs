//! What a record and its rig file say differently, although every column is there: a start elsewhere, another unit.

use super::parse::card_unit;
use super::{Node, NodeKind, Quantity, Rig, Target};
use crate::complaint::{Complaint, Kind};
use crate::number::{in_unit, rounded, text, with_unit};
use crate::physics::card;
use crate::physics::fluid;
use crate::record::{Channel, Record};
use crate::units::Quantity as Amount;

/// Standard deviations of the noise beyond which a body starts elsewhere.
const ELSEWHERE: f64 = 6.0;
/// Share of its range by which an input may leave it: an amplifier may overdrive its valve.
const BEYOND: f64 = 0.5;
/// Times the most of the rig's own cycle that an input reaches: another machine's command is not ten times as large, per cent are a hundred.
const BEYOND_CYCLE: f64 = 10.0;
/// Relative difference of two values that are the same in two units.
const ROUNDING: f64 = 1e-12;
/// Lines of a draft that are named.
const LINES_NAMED: usize = 20;
/// Share by which a ratio of intervals may miss a power of a thousand.
const NEAR: f64 = 0.05;

/// A body whose sensor shows that it begins at `shown`, offset and gain taken off, where the rig file has it at `given`, SI.
struct Start<'a> {
    node: &'a Node,
    channel: &'a Channel,
    shown: f64,
    given: f64,
}

impl Rig {
    /// What a record and the rig file say differently, each in words with what would bring them together.
    pub fn at_odds(&self, record: &Record) -> Vec<String> {
        let starts = self.starts_elsewhere(record).map(|start| {
            let said = |si: f64| with_unit(rounded(in_unit(si, &start.channel.unit), 4), &start.channel.unit.to_string());
            let (column, node, shown) = (&start.channel.name, &start.node.name, said(start.shown));
            format!(
                "`{column}` begins at {shown}, where the rig file starts `{node}` at {}: write `position = \"{shown}\"` into the \
                 line of `{node}`, or `position = \"record\"` where records begin apart, best for records that begin at rest",
                said(start.given)
            )
        });
        let commands = self.commands(record).into_iter().chain(self.beyond_the_cycle(record));
        starts.chain(commands).chain(self.another_clock(record)).chain(self.coldness(record)).collect()
    }

    /// Nodes of which the rig file leaves to a record where they start, where there is none; `help` says what to write.
    pub(crate) fn starts_unknown(&self, is: impl Fn(&NodeKind) -> bool, help: &str) -> Option<Complaint> {
        let unknown: Vec<&Node> = self.nodes.iter().filter(|node| is(&node.kind)).collect();
        let names: Vec<String> = unknown.iter().map(|node| format!("`{}`", node.name)).collect();
        let what = match names.as_slice() {
            [] => return None,
            [one] => format!("node {one} starts at what its sensor shows first, but there is no record"),
            several => {
                format!("nodes {} start at what their sensors show first, but there is no record", several.join(", "))
            }
        };
        let complaint = Complaint::new(Kind::MissingEntry, what).help(help);
        Some(unknown.into_iter().fold(complaint, |complaint, node| complaint.at(node.place.clone())))
    }

    /// Samples of a record that are no more than what a fit may choose: what the rig file leaves open, and of each sensor a level and a
    /// slope, which its tolerance allows in a phase. So few contradict nearly nothing.
    pub(crate) fn few_samples(&self, record: &Record) -> Option<String> {
        let there = |channel: &Channel| channel.values.iter().filter(|value| value.is_finite()).count();
        let sensors: Vec<usize> =
            self.sensors.iter().filter_map(|one| self.sensor_column(record, one).ok().map(there)).collect();
        let samples: usize = sensors.iter().sum();
        let open = (0..self.parameters.len()).filter(|&index| self.is_fitted(index)).count();
        let free = open + 2 * sensors.len();
        (record.time.len() > 1 && samples > 0 && samples <= free).then(|| {
            format!(
                "{} rows give {samples} samples of sensors, no more than the {free} values that a fit may choose: `healthy` or `adequate` \
                 says little of so few",
                record.time.len()
            )
        })
    }

    /// Values that are still those of a draft, in words with their lines.
    pub fn unfilled_values(&self) -> Option<String> {
        let lines: Vec<String> = self.unfilled.iter().take(LINES_NAMED).map(usize::to_string).collect();
        let more = if self.unfilled.len() > LINES_NAMED { " and more" } else { "" };
        let (values, are, lines) = match self.unfilled.len() {
            0 => return None,
            1 => ("One value".to_owned(), "is", format!("line {}", lines.join(", "))),
            count => (format!("{count} values"), "are", format!("lines {}{more}", lines.join(", "))),
        };
        Some(format!(
            "{values} {are} still marked DATA SHEET ({lines}): put in those of your machine, and take the marks away"
        ))
    }

    /// What is doubtful in the rig file alone, each in words.
    pub fn doubts(&self) -> Vec<String> {
        self.stated_twice().chain(self.unusual()).collect()
    }

    /// Values beyond what catalogues have.
    fn unusual(&self) -> impl Iterator<Item = String> {
        let fluid = fluid::CARD.parameters.iter().zip(0..);
        let of_components = self.components.iter().flat_map(|one| one.card.parameters.iter().zip(one.parameters()));
        fluid.chain(of_components).filter_map(|(card, own)| {
            let parameter = &self.parameters[own];
            let unit = card_unit(card.unit);
            let (low, high) = card.usual;
            let value = in_unit(parameter.value, &unit);
            let range = || format!("{} to {}", text(low), with_unit(high, &unit.symbol));
            (!(low..=high).contains(&value)).then(|| {
                let (id, place, value) = (&parameter.id, &parameter.place, with_unit(value, &unit.symbol));
                format!("`{id}` is {value} ({place}), where {} is usual: is its unit right?", range())
            })
        })
    }

    /// Parameters whose component has another value than their fault has as the healthy one, each in words.
    fn stated_twice(&self) -> impl Iterator<Item = String> {
        self.faults.iter().filter_map(|fault| {
            let parameter = &self.parameters[fault.parameter];
            let shown = |value: f64| Amount { value, unit: parameter.unit.clone() };
            let (value, healthy) = (parameter.value, fault.healthy);
            ((value - healthy).abs() > ROUNDING * value.abs().max(healthy.abs())).then(|| {
                format!(
                    "`{}` is {} ({}) and as a fault {} when healthy ({}): `simulate` takes the first, `diagnose` the second; leave \
                     `healthy` out, or write the same value",
                    parameter.id,
                    shown(parameter.value),
                    parameter.place,
                    shown(fault.healthy),
                    fault.place
                )
            })
        })
    }

    /// Whether a body begins away from where the rig file starts it.
    pub(crate) fn begins_within_a_run(&self, record: &Record) -> bool {
        self.starts_elsewhere(record).next().is_some()
    }

    /// Bodies that begin elsewhere than the rig file says, by more than noise and an offset of their sensor explain.
    fn starts_elsewhere<'a>(&'a self, record: &'a Record) -> impl Iterator<Item = Start<'a>> {
        self.sensors.iter().filter(|sensor| sensor.quantity == Quantity::Position).filter_map(|sensor| {
            let Target::Node(node) = sensor.target else { return None };
            let node = &self.nodes[node];
            let NodeKind::Body { position: Some(given), .. } = node.kind else { return None };
            let channel = self.sensor_column(record, sensor).ok()?;
            let value = |parameter: usize| self.parameters[parameter].value;
            let (offset, gain) = (value(sensor.first_parameter), value(sensor.first_parameter + 1));
            let shown = (channel.begins_at()? - offset) / gain;
            let offset = self.faults.iter().find(|fault| fault.parameter == sensor.first_parameter);
            let offset = offset.map_or(0.0, |fault| fault.bounds.0.abs().max(fault.bounds.1.abs()));
            let elsewhere = (shown - given).abs() > offset + ELSEWHERE * sensor.noise;
            elsewhere.then_some(Start { node, channel, shown, given })
        })
    }

    /// A viscosity over the temperature, and none measured.
    fn coldness(&self, record: &Record) -> Option<String> {
        let input = self.temperature.as_ref().map(|temperature| &temperature.input)?;
        let missing = record.channel(&input.column).is_none_or(Channel::is_empty);
        (missing && self.viscosity_varies()).then(|| {
            format!(
                "there is no `{}`, so the fluid is taken at the temperature of its viscosity throughout",
                input.column
            )
        })
    }

    /// Inputs that run far beyond what their component works with.
    fn commands(&self, record: &Record) -> Vec<String> {
        let used = self.components.iter().flat_map(|component| component.inputs.iter().zip(component.card.inputs));
        let beyond = |(&input, card): (&usize, &card::Input)| {
            let (low, high) = card.range;
            let channel = self.input_column(record, &self.inputs[input]).ok()?;
            let (least, greatest) = channel.range()?;
            let room = BEYOND * (high - low);
            (least < low - room || greatest > high + room).then(|| {
                format!(
                    "`{}` runs from {} to {}, a {} from {} to {}: give its line in the rig file a `scale`",
                    channel.name,
                    text(rounded(least, 4)),
                    text(rounded(greatest, 4)),
                    card.name,
                    text(low),
                    text(high)
                )
            })
        };
        used.filter_map(beyond).collect()
    }

    /// Inputs that go so far beyond what the rig's own cycle has of them that they may be in another unit, such as per cent.
    fn beyond_the_cycle(&self, record: &Record) -> impl Iterator<Item = String> {
        let phases = self.cycle.as_ref().map_or(&[][..], |cycle| &cycle.phases);
        self.inputs.iter().enumerate().filter_map(|(input, own)| {
            let ends = phases.iter().flat_map(|phase| [phase.inputs[input].from, phase.inputs[input].to]);
            let most = ends.fold(0.0, |most: f64, end| most.max(end.abs()));
            let channel = self.input_column(record, own).ok()?;
            let (least, greatest) = channel.range()?;
            let goes_to = if -least > greatest { least } else { greatest };
            (most > 0.0 && goes_to.abs() > BEYOND_CYCLE * most).then(|| {
                let [goes_to, most] = [goes_to, most].map(|si| text(rounded(in_unit(si, &channel.unit), 4)));
                format!(
                    "`{}` goes to {goes_to}, where the rig file's cycle has {most} at most: is it in another unit? Its line takes a `scale`",
                    channel.name
                )
            })
        })
    }

    /// A record whose rows are a thousand times as far apart as those of the rig's own cycle, or as near.
    fn another_clock(&self, record: &Record) -> Option<String> {
        let interval = record.sampling()?.interval;
        let ratio = interval / self.cycle.as_ref()?.interval;
        let power = (ratio.log10() / 3.0).round();
        let near = (ratio / 1000_f64.powf(power) - 1.0).abs() < NEAR;
        (power != 0.0 && near).then(|| {
            format!(
                "one row every {} s, {} times the interval of the rig file's cycle: is the time in another unit?",
                text(rounded(interval, 6)),
                text(rounded(ratio, 3))
            )
        })
    }
}
