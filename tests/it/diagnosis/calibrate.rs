//! `calibrate`: what healthy records teach about a rig, as text, as numbers and as a program.

use crate::support::command;
use crate::support::cycle::Run;
use crate::support::telescopic;

use std::fs;
use std::path::Path;

use approx::assert_relative_eq;
use borescope::Record;
use borescope::internals::calibration::{Calibrated, CalibrationOptions, CalibrationReport, calibrate, calibrate_rig};
use borescope::internals::diagnosis::{self, Verdict};
use borescope::internals::model::{InputSignals, Model};
use borescope::internals::rig::{NEVER_KNOWN, Quantity, Rig};
use command::{Ran, borescope};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const TELESCOPIC: &str = telescopic::RIG;

/// A motor beside a reducing valve, on a pump that runs against its relief valve where both are shut.
const TWO_LAGS: &str = r#"[fluid]
density = "870 kg/m3"
viscosity = "40 mPa.s +- 10 %"
bulk_modulus = "14000 bar +- 15 %"

[nodes]
tank = {}
P = { initial = "185 bar" }
M = { initial = "0 bar" }
red = { initial = "100 bar" }

[components.tank]
kind = "tank"
ports = { T = "tank" }

[components.pump]
kind = "pump"
ports = { P = "P", T = "tank" }
displacement = "28 cc/rev +- 2 %"
speed = "1488 rev/min"

[components.line_P]
kind = "line-volume"
ports = { P = "P" }
volume = "1.2 L"

[components.relief]
kind = "relief-valve"
ports = { P = "P", T = "tank" }
set_pressure = "180 bar +- 3 bar"
rated_flow = "60 L/min"
rated_overpressure = "12 bar +- 15 %"
lag = "8 ms"

[components.feed]
kind = "directional-valve"
ports = { P = "P", T = "tank", A = "M", B = "tank" }
command = "u"
rated_flow = "40 L/min"
rated_drop = "5 bar +- 10 %"
lag = "12 ms +- 2 ms"
dead_band = "0.1 +- 0.02"

[components.line_M]
kind = "line-volume"
ports = { P = "M" }
volume = "400 cm3"

[components.motor]
kind = "catalogue:motor"
ports = { A = "M", B = "tank", drain = "tank" }
torque = "T"
displacement = "50 cc/rev +- 2 %"
inertia = "0.12 kg.m2 +- 10 %"

[components.reducer]
kind = "catalogue:pressure-reducing-valve"
ports = { in = "P", out = "red" }
set_pressure = "100 bar +- 4 bar"
closing_range = "8 bar +- 15 %"
rated_flow = "30 L/min"
rated_drop = "10 bar +- 12 %"
lag = "10 ms +- 25 %"

[components.line_red]
kind = "line-volume"
ports = { P = "red" }
volume = "120 cm3"

[components.pilot]
kind = "on-off-valve"
ports = { in = "red", out = "tank" }
command = "a"
rated_flow = "4 L/min"
rated_drop = "50 bar"
lag = "12 ms"

[inputs]
u = { unit = "-" }
a = { unit = "-" }
T = { unit = "N.m", hold = "linear" }

[sensors]
p_P = { quantity = "pressure", at = "P", noise = "0.4 bar", resolution = "0.1 bar", offset = "0 bar +- 0.3 bar", gain = "1 +- 0.15 %" }
p_M = { quantity = "pressure", at = "M", noise = "0.3 bar", resolution = "0.1 bar", offset = "0 bar +- 0.3 bar", gain = "1 +- 0.15 %" }
p_red = { quantity = "pressure", at = "red", noise = "0.3 bar", resolution = "0.1 bar", offset = "0 bar +- 0.3 bar", gain = "1 +- 0.15 %" }
n = { quantity = "state", at = "motor.speed", noise = "0.8 rev/min", resolution = "0.1 rev/min", offset = "0 rev/min +- 0.2 rev/min", gain = "1 +- 0.15 %" }

[faults]
"relief.set_pressure" = { bounds = ["100 bar", "210 bar"] }

[cycle]
interval = "10 ms"
phases = [
  { duration = "1 s", u = "0", a = "0", T = "20 N.m" },
  { duration = "1.5 s", u = "0.6", a = "0", T = "20 N.m" },
  { duration = "1 s", u = "0.6", a = "1", T = "30 N.m" },
  { duration = "1 s", u = "0", a = "0", T = "20 N.m" },
  { duration = "1 s", u = "1", a = "0", T = "25 N.m" },
  { duration = "1 s", u = "0.3", a = "1", T = "25 N.m" },
  { duration = "1.5 s", u = "0", a = "1", T = "20 N.m" },
]
"#;

