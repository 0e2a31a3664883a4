//! Units of measurement as data: SI inside, bar, L/min, mm and degC at the edge.
//!
//! A pressure unit says nothing about its zero: whether a sensor reads gauge or absolute pressure is a matter of the rig.

mod dimension;
mod error;
mod parse;
mod quantity;
mod split;
mod table;

use std::fmt;
use std::str::FromStr;

pub use dimension::Dimension;
pub use error::UnitError;
pub use quantity::Quantity;

/// A unit: `SI value = written value * factor + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// As the user wrote it, and as it is written back.
    pub symbol: String,
    /// What it measures.
    pub dimension: Dimension,
    /// SI units in one of this unit.
    pub factor: f64,
    /// The SI value of this unit's zero: 273.15 for `degC`, otherwise 0.
    pub offset: f64,
}

impl Unit {
    /// Reads a unit: a known word (`bar`, `mm`, `degC`, `%`, `-`), or a product and quotient of powers of them (`L/min/bar`,
    /// `N.s/m`, `N*s/m`, `N s/m`, `kg/m3`, `s-1`), half powers too (`L/min/bar^0.5`). `rev` counts as 1. Within a compound
    /// `degC` is a difference.
    ///
    /// # Errors
    /// A word that is not known, a text that is no unit, and a product behind a `/` (`J/kg.K`), which is ambiguous.
    ///
    /// ```
    /// use borescope::internals::units::{Dimension, Unit};
    /// let unit = Unit::parse("L/min")?;
    /// assert_eq!(unit.dimension, Dimension::FLOW);
    /// assert_eq!(unit.to_si(60.0), 1e-3);
    /// # Ok::<(), borescope::internals::units::UnitError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        parse::parse(text)
    }

    /// Reads a unit that must measure `wanted`.
    ///
    /// # Errors
    /// As [`parse`](Self::parse); also a unit of another dimension.
    pub fn parse_as(text: &str, wanted: Dimension) -> Result<Self, UnitError> {
        let unit = Self::parse(text)?;
        if unit.dimension == wanted {
            Ok(unit)
        } else {
            Err(UnitError::WrongDimension { unit: unit.symbol, found: unit.dimension, wanted })
        }
    }

    /// The unit of a pure number, `-`.
    pub fn dimensionless() -> Self {
        Self { symbol: "-".to_owned(), dimension: Dimension::NONE, factor: 1.0, offset: 0.0 }
    }

    /// The second, the unit of time in records.
    pub fn second() -> Self {
        Self { symbol: "s".to_owned(), dimension: Dimension::TIME, factor: 1.0, offset: 0.0 }
    }

    /// The usual units of a dimension, for messages; the usual ones first.
    pub fn known_for(dimension: Dimension) -> Vec<&'static str> {
        let atoms = table::ATOMS.iter().filter(|atom| atom.dimension == dimension).map(|atom| atom.symbol);
        let compounds = table::COMPOUNDS
            .iter()
            .copied()
            .filter(|symbol| parse::parse(symbol).is_ok_and(|compound| compound.dimension == dimension));
        atoms.chain(compounds).collect()
    }

    /// Spellings that are read besides the usual one, each with the symbol that it stands for.
    pub fn spellings() -> &'static [(&'static str, &'static str)] {
        table::SPELLINGS
    }

    /// A value in this unit, in SI.
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.factor + self.offset
    }

    /// An SI value, in this unit.
    pub fn from_si(&self, si: f64) -> f64 {
        (si - self.offset) / self.factor
    }

    /// A difference, such as a standard deviation, in SI: 2 degC are 2 K.
    pub fn difference_to_si(&self, difference: f64) -> f64 {
        difference * self.factor
    }

    /// A difference in SI, in this unit.
    pub fn difference_from_si(&self, si: f64) -> f64 {
        si / self.factor
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.symbol)
    }
}

impl FromStr for Unit {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        Self::parse(text)
    }
}
