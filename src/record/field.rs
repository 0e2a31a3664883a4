//! What stands in a field: a number with its decimals, a time, or nothing.

use crate::units::Unit;

/// From here on times are counted from the first row, s: an `f64` resolves them to 1e-10 s, a thousandth of the shortest steps
/// that a stiff circuit takes. Time stamps of a computer, which count from 1970, lie beyond.
pub(super) const FAR: f64 = 1e6;

/// What loggers write where there is no value.
pub(super) fn is_missing(field: &str) -> bool {
    const WORDS: &[&str] = &[
        "", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "inf", "-inf", "+inf", "1.#inf", "1.#qnan", "-nan",
    ];
    WORDS.iter().any(|word| field.eq_ignore_ascii_case(word))
}

/// How many decimals the numbers of a column have, as long as all have as many.
#[derive(Clone, Copy)]
pub(super) enum Decimals {
    Unknown,
    All(usize),
    Mixed,
}

impl Decimals {
    pub fn with(self, count: Option<usize>) -> Self {
        match (self, count) {
            (Self::Unknown, Some(count)) => Self::All(count),
            (Self::All(before), Some(count)) if before == count => self,
            _ => Self::Mixed,
        }
    }

    pub fn known(self) -> Option<usize> {
        match self {
            Self::All(count) => Some(count),
            Self::Unknown | Self::Mixed => None,
        }
    }
}

/// A time since the first row, where that is far from 0, rounded as it was written: a difference of large numbers has digits
/// that nobody wrote.
pub(super) fn since(begins_at: &mut Option<f64>, written: f64, decimals: Option<usize>, unit: &Unit) -> f64 {
    let start = *begins_at.get_or_insert(if unit.to_si(written).abs() > FAR { written } else { 0.0 });
    match decimals.and_then(|decimals| i32::try_from(decimals).ok()) {
        _ if start == 0.0 => written,
        Some(decimals @ 0..=12) => {
            let scale = 10f64.powi(decimals);
            ((written - start) * scale).round() / scale
        }
        _ => written - start,
    }
}