/// A volume that drains through an orifice. The calibration in its middle is none that any record has made.
const SMALL: &str = r#"# Kept: the head.
[fluid]
density = "870 kg/m3"

[nodes]
tank = {}
line = { initial = "20 bar" }   # kept: beside a node

[components.tank]
kind = "tank"
ports = { T = "tank" }

[calibration]   # replaced
records = ["old.csv"]
correlation = [[1.0], [0.5, 1.0]]
[calibration.values]
"pump.gain" = "1.3 L/min/V +- 0.001 L/min/V"
"outlet.discharge_coefficient" = "0.9 +- 0.001"
[calibration.sensors.p]
noise = "7 bar"

# Kept: before the line.
[components.line]
kind = "line-volume"
ports = { P = "line" }
volume = "1 L"

[components.pump]
kind = "flow-source"
ports = { P = "line", T = "tank" }
gain = "1 L/min/V"
voltage = "u"

[components.outlet]
kind = "orifice"
ports = { in = "line", out = "tank" }
diameter = "1 mm"

[inputs.u]
unit = "V"

[sensors]
p = { quantity = "pressure", at = "line", noise = "0.1 bar", resolution = "0.05 bar" }
q = { quantity = "flow", at = "outlet.in", noise = "0.02 L/min", gain = "1 +- 0", offset = "0 L/min +- 0 L/min" }

[faults]
"outlet.diameter" = { healthy = "1 mm", bounds = ["0.2 mm", "1.5 mm"] }
"pump.gain" = { healthy = "1 L/min/V", bounds = ["0.5 L/min/V", "1.5 L/min/V"] }

[cycle]
interval = "10 ms"
phases = [ { duration = "2 s", u = "2 V" }, { duration = "2 s", u = "1 V" }, { duration = "2 s", u = "2.5 V" } ]
"#;

/// What the sensors of a rig read over a cycle with other loads: every input beyond 100 (a load, not a command) times `load`.
fn healthy_record(rig: &Rig, name: &str, load: f64, seed: u64) -> Record {
    let mut cycle = rig.cycle.clone().unwrap();
    for profile in cycle.phases.iter_mut().flat_map(|phase| &mut phase.inputs) {
        if profile.from.abs() > 100.0 {
            (profile.from, profile.to) = (load * profile.from, load * profile.to);
        }
    }
    Run::of(&Model::new(rig.clone())).through(cycle).seed(seed).record(name)
}

/// A scaled sensor is described in what it writes, here too: 1 cm of level is 1 V.
#[test]
fn the_noise_of_a_scaled_sensor_is_in_its_own_unit() {
    let path = "fixtures/cascaded_tanks/rig.toml";
    let more = "\n[calibration.sensors.level_2]\nnoise = \"0.3 V\"\ntolerance = \"0.1 V\"\n";
    let rig = Rig::parse(path, std::fs::read_to_string(path).unwrap() + more).unwrap();
    assert_relative_eq!(rig.sensors[0].noise, 3e-3, max_relative = 1e-12);
    assert_relative_eq!(rig.sensors[0].tolerance, 1e-3, max_relative = 1e-12);
}

/// And so is its zero.
#[test]
fn the_zero_of_a_scaled_sensor_is_in_its_own_unit() {
    let path = "fixtures/cascaded_tanks/rig.toml";
    // Or in what it means, as a rig file may state it.
    for stated in ["0.2 V +- 0.05 V", "2 mm +- 0.5 mm"] {
        let more = format!("\n[calibration.values]\n\"sensor.level_2.offset\" = \"{stated}\"\n");
        let rig = Rig::parse(path, std::fs::read_to_string(path).unwrap() + &more).unwrap();
        let offset = &rig.parameters[rig.parameter("sensor.level_2.offset").unwrap()];
        assert_relative_eq!(offset.value, 2e-3, max_relative = 1e-12);
        assert_relative_eq!(offset.sigma, 5e-4, max_relative = 1e-12);
    }
}

