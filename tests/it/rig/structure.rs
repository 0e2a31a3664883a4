//! Structural analysis of rigs, read off their circuits.

use std::time::Instant;

use borescope::Rig;
use borescope::internals::structure::isolability::{isolation, isolation_by_tests, signatures};
use borescope::internals::structure::mtes::mtes_sets;
use borescope::internals::structure::{Count, Isolability, Structure, analyse, from_rig};

fn telescopic() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/telescopic/rig.toml")).unwrap()
}

/// The three faults of the paper.
const OF_THE_PAPER: [&str; 3] = ["cylinder.clearance", "flow_control.orifice_diameter", "directional_valve.opening"];

/// The rig with these of its faults and no others.
fn with_only_faults(text: &str, ids: &[&str]) -> String {
    let (before, rest) = text.split_once("[faults]\n").unwrap();
    let (faults, after) = rest.split_once("\n\n").unwrap();
    let line = |id: &&str| faults.lines().find(|line| line.starts_with(&format!("\"{id}\" = "))).expect(id);
    let kept: Vec<&str> = ids.iter().map(line).collect();
    format!("{before}[faults]\n{}\n\n{after}", kept.join("\n"))
}

/// The rig without these sensors and whatever may be wrong with them.
fn without_sensors(text: &str, names: &[&str]) -> String {
    let mut text = text.to_owned();
    for name in names {
        let (sensor, faults) = (format!("{name} = {{ quantity"), format!("\"sensor.{name}."));
        assert!(text.lines().any(|line| line.starts_with(&sensor)), "{name}");
        let stays = |line: &&str| !line.starts_with(&sensor) && !line.starts_with(&faults);
        text = text.lines().filter(stays).map(|line| format!("{line}\n")).collect();
    }
    text
}

fn with_faults(text: &str, faults: &str) -> String {
    text.replace("[faults]\n", &format!("[faults]\n{faults}"))
}

fn three_faults() -> String {
    with_only_faults(&telescopic(), &OF_THE_PAPER)
}

fn parse(text: String) -> Rig {
    Rig::parse("rig.toml", text).unwrap()
}

/// The unknowns and the faults of an equation, by name and sorted.
fn held<'a>(structure: &'a Structure, equation: &str) -> (Vec<&'a str>, Vec<&'a str>) {
    let equation = structure.equations.iter().find(|other| other.name == equation).unwrap();
    let mut unknowns: Vec<&str> = equation.unknowns.iter().map(|&u| structure.unknowns[u].name.as_str()).collect();
    let mut faults: Vec<&str> = equation.faults.iter().map(|&f| structure.faults[f].as_str()).collect();
    unknowns.sort();
    faults.sort();
    (unknowns, faults)
}

#[test]
fn laws_are_probed() {
    let structure = from_rig(&parse(three_faults()));
    let (unknowns, faults) = held(&structure, "flow into directional_valve.A");
    assert_eq!(
        unknowns,
        [
            "flow into directional_valve.A",
            "pressure of A",
            "pressure of tank",
            "pressure of valve_line",
            "spool of directional_valve"
        ]
    );
    assert_eq!(faults, ["directional_valve.opening"]);
    // Regulates only in a narrow range of pressure drops.
    let (unknowns, faults) = held(&structure, "rate of opening of flow_control");
    assert!(unknowns.contains(&"pressure of pump_line") && unknowns.contains(&"pressure of valve_line"));
    assert_eq!(faults, ["flow_control.orifice_diameter"]);
    // Healthy at 0, where a cubic law has no slope.
    let (unknowns, faults) = held(&structure, "flow into cylinder.B");
    assert_eq!(unknowns, ["flow into cylinder.B", "pressure of A", "pressure of B", "velocity of piston"]);
    assert_eq!(faults, ["cylinder.clearance"]);
    // The chamber's volume follows the piston.
    let (unknowns, _) = held(&structure, "flow balance of A");
    assert!(unknowns.contains(&"position of piston") && unknowns.contains(&"rate of pressure of A"));
    // A line volume takes no flow of its own.
    assert!(!structure.equations.iter().any(|equation| equation.name.contains("valve_line.P")));
    let laws: Vec<&str> = structure.equations.iter().filter(|e| e.knowns == [1]).map(|e| e.name.as_str()).collect();
    assert_eq!(laws, ["force of load.body"]);
}

#[test]
fn three_faults_of_the_telescopic_rig() {
    let result = show(&parse(three_faults()));
    assert_eq!((result.equations, result.unknowns, result.redundancy), (44, 36, 8));
    assert_eq!(result.explained_by, [[true, false, false], [false, true, false], [false, false, true]]);
    assert_eq!(result.mtes_sets, Count { count: 3, complete: true });
    assert_eq!(result.sensors, [Vec::<String>::new()]);
    assert!(result.ambiguity_groups.is_empty() && result.inseparable.is_empty());
    let clearance = result.tests.iter().find(|test| test.faults == ["cylinder.clearance"]).unwrap();
    assert_eq!(clearance.signals.len(), 4, "{clearance:?}");
    let json: serde_json::Value = serde_json::to_value(&result).unwrap();
    assert_eq!(json["mso_sets"]["complete"], true);
}

fn show(rig: &Rig) -> Isolability {
    let start = Instant::now();
    let result = analyse(rig);
    println!("analysed in {:.1} ms\n{}", start.elapsed().as_secs_f64() * 1e3, result);
    result
}

