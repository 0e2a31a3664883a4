//! What each column of a record may be in a circuit.

use super::Circuit;
use crate::record::{Channel, NamedPlace, Record, named_place};
use crate::units::Dimension;

/// Where a sensor of the cylinder circuit sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Location {
    PumpLine,
    A,
    B,
    Piston,
}

/// A column at a sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured<'a> {
    pub channel: &'a Channel,
    pub quantity: &'static str,
    pub spot: Location,
}

/// The columns by what they may be.
pub(super) struct Roles<'a> {
    pub circuit: Circuit,
    pub command: Option<&'a Channel>,
    /// Of a valve with two solenoids, in place of the command: what moves the spool to the side of A, and to the side of B.
    pub solenoids: Option<[&'a Channel; 2]>,
    pub load: Option<&'a Channel>,
    /// Of the cylinder circuit.
    pub sensors: Vec<Measured<'a>>,
    /// Of the reservoirs, in the order of the record.
    pub levels: Vec<&'a Channel>,
}

impl<'a> Roles<'a> {
    pub(super) fn of(
        record: &'a Record,
        circuit: Option<Circuit>,
        command: Option<&'a Channel>,
        load: Option<&'a Channel>,
    ) -> Self {
        let of = |dimension: Dimension| record.channels.iter().filter(move |one| one.unit.dimension == dimension);
        let circuit = circuit.unwrap_or_else(|| {
            let has = |dimension| of(dimension).next().is_some();
            let is_level = |channel: &Channel| channel.name.to_lowercase().contains("level");
            if of(Dimension::LENGTH).any(is_level) && !has(Dimension::PRESSURE) {
                Circuit::Reservoirs
            } else {
                Circuit::Cylinder
            }
        });
        let mut roles = Self { circuit, command, solenoids: None, load, sensors: Vec::new(), levels: Vec::new() };
        match circuit {
            Circuit::Reservoirs => {
                roles.command = command.or_else(|| of(Dimension::VOLTAGE).next());
                roles.load = None;
                roles.levels = of(Dimension::LENGTH).collect();
            }
            Circuit::Cylinder => {
                if command.is_none() {
                    roles.solenoids = solenoids(of(Dimension::NONE)).or_else(|| solenoids(of(Dimension::VOLTAGE)));
                }
                if roles.solenoids.is_none() {
                    roles.command = command.or_else(|| of(Dimension::NONE).chain(of(Dimension::VOLTAGE)).next());
                }
                roles.load = load.or_else(|| of(Dimension::FORCE).next());
                record.channels.iter().for_each(|channel| roles.sensor(channel));
            }
        }
        roles
    }

    /// Takes a column as a sensor, where it may be one and none of its kind sits there already.
    fn sensor(&mut self, channel: &'a Channel) {
        let named = [self.command, self.load].into_iter().flatten().any(|other| other.name == channel.name);
        let (quantity, spot) = match channel.unit.dimension {
            Dimension::PRESSURE => ("pressure", spot(&channel.name)),
            Dimension::FLOW => ("flow", spot(&channel.name)),
            Dimension::LENGTH => ("position", Some(Location::Piston)),
            Dimension::VELOCITY => ("velocity", Some(Location::Piston)),
            _ => return,
        };
        let Some(spot) = spot.filter(|_| !named) else { return };
        if self.at(quantity, spot).is_none() {
            self.sensors.push(Measured { channel, quantity, spot });
        }
    }

    /// The sensor of a quantity at a place.
    pub(super) fn at(&self, quantity: &str, spot: Location) -> Option<&'a Channel> {
        self.sensors.iter().find(|one| one.quantity == quantity && one.spot == spot).map(|one| one.channel)
    }

    /// What became of a column, in words.
    pub(super) fn of_column(&self, name: &str) -> Option<String> {
        let is = |channel: &Channel| channel.name == name;
        if let Some(side) = self.solenoids.and_then(|two| two.into_iter().position(is)) {
            return Some(["solenoid a: P to A and B to T", "solenoid b: P to B and A to T"][side].to_owned());
        }
        if self.command.is_some_and(is) {
            return Some("command".to_owned());
        }
        if self.load.is_some_and(is) {
            return Some("load".to_owned());
        }
        if let Some(index) = self.levels.iter().position(|channel| is(channel)) {
            return Some(format!("level of tank_{}", index + 1));
        }
        self.sensors.iter().find(|one| is(one.channel)).map(|one| {
            let spot = match one.spot {
                Location::PumpLine => "the pump line",
                Location::A => "port A",
                Location::B => "port B",
                Location::Piston => "the piston",
            };
            format!("{} at {spot}", one.quantity)
        })
    }
}

/// The columns of two solenoids: the only two that are either off or on, and never on both at once. Which is which their names say by
/// their last word, else their order.
fn solenoids<'a>(columns: impl Iterator<Item = &'a Channel>) -> Option<[&'a Channel; 2]> {
    let switching: Vec<&Channel> = columns.filter(|channel| is_switched(&channel.values)).collect();
    let &[first, second] = switching.as_slice() else { return None };
    let both = first.values.iter().zip(&second.values).any(|(first, second)| *first > 0.0 && *second > 0.0);
    let last = |channel: &Channel| channel.name.chars().last().map(|letter| letter.to_ascii_lowercase());
    let exchanged = matches!((last(first), last(second)), (Some('b'), Some('a')) | (Some('2'), Some('1')));
    (!both).then_some(if exchanged { [second, first] } else { [first, second] })
}

/// Whether a column has two values, and one of them is zero.
fn is_switched(values: &[f64]) -> bool {
    let there = || values.iter().copied().filter(|value| value.is_finite());
    let on = there().fold(0.0, f64::max);
    on > 0.0 && there().any(|value| value == 0.0) && there().all(|value| value == 0.0 || value == on)
}

/// Where a pressure or a flow is measured, as its name says.
fn spot(name: &str) -> Option<Location> {
    named_place(name).map(|place| match place {
        NamedPlace::PumpLine => Location::PumpLine,
        NamedPlace::A => Location::A,
        NamedPlace::B => Location::B,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_columns_that_are_never_on_together_are_solenoids() {
        let column =
            |name: &str, values: &[f64]| Channel::new(name, crate::units::Unit::parse("-").unwrap(), values.to_vec());
        let (a, b) = (column("Y1 b", &[0.0, 1.0, 0.0, 0.0]), column("Y2 a", &[0.0, 0.0, 0.0, 1.0]));
        let names =
            |columns: &[&Channel]| solenoids(columns.iter().copied()).map(|two| two.map(|one| one.name.clone()));
        assert_eq!(names(&[&a, &b]), Some(["Y2 a".to_owned(), "Y1 b".to_owned()]));
        // One that is in between is a command, and two that are on together are no valve.
        assert_eq!(names(&[&a, &column("u", &[0.0, 0.5, 1.0, 0.0])]), None);
        assert_eq!(names(&[&a, &column("lamp", &[1.0, 1.0, 0.0, 0.0])]), None);
    }
}