/// A rig file that describes sensors in what they write, and states faults of their zeros in what they mean, reads what `calibrate` adds.
#[test]
fn what_is_calibrated_of_a_scaled_sensor_is_read_as_it_was_written() {
    let (_, record) = small();
    for (scale, noise) in [("4 bar/V", "0.025 V"), ("2 bar/bar", "0.05 bar")] {
        let sensor =
            format!("at = \"line\", scale = \"{scale}\", offset = \"0 bar +- 0.3 bar\", noise = \"{noise}\" }}");
        let text = SMALL
            .replace("at = \"line\", noise = \"0.1 bar\", resolution = \"0.05 bar\" }", &sensor)
            .replace("[calibration.sensors.p]\nnoise = \"7 bar\"\n", "")
            .replace(
                "[faults]\n",
                "[faults]\n\"sensor.p.offset\" = { healthy = \"0 bar\", bounds = [\"-2 bar\", \"2 bar\"] }\n",
            );
        let rig = Rig::parse("small.toml", text.clone()).unwrap();
        let found = calibrate(&text, &rig, std::slice::from_ref(&record), &CalibrationOptions::default()).unwrap();
        let again = Rig::parse("small.toml", found.text.clone()).unwrap();
        let index = rig.parameter("sensor.p.offset").unwrap();
        for (written, read) in [
            (found.rig.sensors[0].noise, again.sensors[0].noise),
            (found.rig.sensors[0].tolerance, again.sensors[0].tolerance),
            (found.rig.parameters[index].value, again.parameters[index].value),
            (found.rig.parameters[index].sigma, again.parameters[index].sigma),
        ] {
            assert_relative_eq!(written, read, max_relative = 1e-5);
        }
        // The true ones.
        assert_relative_eq!(again.sensors[0].noise, 1e4, max_relative = 0.15);
        assert!((again.parameters[index].value - 8e3).abs() < 3.5 * again.parameters[index].sigma, "{}", found.text);
    }
}

/// The zero of a scaled sensor may stand in what its column shows.
#[test]
fn the_zero_of_a_scaled_sensor_may_be_stated_in_its_own_unit() {
    let path = "fixtures/cascaded_tanks/rig.toml";
    let text = std::fs::read_to_string(path).unwrap();
    let with = |offset: &str| {
        let text = text.replace("offset = \"0 cm +- 0 cm\"", &format!("offset = \"{offset}\""));
        let rig = Rig::parse(path, text).unwrap();
        let offset = &rig.parameters[rig.parameter("sensor.level_2.offset").unwrap()];
        (offset.value, offset.sigma)
    };
    for stated in ["0.2 V +- 0.05 V", "2 mm +- 0.5 mm"] {
        let (value, sigma) = with(stated);
        assert_relative_eq!(value, 2e-3, max_relative = 1e-12);
        assert_relative_eq!(sigma, 5e-4, max_relative = 1e-12);
    }
}

/// The rig with every parameter that calibration may move somewhere else, as its spread says.
fn another_part(sheet: &Rig, seed: u64) -> Rig {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut rig = sheet.clone();
    for parameter in rig.parameters.iter_mut().filter(|parameter| !parameter.per_event && parameter.spread > 0.0) {
        let standard: f64 = StandardNormal.sample(&mut random);
        parameter.value = (parameter.value + parameter.spread * standard).max(parameter.bounds.0);
    }
    rig
}

/// Errors of the calibrated values, in their standard errors; the second of a pair says whether the records were informative.
fn errors(found: &Rig, truth: &Rig, report: &CalibrationReport) -> Vec<(String, f64, bool)> {
    let one = |told: &borescope::internals::calibration::CalibratedParameter| {
        let found = &found.parameters[found.parameter(&told.id).unwrap()];
        // The rig that wrote the records has no margins: nothing is what they are.
        let truth = truth.parameter(&told.id).map_or(0.0, |index| truth.parameters[index].value);
        (told.id.clone(), (found.value - truth) / found.sigma, told.informed)
    };
    report.parameters.iter().map(one).collect()
}

fn small() -> (Rig, Record) {
    let mut truth = Rig::parse("small.toml", SMALL.to_owned()).unwrap();
    truth.calibration = None;
    for (id, value) in [("pump.gain", 1.04 / 6e4), ("outlet.discharge_coefficient", 0.66), ("sensor.p.offset", 8e3)] {
        let index = truth.parameter(id).unwrap();
        truth.parameters[index].value = value;
    }
    for sensor in &mut truth.sensors {
        sensor.noise = if sensor.quantity == Quantity::Pressure { 1e4 } else { 0.02 / 6e4 };
    }
    let record = healthy_record(&truth, "healthy.csv", 1.0, 5);
    (truth, record)
}

