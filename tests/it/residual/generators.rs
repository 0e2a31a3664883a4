//! The residual generators against simulated truth, Monte Carlo and the run length that their thresholds promise.

use borescope::Unit;
use borescope::internals::model::{InputSignals, Model};
use borescope::internals::record::{Channel, Record};
use borescope::internals::residual::{
    Detection, Gate, Generator, Variant, detect, first_alarm, generators, run_length, threshold,
};
use borescope::internals::rig::{Quantity, Rig};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const WINDOW: f64 = 0.1;
const LPM: f64 = 1e-3 / 60.0;

fn rig() -> Rig {
    Rig::read("fixtures/telescopic/rig.toml").unwrap_or_else(|complaint| panic!("{complaint}"))
}

/// One cycle of the rig with these parameters: what the sensors would show without noise.
fn truth(rig: &Rig, set: &[(&str, f64)]) -> (Record, InputSignals) {
    let cycle = rig.cycle.as_ref().unwrap();
    let drive = InputSignals::from_cycle(rig, cycle);
    let rows = (cycle.duration() / cycle.interval).round() as usize;
    let time: Vec<f64> = (1..=rows).map(|row| row as f64 * cycle.interval).collect();
    let mut parameters = rig.nominal();
    for (id, value) in set {
        parameters[rig.parameter(id).unwrap()] = *value;
    }
    let outputs = Model::new(rig.clone()).solve(&parameters, &drive, &time).unwrap();
    let unit = |quantity| {
        Unit::parse(match quantity {
            Quantity::Pressure => "bar",
            Quantity::Flow => "L/min",
            _ => "mm",
        })
        .unwrap()
    };
    let mut channels: Vec<Channel> = rig
        .sensors
        .iter()
        .zip(outputs.values)
        .map(|(sensor, values)| Channel::new(&sensor.column, unit(sensor.quantity), values))
        .collect();
    for (index, input) in rig.inputs.iter().enumerate() {
        let values = time.iter().map(|&t| drive.value(index, t)).collect();
        channels.push(Channel::new(&input.column, input.unit.clone(), values));
    }
    (Record::new("simulated", time, channels), drive)
}

fn noisy(rig: &Rig, truth: &Record, seed: u64) -> Record {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut record = truth.clone();
    let mut add = |column: &str, noise: f64, resolution: f64| {
        let channel = record.channels.iter_mut().find(|channel| channel.name == column).unwrap();
        for value in &mut channel.values {
            let normal: f64 = StandardNormal.sample(&mut rng);
            *value += noise * normal;
            if resolution > 0.0 {
                *value = (*value / resolution).round() * resolution;
            }
        }
    };
    for sensor in &rig.sensors {
        add(&sensor.column, sensor.noise, sensor.resolution);
    }
    for input in &rig.inputs {
        add(&input.column, input.noise, 0.0);
    }
    record
}

fn find(rig: &Rig, id: &str, variant: Variant) -> Generator {
    generators(rig).into_iter().find(|generator| generator.id == id && generator.variant == variant).unwrap()
}

/// Mean over the windows that count within these times, SI.
fn mean(rig: &Rig, generator: &Generator, record: &Record, drive: &InputSignals, from: f64, to: f64) -> f64 {
    let series = generator.blocks(rig, record, drive, WINDOW).unwrap();
    let counted: Vec<f64> = (0..series.time.len())
        .filter(|&at| series.gate[at] == Gate::Open && series.start[at] >= from && series.time[at] <= to)
        .map(|at| series.value[at])
        .collect();
    assert!(counted.len() >= 5, "{}: {} windows", generator.id, counted.len());
    counted.iter().sum::<f64>() / counted.len() as f64
}

