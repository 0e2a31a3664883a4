//! Readings that the machine cannot give: more travel than the stroke, less pressure than vacuum, another pressure at the beginning than
//! the rig file states as exact.

use crate::number::{difference_in_unit, in_unit, rounded, with_unit};
use crate::physics::VACUUM;
use crate::physics::component::facts;
use crate::physics::component::facts::Symbol;
use crate::record::Record;
use crate::rig::{Component, InitialPressure, NodeKind, Quantity, Rig, Sensor, Target};

/// Share of the stroke by which the travel may exceed it: offset and gain of a sensor are not yet fitted.
const TRAVEL: f64 = 1.1;
/// Share of the samples that may lie below: a shock reads as anything.
const SHOCKS: f64 = 0.01;
/// Standard deviations of the noise that a reading may be off.
const OFF: f64 = 6.0;

/// What no sensor of this machine can read, each in words with what it may be.
pub(super) fn senseless(rig: &Rig, record: &Record) -> Vec<String> {
    rig.sensors.iter().filter_map(|sensor| beyond(rig, record, sensor)).collect()
}

/// Pressure sensors whose first reading is another than their node starts with, where that is exact, each in words.
pub(super) fn begun_elsewhere(rig: &Rig, record: &Record) -> Vec<String> {
    rig.sensors.iter().filter_map(|sensor| begins(rig, record, sensor)).collect()
}

fn begins(rig: &Rig, record: &Record, sensor: &Sensor) -> Option<String> {
    let (Quantity::Pressure, Target::Node(node)) = (sensor.quantity, sensor.target) else { return None };
    let NodeKind::Volume { initial: InitialPressure::Given(stated) } = rig.nodes[node].kind else { return None };
    let first = *rig.sensor_column(record, sensor).ok()?.values.first().filter(|first| first.is_finite())?;
    let unit = rig.sensor_unit(sensor);
    let said = |si: f64| with_unit(rounded(in_unit(si, &unit), 4), &unit.symbol);
    ((first - stated).abs() > OFF * sensor.noise.hypot(sensor.tolerance)).then(|| {
        format!(
            "`{}` begins at {}, where node `{}` starts with exactly {}: state how sure that is (`+-`), or leave `initial` out, which starts it with \
             what the sensor shows",
            sensor.column,
            said(first),
            rig.nodes[node].name,
            said(stated)
        )
    })
}

fn beyond(rig: &Rig, record: &Record, sensor: &Sensor) -> Option<String> {
    let channel = rig.sensor_column(record, sensor).ok()?;
    let mut values: Vec<f64> = channel.values.iter().copied().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.first()?, values.last()?);
    let unit = rig.sensor_unit(sensor);
    match (sensor.quantity, sensor.target) {
        (Quantity::Position, Target::Node(node)) => {
            let moves_it = |one: &&Component| facts(one.card).symbol == Symbol::Cylinder && one.ports.contains(&node);
            let cylinder = rig.components.iter().find(moves_it)?;
            let stroke = rig.parameters[rig.parameter(&format!("{}.stroke", cylinder.name))?].value;
            let said = |si: f64| with_unit(rounded(difference_in_unit(si, &unit), 4), &unit.symbol);
            (high - low > TRAVEL * stroke + 2.0 * OFF * sensor.noise).then(|| {
                format!(
                    "`{}` moves by {}, where `{}` has a stroke of {}: is it another column, unit or `scale`?",
                    sensor.column,
                    said(high - low),
                    cylinder.name,
                    said(stroke)
                )
            })
        }
        (Quantity::Pressure, _) => {
            let usual = *values.get((SHOCKS * values.len() as f64) as usize)?;
            (usual < VACUUM - OFF * sensor.noise).then(|| {
                format!(
                    "`{}` falls to {}, below vacuum (-1.013 bar over the atmosphere): is it another column, or does its zero need a `scale`?",
                    sensor.column,
                    with_unit(rounded(in_unit(usual, &unit), 3), &unit.symbol)
                )
            })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_were_mixed_up_are_told() {
        let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let record = rig.record("fixtures/telescopic/healthy_1.csv").unwrap();
        assert_eq!(senseless(&rig, &record), [""; 0]);
        let mut wrong = record.clone();
        for channel in &mut wrong.channels {
            match channel.name.as_str() {
                "x" => channel.values.iter_mut().for_each(|value| *value *= 10.0),
                "p_A" => channel.values.iter_mut().for_each(|value| *value -= 60e5),
                _ => {}
            }
        }
        let told = senseless(&rig, &wrong);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].starts_with("`p_A` falls to -") && told[1].ends_with("is it another column, unit or `scale`?"));
    }

    #[test]
    fn a_start_that_the_sensor_does_not_show_is_told() {
        let mut rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let record = rig.record("fixtures/telescopic/healthy_1.csv").unwrap();
        let sensor = rig.sensors.iter().find(|sensor| sensor.name == "p_A").unwrap().clone();
        let Target::Node(node) = sensor.target else { panic!("no node") };
        let first = rig.sensor_column(&record, &sensor).unwrap().values[0];
        let mut starting = |stated: f64| {
            rig.nodes[node].kind = NodeKind::Volume { initial: InitialPressure::Given(stated) };
            begun_elsewhere(&rig, &record)
        };
        assert_eq!(starting(first + 5.0 * sensor.noise), [""; 0]);
        let told = starting(first + 20e5);
        assert!(told.len() == 1 && told[0].starts_with("`p_A` begins at "), "{told:?}");
    }
}
