//! Where nodes start that start at what their sensors show.

use crate::complaint::{Complaint, Kind};
use crate::physics::GRAVITY;
use crate::record::Record;
use crate::rig::{InitialPressure, NodeKind, Quantity, Rig, Target};

/// Mean of the first few readings of each node that starts at what its sensor shows: of several sensors the first that shows
/// something.
pub(super) fn readings(rig: &Rig, record: &Record) -> Result<Vec<f64>, Complaint> {
    let mut readings: Vec<Option<f64>> = vec![None; rig.nodes.len()];
    let density = rig.parameters.first().map_or(0.0, |density| density.value);
    let by_record = |node: usize| rig.nodes[node].kind == (NodeKind::Volume { initial: InitialPressure::Record });
    for sensor in &rig.sensors {
        let Target::Node(node) = sensor.target else { continue };
        let per_reading = match sensor.quantity {
            Quantity::Pressure => 1.0,
            Quantity::Level => density * GRAVITY,
            Quantity::Flow | Quantity::Position | Quantity::Velocity => continue,
        };
        if readings[node].is_some() || !by_record(node) {
            continue;
        }
        let channel = rig.sensor_column(record, sensor)?;
        let Some(shown) = channel.begins_at() else { continue };
        let (offset, gain) =
            (rig.parameters[sensor.first_parameter].value, rig.parameters[sensor.first_parameter + 1].value);
        readings[node] = Some((shown - offset) / if gain > 0.0 { gain } else { 1.0 } * per_reading);
    }
    for (index, node) in rig.nodes.iter().enumerate() {
        if readings[index].is_none() && by_record(index) {
            let what = format!("nothing shows where node `{}` starts: its sensor is dead or has no value", node.name);
            return Err(Complaint::new(Kind::MissingEntry, what).at(node.place.clone()).at(record.header()).help(
                "write how it starts: `initial = \"20 bar\"` in its line, or take a record in which its sensor works",
            ));
        }
    }
    Ok(readings.into_iter().map(|found| found.unwrap_or(0.0)).collect())
}
