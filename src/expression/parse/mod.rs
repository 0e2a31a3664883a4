//! From text to a checked program, by recursive descent.

mod exponent;
mod line;
mod sheet;
mod wrong;

use std::sync::Arc;

use super::check::{self, Part};
use super::lexer::{self, Token, Word};
use super::program::{Function, Op, Program};
use super::{ExpressionError, FUNCTIONS, Literal, MAX_BYTES, MAX_NESTING, MAX_NODES, MAX_WAITING, Name, Sheet};
use crate::complaint::help_with_names;
use crate::units::{Dimension, Unit};

type Parsed<T> = Result<T, ExpressionError>;

pub(super) fn parse(text: &str, names: &[Name], sheets: &[Arc<Sheet>]) -> Parsed<(Program, Dimension)> {
    names_can_be_written(names)?;
    if let Some((offset, _)) = text.char_indices().filter(|(_, c)| !c.is_whitespace()).find({
        let mut bytes = 0;
        move |(_, c)| {
            bytes += c.len_utf8();
            bytes > MAX_BYTES
        }
    }) {
        let what = format!("the formula has more than {MAX_BYTES} bytes");
        return Err(ExpressionError::new(offset, what, "split it into several"));
    }
    let token = lexer::next(text, 0)?;
    if token.word == Word::End {
        return Err(ExpressionError::new(
            0,
            "the formula is empty",
            "write for example `k * dp`; a constant is one too",
        ));
    }
    let mut reader = Reader { text, names, sheets, token, end: 0, program: Program::default(), waiting: 0, nesting: 0 };
    let whole = reader.sum()?;
    match reader.token.word {
        Word::End => Ok((reader.program, whole.dimension)),
        Word::Sign(')') => {
            let what = "`)` closes nothing";
            Err(ExpressionError::new(reader.token.start, what, "remove it, or open a bracket with `(` before"))
        }
        _ => Err(reader.unexpected("an operator")),
    }
}

fn names_can_be_written(names: &[Name]) -> Parsed<()> {
    for (index, Name { name, .. }) in names.iter().enumerate() {
        let refuse = |why: &str, help: &str| Err(ExpressionError::new(0, format!("`{name}` {why}"), help));
        if name.is_empty() || lexer::name_length(name) != name.len() {
            let help =
                "names consist of letters, digits and `_`, begin with no digit, and may have points between parts";
            return refuse("cannot be named in a formula", help);
        }
        if FUNCTIONS.contains(&name.as_str()) {
            return refuse("is a function and cannot name a quantity", "take another name");
        }
        if names[..index].iter().any(|other| other.name == *name) {
            return refuse("names two quantities", "take another name for one of them");
        }
    }
    Ok(())
}

