//! A formula back as text.

use super::program::{Function, Op};
use super::{Expression, Literal};
use std::fmt;

/// How tightly a piece of text holds together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Bond {
    Sum,
    Product,
    Negative,
    Power,
    Whole,
}

struct Piece {
    text: String,
    bond: Bond,
}

impl Piece {
    fn whole(text: String) -> Self {
        Self { text, bond: Bond::Whole }
    }

    /// The text, in brackets unless it holds together at least as `bond`.
    fn within(self, bond: Bond) -> String {
        if self.bond >= bond { self.text } else { format!("({})", self.text) }
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let program = &self.program;
        let mut literals = program.literals.iter();
        let mut pieces: Vec<Piece> = Vec::new();
        // A program that was read never takes more pieces than there are.
        let take = |pieces: &mut Vec<Piece>| pieces.pop().unwrap_or_else(|| Piece::whole(String::new()));
        for op in program.ops() {
            let piece = match *op {
                Op::Constant(_) => Piece::whole(literals.next().map_or_else(String::new, Literal::to_string)),
                Op::Value(index) => Piece::whole(self.names[index].name.clone()),
                Op::Negate => {
                    let text = format!("-{}", take(&mut pieces).within(Bond::Negative));
                    Piece { text, bond: Bond::Negative }
                }
                Op::Power(exponent) => {
                    let text = format!("{}^{exponent}", take(&mut pieces).within(Bond::Whole));
                    Piece { text, bond: Bond::Power }
                }
                Op::Add | Op::Subtract | Op::Multiply | Op::Divide => {
                    let (sign, bond, tighter) = match op {
                        Op::Add => ('+', Bond::Sum, Bond::Product),
                        Op::Subtract => ('-', Bond::Sum, Bond::Product),
                        Op::Multiply => ('*', Bond::Product, Bond::Negative),
                        _ => ('/', Bond::Product, Bond::Negative),
                    };
                    let right = take(&mut pieces).within(tighter);
                    let left = take(&mut pieces).within(bond);
                    Piece { text: format!("{left} {sign} {right}"), bond }
                }
                Op::Call(function @ (Function::Min | Function::Max | Function::Root)) => {
                    let (right, left) = (take(&mut pieces), take(&mut pieces));
                    Piece::whole(format!("{}({}, {})", function.name(), left.text, right.text))
                }
                Op::Call(function) => Piece::whole(format!("{}({})", function.name(), take(&mut pieces).text)),
                Op::Sheet(index) => {
                    let sheet = &program.sheets[index];
                    let arguments = pieces.split_off(pieces.len().saturating_sub(sheet.arguments.len()));
                    let arguments: Vec<String> = arguments.into_iter().map(|piece| piece.text).collect();
                    Piece::whole(format!("{}({})", sheet.name, arguments.join(", ")))
                }
                Op::Line(index) => {
                    let line = &program.lines[index];
                    let heights = pieces.split_off(pieces.len().saturating_sub(line.knots.len()));
                    let knots: Vec<String> = line
                        .knots
                        .iter()
                        .zip(heights)
                        .map(|(knot, height)| format!("{}: {}", knot.signed(), height.text))
                        .collect();
                    let name = if line.smooth { "curve" } else { "table" };
                    Piece::whole(format!("{name}({}; {})", take(&mut pieces).text, knots.join(", ")))
                }
            };
            pieces.push(piece);
        }
        f.pad(&take(&mut pieces).text)
    }
}

impl Literal {
    /// As a knot, where a sign needs no brackets.
    fn signed(&self) -> String {
        if self.unit.symbol == "-" { self.number() } else { self.to_string() }
    }

    /// Never longer than what was read, so that what fits into the limits still does.
    fn number(&self) -> String {
        let (plain, scientific) = (format!("{}", self.written), format!("{:e}", self.written));
        if plain.len() <= scientific.len() { plain } else { scientific }
    }
}

/// Writes the number alone where that reads as the same constant, otherwise in brackets with its unit.
impl fmt::Display for Literal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.unit.symbol.as_str() {
            "-" if self.written.is_sign_positive() => f.write_str(&self.number()),
            "-" => write!(f, "[{}]", self.number()),
            symbol => write!(f, "[{} {symbol}]", self.number()),
        }
    }
}
