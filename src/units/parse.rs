//! Reads the text of a unit: products, quotients, whole and half powers of known words.

use super::table::{ATOMS, Atom, COMPOUNDS, MISTAKES, SPELLINGS};
use super::{Dimension, Unit, UnitError};
use crate::complaint::did_you_mean;

/// Most characters of a unit: those of plants have a dozen, and tables show them whole.
const LONGEST: usize = 64;

pub(super) fn parse(text: &str) -> Result<Unit, UnitError> {
    let symbol = text.trim();
    if symbol.is_empty() {
        return Err(UnitError::Empty);
    }
    if let Some((end, _)) = symbol.char_indices().nth(LONGEST) {
        return Err(UnitError::Malformed { unit: format!("{}...", &symbol[..end]) });
    }
    // Alone, a unit keeps its offset; inside a compound degC is a difference.
    if let Some(atom) = find(symbol) {
        return Ok(Unit {
            symbol: symbol.to_owned(),
            dimension: atom.dimension,
            factor: atom.factor,
            offset: atom.offset,
        });
    }
    let mut unit = Unit { symbol: symbol.to_owned(), dimension: Dimension::NONE, factor: 1.0, offset: 0.0 };
    for (index, quotient) in symbol.split('/').enumerate() {
        let factors = factors(quotient);
        // `N . s` splits into empty words around its point; those are no mistake.
        let spaced = quotient.contains(' ');
        let words: Vec<&str> = factors.into_iter().filter(|word| !(spaced && word.is_empty())).collect();
        if words.is_empty() || words.iter().any(|word| word.is_empty()) {
            return Err(UnitError::Malformed { unit: symbol.to_owned() });
        }
        for word in &words {
            let (atom, exponent) = power(symbol, word)?;
            let exponent = if index == 0 { exponent } else { -exponent };
            let power = atom.dimension.rational_power(exponent, 2);
            let power = power.ok_or_else(|| UnitError::Malformed { unit: symbol.to_owned() })?;
            unit.dimension = unit.dimension.times(power);
            // Dividing keeps 1/60 and 1/1000 correctly rounded; multiplying by a rounded reciprocal would not.
            let whole = atom.factor.powi(exponent.abs() / 2);
            let scale = if exponent % 2 == 0 { whole } else { whole * atom.factor.sqrt() };
            if exponent < 0 {
                unit.factor /= scale;
            } else {
                unit.factor *= scale;
            }
        }
        if index > 0 && words.len() > 1 {
            return Err(UnitError::Ambiguous { unit: symbol.to_owned() });
        }
    }
    Ok(unit)
}

/// The factors of a product, cut at its signs; the point of a half power (`bar^0.5`) is none.
fn factors(product: &str) -> Vec<&str> {
    let mut factors = Vec::new();
    let mut start = 0;
    for (at, sign) in product.match_indices(['.', '*', '·', ' ']) {
        let (before, after) = (&product[start..at], &product[at + sign.len()..]);
        let of_power = before.rsplit_once('^').is_some_and(|(_, whole)| whole.parse::<i8>().is_ok());
        let half = after.strip_prefix('5').is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()));
        if sign != "." || !of_power || !half {
            factors.push(before.trim());
            start = at + sign.len();
        }
    }
    factors.push(product[start..].trim());
    factors
}

/// A known word, with twice the power that follows it: `m3`, `m^3`, `m³`, `s-1`, `bar^0.5`.
fn power(unit: &str, word: &str) -> Result<(Atom, i32), UnitError> {
    if let Some(atom) = find(word).filter(|atom| atom.symbol != "-") {
        return Ok((atom, 2));
    }
    let malformed = || UnitError::Malformed { unit: unit.to_owned() };
    let base = word.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, '²' | '³' | '-' | '+' | '^' | '.'));
    if base.is_empty() {
        return Err(malformed());
    }
    let written = word.get(base.len()..).unwrap_or_default().replace('²', "2").replace('³', "3");
    let digits = written.strip_prefix('^').unwrap_or(&written);
    let exponent = if written.is_empty() {
        2
    } else if let Some(whole) = digits.strip_suffix(".5") {
        match whole.parse::<i32>() {
            Ok(exponent) if (-8..=8).contains(&exponent) => 2 * exponent + if whole.starts_with('-') { -1 } else { 1 },
            _ => return Err(malformed()),
        }
    } else {
        match digits.parse::<i32>() {
            Ok(exponent) if exponent != 0 && (-9..=9).contains(&exponent) => 2 * exponent,
            _ => return Err(malformed()),
        }
    };
    match find(base) {
        Some(atom) => Ok((atom, exponent)),
        None => Err(UnitError::Unknown { unit: unit.to_owned(), word: base.to_owned(), nearest: nearest(unit, base) }),
    }
}

/// The whole unit as it was probably meant.
fn nearest(unit: &str, word: &str) -> Option<String> {
    if let Some((_, better)) = MISTAKES.iter().find(|(mistake, _)| *mistake == word) {
        return Some(unit.replacen(word, better, 1));
    }
    // `L/mn` is near `L/min` as a whole, while `mn` alone is as near to `mm`.
    if unit != word
        && let Some(compound) = did_you_mean(unit, COMPOUNDS.iter().copied())
    {
        return Some(compound.to_owned());
    }
    did_you_mean(word, ATOMS.iter().map(|atom| atom.symbol)).map(|better| unit.replacen(word, better, 1))
}

fn find(word: &str) -> Option<Atom> {
    let symbol = SPELLINGS.iter().find(|(spelling, _)| *spelling == word).map_or(word, |(_, symbol)| *symbol);
    ATOMS.iter().find(|atom| atom.symbol == symbol).copied()
}
