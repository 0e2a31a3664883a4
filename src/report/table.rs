//! Tables and texts as wide as a terminal.

/// Columns of a terminal of the usual width.
pub const WIDTH: usize = 80;
/// A head, and whether numbers stand under it, which are set to the right.
pub type Head = (&'static str, bool);

/// Characters of a label at the start of a line at most.
const LABEL: usize = 10;
/// Columns between two of a table, and before the first.
const GAP: usize = 2;

/// Rows under their heads, each column as wide as its widest entry; where the table would be wider than a terminal, heads and texts are
/// broken between words, the widest first. Numbers are not.
pub fn aligned(heads: &[Head], rows: &[Vec<String>]) -> Vec<String> {
    within(Some(WIDTH), heads, rows)
}

/// The same without heads; rows may end early. Blanks that are protected stay in one line.
#[cfg(feature = "cli")]
pub fn headless(rows: &[Vec<String>]) -> Vec<String> {
    headless_within(Some(WIDTH), rows)
}

/// The same for so many columns, or for any.
#[cfg(feature = "cli")]
pub fn headless_within(most: Option<usize>, rows: &[Vec<String>]) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let ended = |row: &Vec<String>| row.iter().cloned().chain(std::iter::repeat(String::new())).take(columns).collect();
    let rows: Vec<Vec<String>> = rows.iter().map(ended).collect();
    let lines = within(most, &vec![("", false); columns], &rows);
    lines.into_iter().skip(1).map(|line| line.replace('\u{a0}', " ")).collect()
}

/// The same for so many columns, or for any.
pub fn within(most: Option<usize>, heads: &[Head], rows: &[Vec<String>]) -> Vec<String> {
    let head: Vec<String> = heads.iter().map(|(name, _)| (*name).to_owned()).collect();
    let all: Vec<&Vec<String>> = std::iter::once(&head).chain(rows).collect();
    let widest = |column: usize, of: &dyn Fn(&str, bool) -> usize| {
        let cells = all.iter().enumerate().map(|(row, cells)| of(&cells[column], row > 0 && heads[column].1));
        cells.max().unwrap_or(0)
    };
    let whole = |text: &str, _: bool| text.chars().count();
    // What may not be broken: a number with its unit, else a word.
    let piece = |text: &str, number: bool| {
        let longest = || text.split(' ').map(|word| word.chars().count()).max().unwrap_or(0);
        if number { text.chars().count() } else { longest() }
    };
    let mut widths: Vec<usize> = (0..heads.len()).map(|column| widest(column, &whole)).collect();
    let least: Vec<usize> = (0..heads.len()).map(|column| widest(column, &piece)).collect();
    while most.is_some_and(|most| widths.iter().map(|width| width + GAP).sum::<usize>() > most) {
        let shrinks = (0..widths.len()).filter(|&column| widths[column] > least[column]);
        let Some(widest) = shrinks.max_by_key(|&column| widths[column]) else { break };
        widths[widest] -= 1;
    }
    let print = |(row, cells): (usize, &&Vec<String>)| {
        let broken: Vec<Vec<String>> = cells
            .iter()
            .zip(heads.iter().zip(&widths))
            .map(|(cell, ((_, number), &width))| {
                let fits = (row > 0 && *number) || cell.chars().count() <= width;
                if fits { vec![cell.clone()] } else { folded(cell, width) }
            })
            .collect();
        let lines = broken.iter().map(Vec::len).max().unwrap_or(0);
        let line = |index: usize| {
            let cells = broken.iter().zip(heads.iter().zip(&widths)).map(|(cell, ((_, number), &width))| {
                let part = cell.get(index).map_or("", String::as_str);
                if *number { format!("{part:>width$}") } else { format!("{part:<width$}") }
            });
            format!("  {}", cells.collect::<Vec<_>>().join("  ")).trim_end().to_owned()
        };
        (0..lines).map(line).collect::<Vec<_>>()
    };
    all.iter().enumerate().flat_map(print).collect()
}

