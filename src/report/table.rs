//! Tables as text.

/// A head, and whether numbers stand under it, which are set to the right.
pub type Head = (&'static str, bool);

/// Rows under their heads, each column as wide as its widest entry.
pub fn aligned(heads: &[Head], rows: &[Vec<String>]) -> Vec<String> {
    let head: Vec<String> = heads.iter().map(|(name, _)| (*name).to_owned()).collect();
    let all: Vec<&Vec<String>> = std::iter::once(&head).chain(rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..heads.len()).map(width).collect();
    let print = |row: &&Vec<String>| {
        let cells = row.iter().zip(heads.iter().zip(&widths)).map(|(cell, ((_, numeric), &width))| {
            if *numeric { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        });
        format!("  {}", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    all.iter().map(print).collect()
}
