//! What the short answers of all verbs share: lines of a terminal, and errors beside each other.

use super::learn::multiple;
use super::table::{Head, aligned};
pub use super::table::{WIDTH, wrapped};

/// Characters of the longest bar of a fall of the error.
const BAR: usize = 24;

/// A model with its errors, times the sensor noise.
pub struct ErrorRow {
    /// What the model is called.
    pub name: String,
    /// On the record that is fitted.
    pub fit: f64,
    /// On the check record, where there is one.
    pub check: Option<f64>,
}

/// Errors model by model, with a bar each; the last record decides how long it is.
pub fn errors(rows: &[ErrorRow]) -> Vec<String> {
    let checked = rows.iter().any(|row| row.check.is_some());
    let last = |row: &ErrorRow| row.check.unwrap_or(row.fit);
    let most = rows.iter().map(last).fold(1.0, f64::max);
    let mut heads: Vec<Head> = vec![("error, times the sensor noise", false)];
    heads.push(("fit", true));
    if checked {
        heads.push(("check", true));
    }
    heads.push(("", false));
    // Bars as long as the longest name leaves room for.
    let name = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max(heads[0].0.len());
    let bar = WIDTH.saturating_sub(name + 22).clamp(1, BAR) as f64;
    let cells = rows.iter().map(|row| {
        let mut cells = vec![row.name.clone(), multiple(row.fit)];
        if checked {
            cells.push(row.check.map_or_else(|| "-".to_owned(), multiple));
        }
        cells.push("#".repeat(((last(row) / most * bar).round() as usize).max(1)));
        cells
    });
    aligned(&heads, &cells.collect::<Vec<_>>())
}

/// The first names, no more than so many, and how many others there are.
pub fn few(names: &[&str], most: usize) -> String {
    let shown = names[..names.len().min(most)].join(", ");
    if names.len() > most { format!("{shown} and {} more", names.len() - most) } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_between_words_and_keep_their_indent() {
        let text = format!("  {}", "abcd ".repeat(40));
        let lines = wrapped(&text, "    ");
        assert!(lines.iter().all(|line| line.chars().count() <= WIDTH), "{lines:?}");
        assert!(
            lines[0].starts_with("  abcd") && lines[1..].iter().all(|line| line.starts_with("    abcd")),
            "{lines:?}"
        );
        assert_eq!(lines.iter().flat_map(|line| line.split_whitespace()).count(), 40);
        // A word that is wider than the terminal is not torn.
        assert_eq!(wrapped(&"x".repeat(100), ""), ["x".repeat(100)]);
        assert_eq!(wrapped(&format!("{} 5\u{a0}%", "x".repeat(77)), "")[1], "5 %");
    }
}
