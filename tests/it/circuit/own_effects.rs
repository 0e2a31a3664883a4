//! Effects of the rig file's own: formulas that act like the library's laws, and every mistake told with its line.

use std::path::Path;

use approx::assert_relative_eq;
use borescope::internals::learn::add::add;
use borescope::internals::model::{InputSignals, Model, Tolerance};
use borescope::internals::rig::{ParameterSetting, Rig};

use crate::support::command::borescope;
use crate::support::cycle::Run;

const RIG: &str = "fixtures/telescopic/rig.toml";

const LEAK: &str = r#"
[own_effects.weeping-joint]
meaning = "A joint of the hose that weeps."
at = "A"
flow = "G * A.p"
parameters = { G = { neutral = "0 L/min/bar", first = "0.002 L/min/bar", bounds = ["0 L/min/bar", "0.2 L/min/bar"] } }
"#;

const BUMP: &str = r#"
[own_effects.tight-spot]
at = "piston"
force = "-F * exp(-((piston.x - x0) / w)^2) * tanh(piston.v / [1 mm/s])"
parameters.F = { neutral = "0 N", first = "200 N", meaning = "friction in the middle of the spot" }
parameters.x0 = { first = "0.1 m" }
parameters.w = { first = "10 mm", bounds = ["1 mm", "100 mm"] }
"#;

/// What a formula may see besides states: an input, the time, a reading.
const HEAVIER: &str = r#"
[own_effects.heavier]
at = "piston"
force = "-k * F_load"
parameters.k = { neutral = 0, first = 0.1 }
"#;

const WARMING: &str = r#"
[own_effects.loosening]
at = "A"
flow = "r * t * A.p"
parameters.r = { neutral = "0 L/min/bar/s", first = "0.001 L/min/bar/s" }
"#;

const BENT: &str = r#"
[own_effects.bent]
at = "q_A"
reading = "reading * (1 + a * reading / [10 L/min]) + d * t"
parameters.a = { neutral = 0, first = 0.02 }
parameters.d = { first = "0 L/min/s" }
"#;

/// Pressure that is lost ahead of the flow control valve, by the square of its flow.
const LOSS: &str = r#"
[own_effects.narrow-line]
at = "flow_control"
drop = "K * q * abs(q)"
parameters.K = { neutral = "0 bar.min2/L2", first = "0.05 bar.min2/L2" }
"#;

/// A leak that opens and closes 3200 times a second.
const CHATTER: &str = r#"
[own_effects.chatter]
at = "A"
flow = "G * A.p * sign(sin([10000 1/s] * t))"
parameters.G = { neutral = "0 L/min/bar", first = "0.002 L/min/bar" }
[effects.chatter]
G = "0.002 L/min/bar"
"#;

fn rig(more: &str) -> Rig {
    let text = std::fs::read_to_string(RIG).unwrap();
    Rig::parse(RIG, text + more).unwrap_or_else(|complaint| panic!("{complaint}"))
}

/// What the sensors show over the first second of the cycle.
fn outputs(rig: &Rig) -> Vec<Vec<f64>> {
    let drive = InputSignals::from_cycle(rig, rig.cycle.as_ref().unwrap());
    let times: Vec<f64> = (0..250).map(|row| 0.004 * f64::from(row)).collect();
    Model::new(rig.clone()).solve(&rig.nominal(), &drive, &times).unwrap().values
}

fn given(rig: &mut Rig, id: &str, name: &str, value: f64) {
    let placed = rig.placed(id).unwrap();
    rig.give_effect(&placed, &[ParameterSetting { name: name.to_owned(), value, sigma: 0.0 }]).unwrap();
}

#[test]
fn a_formula_acts_like_the_law_of_the_library() {
    let conductance = 0.01e-3 / 60.0 / 1e5;
    let mut own = rig(LEAK);
    given(&mut own, "weeping-joint", "G", conductance);
    let mut library = rig("");
    given(&mut library, "external-leakage@A", "conductance", conductance);
    let (own, library, without) = (outputs(&own), outputs(&library), outputs(&rig(LEAK)));
    for (a, b) in own.iter().flatten().zip(library.iter().flatten()) {
        assert_relative_eq!(a, b, max_relative = 1e-6, epsilon = 1e-9);
    }
    // And it does something: 0.1 % of the pressure at A.
    let differs = own[2].iter().zip(&without[2]).any(|(a, b)| (a - b).abs() > 1e-3 * b.abs());
    assert!(differs);
}

