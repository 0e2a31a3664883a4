//! The units that have a symbol of their own, and the usual compounds of them.

use super::Dimension;

/// A unit that is written as one word.
#[derive(Debug, Clone, Copy)]
pub(super) struct Atom {
    pub symbol: &'static str,
    pub dimension: Dimension,
    pub factor: f64,
    pub offset: f64,
}

const fn atom(symbol: &'static str, dimension: Dimension, factor: f64) -> Atom {
    Atom { symbol, dimension, factor, offset: 0.0 }
}

/// Usual ones first within a dimension: lists in messages keep this order.
pub(super) const ATOMS: &[Atom] = &[
    atom("-", Dimension::NONE, 1.0),
    atom("%", Dimension::NONE, 1e-2),
    atom("1", Dimension::NONE, 1.0),
    // One revolution is 1, so that displacement times speed is a flow.
    atom("rev", Dimension::NONE, 1.0),
    atom("rad", Dimension::NONE, 0.5 / std::f64::consts::PI),
    atom("deg", Dimension::NONE, 1.0 / 360.0),
    atom("mm", Dimension::LENGTH, 1e-3),
    atom("um", Dimension::LENGTH, 1e-6),
    atom("cm", Dimension::LENGTH, 1e-2),
    atom("m", Dimension::LENGTH, 1.0),
    atom("km", Dimension::LENGTH, 1e3),
    atom("L", Dimension::VOLUME, 1e-3),
    atom("mL", Dimension::VOLUME, 1e-6),
    atom("cc", Dimension::VOLUME, 1e-6),
    atom("s", Dimension::TIME, 1.0),
    atom("ms", Dimension::TIME, 1e-3),
    atom("us", Dimension::TIME, 1e-6),
    atom("min", Dimension::TIME, 60.0),
    atom("h", Dimension::TIME, 3600.0),
    atom("Hz", Dimension::FREQUENCY, 1.0),
    atom("kHz", Dimension::FREQUENCY, 1e3),
    atom("rpm", Dimension::FREQUENCY, 1.0 / 60.0),
    atom("kg", Dimension::MASS, 1.0),
    atom("g", Dimension::MASS, 1e-3),
    atom("t", Dimension::MASS, 1e3),
    atom("N", Dimension::FORCE, 1.0),
    atom("kN", Dimension::FORCE, 1e3),
    atom("bar", Dimension::PRESSURE, 1e5),
    atom("mbar", Dimension::PRESSURE, 1e2),
    atom("MPa", Dimension::PRESSURE, 1e6),
    atom("kPa", Dimension::PRESSURE, 1e3),
    atom("hPa", Dimension::PRESSURE, 1e2),
    atom("Pa", Dimension::PRESSURE, 1.0),
    atom("mPa", Dimension::PRESSURE, 1e-3),
    atom("GPa", Dimension::PRESSURE, 1e9),
    atom("psi", Dimension::PRESSURE, 6_894.757_293_168_361),
    atom("cP", Dimension::DYNAMIC_VISCOSITY, 1e-3),
    atom("cSt", Dimension::KINEMATIC_VISCOSITY, 1e-6),
    atom("J", Dimension::ENERGY, 1.0),
    atom("kJ", Dimension::ENERGY, 1e3),
    // Torque as data sheets and loggers write it.
    atom("Nm", Dimension::ENERGY, 1.0),
    atom("kNm", Dimension::ENERGY, 1e3),
    atom("W", Dimension::POWER, 1.0),
    atom("kW", Dimension::POWER, 1e3),
    Atom { symbol: "degC", dimension: Dimension::TEMPERATURE, factor: 1.0, offset: 273.15 },
    atom("K", Dimension::TEMPERATURE, 1.0),
    atom("A", Dimension::CURRENT, 1.0),
    atom("mA", Dimension::CURRENT, 1e-3),
    atom("V", Dimension::VOLTAGE, 1.0),
    atom("mV", Dimension::VOLTAGE, 1e-3),
    atom("kV", Dimension::VOLTAGE, 1e3),
];

/// Other spellings that loggers use, and the symbol they stand for.
pub(super) const SPELLINGS: &[(&str, &str)] =
    &[("l", "L"), ("ml", "mL"), ("µm", "um"), ("μm", "um"), ("µs", "us"), ("μs", "us"), ("°C", "degC"), ("ccm", "cc")];

/// Words that people write and that are too far from, or ambiguous beside, the right symbol to be found by their letters.
pub(super) const MISTAKES: &[(&str, &str)] = &[
    ("C", "degC"),
    ("degree", "degC"),
    ("barg", "bar"),
    ("bara", "bar"),
    ("lpm", "L/min"),
    ("sec", "s"),
    ("micron", "um"),
    // A slip of the finger rather than a torque.
    ("nm", "mm"),
];

/// Compounds that lists of units name; any other product or quotient is read as well.
pub(super) const COMPOUNDS: &[&str] = &[
    "mm2",
    "cm2",
    "m2",
    "mm2/mm",
    "cm3",
    "m3",
    "cm3/rev",
    "cc/rev",
    "rev/min",
    "rad/s",
    "1/s",
    "L/min",
    "L/s",
    "m3/s",
    "L/min/bar",
    "m3/s/Pa",
    "L/min/bar^0.5",
    "m3/s/Pa^0.5",
    "cm3/bar",
    "m3/Pa",
    "mm/s",
    "m/s",
    "m/s2",
    "kg/m3",
    "mPa.s",
    "Pa.s",
    "mm2/s",
    "m2/s",
    "N/mm",
    "N/um",
    "N/m",
    "N.s/m",
    "kN.s/m",
    "1/bar",
    "1/Pa",
    "N.m",
];
