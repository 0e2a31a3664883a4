//! Components of formulas: laws that act like built-in ones, files that are included, the catalogue, and every mistake with its line.

use std::fs;
use std::path::Path;

use approx::assert_relative_eq;
use borescope::internals::model::{InputSignals, Model};
use borescope::internals::physics::ATMOSPHERE;
use borescope::internals::physics::fluid::{self, Fluid};
use borescope::internals::physics::ports::{PortFlows, PortVariables};
use borescope::internals::residual::{Variant, generators};
use borescope::internals::rig::Rig;

use crate::support::command::borescope;

const FILTER: &str = "fixtures/own_filter/rig.toml";

fn text() -> String {
    fs::read_to_string(FILTER).unwrap()
}

fn parse(text: String) -> Rig {
    Rig::parse(FILTER, text).unwrap_or_else(|complaint| panic!("{complaint}"))
}

/// What the sensors show over the cycle.
fn outputs(rig: &Rig) -> Vec<Vec<f64>> {
    let drive = InputSignals::from_cycle(rig, rig.cycle.as_ref().unwrap());
    let times: Vec<f64> = (0..600).map(|row| 0.02 * f64::from(row)).collect();
    Model::new(rig.clone()).solve(&rig.nominal(), &drive, &times).unwrap().values
}

/// What a component of the rig answers at variables and inputs, SI.
fn answers(rig: &Rig, name: &str, at: &[f64], inputs: &[f64]) -> PortFlows<f64> {
    let nominal = rig.nominal();
    let component = rig.components.iter().find(|component| component.name == name).unwrap();
    let fluid = Fluid::new(&nominal[..fluid::CARD.parameters.len()]);
    let law = component.law(|index| nominal[index], &fluid).unwrap();
    let (mut seen, mut answers) = (PortVariables::default(), PortFlows::default());
    seen.z[..at.len()].copy_from_slice(at);
    seen.u[..inputs.len()].copy_from_slice(inputs);
    law.evaluate(&seen, &mut answers);
    answers
}

const ORIFICE: &str = r#"
[own_components.hole]
ports = { in = "hydraulic", out = "hydraulic" }
parameters.diameter = { unit = "mm" }
quantities.conductance = "0.7 * 0.785398163397 * diameter^2 * sqrt(2 / fluid.density)"
flow = { from = "in", to = "out", formula = "conductance * root(in.p - out.p, [0.2 bar])" }
"#;

/// A default that names another parameter is what the file states of that one, and stays where that one goes.
#[test]
fn a_default_may_be_what_another_parameter_is_stated_as() {
    let own = |default: &str| {
        let drawn = format!("drawn = {{ unit = \"mm\", default = \"{default}\" }}");
        let ratio = "conductance = \"0.7 * 0.785398163397 * drawn * diameter * sqrt(2 / fluid.density)\"";
        let (before, rest) = ORIFICE.split_once("quantities.").unwrap();
        let rest = rest.split_once('\n').unwrap().1;
        format!("{before}parameters.{drawn}\nquantities.{ratio}\n{rest}")
    };
    let with = |default: &str, stated: &str| {
        let hole = format!("hole = {{ kind = \"own:hole\", ports = {{ in = \"clean\", out = \"tank\" }}, {stated} }}");
        text().replacen("[components]\n", &format!("[components]\n{hole}\n"), 1) + &own(default)
    };
    let value = |rig: &Rig, id: &str| rig.parameters[rig.parameter(id).unwrap()].clone();
    let rig = parse(with("diameter", "diameter = \"2 mm +- 0.1 mm\""));
    let drawn = value(&rig, "hole.drawn");
    assert_eq!((drawn.value, drawn.sigma, value(&rig, "hole.diameter").sigma), (2e-3, 0.0, 1e-4));
    let rig = parse(with("diameter", "diameter = \"2 mm\", drawn = \"3 mm\""));
    assert_eq!(value(&rig, "hole.drawn").value, 3e-3);
    // What is no name of another is a number, and an unlike unit is told.
    let told = |text: String| Rig::parse(FILTER, text).unwrap_err().to_string();
    assert!(told(with("diametre", "diameter = \"2 mm\"")).contains("diametre"));
    let unlike =
        with("diameter", "diameter = \"2 mm\"").replacen("drawn = { unit = \"mm\"", "drawn = { unit = \"cm\"", 1);
    let told = told(unlike);
    assert!(told.contains("`drawn` is by default as `diameter`") && told.contains("unit = \"mm\""), "{told}");
}