#[test]
fn few_sensors() {
    let two = show(&parse(without_sensors(&three_faults(), &["p_P", "p_A", "p_B", "q_P", "q_A", "q_B"])));
    assert_eq!(two.detectable, [true; 3]);
    assert!(two.ambiguity_groups.is_empty());
    assert!(two.tests.iter().all(|test| test.faults.len() == 2));
    let none =
        show(&parse(without_sensors(&three_faults(), &["p_pump", "p_P", "p_A", "p_B", "q_P", "q_A", "q_B", "x"])));
    assert_eq!((none.redundancy, none.mso_sets.count, none.tests.len()), (0, 0, 0));
    assert_eq!(none.detectable, [false; 3]);
    assert!(!none.sensors.is_empty());
    assert!(none.sensors.iter().all(|sensors| sensors.len() == 2));
}

/// The sensors suggested are those of all single ones that do.
#[test]
fn suggested_sensors_do() {
    let rig = parse(without_sensors(&three_faults(), &["p_pump", "p_P", "p_A", "p_B", "q_P", "q_A", "q_B"]));
    let result = show(&rig);
    assert_eq!(result.ambiguity_groups.len(), 1);
    let structure = from_rig(&rig);
    let does = |unknown: &usize| {
        structure.unknowns[*unknown].measurable
            && isolation(&structure.with_sensor(*unknown, false)).groups().len() == 3
    };
    let doing: Vec<Vec<String>> = (0..structure.unknowns.len())
        .filter(does)
        .map(|unknown| vec![structure.unknowns[unknown].name.clone()])
        .collect();
    assert_eq!(result.sensors, doing);
}

/// What the whole rig can tell apart: every fault from every other, with nine pairs excepted.
#[test]
fn all_faults_of_the_telescopic_rig() {
    let result = show(&parse(telescopic()));
    assert_eq!(result.faults.len(), 23);
    assert!(result.detectable.iter().all(|&detectable| detectable));
    // Set pressure and displacement act on the flow over the relief valve alone, which nothing measures.
    let mut pairs = vec![["relief.set_pressure".to_owned(), "pump.displacement".to_owned()]];
    // Offset and gain of a sensor stand in one equation.
    let sensors = ["p_pump", "p_P", "p_A", "p_B", "q_P", "q_A", "q_B", "x"];
    pairs.extend(sensors.map(|name| ["offset", "gain"].map(|wrong| format!("sensor.{name}.{wrong}"))));
    assert_eq!(result.ambiguity_groups, pairs);
    for (fault, explained_by) in result.faults.iter().zip(&result.explained_by) {
        for (other, &explains) in result.faults.iter().zip(explained_by) {
            let paired = pairs.iter().any(|pair| pair.contains(fault) && pair.contains(other));
            assert_eq!(explains, fault == other || paired, "{fault} explained by {other}");
        }
    }
    // A flow beside the relief valve parts the first pair, nothing at all the others: each fault of them explains the other.
    assert_eq!(result.sensors, ["pump.P", "pump.T", "relief.P", "relief.T"].map(|port| [format!("flow into {port}")]));
    assert_eq!(result.inseparable.len(), 2 * sensors.len());
}

/// With the fluid's properties as faults too: what the tests tell apart is what the structure lets be told apart.
#[test]
fn many_faults() {
    let fluid = r#"
        "fluid.viscosity" = { healthy = "45.5 mPa.s", bounds = ["20 mPa.s", "80 mPa.s"] }
        "fluid.bulk_modulus" = { healthy = "14000 bar", bounds = ["2000 bar", "16000 bar"] }
    "#;
    let rig = parse(with_faults(&telescopic(), fluid));
    let result = show(&rig);
    assert_eq!(result.faults.len(), 25);
    assert!(result.detectable.iter().all(|&detectable| detectable));
    // Offset and gain of each of the eight sensors, and what only the flow at the relief valve would tell apart.
    assert_eq!(result.ambiguity_groups.len(), 9);
    assert_eq!(result.ambiguity_groups[0], ["relief.set_pressure", "pump.displacement"]);
    assert!(result.sensors.contains(&vec!["flow into relief.P".to_owned()]));
    assert_eq!(result.inseparable.len(), 16);
    let structure = from_rig(&rig).one_equation_per_fault();
    let tests = signatures(&structure, &mtes_sets(&structure, usize::MAX).sets);
    assert_eq!(isolation_by_tests(&tests, 25), isolation(&structure));
}

#[test]
fn a_volume_whose_deviation_is_stated_is_one_value_throughout() {
    let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
    let varies = |text: &str| {
        let rig = borescope::Rig::parse("rig.toml", text.to_owned()).unwrap();
        let volume = rig.parameter("pump_line.volume").map(|index| rig.parameters[index].clone()).unwrap();
        (volume.per_event, volume.sigma / volume.value)
    };
    let (by_default, sigma) = varies(&text);
    assert!(by_default && (sigma - 0.05).abs() < 1e-12, "{sigma}");
    let (stated, sigma) = varies(&text.replacen("\"50 cm3\"", "\"50 cm3 +- 10 %\"", 1));
    assert!(!stated && (sigma - 0.1).abs() < 1e-12, "{sigma}");
}
