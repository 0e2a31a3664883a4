//! `table` and `curve`.

use super::{Parsed, Reader};
use crate::expression::check::{self, Part};
use crate::expression::program::{Line, Op};
use crate::expression::{ExpressionError, MAX_KNOTS};
use crate::units::Dimension;

impl Reader<'_> {
    /// `table(...)` or `curve(...)`, whose name was taken.
    pub(super) fn line(&mut self, smooth: bool, start: usize) -> Parsed<Part> {
        self.expect('(')?;
        let argument = self.sum()?;
        self.expect(';')?;
        let mut line = Line { smooth, knots: Vec::new(), at: Vec::new() };
        let mut first = None;
        loop {
            let (literal, knot) = self.constant()?;
            check::knot(self.text, argument, knot)?;
            let place = literal.si();
            if line.at.last().is_some_and(|before| *before >= place) {
                let what =
                    format!("the knot `{}` does not lie behind the one before", &self.text[knot.start..knot.end]);
                return Err(ExpressionError::new(knot.start, what, "write the knots in growing order"));
            }
            if line.at.len() == MAX_KNOTS {
                let what = format!("more than {MAX_KNOTS} knots");
                return Err(ExpressionError::new(
                    knot.start,
                    what,
                    "leave out knots where the line is nearly straight",
                ));
            }
            line.knots.push(literal);
            line.at.push(place);
            self.expect(':')?;
            let height = self.sum()?;
            check::height(self.text, *first.get_or_insert(height), height)?;
            if !self.at(',') {
                break;
            }
            self.take()?;
        }
        self.expect(')')?;
        let count = line.at.len();
        if count < 2 {
            let help = "write at least two: `table(x; 0: a, 1: b)`";
            return Err(ExpressionError::new(start, "a line through a single knot", help));
        }
        self.program.lines.push(line);
        self.emit(Op::Line(self.program.lines.len() - 1), count + 1, start)?;
        let dimension = first.map_or(Dimension::NONE, |height| height.dimension);
        Ok(Part { dimension, start, end: self.end, bare: false })
    }
}