/// Two records of one rig begin at other pressures: what one began with says nothing of the next.
#[test]
fn each_record_has_its_own_start_and_the_next_may_have_another() {
    let text = SMALL.replace("initial = \"20 bar\"", "initial = \"20 bar +- 5 bar\"");
    let sheet = Rig::parse("small.toml", text.clone()).unwrap();
    let (truth, _) = small();
    let records = [18e5, 24e5].map(|start| {
        let mut rig = sheet.clone();
        rig.calibration = None;
        for (own, made) in rig.sensors.iter_mut().zip(&truth.sensors) {
            own.noise = made.noise;
        }
        for parameter in &truth.parameters {
            let index = rig.parameter(&parameter.id).unwrap();
            rig.parameters[index].value = parameter.value;
        }
        let index = rig.parameter("node.line.initial").unwrap();
        rig.parameters[index].value = start;
        healthy_record(&rig, &format!("from_{start}.csv"), 1.0, 7)
    });
    let Calibrated { rig, text, report } = calibrate(&text, &sheet, &records, &CalibrationOptions::default()).unwrap();
    assert!(report.adequate, "{:?}", report.warnings);
    let start = &rig.parameters[rig.parameter("node.line.initial").unwrap()];
    assert_relative_eq!(start.sigma, 5e5, max_relative = 1e-9);
    assert_relative_eq!(start.value, 21e5, max_relative = 5e-3);
    assert!(text.contains("mean of the records"), "{text}");
    let gain = &rig.parameters[rig.parameter("pump.gain").unwrap()];
    assert!((gain.value - 1.04 / 6e4).abs() < 3.0 * gain.sigma, "{} +- {}", gain.value, gain.sigma);
}

fn calibrated_small() -> (Calibrated, Rig, Record) {
    let (truth, record) = small();
    let rig = Rig::parse("small.toml", SMALL.to_owned()).unwrap();
    let calibrated = calibrate(SMALL, &rig, std::slice::from_ref(&record), &CalibrationOptions::default()).unwrap();
    (calibrated, truth, record)
}

#[test]
fn the_text_stays_but_for_the_calibration() {
    let (calibrated, _, record) = calibrated_small();
    let (kept, new) = calibrated.text.split_once("\n# Calibrated on healthy records").unwrap();
    let start = SMALL.find("[calibration]").unwrap();
    let end = SMALL.find("# Kept: before the line.").unwrap();
    let without = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(without(kept), without(&format!("{}{}", &SMALL[..start], &SMALL[end..])));
    for comment in ["# Kept: the head.", "# kept: beside a node", "# Kept: before the line."] {
        assert!(kept.contains(comment), "{comment}");
    }
    assert!(!calibrated.text.contains("old.csv") && new.contains("records = [\"healthy.csv\"]"), "{new}");
    // Calibrated once more, it is what it was: its own calibration is not used.
    let again = calibrate(&calibrated.text, &calibrated.rig, &[record], &CalibrationOptions::default()).unwrap();
    assert_eq!(again.text, calibrated.text);
    assert_eq!(again.report, calibrated.report);
}

#[test]
fn the_rig_is_what_reading_its_text_gives() {
    let (calibrated, truth, _) = calibrated_small();
    let rig = Rig::parse("small.toml", calibrated.text.clone()).unwrap();
    assert_eq!(rig.calibration, calibrated.rig.calibration);
    assert_eq!(rig.nominal(), calibrated.rig.nominal());
    let index = rig.parameter("pump.gain").unwrap();
    let fault = rig.faults.iter().find(|fault| fault.parameter == index).unwrap();
    assert_eq!(fault.healthy, rig.parameters[index].value);
    // What is exact, and a fault without spread, is left alone.
    let ids: Vec<&str> = calibrated.report.parameters.iter().map(|parameter| parameter.id.as_str()).collect();
    for left in ["sensor.q.gain", "sensor.q.offset", "outlet.diameter", "fluid.density"] {
        assert!(!ids.contains(&left), "{left} in {ids:?}");
    }
    for (id, error, _) in errors(&rig, &truth, &calibrated.report) {
        assert!(error.abs() < 3.5, "{id}: {error:.2} standard errors off");
    }
    let gain = calibrated.report.parameters.iter().find(|told| told.id == "pump.gain").unwrap();
    assert!(gain.informed && gain.fault && (gain.after - 1.04).abs() < 0.005, "{gain:?}");
    // The flow meter is exact, so pump and outlet are known as well as it.
    let covariance = rig.covariance(&rig.calibration.as_ref().unwrap().parameters);
    assert!(covariance.cholesky().is_some());
}

#[test]
fn in_memory_and_from_text_agree() {
    let (calibrated, _, record) = calibrated_small();
    let sheet = calibrated.text.split_once("\n# Calibrated on healthy records").unwrap().0;
    let sheet = Rig::parse("small.toml", sheet.to_owned()).unwrap();
    let (rig, report) = calibrate_rig(&sheet, &[record], &CalibrationOptions::default()).unwrap();
    assert_eq!(report, calibrated.report);
    for (memory, text) in rig.parameters.iter().zip(&calibrated.rig.parameters) {
        assert!((memory.value - text.value).abs() <= 1e-4 * text.sigma, "{}", memory.id);
        assert!((memory.sigma - text.sigma).abs() <= 1e-4 * text.sigma, "{}", memory.id);
    }
}

