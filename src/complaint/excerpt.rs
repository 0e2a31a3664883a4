//! The line of a file that a complaint is about, with carets under the place.

use std::fmt::Write;
use std::ops::Range;

use unicode_width::UnicodeWidthStr;

use crate::visible::visible;

/// Most characters that are shown of a line, and of what is wrong in it.
const MOST: usize = 100;
const MOST_MARKED: usize = 60;
/// Stands for what is cut off.
const CUT: &str = "...";

/// A part of a line as people may see it: short, and with hidden characters escaped.
#[derive(Debug, Clone)]
pub(super) struct Excerpt {
    before: String,
    marked: String,
    behind: String,
}

impl Excerpt {
    /// The bytes `range` of a line; of those behind its end none is marked.
    pub(super) fn new(line: &str, range: Range<usize>) -> Self {
        let line = line.trim_end_matches(['\n', '\r']);
        let (start, end) = (boundary(line, range.start), boundary(line, range.end.max(range.start)));
        let (before, rest) = line.split_at(start);
        let (marked, behind) = rest.split_at(end - start);
        // What one side does not need is left to the other.
        let room = MOST - count(marked, MOST_MARKED);
        let ahead = count(before, room - count(behind, room / 2));
        Self { before: last(before, ahead), marked: first(marked, MOST_MARKED), behind: first(behind, room - ahead) }
    }

    /// The line behind its number, and the carets below; at least one.
    pub(super) fn write(&self, number: usize, width: usize, out: &mut String) {
        let Self { before, marked, behind } = self;
        // Writing to a string does not fail.
        let _ = write!(out, "\n  {number:width$} | {before}{marked}{behind}");
        let _ = write!(out, "\n  {:width$} | {:indent$}", "", "", indent = before.width());
        out.push_str(&"^".repeat(marked.width().max(1)));
    }
}

/// The last place between two characters that is not behind `byte`.
fn boundary(line: &str, byte: usize) -> usize {
    let byte = byte.min(line.len());
    (0..=byte).rev().find(|&byte| line.is_char_boundary(byte)).unwrap_or(0)
}

/// Characters of a text, and no more than this.
fn count(text: &str, most: usize) -> usize {
    text.chars().take(most).count()
}

fn first(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((at, _)) => shown(&text[..at]) + CUT,
        None => shown(text),
    }
}

fn last(text: &str, most: usize) -> String {
    let from = most.checked_sub(1).map_or(text.len(), |nth| text.char_indices().rev().nth(nth).map_or(0, |(at, _)| at));
    let cut = if from > 0 { CUT } else { "" };
    cut.to_owned() + &shown(&text[from..])
}

/// Tabs would put the carets elsewhere.
fn shown(text: &str) -> String {
    visible(&text.replace('\t', " ")).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(line: &str, range: Range<usize>) -> String {
        let mut out = String::new();
        Excerpt::new(line, range).write(7, 1, &mut out);
        out
    }

    #[test]
    fn carets_stand_under_the_place() {
        assert_eq!(drawn("a = \"b\"\r\n", 4..7), "\n  7 | a = \"b\"\n    |     ^^^");
        assert_eq!(drawn("\ta = 1", 1..2), "\n  7 |  a = 1\n    |  ^");
        // Characters that take two columns, one of two bytes in one, one that is escaped.
        assert_eq!(drawn("压力,\u{b5}m,x", 11..12), "\n  7 | 压力,\u{b5}m,x\n    |         ^");
        assert_eq!(drawn("\u{1b}[2J,x", 5..6), "\n  7 | \\u001b[2J,x\n    |           ^");
    }

    #[test]
    fn what_is_nothing_or_beyond_the_line_has_one_caret() {
        assert_eq!(drawn("0,,1", 2..2), "\n  7 | 0,,1\n    |   ^");
        assert_eq!(drawn("0,", 5..9), "\n  7 | 0,\n    |   ^");
        // The second byte of a character.
        assert_eq!(drawn("\u{b5}", 1..2), "\n  7 | \u{b5}\n    | ^");
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let line = format!("{}{}{}", "a".repeat(100), "b".repeat(100), "c".repeat(100));
        let (a, b, c) = ("a".repeat(20), "b".repeat(60), "c".repeat(20));
        let carets = format!("{}{}", " ".repeat(23), "^".repeat(63));
        assert_eq!(drawn(&line, 100..200), format!("\n  7 | ...{a}{b}...{c}...\n    | {carets}"));
        // At the beginning all of the room is behind the place, at the end all before it.
        assert_eq!(drawn(&line, 0..1), format!("\n  7 | {}...\n    | ^", &line[..100]));
        assert_eq!(drawn(&line, 299..300), format!("\n  7 | ...{}\n    | {}^", &line[200..], " ".repeat(102)));
    }
}
