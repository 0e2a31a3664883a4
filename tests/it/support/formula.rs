//! What the tests of formulas share.
#![allow(dead_code)]

use borescope::Unit;
use borescope::internals::expression::{Expression, ExpressionError, Name};

/// Names of the tests, with units that tell their dimensions.
pub const NAMES: [(&str, &str); 10] = [
    ("x", "-"),
    ("y", "-"),
    ("z", "-"),
    ("p_A", "Pa"),
    ("p_T", "Pa"),
    ("v", "m/s"),
    ("q", "m3/s"),
    ("k", "m3/s/Pa^0.5"),
    ("pump.speed", "1/s"),
    ("T", "K"),
];

pub fn names() -> Vec<Name> {
    NAMES.map(|(name, unit)| Name::new(name, Unit::parse(unit).unwrap().dimension)).to_vec()
}

pub fn read(text: &str) -> Expression {
    Expression::parse(text, &names())
        .unwrap_or_else(|error| panic!("{text}: at {}: {error}; {}", error.offset, error.help))
}

pub fn wrong(text: &str) -> ExpressionError {
    match Expression::parse(text, &names()) {
        Ok(expression) => panic!("{text} reads as {expression}"),
        Err(error) => error,
    }
}

/// x, y, z, p_A, p_T, v, q, k, pump.speed, T.
pub const AT: [f64; 10] = [0.3, 2.0, -1.5, 5e5, 1e5, 0.4, 2e-4, 3e-7, 25.0, 313.15];

#[track_caller]
pub fn near(text: &str, got: f64, wanted: f64) {
    assert!((got - wanted).abs() <= 4e-15 * wanted.abs(), "{text}: {got:e}, not {wanted:e}");
}
