//! A meter at a part reads what effects inside that part pass as well; a load cell reads the force of a part on its body.

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

/// A load outside the cylinder that no cell reads, N.
const HANGS: f64 = 200.0;

/// The telescopic rig with load cells at its cylinder and at its load, and the speed between them; with a seal that rubs inside the cylinder.
fn pulled() -> Model {
    let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
    let cells = "[sensors]\nF_rod = { quantity = \"force\", at = \"cylinder.rod\", noise = \"5 N\" }\nF_late = { quantity = \"force\", at = \
                 \"cylinder.rod\", noise = \"5 N\", lag = \"10 ms\" }\nF_cell = { quantity = \"force\", at = \"load.body\", noise = \"5 N\" }\nv = { quantity = \"velocity\", at = \"piston\", noise = \"1 mm/s\" }\n";
    let effects = format!(
        "\n[effects]\n\"seal-friction@cylinder\" = {{ coulomb = \"300 N +- 50 N\" }}\nload-force = {{ force = \"{HANGS} N +- 10 N\" }}\n"
    );
    Model::new(Rig::parse("rig.toml", text.replacen("[sensors]\n", cells, 1) + &effects).unwrap())
}

#[test]
fn load_cells_read_what_a_part_does_with_what_rubs_inside_and_no_load() {
    let model = pulled();
    let rig = &model.rig;
    let drive = InputSignals::from_cycle(rig, &rig.cycle.clone().unwrap());
    let times: Vec<f64> = (0..20_000).map(|row| f64::from(row) * 1e-4).collect();
    let read = model.solve(&rig.nominal(), &drive, &times).unwrap().values;
    let of = |name: &str| &read[rig.sensors.iter().position(|sensor| sensor.name == name).unwrap()];
    let (rod, load, late, v) = (of("F_rod"), of("F_cell"), of("F_late"), of("v"));
    let mass = rig.nominal()[rig.parameter("cylinder.mass").unwrap()];
    let gained: f64 = (0..times.len() - 1)
        .map(|row| {
            let net = |row: usize| rod[row] + load[row] - HANGS;
            0.5 * (net(row) + net(row + 1)) * (times[row + 1] - times[row])
        })
        .sum();
    let moved = v.iter().copied().fold(0.0, f64::max);
    assert!(moved > 0.02, "{moved}");
    approx::assert_abs_diff_eq!(gained, mass * (v[v.len() - 1] - v[0]), epsilon = 2e-3 * mass * moved);
    // While the rod gathers speed the filter runs after it: what it has gained is the integral of what it is behind, over its lag.
    let behind: f64 = (0..times.len() - 1)
        .map(|row| 0.5 * (rod[row] - late[row] + rod[row + 1] - late[row + 1]) * (times[row + 1] - times[row]) / 10e-3)
        .sum();
    let span = rod.iter().copied().fold(f64::MIN, f64::max) - rod.iter().copied().fold(f64::MAX, f64::min);
    approx::assert_abs_diff_eq!(behind, late[late.len() - 1] - late[0], epsilon = 2e-3 * span);
    assert!(rod.iter().zip(late).any(|(rod, late)| (rod - late).abs() > 0.05 * span));
}

#[test]
fn a_force_is_read_at_a_mechanical_port() {
    let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
    let wrong = "[sensors]\nF = { quantity = \"force\", at = \"cylinder.A\", noise = \"5 N\" }\n";
    let told = Rig::parse("rig.toml", text.replacen("[sensors]\n", wrong, 1)).unwrap_err().to_string();
    assert!(told.contains("measures the force at `cylinder.A`, which is no mechanical port"), "{told}");
    assert!(told.contains("cylinder.rod"), "{told}");
}
