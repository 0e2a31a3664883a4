//! What the short answers of all verbs share: lines of a terminal, and errors beside each other.

use super::learn::multiple;
use super::table::{Head, aligned};
pub use super::table::{WIDTH, few, wrapped};

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

/// The command that leads further, as the last line of an answer. Longer than a terminal is wide, it goes on in the next line as shells of
/// Unix have it; those of Windows take one line alone.
pub fn next_line(command: &str) -> String {
    let whole = format!("Next: {command}");
    if cfg!(windows) || whole.chars().count() <= WIDTH {
        return whole;
    }
    let mut lines = vec!["Next:".to_owned()];
    for part in parts(command) {
        let last = lines.last_mut().expect("one at least");
        // Room for what says that the line goes on.
        if last.chars().count() + 1 + part.chars().count() + 2 <= WIDTH || last.trim_end() == "Next:" {
            *last = format!("{last} {part}");
        } else {
            last.push_str(" \\");
            lines.push(format!("{:6}{part}", ""));
        }
    }
    lines.join("\n")
}

/// Words of a command that stay together: a file whose name has blanks in quotes, an option with its value.
fn parts(command: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let (mut is_quoted, mut joins) = (false, false);
    for word in command.split(' ') {
        let is_option = !is_quoted && word.starts_with('-');
        match parts.last_mut() {
            Some(last) if is_quoted || (joins && !is_option) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => parts.push(word.to_owned()),
        }
        // `\'` is a quote of the name itself.
        is_quoted ^= (word.matches('\'').count() - word.matches("\\'").count()) % 2 == 1;
        joins = is_option;
    }
    parts
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

    #[test]
    #[cfg(not(windows))]
    fn a_long_command_goes_on_in_the_next_line_between_its_arguments() {
        assert_eq!(next_line("borescope check rig.toml"), "Next: borescope check rig.toml");
        let long = "a".repeat(50);
        let told = next_line(&format!("borescope suggest 'my rig'\\''s {long}' --check {long} -o b.toml"));
        let lines = [
            "Next: borescope suggest \\".to_owned(),
            format!("      'my rig'\\''s {long}' \\"),
            format!("      --check {long} -o b.toml"),
        ];
        assert_eq!(told, lines.join("\n"));
    }
}
