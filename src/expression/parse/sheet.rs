//! Calls of tables that were read from files.

use std::sync::Arc;

use super::{Parsed, Reader};
use crate::expression::check::{self, Part};
use crate::expression::program::Op;
use crate::expression::{ExpressionError, Sheet};

impl Reader<'_> {
    /// `lever.ratio(x)` or `map.loss(speed, drop)`, whose name was taken.
    pub(super) fn sheet(&mut self, sheet: &Arc<Sheet>, start: usize) -> Parsed<Part> {
        self.expect('(')?;
        let mut given = 0;
        loop {
            let argument = self.sum()?;
            if let Some(&wanted) = sheet.arguments.get(given) {
                check::argument(self.text, &sheet.name, wanted, argument)?;
            }
            given += 1;
            if !self.at(',') {
                break;
            }
            self.take()?;
        }
        self.expect(')')?;
        let (name, wanted) = (&sheet.name, sheet.arguments.len());
        if given != wanted {
            let (what, help) = match wanted {
                1 => (format!("the table `{name}` takes 1 argument, not {given}"), format!("write `{name}(x)`")),
                _ => (format!("the table `{name}` takes 2 arguments, not {given}"), format!("write `{name}(x, y)`")),
            };
            return Err(ExpressionError::new(start, what, help));
        }
        let sheets = &mut self.program.sheets;
        let index = sheets.iter().position(|known| known.name == sheet.name).unwrap_or_else(|| {
            sheets.push(Arc::clone(sheet));
            sheets.len() - 1
        });
        self.emit(Op::Sheet(index), wanted, start)?;
        Ok(Part { dimension: sheet.gives, start, end: self.end, bare: false })
    }
}