#[test]
fn every_residual_of_the_rig_is_found() {
    let found: Vec<String> = generators(&rig())
        .iter()
        .map(|generator| format!("{} {} {:?}", generator.id, generator.equation, generator.variant))
        .collect();
    assert_eq!(
        found,
        [
            "pump.balance - Corrected",
            "relief.state - Corrected",
            "flow_control.flow (10) Corrected",
            "flow_control.flow (10) Paper",
            "directional_valve.leakage (16) Corrected",
            "directional_valve.leakage (16) Paper",
            "directional_valve.consumer (18) Corrected",
            "directional_valve.consumer (18) Paper",
            "directional_valve.supply (20) Corrected",
            "directional_valve.supply (20) Paper",
            "directional_valve.return (14) Corrected",
            "directional_valve.return (14) Paper",
            "cylinder.leakage (4) Corrected",
            "cylinder.leakage (4) Paper",
            "cylinder.flow_A (1) Corrected",
            "cylinder.flow_B (1) Corrected",
            "cylinder.force - Corrected",
        ]
    );
}

#[test]
fn a_residual_is_found_only_where_its_sensors_are() {
    let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
    let without = |sensor: &str| {
        let kept: Vec<&str> = text
            .lines()
            .filter(|line| !line.starts_with(&format!("{sensor} = {{")) && !line.contains(&format!("sensor.{sensor}.")))
            .collect();
        let rig = Rig::parse("cut.toml", kept.join("\n")).unwrap_or_else(|complaint| panic!("{complaint}"));
        generators(&rig).into_iter().map(|generator| generator.id).collect::<Vec<_>>()
    };
    assert!(without("x").iter().all(|id| !id.starts_with("cylinder")));
    assert!(!without("p_pump").contains(&"flow_control.flow".to_owned()));
    assert!(!without("q_P").contains(&"directional_valve.supply".to_owned()));
    assert!(without("q_P").contains(&"directional_valve.consumer".to_owned()));
}

#[test]
fn without_noise_every_corrected_residual_of_a_healthy_rig_is_zero() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[]);
    for generator in generators(&rig).iter().filter(|generator| generator.variant == Variant::Corrected) {
        let series = generator.blocks(&rig, &record, &drive, WINDOW).unwrap();
        let open: Vec<usize> = (0..series.time.len()).filter(|&at| series.gate[at] == Gate::Open).collect();
        // The bias correction is for noise that is not there, so it is put back through the share of the noise.
        let worst = open.iter().map(|&at| (series.value[at] / series.sigma[at]).abs()).fold(0.0, f64::max);
        println!("{:28} {:3} windows, worst {worst:.4} sigma", generator.id, open.len());
        assert!(open.len() >= 10, "{}: {} windows", generator.id, open.len());
        assert!(worst < 0.25, "{}: {worst} sigma", generator.id);
    }
}

#[test]
fn the_leakage_is_read_right_and_the_printed_form_reads_a_seventh() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[("cylinder.clearance", 0.2e-3)]);
    let (from, to) = (1.5, 2.5);
    // Truth from the law: conductance times pressure difference, less what the wall drags along.
    let at = |name: &str, t: f64| {
        let row = record.time.partition_point(|&time| time < t);
        record.channel(name).unwrap().values[row]
    };
    let speed = (at("x", to) - at("x", from)) / (to - from);
    let gap: f64 = 0.1e-3;
    let conductance = std::f64::consts::PI * 0.04 * gap.powi(3) / (12.0 * 45.5e-3 * 37.4e-3);
    let leak = conductance * (at("p_A", 2.0) - at("p_B", 2.0)) - std::f64::consts::PI * 0.04 * gap * speed / 2.0;
    for seed in 0..4 {
        let record = noisy(&rig, &record, seed);
        for id in ["cylinder.leakage", "cylinder.flow_A", "cylinder.flow_B"] {
            let read = mean(&rig, &find(&rig, id, Variant::Corrected), &record, &drive, from, to);
            println!("{id}: {:.4} L/min of {:.4}", read / LPM, leak / LPM);
            assert!((read - leak).abs() < 0.04 * LPM, "{id}: {} of {}", read / LPM, leak / LPM);
        }
    }
    let printed = mean(&rig, &find(&rig, "cylinder.leakage", Variant::Paper), &record, &drive, from, to);
    println!("printed (4): {:.4} L/min, 1/{:.2} of the leakage", printed / LPM, leak / printed);
    assert!((leak / printed - 7.0).abs() < 0.1, "{}", leak / printed);
}

