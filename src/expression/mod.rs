//! Formulas of the user's own: arithmetic over named quantities with units, `k * (p_A - p_T) / (1 + v^2 / v0^2)`.
//!
//! A formula is read once, its dimensions are checked, and it becomes a short program that runs over any
//! [`Real`], so its derivatives are exact.
//!
//! | written | meaning | dimension |
//! |---|---|---|
//! | `1.5`, `2e-3` | a pure number | none |
//! | `[0.3 bar]`, `[-40 degC]` | a number with its unit; `degC` counts from absolute zero | of the unit |
//! | `dp`, `pump.speed` | a variable or parameter | its own |
//! | `a + b`, `a - b`, `-a` | sum, difference, negative | like terms |
//! | `a * b`, `a / b` | product, quotient | any |
//! | `a^2`, `a^-1`, `a^1.5`, `a^(1/3)` | power with a constant exponent from -16 to 16; binds more tightly than `-` | any whose power is whole or half |
//! | `sqrt(a)` | square root | any whose root is whole or half |
//! | `abs(a)` | magnitude | any |
//! | `exp(a)`, `ln(a)`, `sin(a)`, `cos(a)`, `tanh(a)` | the usual functions; angles in rad | none |
//! | `sign(a)`, `step(a)` | -1, 0, 1; and 0 below 0, otherwise 1 | any, gives none |
//! | `min(a, b)`, `max(a, b)` | the smaller, the larger | like ones |
//! | `root(a, w)` | square root of the magnitude with the sign of `a`, straight where `a` is small against `w`: `a / (a^2 + w^2)^0.25` | like ones whose root is whole or half |
//! | `table(a; 0: y0, 1: y1, ...)` | broken line through 2 to 32 knots at constant, growing places | of the heights |
//! | `curve(a; 0: y0, 1: y1, ...)` | smooth line through them that never overshoots (monotone cubic) | of the heights |
//!
//! The heights of `table` and `curve` are formulas themselves, mostly parameters; both hold their ends outside the knots.
//!
//! There are no loops, no definitions and no files, and length, nesting and size are limited
//! ([`MAX_BYTES`], [`MAX_NESTING`], [`MAX_NODES`]): a stranger's formula costs microseconds at worst.
//!
//! # Corners
//!
//! Derivatives are finite wherever the value is, up to the range of an `f64`:
//!
//! - A root, or another power that is not whole, is steeper than any number at 0. Where its argument is below 1e-24 (in
//!   SI) the slope is the one at 1e-24, and its own slope counts as 0. Values are exact.
//! - `abs` has the slope from the right at 0. `sign` and `step` have slope 0 everywhere, also where they jump.
//! - `min` and `max` of equals have the mean of both slopes. On a knot, `table` has the slope from the right.
//!
//! Where the formula has no value (root or logarithm of a negative number, `0 / 0`) the result is NaN or infinite, and so
//! may be the derivatives: the caller looks.

mod check;
mod display;
mod error;
mod interpolation;
mod lexer;
mod parse;
mod program;
mod schedule;
mod sheet;

pub use error::ExpressionError;
pub use schedule::Schedule;
pub use sheet::Sheet;

use std::sync::Arc;

use crate::numeric::Real;
use crate::units::{Dimension, Unit};
use program::Program;

/// Bytes of a formula, blanks not counted.
pub const MAX_BYTES: usize = 4096;
/// Numbers, names, operators and functions of a formula together.
pub const MAX_NODES: usize = 1000;
/// Brackets, functions and signs within each other.
pub const MAX_NESTING: usize = 64;
/// Intermediate values that wait for each other.
pub const MAX_WAITING: usize = 64;
/// Knots of one `table` or `curve`.
pub const MAX_KNOTS: usize = 32;

/// The names of the functions, as a formula writes them.
pub const FUNCTIONS: [&str; 14] =
    ["sqrt", "abs", "exp", "ln", "sin", "cos", "tanh", "sign", "step", "min", "max", "root", "table", "curve"];

