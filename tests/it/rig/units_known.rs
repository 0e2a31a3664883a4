//! Units against known values, compounds in all their spellings, and what is said to a wrong one.

use borescope::internals::units::{Dimension, Quantity, Unit, UnitError};

/// Symbol, a value in it, the SI value, the dimension.
const KNOWN: &[(&str, f64, f64, Dimension)] = &[
    ("bar", 18.5, 18.5e5, Dimension::PRESSURE),
    ("MPa", 0.74, 0.74e6, Dimension::PRESSURE),
    ("kPa", 100.0, 1e5, Dimension::PRESSURE),
    ("Pa", 3.0, 3.0, Dimension::PRESSURE),
    ("psi", 14.503_773_773_02, 1e5, Dimension::PRESSURE),
    ("L/min", 60.0, 1e-3, Dimension::FLOW),
    ("l/min", 60.0, 1e-3, Dimension::FLOW),
    ("m3/s", 2.0, 2.0, Dimension::FLOW),
    ("m³/s", 2.0, 2.0, Dimension::FLOW),
    ("L/min/bar", 60.0, 1e-8, Dimension::FLOW_PER_PRESSURE),
    ("cm3", 50.0, 50e-6, Dimension::VOLUME),
    ("cm3/rev", 5.5, 5.5e-6, Dimension::VOLUME),
    ("cc/rev", 5.5, 5.5e-6, Dimension::VOLUME),
    ("rev/min", 1000.0, 1000.0 / 60.0, Dimension::FREQUENCY),
    ("rpm", 1000.0, 1000.0 / 60.0, Dimension::FREQUENCY),
    ("1/min", 60.0, 1.0, Dimension::FREQUENCY),
    ("s-1", 2.0, 2.0, Dimension::FREQUENCY),
    ("s^-1", 2.0, 2.0, Dimension::FREQUENCY),
    ("mm", 37.4, 0.0374, Dimension::LENGTH),
    ("um", 50.0, 50e-6, Dimension::LENGTH),
    ("µm", 50.0, 50e-6, Dimension::LENGTH),
    ("m", 1.0, 1.0, Dimension::LENGTH),
    ("mm2", 101.35, 101.35e-6, Dimension::AREA),
    ("mm^2", 101.35, 101.35e-6, Dimension::AREA),
    ("mm2/mm", 10.0, 0.01, Dimension::LENGTH),
    ("N", 5400.0, 5400.0, Dimension::FORCE),
    ("kN", 5.4, 5400.0, Dimension::FORCE),
    ("Nm", 15.2, 15.2, Dimension::ENERGY),
    ("kNm", 1.2, 1200.0, Dimension::ENERGY),
    ("kg", 100.0, 100.0, Dimension::MASS),
    ("N.s/m", 800.0, 800.0, Dimension::DAMPING),
    ("N*s/m", 800.0, 800.0, Dimension::DAMPING),
    ("N s/m", 800.0, 800.0, Dimension::DAMPING),
    ("N·s/m", 800.0, 800.0, Dimension::DAMPING),
    ("N . s / m", 800.0, 800.0, Dimension::DAMPING),
    ("kN.s/m", 80.0, 8e4, Dimension::DAMPING),
    ("N/m", 5000.0, 5000.0, Dimension::STIFFNESS),
    ("N/mm", 5.0, 5000.0, Dimension::STIFFNESS),
    ("N/um", 50.0, 5e7, Dimension::STIFFNESS),
    ("Pa.s", 0.0455, 0.0455, Dimension::DYNAMIC_VISCOSITY),
    ("mPa.s", 45.5, 0.0455, Dimension::DYNAMIC_VISCOSITY),
    ("cSt", 46.0, 46e-6, Dimension::KINEMATIC_VISCOSITY),
    ("mm2/s", 46.0, 46e-6, Dimension::KINEMATIC_VISCOSITY),
    ("kg/m3", 870.0, 870.0, Dimension::DENSITY),
    ("degC", 40.0, 313.15, Dimension::TEMPERATURE),
    ("°C", -273.15, 0.0, Dimension::TEMPERATURE),
    ("K", 313.15, 313.15, Dimension::TEMPERATURE),
    ("s", 1.5, 1.5, Dimension::TIME),
    ("ms", 8.0, 0.008, Dimension::TIME),
    ("min", 2.0, 120.0, Dimension::TIME),
    ("h", 0.5, 1800.0, Dimension::TIME),
    ("Hz", 250.0, 250.0, Dimension::FREQUENCY),
    ("V", 3.2, 3.2, Dimension::VOLTAGE),
    ("mV", 320.0, 0.32, Dimension::VOLTAGE),
    ("A.V", 2.0, 2.0, Dimension::POWER),
    ("%", 40.0, 0.4, Dimension::NONE),
    ("-", 0.7, 0.7, Dimension::NONE),
    ("mm/s", 73.0, 0.073, Dimension::VELOCITY),
    ("m/s", 0.073, 0.073, Dimension::VELOCITY),
    ("m/s2", 9.81, 9.81, Dimension::ACCELERATION),
    ("W", 5.0, 5.0, Dimension::POWER),
    ("bar.L/min", 600.0, 1000.0, Dimension::POWER),
    ("kW", 1.5, 1500.0, Dimension::POWER),
    ("cm3/bar", 1.0, 1e-11, Dimension::VOLUME_PER_PRESSURE),
    ("1/bar", 1.0, 1e-5, Dimension::COMPRESSIBILITY),
];

