//! The table of `--curves`: what was measured beside what the models read, sample by sample.

use std::io::{self, Write};

use crate::number::in_unit;
use crate::record::Record;
use crate::rig::{Rig, Sensor};
use crate::units::Unit;

/// The curves of one record. Each model's readings are `[sensor][row]` in the order of the rig's sensors, SI; where a model
/// could not be solved they are empty, and its columns stay without values.
#[derive(Debug, Clone, Copy)]
pub struct Curves<'a> {
    /// The user's model.
    pub model: &'a [Vec<f64>],
    /// The model with the faults or effects that were found; the user's model where nothing was found.
    pub found: &'a [Vec<f64>],
}

/// The columns that each sensor has in the table.
const COLUMNS: [&str; 5] = ["measured", "model", "found", "sigma", "misfit"];

impl Curves<'_> {
    /// Writes the table as CSV: `time [s]`, then for each sensor `NAME.measured`, `NAME.model`, `NAME.found`, `NAME.sigma` in
    /// the unit of the sensor, and `NAME.misfit`, measured minus found over sigma, which has no unit.
    /// A cell without a sample is empty.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_csv(&self, rig: &Rig, record: &Record, to: &mut dyn Write) -> io::Result<()> {
        let mut table = csv::Writer::from_writer(to);
        table.write_record(header(rig))?;
        let measured: Vec<Option<&[f64]>> = rig
            .sensors
            .iter()
            .map(|sensor| record.channel(&sensor.column).map(|channel| channel.values.as_slice()))
            .collect();
        let units: Vec<Unit> = rig.sensors.iter().map(|sensor| rig.sensor_unit(sensor)).collect();
        for (row, time) in record.time.iter().enumerate() {
            table.write_field(in_unit(*time, &Unit::second()).to_string())?;
            for (index, sensor) in rig.sensors.iter().enumerate() {
                let at = |curves: &[Vec<f64>]| curves.get(index).and_then(|curve| curve.get(row)).copied();
                let sample = Sample {
                    measured: measured[index].and_then(|values| values.get(row)).copied(),
                    model: at(self.model),
                    found: at(self.found),
                };
                for cell in sample.cells(sensor, &units[index]) {
                    table.write_field(cell)?;
                }
            }
            table.write_record(None::<&[u8]>)?;
        }
        table.flush()
    }
}

fn header(rig: &Rig) -> Vec<String> {
    let mut names = vec!["time [s]".to_owned()];
    for sensor in &rig.sensors {
        let unit = rig.sensor_unit(sensor).symbol;
        names.extend(COLUMNS.iter().map(|column| {
            let unit = if *column == "misfit" { "-" } else { &unit };
            format!("{}.{column} [{unit}]", sensor.name)
        }));
    }
    names
}

/// One row of one sensor, SI; `None` or NaN where there is nothing.
struct Sample {
    measured: Option<f64>,
    model: Option<f64>,
    found: Option<f64>,
}

impl Sample {
    /// The cells of [`COLUMNS`]. A row in which nothing was measured has no sigma and no misfit.
    fn cells(&self, sensor: &Sensor, unit: &Unit) -> [String; COLUMNS.len()] {
        let there = |value: Option<f64>| value.filter(|value| value.is_finite());
        let sigma = there(self.measured).map(|_| sensor.variance().sqrt());
        let misfit = there(self.measured).zip(there(self.found)).zip(sigma);
        let misfit = misfit.map(|((measured, found), sigma)| (measured - found) / sigma);
        let value = |si: Option<f64>| there(si).map_or_else(String::new, |si| in_unit(si, unit).to_string());
        [
            value(self.measured),
            value(self.model),
            value(self.found),
            sigma.map_or_else(String::new, |sigma| crate::number::difference_in_unit(sigma, unit).to_string()),
            there(misfit).map_or_else(String::new, |misfit| crate::number::rounded(misfit, 6).to_string()),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_misfit_is_measured_minus_found_over_sigma() {
        let rig = Rig::read("fixtures/two_tanks/rig.toml").unwrap();
        let names: Vec<String> = rig.sensors.iter().map(|sensor| sensor.column.clone()).collect();
        let channel = |name: &String| crate::record::Channel::new(name, Unit::parse("m").unwrap(), vec![0.5, f64::NAN]);
        let record = Record::new("in.csv", vec![0.0, 1.0], names.iter().map(channel).collect());
        let readings = |value: f64| vec![vec![value; 2]; rig.sensors.len()];
        let (model, found) = (readings(0.4), readings(0.499));
        let mut written = Vec::new();
        Curves { model: &model, found: &found }.write_csv(&rig, &record, &mut written).unwrap();
        let text = String::from_utf8(written).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let unit = &rig.sensor_unit(&rig.sensors[0]);
        assert_eq!(
            rows[0][..3],
            [
                "time [s]".to_owned(),
                format!("{}.measured [{unit}]", rig.sensors[0].name),
                format!("{}.model [{unit}]", rig.sensors[0].name)
            ]
        );
        assert_eq!(rows.len(), 3);
        let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
        let sigma = rig.sensors[0].variance().sqrt();
        approx::assert_relative_eq!(number(1, 5), 0.001 / sigma, max_relative = 1e-5);
        approx::assert_relative_eq!(number(1, 4), unit.difference_from_si(sigma), max_relative = 1e-8);
        // Nothing was measured in the second row, yet both models read something.
        assert_eq!((rows[2][1], rows[2][4], rows[2][5]), ("", "", ""));
        assert_eq!(number(2, 3), unit.from_si(0.499));
    }
}
