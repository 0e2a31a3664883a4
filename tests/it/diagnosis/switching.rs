//! Spools with mass and dead time, which no data sheet states, make neither faults nor a misfit; nor does a slow logger.

use crate::support::cycle::Run;
use crate::support::plant;

use borescope::Model;
use borescope::Record;
use borescope::Rig;
use borescope::internals::calibration::{CalibrationOptions, calibrate};
use borescope::internals::campaign::random::Stream;
use borescope::internals::diagnosis::estimate;
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, Verdict, diagnose};
use borescope::internals::model::InputSignals;
use plant::Plant;
use plant::record::{cycle, record};

const RIG: &str = "fixtures/telescopic/rig.toml";

fn diagnosed(record: &Record) -> Diagnosis {
    let model = Model::new(Rig::read(RIG).unwrap());
    diagnose(&model, record, &DiagnosisOptions::default()).unwrap().diagnosis
}

fn of_plant(plant: &Plant, seed: u64) -> Diagnosis {
    let mut random = Stream::numbered(seed, 0);
    let phases = cycle(&mut random, 1.0);
    diagnosed(&record("plant", plant, &phases, &mut random))
}

fn present(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.present().map(|fault| fault.id.as_str()).collect()
}

/// Spools: the first as quick as the lag of the model, the others slower and later, the last far from it.
const SPOOLS: [(f64, f64, usize); 4] = [(0.85, 8e-3, 0), (0.7, 9e-3, 1), (1.0, 10e-3, 2), (0.6, 12e-3, 2)];

fn plant(spool: usize, clearance: f64) -> Plant {
    let (spool_damping, lag, dead_rows) = SPOOLS[spool];
    Plant { spool_damping, spool_lags: [lag, 0.0], dead_rows, clearance, ..Plant::default() }
}

fn is_healthy(spool: usize, seed: u64) {
    let diagnosis = of_plant(&plant(spool, Plant::default().clearance), seed);
    assert_eq!((diagnosis.verdict, present(&diagnosis)), (Verdict::Healthy, vec![]), "spool {spool}, seed {seed}");
}

fn leaks_alone(spool: usize, seed: u64) {
    let diagnosis = of_plant(&plant(spool, 0.15e-3), seed);
    assert_eq!(present(&diagnosis), ["cylinder.clearance"], "spool {spool}, seed {seed}");
    let clearance = &diagnosis.faults[0];
    let [Some(low), Some(high)] = clearance.ci95 else { panic!("open: {clearance:?}") };
    assert!(low <= 0.15 && 0.15 <= high && high - low < 0.01, "spool {spool}, seed {seed}: {low} to {high}");
}

#[test]
fn a_healthy_rig_is_healthy_whatever_its_spool_does() {
    is_healthy(2, 13);
}

#[test]
fn a_leak_is_found_alone_whatever_the_spool_does() {
    leaks_alone(2, 23);
}

/// What the record shows of the spool is told: 12 ms and a damping of 0.6 where the rig file has a lag of 8 ms. The record dates from
/// the row behind, so its dead time has an interval more or less.
#[test]
fn the_spool_of_the_record_is_told() {
    let diagnosis = of_plant(&plant(3, 0.15e-3), 24);
    assert_eq!(present(&diagnosis), ["cylinder.clearance"]);
    let of = |id: &str| diagnosis.dynamics.iter().find(|one| one.id == id).map_or(f64::NAN, |one| one.value);
    approx::assert_relative_eq!(of("directional_valve.lag"), 12.0, max_relative = 0.1);
    approx::assert_relative_eq!(of("directional_valve.inertia_time"), 12.0 / 1.2, max_relative = 0.1);
    approx::assert_abs_diff_eq!(of("directional_valve.dead_time"), 8.0, epsilon = 4.0);
}

/// A spool that has become slow is so in every switching, which each may be forgiven for itself: no fault explains it, and yet the record
/// is not healthy. Declared as a fault its lag is one value throughout.
#[test]
fn a_spool_that_has_become_slow_is_not_healthy() {
    let text = std::fs::read_to_string(RIG).unwrap().replace("lag = \"8 ms\"", "lag = \"8 ms +- 0.8 ms\"");
    let mut random = Stream::numbered(31, 0);
    let phases = cycle(&mut random, 1.0);
    let slow = Plant { spool_lags: [20e-3, 0.0], ..Plant::default() };
    let record = record("plant", &slow, &phases, &mut random);
    let of = |text: String| Model::new(Rig::parse(RIG, text).unwrap()).diagnose(&record).unwrap();

    let undeclared = of(text.clone());
    let missing = undeclared.missing_effect.as_ref().expect("an effect");
    assert_eq!((undeclared.verdict, &missing.effects[..]), (Verdict::ModelInadequate, &["spool-lag".to_owned()][..]));
    approx::assert_relative_eq!(missing.parameters[0].value, 20.0, max_relative = 0.05);

    let lag = "[faults]\n\"directional_valve.lag\" = { bounds = [\"2 ms\", \"40 ms\"] }";
    let declared = of(text.replace("[faults]", lag));
    assert_eq!((declared.verdict, &present(&declared)[..]), (Verdict::Faulty, &["directional_valve.lag"][..]));
    let found = declared.present().next().unwrap();
    let [Some(low), Some(high)] = found.ci95 else { panic!("open: {found:?}") };
    assert!(low <= 20.0 && 20.0 <= high && high - low < 4.0, "{low} to {high}");
}