#[test]
fn the_printed_constant_flow_calls_a_healthy_valve_blocked() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[]);
    let corrected = mean(&rig, &find(&rig, "flow_control.flow", Variant::Corrected), &record, &drive, 1.0, 2.5);
    let printed = mean(&rig, &find(&rig, "flow_control.flow", Variant::Paper), &record, &drive, 1.0, 2.5);
    println!("(10) corrected {:.3} L/min, printed {:.3} L/min", corrected / LPM, printed / LPM);
    assert!(corrected.abs() < 0.1 * LPM);
    // (13) as printed takes the pressure drop out of the root: off by the root of 9 bar in Pa.
    let supply = mean(&rig, &find(&rig, "directional_valve.supply", Variant::Paper), &record, &drive, 1.0, 2.5);
    println!("(20) by (13) as printed: {:.0} L/min", supply / LPM);
    assert!(supply / LPM > 5.5 * 900.0);
    assert!((printed / LPM - (34.0 - 5.5)).abs() < 0.5);
}

#[test]
fn the_stated_noise_is_the_noise_of_many_records() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[]);
    let seeds = 60;
    let corrected: Vec<Generator> =
        generators(&rig).into_iter().filter(|generator| generator.variant == Variant::Corrected).collect();
    let mut sums = vec![(0.0_f64, 0.0_f64, 0.0_f64); corrected.len()];
    let mut lagged = vec![0.0_f64; corrected.len()];
    for seed in 0..seeds {
        let record = noisy(&rig, &record, 100 + seed);
        for (index, generator) in corrected.iter().enumerate() {
            let series = generator.blocks(&rig, &record, &drive, WINDOW).unwrap();
            let mut before = None;
            for at in 0..series.time.len() {
                if series.gate[at] != Gate::Open {
                    before = None;
                    continue;
                }
                let z = series.value[at] / series.sigma[at];
                sums[index].0 += 1.0;
                sums[index].1 += z;
                sums[index].2 += z * z;
                lagged[index] += before.map_or(0.0, |before| before * z);
                before = Some(z);
            }
        }
    }
    for ((generator, (count, sum, squares)), lagged) in corrected.iter().zip(sums).zip(lagged) {
        let (mean, deviation) = (sum / count, (squares / count - (sum / count).powi(2)).sqrt());
        println!(
            "{:28} {count:6} windows: mean {mean:+.3}, deviation {deviation:.3}, neighbours {:+.3}",
            generator.id,
            lagged / count
        );
        // The window before gives the noise, so a law whose noise depends on its noisy inputs spreads a little more.
        assert!((deviation - 1.0).abs() < 0.06, "{}: {deviation}", generator.id);
        assert!(mean.abs() < 0.1, "{}: {mean}", generator.id);
        assert!((lagged / count).abs() < 0.08, "{}: {}", generator.id, lagged / count);
    }
}

#[test]
fn per_sample_noise_is_that_of_the_samples() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[]);
    let generator = find(&rig, "cylinder.leakage", Variant::Corrected);
    let series = generator.evaluate(&rig, &noisy(&rig, &record, 7), &drive, WINDOW).unwrap();
    assert_eq!(series.time, record.time);
    let open: Vec<usize> = (0..series.time.len()).filter(|&at| series.gate[at] == Gate::Open).collect();
    let squares: f64 = open.iter().map(|&at| (series.value[at] / series.sigma[at]).powi(2)).sum();
    let deviation = (squares / open.len() as f64).sqrt();
    // 4 q2 - 3 q1: five times the noise of one meter.
    let gain = series.sigma[open[0]] / rig.sensors[4].variance().sqrt();
    println!("{} samples, deviation {deviation:.3}, noise gain {gain:.3}", open.len());
    assert!((deviation - 1.0).abs() < 0.06, "{deviation}");
    assert!((gain - 5.0).abs() < 0.05, "{gain}");
}

