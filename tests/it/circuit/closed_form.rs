//! Small circuits whose answers are known in closed form; the digits in which the model agrees are printed.

use crate::support::circuit;

use std::f64::consts::PI;

use borescope::Model;
use borescope::Rig;
use borescope::internals::physics::GRAVITY;
use circuit::{digits, model, run};

const OIL: &str = "[fluid]\ndensity = \"870 kg/m3\"\nviscosity = \"45.5 mPa.s\"\nbulk_modulus = \"14000 bar\"\n";

/// So tight that only the physics is left.
fn tight(text: &str) -> Model {
    model(Rig::parse("test.toml", text.to_owned()), 1e-10)
}

#[test]
fn a_reservoir_drains_after_torricelli() {
    // From 10 m; at that height the laminar start of the orifice, 10 Pa, is below the ninth digit.
    let head = 870.0 * GRAVITY * 10.0;
    let model = tight(&format!(
        r#"{OIL}
[nodes]
sump = {{}}
vessel = {{ initial = "{head} Pa" }}
[components]
sump = {{ kind = "tank", ports = {{ T = "sump" }} }}
vessel = {{ kind = "reservoir", ports = {{ P = "vessel" }}, area = "100 cm2" }}
hole = {{ kind = "orifice", ports = {{ in = "vessel", out = "sump" }}, diameter = "5 mm", transition_pressure = "1e-4 bar" }}
[sensors]
level = {{ quantity = "level", at = "vessel", noise = "1 mm" }}
flow = {{ quantity = "flow", at = "hole.in", noise = "1 L/min" }}
[cycle]
interval = "5 s"
phases = [ {{ duration = "500 s" }} ]
"#
    ));
    let (times, outputs) = run(&model);
    let hole = 0.7 * PI / 4.0 * 0.005_f64.powi(2);
    // A h' = -Cd a sqrt(2 g h): the root of the level falls straight.
    let level = |t: f64| (10f64.sqrt() - 0.5 * hole / 0.01 * (2.0 * GRAVITY).sqrt() * t).powi(2);
    assert!(level(500.0) > 0.3 && level(500.0) < 3.0);
    assert!(digits("level after Torricelli", &outputs.values[0], times.iter().map(|&t| level(t))) > 7.0);
    let flow = times.iter().map(|&t| hole * (2.0 * GRAVITY * level(t)).sqrt());
    assert!(digits("flow after Torricelli", &outputs.values[1], flow) > 7.0);
}

#[test]
fn a_volume_discharges_through_a_laminar_leak() {
    let model = tight(&format!(
        r#"{OIL}
[nodes]
tank = {{}}
A = {{ initial = "100 bar" }}
[components]
tank = {{ kind = "tank", ports = {{ T = "tank" }} }}
line = {{ kind = "line-volume", ports = {{ P = "A" }}, volume = "100 cm3" }}
[components.valve]
kind = "directional-valve"
ports = {{ P = "tank", T = "tank", A = "A", B = "tank" }}
command = "u"
rated_flow = "8 L/min"
rated_drop = "18.5 bar"
leak_AT = "0.01 L/min/bar"
[inputs.u]
unit = "-"
[sensors]
p = {{ quantity = "pressure", at = "A", noise = "1 bar" }}
[cycle]
interval = "2 ms"
phases = [ {{ duration = "0.2 s", u = 0 }} ]
"#
    ));
    let (times, outputs) = run(&model);
    let (capacity, conductance) = (1e-4 / 1.4e9, 0.01e-3 / 60.0 / 1e5);
    println!("time constant {:.4} s", capacity / conductance);
    let closed = times.iter().map(|t| 1e7 * (-t * conductance / capacity).exp());
    assert!(digits("exponential discharge", &outputs.values[0], closed) > 8.0);
}

