//! The learning loop on records that others made: simulated rigs that hide one effect each, and measured tanks.

use std::path::Path;

use borescope::Record;
use borescope::Rig;
use borescope::internals::calibration::{CalibrationOptions, calibrate};
use borescope::internals::learn::evaluated::Conclusion;
use borescope::internals::learn::improve::{Improvement, improve};
use borescope::internals::learn::suggest::suggest;
use borescope::internals::model::{InputSignals, Model};
use borescope::internals::report::ledger::Ledger;

fn telescopic() -> Rig {
    Rig::read("fixtures/telescopic/rig.toml").unwrap()
}

fn improved(rig: &Rig, fit: &Path, check: &Path) -> Improvement {
    improve(rig, &rig.record(fit).unwrap(), &rig.record(check).unwrap(), |step| {
        println!("{:?}: fit {:.3}, check {:.3}", step.added, step.fit.normalised, step.check.normalised);
    })
    .unwrap()
}

fn added(improvement: &Improvement) -> Vec<&str> {
    improvement.steps.iter().filter_map(|step| step.added.as_deref()).collect()
}

/// A parameter of the improved rig, in its unit.
fn value(improvement: &Improvement, id: &str) -> f64 {
    let rig = &improvement.trial.rig;
    let index = rig.parameter(id).unwrap();
    rig.parameters[index].unit.from_si(improvement.trial.values[index])
}

/// Mean square of the weighted misfits on the check record, before anything was added and at the end.
fn check_chi2(improvement: &Improvement) -> (f64, f64) {
    (improvement.steps[0].check.chi2, improvement.steps[improvement.steps.len() - 1].check.chi2)
}

#[test]
fn nothing_is_missing_in_a_healthy_rig() {
    let folder = Path::new("fixtures/telescopic");
    let [fit, check] = ["healthy_1.csv", "healthy_3.csv"].map(|name| Record::read(folder.join(name)).unwrap());
    let suggestion = suggest(&telescopic(), &fit, Some(&check)).unwrap();
    let chi2 = suggestion.base_check.unwrap().chi2;
    println!("check chi-square {chi2:.3}");
    assert_eq!(suggestion.conclusion, Conclusion::Adequate);
    // What the rigs that hide something have to come down to.
    assert!((chi2 - HEALTHY_CHECK).abs() < 0.05 * HEALTHY_CHECK, "{chi2}");
}

/// Mean square of the weighted misfits of the plain model on `healthy_3`, fitted to `healthy_1`.
const HEALTHY_CHECK: f64 = 0.99;

/// A rig whose sensors state so many times their noise.
fn stating(rig: &Rig, factor: f64) -> Rig {
    let mut rig = rig.clone();
    for sensor in &mut rig.sensors {
        sensor.noise *= factor;
        sensor.stated_noise *= factor;
        sensor.tolerance *= if sensor.tolerance_is_stated { 1.0 } else { factor };
    }
    rig
}

mod studies {
    use super::*;

    #[test]
    #[ignore = "half a minute"]
    fn a_line_is_told_from_friction() {
        let folder = Path::new("fixtures/learning");
        let improvement = improved(&telescopic(), &folder.join("line_fit.csv"), &folder.join("line_check.csv"));
        assert_eq!(improvement.conclusion, Conclusion::EffectFound);
        assert_eq!(added(&improvement), ["line-resistance@A"]);
        let (before, after) = check_chi2(&improvement);
        println!("check chi-square {before:.3} to {after:.3}");
        assert!(before > 3.0 && after < 1.1 * HEALTHY_CHECK, "{before} {after}");
    }

    #[test]
    #[ignore = "two minutes"]
    fn what_is_missing_does_not_hang_on_the_stated_noise() {
        let folder = Path::new("fixtures/learning");
        let [fit, check] = ["line_fit.csv", "line_check.csv"].map(|name| Record::read(folder.join(name)).unwrap());
        let found = [0.1, 1.0, 10.0].map(|factor| {
            let suggestion = suggest(&stating(&telescopic(), factor), &fit, Some(&check)).unwrap();
            let best = &suggestion.judged[0];
            let size = best.trial.rig.parameter("line-resistance@A.turbulent").map(|index| best.trial.values[index]);
            // In bar: the first sensors are of pressures.
            let errors: Vec<f64> = best.check.as_ref().unwrap().rmse[..4].iter().map(|pascal| pascal / 1e5).collect();
            println!("{factor}: {:?} {} {size:?} {errors:?}", suggestion.conclusion, best.id());
            (suggestion.conclusion, best.id(), size.unwrap(), errors)
        });
        let (conclusion, id, size, errors) = &found[1];
        assert_eq!((*conclusion, id.as_str()), (Conclusion::EffectFound, "line-resistance@A"));
        for (other, other_id, other_size, other_errors) in [&found[0], &found[2]] {
            assert_eq!((other, other_id), (conclusion, id));
            assert!((other_size / size - 1.0).abs() < 0.02, "{other_size} {size}");
            for (other, error) in other_errors.iter().zip(errors) {
                assert!((other / error - 1.0).abs() < 0.05, "{other} {error}");
            }
        }
    }
}

