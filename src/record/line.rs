//! A line of a table as the file has it, so that a complaint can point at a field of it.

use std::ops::Range;
use std::path::Path;

use crate::complaint::Place;

/// A row with what stands around its fields.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    /// Counted from 1.
    pub number: usize,
    /// From where the row begins; what follows behind its end does not matter.
    pub text: &'a str,
    pub separator: u8,
}

impl Line<'_> {
    /// The whole line.
    pub(super) fn place(&self, path: &Path) -> Place {
        let text = self.first_line();
        Place::line(path, self.number).showing(text, 0..text.len())
    }

    /// A field of it.
    pub(super) fn field(&self, path: &Path, index: usize) -> Place {
        let text = self.first_line();
        Place::line(path, self.number).showing(text, range(text, self.separator, index))
    }

    /// A name in quotation marks may go on in the next line.
    fn first_line(&self) -> &str {
        self.text.split(['\n', '\r']).next().unwrap_or_default()
    }
}

/// Where a field stands, without the blanks around it.
fn range(text: &str, separator: u8, index: usize) -> Range<usize> {
    let mut quoted = false;
    let is_separator = |(at, byte): (usize, u8)| {
        quoted ^= byte == b'"';
        (byte == separator && !quoted).then_some(at)
    };
    let mut ends = text.bytes().enumerate().filter_map(is_separator);
    let start = match index.checked_sub(1) {
        None => 0,
        Some(before) => ends.nth(before).map_or(text.len(), |at| at + 1),
    };
    let end = ends.next().unwrap_or(text.len()).max(start);
    let field = &text[start..end];
    let from = start + (field.len() - field.trim_start().len());
    from..from + field.trim().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_between_separators_outside_quotes() {
        let field = |text: &'static str, index| &text[range(text, b',', index)];
        assert_eq!(["0", "x y", ""].map(String::from), [0, 1, 2].map(|index| field("0, x y ,", index).to_owned()));
        assert_eq!(field("\"p,q\",\"1,5\",7", 1), "\"1,5\"");
        assert_eq!(field("0,1", 5), "");
    }
}