#[test]
fn at_its_neutral_value_a_formula_does_nothing() {
    let plain = outputs(&rig(""));
    for (more, id, size) in [(LEAK, "weeping-joint", "G"), (BUMP, "tight-spot@piston", "F"), (LOSS, "narrow-line", "K")]
    {
        let mut with = rig(more);
        given(&mut with, id, size, 0.0);
        for (a, b) in outputs(&with).iter().flatten().zip(plain.iter().flatten()) {
            assert_relative_eq!(a, b, max_relative = 1e-9, epsilon = 1e-12);
        }
    }
}

#[test]
fn a_force_over_an_input_is_a_larger_input() {
    let mut own = rig(HEAVIER);
    given(&mut own, "heavier", "k", 0.1);
    let mut plain = rig("");
    let load = plain.inputs.iter().position(|input| input.name == "F_load").unwrap();
    for phase in &mut plain.cycle.as_mut().unwrap().phases {
        phase.inputs[load].from *= 1.1;
        phase.inputs[load].to *= 1.1;
    }
    // Before the record the chamber holds the load, whatever the effect adds: compared while the piston moves.
    for (own, plain) in outputs(&own).iter().zip(&outputs(&plain)) {
        for (a, b) in own[200..].iter().zip(&plain[200..]) {
            assert_relative_eq!(a, b, max_relative = 1e-4, epsilon = 1e-6);
        }
    }
}

#[test]
fn a_flow_over_time_has_exact_slopes() {
    let mut own = rig(WARMING);
    let slope = 0.01e-3 / 60.0 / 1e5;
    given(&mut own, "loosening", "r", slope);
    let index = own.parameter("loosening@A.r").unwrap();
    let drive = InputSignals::from_cycle(&own, own.cycle.as_ref().unwrap());
    let times: Vec<f64> = (0..250).map(|row| 0.004 * f64::from(row)).collect();
    let model = Model::new(own).with_tolerance(Tolerance { relative: 1e-8, absolute: 1e-8 });
    let at = |r: f64| {
        let mut values = model.rig.nominal();
        values[index] = r;
        model.sensitivities(&values, &[index], &drive, &times).unwrap()
    };
    let (below, here, above) = (at(0.99 * slope), at(slope), at(1.01 * slope));
    // The pressure at A, half a second after the valve has opened.
    let difference = (above.outputs.values[2][249] - below.outputs.values[2][249]) / (0.02 * slope);
    assert!((difference * slope).abs() > 100.0, "{difference}");
    assert_relative_eq!(here.derivatives[0][2][249], difference, max_relative = 1e-4);
}

#[test]
fn a_loss_of_pressure_is_a_smaller_throttle() {
    // With the reducing valve saturated both are orifices in a row: 1/g² of the valve, and K.
    let mut own = rig(LOSS);
    let loss = 2.0 * 1e5 * 6e4 * 6e4;
    given(&mut own, "narrow-line@flow_control", "K", loss);
    let both = outputs(&own);
    let row = 249;
    let (pump, valve, flow) = (both[0][row], both[1][row], both[4][row]);
    let conductance = |cd: f64, area: f64| cd * area * (2.0 / 870.0_f64).sqrt();
    let reducing = conductance(0.7, 10e-3 * 1.5e-3);
    let throttle = conductance(0.7, std::f64::consts::FRAC_PI_4 * 5e-3 * 5e-3);
    let expected = flow * flow * (1.0 / (reducing * reducing) + 1.0 / (throttle * throttle) + loss);
    assert!(flow > 4e-3 / 60.0, "{flow}");
    // The root of the valve is smoothed at 0.05 bar.
    assert_relative_eq!(pump - valve, expected, max_relative = 5e-3);
}

#[test]
fn a_loss_of_pressure_has_exact_slopes() {
    let mut own = rig(LOSS);
    let size = 2.0 * 1e5 * 6e4 * 6e4;
    given(&mut own, "narrow-line@flow_control", "K", size);
    let asked = ["narrow-line@flow_control.K", "flow_control.orifice_diameter"].map(|id| own.parameter(id).unwrap());
    let drive = InputSignals::from_cycle(&own, own.cycle.as_ref().unwrap());
    let times: Vec<f64> = (0..250).map(|row| 0.004 * f64::from(row)).collect();
    let model = Model::new(own).with_tolerance(Tolerance { relative: 1e-8, absolute: 1e-8 });
    let nominal = model.rig.nominal();
    let here = model.sensitivities(&nominal, &asked, &drive, &times).unwrap();
    for (place, &index) in asked.iter().enumerate() {
        let at = |factor: f64| {
            let mut values = nominal.clone();
            values[index] *= factor;
            model.solve(&values, &drive, &times).unwrap().values[0][249]
        };
        let difference = (at(1.001) - at(0.999)) / (0.002 * nominal[index]);
        assert!((difference * nominal[index]).abs() > 500.0, "{difference}");
        assert_relative_eq!(here.derivatives[place][0][249], difference, max_relative = 1e-3);
    }
}