#[test]
fn a_mass_swings_on_trapped_oil() {
    // Both chambers closed and in balance; the areas are as 4 to 3.
    let model = tight(&format!(
        r#"{OIL}
[nodes]
A = {{ initial = "30 bar" }}
B = {{ initial = "40 bar" }}
piston = {{ position = "60 mm", velocity = "0.1 mm/s" }}
[components.cylinder]
kind = "cylinder"
ports = {{ A = "A", B = "B", rod = "piston" }}
bore = "40 mm"
rod = "20 mm"
stroke = "170 mm"
dead_volume_A = "50 cm3"
dead_volume_B = "50 cm3"
mass = "100 kg"
[sensors]
x = {{ quantity = "position", at = "piston", noise = "1 mm" }}
v = {{ quantity = "velocity", at = "piston", noise = "1 mm/s" }}
p_A = {{ quantity = "pressure", at = "A", noise = "1 bar" }}
[cycle]
interval = "0.5 ms"
phases = [ {{ duration = "0.2 s" }} ]
"#
    ));
    let (times, outputs) = run(&model);
    let (big, small) = (PI / 4.0 * 0.04_f64.powi(2), PI / 4.0 * (0.04_f64.powi(2) - 0.02_f64.powi(2)));
    let (volume_a, volume_b) = (50e-6 + big * 0.06, 50e-6 + small * 0.11);
    let stiffness = 1.4e9 * (big * big / volume_a + small * small / volume_b);
    let omega = (stiffness / 100.0).sqrt();
    println!("{:.2} Hz, {:.1} swings", omega / (2.0 * PI), omega * 0.2 / (2.0 * PI));
    let travel: Vec<f64> = outputs.values[0].iter().map(|x| x - 0.06).collect();
    let sine = times.iter().map(|t| 1e-4 / omega * (omega * t).sin());
    // The chambers change by a millionth of their volume, which the straight theory leaves out.
    assert!(digits("travel on the oil spring", &travel, sine) > 5.0);
    let cosine = times.iter().map(|t| 1e-4 * (omega * t).cos());
    assert!(digits("speed on the oil spring", &outputs.values[1], cosine) > 5.0);
    let swing: Vec<f64> = outputs.values[2].iter().map(|p| p - 30e5).collect();
    let pressure = times.iter().map(|t| -1.4e9 * big / volume_a * 1e-4 / omega * (omega * t).sin());
    assert!(digits("pressure on the oil spring", &swing, pressure) > 4.5);
}

#[test]
fn spool_and_sensor_follow_with_their_lags() {
    // At a constant drop the flow is that of the spool.
    let model = tight(&format!(
        r#"{OIL}
[nodes]
high = {{}}
low = {{}}
[components]
high = {{ kind = "tank", ports = {{ T = "high" }}, pressure = "100 bar" }}
low = {{ kind = "tank", ports = {{ T = "low" }} }}
[components.valve]
kind = "directional-valve"
ports = {{ P = "high", T = "low", A = "low", B = "low" }}
command = "u"
rated_flow = "8 L/min"
rated_drop = "18.5 bar"
lag = "8 ms"
transition_pressure = "1e-4 bar"
[inputs.u]
unit = "-"
[sensors]
quick = {{ quantity = "flow", at = "valve.P", noise = "1 L/min" }}
slow = {{ quantity = "flow", at = "valve.P", noise = "1 L/min", lag = "3 ms" }}
[cycle]
interval = "1 ms"
phases = [ {{ duration = "20 ms", u = 0 }}, {{ duration = "80 ms", u = 1 }} ]
"#
    ));
    let (times, outputs) = run(&model);
    let full = 8e-3 / 60.0 * (100.0_f64 / 18.5).sqrt();
    let (spool, sensor) = (8e-3, 3e-3);
    let behind: Vec<f64> = times.iter().map(|t| (t - 0.02).max(0.0)).collect();
    let quick = behind.iter().map(|t| full * (1.0 - (-t / spool).exp()));
    assert!(digits("lag of the spool", &outputs.values[0], quick) > 8.0);
    let slow = behind
        .iter()
        .map(|t| full * (1.0 - (spool * (-t / spool).exp() - sensor * (-t / sensor).exp()) / (spool - sensor)));
    assert!(digits("lag of spool and sensor", &outputs.values[1], slow) > 8.0);
}
