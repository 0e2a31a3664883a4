//! What must hold whatever the numbers: units there and back, columns as they are mapped, fluid that stays, the order of a rig
//! file.

use std::collections::HashMap;

use borescope::Rig;
use borescope::internals::model::{InputSignals, Model, cycle_times};
use borescope::internals::record::{Asked, Channel, Record};
use borescope::internals::units::{Dimension, Quantity, Unit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A number of any size and sign.
fn number(random: &mut ChaCha8Rng) -> f64 {
    let mantissa = random.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0;
    mantissa * 10f64.powi((random.next_u32() % 13) as i32 - 6)
}

fn close(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 1e-14 * (a.abs() + b.abs() + scale)
}

#[test]
fn every_unit_comes_back() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut units = 0;
    for (dimension, name) in Dimension::named() {
        for symbol in Unit::known_for(dimension) {
            let unit = Unit::parse_as(symbol, dimension).unwrap();
            units += 1;
            for _ in 0..200 {
                let value = number(&mut random);
                let scale = (unit.offset / unit.factor).abs();
                let back = unit.from_si(unit.to_si(value));
                assert!(close(back, value, scale), "{name}: {value} {symbol} comes back as {back}");
                let written = format!("{value} {symbol}");
                let quantity =
                    Quantity::parse_as(&written, dimension).unwrap_or_else(|error| panic!("{written}: {error}"));
                assert!(close(quantity.in_unit(), value, scale), "{written}");
                let difference = unit.difference_from_si(unit.difference_to_si(value));
                assert!(close(difference, value, 0.0), "{written}");
            }
        }
    }
    assert!(units > 40, "{units}");
}

/// A record says the same in other units.
#[test]
fn a_record_in_other_units_is_the_same_record() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let values: Vec<f64> = (0..100).map(|_| number(&mut random)).collect();
    let time: Vec<f64> = (0..100).map(|row| f64::from(row) * 0.125).collect();
    let folder = tempfile::tempdir().unwrap();
    for symbol in Unit::known_for(Dimension::PRESSURE) {
        let unit = Unit::parse(symbol).unwrap();
        let path = folder.path().join("record.csv");
        Record::new("made", time.clone(), vec![Channel::new("p", unit, values.clone())]).write(&path).unwrap();
        let back = Record::read(&path).unwrap();
        assert_eq!(back.time, time);
        let pairs = back.channels[0].values.iter().zip(&values);
        assert!(pairs.into_iter().all(|(a, b)| close(*a, *b, 0.0)), "{symbol}");
    }
}

const RIG: &str = "fixtures/two_tanks/rig.toml";

/// Scale, sign and zero of a column are its rig file's: the record is the same as one of the plain column.
#[test]
fn mapped_columns_read_as_what_they_stand_for() {
    let text = std::fs::read_to_string(RIG).unwrap();
    let plain = Rig::parse(RIG, text.clone()).unwrap();
    let input = plain.inputs[0].clone();
    let sensor = plain.sensors[0].clone();
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, input_values: Vec<f64>, unit: &Unit| {
        let time = vec![0.0, 1.0, 2.0];
        let channels = vec![
            Channel::new(input.column.clone(), unit.clone(), input_values),
            Channel::new(sensor.column.clone(), Unit::parse("cm").unwrap(), vec![0.01, 0.02, 0.03]),
        ];
        let path = folder.path().join(name);
        Record::new("made", time, channels).write(&path).unwrap();
        path
    };
    let of =
        |path: &std::path::Path, rig: &Rig| rig.record(path).unwrap().channel(&input.column).unwrap().values.clone();
    let direct = of(&write("plain.csv", vec![1.0, 2.0, -1.0], &input.unit), &plain);
    // Minus two volts a millivolt, and 5 mV at zero.
    let declared = "unit = \"V\"";
    assert_eq!(text.matches(declared).count(), 1);
    let mapped = text.replace(declared, &format!("{declared}\nscale = \"-2 V/mV\"\noffset = \"5 mV\""));
    let mapped = Rig::parse(RIG, mapped).unwrap_or_else(|complaint| panic!("{complaint}"));
    let millivolts = [4.5e-3, 4.0e-3, 5.5e-3].to_vec();
    let scaled = of(&write("mapped.csv", millivolts, &Unit::parse("mV").unwrap()), &mapped);
    assert!(direct.iter().zip(&scaled).all(|(a, b)| close(*a, *b, 1.0)), "{direct:?} {scaled:?}");
}