#[test]
fn a_formula_acts_like_the_built_in_law() {
    let outlet = |line: &str| {
        let text = text();
        let (before, rest) = text.split_once("outlet = {").unwrap();
        let rest = rest.split_once('\n').unwrap().1.replace("\"outlet.conductance\"", "#");
        format!("{before}outlet = {{ {line} }}\n{rest}{ORIFICE}")
    };
    let own = parse(outlet(r#"kind = "own:hole", ports = { in = "clean", out = "tank" }, diameter = "3 mm""#));
    let built_in = outlet(
        r#"kind = "orifice", ports = { in = "clean", out = "tank" }, diameter = "3 mm", transition_pressure = "0.2 bar""#,
    );
    let built_in = parse(built_in.replace(ORIFICE, ""));
    for (a, b) in outputs(&own).iter().flatten().zip(outputs(&built_in).iter().flatten()) {
        assert_relative_eq!(a, b, max_relative = 1e-6, epsilon = 1e-9);
    }
}

#[test]
fn what_goes_in_comes_out() {
    let rig = parse(text());
    let flows = answers(&rig, "outlet", &[ATMOSPHERE + 9e5, ATMOSPHERE, 0.5], &[2.0]);
    // 12 L/min/bar^0.5, half open, sqrt(9 bar): 18 L/min, but for the smooth root.
    assert_relative_eq!(flows.through[0], 18e-3 / 60.0, max_relative = 1e-4);
    assert_eq!(flows.through[0], -flows.through[1]);
    // 2 V of 4 V is where it stands already.
    assert_eq!(flows.rate[0], 0.0);
}

const RAM: &str = r#"
[own_components.ram]
ports = { A = "hydraulic", rod = "body" }
parameters.bore = { unit = "mm", positive = true }
parameters.dead_volume = { unit = "cm3", role = "volume" }
parameters.m = { unit = "kg", positive = true, role = "mass" }
quantities.area = "0.785398163397 * bore^2"
piston = { at = "A", on = "rod", area = "area" }
volume = { at = "A", formula = "dead_volume + area * max(rod.x, [0 mm])" }
mass = { on = "rod", formula = "m" }
force = { on = "rod", formula = "-m * [9.80665 m/s2]" }
"#;

#[test]
fn a_piston_gives_its_body_the_power_that_it_takes() {
    let text = text().replace("[nodes]\n", &format!("{RAM}\n[nodes]\nbody = {{}}\n"));
    let rig = parse(text.replace(
        "\n[inputs.u]",
        "ram = { kind = \"own:ram\", ports = { A = \"clean\", rod = \"body\" }, bore = \"50 mm\", dead_volume = \"10 cm3\", \
         m = \"200 kg\" }\n\n[inputs.u]",
    ));
    let area = std::f64::consts::FRAC_PI_4 * 0.05f64.powi(2);
    let answers = answers(&rig, "ram", &[ATMOSPHERE + 40e5, 0.1, 0.2], &[]);
    let weight = 200.0 * 9.80665;
    assert_relative_eq!(answers.through[0], area * 0.2, max_relative = 1e-9);
    assert_relative_eq!(answers.through[1] + weight, area * 40e5, max_relative = 1e-9);
    assert_relative_eq!(answers.through[0] * 40e5, (answers.through[1] + weight) * 0.2, max_relative = 1e-9);
    assert_relative_eq!(answers.capacity[0], (10e-6 + area * 0.1) / 1.4e9, max_relative = 1e-9);
    assert_eq!(answers.capacity[1], 200.0);
}

#[test]
fn a_flow_that_nobody_measures_follows_from_the_law_and_a_measured_one_does_not() {
    let signature = |text: String| {
        let rig = parse(text);
        let all = generators(&rig).into_iter().filter(|one| one.variant == Variant::Corrected);
        all.map(|one| one.id).collect::<Vec<_>>()
    };
    assert_eq!(signature(text()), ["filter.flow", "outlet.flow"]);
    // Without its sensor the flow of the filter is what the throttle behind it takes.
    let unmeasured: String =
        text().lines().filter(|line| !line.starts_with("q = ")).map(|line| format!("{line}\n")).collect();
    assert_eq!(signature(unmeasured.clone()), ["filter.flow", "outlet.flow"]);
    // With neither sensor nor pressure behind it nothing is known.
    let blind: String =
        unmeasured.lines().filter(|line| !line.starts_with("p_clean")).map(|line| format!("{line}\n")).collect();
    assert!(signature(blind).is_empty());
}

#[test]
fn a_clogged_filter_of_formulas_is_diagnosed() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("clogged.csv");
    let record = record.to_str().unwrap();
    let set = "filter.clogging=0.3";
    assert!(borescope(["simulate", FILTER, "--set", set, "--seed", "1", "-o", record]).status == Some(0));
    let output = borescope(["diagnose", FILTER, record, "--format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&output.out).unwrap();
    assert_eq!(found["verdict"], "faulty");
    let fault = found["faults"].as_array().unwrap().iter().find(|fault| fault["id"] == "filter.clogging").unwrap();
    assert_eq!(fault["present"], true);
    let ends: Vec<f64> = fault["ci95"].as_array().unwrap().iter().map(|end| end.as_f64().unwrap()).collect();
    assert!(ends[0] < 0.3 && 0.3 < ends[1] && ends[1] - ends[0] < 0.02, "{ends:?}");
    assert!(found["faults"].as_array().unwrap().iter().filter(|fault| fault["present"] == true).count() == 1);
}

/// The message about the rig file with a change.
fn message(from: &str, to: &str) -> String {
    let text = text();
    assert!(text.contains(from), "{from}");
    Rig::parse(FILTER, text.replacen(from, to, 1)).unwrap_err().with_lines()
}

#[test]
fn every_mistake_has_its_line_and_a_remedy() {
    let flow = "conductance * opening * root(drop, [0.1 bar])";
    for (from, to, pieces) in [
        (
            flow,
            "conductanse * opening * root(drop, [0.1 bar])",
            &["unknown name", "did you mean `conductance`?", "^"][..],
        ),
        (flow, "conductance * opening * drop", &["the formula gives", "not flow", "^"]),
        (
            "from = \"in\", to = \"out\", formula = \"conductance * opening",
            "from = \"in\", formula = \"conductance * opening",
            &["has no `to`", "no oil is made or lost", "add a port that meets the tank"],
        ),
        (
            "to = \"out\", formula = \"conductance * opening",
            "to = \"in\", formula = \"conductance * opening",
            &["from port `in` to itself"],
        ),
        (
            "to = \"out\", formula = \"conductance * opening",
            "to = \"ouf\", formula = \"conductance * opening",
            &["which is no port", "did you mean `out`?"],
        ),
        ("follows = \"command / [4 V]\", lag = \"tau\"", "scale = 1", &["state `opening` has no `rate`", "follows"]),
        ("lag = \"tau\"", "lag = \"conductance\"", &["no parameter that is a time"]),
        ("default = \"20 ms\", positive = true", "default = \"20 ms\"", &["may be 0", "positive = true"]),
        ("command / [4 V]", "command", &["the formula gives voltage", "not a pure number"]),
        (
            "parameters.tau =",
            "parameters.spare = { unit = \"-\" }\nparameters.tau =",
            &["uses `spare`", "no record could say"],
        ),
        (flow, "conductance * opening * drop / sqrt(drop)", &["has no value at", "root("]),
        (
            "worked.gives = { in = \"12 L/min\" }",
            "worked.gives = { in = \"13 L/min\" }",
            &["give 11.998 L/min and not 13 L/min"],
        ),
        (
            "quantities.drop = \"in.p - out.p\"",
            "quantities.drop = \"2 * drop\"",
            &["a quantity cannot build on itself"],
        ),
        (
            "kind = \"own:throttle\"",
            "kind = \"own:throtle\"",
            &["unknown component kind", "did you mean `own:throttle`?"],
        ),
        ("kind = \"own:throttle\"", "kind = \"catalogue:filtr\"", &["unknown component kind", "catalogue:filter"]),
        ("symbol = \"orifice\"", "symbol = \"hole\"", &["`hole`", "orifice"]),
        ("bounds = [0, 1]", "bounds = [0, 1], effect = { first = 0.1 }", &["has no `name`", "spool-hysteresis"]),
        ("bounds = [0, 1]", "bounds = [0, 1], effect = { name = \"a@b\", first = 0.1 }", &["cannot be called `a@b`"]),
        (
            "bounds = [0, 1]",
            "bounds = [0, 1], effect = { name = \"a\", first = 2 }",
            &["`first` of `clogging`", "shows"],
        ),
        (
            "bounds = [0, 1]",
            "bounds = [0, 1], effect = { name = \"a\", first = 0 }",
            &["the size of an effect", "shows"],
        ),
        (
            "default = 0, bounds = [0, 1]",
            "effect = { name = \"a\", first = 2 }",
            &["has no default", "without the effect"],
        ),
        ("unit = \"-\", follows", "unit = \"-\", falls = 1, follows", &["has no key `falls`"]),
        ("inputs.command", "inputs.drop", &["`drop` names two things"]),
        ("command = \"u\", ", "", &["has no `command`"]),
    ] {
        let message = message(from, to);
        for piece in pieces {
            assert!(message.contains(piece), "{to}\n{message}\nlacks: {piece}");
        }
        assert!(message.contains("rig.toml:") && message.contains("help:"), "{message}");
    }
}

#[test]
fn files_are_included_once_and_never_in_a_circle() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let text = text();
    let (head, rest) = text.split_once("[own_components.filter]").unwrap();
    let (own, rest) = rest.split_once("[nodes]").unwrap();
    let rig = format!("include = [\"parts.toml\", \"more.toml\"]\n{head}[nodes]{rest}");
    write("parts.toml", &format!("[own_components.filter]{own}"));
    write("more.toml", "include = \"parts.toml\"\n");
    write("rig.toml", &rig);
    let path = folder.path().join("rig.toml");
    assert_eq!(outputs(&Rig::read(&path).unwrap()), outputs(&parse(text.clone())));

    write("more.toml", "include = \"more.toml\"\n");
    let message = Rig::read(&path).unwrap_err().with_lines();
    assert!(message.contains("`more.toml` includes itself") && message.contains("more.toml:1"), "{message}");
    write("more.toml", "include = \"rig.toml\"\n");
    assert!(Rig::read(&path).unwrap_err().to_string().contains("`rig.toml` includes itself"));
    write("more.toml", &format!("[own_components.filter]{own}"));
    let message = Rig::read(&path).unwrap_err().with_lines();
    assert!(
        message.contains("described twice") && message.contains("parts.toml") && message.contains("more.toml"),
        "{message}"
    );
    write("more.toml", "[nodes]\nA = {}\n");
    assert!(Rig::read(&path).unwrap_err().to_string().contains("has no key `nodes`"));
    fs::remove_file(folder.path().join("more.toml")).unwrap();
    assert!(Rig::read(&path).unwrap_err().with_lines().contains("rig.toml:1"));
}

#[test]
fn a_part_of_the_catalogue_is_used_twice_and_copied() {
    let line = |kind: &str| {
        format!("ports = {{ in = \"clean\", out = \"tank\" }}, kind = \"{kind}\", conductance = \"12 L/min/bar\"")
    };
    let with = |kind: &str, more: &str| {
        let text = text().replace(
            "\n[inputs.u]",
            &format!("bypass = {{ {} }}\nleak = {{ {}, clogging = 0.9 }}\n\n[inputs.u]", line(kind), line(kind)),
        );
        format!("{text}{more}")
    };
    let rig = parse(with("catalogue:filter", ""));
    let at = [ATMOSPHERE + 2e5, ATMOSPHERE];
    assert_relative_eq!(answers(&rig, "bypass", &at, &[]).through[0], 24e-3 / 60.0, max_relative = 1e-9);
    assert_relative_eq!(answers(&rig, "leak", &at, &[]).through[0], 2.4e-3 / 60.0, max_relative = 1e-9);

    let output = borescope(["components", "catalogue:filter", "--source"]);
    let copied = output.out.replace("own_components.filter", "own_components.mine");
    let copied = parse(with("own:mine", &copied));
    assert_eq!(outputs(&copied), outputs(&rig));
}

#[test]
fn every_file_of_the_catalogue_is_a_component() {
    for entry in fs::read_dir("catalogue").unwrap() {
        let path = entry.unwrap().path();
        let name = Path::new(&path).file_stem().unwrap().to_str().unwrap().to_owned();
        let output = borescope(["components", format!("catalogue:{name}").as_str()]);
        assert_eq!(output.status, Some(0), "{name}: {}", output.err);
        assert!(output.out.contains("must be given"), "{name}");
    }
}

const SOLENOIDS: &str = r#"
[nodes]
tank = {}
P = { initial = "0 bar" }
A = { initial = "0 bar" }
B = { initial = "0 bar" }

[components]
tank = { kind = "tank", ports = { T = "tank" } }
volume_P = { kind = "line-volume", ports = { P = "P" }, volume = "100 cm3" }
volume_A = { kind = "line-volume", ports = { P = "A" }, volume = "100 cm3" }
volume_B = { kind = "line-volume", ports = { P = "B" }, volume = "100 cm3" }
valve = { kind = "catalogue:solenoid-valve", ports = { P = "P", T = "tank", A = "A", B = "B" }, a = "a", b = "b", rated_flow = "40 L/min", CENTRE }

[inputs.a]
unit = "-"
[inputs.b]
unit = "-"
"#;

#[test]
fn a_solenoid_valve_has_the_centre_that_is_stated_a_mass_and_two_switching_times() {
    let litres = 1e-3 / 60.0;
    let [p, a, b] = [20e5, 5e5, 5e5].map(|gauge| gauge + ATMOSPHERE);
    // Ports P, T, A, B, then the spool and its speed.
    let moving = |spool: f64, speed: f64| [p, ATMOSPHERE, a, b, spool, speed];
    let at = |spool: f64| moving(spool, 0.0);
    let valve = |centre: &str| {
        Rig::parse(FILTER, format!("[fluid]\n{}", SOLENOIDS.replace("CENTRE", centre)))
            .unwrap_or_else(|told| panic!("{told}"))
    };
    let flows =
        |rig: &Rig, spool: f64| answers(rig, "valve", &at(spool), &[0.0, 0.0]).through.map(|flow| flow / litres);

    // 40 L/min at 5 bar: 80 at 20 bar, 69.28 at 15 bar, 40 from a consumer at 5 bar to the tank.
    let tandem = valve("centre_PT = 0.5");
    assert_relative_eq!(flows(&tandem, 0.0)[0], 40.0, max_relative = 1e-4);
    assert_relative_eq!(flows(&tandem, 0.0)[2], 0.0, epsilon = 1e-9);
    // Half way through the lap of 20 % the centre is half shut; beyond it, it is shut and the edges open.
    assert_relative_eq!(flows(&tandem, 0.1)[0], 20.0, max_relative = 1e-4);
    let [from_p, _, into_a, from_b, ..] = flows(&tandem, 0.6);
    assert_relative_eq!(from_p, 0.5 * 69.282, max_relative = 1e-4);
    assert_relative_eq!(into_a, -0.5 * 69.282, max_relative = 1e-4);
    assert_relative_eq!(from_b, 0.5 * 40.0, max_relative = 1e-4);
    let float = valve("centre_AT = 0.25, centre_BT = 0.5");
    assert_relative_eq!(flows(&float, 0.0)[2], 10.0, max_relative = 1e-4);
    assert_relative_eq!(flows(&float, 0.0)[3], 20.0, max_relative = 1e-4);
    assert_relative_eq!(flows(&float, 0.0)[0], 0.0, epsilon = 1e-9);

    // `T² s'' + tau s' + s = u` with `T = tau/(2 * 0.7)`: 15 ms while a solenoid pulls, 20 ms while springs do.
    let accelerates = |at: &[f64], solenoids: [f64; 2]| {
        let [speed, acceleration, ..] = answers(&tandem, "valve", at, &solenoids).rate;
        assert_eq!(speed, at[5]);
        acceleration
    };
    assert_relative_eq!(accelerates(&at(0.0), [1.0, 0.0]), (1.4_f64 / 15e-3).powi(2), max_relative = 1e-9);
    assert_relative_eq!(accelerates(&at(-1.0), [0.0, 0.0]), (1.4_f64 / 20e-3).powi(2), max_relative = 1e-9);
    // At a speed at which its whole way takes one lag damping holds what the solenoid gives.
    assert_relative_eq!(accelerates(&moving(0.0, 1.0 / 15e-3), [1.0, 0.0]), 0.0, epsilon = 1e-6);
}

#[test]
fn the_physics_that_a_component_may_lack_is_an_effect_of_the_rig() {
    let with = "bounds = [0, 1], effect = { name = \"clogged-element\", first = 0.1 }";
    let rig = parse(text().replacen("bounds = [0, 1]", with, 1));
    let places: Vec<String> = rig.effect_places().iter().map(|placed| rig.effect_id(placed)).collect();
    assert!(places.contains(&"clogged-element@filter".to_owned()), "{places:?}");
    let placed = rig.placed("clogged-element@filter").unwrap();
    assert_eq!(placed.effect.parameters[0].neutral, Some(0.0));
    assert_eq!(rig.parameters[rig.bent(&placed, "clogging").unwrap()].id, "filter.clogging");

    // The catalogue's, and those of the library that sit at whatever is a cylinder.
    let axis = Rig::read("fixtures/servo_axis/rig.toml").unwrap();
    for id in ["spool-hysteresis@valve", "spool-dead-band@valve", "viscous-friction@cylinder", "seal-friction@cylinder"]
    {
        let mut with = axis.clone();
        let placed = axis.placed(id).unwrap_or_else(|complaint| panic!("{complaint}"));
        with.give_effect(&placed, &[]).unwrap();
        assert_eq!(with.effects[0].id, id);
    }
    assert!(axis.placed("end-cushioning@cylinder").is_ok());
    assert!(Rig::read("fixtures/two_tanks/rig.toml").unwrap().placed("seal-friction").is_err());
}
