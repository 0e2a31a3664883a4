//! Why a text is no unit or no quantity, and what would be.

use std::fmt;

use super::split::split;
use super::{Dimension, Unit};

/// A text that is no unit, no quantity, or one of the wrong dimension. `Display` says what is wrong,
/// [`help`](Self::help) what would be right.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnitError {
    /// Nothing is written where a unit belongs.
    Empty,
    /// One word of the unit is not known.
    Unknown {
        /// The whole unit as written.
        unit: String,
        /// The word that is not known.
        word: String,
        /// The whole unit with the nearest known word in its place.
        nearest: Option<String>,
    },
    /// Two signs in a row, one at an end, an exponent that is no small integer, or brackets that do not match.
    Malformed {
        /// The whole unit as written.
        unit: String,
    },
    /// A product behind a quotient, which people read in two ways: `J/kg.K`.
    Ambiguous {
        /// The whole unit as written.
        unit: String,
    },
    /// A unit that measures something else.
    WrongDimension {
        /// The unit as written.
        unit: String,
        /// What it measures.
        found: Dimension,
        /// What is asked for.
        wanted: Dimension,
    },
    /// A number without a unit where a quantity with a dimension is asked for.
    MissingUnit {
        /// The number as written.
        number: String,
        /// What is asked for.
        wanted: Dimension,
    },
    /// A quantity that does not begin with a finite number.
    NotANumber {
        /// The text as written.
        text: String,
    },
}

impl UnitError {
    /// What would be right: one sentence without a full stop at its end.
    pub fn help(&self) -> String {
        match self {
            Self::Empty => "write a unit, such as `bar` or `L/min`; `-` for a pure number".to_owned(),
            Self::Unknown { unit, .. } if unit.contains(['(', ')']) => {
                "units have no brackets: `N.s/m` is N per m/s".to_owned()
            }
            Self::Unknown { nearest: Some(nearest), .. } => match Unit::parse(nearest) {
                Ok(unit) => format!("did you mean `{nearest}`? Units of {}: {}", unit.dimension, list(unit.dimension)),
                Err(_) => format!("did you mean `{nearest}`?"),
            },
            Self::Unknown { .. } => {
                "units are products and quotients of known ones, such as `bar`, `L/min`, `mm`, `N.s/m` or `degC`; \
                 `-` for a pure number"
                    .to_owned()
            }
            Self::Malformed { .. } => "write units as `L/min`, `N.s/m`, `kg/m3` or `m/s2`".to_owned(),
            Self::Ambiguous { unit } => {
                let (head, tail) = unit.split_once('/').unwrap_or((unit, ""));
                let divided = tail.replace(['.', '*', '·', ' '], "/");
                format!(
                    "to divide by every factor write `{head}/{divided}`; to multiply, move the factor before the `/`"
                )
            }
            Self::WrongDimension { wanted, .. } => {
                format!("units of {wanted}: {}", list(*wanted))
            }
            Self::MissingUnit { number, wanted } => match Unit::known_for(*wanted).first() {
                Some(unit) => format!("write for example `{number} {unit}`; units of {wanted}: {}", list(*wanted)),
                None => format!("write it in {}", wanted.base_units()),
            },
            Self::NotANumber { text } => match with_decimal_point(text) {
                Some(better) => format!("the decimal mark is a point: `{better}`"),
                None => "write a number and its unit, such as `5 mm` or `18.5 bar`".to_owned(),
            },
        }
    }
}

/// The text with its one comma as a point, where that makes it a quantity.
fn with_decimal_point(text: &str) -> Option<String> {
    let better = text.replacen(',', ".", 1);
    let is_quantity = |text: &str| split(text).is_some_and(|(_, unit)| unit.is_empty() || Unit::parse(unit).is_ok());
    (better != text && is_quantity(&better)).then_some(better)
}

fn list(dimension: Dimension) -> String {
    let known = Unit::known_for(dimension);
    if known.is_empty() {
        return format!("`{}`", dimension.base_units());
    }
    let quoted: Vec<String> = known.iter().map(|symbol| format!("`{symbol}`")).collect();
    quoted.join(", ")
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the unit is missing"),
            Self::Unknown { unit, word, .. } if unit == word => write!(f, "unknown unit `{unit}`"),
            Self::Unknown { unit, word, .. } => write!(f, "unknown unit `{word}` in `{unit}`"),
            Self::Malformed { unit } => write!(f, "`{unit}` is not a unit"),
            Self::Ambiguous { unit } => {
                write!(f, "`{unit}` can be read in two ways: a product follows a `/`")
            }
            Self::WrongDimension { unit, found, wanted } => write!(f, "`{unit}` is a unit of {found}, not of {wanted}"),
            Self::MissingUnit { number, wanted } => {
                write!(f, "`{number}` has no unit, but needs one of {wanted}")
            }
            Self::NotANumber { text } => write!(f, "`{text}` does not begin with a finite number"),
        }
    }
}

impl std::error::Error for UnitError {}