#[test]
fn a_formula_of_a_sensor_bends_its_reading() {
    let mut own = rig(BENT);
    let placed = own.placed("bent@q_A").unwrap();
    let one = |name: &str, value: f64| ParameterSetting { name: name.to_owned(), value, sigma: 0.0 };
    let drift = 0.5e-3 / 60.0;
    own.give_effect(&placed, &[one("a", 0.2), one("d", drift)]).unwrap();
    let sensor = own.sensors.iter().position(|sensor| sensor.name == "q_A").unwrap();
    let (bent, plain) = (outputs(&own), outputs(&rig("")));
    for (row, (a, b)) in bent[sensor].iter().zip(&plain[sensor]).enumerate() {
        let expected = b * (1.0 + 0.2 * b / (10e-3 / 60.0)) + drift * 0.004 * row as f64;
        assert_relative_eq!(*a, expected, max_relative = 1e-9, epsilon = 1e-15);
    }
    assert_eq!(bent[0], plain[0]);
    // The least reading bends by 20 % of 5.5 L/min over 10.
    assert!(bent[sensor][249] > 1.05 * plain[sensor][249]);
}

/// Where a fault stands in for an effect the effect scores nothing, and is fitted from its first size.
#[test]
fn what_a_fault_hides_is_added_all_the_same() {
    let path = "fixtures/two_tanks/rig.toml";
    let loss = "\n[own_effects.loss]\nat = \"upper_outlet\"\ndrop = \"K * q * abs(q)\"\n\
        parameters.K = { neutral = \"0 bar.min2/L2\", first = \"1e-4 bar.min2/L2\" }\n";
    let text = std::fs::read_to_string(path).unwrap() + loss;
    let plain = Rig::parse(path, text.clone()).unwrap();
    let mut lossy = plain.clone();
    let truth = 2e-4 * 1e5 / (1e-3 / 60.0_f64).powi(2);
    given(&mut lossy, "loss@upper_outlet", "K", truth);
    let record = Run::of(&Model::new(lossy)).record("lossy");
    let added = add(&text, &plain, "loss@upper_outlet", Some(&record)).unwrap();
    let rig = Rig::parse(path, added.text).unwrap();
    let found = &rig.parameters[rig.parameter("loss@upper_outlet.K").unwrap()];
    println!("{} +- {} of {truth}", found.value, found.sigma);
    assert!((found.value - truth).abs() < 3.0 * found.sigma && found.sigma < 0.3 * truth);
}

#[test]
fn a_formula_competes_with_the_library_and_stands_in_effects() {
    let rig =
        rig(&format!("{LEAK}{BUMP}\n[effects]\n\"tight-spot@piston\" = {{ F = \"300 N +- 50 N\", x0 = \"80 mm\" }}\n"));
    let ids: Vec<String> = rig.effect_places().iter().map(|placed| rig.effect_id(placed)).collect();
    assert!(ids.iter().any(|id| id == "weeping-joint@A"), "{ids:?}");
    assert_eq!(rig.effects[0].id, "tight-spot@piston");
    let value = |name: &str| rig.parameters[rig.parameter(&format!("tight-spot@piston.{name}")).unwrap()].value;
    assert_eq!((value("F"), value("x0"), value("w")), (300.0, 0.08, 0.01));
}

