//! A formula as words: numbers, quantities, names, signs.

use super::{ExpressionError, Literal};
use crate::units::Unit;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Word<'a> {
    Number(f64),
    Quantity(Literal),
    Name(&'a str),
    /// One of `+-*/^(),;:`.
    Sign(char),
    End,
}

/// A word and its bytes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Token<'a> {
    pub word: Word<'a>,
    pub start: usize,
    pub end: usize,
}

/// The next word at or behind byte `from`.
pub(super) fn next(text: &str, from: usize) -> Result<Token<'_>, ExpressionError> {
    let rest = text.get(from..).unwrap_or_default();
    let start = text.len() - rest.trim_start().len();
    let rest = &text[start..];
    let token = |word, length| Ok(Token { word, start, end: start + length });
    match rest.chars().next() {
        None => token(Word::End, 0),
        Some(sign @ ('+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' | ';' | ':')) => token(Word::Sign(sign), 1),
        Some('[') => quantity(rest, start),
        Some(first) if first.is_ascii_digit() => {
            let (value, length) = number(rest, start)?;
            token(Word::Number(value), length)
        }
        Some(_) => match name_length(rest) {
            0 => Err(stray(rest, start)),
            length => token(Word::Name(&rest[..length]), length),
        },
    }
}

/// Bytes of the name at the start of `text`; 0 where there is none.
pub(super) fn name_length(text: &str) -> usize {
    let mut length = 0;
    loop {
        let part = &text[length..];
        if !part.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            // A point belongs to a name only with a part behind it.
            return length.saturating_sub(1);
        }
        let end = part.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(part.len());
        length += end;
        if !part[end..].starts_with('.') {
            return length;
        }
        length += 1;
    }
}

/// The number at the start of `text`, and its bytes.
fn number(text: &str, offset: usize) -> Result<(f64, usize), ExpressionError> {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes.iter().skip(from).take_while(|byte| byte.is_ascii_digit()).count();
    let mut length = digits(0);
    let begins = length > 0;
    let mut ends = true;
    if bytes.get(length) == Some(&b'.') {
        let decimals = digits(length + 1);
        ends = decimals > 0;
        length += 1 + decimals;
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        let exponent = digits(length + 1 + sign);
        if exponent > 0 {
            length += 1 + sign + exponent;
        }
    }
    let written = &text[..length];
    if !begins || !ends {
        let what =
            if written.is_empty() { "a number is missing".to_owned() } else { format!("`{written}` is no number") };
        return Err(ExpressionError::new(offset, what, "digits stand on both sides of a decimal point: `0.5`, `5.0`"));
    }
    match written.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((value, length)),
        _ => Err(ExpressionError::new(offset, format!("`{written}` is too large"), "numbers go up to 1e308")),
    }
}

/// The quantity at the start of `text`, which opens with `[`.
fn quantity(text: &str, offset: usize) -> Result<Token<'_>, ExpressionError> {
    let Some(close) = text.find(']') else {
        return Err(ExpressionError::new(offset, "`[` is never closed", "numbers with a unit are written `[0.3 bar]`"));
    };
    let inside = text[1..close].trim_start();
    let signless = inside.strip_prefix('-').unwrap_or(inside);
    let at = offset + close - signless.len();
    let (magnitude, length) = number(signless, at)?;
    let unit = signless[length..].trim();
    if unit.starts_with(',') {
        return Err(ExpressionError::new(
            at + length,
            "`,` within a number",
            "the decimal mark is a point: `[0.3 bar]`",
        ));
    }
    let unit = match unit {
        "" => Unit::dimensionless(),
        _ => Unit::parse(unit).map_err(|error| ExpressionError::new(at + length, error.to_string(), error.help()))?,
    };
    let written = if signless.len() < inside.len() { -magnitude } else { magnitude };
    let literal = Literal { written, unit };
    if !literal.si().is_finite() {
        let inside = inside.trim_end();
        return Err(ExpressionError::new(at, format!("`{inside}` is too large"), "numbers go up to 1e308 in SI"));
    }
    Ok(Token { word: Word::Quantity(literal), start: offset, end: offset + close + 1 })
}

fn stray(text: &str, offset: usize) -> ExpressionError {
    let sign = text.chars().next().unwrap_or_default();
    let shown = if sign.is_control() { sign.escape_default().to_string() } else { sign.to_string() };
    let help = match sign {
        '.' => "digits stand on both sides of a decimal point: `0.5`",
        '|' => "a magnitude is written `abs(x)`",
        ']' => "numbers with a unit are written `[0.3 bar]`",
        '"' | '\'' => "numbers with a unit are written `[0.3 bar]`, names without quotes",
        '%' => "a share is written `[5 %]`",
        '<' | '>' | '=' => "comparisons are written with `step`: `step(x - y)` is 1 where `x` reaches `y`",
        '·' | '×' => "products are written with `*`",
        '²' | '³' => "powers are written with `^`: `x^2`",
        '√' => "a root is written `sqrt(x)`",
        _ => "formulas consist of numbers, names, `+ - * / ^`, brackets and functions",
    };
    ExpressionError::new(offset, format!("`{shown}` has no meaning in a formula"), help)
}