/// Records that stand beside the project.
mod shared {
    use super::*;

    use crate::support::command::borescope;

    const SHARED: &str = "../shared/records";

    /// A command that has to succeed, with what it prints: no more lines than a person reads, none wider than a terminal.
    fn told(arguments: &[&str], most: usize) -> String {
        let ran = borescope(arguments);
        assert_eq!(ran.status, Some(0), "{arguments:?}: {}", ran.err);
        let widest = ran.out.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        assert!(widest <= 80 && ran.out.lines().count() <= most, "{arguments:?}:\n{}", ran.out);
        println!("{}", ran.out);
        ran.out
    }

    /// Compare, see, learn, add and watch the error fall, as a user does it.
    #[test]
    #[ignore = "needs ../shared/records"]
    fn the_loop_in_a_terminal() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let (rig, law) = (telescopic().path.display().to_string(), path("law.toml"));
        for (hides, effect) in
            [("a", "external-leakage@A"), ("b", "seal-friction@cylinder"), ("c", "line-resistance@A"), ("d", "")]
        {
            let [fit, check] = ["fit", "check"].map(|kind| format!("{SHARED}/rig_{hides}_{kind}.csv"));
            let new = path(&format!("{hides}.toml"));
            assert!(told(&["compare", &rig, &fit], 17).starts_with("MISFIT: "));
            let learnt = told(&["suggest", &rig, &fit, "--check", &check], 17);
            let (rig, effect) = if effect.is_empty() {
                // No effect of the library: the law that the curve shows is put into the file, and judged like any other.
                assert!(learnt.starts_with("UNKNOWN EFFECT: "), "{learnt}");
                let formula = learnt.lines().skip_while(|line| !line.starts_with("  [own_effects."));
                let formula: Vec<&str> = formula.take_while(|line| !line.is_empty()).collect();
                let text = std::fs::read_to_string(&rig).unwrap();
                std::fs::write(&law, format!("{text}\n{}\n", formula.join("\n"))).unwrap();
                let learnt = told(&["suggest", &law, &fit, "--check", &check], 17);
                assert!(learnt.starts_with("EFFECT FOUND: the model lacks extra-friction@"), "{learnt}");
                let effect = learnt.split_whitespace().find(|word| word.starts_with("extra-friction@")).unwrap();
                (&law, effect.to_owned())
            } else {
                assert!(learnt.starts_with(&format!("EFFECT FOUND: the model lacks {effect}")), "{learnt}");
                (&rig, effect.to_owned())
            };
            told(&["add", rig, &effect, "--fit", &fit, "-o", &new], 17);
            // The fit record takes as long, and says the same: of one rig it is looked at too.
            for record in if hides == "a" { vec![&fit, &check] } else { vec![&check] } {
                // What is left is a fault of the record, or nothing.
                let left = told(&["compare", &new, record, "--before", rig], 24);
                let verdict = left.split_whitespace().take(24).collect::<Vec<_>>().join(" ");
                let is_left = verdict.starts_with("ADEQUATE") || verdict.contains("with the faults below it does.");
                assert!(is_left && left.contains("Before ("), "{left}");
            }
        }
    }

    #[test]
    #[ignore = "needs ../shared/records"]
    fn the_tanks_overflow_and_their_pump_has_a_dead_voltage() {
        let folder = Path::new(SHARED);
        let rig = Rig::read("fixtures/cascaded_tanks/rig.toml").unwrap();
        // The rig file states 0.2 V.
        let stated = [0.1, 0.25, 1.0, 2.5].map(|factor| {
            let rig = stating(&rig, factor);
            let improvement = improved(&rig, &folder.join("tanks_fit.csv"), &folder.join("tanks_check.csv"));
            let mut effects: Vec<&str> = added(&improvement).iter().flat_map(|added| added.split(" + ")).collect();
            effects.sort_unstable();
            assert_eq!(effects, ["dead-voltage", "reservoir-overflow@lower", "reservoir-overflow@upper"], "{factor}");
            // 1 cm of level is 1 V.
            let error = improvement.steps[improvement.steps.len() - 1].check.rmse[0] * 100.0;
            println!("check error at {factor} of the stated noise {error:.4} V");
            assert!(error <= 0.335, "{factor}: {error} V");
            improvement
        });
        let improvement = &stated[2];
        // The lower tank is full at 10 V; a share is a share; the pump starts within its range.
        assert!((value(improvement, "reservoir-overflow@lower.height") - 10.0).abs() < 0.5);
        assert!((0.0..=1.0).contains(&value(improvement, "reservoir-overflow@upper.share")));
        assert!((0.1..2.0).contains(&value(improvement, "pump.dead_voltage")));
        // With the data sheet calibrated on the record that was learnt from, a simulation alone predicts the other as well.
        let text = std::fs::read_to_string(&rig.path).unwrap();
        let [fit, check] = ["tanks_fit.csv", "tanks_check.csv"].map(|name| rig.record(folder.join(name)).unwrap());
        let text = improvement.rig_file(&text, &rig).unwrap();
        let improved = Rig::parse(&rig.path, text.clone()).unwrap();
        let calibrated = calibrate(&text, &improved, &[fit], &CalibrationOptions::default()).unwrap().rig;
        let drive = InputSignals::from_record(&calibrated, &check).unwrap();
        let model = Model::new(calibrated);
        let predicted = model.solve(&model.rig.nominal(), &drive, &check.time).unwrap().values;
        let measured = &check.channel("level_2").unwrap().values;
        let squares: f64 = predicted[0].iter().zip(measured).map(|(a, b)| (a - b).powi(2)).sum();
        let error = 100.0 * (squares / measured.len() as f64).sqrt();
        println!("simulated with the calibrated file: {error:.4} V");
        assert!(error <= 0.335, "{error} V");
    }

    #[test]
    #[ignore = "needs ../shared/records"]
    fn dry_friction_of_a_linear_drive_is_named() {
        let folder = Path::new(SHARED).join("real");
        let rig = Rig::read("fixtures/emps/rig.toml").unwrap();
        let [fit, check] = ["emps_fit.csv", "emps_check.csv"].map(|name| rig.record(folder.join(name)).unwrap());
        let suggestion = suggest(&rig, &fit, Some(&check)).unwrap();
        let best = &suggestion.judged[0];
        assert_eq!((suggestion.conclusion, best.id().as_str()), (Conclusion::PartlyExplained, "seal-friction@drive"));
        // Published: 20.4 N; with it 2.60 and 6.06 mm.
        let coulomb = best.trial.rig.parameter("seal-friction@drive.coulomb").unwrap();
        assert!((best.trial.values[coulomb] - 20.4).abs() < 6.0, "{} N", best.trial.values[coulomb]);
        let [on_fit, on_check] = [&best.trial.fit, best.check.as_ref().unwrap()].map(|run| 1e3 * run.rmse[0]);
        println!("fit {on_fit:.2} mm, check {on_check:.2} mm");
        assert!(on_fit < 2.6 && on_check < 6.06, "{on_fit} {on_check} mm");
    }

    /// The other shared rigs; half a minute each.
    #[test]
    #[ignore = "needs ../shared/records"]
    fn the_shared_rigs() {
        let folder = Path::new(SHARED);
        let names =
            |rig: &str| [format!("rig_{rig}_fit.csv"), format!("rig_{rig}_check.csv")].map(|name| folder.join(name));
        for (rig, effect, conclusion) in [
            ("a", "external-leakage@A", Conclusion::EffectFound),
            ("b", "seal-friction@cylinder", Conclusion::EffectFound),
            ("d", "empirical-friction@cylinder", Conclusion::UnknownEffect),
        ] {
            let [fit, check] = names(rig);
            let improvement = improved(&telescopic(), &fit, &check);
            assert_eq!((added(&improvement), improvement.conclusion), (vec![effect], conclusion), "rig_{rig}");
            let (before, after) = check_chi2(&improvement);
            println!("rig_{rig}: check chi-square {before:.3} to {after:.3}");
            assert!(after < 1.1 * HEALTHY_CHECK, "rig_{rig}: {after}");
            match rig {
                // 0.30 L/min at 50 bar.
                "a" => {
                    assert!((value(&improvement, "external-leakage@A.conductance") / 0.006 - 1.0).abs() < 0.01);
                    // Its piston leaks too, which is a fault.
                    let ledger = Ledger::new(&improvement, Default::default());
                    let [fault] = ledger.faults.as_slice() else { panic!("{:?}", ledger.faults) };
                    assert_eq!(fault.id, "cylinder.clearance");
                    assert!((fault.value - 0.2).abs() < 3.0 * fault.sigma && fault.sigma < 0.002, "{fault:?}");
                    assert!(ledger.headline().contains("with cylinder.clearance 0."), "{}", ledger.headline());
                }
                "b" => {
                    assert!((value(&improvement, "seal-friction@cylinder.coulomb") / 420.0 - 1.0).abs() < 0.01);
                    let breakaway = improvement.trial.rig.parameter("seal-friction@cylinder.breakaway").unwrap();
                    let off = (improvement.trial.values[breakaway] - 260.0).abs();
                    assert!(off < 3.0 * improvement.trial.sigmas[&breakaway] && off < 130.0, "{off} N");
                }
                _ => {}
            }
        }
    }
}