#[test]
fn units_have_their_known_values() {
    for &(symbol, value, si, dimension) in KNOWN {
        let unit = Unit::parse(symbol).unwrap_or_else(|error| panic!("{symbol}: {error}"));
        assert_eq!(unit.dimension, dimension, "{symbol}");
        let converted = unit.to_si(value);
        assert!((converted - si).abs() <= 1e-12 * si.abs(), "{value} {symbol} is {converted}, not {si}");
        assert_eq!(unit.to_string(), symbol);
    }
}

#[test]
fn converting_there_and_back_changes_at_most_the_last_digits() {
    let mut state = 1_u64;
    for &(symbol, ..) in KNOWN {
        let unit = Unit::parse(symbol).unwrap();
        for _ in 0..200 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let value = ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0) * 1e4;
            let back = unit.from_si(unit.to_si(value));
            let scale = value.abs().max(unit.offset.abs() / unit.factor);
            assert!((back - value).abs() <= 4.0 * f64::EPSILON * scale, "{value} {symbol}");
            let difference = unit.difference_from_si(unit.difference_to_si(value));
            assert!((difference - value).abs() <= 4.0 * f64::EPSILON * value.abs());
            assert_eq!(unit.difference_to_si(value), value * unit.factor);
        }
    }
}

#[test]
fn a_difference_of_degrees_has_no_offset() {
    let unit = Unit::parse("degC").unwrap();
    assert_eq!(unit.difference_to_si(0.1), 0.1);
    assert_eq!(Unit::parse("bar/degC").unwrap().offset, 0.0);
}

#[test]
fn displacement_times_speed_is_a_flow() {
    let displacement = Quantity::parse("5.5 cc/rev").unwrap();
    let speed = Quantity::parse("1000 rev/min").unwrap();
    let flow = displacement.unit.dimension.times(speed.unit.dimension);
    assert_eq!(flow, Dimension::FLOW);
    let in_litres = Unit::parse("L/min").unwrap().from_si(displacement.value * speed.value);
    assert!((in_litres - 5.5).abs() < 1e-12);
}

/// What is written, what is wrong with it, what would be right.
const WRONG: &[(&str, &str, &str)] = &[
    ("", "the unit is missing", "write a unit, such as `bar` or `L/min`; `-` for a pure number"),
    (
        "baar",
        "unknown unit `baar`",
        "did you mean `bar`? Units of pressure: `bar`, `mbar`, `MPa`, `kPa`, `hPa`, `Pa`, `mPa`, `GPa`, `psi`",
    ),
    ("L/mn", "unknown unit `mn` in `L/mn`", "did you mean `L/min`? Units of flow: `L/min`, `L/s`, `m3/s`"),
    ("C", "unknown unit `C`", "did you mean `degC`? Units of temperature: `degC`, `K`"),
    (
        "furlong",
        "unknown unit `furlong`",
        "units are products and quotients of known ones, such as `bar`, `L/min`, `mm`, `N.s/m` or `degC`; \
         `-` for a pure number",
    ),
    (
        "N.s/m.K",
        "`N.s/m.K` can be read in two ways: a product follows a `/`",
        "to divide by every factor write `N.s/m/K`; to multiply, move the factor before the `/`",
    ),
    ("L//min", "`L//min` is not a unit", "write units as `L/min`, `N.s/m`, `kg/m3` or `m/s2`"),
    ("m99", "`m99` is not a unit", "write units as `L/min`, `N.s/m`, `kg/m3` or `m/s2`"),
    ("L/-", "`L/-` is not a unit", "write units as `L/min`, `N.s/m`, `kg/m3` or `m/s2`"),
];

#[test]
fn a_wrong_unit_is_told_with_what_would_be_right() {
    for &(text, what, help) in WRONG {
        let error = Unit::parse(text).unwrap_err();
        assert_eq!((error.to_string().as_str(), error.help().as_str()), (what, help));
    }
}

