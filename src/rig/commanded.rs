//! How a record commands the valves of a rig, and what of them is then a matter of switching alone.

use super::{Component, Rig};
use crate::physics::card::Role;
use crate::record::{Channel, Record};

/// Share of a command within which it counts as none, or as full: a twentieth more in the exponent of an edge then changes the flow by
/// less than a thousandth of the fully open valve's where that is open, and by four thousandths where it is shut.
const AT_END: f64 = 0.02;
/// Lags after which a spool is within a fiftieth of where its command rests.
const SETTLED: f64 = 4.0;

impl Rig {
    /// The rig as one of some records commands it. Where a command rests between shut and open for longer than the spool takes to follow, how
    /// far an edge is open there is a value of the valve, known as before but the same throughout, and no matter of one switching. `None`
    /// where that changes nothing.
    pub(crate) fn as_commanded<'a>(&self, records: impl IntoIterator<Item = &'a Record> + Clone) -> Option<Self> {
        let mut commanded = None;
        for component in &self.components {
            let own = component.card.parameters.iter().enumerate();
            let edges = own.filter(|(_, parameter)| parameter.role == Role::Edge);
            let edges: Vec<usize> = edges.map(|(place, _)| component.first_parameter + place).collect();
            let edges = edges.into_iter().filter(|&edge| self.parameters[edge].varies());
            if records.clone().into_iter().any(|record| self.rests_between(component, record)) {
                edges.for_each(|edge| commanded.get_or_insert_with(|| self.clone()).parameters[edge].per_event = false);
            }
        }
        commanded
    }

    /// Whether the command that a component follows rests between its ends.
    fn rests_between(&self, component: &Component, record: &Record) -> bool {
        let followed = component.inputs.iter().zip(component.card.inputs).find_map(|(&input, card)| {
            let lag = component.card.parameters.iter().position(|own| Some(own.name) == card.lag)?;
            let channel = self.input_column(record, &self.inputs[input]).ok()?;
            Some((channel, SETTLED * self.parameters[component.first_parameter + lag].value))
        });
        followed.is_some_and(|(channel, settled)| rests_between(&record.time, channel, settled))
    }
}

/// Whether a column stays between the ends of a command for longer than `settled`, s.
fn rests_between(time: &[f64], channel: &Channel, settled: f64) -> bool {
    let mut since = None;
    for (&time, value) in time.iter().zip(&channel.values) {
        if !(AT_END..=1.0 - AT_END).contains(&value.abs()) {
            since = None;
        } else if time - *since.get_or_insert(time) > settled {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The telescopic rig, and a record whose command stays at a value for so long, s.
    fn commanded(value: f64, length: f64) -> (Rig, Record) {
        let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let mut record = Record::read("fixtures/telescopic/healthy_1.csv").unwrap();
        let input = rig.inputs.iter().find(|input| input.column == "valve_command").unwrap();
        let place = record.channels.iter().position(|channel| channel.name == input.column).unwrap();
        for (&time, command) in record.time.iter().zip(&mut record.channels[place].values) {
            if (1.0..1.0 + length).contains(&time) {
                *command = value;
            }
        }
        (rig, record)
    }

    #[test]
    fn an_edge_is_of_the_valve_where_the_command_rests_between() {
        let per_event = |rig: &Rig| {
            let edge = rig.parameter("directional_valve.progression_PA").unwrap();
            rig.parameters[edge].per_event
        };
        let (rig, between) = commanded(0.4, 0.5);
        assert!(per_event(&rig));
        assert!(!per_event(&rig.as_commanded([&between]).unwrap()));
        // Open, all but open, and on its way within what the spool takes.
        for (value, length) in [(1.0, 0.5), (0.99, 0.5), (0.4, 0.03)] {
            let (rig, record) = commanded(value, length);
            assert!(rig.as_commanded([&record]).is_none(), "{value} for {length} s");
        }
        // Of several records one is enough.
        let (rig, open) = commanded(1.0, 0.5);
        assert!(rig.as_commanded([&open, &between]).is_some());
    }
}
