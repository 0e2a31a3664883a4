//! Complaints about a word that does not fit.

use super::Reader;
use crate::complaint::{did_you_mean, help_with_names};
use crate::expression::lexer::{Token, Word};
use crate::expression::{ExpressionError, FUNCTIONS};
use crate::units::Unit;

impl Reader<'_> {
    pub(super) fn unknown(&self, name: &str, start: usize) -> ExpressionError {
        if FUNCTIONS.contains(&name) {
            let what = format!("`{name}` is a function and needs an argument");
            return ExpressionError::new(start, what, format!("write `{name}(...)`"));
        }
        let names = self.names.iter().map(|known| known.name.as_str());
        let what = format!("unknown name `{name}`");
        if did_you_mean(name, names.clone()).is_none() && Unit::parse(name).is_ok() {
            return ExpressionError::new(start, what, format!("numbers with a unit are written `[1 {name}]`"));
        }
        ExpressionError::new(start, what, help_with_names(name, "names", names))
    }

    /// The complaint about the next word where `wanted` belongs.
    pub(super) fn unexpected(&self, wanted: &str) -> ExpressionError {
        let Token { start, end, .. } = self.token;
        let written = &self.text[start..end];
        let before = &self.text[..start];
        let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        let (what, help) = match &self.token.word {
            Word::End => {
                let help = if wanted == "`)`" { "every `(` needs its `)`" } else { "the formula is not complete" };
                (format!("the formula ends where {wanted} belongs"), help.to_owned())
            }
            Word::Sign(sign) => {
                let comma = *sign == ',' && digit(before.chars().next_back()) && digit(self.text[end..].chars().next());
                let help = if comma {
                    "the decimal mark is a point: `0.5`".to_owned()
                } else {
                    format!("here belongs {wanted}")
                };
                (format!("`{sign}` does not belong here"), help)
            }
            Word::Name(name) if digit(before.trim_end().chars().next_back()) && Unit::parse(name).is_ok() => {
                let number =
                    before.trim_end().rsplit(|c: char| !c.is_ascii_digit() && c != '.').next().unwrap_or_default();
                (format!("a unit outside of brackets: `{name}`"), format!("write `[{number} {name}]`"))
            }
            _ => (format!("an operator is missing before `{written}`"), "products are written with `*`".to_owned()),
        };
        ExpressionError::new(start, what, help)
    }
}
