//! The bundled circuits: steady state, the default tolerance, an independent method, and derivatives.

use crate::support::circuit;

use std::f64::consts::PI;

use borescope::Rig;
use borescope::internals::model::{InputSignals, Model, Outputs, Tolerance};
use circuit::{digits, model, run};

const TELESCOPIC: &str = "fixtures/telescopic/rig.toml";

fn sensor(model: &Model, name: &str) -> usize {
    model.rig.sensors.iter().position(|sensor| sensor.name == name).unwrap()
}

#[test]
fn the_steady_stroke_balances_flows_and_forces() {
    let model = model(Rig::read(TELESCOPIC), 1e-9);
    let (times, outputs) = run(&model);
    let row = times.iter().position(|t| *t >= 2.0).unwrap();
    let at = |name: &str| outputs.values[sensor(&model, name)][row];
    let x = &outputs.values[sensor(&model, "x")];
    let speed = (x[row + 50] - x[row - 50]) / (times[row + 50] - times[row - 50]);
    let (big, small) = (PI / 4.0 * 0.04_f64.powi(2), PI / 4.0 * (0.04_f64.powi(2) - 0.02_f64.powi(2)));
    let pump = 5.5e-3 / 60.0;
    assert!(at("p_pump") < 99e5, "the relief valve is shut");
    println!("speed {speed:.5} m/s, p_pump {:.2} bar, p_A {:.2} bar", at("p_pump") / 1e5, at("p_A") / 1e5);
    assert!(digits("pump flow into the valve", &[at("q_P")], [pump]) > 6.0);
    assert!(digits("q_A = q_P", &[at("q_A")], [at("q_P")]) > 6.0);
    assert!(digits("q_A = A1 v", &[at("q_A")], [big * speed]) > 6.0);
    assert!(digits("q_B = A2 v", &[at("q_B")], [small * speed]) > 6.0);
    let pushed = big * at("p_A") - small * at("p_B");
    assert!(digits("forces on the piston", &[pushed], [5400.0 + 800.0 * speed]) > 6.0);
    // One path passes 8 L/min under 18.5 bar.
    let drop = 18.5e5 * (at("q_P") / (8e-3 / 60.0)).powi(2);
    assert!(digits("drop from P to A", &[at("p_P") - at("p_A")], [drop]) > 4.0);
}

/// Share of the samples of all sensors that agree within this many standard deviations of the noise, and the worst.
fn agreement(model: &Model, one: &Outputs, other: &Outputs, within: f64) -> (f64, f64) {
    let (mut good, mut all, mut worst) = (0_usize, 0_usize, 0.0_f64);
    for ((sensor, a), b) in model.rig.sensors.iter().zip(&one.values).zip(&other.values) {
        for (a, b) in a.iter().zip(b) {
            let off = (a - b).abs() / sensor.noise;
            good += usize::from(off < within);
            all += 1;
            worst = worst.max(off);
        }
    }
    (good as f64 / all as f64, worst)
}

#[test]
fn the_default_tolerance_is_finer_than_the_noise() {
    // The relative tolerance counts from absolute pressure: of shallow tanks it leaves a tenth of a millimetre.
    for (path, least) in
        [(TELESCOPIC, 0.999), ("fixtures/press/rig.toml", 0.999), ("fixtures/two_tanks/rig.toml", 0.75)]
    {
        let (_, default) = run(&model(Rig::read(path), Tolerance::default().relative));
        let model = model(Rig::read(path), 1e-7);
        let (_, finer) = run(&model);
        let (share, worst) = agreement(&model, &default, &finer, 0.01);
        println!(
            "{}: {:.3} % of the samples within 0.01 sigma, worst {worst:.3} sigma, {} steps against {}",
            model.rig.name,
            100.0 * share,
            default.effort.steps,
            finer.effort.steps
        );
        assert!(share > least && worst < 0.1);
    }
}