#[test]
fn mistakes_are_told() {
    for (more, from, to, message) in [
        (HEAVIER, "F_load", "F_load * t * valve_command", "too many inputs"),
        (HEAVIER, "-k * F_load", "-k * F_lod", "F_lod"),
        (BENT, "d * t", "d * p_A", "p_A"),
        (BENT, "reading * (1", "reading * (2", "neutral value the effect is not nothing"),
        (BENT, "reading =", "flow =", "no `flow` acts at `q_A`"),
        (LOSS, "drop =", "flow =", "no `flow` acts at `flow_control`"),
        (LOSS, "abs(q)", "abs(piston.v)", "piston.v"),
        (LOSS, "q * abs(q)", "q^2", "the drop does not rise with the flow `q`"),
        (LOSS, "\"flow_control\"", "\"directional_valve\"", "nothing can act at `directional_valve`"),
        (
            BUMP,
            "[\"1 mm\", \"100 mm\"]",
            "[\"100 mm\", \"1 mm\"]",
            "the first of the bounds of `w` is not below the second",
        ),
        (BUMP, "first = \"10 mm\"", "first = \"200 mm\"", "`first` of `w` is outside its bounds"),
        (BUMP, " / w)", " / [10 mm])", "the formula does not use `w`"),
        (WARMING, "parameters.r", "parameters.t", "a parameter cannot be called `t`"),
    ] {
        told(more, from, to, message);
    }
    for (from, to, message) in [
        ("at = \"A\"", "at = \"C\"", "nothing can act at `C`"),
        ("G * A.p", "G * A.p * A.p", "the formula gives power, not flow"),
        ("G * A.p", "G * A.q", "A.q"),
        ("G * A.p", "G * A.p + [0.1 L/min]", "neutral value the effect is not nothing"),
        ("neutral = \"0 L/min/bar\", ", "", "no neutral value"),
        ("own_effects.weeping-joint", "own_effects.pump-slip", "cannot be called `pump-slip`"),
        ("bounds = [\"0 L/min/bar\", \"0.2 L/min/bar\"]", "bounds = [\"0 L/min/bar\"]", "is no pair"),
        ("flow =", "force =", "no `force` acts at `A`"),
        ("flow =", "flux =", "has no `flow`"),
        // What it might see is named, not only what it sees.
        ("G * A.p", "G * A.p * F_laod", "did you mean `F_load`?"),
        ("G * A.p", "G * A.p * time", "`piston.v`, `valve_command`, `F_load`, `t`, `G`"),
    ] {
        told(LEAK, from, to, message);
    }
}

/// A run that would take a hundred times the steps of another is given up, and so is the fit that begins with it.
#[test]
fn a_formula_that_jumps_again_and_again_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (rig, record) = (folder.path().join("rig.toml"), folder.path().join("record.csv"));
    std::fs::write(&rig, std::fs::read_to_string(RIG).unwrap() + CHATTER).unwrap();
    let second = std::fs::read_to_string("fixtures/telescopic/healthy_1.csv").unwrap();
    std::fs::write(&record, second.lines().take(252).map(|line| format!("{line}\n")).collect::<String>()).unwrap();
    let [rig, record] = [&rig, &record].map(|path| path.to_str().unwrap());
    let begun = std::time::Instant::now();
    for arguments in [
        vec!["simulate", rig, "-o", "/dev/null"],
        vec!["simulate", rig, "--input", record, "-o", "/dev/null"],
        vec!["compare", rig, record],
        vec!["diagnose", rig, record],
        vec!["calibrate", rig, record, "-o", "/dev/null"],
    ] {
        let ran = borescope(&arguments);
        assert_eq!(ran.status, Some(2), "{arguments:?}: {}{}", ran.out, ran.err);
        let cause = "pressure of A jumps or bends again and again; there acts the formula \
                     `flow = G * A.p * sign(sin([10000 1/s] * t))` of `chatter";
        assert!(
            ran.err.contains("steps had to be taken back") && ran.err.contains(cause),
            "{arguments:?}: {}",
            ran.err
        );
    }
    assert!(begun.elapsed().as_secs() < 10, "{:?}", begun.elapsed());
}

#[test]
fn a_mistake_in_a_formula_has_its_caret() {
    let text = std::fs::read_to_string(RIG).unwrap() + &LEAK.replace("G * A.p", "G * A.p * F_laod");
    let told = Rig::parse(Path::new(RIG), text).unwrap_err().with_lines();
    let [line, carets] = [1, 0].map(|back| told.lines().rev().nth(back).unwrap());
    assert!(line.contains("G * A.p * F_laod") && carets.find('^') == line.find("F_laod"), "{told}");
}

/// The complaint about an effect with one thing replaced, and that it names a line of the effect.
fn told(effect: &str, from: &str, to: &str, message: &str) {
    assert!(effect.contains(from), "{from}");
    let text = std::fs::read_to_string(RIG).unwrap();
    let first = text.lines().count();
    let complaint = Rig::parse(Path::new(RIG), text + &effect.replace(from, to)).unwrap_err();
    println!("{complaint}\n");
    assert!(complaint.to_string().contains(message), "{complaint}");
    assert!(complaint.places[0].line.is_some_and(|line| line > first), "{complaint}");
}