/// Errors over several parts of the telescopic circuit, each calibrated on two records of its own.
fn study(seeds: std::ops::Range<u64>) -> Vec<(String, f64, bool)> {
    let sheet = Rig::read(TELESCOPIC).unwrap();
    let mut all = Vec::new();
    for seed in seeds {
        let truth = another_part(&sheet, seed);
        let records =
            [1.0, 0.5].map(|load| healthy_record(&truth, "part.csv", load, 100 * seed + (10.0 * load) as u64));
        let (rig, report) = calibrate_rig(&sheet, &records, &CalibrationOptions::default()).unwrap();
        assert!(report.adequate && report.settled, "{:?}", report.warnings);
        for sensor in &report.sensors {
            let share = sensor.noise / sensor.noise_before;
            assert!((0.95..1.05).contains(&share), "noise of {}: {share}", sensor.name);
            // The model is right here, so that the tolerance shrinks.
            assert!(sensor.tolerance < sensor.tolerance_before, "tolerance of {}", sensor.name);
        }
        all.extend(errors(&rig, &truth, &report));
    }
    all
}

fn mean_square(errors: impl Iterator<Item = f64> + Clone) -> f64 {
    errors.clone().map(|error| error * error).sum::<f64>() / errors.count() as f64
}

#[test]
fn parts_off_their_data_sheet_are_found_within_their_errors() {
    let all = study(0..2);
    let informed = all.iter().filter(|(_, _, informed)| *informed).count();
    assert!(informed >= 50, "{informed} of {}", all.len());
    for (id, error, _) in &all {
        assert!(error.abs() < 3.5, "{id}: {error:.2} standard errors off");
    }
    // 68 errors, some correlated. Here the model is right, and what is left open for physics that it lacks makes claims wide;
    // `calibration_honest` asks the same of rigs that are otherwise.
    let square = mean_square(all.iter().map(|(_, error, _)| *error));
    assert!((0.15..1.8).contains(&square), "{square}");
}

#[test]
fn noise_and_tolerance_are_found_where_they_are_others() {
    let sheet = Rig::read(TELESCOPIC).unwrap();
    let mut truth = another_part(&sheet, 3);
    let place = |name: &str| sheet.sensors.iter().position(|sensor| sensor.name == name).unwrap();
    let (p_a, q_b) = (place("p_A"), place("q_B"));
    truth.sensors[p_a].noise *= 2.0;
    truth.sensors[q_b].noise *= 0.5;
    // In each phase of the cycle p_P is off by another constant.
    let mut random = ChaCha8Rng::seed_from_u64(77);
    let off = 6e4;
    let records = [1.0, 0.7, 0.4].map(|load| {
        let mut record = healthy_record(&truth, "part.csv", load, (100.0 * load) as u64);
        let cycle = truth.cycle.clone().unwrap();
        let mut until = Vec::new();
        let mut end = 0.0;
        for phase in &cycle.phases {
            end += phase.duration;
            let standard: f64 = StandardNormal.sample(&mut random);
            until.push((end, off * standard));
        }
        let channel = record.channels.iter_mut().find(|channel| channel.name == "p_P").unwrap();
        for (value, time) in channel.values.iter_mut().zip(&record.time) {
            *value += until.iter().find(|(end, _)| time <= end).map_or(0.0, |(_, off)| *off);
        }
        record
    });
    let (rig, report) = calibrate_rig(&sheet, &records, &CalibrationOptions::default()).unwrap();
    for (sensor, truth) in rig.sensors.iter().zip(&truth.sensors) {
        let share = sensor.noise / truth.noise;
        assert!((0.93..1.07).contains(&share), "noise of {}: {share} of the true one", sensor.name);
    }
    let (p_p, other) = (&rig.sensors[place("p_P")], &rig.sensors[place("p_B")]);
    // 15 constants tell a standard deviation to a fifth.
    assert!((0.4 * off..2.0 * off).contains(&p_p.tolerance), "{} Pa for {off} Pa", p_p.tolerance);
    assert!(other.tolerance < 0.1 * p_p.tolerance, "{} Pa", other.tolerance);
    assert!(report.adequate, "{:?}", report.warnings);
    assert!(report.warnings.iter().any(|warning| warning.contains("`p_P`")), "{:?}", report.warnings);
}

