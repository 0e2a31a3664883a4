//! A number with its unit, as a rig file gives it.

use std::fmt;
use std::str::FromStr;

use super::split::split;
use super::{Dimension, Unit, UnitError};

/// Fewer digits than an f64 holds, so that 0.3 mm comes back as 0.3 and not as 0.30000000000000004.
const SHOWN_DIGITS: usize = 12;

/// A value in SI, with the unit in which it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// In SI.
    pub value: f64,
    /// The unit of the text.
    pub unit: Unit,
}

impl Quantity {
    /// Reads `5 mm`, `18.5 bar`, `40 degC`, or a bare number, which is dimensionless.
    ///
    /// # Errors
    /// A text that does not begin with a finite number, and every error of [`Unit::parse`].
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let (number, unit) = Self::split(text)?;
        let unit = if unit.is_empty() { Unit::dimensionless() } else { Unit::parse(unit)? };
        Ok(Self { value: unit.to_si(number), unit })
    }

    /// Reads a quantity that must measure `wanted`.
    ///
    /// # Errors
    /// As [`parse`](Self::parse); also a unit of another dimension, or none where one is needed.
    pub fn parse_as(text: &str, wanted: Dimension) -> Result<Self, UnitError> {
        let (number, unit) = Self::split(text)?;
        let unit = match unit {
            "" if wanted == Dimension::NONE => Unit::dimensionless(),
            "" => {
                return Err(UnitError::MissingUnit { number: text.trim().to_owned(), wanted });
            }
            _ => Unit::parse_as(unit, wanted)?,
        };
        Ok(Self { value: unit.to_si(number), unit })
    }

    /// The value in its own unit.
    pub fn in_unit(&self) -> f64 {
        self.unit.from_si(self.value)
    }

    fn split(text: &str) -> Result<(f64, &str), UnitError> {
        split(text).ok_or_else(|| UnitError::NotANumber { text: text.trim().to_owned() })
    }
}

/// Writes the value in its own unit with at most 12 digits; no unit for a pure number.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.in_unit();
        let shown = format!("{value:.*e}", SHOWN_DIGITS - 1).parse::<f64>().unwrap_or(value);
        let magnitude = shown.abs();
        if magnitude != 0.0 && !(1e-5..1e12).contains(&magnitude) {
            write!(f, "{shown:e}")?;
        } else {
            write!(f, "{shown}")?;
        }
        if self.unit.symbol == "-" { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

impl FromStr for Quantity {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        Self::parse(text)
    }
}
