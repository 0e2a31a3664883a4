//! Draws the pictures of the README: a diagnosis, and the error that falls when the missing effect is added.
//!
//!     cargo run --release --example readme_picture
//!
//! writes `docs/figures/series-1.svg` and `docs/figures/error-falls.svg`.

use std::error::Error;
use std::path::Path;

use borescope::Model;
use borescope::Record;
use borescope::Rig;
use borescope::internals::diagnosis::{DiagnosisOptions, diagnose};
use borescope::internals::files::write_atomically;
use borescope::internals::learn::improve::improve;
use borescope::internals::report::headline::headline;
use borescope::internals::report::plot::{Axis, Chart, Figure, Rule, Series};

const DIAGNOSIS: &str = "docs/figures/series-1.svg";
const IMPROVEMENT: &str = "docs/figures/error-falls.svg";
/// End of the first stroke out and back, s.
const END: f64 = 17.4;
/// Every so many rows is a dot.
const DOTS: usize = 40;
/// Shown of the record that decides whether an effect is added: one stroke out and back, s.
const CHECKED: f64 = 9.4;
/// The sensor whose misfit is shown.
const SENSOR: &str = "p_B";

fn main() -> Result<(), Box<dyn Error>> {
    diagnosis()?;
    improvement()
}

fn write(path: &str, figure: &Figure) -> Result<(), Box<dyn Error>> {
    let svg = figure.svg();
    write_atomically(Path::new(path), |out| out.write_all(svg.as_bytes()))?;
    println!("{path}: {}", figure.description);
    Ok(())
}

fn diagnosis() -> Result<(), Box<dyn Error>> {
    let model = Model::new(Rig::read("fixtures/telescopic/rig.toml")?);
    let record = Record::read("fixtures/telescopic/series_1.csv")?;
    let diagnosed = diagnose(&model, &record, &DiagnosisOptions::default())?;
    let rig = &model.rig;
    let rows = record.time.partition_point(|time| *time <= END);
    let mut panels = Vec::new();
    for (name, title) in [("p_A", "Pressure at the cap side of the cylinder"), ("x", "Position of the piston")] {
        let Some(index) = rig.sensors.iter().position(|sensor| sensor.name == name) else { continue };
        let unit = rig.sensor_unit(&rig.sensors[index]);
        let measured = &record.require(name, unit.dimension, rig.sensors[index].place.clone())?.values;
        let points = |values: &[f64], every: usize| -> Vec<(f64, f64)> {
            let shown = values.iter().map(|si| unit.from_si(*si));
            record.time.iter().copied().zip(shown).take(rows).step_by(every).collect()
        };
        let series = vec![
            Series::line("healthy model", points(&diagnosed.healthy[index], 1)).styled(2, 1),
            Series::line("model with the faults found", points(&diagnosed.model[index], 1)).styled(1, 0),
            Series::dots("measured", points(measured, DOTS)).styled(0, 0),
        ];
        panels.push(Chart::new(title, Axis::new("time", "s").over(0.0, END), Axis::new(name, &unit.symbol), series));
    }
    let what = format!("Series 1 of the telescopic circuit. {}", headline(&diagnosed.diagnosis));
    let mut figure = Figure::new("A diagnosis", what, panels);
    figure.panel_height = 240.0;
    write(DIAGNOSIS, &figure)
}

fn improvement() -> Result<(), Box<dyn Error>> {
    let rig = Rig::read("fixtures/telescopic/rig.toml")?;
    let [fit, check] = ["line_fit", "line_check"].map(|name| Record::read(format!("fixtures/learning/{name}.csv")));
    let (fit, check) = (fit?, check?);
    let found = improve(&rig, &fit, &check, |_| {})?;
    let sensor = rig.sensors.iter().position(|sensor| sensor.name == SENSOR).ok_or("no such sensor")?;
    let unit = rig.sensor_unit(&rig.sensors[sensor]);
    let noise = rig.sensors[sensor].noise;
    let measured = &check.require(SENSOR, unit.dimension, rig.sensors[sensor].place.clone())?.values;
    let rows = check.time.partition_point(|time| *time <= CHECKED);
    let along = |value: &dyn Fn(usize) -> f64, every: usize| -> Vec<(f64, f64)> {
        (0..rows).step_by(every).map(|row| (check.time[row], value(row))).collect()
    };
    let mut models = Vec::new();
    for (trial, step) in [(&found.given, found.steps.first()), (&found.trial, found.steps.last())] {
        let step = step.ok_or("no model was fitted")?;
        let name = step.added.as_ref().map_or_else(|| "your model".to_owned(), |added| format!("with {added}"));
        models.push((name, trial.check(&check)?));
    }
    let (mut pressures, mut misfits) = (Vec::new(), Vec::new());
    for (index, (name, run)) in models.iter().enumerate() {
        let model = &run.outputs[sensor];
        let (colour, dash) = (2 - index, 1 - index);
        pressures.push(Series::line(name, along(&|row| unit.from_si(model[row]), 1)).styled(colour, dash));
        let misfit = |row: usize| (measured[row] - model[row]) / noise;
        misfits.push(Series::line(format!("{name}: {:.1}", run.normalised), along(&misfit, 4)).styled(colour, dash));
    }
    pressures.push(Series::dots("measured", along(&|row| unit.from_si(measured[row]), 20)).styled(0, 0));
    let time = || Axis::new("time", "s").over(0.0, CHECKED);
    let mut misfit = Chart::new(
        "Misfit at this sensor, times its noise (legend: error over all sensors)",
        time(),
        Axis::new("misfit", "-"),
        misfits,
    );
    misfit.rules.push(Rule::Horizontal { y: 0.0, label: String::new() });
    let pressure = Axis::new(SENSOR, &unit.symbol);
    let pressure = Chart::new("Pressure at the rod side of the cylinder", time(), pressure, pressures);
    let error: Vec<String> = models.iter().map(|(name, run)| format!("{name} {:.2}", run.normalised)).collect();
    let what = format!("A record to which nothing is fitted. Error over the sensor noise: {}.", error.join(", "));
    let mut figure = Figure::new("The error falls", what, vec![pressure, misfit]);
    figure.panel_height = 240.0;
    write(IMPROVEMENT, &figure)
}
