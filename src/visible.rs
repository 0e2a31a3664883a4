//! Text of strangers (names, cells, paths) as people may see it: nothing in it moves a cursor, hides a line or turns the reading
//! direction around.

use std::borrow::Cow;
use std::io::{self, Write};

/// Most characters of a name: tables and messages show names whole.
pub const LONGEST_NAME: usize = 200;

/// Whether a terminal or a browser acts on a character instead of showing it: control characters, and those that set the
/// direction of writing or take no room.
pub fn is_hidden(letter: char) -> bool {
    letter.is_control()
        || matches!(letter, '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}' | '\u{FEFF}')
}

/// The text with each hidden character as its escape, such as `\u001b`: the spelling of JSON, so that a JSON text keeps its
/// meaning.
pub fn visible(text: &str) -> Cow<'_, str> {
    shown(text, |_| false)
}

/// The same for a text of several lines, whose line breaks and tabs stay.
pub fn visible_lines(text: &str) -> Cow<'_, str> {
    shown(text, |letter| matches!(letter, '\n' | '\t'))
}

fn shown(text: &str, stays: impl Fn(char) -> bool) -> Cow<'_, str> {
    let escaped = |letter: char| is_hidden(letter) && !stays(letter);
    if !text.chars().any(escaped) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\n' if escaped(letter) => out.push_str("\\n"),
            '\t' if escaped(letter) => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            letter if escaped(letter) => out.push_str(&format!("\\u{:04x}", u32::from(letter))),
            letter => out.push(letter),
        }
    }
    Cow::Owned(out)
}

/// Why a text is no name; `None` where it is one.
pub fn unusable_name(name: &str) -> Option<String> {
    if name.chars().any(is_hidden) {
        return Some("holds a character that is not shown, such as a line break or an escape".to_owned());
    }
    let count = name.chars().count();
    (count > LONGEST_NAME).then(|| format!("has {count} characters, more than {LONGEST_NAME}"))
}

/// Writes text with hidden characters as their escapes; line breaks and tabs stay, and so do the colours of this program where
/// `colours` is set.
pub struct Visible<W: Write> {
    to: W,
    colours: bool,
    /// The begin of a character whose other bytes are still to come.
    begun: Vec<u8>,
}

impl<W: Write> Visible<W> {
    pub fn new(to: W, colours: bool) -> Self {
        Self { to, colours, begun: Vec::new() }
    }

    fn text(&mut self, text: &str) -> io::Result<()> {
        if !self.colours {
            return self.to.write_all(visible_lines(text).as_bytes());
        }
        let mut rest = text;
        while let Some(at) = rest.find('\x1b') {
            let (before, from) = rest.split_at(at);
            self.to.write_all(visible_lines(before).as_bytes())?;
            let length = colour(from);
            self.to.write_all(from.get(..length).unwrap_or_default().as_bytes())?;
            rest = from.get(length..).unwrap_or_default();
            if length == 0 {
                self.to.write_all(b"\\u001b")?;
                rest = from.get(1..).unwrap_or_default();
            }
        }
        self.to.write_all(visible_lines(rest).as_bytes())
    }
}

/// Bytes of the sequence that sets a colour of this program, with which the text begins; 0 where it begins with another.
fn colour(text: &str) -> usize {
    const OWN: [&str; 4] = ["\x1b[1;31m", "\x1b[1;32m", "\x1b[1;33m", "\x1b[0m"];
    OWN.iter().find(|own| text.starts_with(**own)).map_or(0, |own| own.len())
}

impl<W: Write> Write for Visible<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut all = std::mem::take(&mut self.begun);
        all.extend_from_slice(bytes);
        for chunk in all.utf8_chunks() {
            self.text(chunk.valid())?;
            let broken = chunk.invalid();
            // Bytes at the end may be the begin of a character; others are none, and are passed on.
            let at_end = broken.len() < 4 && all.ends_with(broken);
            match at_end {
                true => self.begun = broken.to_vec(),
                false => self.to.write_all(broken)?,
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let begun = std::mem::take(&mut self.begun);
        self.to.write_all(&begun)?;
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_hidden_is_shown_as_its_escape() {
        assert_eq!(visible("p_A \u{b5}m"), "p_A \u{b5}m");
        assert_eq!(visible("a\x1b[2Jb\u{9b}c\r\n\0"), "a\\u001b[2Jb\\u009bc\\r\\n\\u0000");
        assert_eq!(visible("\u{202e}cba"), "\\u202ecba");
        assert_eq!(visible_lines("a\n\tb\r"), "a\n\tb\\r");
    }

    #[test]
    fn a_writer_keeps_text_lines_and_own_colours() {
        let written = |colours, pieces: &[&[u8]]| {
            let mut bytes = Vec::new();
            let mut to = Visible::new(&mut bytes, colours);
            pieces.iter().for_each(|piece| to.write_all(piece).unwrap());
            to.flush().unwrap();
            String::from_utf8(bytes).unwrap()
        };
        assert_eq!(written(true, &[b"\x1b[1;32mok\x1b[0m\n\x1b[2J"]), "\x1b[1;32mok\x1b[0m\n\\u001b[2J");
        assert_eq!(written(false, &[b"\x1b[1;32mok"]), "\\u001b[1;32mok");
        // A character that comes in two pieces.
        assert_eq!(written(false, &[b"\xC3", b"\xA9\xE2\x80", b"\xAE!"]), "\u{e9}\\u202e!");
    }

    #[test]
    fn names_are_short_and_of_visible_characters() {
        assert_eq!(unusable_name("Druck p_A (\u{b0}C)"), None);
        assert!(unusable_name("a\nHEALTHY: nothing").is_some_and(|why| why.contains("line break")));
        assert!(unusable_name(&"x".repeat(LONGEST_NAME + 1)).is_some_and(|why| why.contains("201 characters")));
    }
}