#[test]
fn a_calibrated_rig_finds_another_healthy_record_healthy() {
    let text = fs::read_to_string(TELESCOPIC).unwrap();
    let rig = Rig::parse(TELESCOPIC, text.clone()).unwrap();
    let read = |name: &str| Record::read(format!("fixtures/telescopic/{name}.csv")).unwrap();
    let calibrated =
        calibrate(&text, &rig, &[read("healthy_1"), read("healthy_3")], &CalibrationOptions::default()).unwrap();
    assert!(calibrated.report.adequate, "{:?}", calibrated.report.warnings);
    assert!(calibrated.report.warnings.is_empty(), "{:?}", calibrated.report.warnings);
    assert!(calibrated.text.starts_with(&text));
    // The data sheet of these records is the truth, and the pump's flow is what every meter shows.
    let displacement = calibrated.report.parameters.iter().find(|told| told.id == "pump.displacement").unwrap();
    assert!((displacement.after - 5.5).abs() < 0.001, "{displacement:?}");
    // Beside what no record can say the records themselves widen it by less than an eighth.
    let never_known = NEVER_KNOWN * displacement.sigma_before;
    assert!(displacement.sigma_after < 1.125 * never_known, "{never_known} {displacement:?}");
    let model = Model::new(calibrated.rig);
    let found =
        diagnosis::diagnose(&model, &read("healthy_2"), &diagnosis::DiagnosisOptions::default()).unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::Healthy);
}

#[test]
fn a_record_that_is_not_healthy_is_called_so() {
    let sheet = Rig::read(TELESCOPIC).unwrap();
    let leak = Record::read("fixtures/telescopic/leak_020.csv").unwrap();
    let (_, report) = calibrate_rig(&sheet, &[leak], &CalibrationOptions::default()).unwrap();
    assert!(!report.adequate);
    assert!(report.warnings.iter().any(|warning| warning.contains("does not explain")), "{:?}", report.warnings);
}

/// A folder with the small rig and a healthy record of it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rig.toml"), SMALL).unwrap();
    let (_, record) = small();
    record.write(folder.path().join("healthy.csv")).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Ran {
    let in_folder = |argument: &&str| {
        if argument.contains('.') { folder.join(argument).display().to_string() } else { (*argument).to_owned() }
    };
    borescope(std::iter::once("calibrate".to_owned()).chain(arguments.iter().map(in_folder)))
}

#[test]
fn the_program_writes_the_rig_and_its_summary() {
    let folder = folder();
    let ran = run(folder.path(), &["rig.toml", "healthy.csv", "-o", "new.toml", "--format", "json"]);
    assert_eq!((ran.status, ran.err.as_str()), (Some(0), ""));
    let summary: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(summary["schema"], "borescope.calibration/1");
    assert_eq!(summary["adequate"], true);
    assert_eq!(summary["records"][0]["rows"], 601);
    for key in ["id", "meaning", "unit", "before", "sigma_before", "after", "sigma_after", "informed", "fault"] {
        assert!(!summary["parameters"][0][key].is_null(), "{key}");
    }
    for key in ["name", "unit", "noise_before", "noise", "noise_correlation", "tolerance_before", "tolerance"] {
        assert!(!summary["sensors"][0][key].is_null(), "{key}");
    }
    let new = folder.path().join("new.toml");
    let rig = Rig::read(&new).unwrap();
    assert_eq!(rig.calibration.unwrap().records.len(), 1);
    let text = run(folder.path(), &["rig.toml", "healthy.csv", "-o", "again.toml", "--all"]);
    assert_eq!(text.status, Some(0));
    let channel = &summary["records"][0]["channels"][0];
    let error = |key: &str| channel[key].as_f64().unwrap();
    assert!(error("rmse") < error("rmse_before"), "{channel}");
    for part in ["pump.gain", "tolerance", "601 rows", "error of each sensor", "explained"] {
        assert!(text.out.contains(part), "`{part}` is not in {}", text.out);
    }
    assert_eq!(fs::read(&new).unwrap(), fs::read(folder.path().join("again.toml")).unwrap());
}

#[test]
fn wrong_input_is_told_and_nothing_written() {
    let folder = folder();
    let path = folder.path();
    let lacking = fs::read_to_string(path.join("healthy.csv")).unwrap().replacen("q [", "flow [", 1);
    fs::write(path.join("lacking.csv"), lacking).unwrap();
    let record = fs::read(path.join("healthy.csv")).unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&["rig.toml", "healthy.csv", "-o", "missing.d/new.toml"], "there is no folder"),
        (&["rig.toml", "healthy.csv", "-o", "healthy.csv"], "this file is read, and would be overwritten"),
        (&["rig.toml", "healthy.csv", "healthy.csv", "-o", "new.toml"], "given twice"),
        (&["rig.toml", "lacking.csv", "-o", "new.toml"], "the record has no column `q`"),
        (&["rig.toml", "none.csv", "-o", "new.toml"], "there is no such file"),
        (&["none.toml", "healthy.csv", "-o", "new.toml"], "there is no such file"),
        (&["rig.toml", "-o", "new.toml"], "required"),
        (&["rig.toml", "healthy.csv"], "required"),
    ];
    for (arguments, message) in cases {
        let ran = run(path, arguments);
        assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(ran.err.contains(message), "{arguments:?}: {}", ran.err);
    }
    assert!(!path.join("new.toml").exists());
    assert_eq!(fs::read(path.join("healthy.csv")).unwrap(), record);
}

