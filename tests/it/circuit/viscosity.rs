//! Oil that gets thinner: the law against its worked number, the engine's derivatives against differences.

use approx::assert_relative_eq;
use borescope::Rig;
use borescope::Unit;
use borescope::internals::model::{InputSignals, Model, Tolerance};
use borescope::internals::physics::fluid::Fluid;
use borescope::internals::record::{Channel, Record};

const RIG: &str = "fixtures/telescopic/rig.toml";

/// The telescopic rig with a worn seal.
fn leaking() -> Model {
    let text = std::fs::read_to_string(RIG).unwrap().replace("clearance = \"0 mm\"", "clearance = \"0.2 mm\"");
    Model::new(Rig::parse(RIG, text).unwrap()).with_tolerance(Tolerance { relative: 1e-8, absolute: 1e-8 })
}

/// A stroke out under load while the oil warms up by so many kelvin in 2 s; without a temperature where `None`. The first row
/// speaks of the 4 ms before it: there the run begins.
fn stroke(warming: Option<f64>) -> Record {
    let time: Vec<f64> = (0..550).map(|row| f64::from(row) * 4e-3).collect();
    let column = |name: &str, unit: &str, value: &dyn Fn(f64) -> f64| {
        let unit: Unit = unit.parse().unwrap();
        Channel::new(name, unit.clone(), time.iter().map(|&t| unit.to_si(value(t))).collect())
    };
    let mut channels = vec![
        column("valve_command", "-", &|t| f64::from(u8::from(t > 0.5))),
        column("F_load", "N", &|_| 4000.0),
        column("p_A", "bar", &|_| 0.0),
    ];
    channels.extend(warming.map(|warming| column("T_oil", "degC", &|t| 40.0 + warming * (t + 4e-3) / 2.0)));
    Record::new("stroke", time, channels)
}

/// Readings of `x` with some values of parameters, and their derivative by the last of these.
fn positions(record: &Record, changed: &[(&str, f64)]) -> (Vec<f64>, Vec<f64>) {
    let model = leaking();
    let drive = InputSignals::from_record(&model.rig, record).unwrap();
    let mut values = model.rig.nominal();
    let index = |id: &str| model.rig.parameter(id).unwrap();
    for &(id, value) in changed {
        values[index(id)] = value;
    }
    let by: Vec<usize> = changed.last().map(|(id, _)| index(id)).into_iter().collect();
    let mut found = model.sensitivities(&values, &by, &drive, &record.time).unwrap();
    let x = model.rig.sensors.iter().position(|sensor| sensor.name == "x").unwrap();
    let derivatives = found.derivatives.pop().map_or_else(Vec::new, |mut by| by.swap_remove(x));
    (found.outputs.values.swap_remove(x), derivatives)
}

#[test]
fn fluidity_is_what_the_law_says() {
    let fluid = Fluid::new(&[870.0, 45.5e-3, 1.4e9, 0.0, 0.03, 0.0, 1.0]);
    assert_relative_eq!(fluid.fluidity(10.0, 100.0), 1.349_859, max_relative = 1e-6);
    assert_relative_eq!(
        Fluid::new(&[870.0, 45.5e-3, 1.4e9, 0.0, 0.0, 0.01, 1.0]).fluidity(10.0, 20.0),
        1.221_403,
        max_relative = 1e-6
    );
    assert_relative_eq!(Fluid::new(&[870.0, 45.5e-3, 1.4e9, 0.0, 0.0, 0.0, 1.0]).fluidity(10.0, 20.0), 1.0);
}

#[test]
fn warm_oil_leaks_more_and_a_record_without_temperature_is_at_the_reference() {
    let last = |record: &Record, k: f64| *positions(record, &[("fluid.temperature_coefficient", k)]).0.last().unwrap();
    let cold = last(&stroke(None), 0.03);
    assert_relative_eq!(cold, last(&stroke(Some(10.0)), 0.0), max_relative = 1e-9);
    // The gap passes 15 % more in the mean of the stroke, of a leak that takes about a third of the flow.
    let warm = last(&stroke(Some(10.0)), 0.03);
    assert!(warm < cold - 2e-3, "{warm} {cold}");
    // A drift of the same viscosity, the temperature not measured.
    let drifting = *positions(&stroke(None), &[("fluid.viscosity_drift", 0.15)]).0.last().unwrap();
    assert_relative_eq!(drifting, warm, max_relative = 1e-7);
}

#[test]
fn derivatives_are_those_of_the_simulation() {
    for (id, value, step, warming) in
        [("fluid.temperature_coefficient", 0.03, 1e-4, Some(10.0)), ("fluid.viscosity_drift", 0.05, 1e-4, None)]
    {
        let record = stroke(warming);
        let (_, slope) = positions(&record, &[(id, value)]);
        let (above, _) = positions(&record, &[(id, value + step)]);
        let (below, _) = positions(&record, &[(id, value - step)]);
        let last = slope.len() - 1;
        let difference = (above[last] - below[last]) / (2.0 * step);
        assert!(difference.abs() > 1e-3, "{id}: {difference}");
        assert_relative_eq!(slope[last], difference, max_relative = 1e-4);
    }
}

#[test]
fn a_window_goes_on_where_the_record_began() {
    let model = leaking();
    let record = stroke(None);
    let last = |late: f64, drift: f64| {
        let drive = InputSignals::from_record(&model.rig, &record).unwrap();
        let drive = InputSignals { begun: drive.begun - late, ..drive };
        let mut values = model.rig.nominal();
        values[model.rig.parameter("fluid.viscosity_drift").unwrap()] = drift;
        let x = model.rig.sensors.iter().position(|sensor| sensor.name == "x").unwrap();
        *model.solve(&values, &drive, &record.time).unwrap().values[x].last().unwrap()
    };
    assert_eq!(last(100.0, 0.0), last(0.0, 0.0));
    // A hundred seconds later the oil is 22 % thinner.
    assert!(last(100.0, 0.002) < last(0.0, 0.002) - 5e-3);
}

#[test]
fn a_temperature_that_is_needed_and_missing_is_told() {
    let text = std::fs::read_to_string(RIG).unwrap();
    let warm = "\n[effects]\n\"viscosity-temperature\" = { temperature_coefficient = \"0.03 1/K\" }\n";
    let needed = Rig::parse(RIG, text.clone() + warm).unwrap();
    let told = |rig: &Rig, warming| rig.at_odds(&stroke(warming)).iter().any(|odd| odd.contains("no `T_oil`"));
    assert!(told(&needed, None));
    assert!(!told(&needed, Some(5.0)));
    assert!(!told(&Rig::parse(RIG, text.clone()).unwrap(), None));
    // Without it nothing may be known of a temperature.
    let without: String =
        text.lines().filter(|line| !line.starts_with("temperature")).map(|line| format!("{line}\n")).collect();
    let complaint = Rig::parse(RIG, without + warm).unwrap_err();
    assert!(complaint.to_string().contains("cannot have the effect `viscosity-temperature`"), "{complaint}");
    let complaint = Rig::parse(RIG, text.replace(", noise = \"0.1 degC\"", "")).unwrap_err();
    assert!(complaint.to_string().contains("noise"), "{complaint}");
}
