//! The constant behind a `^`.

use super::{Parsed, Reader};
use crate::expression::ExpressionError;
use crate::expression::lexer::Word;
use crate::expression::program::Exponent;

impl Reader<'_> {
    /// `2`, `-0.5`, `(1/3)`, `(-2)`.
    pub(super) fn exponent(&mut self) -> Parsed<Exponent> {
        let start = self.token.start;
        let bracket = self.at('(');
        if bracket {
            self.take()?;
        }
        let negative = self.at('-');
        if negative {
            self.take()?;
        }
        let (mut numerator, mut denominator) = (self.thousandths()?, 1000);
        if bracket {
            if self.at('/') {
                self.take()?;
                // 1000 a / (1000 b)
                denominator = self.thousandths()?;
            }
            if !self.at(')') {
                return Err(not_constant(self.token.start));
            }
            self.take()?;
        }
        if negative {
            numerator = -numerator;
        }
        let divisor = gcd(numerator.unsigned_abs(), denominator.unsigned_abs()).max(1) as i32;
        let exponent = Exponent { numerator: numerator / divisor, denominator: denominator / divisor };
        if exponent.denominator == 0
            || exponent.denominator > 1000
            || exponent.numerator.abs() > 16 * exponent.denominator
        {
            let what = format!("`{}` is no exponent", &self.text[start..self.end]);
            let help = "exponents reach from -16 to 16, with denominators up to 1000";
            return Err(ExpressionError::new(start, what, help));
        }
        Ok(exponent)
    }

    /// A number of at most three decimals, times 1000.
    fn thousandths(&mut self) -> Parsed<i32> {
        let Word::Number(value) = self.token.word else { return Err(not_constant(self.token.start)) };
        let scaled = (value * 1000.0).round();
        if scaled / 1000.0 != value || scaled > 1e6 {
            let what = format!("`{}` is no exponent", &self.text[self.token.start..self.token.end]);
            let help = "exponents have at most three decimals and reach from -16 to 16; write thirds as `x^(1/3)`";
            return Err(ExpressionError::new(self.token.start, what, help));
        }
        self.take()?;
        Ok(scaled as i32)
    }
}

fn not_constant(offset: usize) -> ExpressionError {
    let help = "write `x^2`, `x^-0.5` or `x^(1/3)`; for an exponent that varies `exp(n * ln(x))`";
    ExpressionError::new(offset, "an exponent is a constant pure number", help)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}
