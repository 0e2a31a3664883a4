//! Reads the text of a unit: products, quotients and integer powers of known words.

use super::table::{ATOMS, Atom, COMPOUNDS, MISTAKES, SPELLINGS};
use super::{Dimension, Unit, UnitError};
use crate::complaint::did_you_mean;

pub(super) fn parse(text: &str) -> Result<Unit, UnitError> {
    let symbol = text.trim();
    if symbol.is_empty() {
        return Err(UnitError::Empty);
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
        let factors: Vec<&str> = quotient.split(['.', '*', '·', ' ']).map(str::trim).collect();
        // `N . s` splits into empty words around its point; those are no mistake.
        let spaced = quotient.contains(' ');
        let words: Vec<&str> = factors.into_iter().filter(|word| !(spaced && word.is_empty())).collect();
        if words.is_empty() || words.iter().any(|word| word.is_empty()) {
            return Err(UnitError::Malformed { unit: symbol.to_owned() });
        }
        for word in &words {
            let (atom, exponent) = power(symbol, word)?;
            let exponent = if index == 0 { exponent } else { -exponent };
            unit.dimension = unit.dimension.times(atom.dimension.power(exponent));
            // Dividing keeps 1/60 and 1/1000 correctly rounded; multiplying by a rounded reciprocal would not.
            let scale = atom.factor.powi(i32::from(exponent.abs()));
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

/// A known word, with the power that follows it: `m3`, `m^3`, `m³`, `s-1`.
fn power(unit: &str, word: &str) -> Result<(Atom, i8), UnitError> {
    if let Some(atom) = find(word).filter(|atom| atom.symbol != "-") {
        return Ok((atom, 1));
    }
    let malformed = || UnitError::Malformed { unit: unit.to_owned() };
    let base = word.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, '²' | '³' | '-' | '+' | '^'));
    if base.is_empty() {
        return Err(malformed());
    }
    let written = word.get(base.len()..).unwrap_or_default().replace('²', "2").replace('³', "3");
    let digits = written.strip_prefix('^').unwrap_or(&written);
    let exponent = if written.is_empty() {
        1
    } else {
        match digits.parse::<i8>() {
            Ok(exponent) if exponent != 0 && (-9..=9).contains(&exponent) => exponent,
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