/// Mean run length of a two-sided CUSUM over white values, by simulation.
fn simulated(k: f64, h: f64, runs: u64, longest: usize) -> (f64, f64) {
    let mut lengths = Vec::new();
    for seed in 0..runs {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let values: Vec<f64> = (0..longest).map(|_| StandardNormal.sample(&mut rng)).collect();
        let alarm = first_alarm(&values, &vec![0.0; longest], k, h);
        lengths.push(alarm.map_or(longest, |alarm| alarm.at + 1) as f64);
    }
    let mean = lengths.iter().sum::<f64>() / runs as f64;
    // Run lengths are nearly exponential, so their deviation is their mean.
    (mean, mean / (runs as f64).sqrt())
}

#[test]
fn the_threshold_keeps_the_run_length_that_was_asked_for() {
    assert!((run_length(0.5, 5.0) / 931.0 - 1.0).abs() < 0.02, "{}", run_length(0.5, 5.0));
    // Windows of 0.1 s: 0.05 h, 0.1 h and 0.2 h of white residuals.
    let mut before = 0.0;
    for hours in [0.05_f64, 0.1, 0.2] {
        let asked = hours * 3600.0 / WINDOW;
        let h = threshold(0.5, 2.0 * asked);
        let (found, error) = simulated(0.5, h, 600, 20 * asked as usize);
        println!("{hours} h: threshold {h:.3}, asked {asked:.0} windows, found {found:.0} +- {error:.0}");
        // Three standard errors, and 3 % for Siegmund's approximation.
        assert!((found - asked).abs() < 3.0 * error + 0.03 * asked, "{found} of {asked}");
        assert!(h > before + 0.6 && (before == 0.0 || h < before + 0.75), "twice the run length costs ln 2 / 2k");
        before = h;
    }
}

#[test]
fn healthy_noise_raises_no_more_alarms_than_were_asked_for() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[]);
    const HOURS: f64 = 0.005;
    // No allowance: what is tested is the noise alone.
    let detection = Detection { hours_between_false_alarms: HOURS, coverage: 0.0, ..Detection::default() };
    let seeds = 120;
    let alarmed = |seed: &u64| {
        let reports = detect(&rig, &noisy(&rig, &record, 1000 + seed), &drive, &detection).unwrap();
        reports.iter().any(|report| report.fired)
    };
    let alarms = (0..seeds).filter(alarmed).count() as f64;
    let most = seeds as f64 * record.time.last().unwrap() / (HOURS * 3600.0);
    println!("{alarms} alarms in {seeds} records, at most {most:.1} expected");
    assert!(alarms <= most + 3.0 * most.sqrt(), "{alarms} of {most}");
}

#[test]
fn a_bias_within_its_tolerance_is_no_fault_and_a_larger_one_is_dated() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let noise: Vec<f64> = (0..20_000).map(|_| StandardNormal.sample(&mut rng)).collect();
    let h = threshold(0.5, 1e9);
    let biased: Vec<f64> = noise.iter().map(|value| value + 0.8).collect();
    assert!(first_alarm(&biased, &vec![0.0; biased.len()], 0.5, h).is_some());
    assert_eq!(first_alarm(&biased, &vec![0.8; biased.len()], 0.5, h), None);
    let late: Vec<f64> = noise.iter().enumerate().map(|(at, z)| if at < 5000 { *z } else { z + 3.0 }).collect();
    let alarm = first_alarm(&late, &vec![0.0; late.len()], 0.5, h).unwrap();
    println!("shift at 5000, alarm at {}, onset {}", alarm.at, alarm.onset);
    assert!(alarm.at - 5000 < 15 && alarm.onset.abs_diff(5000) <= 5);
}