/// The two tanks with a flow meter in the outlet, simulated over their cycle: times, and readings by the name of the sensor.
fn simulated(text: &str) -> (Vec<f64>, HashMap<String, Vec<f64>>) {
    let text = text.replace(
        "[sensors]",
        "[sensors]\nq_out = { quantity = \"flow\", at = \"lower_outlet.in\", noise = \"0.01 L/min\" }",
    );
    let rig = Rig::parse(RIG, text).unwrap_or_else(|complaint| panic!("{complaint}"));
    let cycle = rig.cycle.clone().unwrap();
    let times = cycle_times(&rig, &cycle);
    let model = Model::new(rig);
    let outputs = model.solve(&model.rig.nominal(), &InputSignals::from_cycle(&model.rig, &cycle), &times).unwrap();
    let names = model.rig.sensors.iter().map(|sensor| sensor.name.clone());
    (times, names.zip(outputs.values).collect())
}

/// The order of tables in the file, of components and of sensors, is no physics.
#[test]
fn the_order_of_a_rig_file_changes_nothing() {
    let text = std::fs::read_to_string(RIG).unwrap();
    let mut blocks: Vec<&str> = text.split("\n\n").collect();
    blocks.reverse();
    let reversed = format!("{}\n", blocks.join("\n\n"));
    let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("level_")).collect();
    let reversed = reversed.replace(&lines.join("\n"), &format!("{}\n{}", lines[1], lines[0]));
    assert!(reversed.find("level_2 =") < reversed.find("level_1 ="));
    let ((_, forward), (_, backward)) = (simulated(&text), simulated(&reversed));
    for (name, values) in &forward {
        let greatest = values.iter().fold(0.0, |greatest: f64, value| greatest.max(value.abs()));
        let pairs = values.iter().zip(&backward[name]);
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-5 * greatest), "{name}");
    }
}

/// What flows in and not out is in the tanks.
#[test]
fn no_fluid_is_lost() {
    let (times, readings) = simulated(&std::fs::read_to_string(RIG).unwrap());
    let flow = &readings["q_out"];
    let out: f64 = times.windows(2).zip(flow.windows(2)).map(|(t, q)| (t[1] - t[0]) * 0.5 * (q[0] + q[1])).sum();
    // 3 L/min/V times 1.2, 2 and 0.6 V, 300 s each.
    let into = 3e-3 / 60.0 * 300.0 * (1.2 + 2.0 + 0.6);
    let held = 154e-4 * (readings["level_1"].last().unwrap() + readings["level_2"].last().unwrap());
    assert!((into - out - held).abs() < 1e-3 * into, "{into} m3 in, {out} out, {held} held");
}

/// Columns without units take those of the rig, and none without being told.
#[test]
fn a_column_without_a_unit_takes_that_of_the_rig() {
    let bar = Unit::parse("bar").unwrap();
    let asked = Asked::new([("p".to_owned(), Some(bar)), ("x".to_owned(), None)]);
    let record = asked.read_bytes("R", b"time [s],p,x [mm]\n0,1.5,2\n1,2.5,3\n".to_vec()).unwrap();
    assert_eq!(record.channel("p").unwrap().values, [1.5e5, 2.5e5]);
    let refused = asked.read_bytes("R", b"time [s],p [bar],x\n0,1.5,2\n".to_vec()).unwrap_err();
    assert_eq!(refused.what, "the column `x` has no unit in square brackets");
}
