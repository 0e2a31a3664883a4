//! Draws the picture of the README: series 1, measured, beside the healthy and the fitted model, over its first stroke.
//!
//!     cargo run --release --example readme_picture
//!
//! writes `docs/figures/series-1.svg`.

use std::error::Error;
use std::path::Path;

use borescope::diagnosis::{Options, diagnose};
use borescope::files::write_atomically;
use borescope::model::Model;
use borescope::record::Record;
use borescope::report::diagnosis::headline;
use borescope::report::plot::{Axis, Chart, Figure, Series};
use borescope::rig::Rig;

const PICTURE: &str = "docs/figures/series-1.svg";
/// End of the first stroke out and back, s.
const END: f64 = 17.4;
/// Every so many rows is a dot.
const DOTS: usize = 40;

fn main() -> Result<(), Box<dyn Error>> {
    let model = Model::new(Rig::read("fixtures/telescopic/rig.toml")?);
    let record = Record::read("fixtures/telescopic/series_1.csv")?;
    let diagnosed = diagnose(&model, &record, &Options::default())?;
    let rig = &model.rig;
    let rows = record.time.partition_point(|time| *time <= END);
    let mut panels = Vec::new();
    for (name, title) in [("p_A", "Pressure at the big side"), ("x", "Position of the piston")] {
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
    let svg = figure.svg();
    write_atomically(Path::new(PICTURE), |out| out.write_all(svg.as_bytes()))?;
    println!("{PICTURE}: {}", headline(&diagnosed.diagnosis));
    Ok(())
}
