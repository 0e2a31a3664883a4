//! Structural analysis of rigs, read off their circuits.

use std::time::Instant;

use borescope::rig::Rig;
use borescope::structure::isolability::{isolation, isolation_by_tests, signatures};
use borescope::structure::mtes::mtes_sets;
use borescope::structure::{Count, Isolability, Structure, analyse, from_rig, render};

fn telescopic() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/telescopic/rig.toml")).unwrap()
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
    let structure = from_rig(&parse(telescopic()));
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
fn telescopic_rig() {
    let result = show(&parse(telescopic()));
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
    println!("analysed in {:.1} ms\n{}", start.elapsed().as_secs_f64() * 1e3, render(&result));
    result
}

fn without_sensors(text: &str, names: &[&str]) -> String {
    let gone = |line: &str| names.iter().any(|name| line.starts_with(&format!("{name} = {{ quantity")));
    text.lines().filter(|line| !gone(line)).map(|line| format!("{line}\n")).collect()
}

fn with_faults(text: &str, faults: &str) -> String {
    text.replace("[faults]\n", &format!("[faults]\n{faults}"))
}

#[test]
fn few_sensors() {
    let two = show(&parse(without_sensors(&telescopic(), &["p_P", "p_A", "p_B", "q_P", "q_A", "q_B"])));
    assert_eq!(two.detectable, [true; 3]);
    assert!(two.ambiguity_groups.is_empty());
    assert!(two.tests.iter().all(|test| test.faults.len() == 2));
    let none = show(&parse(without_sensors(&telescopic(), &["p_pump", "p_P", "p_A", "p_B", "q_P", "q_A", "q_B", "x"])));
    assert_eq!((none.redundancy, none.mso_sets.count, none.tests.len()), (0, 0, 0));
    assert_eq!(none.detectable, [false; 3]);
    assert!(none.sensors.iter().all(|sensors| sensors.len() == 2));
}

/// The sensors suggested are those of all single ones that do.
#[test]
fn suggested_sensors_do() {
    let rig = parse(without_sensors(&telescopic(), &["p_pump", "p_P", "p_A", "p_B", "q_P", "q_A", "q_B"]));
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

#[test]
fn many_faults() {
    let mut faults = String::new();
    for (sensor, unit) in [("p_pump", "bar"), ("p_P", "bar"), ("p_A", "bar"), ("p_B", "bar"), ("x", "mm")] {
        faults += &format!(
            "\"sensor.{sensor}.offset\" = {{ healthy = \"0 {unit}\", bounds = [\"-10 {unit}\", \"10 {unit}\"] }}\n"
        );
        faults += &format!("\"sensor.{sensor}.gain\" = {{ healthy = 1.0, bounds = [0.5, 1.5] }}\n");
    }
    faults += r#"
        "directional_valve.leak_AT" = { healthy = "0 L/min/bar", bounds = ["0 L/min/bar", "0.1 L/min/bar"] }
        "directional_valve.leak_PB" = { healthy = "0 L/min/bar", bounds = ["0 L/min/bar", "0.1 L/min/bar"] }
        "relief.set_pressure" = { healthy = "100 bar", bounds = ["20 bar", "120 bar"] }
        "pump.displacement" = { healthy = "5.5 cc/rev", bounds = ["3 cc/rev", "5.6 cc/rev"] }
        "fluid.viscosity" = { healthy = "45.5 mPa.s", bounds = ["20 mPa.s", "80 mPa.s"] }
        "fluid.bulk_modulus" = { healthy = "14000 bar", bounds = ["2000 bar", "16000 bar"] }
    "#;
    let rig = parse(with_faults(&telescopic(), &faults));
    let result = show(&rig);
    assert_eq!(result.faults.len(), 19);
    assert!(result.detectable.iter().all(|&detectable| detectable));
    // Offset and gain of each of the five sensors, and what only the flow at the relief valve would tell apart.
    assert_eq!(result.ambiguity_groups.len(), 6);
    assert_eq!(result.ambiguity_groups[5], ["relief.set_pressure", "pump.displacement"]);
    assert!(result.sensors.contains(&vec!["flow into relief.P".to_owned()]));
    assert_eq!(result.inseparable.len(), 10);
    let structure = from_rig(&rig).one_equation_per_fault();
    let tests = signatures(&structure, &mtes_sets(&structure, usize::MAX).sets);
    assert_eq!(isolation_by_tests(&tests, 19), isolation(&structure));
}
