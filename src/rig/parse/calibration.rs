//! What calibration has written: values, their correlation, noise and tolerance of sensors.

use nalgebra::DMatrix;

use super::difference;
use crate::complaint::{Complaint, Kind, help_with_names};
use crate::rig::scaling::Scaling;
use crate::rig::source::{Table, Value};
use crate::rig::{Calibration, Rig, range};

pub(super) fn read_calibration(rig: &mut Rig, value: &Value<'_>) -> Result<(), Complaint> {
    let table = value.table("`[calibration]`")?;
    let mut records = Vec::new();
    if let Some(list) = table.get("records") {
        for record in list.list()? {
            records.push(record.text()?.to_owned());
        }
    }
    let mut margins = Vec::new();
    if let Some(list) = table.get("margins") {
        for margin in list.list()? {
            let id = margin.text()?;
            rig.give_margin(id).map_err(|mut complaint| {
                complaint.places = vec![margin.place()];
                complaint
            })?;
            margins.push(id.to_owned());
        }
    }
    let mut parameters = Vec::new();
    if let Some(values) = table.get("values") {
        for (id, value) in values.table("`[calibration.values]`")?.entries() {
            parameters.push(read_value(rig, id, &value)?);
        }
    }
    let mut dynamics = Vec::new();
    if let Some(values) = table.get("dynamics") {
        for (id, value) in values.table("`[calibration.dynamics]`")?.entries() {
            dynamics.push(read_value(rig, id, &value)?);
        }
    }
    let correlation = read_correlation(&table, parameters.len())?;
    if let Some(sensors) = table.get("sensors") {
        for (name, value) in sensors.table("`[calibration.sensors]`")?.entries() {
            read_sensor(rig, name, &value)?;
        }
    }
    table.finish()?;
    rig.calibration = Some(Calibration { records, margins, dynamics, parameters, correlation });
    Ok(())
}

/// Relative difference of a number that has been written in another unit.
const ROUNDING: f64 = 1e-9;

fn read_value(rig: &mut Rig, id: &str, value: &Value<'_>) -> Result<usize, Complaint> {
    let Some(index) = rig.parameter(id) else {
        return Err(Complaint::new(Kind::UnknownName, format!("calibrated `{id}`, which is no parameter of this rig"))
            .at(value.place())
            .help(rig.help_with_parameters(id)));
    };
    let scaled = rig.sensors.iter().find(|sensor| sensor.first_parameter == index);
    let scaled = scaled.and_then(|offset| offset.scale.clone());
    let parameter = &mut rig.parameters[index];
    let own = parameter.unit.dimension;
    // The zero of a scaled sensor stands in what it writes, or, where the rig file states it so, in what it means.
    let (dimension, factor) = Scaling::of_column(scaled.as_ref(), own);
    let (mut stated, factor) = match value.stated(dimension) {
        Ok(stated) => (stated, factor),
        Err(error) => (value.stated(own).map_err(|_| error)?, 1.0),
    };
    stated.value *= factor;
    stated.sigma = stated.sigma.map(|sigma| sigma * factor);
    let (low, high) = parameter.bounds;
    if !(low..=high).contains(&stated.value) {
        return Err(Complaint::new(Kind::Bounds, format!("{} is outside its physical bounds", value.what))
            .at(value.place())
            .help(format!("{}: {}", parameter.meaning, range(parameter.bounds, &parameter.unit))));
    }
    (parameter.value, parameter.place) = (stated.value, value.place());
    if let Some(sigma) = stated.sigma {
        parameter.sigma = sigma;
    }
    let unit = parameter.unit.clone();
    if let Some(fault) = rig.faults.iter_mut().find(|fault| fault.parameter == index) {
        let (low, high) = fault.bounds;
        // In another unit a value at its bound is rounded otherwise.
        let within = stated.value.clamp(low, high);
        if (stated.value - within).abs() > ROUNDING * within.abs() {
            return Err(Complaint::new(
                Kind::Bounds,
                format!("{} is outside the range that its fault is searched in", value.what),
            )
            .at(value.place())
            .at(fault.place.clone())
            .help(format!("it is searched {}", range(fault.bounds, &unit))));
        }
        fault.healthy = within;
    }
    Ok(index)
}

/// The lower triangle, one row per value, the diagonal included; without it the values are independent.
fn read_correlation(table: &Table<'_>, count: usize) -> Result<DMatrix<f64>, Complaint> {
    let mut correlation = DMatrix::identity(count, count);
    let Some(value) = table.get("correlation") else { return Ok(correlation) };
    let shape = |value: &Value<'_>, what: String| {
        Complaint::new(Kind::Shape, what)
            .at(value.place())
            .help(format!("write the lower triangle for {count} values: one row each, the last entry of a row 1"))
    };
    let rows = value.list()?;
    if rows.len() != count {
        return Err(shape(&value, format!("{} has {} rows", value.what, rows.len())));
    }
    for (i, row) in rows.iter().enumerate() {
        let entries = row.list()?;
        if entries.len() != i + 1 {
            return Err(shape(row, format!("row {} of {} has {} entries", i + 1, value.what, entries.len())));
        }
        for (j, entry) in entries.iter().enumerate() {
            let r = entry.quantity(crate::units::Dimension::NONE)?.value;
            (correlation[(i, j)], correlation[(j, i)]) = (r, r);
        }
    }
    let unit = (0..count).all(|i| correlation[(i, i)] == 1.0);
    if !unit || correlation.clone().cholesky().is_none() {
        return Err(Complaint::new(Kind::Contradiction, format!("{} is no correlation matrix", value.what))
            .at(value.place())
            .help("its diagonal is 1 and it is positive definite; let `borescope calibrate` write it"));
    }
    Ok(correlation)
}

fn read_sensor(rig: &mut Rig, name: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let table = value.table(format!("calibrated sensor `{name}`"))?;
    let names: Vec<String> = rig.sensors.iter().map(|sensor| sensor.name.clone()).collect();
    let Some(sensor) = rig.sensors.iter_mut().find(|sensor| sensor.name == name) else {
        return Err(Complaint::new(
            Kind::UnknownName,
            format!("calibrated sensor `{name}`, which the rig does not have"),
        )
        .at(value.place())
        .help(help_with_names(name, "sensors", names.iter().map(String::as_str))));
    };
    let (dimension, factor) = Scaling::of_column(sensor.scale.as_ref(), sensor.dimension);
    if let Some(noise) = table.get("noise") {
        let sigma = difference(&noise, dimension)? * factor;
        if sigma <= 0.0 {
            return Err(Complaint::new(Kind::Bounds, format!("{} is not positive", noise.what))
                .at(noise.place())
                .help("give one standard deviation of a sample"));
        }
        (sensor.noise, sensor.stated_noise) = (sigma, sigma);
    }
    if let Some(tolerance) = table.get("tolerance") {
        sensor.tolerance = difference(&tolerance, dimension)? * factor;
        sensor.tolerance_is_stated = true;
    }
    table.finish()
}