/// A variable or parameter that a formula may use.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Name {
    /// Letters, digits and `_`, beginning with no digit; parts may be joined by points: `pump.speed`.
    pub name: String,
    /// What it measures; its values are in SI.
    pub dimension: Dimension,
}

impl Name {
    /// A name and what it measures.
    pub fn new(name: impl Into<String>, dimension: Dimension) -> Self {
        Self { name: name.into(), dimension }
    }
}

/// A formula whose dimensions are right. `Display` writes it with one spelling of blanks, brackets and numbers, which reads
/// as an equal expression.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    names: Vec<Name>,
    dimension: Dimension,
    program: Program,
}

/// A constant as it is written.
#[derive(Debug, Clone, PartialEq)]
struct Literal {
    written: f64,
    unit: Unit,
}

impl Literal {
    fn si(&self) -> f64 {
        self.unit.to_si(self.written)
    }
}

impl Expression {
    /// Reads a formula over `names`; see the [module](self) for what can be written.
    ///
    /// # Errors
    /// The first mistake: of spelling, an unknown name, quantities that do not fit together, a limit. Also names that no
    /// formula could write: a function's, one given twice, one with other signs than [`Name::name`] tells.
    ///
    /// ```
    /// use borescope::internals::expression::{Expression, Name};
    /// use borescope::internals::units::{Dimension, Unit};
    ///
    /// let names = [Name::new("dp", Dimension::PRESSURE), Name::new("k", Unit::parse("L/min/bar^0.5")?.dimension)];
    /// let flow = Expression::parse("k * sign(dp) * sqrt(abs(dp))", &names)?;
    /// assert_eq!(flow.dimension(), Dimension::FLOW);
    /// assert!((flow.evaluate(&[-4e4, 5e-7]) + 1e-4).abs() < 1e-18);
    ///
    /// let error = Expression::parse("k * sqrt(dp) + dp", &names).unwrap_err();
    /// assert_eq!(error.to_string(), "cannot add pressure (`dp`) to flow (`k * sqrt(dp)`)");
    /// assert_eq!(error.offset, 13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parse(text: &str, names: &[Name]) -> Result<Self, ExpressionError> {
        Self::parse_with(text, names, &[])
    }

    /// Reads a formula that may also call tables by their names.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn parse_with(text: &str, names: &[Name], sheets: &[Arc<Sheet>]) -> Result<Self, ExpressionError> {
        let (program, dimension) = parse::parse(text, names, sheets)?;
        Ok(Self { names: names.to_vec(), dimension, program })
    }

    /// That the formula measures `wanted`; `text` is what it was read from.
    ///
    /// # Errors
    /// A formula of another dimension.
    pub(crate) fn check(self, text: &str, wanted: Dimension) -> Result<Self, ExpressionError> {
        check::whole(text, self.dimension, wanted)?;
        Ok(self)
    }

    /// Reads a formula that must measure `wanted`.
    ///
    /// # Errors
    /// As [`parse`](Self::parse); also a formula of another dimension.
    pub fn parse_as(text: &str, names: &[Name], wanted: Dimension) -> Result<Self, ExpressionError> {
        Self::parse(text, names)?.check(text, wanted)
    }

    /// What the formula measures.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// The names it was read with, in the order of the values.
    pub fn names(&self) -> &[Name] {
        &self.names
    }

    /// Numbers, names, operators and functions of the formula together: what one evaluation costs.
    pub fn size(&self) -> usize {
        self.program.ops().len()
    }

    /// Whether the formula names `names()[index]` at all.
    pub fn uses(&self, index: usize) -> bool {
        self.program.uses(index)
    }

    /// The value in SI at `values`, in SI and in the order of the names. Nothing is allocated.
    ///
    /// # Panics
    /// With fewer values than names.
    pub fn evaluate<T: Real>(&self, values: &[T]) -> T {
        assert!(values.len() >= self.names.len(), "{} values for {} names", values.len(), self.names.len());
        self.program.evaluate(values)
    }
}
