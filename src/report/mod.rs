//! What a reader gets to see: texts, line charts, self-contained pages, and the part of the reference that the cards give.

#[cfg(feature = "cli")]
pub mod addition;
#[cfg(feature = "cli")]
pub mod brief;
#[cfg(feature = "cli")]
pub mod calibration;
#[cfg(feature = "cli")]
pub mod campaign;
pub(crate) mod caveats;
#[cfg(feature = "cli")]
pub mod check;
#[cfg(feature = "cli")]
pub mod circuit;
#[cfg(feature = "cli")]
pub mod comparison;
#[cfg(feature = "cli")]
pub mod components;
#[cfg(feature = "cli")]
pub mod curves;
pub mod diagnosis;
mod diagnosis_tables;
pub mod digits;
#[cfg(feature = "cli")]
pub mod effects;
#[cfg(feature = "cli")]
pub mod findings;
#[cfg(feature = "cli")]
pub mod fleet;
pub mod headline;
#[cfg(feature = "cli")]
pub mod history;
#[cfg(feature = "cli")]
pub mod html;
#[cfg(feature = "cli")]
pub mod improvement;
#[cfg(feature = "cli")]
pub mod isolability;
pub mod learn;
#[cfg(feature = "cli")]
pub mod ledger;
#[cfg(feature = "cli")]
pub mod pages;
#[cfg(feature = "cli")]
pub mod plot;
#[cfg(feature = "cli")]
pub mod provenance;
#[cfg(all(feature = "cli", feature = "internals"))]
pub mod reference;
mod residuals;
#[cfg(all(feature = "cli", feature = "internals"))]
mod settings;
#[cfg(feature = "cli")]
pub mod simulation;
pub mod style;
#[cfg(feature = "cli")]
pub mod suggestion;
pub mod table;
#[cfg(feature = "cli")]
pub mod unknown;
#[cfg(feature = "cli")]
pub mod windows;

#[cfg(feature = "cli")]
use crate::visible::is_hidden;

/// A text as the content of an XML or HTML element or of a quoted attribute: markup escaped, and the control characters
/// that XML forbids, and those that turn the reading direction, replaced by U+FFFD.
#[cfg(feature = "cli")]
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
