//! What a reader gets to see: texts, line charts, self-contained pages, and the part of the reference that the cards give.

pub mod addition;
pub mod campaign;
pub(crate) mod caveats;
pub mod check;
pub mod circuit;
pub mod comparison;
pub mod curves;
pub mod diagnosis;
pub mod digits;
pub mod effects;
#[cfg(feature = "store")]
pub mod history;
pub mod html;
pub mod improvement;
pub mod isolability;
pub mod learn;
pub mod pages;
pub mod plot;
pub mod reference;
mod residuals;
pub mod simulation;
pub mod style;
pub mod table;
pub mod windows;

use crate::visible::is_hidden;

/// A text as the content of an XML or HTML element or of a quoted attribute: markup escaped, and the control characters
/// that XML forbids, and those that turn the reading direction, replaced by U+FFFD.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\t' | '\n' | '\r' => escaped.push(character),
            '\0'..='\u{1f}' | '\u{7f}' | '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            character if is_hidden(character) => escaped.push('\u{fffd}'),
            _ => escaped.push(character),
        }
    }
    escaped
}
