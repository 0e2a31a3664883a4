//! A fault that begins in the middle of a record: the residuals that should fire do, soon, and say when it began.

use borescope::Rig;
use borescope::internals::model::{InputSignals, Model};
use borescope::internals::residual::{Detection, ResidualReport, detect};

use crate::support::cycle::Run;

/// A fault that begins, with where and when its residuals feel it.
struct Case {
    parameter: &'static str,
    /// Values before and after, SI.
    after: f64,
    /// The residuals that must fire.
    feel: &'static [&'static str],
    /// Times of its beginning, s: out from 0.5 s to 2.9 s, back from 4.5 s to 6.4 s.
    times: &'static [f64],
}

const CYLINDER: &[&str] = &["cylinder.leakage", "cylinder.flow_A", "cylinder.flow_B"];
const EDGES: &[&str] = &["directional_valve.consumer", "directional_valve.supply", "directional_valve.return"];
const BOTH: &[f64] = &[1.0, 1.27, 1.62, 2.03, 5.05, 5.3];
const OUT: &[f64] = &[1.0, 1.27, 1.62, 2.03];
/// 0.01 L/min/bar in m³/s/Pa.
const LEAK: f64 = 1e-5 / 60.0 / 1e5;

const CASES: &[Case] = &[
    // Without load the pressures of the way back leave 0.1 mm too little to see.
    Case { parameter: "cylinder.clearance", after: 0.1e-3, feel: CYLINDER, times: OUT },
    Case { parameter: "cylinder.clearance", after: 0.2e-3, feel: CYLINDER, times: BOTH },
    Case { parameter: "directional_valve.opening", after: 0.7, feel: EDGES, times: BOTH },
    Case { parameter: "flow_control.orifice_diameter", after: 1.6e-3, feel: &["flow_control.flow"], times: BOTH },
    // On the way back each leak lies beside an open edge and is lost in it.
    Case {
        parameter: "directional_valve.leak_AT",

        after: LEAK,
        feel: &["directional_valve.leakage", "directional_valve.consumer"],
        times: OUT,
    },
    Case {
        parameter: "directional_valve.leak_PB",

        after: LEAK,
        feel: &["directional_valve.leakage", "directional_valve.supply", "directional_valve.return"],
        times: OUT,
    },
    Case {
        parameter: "sensor.q_A.offset",

        after: 0.1e-3 / 60.0,
        feel: &["cylinder.leakage", "cylinder.flow_A"],
        times: BOTH,
    },
];

/// Reports on the rig's cycle with a fault that begins at `time`.
fn reports(model: &Model, case: &Case, time: f64, seed: u64) -> Vec<ResidualReport> {
    let rig = &model.rig;
    let run = Run::of(model).with(&[(case.parameter, case.after)]).since(time).seed(seed);
    let record = run.record("simulated");
    // The detector knows commands and loads, not the onset.
    let known = InputSignals::from_record(rig, &record).unwrap();
    detect(rig, &record, &known, &Detection::default()).unwrap()
}

#[test]
fn a_fault_that_begins_within_the_record_is_found_and_dated() {
    let model = Model::new(Rig::read("fixtures/telescopic/rig.toml").unwrap_or_else(|complaint| panic!("{complaint}")));
    let (mut onsets, mut close, mut early) = (0, 0, 0);
    for case in CASES {
        let (mut delays, mut errors) = (Vec::new(), Vec::new());
        for &time in case.times {
            for seed in 0..4 {
                let what = format!("{} {:.3e} from {time} s, seed {seed}", case.parameter, case.after);
                let reports = reports(&model, case, time, seed);
                let fired = reports.iter().filter(|report| report.fired);
                let alarm = |report: &ResidualReport| report.alarm_at_s.unwrap_or(f64::INFINITY);
                for report in fired.clone() {
                    assert!(alarm(report) > time, "{what}: {} fires at {} s", report.id, alarm(report));
                }
                for id in case.feel {
                    assert!(fired.clone().any(|report| report.id == *id), "{what}: {id} is silent");
                }
                let first = fired.min_by(|a, b| alarm(a).total_cmp(&alarm(b))).unwrap();
                assert!(
                    case.feel.contains(&first.id.as_str()) || case.parameter.contains("offset"),
                    "{what}: {}",
                    first.id
                );
                let (delay, error) = (alarm(first) - time, first.onset_s.unwrap() - time);
                // Six windows: one that the fault begins in, one to take the noise from, four to be sure.
                assert!(delay < 0.6, "{what}: found {delay:.2} s late");
                assert!(error.abs() < 0.5, "{what}: dated {error:+.2} s off");
                onsets += 1;
                close += usize::from(error.abs() <= 0.15);
                early += usize::from(error < 0.0);
                delays.push(delay);
                errors.push(error);
            }
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let root = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
        let longest = delays.iter().copied().fold(0.0, f64::max);
        println!(
            "{:32} {:9.2e}: found after {:.2} s (at most {longest:.2}), dated {:+.3} s, root mean square {root:.3} s",
            case.parameter,
            case.after,
            mean(&delays),
            mean(&errors)
        );
    }
    println!("{close} of {onsets} dates within 0.15 s, {early} early");
    // A sum that noise had begun to fill dates too early; more than one in ten would be another reason.
    assert!(close * 10 >= onsets * 9, "{close} of {onsets}");
}

#[test]
fn a_record_is_healthy_until_the_fault_begins() {
    let model = Model::new(Rig::read("fixtures/telescopic/rig.toml").unwrap_or_else(|complaint| panic!("{complaint}")));
    for case in CASES {
        // It begins with the last row.
        let reports = reports(&model, case, model.rig.cycle.as_ref().unwrap().duration(), 9);
        assert!(reports.iter().all(|report| !report.fired), "{}: {reports:?}", case.parameter);
    }
}
