//! The table of `docs/theory/noise.md`: what trapped oil remembers of a switching.

use borescope::Rig;
use borescope::internals::model::{InputSignals, Model, cycle_times};

/// Gauge pressures of A and B at the end, bar: out for 1.5 s, then closed for 1.5 s.
fn at_the_end(set: &[(&str, f64)], late: f64) -> [f64; 2] {
    let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
    let (before, _) = text.split_once("phases = [").unwrap();
    let phase = |seconds: f64, command: u8| {
        format!("{{ duration = \"{seconds} s\", valve_command = {command}, F_load = \"5400 N\" }},")
    };
    let phases = [phase(0.5, 0), phase(1.5 + late, 1), phase(1.5 - late, 0)].concat();
    let rig = Rig::parse("rig.toml", format!("{before}phases = [{phases}]")).unwrap_or_else(|error| panic!("{error}"));
    let mut parameters = rig.nominal();
    for (id, value) in set {
        parameters[rig.parameter(id).unwrap()] = *value;
    }
    let cycle = rig.cycle.clone().unwrap();
    let (drive, times) = (InputSignals::from_cycle(&rig, &cycle), cycle_times(&rig, &cycle));
    let model = Model::new(rig);
    let outputs = model.solve(&parameters, &drive, &times).unwrap();
    let last = |name: &str| {
        let sensor = model.rig.sensors.iter().position(|sensor| sensor.name == name).unwrap();
        outputs.values[sensor].last().unwrap() / 1e5
    };
    [last("p_A"), last("p_B")]
}

#[test]
fn trapped_oil_remembers_unequal_edges_and_forgets_delays() {
    let page = std::fs::read_to_string("docs/theory/noise.md").unwrap();
    let plain = at_the_end(&[], 0.0);
    for (what, changed) in [
        ("the command comes 0.1 ms later", at_the_end(&[], 1e-4)),
        ("the command comes 4 ms later", at_the_end(&[], 4e-3)),
        ("edge P-A opens with", at_the_end(&[("directional_valve.progression_PA", 1.05)], 0.0)),
        ("edge B-T opens with", at_the_end(&[("directional_valve.progression_BT", 1.05)], 0.0)),
        ("the spool's lag is 10 ms", at_the_end(&[("directional_valve.lag", 10e-3)], 0.0)),
    ] {
        let row = page.lines().find(|line| line.starts_with(&format!("| {what}"))).unwrap();
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        for (cell, (changed, plain)) in cells[2..4].iter().zip(changed.iter().zip(plain)) {
            let shown: f64 = cell.trim_end_matches(" bar").parse().unwrap();
            println!("{what}: {:+.3} bar, shown {shown:+.2}", changed - plain);
            assert!((changed - plain - shown).abs() < 0.011, "{what}: {}, shown {shown}", changed - plain);
        }
    }
}
