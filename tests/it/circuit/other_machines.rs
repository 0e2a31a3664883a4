//! Circuits whose records another program made from textbook equations, integrated by SciPy: the model follows them, and the fault
//! in a record is found with an interval that holds it. Their rig files are in `fixtures/`, a page of the gallery each.

use borescope::Rig;
use borescope::internals::diagnosis::{DiagnosisOptions, Verdict, diagnose, estimate};
use borescope::internals::model::{Before, InputSignals, Model, Onset};

use crate::support::command::borescope;
use crate::support::cycle::Run;

use std::fs;

/// Columns of a CSV file by their headings without units.
fn columns(path: &str) -> Vec<(String, Vec<f64>)> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',').map(|name| name.split_whitespace().next().unwrap().to_owned());
    let mut columns: Vec<(String, Vec<f64>)> = names.map(|name| (name, Vec::new())).collect();
    for line in lines {
        for ((_, values), field) in columns.iter_mut().zip(line.split(',')) {
            values.push(field.parse().unwrap());
        }
    }
    columns
}

/// The largest root mean square of what model and reference differ by, as a share of the range of the column.
fn largest_difference(name: &str) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.csv");
    let (rig, reference) = (format!("fixtures/{name}/rig.toml"), format!("fixtures/{name}/reference.csv"));
    let ran = borescope(["simulate", &rig, "--input", &reference, "-o", model.to_str().unwrap()]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    let (model, reference) = (columns(model.to_str().unwrap()), columns(&reference));
    let mut worst = 0.0_f64;
    for (name, values) in &model {
        let (_, wanted) = reference.iter().find(|(other, _)| other == name).unwrap();
        assert_eq!(values.len(), wanted.len());
        let range = wanted.iter().fold(f64::MIN, |a, b| a.max(*b)) - wanted.iter().fold(f64::MAX, |a, b| a.min(*b));
        let square: f64 = values.iter().zip(wanted).map(|(a, b)| (a - b).powi(2)).sum();
        worst = worst.max((square / values.len() as f64).sqrt() / range);
    }
    worst
}

/// That a record has this fault, this one alone, and that its interval holds the truth; when it is detected, s.
fn is_found(name: &str, record: &str, fault: &str, truth: f64) -> f64 {
    is_found_on(&format!("fixtures/{name}/rig.toml"), &format!("fixtures/{name}/{record}.csv"), fault, truth)
}

