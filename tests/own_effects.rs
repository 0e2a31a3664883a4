//! Effects of the rig file's own: formulas that act like the library's laws, and every mistake told with its line.

use std::path::Path;

use approx::assert_relative_eq;
use borescope::model::{Drive, Model};
use borescope::rig::{Given, Rig};

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

fn rig(more: &str) -> Rig {
    let text = std::fs::read_to_string(RIG).unwrap();
    Rig::parse(RIG, text + more).unwrap_or_else(|complaint| panic!("{complaint}"))
}

/// What the sensors show over the first second of the cycle.
fn outputs(rig: &Rig) -> Vec<Vec<f64>> {
    let drive = Drive::from_cycle(rig, rig.cycle.as_ref().unwrap());
    let times: Vec<f64> = (0..250).map(|row| 0.004 * f64::from(row)).collect();
    Model::new(rig.clone()).simulate(&rig.nominal(), &drive, &times).unwrap().values
}

fn given(rig: &mut Rig, id: &str, name: &str, value: f64) {
    let placed = rig.placed(id).unwrap();
    rig.give_effect(&placed, &[Given { name: name.to_owned(), value, sigma: 0.0 }]).unwrap();
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
    for (more, id, size) in [(LEAK, "weeping-joint", "G"), (BUMP, "tight-spot@piston", "F")] {
        let mut with = rig(more);
        given(&mut with, id, size, 0.0);
        for (a, b) in outputs(&with).iter().flatten().zip(plain.iter().flatten()) {
            assert_relative_eq!(a, b, max_relative = 1e-9, epsilon = 1e-12);
        }
    }
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
    for (from, to, message) in [
        ("at = \"A\"", "at = \"C\"", "nothing can act at `C`"),
        ("G * A.p", "G * A.p * A.p", "the formula gives power, not flow"),
        ("G * A.p", "G * A.q", "A.q"),
        ("G * A.p", "G * A.p + [0.1 L/min]", "neutral value the effect is not nothing"),
        ("neutral = \"0 L/min/bar\", ", "", "no neutral value"),
        ("own_effects.weeping-joint", "own_effects.pump-slip", "cannot be called `pump-slip`"),
        ("bounds = [\"0 L/min/bar\", \"0.2 L/min/bar\"]", "bounds = [\"0 L/min/bar\"]", "is no pair"),
        ("flow =", "force =", "has no `flow`"),
    ] {
        assert!(LEAK.contains(from), "{from}");
        let text = std::fs::read_to_string(RIG).unwrap();
        let first = text.lines().count();
        let complaint = Rig::parse(Path::new(RIG), text + &LEAK.replace(from, to)).unwrap_err();
        println!("{complaint}\n");
        assert!(complaint.to_string().contains(message), "{complaint}");
        assert!(complaint.places[0].line.is_some_and(|line| line > first), "{complaint}");
    }
}