/// Mass and dead time act on what drives a law, so no fault is one of them; what a rig file says of their uncertainty each switching may
/// use.
#[test]
fn mass_and_dead_time_are_no_faults_but_may_be_uncertain() {
    let text = std::fs::read_to_string(RIG).unwrap();
    let with = |before: &str, line: &str| {
        assert_eq!(text.matches(before).count(), 1, "{before}");
        Rig::parse(RIG, text.replace(before, &format!("{before}{line}")))
    };
    let fault = with("[faults]\n", "\"directional_valve.inertia_time\" = { bounds = [\"0 ms\", \"9 ms\"] }\n");
    let fault = fault.unwrap_err().to_string();
    assert!(fault.contains("`directional_valve.inertia_time` cannot be a fault"), "{fault}");

    let valve = |line: &str| with("[components.directional_valve]\n", line).unwrap();
    let late = Model::new(valve("dead_time = \"35 ms\"\n"));
    let record = Run::of(&late).record("late");
    let misfit = |line: &str| {
        let model = Model::new(valve(line));
        let drive = InputSignals::from_record(&model.rig, &record).unwrap();
        let found = estimate::near(&model, &record, &drive, None, 1).unwrap();
        found.without_faults(1).unwrap().isolation.best.cost
    };
    let lines = ["35 ms", "20 ms", "20 ms +- 10 ms"].map(|dead_time| format!("dead_time = \"{dead_time}\"\n"));
    let [right, exact, uncertain] = lines.map(|line| misfit(&line));
    println!("chi-square with 35 ms {right:.0}, 20 ms {exact:.0}, 20 ms +- 10 ms {uncertain:.0}");
    assert!(uncertain - right < 0.1 * (exact - right));
}

/// Mass and dead time reshape a command, which then cannot drive another part.
#[test]
fn mass_behind_a_shared_command_is_refused() {
    let valve = |name: &str, inertia_time: &str| {
        format!(
            "[components.{name}]\nkind = \"on-off-valve\"\nports = {{ in = \"pump_line\", out = \"tank\" }}\ncommand = \"valve_command\"\n\
             rated_flow = \"1 L/min\"\nrated_drop = \"10 bar\"\n{inertia_time}\n"
        )
    };
    let text = std::fs::read_to_string(RIG).unwrap();
    let with = |inertia_time: &str| {
        let valves = valve("first", inertia_time) + &valve("second", "");
        Rig::parse(
            RIG,
            text.replacen("[components.directional_valve]", &(valves + "[components.directional_valve]"), 1),
        )
    };
    with("").unwrap();
    let told = with("inertia_time = \"5 ms\"").unwrap_err().to_string();
    assert!(told.contains("`first.inertia_time` on an input that other parts have too, `valve_command`"), "{told}");
}

/// A record as a logger of so many rows less would have written it.
fn thinned(record: &Record, every: usize) -> Record {
    let rows = |values: &[f64]| values.iter().skip(every - 1).step_by(every).copied().collect::<Vec<f64>>();
    let mut thinned = record.clone();
    thinned.time = rows(&record.time);
    for (channel, whole) in thinned.channels.iter_mut().zip(&record.channels) {
        channel.values = rows(&whole.values);
    }
    thinned
}

fn stays_healthy(every: usize) {
    let record = Record::read("fixtures/telescopic/healthy_1.csv").unwrap();
    let diagnosis = diagnosed(&thinned(&record, every));
    assert_eq!((diagnosis.verdict, present(&diagnosis)), (Verdict::Healthy, vec![]), "every {every}th row");
}

/// 25 and 5 Hz: the edges of the command lie anywhere between two rows.
#[test]
fn a_slow_logger_moves_no_sensor() {
    stays_healthy(10);
    stays_healthy(50);
}

/// What lies between the spools and the loggers of the tests.
mod studies {
    use super::*;

