//! Numbers as people read them.

use crate::units::Unit;

/// With at most `digits` significant digits, without zeros at the end.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// An SI value in its unit, with at most nine digits: the way through SI leaves 0.30000000000000004 where 0.3 was meant.
pub fn in_unit(si: f64, unit: &Unit) -> f64 {
    rounded(unit.from_si(si), 9)
}

/// An SI difference, such as a standard deviation, in its unit.
pub fn difference_in_unit(si: f64, unit: &Unit) -> f64 {
    rounded(unit.difference_from_si(si), 9)
}

/// Six digits; very large and very small numbers with an exponent.
pub fn text(value: f64) -> String {
    let value = rounded(value, 6);
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-4..1e7).contains(&magnitude) { format!("{value:e}") } else { format!("{value}") }
}

/// A value and its unit as a rig file has them, with so many digits; a pure number stands alone.
pub fn written(value: f64, digits: usize, unit: &Unit) -> String {
    let value = rounded(value, digits);
    if unit.symbol == "-" { value.to_string() } else { format!("{value} {}", unit.symbol) }
}

/// A value and its unit; a pure number stands alone.
pub fn with_unit(value: f64, unit: &str) -> String {
    before_unit(text(value), unit)
}

/// A number as it is shown with its unit behind it; a pure number stands alone.
pub fn before_unit(number: String, unit: &str) -> String {
    if unit == "-" { number } else { format!("{number} {unit}") }
}

/// Digits where no interval says how many are worth something.
const DIGITS_UNKNOWN: usize = 4;
/// Below this a number has an exponent, as in [`text`].
const EXPONENT_BELOW: f64 = 1e-4;

/// A number with the digits that two digits of `width` leave, or with four where that is none; 0 has no sign.
pub fn worth(value: f64, width: f64) -> String {
    if !(width > 0.0 && width.is_finite() && value.is_finite()) {
        return text(rounded(value, DIGITS_UNKNOWN));
    }
    let decimals = 1 - width.log10().floor() as i32;
    let last = (value.abs().log10().floor() as i32).saturating_add(decimals);
    let digits = last.max(0) as usize;
    let near: f64 = match last {
        _ if value == 0.0 => 0.0,
        // Of less than one step only whether it is nearer to the step than to nothing.
        ..0 => (value / 10_f64.powi(-decimals)).round() * 10_f64.powi(-decimals),
        _ => format!("{value:.digits$e}").parse().unwrap_or(value),
    };
    let half = 0.5 * 10_f64.powi(-decimals);
    if near.abs() <= half {
        return if width < EXPONENT_BELOW { "0".to_owned() } else { format!("{:.*}", decimals.max(0) as usize, 0.0) };
    }
    let small = near.abs() < EXPONENT_BELOW && width < EXPONENT_BELOW;
    if !small && near.abs() < 1e7 {
        format!("{near:.*}", decimals.max(0) as usize)
    } else {
        format!("{near:.*e}", (near.abs().log10().floor() as i32 + decimals).max(0) as usize)
    }
}