#[test]
fn what_the_help_lists_is_of_the_dimension() {
    for &(_, _, _, dimension) in KNOWN {
        let listed = Unit::known_for(dimension);
        assert!(!listed.is_empty(), "{dimension}");
        for symbol in listed {
            assert_eq!(Unit::parse(symbol).unwrap().dimension, dimension, "{symbol}");
        }
    }
}

#[test]
fn a_dimension_without_a_name_shows_its_base_units() {
    let dimension = Dimension::FLOW.power(2);
    assert_eq!(dimension.to_string(), "m6.s-2");
    assert_eq!(Unit::parse("m6.s-2").unwrap().dimension, dimension);
    assert_eq!(Dimension::PRESSURE.to_string(), "pressure");
}

#[test]
fn half_powers_are_read_and_written() {
    let conductance = Dimension::FLOW.per(Dimension::PRESSURE.rational_power(1, 2).unwrap());
    for (text, si) in [
        ("L/min/bar^0.5", 1e-3 / 60.0 / 1e5_f64.sqrt()),
        ("m^3.5.kg^-0.5", 1.0),
        ("m^3.5 kg^-0.5", 1.0),
        ("cm3/s/MPa^0.5", 1e-6 / 1e3),
    ] {
        let unit = Unit::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(unit.dimension, conductance, "{text}");
        assert!((unit.factor / si - 1.0).abs() < 1e-15, "{text}: {}", unit.factor);
    }
    assert_eq!(conductance.to_string(), "m^3.5.kg^-0.5");
    assert_eq!(Unit::parse("bar^1.5").unwrap().factor, 1e5 * 1e5_f64.sqrt());
    assert_eq!(Unit::parse("s^2.m").unwrap().dimension.to_string(), "m.s2");
    for wrong in ["bar^0.7", "bar0.5", "bar^.5", "bar^0.55", "bar^9.5", "bar^0.5.5", "m^", "m3/s.Pa^-0.5"] {
        assert!(Unit::parse(wrong).is_err(), "{wrong}");
    }
    assert_eq!(Dimension::PRESSURE.rational_power(1, 3), None);
    assert_eq!(Dimension::VOLUME.rational_power(1, 3), Some(Dimension::LENGTH));
    assert_eq!(Dimension::LENGTH.rational_power(101, 1), None);
    assert_eq!(Dimension::LENGTH.rational_power(1, 0), None);
}

#[test]
fn quantities_are_read_and_written_in_their_unit() {
    for (text, si, shown) in [
        ("5 mm", 0.005, "5 mm"),
        ("5mm", 0.005, "5 mm"),
        ("  18.5   bar ", 18.5e5, "18.5 bar"),
        ("0.3 mm", 0.3e-3, "0.3 mm"),
        ("40 degC", 313.15, "40 degC"),
        ("-1.5e-3 m", -1.5e-3, "-0.0015 m"),
        ("2e-7 m", 2e-7, "2e-7 m"),
        ("0.7", 0.7, "0.7"),
        ("0.7 -", 0.7, "0.7"),
        ("40 %", 0.4, "40 %"),
        ("60 1/min", 1.0, "60 1/min"),
        ("+.5 N", 0.5, "0.5 N"),
    ] {
        let quantity = Quantity::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!((quantity.value - si).abs() <= 1e-15 * si.abs().max(1e-3), "{text}");
        assert_eq!(quantity.to_string(), shown);
    }
}

#[test]
fn a_wrong_quantity_is_told_with_what_would_be_right() {
    for (text, what, help) in [
        ("5,5 mm", "`5,5 mm` does not begin with a finite number", "the decimal mark is a point: `5.5 mm`"),
        (
            "mm 5",
            "`mm 5` does not begin with a finite number",
            "write a number and its unit, such as `5 mm` or `18.5 bar`",
        ),
        (
            "1e999 mm",
            "`1e999 mm` does not begin with a finite number",
            "write a number and its unit, such as `5 mm` or `18.5 bar`",
        ),
        (
            "5",
            "`5` has no unit, but needs one of length",
            "write for example `5 mm`; units of length: `mm`, `um`, `cm`, `m`, `km`, `mm2/mm`",
        ),
        (
            "5 bar",
            "`bar` is a unit of pressure, not of length",
            "units of length: `mm`, `um`, `cm`, `m`, `km`, `mm2/mm`",
        ),
        ("5 nm", "unknown unit `nm`", "did you mean `mm`? Units of length: `mm`, `um`, `cm`, `m`, `km`, `mm2/mm`"),
    ] {
        let error = Quantity::parse_as(text, Dimension::LENGTH).unwrap_err();
        assert_eq!((error.to_string().as_str(), error.help().as_str()), (what, help));
    }
    assert!(matches!(Quantity::parse_as("3 bar", Dimension::NONE), Err(UnitError::WrongDimension { .. })));
}