#[test]
fn a_rig_without_sensors_cannot_be_calibrated() {
    let (_, record) = small();
    let start = SMALL.find("[sensors]").unwrap();
    let end = SMALL.find("[faults]").unwrap();
    let text =
        format!("{}{}", &SMALL[..start], &SMALL[end..]).replace("[calibration.sensors.p]\nnoise = \"7 bar\"\n", "");
    let rig = Rig::parse("small.toml", text.clone()).unwrap();
    let complaint = calibrate(&text, &rig, &[record], &CalibrationOptions::default()).unwrap_err();
    assert!(complaint.to_string().contains("no sensors"), "{complaint}");
    let complaint = calibrate_rig(&small().0, &[], &CalibrationOptions::default()).unwrap_err();
    assert!(complaint.to_string().contains("no records"), "{complaint}");
}

/// The linear drive has dry friction that its file lacks: the calibrated model must not leave the record further than the file did,
/// and what `calibrate` says of its error is what `simulate` then gives.
#[test]
#[ignore = "needs ../shared/records"]
fn a_measured_drive_is_not_harmed() {
    let text = fs::read_to_string("fixtures/emps/rig.toml").unwrap();
    let rig = Rig::parse("fixtures/emps/rig.toml", text.clone()).unwrap();
    let record = rig.scaled(Record::read("../shared/records/real/emps_fit.csv").unwrap());
    let calibrated = calibrate(&text, &rig, std::slice::from_ref(&record), &CalibrationOptions::default()).unwrap();
    let channel = &calibrated.report.records[0].channels[0];
    assert!(channel.rmse < channel.rmse_before, "{channel:?}");
    let model = Model::new(calibrated.rig);
    let drive = InputSignals::from_record(&model.rig, &record).unwrap();
    let read = &model.solve(&model.rig.nominal(), &drive, &record.time).unwrap().values[0];
    let measured = &record.channels.iter().find(|channel| channel.name == "q").unwrap().values;
    let square: f64 = read.iter().zip(measured).map(|(model, measured)| (model - measured).powi(2)).sum();
    let error = 1e3 * (square / read.len() as f64).sqrt();
    approx::assert_relative_eq!(error, channel.rmse * if channel.unit == "m" { 1e3 } else { 1.0 }, max_relative = 1e-3);
    let friction = calibrated.report.parameters.iter().find(|one| one.id.contains("seal-friction")).unwrap();
    assert!((15.0..25.0).contains(&friction.after) && friction.informed, "published: 20.4 N; {friction:?}");
}

/// Behind a jump of a command, where alone a lag shows, the first fits have no weight: lags that they find serve values that are still
/// off. Asked for again where the rounds have ended, they are those of the machine; before, they were 0.55 and 0.85 ms off.
#[test]
fn mean_lags_are_asked_for_again_where_everything_else_is_found() {
    let folder = folder();
    fs::write(folder.path().join("two_lags.toml"), TWO_LAGS).unwrap();
    let machine = [
        "relief.set_pressure=176.2bar",
        "relief.rated_overpressure=13.9bar",
        "feed.rated_drop=5.6bar",
        "feed.dead_band=0.118",
        "motor.displacement=49.1cc/rev",
        "motor.inertia=0.128kg.m2",
        "fluid.bulk_modulus=12600bar",
        "reducer.set_pressure=95.8bar",
        "fluid.viscosity=36.5mPa.s",
        "reducer.lag=14ms",
    ];
    let [rig, healthy] = ["two_lags.toml", "machine.csv"].map(|name| folder.path().join(name).display().to_string());
    let set = machine.iter().flat_map(|value| ["--set", value]);
    let simulated = borescope(["simulate", &rig, "--seed", "2", "-o", &healthy].into_iter().chain(set));
    assert_eq!(simulated.status, Some(0), "{}", simulated.err);
    let ran = run(folder.path(), &["two_lags.toml", "machine.csv", "-o", "calibrated.toml"]);
    assert_eq!(ran.status, Some(0), "{}", ran.err);
    let found = Rig::read(folder.path().join("calibrated.toml")).unwrap();
    for (lag, truth, within) in [("relief.lag", 8e-3, 0.2e-3), ("reducer.lag", 14e-3, 0.4e-3)] {
        let value = found.parameters[found.parameter(lag).unwrap()].value;
        assert!((value - truth).abs() < within, "{lag}: {value}");
    }
}