    /// The record begins with the command at full, the spool still at rest: what came before its first row no record says.
    #[test]
    #[ignore = "twenty seconds"]
    fn a_record_that_begins_with_a_command_needs_no_fault() {
        let mut random = Stream::numbered(25, 0);
        let phases = cycle(&mut random, 1.0).split_off(1);
        for (clearance, verdict, faults) in [
            (Plant::default().clearance, Verdict::Healthy, vec![]),
            (0.1e-3, Verdict::Faulty, vec!["cylinder.clearance"]),
        ] {
            let diagnosis = diagnosed(&record("plant", &plant(1, clearance), &phases, &mut random));
            assert_eq!((diagnosis.verdict, present(&diagnosis)), (verdict, faults));
        }
    }

    /// A leak that begins within the record, behind a spool far from the rig file: the rig that explains the record is the given one with
    /// another spool, not the one in which faults also have a value before they began.
    #[test]
    #[ignore = "ten seconds"]
    fn a_fault_that_begins_behind_another_spool_leaves_the_rig_its_parameters() {
        let rig = Rig::read(RIG).unwrap();
        let mut truth = rig.clone();
        for (id, value) in [("directional_valve.lag", 12e-3), ("directional_valve.inertia_time", 10e-3)] {
            let index = truth.parameter(id).unwrap();
            truth.parameters[index].value = value;
        }
        let truth = Model::new(truth);
        let record = Run::of(&truth).with_quantities(&[("cylinder.clearance", "0.2 mm")]).since(4.0).record("later");
        let found = diagnose(&Model::new(rig.clone()), &record, &DiagnosisOptions::default()).unwrap();
        assert_eq!((found.diagnosis.verdict, present(&found.diagnosis)), (Verdict::Faulty, vec!["cylinder.clearance"]));
        approx::assert_abs_diff_eq!(found.diagnosis.onset_s.unwrap(), 4.0, epsilon = 0.5);
        let ids = |rig: &Rig| rig.parameters.iter().map(|parameter| parameter.id.clone()).collect::<Vec<_>>();
        assert_eq!(ids(found.rig(&rig)), ids(&rig));
        assert_eq!(found.diagnosis.dynamics.len(), 3);
    }

    #[test]
    #[ignore = "a minute"]
    fn spools_and_loggers_between() {
        is_healthy(0, 11);
        is_healthy(1, 12);
        leaks_alone(0, 21);
        leaks_alone(1, 22);
        stays_healthy(20);
    }

    /// Healthy records of spools that overshoot, quick and slow, with and without dead time.
    #[test]
    #[ignore = "half a minute"]
    fn spools_on_a_grid() {
        healthy_on_a_grid(&[0.6, 0.8], &[6e-3, 12e-3], &[0, 2]);
    }

    /// The grid of theory/noise.md.
    #[test]
    #[ignore = "study, two minutes"]
    fn spools_on_the_whole_grid() {
        healthy_on_a_grid(&[0.6, 0.8, 1.0], &[6e-3, 9e-3, 12e-3], &[0, 1, 2]);
    }

    fn healthy_on_a_grid(dampings: &[f64], lags: &[f64], dead: &[usize]) {
        let mut wrong = Vec::new();
        let mut seed = 100;
        for &spool_damping in dampings {
            for &lag in lags {
                for &dead_rows in dead {
                    seed += 1;
                    let plant = Plant { spool_damping, spool_lags: [lag, 0.0], dead_rows, ..Plant::default() };
                    let found = of_plant(&plant, seed);
                    println!("{spool_damping} {lag} {dead_rows}: {:?} {:?}", found.verdict, present(&found));
                    if found.verdict != Verdict::Healthy {
                        wrong.push((spool_damping, lag, dead_rows));
                    }
                }
            }
        }
        assert!(wrong.is_empty(), "{wrong:?}");
    }

    /// Two healthy records teach how the spool follows, and the rig file keeps it.
    #[test]
    #[ignore = "half a minute"]
    fn calibration_learns_the_spool() {
        let text = std::fs::read_to_string(RIG).unwrap();
        let rig = Rig::parse(RIG, text.clone()).unwrap();
        let healthy = |seed: u64| {
            let mut random = Stream::numbered(seed, 0);
            let phases = cycle(&mut random, 1.0);
            record("healthy", &plant(3, Plant::default().clearance), &phases, &mut random)
        };
        let calibrated = calibrate(&text, &rig, &[healthy(31), healthy(32)], &CalibrationOptions::default()).unwrap();
        let kept = Rig::parse(RIG, calibrated.text).unwrap();
        let of = |id: &str| kept.parameters[kept.parameter(id).unwrap()].value;
        approx::assert_relative_eq!(of("directional_valve.lag"), 12e-3, max_relative = 0.1);
        approx::assert_relative_eq!(of("directional_valve.inertia_time"), 10e-3, max_relative = 0.1);
        let found = diagnose(&Model::new(kept), &healthy(33), &DiagnosisOptions::default()).unwrap().diagnosis;
        assert_eq!((found.verdict, present(&found), found.dynamics.len()), (Verdict::Healthy, vec![], 0));
    }
}