struct Reader<'a> {
    text: &'a str,
    names: &'a [Name],
    sheets: &'a [Arc<Sheet>],
    /// The next word.
    token: Token<'a>,
    /// Behind the last word that was taken.
    end: usize,
    program: Program,
    /// Values that wait after the program so far.
    waiting: usize,
    nesting: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self) -> Parsed<Token<'a>> {
        let next = lexer::next(self.text, self.token.end)?;
        self.end = self.token.end;
        Ok(std::mem::replace(&mut self.token, next))
    }

    fn at(&self, sign: char) -> bool {
        self.token.word == Word::Sign(sign)
    }

    fn expect(&mut self, sign: char) -> Parsed<()> {
        if !self.at(sign) {
            return Err(self.unexpected(&format!("`{sign}`")));
        }
        self.take().map(drop)
    }

    /// Adds an operation that takes `taken` values and leaves one.
    fn emit(&mut self, op: Op, taken: usize, offset: usize) -> Parsed<()> {
        self.waiting = self.waiting + 1 - taken;
        self.program.waiting = self.program.waiting.max(self.waiting);
        self.program.push(op);
        if self.program.ops().len() > MAX_NODES {
            let what = format!("the formula has more than {MAX_NODES} numbers, names and operators");
            return Err(ExpressionError::new(offset, what, "split it into several"));
        }
        if self.waiting > MAX_WAITING {
            let what = format!("more than {MAX_WAITING} values wait for each other here");
            return Err(ExpressionError::new(offset, what, "begin sums and products with their longest part"));
        }
        Ok(())
    }

    /// Reads something nested.
    fn nested<T>(&mut self, offset: usize, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            let what = format!("nested more than {MAX_NESTING} deep");
            return Err(ExpressionError::new(offset, what, "remove brackets, or split the formula into several"));
        }
        let result = read(self);
        self.nesting -= 1;
        result
    }

    fn sum(&mut self) -> Parsed<Part> {
        let product = Self::product;
        self.chain(['+', '-'], product)
    }

    fn product(&mut self) -> Parsed<Part> {
        self.chain(['*', '/'], Self::signed)
    }

    /// Operands joined by either of two signs, from the left.
    fn chain(&mut self, signs: [char; 2], operand: impl Fn(&mut Self) -> Parsed<Part>) -> Parsed<Part> {
        let mut left = operand(self)?;
        while let Word::Sign(sign) = self.token.word
            && signs.contains(&sign)
        {
            let offset = self.take()?.start;
            let right = operand(self)?;
            let dimension = check::binary(self.text, (sign, offset), left, right)?;
            let op = match sign {
                '+' => Op::Add,
                '-' => Op::Subtract,
                '*' => Op::Multiply,
                _ => Op::Divide,
            };
            self.emit(op, 2, offset)?;
            left = Part { dimension, start: left.start, end: self.end, bare: false };
        }
        Ok(left)
    }

    fn signed(&mut self) -> Parsed<Part> {
        if !self.at('-') {
            return self.power();
        }
        let start = self.take()?.start;
        let part = self.nested(start, Self::signed)?;
        self.emit(Op::Negate, 1, start)?;
        Ok(Part { start, ..part })
    }

    fn power(&mut self) -> Parsed<Part> {
        let base = self.operand()?;
        // Before dimensions are looked at, because `3 bar` has not the one that was meant.
        if matches!(self.token.word, Word::Number(_) | Word::Quantity(_) | Word::Name(_) | Word::Sign('(')) {
            return Err(self.unexpected("an operator"));
        }
        if !self.at('^') {
            return Ok(base);
        }
        let offset = self.take()?.start;
        let exponent = self.exponent()?;
        let dimension = check::power(self.text, offset, base, exponent)?;
        self.emit(Op::Power(exponent), 1, offset)?;
        if self.at('^') {
            let what = "a power of a power can be read in two ways";
            return Err(ExpressionError::new(self.token.start, what, "write `(x^2)^3`, or `x^6`"));
        }
        Ok(Part { dimension, start: base.start, end: self.end, bare: false })
    }

    /// A number, quantity, name, call or bracket.
    fn operand(&mut self) -> Parsed<Part> {
        let start = self.token.start;
        match self.token.word {
            Word::Number(_) | Word::Quantity(_) => {
                let (literal, part) = self.constant()?;
                self.emit(Op::Constant(literal.si()), 0, start)?;
                self.program.literals.push(literal);
                Ok(part)
            }
            Word::Name(name) => {
                self.take()?;
                if self.at('(') {
                    return self.nested(start, |reader| reader.call(name, start));
                }
                let Some(index) = self.names.iter().position(|known| known.name == name) else {
                    return Err(self.unknown(name, start));
                };
                self.emit(Op::Value(index), 0, start)?;
                Ok(Part { dimension: self.names[index].dimension, start, end: self.end, bare: false })
            }
            Word::Sign('(') => {
                self.take()?;
                let inside = self.nested(start, Self::sum)?;
                self.expect(')')?;
                Ok(Part { start, end: self.end, bare: false, ..inside })
            }
            Word::Sign(sign) => {
                let what = format!("`{sign}` stands where a number, a name or `(` belongs");
                let doubled = sign == '*' && self.text[..start].ends_with('*');
                let help = match sign {
                    '*' if doubled => "powers are written with `^`: `x^2`",
                    '+' => "leave it out: `x`, not `+x`",
                    _ => "something is missing before it",
                };
                Err(ExpressionError::new(start, what, help))
            }
            Word::End => Err(self.unexpected("a number, a name or `(`")),
        }
    }

    /// A number or quantity, also with a sign before a number.
    fn constant(&mut self) -> Parsed<(Literal, Part)> {
        let token = self.take()?;
        let negative = token.word == Word::Sign('-');
        let number = if negative { self.take()? } else { token.clone() };
        let (literal, bare) = match number.word {
            Word::Number(value) => {
                (Literal { written: if negative { -value } else { value }, unit: Unit::dimensionless() }, true)
            }
            Word::Quantity(literal) if !negative => (literal, false),
            _ => {
                let help = "write a number or a quantity, such as `-0.2` or `[-0.2 bar]`";
                return Err(ExpressionError::new(token.start, "knots stand at constant places", help));
            }
        };
        let part = Part { dimension: literal.unit.dimension, start: token.start, end: self.end, bare };
        Ok((literal, part))
    }

    /// A call whose name was taken.
    fn call(&mut self, name: &str, start: usize) -> Parsed<Part> {
        if matches!(name, "table" | "curve") {
            return self.line(name == "curve", start);
        }
        if let Some(sheet) = self.sheets.iter().find(|sheet| sheet.name == name) {
            return self.sheet(&Arc::clone(sheet), start);
        }
        let Some(function) = Function::find(name) else {
            let known = self.names.iter().any(|known| known.name == name);
            return Err(if known {
                let what = format!("`{name}` is a quantity, not a function");
                ExpressionError::new(start, what, format!("products are written with `*`: `{name} * (...)`"))
            } else {
                let what = format!("unknown function `{name}`");
                let all = FUNCTIONS.iter().copied().chain(self.sheets.iter().map(|sheet| sheet.name.as_str()));
                ExpressionError::new(start, what, help_with_names(name, "functions", all))
            });
        };
        self.expect('(')?;
        let first = self.sum()?;
        let mut second = None;
        let mut given = 1;
        while self.at(',') {
            self.take()?;
            second = Some(self.sum()?);
            given += 1;
        }
        self.expect(')')?;
        let wanted = function.arguments();
        if given != wanted {
            let plural = if wanted == 1 { "" } else { "s" };
            let what = format!("`{name}` takes {wanted} argument{plural}, not {given}");
            let help = if wanted == 1 { format!("write `{name}(x)`") } else { format!("write `{name}(x, y)`") };
            return Err(ExpressionError::new(start, what, help));
        }
        let dimension = check::call(self.text, function, first, second)?;
        self.emit(Op::Call(function), wanted, start)?;
        Ok(Part { dimension, start, end: self.end, bare: false })
    }
}
