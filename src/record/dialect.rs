//! What was recognised of a text file: its separator, its decimal mark, where the units stand.

use std::fmt;

use crate::complaint::{Complaint, Kind};

/// Where the units of a header stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UnitsIn {
    /// `p_A [bar]`.
    SquareBrackets,
    /// `p_A (bar)`, where no column has square ones.
    RoundBrackets,
    /// `p_A_bar`, where the first column is a time so written, such as `t_s`.
    Names,
}

/// How a table is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialect {
    pub separator: u8,
    /// Whether the numbers have decimal commas.
    pub commas: bool,
    /// The line of the units, where they do not stand behind the names.
    pub unit_row: Option<usize>,
    pub units: UnitsIn,
    /// Rows above the names of the columns that were passed over.
    pub above: usize,
    /// What the times are counted from, where that is not 0 s.
    pub begins_at: Option<String>,
}

impl Dialect {
    /// All but the separator and the decimal mark.
    pub(super) fn behind_separators(&self) -> String {
        let units = match self.unit_row {
            Some(line) => format!(", units in line {line}"),
            None => match self.units {
                UnitsIn::SquareBrackets => String::new(),
                UnitsIn::RoundBrackets => ", units in round brackets".to_owned(),
                UnitsIn::Names => ", units behind the last `_` of the names".to_owned(),
            },
        };
        let above = match self.above {
            0 => String::new(),
            1 => ", the line above the names passed over".to_owned(),
            lines => format!(", {lines} lines above the names passed over"),
        };
        units + &above + &counted_from(self.begins_at.as_deref())
    }
}

/// Says that times are counted from the first row.
pub(super) fn counted_from(begins_at: Option<&str>) -> String {
    begins_at.map_or(String::new(), |start| format!(", times counted from the first row, at {start}"))
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let separator = match self.separator {
            b';' => "semicolons",
            b'\t' => "tabs",
            _ => "commas",
        };
        let mark = if self.commas { "commas" } else { "points" };
        write!(f, "columns between {separator}, decimal {mark}{}", self.behind_separators())
    }
}

/// The separator that a line states, as Excel writes it: `sep=;`.
pub(super) fn stated_separator(line: &str) -> Option<u8> {
    let (word, sign) = line.split_at_checked(4)?;
    let sign = sign.bytes().next().filter(|sign| matches!(sign, b';' | b',' | b'\t'));
    sign.filter(|_| word.eq_ignore_ascii_case("sep="))
}

/// The sign between columns: the one that the header has most of outside quotes and brackets.
///
/// # Errors
/// Two signs of which the header has as many.
pub(super) fn separator(header: &str) -> Result<u8, Complaint> {
    let mut counts = [(b',', 0_usize), (b';', 0), (b'\t', 0)];
    let (mut quoted, mut bracketed) = (false, false);
    for byte in header.bytes() {
        match byte {
            b'"' => quoted = !quoted,
            b'\n' | b'\r' if !quoted => break,
            b'[' => bracketed = true,
            b']' => bracketed = false,
            _ if quoted || bracketed => {}
            _ => {
                for (sign, count) in &mut counts {
                    *count += usize::from(*sign == byte);
                }
            }
        }
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let [(first, most), (second, next), _] = counts;
    if most > 0 && most == next {
        let name = |sign: u8| if sign == b'\t' { "tab".to_owned() } else { format!("`{}`", char::from(sign)) };
        let what = format!("the columns may be separated by {} or by {}", name(first), name(second));
        return Err(
            Complaint::new(Kind::Contradiction, what).help("write names that hold a separator in quotation marks")
        );
    }
    Ok(if most == 0 { b',' } else { first })
}

/// Whether the comma of a number can only be a decimal mark: behind a separator of thousands stand three digits, before it
/// one to three that do not begin with zero.
pub(super) fn proves_decimal_comma(field: &str) -> bool {
    let unsigned = field.trim_start_matches(['+', '-']);
    let Some((before, after)) = unsigned.split_once(',') else { return false };
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    after.len() != 3 || !digits(after) || before.is_empty() || before.len() > 3 || before.starts_with('0')
}

/// Whether a text looks like a number with separators of thousands: `1,234.5`, `1.234.567`, `1'234`.
pub(super) fn has_thousands(field: &str) -> bool {
    let unsigned = field.trim_start_matches(['+', '-']);
    let marks = unsigned.bytes().filter(|byte| !byte.is_ascii_digit()).count();
    let allowed = unsigned.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b',' | b'.' | b'\'' | b' '));
    let groups: Vec<&str> = unsigned.split([',', '.', '\'', ' ']).collect();
    allowed
        && (marks >= 2 || unsigned.contains(['\'', ' ']))
        && groups.first().is_some_and(|first| (1..=3).contains(&first.len()))
        && groups[1..groups.len() - 1].iter().all(|group| group.len() == 3)
}
