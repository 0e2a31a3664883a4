//! Columns that hold another quantity, or the quantity at another zero, scale or sign.

use super::Rig;
use super::source::Value;
use crate::complaint::{Complaint, Kind};
use crate::record::{Asked, Channel, Record};
use crate::units::{Dimension, Quantity, Unit};

/// What a column of a record stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    /// In which the rig file describes the column.
    pub raw: Unit,
    /// The same as a unit of the quantity: negative where the column counts the other way, its zero where the quantity's is not.
    pub unit: Unit,
}

impl Scaling {
    /// From `1 cm/V`, or `-200 N/V` with what the column shows at zero; from `1450 rev/min` of a column without unit.
    pub(super) fn read(value: &Value<'_>, dimension: Dimension, zero: Option<&Value<'_>>) -> Result<Self, Complaint> {
        let text = value.text()?;
        let wrong = || {
            Complaint::new(Kind::Unit, format!("{} is `{text}`", value.what)).at(value.place()).help(
                "write what one unit of the column stands for, the column's unit behind the last `/`: `1 cm/V`, `36.65 mm/s/rpm` of a \
                 speed in rpm, or `1450 rev/min` of a column without unit",
            )
        };
        let per_unit = |(number, raw): (&str, &str)| {
            Some((Quantity::parse_as(number, dimension).ok()?, Unit::parse(raw.trim()).ok()?))
        };
        let whole = || Some((Quantity::parse_as(text, dimension).ok()?, Unit::dimensionless()));
        let (stands, raw) = text.rsplit_once('/').and_then(per_unit).or_else(whole).ok_or_else(wrong)?;
        let factor = stands.unit.difference_to_si(stands.in_unit());
        if factor == 0.0 || !factor.is_finite() {
            return Err(wrong());
        }
        let zero = zero.map(|zero| zero.quantity(raw.dimension)).transpose()?;
        let offset = zero.map_or(0.0, |zero| -factor * raw.from_si(zero.value));
        let unit = Unit { symbol: raw.symbol.clone(), dimension, factor, offset };
        Ok(Self { raw, unit })
    }

    /// Of a column that holds the quantity itself, but shows `zero` where that is 0.
    pub(super) fn shifted(unit: &Unit, zero: &Value<'_>) -> Result<Self, Complaint> {
        let zero = zero.quantity(unit.dimension)?;
        let offset = -unit.difference_to_si(zero.in_unit());
        Ok(Self { raw: unit.clone(), unit: Unit { offset: unit.offset + offset, ..unit.clone() } })
    }

    /// The dimension in which the rig file describes a column of a quantity, and the factor from there to the quantity.
    pub(super) fn of_column(scale: Option<&Self>, dimension: Dimension) -> (Dimension, f64) {
        scale.map_or((dimension, 1.0), |scale| (scale.raw.dimension, scale.size()))
    }

    /// The unit in which the rig file describes differences of the column, as one of the quantity.
    pub(crate) fn of_differences(&self) -> Unit {
        Unit { factor: self.unit.factor.abs(), offset: 0.0, symbol: self.raw.symbol.clone(), ..self.unit.clone() }
    }

    /// The size of one SI unit of the column, in SI units of the quantity.
    pub(super) fn size(&self) -> f64 {
        (self.unit.factor / self.raw.factor).abs()
    }

    fn apply(&self, channel: &mut Channel) {
        channel.values.iter_mut().for_each(|value| *value = self.unit.to_si(self.raw.from_si(*value)));
        channel.unit = self.unit.clone();
    }
}

impl Rig {
    /// Whether a sensor or an input reads this column.
    pub(crate) fn reads(&self, column: &str) -> bool {
        let sensors = self.sensors.iter().map(|sensor| &sensor.column);
        sensors.chain(self.inputs.iter().map(|input| &input.column)).any(|own| own == column)
    }

    /// What the rig asks of a record: its columns, with the units that its file tells.
    pub(crate) fn asked(&self) -> Asked {
        let sensors = self.sensors.iter().map(|sensor| {
            let scaled = sensor.scale.as_ref().map(|scale| scale.raw.clone());
            (sensor.column.clone(), scaled.or_else(|| sensor.column_unit.clone()))
        });
        let inputs = self.inputs.iter().map(|input| {
            let unit = input.scale.as_ref().map_or(&input.unit, |scale| &scale.raw);
            (input.column.clone(), Some(unit.clone()))
        });
        let temperature = self
            .temperature
            .iter()
            .map(|temperature| (temperature.input.column.clone(), Some(temperature.input.unit.clone())));
        Asked::new(sensors.chain(inputs).chain(temperature))
    }

    /// The record with the columns of scaled sensors and inputs as what they stand for.
    pub fn scaled(&self, mut record: Record) -> Record {
        let sensors = self.sensors.iter().map(|sensor| (&sensor.column, &sensor.scale));
        let inputs = self.inputs.iter().map(|input| (&input.column, &input.scale));
        let scalings: Vec<(&String, &Scaling)> =
            sensors.chain(inputs).filter_map(|(column, scale)| Some((column, scale.as_ref()?))).collect();
        for channel in &mut record.channels {
            let own = |(column, scale): &&(&String, &Scaling)| {
                **column == channel.name && scale.raw.dimension == channel.unit.dimension
            };
            if let Some((_, scale)) = scalings.iter().find(own) {
                scale.apply(channel);
            }
        }
        record
    }
}

#[cfg(test)]
mod tests {
    use crate::record::{Channel, Record};
    use crate::rig::Rig;
    use crate::units::Unit;

    #[test]
    fn a_column_without_unit_stands_for_a_quantity() {
        let text = include_str!("../../fixtures/telescopic/rig.toml");
        let stated = "noise = \"15 N\"";
        assert_eq!(text.matches(stated).count(), 1);
        let rig = Rig::parse("rig.toml", text.replace(stated, "scale = \"1.5 kN\"")).unwrap();
        let column = Channel::new("F_load".to_owned(), Unit::dimensionless(), vec![0.0, 1.0]);
        let record = Record::new("on.csv", vec![0.0, 1.0], vec![column]);
        approx::assert_relative_eq!(
            rig.scaled(record).channel("F_load").unwrap().values[1],
            1500.0,
            max_relative = 1e-12
        );
    }
}