/// A heavy load on a column of oil, lightly damped.
const RINGING: &str = include_str!("scissor_lift.toml");

#[test]
fn a_stiffness_that_rings_at_another_frequency_is_found() {
    let sheet = Rig::parse("ringing.toml", RINGING.to_owned()).unwrap();
    let model = sheet.model();
    // As far off as its standard uncertainty: the model is out of step long before the ringing has died.
    for (seed, off) in [("11050 bar", "7.84 cc/rev"), ("15500 bar", "8.1 cc/rev")].into_iter().enumerate() {
        let truth = [("fluid.bulk_modulus", off.0), ("pump.displacement", off.1)];
        let run =
            |number| Run::of(&model).with_quantities(&truth).seed(10 * seed as u64 + number).record("ringing.csv");
        let (found, report) = calibrate_rig(&sheet, &[1, 2].map(run), &CalibrationOptions::default()).unwrap();
        assert!(report.adequate, "{:?}", report.warnings);
        for (id, text) in truth {
            let (value, found) =
                (borescope::Quantity::parse(text).unwrap().value, &found.parameters[found.parameter(id).unwrap()]);
            assert!(
                (found.value - value).abs() < 3.0 * found.sigma,
                "{id}: {} +- {}, not {value}",
                found.value,
                found.sigma
            );
            assert_relative_eq!(found.value, value, max_relative = 0.02);
        }
    }
}

mod studies {
    use super::*;

    /// Masses, lags and rated drops are off the data sheets by what data sheets are, the spool has mass, and the load is let go as the valve
    /// closes (`fixtures/independent/clamp_and_feed.py`): what the records determine is within two and a half standard deviations
    /// of the machine, a third record is healthy, and neither a command that is logged late nor oil that has become warm is a fault.
    #[test]
    #[ignore = "a minute"]
    fn a_machine_off_its_data_sheets_is_calibrated_to_what_it_is() {
        let rig = Rig::read("fixtures/clamp_and_feed/rig.toml").unwrap();
        let healthy = |number: usize| Record::read(format!("fixtures/clamp_and_feed/healthy_{number}.csv")).unwrap();
        let records = [healthy(1), healthy(2)];
        let (calibrated, report) = calibrate_rig(&rig, &records, &CalibrationOptions::default()).unwrap();
        let machine = [
            ("line_A.volume", 310.0),
            ("line_B.volume", 395.0),
            ("fluid.bulk_modulus", 12_500.0),
            ("feed_cylinder.mass", 210.0),
            ("feed_cylinder.viscous_friction", 3100.0),
            ("relief.set_pressure", 141.5),
            ("accumulator.exponent", 1.23),
        ];
        for (id, truth) in machine {
            let found = report.parameters.iter().find(|one| one.id == id).unwrap();
            assert!((found.after - truth).abs() < 2.5 * found.sigma_after, "{found:?}, {truth}");
        }
        let lag = calibrated.parameters[calibrated.parameter("reducing.lag").unwrap()].value;
        assert_relative_eq!(lag, 9e-3, max_relative = 0.05);

        let model = Model::new(calibrated);
        let diagnosed = |record: &Record| {
            diagnosis::diagnose(&model, record, &diagnosis::DiagnosisOptions::default()).unwrap().diagnosis
        };
        let mut third = healthy(3);
        let found = diagnosed(&third);
        assert_eq!((found.verdict, &found.common_cause), (Verdict::Healthy, &None));
        let values = &mut third.channels.iter_mut().find(|channel| channel.name == "u").unwrap().values;
        values.rotate_right(6);
        values[..6].fill(0.0);
        let found = diagnosed(&third);
        let cause = found.common_cause.as_ref().map(|cause| (cause.kind, cause.columns.join(","), cause.value));
        assert_eq!(cause, Some(("late-inputs", "u".to_owned(), Some(0.06))));
        assert_eq!((found.verdict, found.present().count()), (Verdict::Healthy, 0));

        let warm = diagnosed(&Record::read("fixtures/clamp_and_feed/warm.csv").unwrap());
        assert_eq!((warm.verdict, warm.present().count()), (Verdict::Healthy, 0), "{warm:?}");
        let cause = warm.common_cause.unwrap();
        assert_eq!(cause.kind, "other-oil");
        assert_relative_eq!(cause.value.unwrap(), 0.55 * 0.04, max_relative = 0.03);
    }
}