#[test]
fn the_state_of_the_relief_valve_is_checked_where_its_pressure_says_shut() {
    let rig = rig();
    let alarmed = |set: &[(&str, f64)]| {
        let (record, drive) = truth(&rig, set);
        let reports = detect(&rig, &noisy(&rig, &record, 5), &drive, &Detection::default()).unwrap();
        let fired = |id: &str| reports.iter().find(|report| report.id == id).map(|report| (report.fired, report.phase));
        (fired("pump.balance").unwrap(), fired("relief.state").unwrap())
    };
    // 60 bar in place of 100: oil goes over the relief valve while the pressure, under 60 bar and a little, says shut.
    let ((_, _), (state, phase)) = alarmed(&[("relief.set_pressure", 60e5)]);
    assert_eq!((state, phase), (true, Some("closed")));
    // With the valve closed the whole pump flow goes over the relief valve, healthy or not; only above its set pressure does
    // a shift of 5 bar show, and only in the balance.
    let ((balance, phase), (state, _)) = alarmed(&[("relief.set_pressure", 105e5)]);
    assert_eq!((balance, phase, state), (true, Some("closed"), false));
    // A pump that gives a tenth less misses flow in any state.
    let ((balance, _), (state, phase)) = alarmed(&[("pump.displacement", 5.5e-6 * 0.9)]);
    assert_eq!((balance, state, phase), (true, true, Some("P-A")));
    assert_eq!(alarmed(&[]), ((false, None), (false, None)));
}

#[test]
fn each_fault_is_felt_where_its_parameter_enters_and_nowhere_else() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[]);
    for generator in generators(&rig).iter().filter(|generator| generator.variant == Variant::Corrected) {
        let answers = generator.signature(&rig, &record, &drive, WINDOW).unwrap();
        let felt: Vec<&str> = answers[..3]
            .iter()
            .filter(|answer| answer.at_limit != 0.0)
            .map(|answer| answer.parameter.as_str())
            .collect();
        let expected: &[&str] = match generator.id.as_str() {
            "cylinder.leakage" | "cylinder.flow_A" | "cylinder.flow_B" => &["cylinder.clearance"],
            "flow_control.flow" => &["flow_control.orifice_diameter"],
            "directional_valve.consumer" | "directional_valve.supply" | "directional_valve.return" => {
                &["directional_valve.opening"]
            }
            _ => &[],
        };
        assert_eq!(felt, expected, "{}", generator.id);
        // Losing opening or diameter raises the residual.
        for answer in answers[1..3].iter().filter(|answer| answer.slope != 0.0) {
            assert!(answer.slope < 0.0, "{} by {}", generator.id, answer.parameter);
        }
    }
    let offsets = find(&rig, "directional_valve.leakage", Variant::Corrected)
        .signature(&rig, &record, &drive, WINDOW)
        .unwrap()
        .into_iter()
        .filter(|answer| answer.parameter.ends_with(".offset") && answer.slope.abs() > 1e-3);
    let offsets: Vec<String> = offsets.map(|answer| answer.parameter).collect();
    assert_eq!(offsets, ["sensor.q_P.offset", "sensor.q_A.offset", "sensor.q_B.offset"]);
}

#[test]
fn a_report_has_the_fields_that_programs_rely_on() {
    let rig = rig();
    let (record, drive) = truth(&rig, &[("directional_valve.opening", 0.6)]);
    let record = noisy(&rig, &record, 11);
    let reports = detect(&rig, &record, &drive, &Detection::default()).unwrap();
    let fired: Vec<&str> = reports.iter().filter(|report| report.fired).map(|report| report.id.as_str()).collect();
    assert_eq!(fired, ["directional_valve.consumer", "directional_valve.supply", "directional_valve.return"]);
    let consumer = reports.iter().find(|report| report.id == "directional_valve.consumer").unwrap();
    let row = serde_json::to_value(consumer).unwrap();
    assert_eq!((row["equation"].as_str(), row["unit"].as_str()), (Some("(18)"), Some("L/min")));
    assert_eq!((row["fired"].as_bool(), row["variant"].as_str()), (Some(true), Some("corrected")));
    assert!(row["mean"].is_f64() && row["sigma"].is_f64() && row["alarm_at_s"].is_f64() && row["onset_s"].is_f64());
    assert_eq!((row["phase"].as_str(), row["direction"].as_str()), (Some("P-A"), Some("high")));
}