/// The same with the files given.
fn is_found_on(rig: &str, record: &str, fault: &str, truth: f64) -> f64 {
    let output = borescope(["diagnose", rig, record, "--format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&output.out).unwrap();
    assert_eq!(found["verdict"], "faulty", "{record}");
    let present: Vec<_> = found["faults"].as_array().unwrap().iter().filter(|one| one["present"] == true).collect();
    assert_eq!(present.len(), 1, "{record}: {present:?}");
    assert_eq!(present[0]["id"], fault);
    let ends: Vec<f64> = present[0]["ci95"].as_array().unwrap().iter().map(|end| end.as_f64().unwrap()).collect();
    assert!(ends[0] < truth && truth < ends[1], "{record}: {ends:?} and {truth}");
    found["detected_at_s"].as_f64().unwrap_or(f64::NAN)
}

// What is asked of a peer is 1 %. Measured: 0.001 % and less; 0.02 % at the accumulator, whose empty bladder lets go at once, and 0.06 %
// at the arm, whose valves let go of its load.
const ALIKE: f64 = 1e-3;

#[test]
fn a_closed_hydrostatic_drive_is_as_scipy_has_it_and_its_relief_valve_is_found() {
    assert!(largest_difference("hydrostatic_drive") < ALIKE);
    let detected = is_found("hydrostatic_drive", "relief", "relief_A.set_pressure", 150.0);
    // The pressure first passes 150 bar at 0.73 s; before, the valve is shut whatever it is set to.
    assert!((0.7..2.0).contains(&detected), "{detected} s");
}

#[test]
fn a_servo_axis_is_as_scipy_has_it_and_its_worn_edge_is_found() {
    assert!(largest_difference("servo_axis") < ALIKE);
    is_found("servo_axis", "worn_edge", "valve.lap_PA", -3.0);
}

#[test]
fn a_boom_on_its_linkage_is_as_scipy_has_it_and_its_leak_is_found_wherever_it_begins() {
    assert!(largest_difference("boom") < ALIKE);
    is_found("boom", "leak", "piston_leak.conductance", 0.01);
}

#[test]
fn an_accumulator_with_two_consumers_is_as_scipy_has_it_and_its_lost_gas_is_found() {
    assert!(largest_difference("accumulator") < ALIKE);
    is_found("accumulator", "precharge", "accumulator.precharge", 60.0);
}

/// Its machine is off the data sheets, so its faults are found on the calibrated rig, in the gallery.
#[test]
fn an_arm_with_load_sensing_is_as_scipy_has_it() {
    assert!(largest_difference("excavator") < ALIKE);
}

/// Its valve begins 0.1 bar elsewhere, which its flow meter shows in the first row; all else is within 0.01 %.
#[test]
fn a_whole_robot_is_as_scipy_has_it() {
    assert!(largest_difference("robot") < 3.0 * ALIKE);
}

/// A controller moves its command from row to row. Were each step a switching, every row would be a phase of its own, in which the
/// model may differ by anything.
#[test]
fn the_steps_of_a_controller_are_no_switchings() {
    let path = "fixtures/servo_axis/rig.toml";
    let text = fs::read_to_string(path).unwrap().replacen("hold = \"linear\"", "hold = \"after\"", 1);
    let rig = Rig::parse(path, text).unwrap();
    let record = rig.record("fixtures/servo_axis/healthy_1.csv").unwrap();
    let drive = InputSignals::from_record(&rig, &record).unwrap();
    let steps = drive.pieces.windows(2).filter(|pair| pair[0].to[0] != pair[1].from[0]).count();
    let jumps = drive.pieces.iter().filter(|piece| piece.jump).count();
    assert!(steps > record.time.len() / 2 && jumps < 30, "{steps} steps, {jumps} of them jumps");
}

/// A dead time of an input is that of all that it drives: of the one valve behind it, here.
#[test]
fn a_dead_time_of_an_input_is_that_of_the_valve_behind_it() {
    let path = "fixtures/telescopic/rig.toml";
    let text = fs::read_to_string(path).unwrap();
    let outputs = |table: &str| {
        let text = text.replacen(table, &format!("{table}\ndead_time = \"9 ms\""), 1);
        let rig = Rig::parse(path, text).unwrap();
        let record = rig.record("fixtures/telescopic/healthy_1.csv").unwrap();
        let drive = InputSignals::from_record(&rig, &record).unwrap();
        let model = Model::new(rig);
        model.solve(&model.rig.nominal(), &drive, &record.time).unwrap().values
    };
    let [stated, of_input, of_valve] =
        ["[fluid]_", "[inputs.valve_command]", "[components.directional_valve]"].map(outputs);
    let apart = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        let position = |values: &[Vec<f64>]| values[values.len() - 1].clone();
        position(a).iter().zip(position(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    // The piston moves at 0.1 m/s and more.
    assert!(apart(&of_input, &of_valve) < 1e-8, "{}", apart(&of_input, &of_valve));
    assert!(apart(&of_input, &stated) > 5e-4, "{}", apart(&of_input, &stated));
}

/// A valve of the catalogue has no dead time of its own; its spool would be made slower by what the file leaves out of the input's.
#[test]
fn an_uncertain_dead_time_of_an_input_is_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let whole = fs::read_to_string("fixtures/servo_loop/rig.toml").unwrap();
    let input = r#"u = { unit = "-", hold = "linear""#;
    assert!(whole.contains(input));
    let frequency = |dead_time: &str| {
        let rig = path("rig.toml");
        fs::write(&rig, whole.replacen(input, &format!("{input}, dead_time = \"{dead_time}\""), 1)).unwrap();
        let records = [1, 2].map(|one| {
            let (as_recorded, record) = (format!("fixtures/servo_loop/healthy_{one}.csv"), path(&format!("{one}.csv")));
            let seed = one.to_string();
            let set = "input.u.dead_time=7.5ms";
            let simulate =
                ["simulate", &rig, "--input", &as_recorded, "--set", set, "--seed", &seed, "-o", &record, "--force"];
            assert_eq!(borescope(simulate).status, Some(0));
            record
        });
        let calibrate =
            ["calibrate", &rig, &records[0], &records[1], "-o", &path("new.toml"), "--force", "--format", "json"];
        let ran = borescope(calibrate);
        let found: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
        let all = found["parameters"].as_array().unwrap();
        let of = |id: &str| all.iter().find(|one| one["id"] == id).and_then(|one| one["after"].as_f64());
        let dead_time = of("input.u.dead_time");
        let written = Rig::read(path("new.toml")).unwrap();
        let written = &written.parameters[written.parameter("input.u.dead_time").unwrap()];
        assert!((1e3 * written.value - dead_time.unwrap_or(4.0)).abs() < 1e-3, "{} s", written.value);
        (of("valve.natural_frequency").unwrap(), dead_time)
    };
    let (exact, none) = frequency("4 ms");
    let (open, found) = frequency("4 ms +- 3 ms");
    println!("{exact} Hz with 4 ms, {open} Hz with {found:?} ms");
    // 55 Hz and 7.5 ms are true; only the overshoot tells a delay from a slow spool.
    assert!(none.is_none() && (found.unwrap() - 7.5).abs() < 2.0 && (open - 55.0).abs() < 0.7 * (exact - 55.0).abs());
}

/// Where commands switch, the mean of a dead time is asked for when the rounds have ended.
#[test]
fn an_uncertain_dead_time_of_commands_that_switch_is_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let whole = fs::read_to_string("fixtures/own_filter/rig.toml").unwrap();
    let input = "[inputs.u]\nunit = \"V\"";
    assert_eq!(whole.matches(input).count(), 1);
    let rig = path("rig.toml");
    fs::write(&rig, whole.replacen(input, &format!("{input}\ndead_time = \"10 ms +- 10 ms\""), 1)).unwrap();
    let record = path("record.csv");
    let simulate = ["simulate", &rig, "--set", "input.u.dead_time=28ms", "--seed", "1", "-o", &record];
    assert_eq!(borescope(simulate).status, Some(0));
    let ran = borescope(["calibrate", &rig, &record, "-o", &path("new.toml"), "--format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let dynamics = found["dynamics"].as_array().unwrap();
    let dead_time = dynamics.iter().find(|one| one["id"] == "input.u.dead_time").unwrap()["after"].as_f64().unwrap();
    println!("{dead_time} ms");
    assert!((dead_time - 28.0).abs() < 3.0, "{dead_time} ms");
}

/// As a value that is fitted a dead time does what the file does that states it, and its derivative is how the readings differ.
#[test]
fn a_dead_time_that_is_fitted_acts_as_a_stated_one() {
    let path = "fixtures/hydrostatic_drive/rig.toml";
    let text = fs::read_to_string(path).unwrap();
    let line = r#"swash = { unit = "-", hold = "linear""#;
    let rig = |dead_time: &str| {
        Rig::parse(path, text.replacen(line, &format!("{line}, dead_time = \"{dead_time}\""), 1)).unwrap()
    };
    let open = rig("25 ms +- 8 ms");
    let record = open.record("fixtures/hydrostatic_drive/healthy_1.csv").unwrap();
    let own = open.parameter("input.swash.dead_time").unwrap();
    let model = Model::new(open);
    let drive = InputSignals::from_record(&model.rig, &record).unwrap();
    // Parameters change at the moment of an onset, whatever the inputs do: here where a ramp ends as it acts 25 ms late.
    let leak = model.rig.parameter("motor.case_leakage").unwrap();
    let moment = drive.pieces.iter().map(|piece| piece.start).find(|&start| start > 2.0).unwrap();
    let onset = Onset { time: moment, before: vec![(leak, Before::Value(0.0))] };
    let solve_with = |drive: &InputSignals, dead_time: f64| {
        let mut values = model.rig.nominal();
        values[own] = dead_time;
        model.solve(&values, drive, &record.time).unwrap().values
    };
    let (solve, begun) = (|dead_time: f64| solve_with(&drive, dead_time), drive.clone().with_onset(onset.clone()));
    let apart = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        let of = |(sensor, (a, b)): (usize, (&Vec<f64>, &Vec<f64>))| {
            let most = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            most / model.rig.sensors[sensor].noise
        };
        a.iter().zip(b).enumerate().map(of).fold(0.0, f64::max)
    };
    for (seconds, stated) in [(0.033, "33 ms"), (0.004, "4 ms"), (0.025, "25 ms")] {
        let rig = rig(stated);
        let other = InputSignals::from_record(&rig, &record).unwrap();
        let values = rig.nominal();
        let other_begun = other.clone().with_onset(onset.clone());
        let stated_model = Model::new(rig);
        let wanted = |drive: &InputSignals| stated_model.solve(&values, drive, &record.time).unwrap().values;
        for (found, wanted) in [(solve(seconds), wanted(&other)), (solve_with(&begun, seconds), wanted(&other_begun))] {
            println!("{stated}: {} of the noise", apart(&found, &wanted));
            assert!(apart(&found, &wanted) < 0.05, "{stated}: {}", apart(&found, &wanted));
        }
    }
    assert!(apart(&solve(0.033), &solve(0.025)) > 20.0);
    let found = model.sensitivities(&model.rig.nominal(), &[own, leak], &drive, &record.time).unwrap();
    let alone = model.sensitivities(&model.rig.nominal(), &[leak], &drive, &record.time).unwrap();
    assert_eq!(found.derivatives[1], alone.derivatives[0]);
    // A millisecond to both sides, where the derivative takes two.
    let (later, sooner) = (solve(0.026), solve(0.024));
    let unseen = |sensor: usize| record.time.len() as f64 * (0.1 * model.rig.sensors[sensor].noise / 8e-3).powi(2);
    let squares = |of: &dyn Fn(usize) -> f64| (0..record.time.len()).map(|row| of(row).powi(2)).sum::<f64>();
    for sensor in 0..model.rig.sensors.len() {
        let slope = |row: usize| (later[sensor][row] - sooner[sensor][row]) / 2e-3;
        let wrong = squares(&|row| found.derivatives[0][sensor][row] - slope(row));
        assert!(wrong <= 0.01 * squares(&slope) + unseen(sensor), "{}", model.rig.sensors[sensor].name);
    }
}

/// Pump and motor leak across in parallel, and only the motor's leak is declared: that the pump may be what leaks is said, and only of it.
#[test]
fn what_is_not_declared_and_does_the_same_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (rig, record) = (path("rig.toml"), path("record.csv"));
    let whole = fs::read_to_string("fixtures/hydrostatic_drive/rig.toml").unwrap();
    let exact = r#"internal_leakage = "0.012 L/min/bar""#;
    assert_eq!(whole.matches(exact).count(), 1);
    fs::write(&rig, whole.replacen(exact, r#"internal_leakage = "0.012 L/min/bar +- 30 %""#, 1)).unwrap();
    let alike = |set: &str| {
        let input = "fixtures/hydrostatic_drive/healthy_1.csv";
        let simulate = ["simulate", &rig, "--input", input, "--set", set, "--seed", "2", "-o", &record, "--force"];
        assert_eq!(borescope(simulate).status, Some(0));
        let found = borescope(["diagnose", &rig, &record, "--format", "json"]);
        let found: serde_json::Value = serde_json::from_str(&found.out).unwrap();
        assert_eq!(found["verdict"], "faulty");
        found["alike"].clone()
    };
    let twins = alike("motor.internal_leakage=0.04L/min/bar");
    assert_eq!(twins, serde_json::json!([["motor.internal_leakage", "pump.internal_leakage"]]));
    let said =
        "pump.internal_leakage is no declared fault, and does the same to this record as motor.internal_leakage.";
    let page = path("page.html");
    let told = borescope(["diagnose", &rig, &record, "--report", &page]).out;
    assert!(told.split_whitespace().collect::<Vec<_>>().join(" ").contains(said), "{told}");
    assert!(fs::read_to_string(page).unwrap().contains(said));
    assert_eq!(alike("motor.case_leakage=0.02L/min/bar"), serde_json::json!([]));
    let told = borescope(["diagnose", &rig, &record]).out;
    assert!(!told.contains("no declared fault"), "{told}");
}

/// A poppet whose spring is set otherwise passes with the root of the pressure, a pilot-operated valve by parallel lines: a weak spring of
/// either is a weak spring, and no other part beside it.
#[test]
fn a_weak_spring_is_found_whichever_way_the_valve_is_built() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("record.csv").to_str().unwrap().to_owned();
    let (rig, input) = ("fixtures/hydrostatic_drive/rig.toml", "fixtures/hydrostatic_drive/healthy_1.csv");
    for exponent in ["0", "0.5"] {
        let exponent = format!("charge_relief.setting_exponent={exponent}");
        let set = ["--set", "charge_relief.set_pressure=12bar", "--set", &exponent];
        let simulate = ["simulate", rig, "--input", input, "--seed", "1", "-o", &record, "--force"];
        assert_eq!(borescope(simulate.into_iter().chain(set)).status, Some(0));
        is_found_on(rig, &record, "charge_relief.set_pressure", 12.0);
    }
}

mod studies {
    use super::*;

    /// Twelve cylinders on one pump station: most of what may differ does nothing in most phases, and the record of the new machine is
    /// explained by it.
    #[test]
    #[ignore = "half a minute"]
    fn a_transfer_line_of_twelve_cylinders_is_followed() {
        let model = Model::new(Rig::read("fixtures/transfer_line/rig.toml").unwrap());
        let record = Run::of(&model).record("new");
        let drive = InputSignals::from_record(&model.rig, &record).unwrap();
        let found = estimate::near(&model, &record, &drive, None, 1).unwrap();
        assert!(found.explains() && found.isolation.set().is_empty());
    }

    /// A relief valve 10 bar down and a leak that is small beside its bound: a twenty-fifth of it. Neither the healthy machine nor shares of
    /// the way to bounds lead there, and clearance at its bound left little enough over all sensors to end the search.
    #[test]
    #[ignore = "twenty seconds"]
    fn a_leak_that_is_small_beside_its_bound_is_found_beside_another_fault() {
        let rig = Rig::read("fixtures/regeneration/rig.toml").unwrap();
        let record = rig.record("fixtures/regeneration/relief_and_leak.csv").unwrap();
        let found = diagnose(&Model::new(rig), &record, &DiagnosisOptions::default()).unwrap().diagnosis;
        let present: Vec<_> = found.faults.iter().filter(|fault| fault.present).collect();
        let ids: Vec<&str> = present.iter().map(|fault| fault.id.as_str()).collect();
        assert_eq!((found.verdict, ids), (Verdict::Faulty, vec!["relief.set_pressure", "switch.leakage"]));
        let lower = present[0].value - present[0].healthy;
        assert!((lower + 10.0).abs() < 0.6, "{lower} bar");
        assert!((present[1].value - 0.02).abs() < 0.0005, "{} L/min/bar", present[1].value);
    }

    /// A position loop holds its valve where the edges begin to open. With sharp edges the calibration left 7 times the noise of the position,
    /// and had a viscous friction of 1610 N s/m.
    #[test]
    #[ignore = "ten seconds"]
    fn the_edges_of_a_valve_in_a_position_loop_are_calibrated_and_its_dry_friction_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let calibrated = folder.path().join("calibrated.toml");
        let calibrated = calibrated.to_str().unwrap();
        let [rig, first, second, friction] = ["rig.toml", "healthy_1.csv", "healthy_2.csv", "friction.csv"]
            .map(|name| format!("fixtures/servo_loop/{name}"));
        let ran = borescope(["calibrate", &rig, &first, &second, "-o", calibrated, "--format", "json"]);
        let found: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
        for (id, truth) in [("valve.rounding", 0.3), ("valve.rated_flow", 58.8), ("cylinder.viscous_friction", 2500.0)]
        {
            let one = found["parameters"].as_array().unwrap().iter().find(|one| one["id"] == id).unwrap();
            let (value, error) = (one["after"].as_f64().unwrap(), one["sigma_after"].as_f64().unwrap());
            assert!((value - truth).abs() < 3.0 * error && error < 0.1 * truth, "{id}: {value} +- {error}");
        }
        is_found_on(calibrated, &friction, "friction.force", 1500.0);
    }

    /// A leak in one of twelve cylinders, in the record of one part: a third of the cycle.
    #[test]
    #[ignore = "a minute"]
    fn a_leak_in_a_transfer_line_is_found() {
        let rig = "fixtures/transfer_line/rig.toml";
        let model = Model::new(Rig::read(rig).unwrap());
        let mut cycle = model.rig.cycle.clone().unwrap();
        cycle.phases.truncate(cycle.phases.len() / 3);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("leak.csv");
        let run = Run::of(&model).through(cycle).with_quantities(&[("slide_2_cylinder.clearance", "0.08 mm")]);
        run.record("leak").write(&path).unwrap();
        is_found_on(rig, path.to_str().unwrap(), "slide_2_cylinder.clearance", 0.08);
    }
}
