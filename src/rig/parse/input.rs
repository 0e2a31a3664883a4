//! Inputs: what drives the circuit.

use super::{difference, named};
use crate::complaint::{Complaint, Kind};
use crate::physics::card::Role;
use crate::rig::source::Value;
use crate::rig::{Hold, Input, Parameter, Rig, Scaling, Temperature};
use crate::units::{Dimension, Unit};

pub(super) fn read_inputs(rig: &mut Rig, inputs: Option<Value<'_>>) -> Result<(), Complaint> {
    let Some(inputs) = inputs else { return Ok(()) };
    for (name, value) in inputs.table("`[inputs]`")?.named_entries()? {
        let table = value.table(format!("input `{name}`"))?;
        let unit = table.require("unit", "add the unit of the column, such as `unit = \"N\"`")?;
        let place = unit.place();
        let unit = Unit::parse(unit.text()?)
            .map_err(|error| Complaint::new(Kind::Unit, error.to_string()).at(place).help(error.help()))?;
        let hold = match table.get("hold") {
            None => Hold::After,
            Some(value) => named(&value, "ways to hold", Hold::NAMED)?,
        };
        let scale = match table.get("scale") {
            None => table.get("offset").map(|zero| Scaling::shifted(&unit, &zero)).transpose()?,
            Some(value) => Some(Scaling::read(&value, unit.dimension, table.get("offset").as_ref())?),
        };
        // A scaled input is described in what its column holds.
        let (dimension, size) =
            scale.as_ref().map_or((unit.dimension, 1.0), |scale| (scale.raw.dimension, scale.size()));
        let noise = match table.get("noise") {
            None => 0.0,
            Some(value) => difference(&value, dimension)? * size,
        };
        let column = table.get("column").map(|column| column.name()).transpose()?.unwrap_or(name).to_owned();
        let dead_time = table.get("dead_time").map(|value| read_dead_time(rig, (name, hold), &value)).transpose()?;
        table.finish()?;
        let (name, place) = (name.to_owned(), value.place());
        rig.inputs.push(Input { name, column, unit, scale, hold, noise, dead_time, place });
    }
    Ok(())
}

/// A time that does not run backwards, as a parameter of the rig: its index. Where commands switch each switching may have another; where
/// an input runs straight from row to row nothing switches, and it is one value.
fn read_dead_time(rig: &mut Rig, (input, hold): (&str, Hold), value: &Value<'_>) -> Result<usize, Complaint> {
    let stated = value.stated(Dimension::TIME)?;
    if stated.value < 0.0 {
        return Err(Complaint::new(Kind::Bounds, "an input cannot act before its column says so").at(value.place()).help(
            "write 0 s or more, such as `dead_time = \"3 ms\"`; a logger that is late itself is put right in the record",
        ));
    }
    let sigma = stated.sigma.unwrap_or(0.0);
    rig.parameters.push(Parameter {
        id: format!("input.{input}.dead_time"),
        unit: stated.unit,
        value: stated.value,
        bounds: (0.0, f64::INFINITY),
        sigma,
        per_event: hold != Hold::Linear,
        role: Role::DeadTime,
        spread: sigma,
        meaning: format!("by how much later than its column says `{input}` acts"),
        place: value.place(),
    });
    Ok(rig.parameters.len() - 1)
}

/// Where records tell the temperature of the fluid: `{ column = "T_oil", reference = "40 degC", noise = "0.1 degC" }`.
pub(super) fn read_temperature(value: &Value<'_>) -> Result<Temperature, Complaint> {
    let table = value.table("`temperature` of the fluid")?;
    let column =
        table.require("column", "add the column of the record, such as `column = \"T_oil\"`")?.name()?.to_owned();
    let reference =
        table.require("reference", "add the temperature of the viscosity, such as `reference = \"40 degC\"`")?;
    let reference = reference.quantity(Dimension::TEMPERATURE)?;
    let noise = table.require("noise", "add one standard deviation of a reading, such as `noise = \"0.1 degC\"`")?;
    let (place, noise) = (noise.place(), difference(&noise, Dimension::TEMPERATURE)?);
    if noise == 0.0 {
        return Err(Complaint::new(Kind::Bounds, "a thermometer without noise")
            .at(place)
            .help("write a standard deviation above 0, half a digit of the logger at least"));
    }
    table.finish()?;
    let (name, unit, place) = (column.clone(), reference.unit.clone(), value.place());
    let input = Input { name, column, unit, scale: None, hold: Hold::Linear, noise, dead_time: None, place };
    Ok(Temperature { input, reference: reference.value })
}
