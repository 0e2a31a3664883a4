//! A meter at a part reads what effects inside that part pass as well.

use borescope::Rig;
use borescope::internals::model::{InputSignals, Model, cycle_times};

const SLIP: f64 = 0.02;

/// The telescopic rig with meters behind its pump, with and without a lag, and a pump that slips by so much, L/min/bar.
fn slipping() -> Model {
    let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
    let meters = "[sensors]\nq_pump = { quantity = \"flow\", at = \"pump.P\", direction = \"out\", noise = \"0.03 L/min\" }\nq_late = { \
                  quantity = \"flow\", at = \"pump.P\", direction = \"out\", noise = \"0.03 L/min\", lag = \"20 ms\" }\n";
    let effect =
        format!("\n[effects]\n\"pump-slip@pump\" = {{ conductance = \"{SLIP} L/min/bar +- 0.01 L/min/bar\" }}\n");
    let rig = Rig::parse("rig.toml", text.replacen("[sensors]\n", meters, 1) + &effect).unwrap();
    Model::new(rig)
}

#[test]
fn the_slip_of_a_pump_never_reaches_the_meter_behind_it() {
    let model = slipping();
    let rig = &model.rig;
    let cycle = rig.cycle.clone().unwrap();
    let (drive, times) = (InputSignals::from_cycle(rig, &cycle), cycle_times(rig, &cycle));
    let read = model.solve(&rig.nominal(), &drive, &times).unwrap().values;
    let sensor = |name: &str| rig.sensors.iter().position(|sensor| sensor.name == name).unwrap();
    // Displacement times speed, less what leaks back: 5.5 cm3 a thousand times a minute.
    for row in (0..times.len()).step_by(50) {
        let expected = 5.5 - SLIP * read[sensor("p_pump")][row] / 1e5;
        let shown = read[sensor("q_pump")][row] * 6e4;
        approx::assert_abs_diff_eq!(shown, expected, epsilon = 1e-6);
    }
    let late = read[sensor("q_late")].last().unwrap() - read[sensor("q_pump")].last().unwrap();
    assert!(late.abs() * 6e4 < 0.02, "{late}");
    // And so do its derivatives.
    let slip = rig.parameter("pump-slip.conductance").unwrap();
    let by_slip = model.sensitivities(&rig.nominal(), &[slip], &drive, &times).unwrap().derivatives;
    let moved = |by: f64| {
        let mut values = rig.nominal();
        values[slip] += by;
        model.solve(&values, &drive, &times).unwrap().values
    };
    let step = 1e-3 * rig.nominal()[slip];
    let (up, down) = (moved(step), moved(-step));
    for name in ["q_pump", "q_late"] {
        let index = sensor(name);
        let row = times.len() - 1;
        let slope = (up[index][row] - down[index][row]) / (2.0 * step);
        approx::assert_relative_eq!(by_slip[0][index][row], slope, max_relative = 1e-3);
    }
}