/// A text in lines of at most [`WIDTH`] columns, broken at blanks that are not protected; those after the first begin with
/// `indent`.
pub fn wrapped(text: &str, indent: &str) -> Vec<String> {
    let lead = &text[..text.len() - text.trim_start().len()];
    let mut lines = vec![lead.to_owned()];
    let mut empty = true;
    for word in text.split([' ', '\n']).filter(|word| !word.is_empty()) {
        let used = lines.last().map_or(0, |line| line.chars().count());
        if !empty && used + 1 + word.chars().count() > WIDTH {
            lines.push(indent.to_owned());
            empty = true;
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(if empty { "" } else { " " });
            line.push_str(&word.replace('\u{a0}', " "));
        }
        empty = false;
    }
    lines
}

/// A text in lines of at most so many columns, as far as its words allow.
fn folded(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The first names, no more than so many, and how many others there are.
pub fn few(names: &[&str], most: usize) -> String {
    let shown = names[..names.len().min(most)].join(", ");
    if names.len() > most { format!("{shown} and {} more", names.len() - most) } else { shown }
}

/// A text whose lines are as wide as a terminal at most. What stands behind a label, or behind the columns of a table, stays under
/// itself; a command to be copied is left as it is.
pub fn fitted(text: &str) -> String {
    let fit = |line: &str| -> Vec<String> {
        let is_command = line.starts_with("Next: ") || line.trim_start().starts_with("borescope ");
        if line.chars().count() <= WIDTH || is_command {
            return vec![line.to_owned()];
        }
        let behind = |at: usize| at + line[at..].len() - line[at..].trim_start().len();
        let start = match line.find("  ") {
            // A word and what it stands for, which may hold blanks of its own.
            Some(at) if (1..=LABEL).contains(&at) => behind(at),
            // What such a word stands for goes on.
            Some(0) if behind(0) >= LABEL => behind(0),
            _ => line.rfind("  ").map_or(0, behind),
        };
        let (label, rest) = line.split_at(start);
        let room = label.chars().count();
        if room > WIDTH / 2 || rest.is_empty() {
            return vec![line.to_owned()];
        }
        let indent = " ".repeat(if label.trim().is_empty() { room + 2 } else { room });
        // Blanks within the label are its own.
        let kept = format!("{}{rest}", "\u{1}".repeat(room));
        let mut lines = wrapped(&kept, &indent);
        lines[0] = lines[0].replacen(&"\u{1}".repeat(room), label, 1);
        lines
    };
    let mut out: String = text.lines().flat_map(fit).map(|line| line + "\n").collect();
    if !text.ends_with('\n') {
        out.pop();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_no_wider_than_a_terminal_where_words_allow() {
        let heads: [Head; 4] = [("sensor", false), ("reduced chi-square", true), ("unit", false), ("meaning", false)];
        let row =
            |name: &str| vec![name.to_owned(), "12.5 %".to_owned(), "bar".to_owned(), "a long meaning ".repeat(8)];
        let lines = aligned(&heads, &[row("p_A"), row("p_B")]);
        assert!(lines.iter().all(|line| line.chars().count() <= WIDTH), "{lines:#?}");
        assert_eq!(lines.iter().filter(|line| line.contains("12.5 %")).count(), 2);
        assert!(within(None, &heads, &[row("p_A")]).len() == 2);
        // One that fits is as it was.
        assert_eq!(aligned(&[("a", false), ("b", true)], &[vec!["x".into(), "1".into()]]), ["  a  b", "  x  1"]);
    }

    #[test]
    fn a_line_is_broken_under_its_own_beginning() {
        let long = "word ".repeat(30);
        let text = fitted(&format!("law       {long}\n  {long}\nNext: borescope {long}"));
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("law       word") && lines[1].starts_with("          word"), "{text}");
        assert!(
            lines.iter().filter(|line| !line.starts_with("Next")).all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
        assert!(lines.last().unwrap().starts_with("Next: borescope word"), "{text}");
    }
}