#[test]
fn an_explicit_method_of_another_library_agrees() {
    for (path, least) in
        [("fixtures/two_tanks/rig.toml", 0.9999), ("fixtures/press/rig.toml", 0.99), (TELESCOPIC, 0.99)]
    {
        let model = model(Rig::read(path), 1e-8);
        let (times, implicit) = run(&model);
        let drive = InputSignals::from_cycle(&model.rig, model.rig.cycle.as_ref().unwrap());
        let explicit = model.solve_explicitly(&model.rig.nominal(), &drive, &times).unwrap();
        let (share, worst) = agreement(&model, &implicit, &explicit, 1e-3);
        println!(
            "{}: {:.3} % within 0.001 sigma, worst {worst:.1e} sigma, {} implicit steps against {} explicit",
            model.rig.name,
            100.0 * share,
            implicit.effort.steps,
            explicit.effort.steps
        );
        assert!(share >= least && worst < 0.1);
    }
}

/// Digits in the worst sensor in which central differences with a step of this share agree with derivatives.
fn digits_of_derivative(
    model: &Model,
    drive: &InputSignals,
    times: &[f64],
    at: &[f64],
    parameter: usize,
    share: f64,
    derivatives: &[Vec<f64>],
) -> f64 {
    let step = share * at[parameter];
    let moved = |sign: f64| {
        let mut parameters = at.to_vec();
        parameters[parameter] += sign * step;
        model.solve(&parameters, drive, times).unwrap()
    };
    let (more, less) = (moved(1.0), moved(-1.0));
    let mut fewest = f64::INFINITY;
    for (number, sensor) in model.rig.sensors.iter().enumerate() {
        let difference = |row: usize| (more.values[number][row] - less.values[number][row]) / (2.0 * step);
        let greatest = (0..times.len()).map(|row| difference(row).abs()).fold(0.0, f64::max);
        // A change below a thousandth of the noise per 1 % of the parameter is lost in rounding.
        if greatest * 0.01 * at[parameter] < 1e-3 * sensor.noise {
            continue;
        }
        let worst = (0..times.len()).map(|row| (difference(row) - derivatives[number][row]).abs()).fold(0.0, f64::max);
        fewest = fewest.min(-(worst / greatest).log10());
    }
    fewest
}

#[test]
fn dual_numbers_agree_with_differences() {
    for (path, ids, set, until) in [
        (
            TELESCOPIC,
            &[
                "fluid.bulk_modulus",
                "cylinder.clearance",
                "flow_control.orifice_diameter",
                "directional_valve.opening",
                "directional_valve.lag",
                "cylinder.viscous_friction",
            ][..],
            &[("cylinder.clearance", 0.15e-3), ("flow_control.orifice_diameter", 1.6e-3)][..],
            0.3,
        ),
        (
            "fixtures/press/rig.toml",
            &["meter_out.opening", "relief.set_pressure", "cylinder.mass", "pump.displacement"][..],
            &[][..],
            0.3,
        ),
        (
            "fixtures/two_tanks/rig.toml",
            &["upper_outlet.diameter", "pump.gain", "sensor.level_1.gain"][..],
            &[][..],
            0.3,
        ),
        // Its spool is at rest at its command to the last digit, in the middle of a dead zone of no width.
        (
            "fixtures/servo_axis/rig.toml",
            &["valve.gain", "valve.null", "valve.rated_flow"][..],
            &[("valve.null", 0.01)][..],
            1.8,
        ),
    ] {
        let model = model(Rig::read(path), 1e-10);
        let mut at = model.rig.nominal();
        for (id, value) in set {
            at[model.rig.parameter(id).unwrap()] = *value;
        }
        let drive = InputSignals::from_cycle(&model.rig, model.rig.cycle.as_ref().unwrap());
        let by: Vec<usize> = ids.iter().map(|id| model.rig.parameter(id).unwrap()).collect();
        // So many times the second phase, early enough that the end stop, whose stiffness makes differences coarse, is not reached.
        let times: Vec<f64> = (1..=100).map(|row| drive.pieces[1].end * until * f64::from(row) / 100.0).collect();
        let dual = model.sensitivities(&at, &by, &drive, &times).unwrap();
        for (index, &parameter) in by.iter().enumerate() {
            // A difference is spoilt by rounding if its step is short and by curvature if it is long: the better one counts.
            let fewest = [1e-3, 1e-4].map(|share| {
                digits_of_derivative(&model, &drive, &times, &at, parameter, share, &dual.derivatives[index])
            });
            let fewest = fewest.into_iter().fold(0.0, f64::max);
            println!("{}: {}: {fewest:.1} digits in the worst sensor", model.rig.name, ids[index]);
            assert!(fewest > 3.0 && fewest.is_finite());
        }
    }
}
